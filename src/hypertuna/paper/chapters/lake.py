"""The swim in open water of section III.G: the mission `lake`, as it was flown and stored, beside 800 m and 9.1 Wh."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.description.robot import load
from hypertuna.io.files import shipped
from hypertuna.mission.file import read_mission
from hypertuna.mission.flight import Flight, fly, outcome
from hypertuna.mission.record import MissionRecord
from hypertuna.paper.ledger import Finding, published
from hypertuna.reports.html import WIDTH, Picture, Section

__all__ = ["LAKE", "STORED", "Lake", "findings", "fly_lake", "lake_record", "read_lake", "sections"]

LAKE = "twin at sea"  # the model in the ledger
MISSION = "lake"
STORED = "missions/lake.json"  # below data
AGAIN = "validation/missions/lake.py flies it anew"
HOUR = 3600.0
DRAWN = ("position", "attitude", "position_estimated", "depth_estimated", "mode", "energy", "charge_left")
EVERY = 5.0  # s between the rows that a picture is drawn from


@dataclass(frozen=True)
class Lake:
    """The mission as it was flown.

    Attributes
    ----------
    record : mapping or None
        What `lake_record` returns; None where there is none that holds.
    why : str
        Why there is none: a sentence without its stop.
    """

    record: Mapping[str, Any] | None
    why: str = ""


def read_lake() -> Lake:
    """Read the stored flight.

    Returns
    -------
    Lake
        Without a record if the robot or the mission has changed since.
    """
    folder = shipped("data")
    try:
        record = json.loads((folder / STORED).read_text(encoding="utf-8"))
        robot, mission = load(record["robot"]), read_mission(MISSION)
    except (OSError, ValueError, KeyError):
        return Lake(None, f"no flight is stored; {AGAIN}")
    if (record["robot_hash"], record["mission_hash"]) != (robot.hash, mission.hash):
        return Lake(None, f"the robot or the mission has changed since the stored flight; {AGAIN}")
    return Lake(record)


def fly_lake() -> Lake:
    """Fly the mission anew.

    Returns
    -------
    Lake
    """
    file = read_mission(MISSION)
    return Lake(lake_record(fly(file, load(file.robot or ""))))


def lake_record(flight: Flight) -> dict[str, Any]:
    """Say what the ledger needs of a flight.

    Parameters
    ----------
    flight : Flight

    Returns
    -------
    dict
        Of its first 30 min: way over ground, energy of the servos and of the battery; and of the whole, with a row
        every 5 s that a picture is drawn from.
    """
    record, one = flight.record, outcome(flight)
    seconds = min(published()["lake"]["duration_s"], float(record.time[-1]))
    steps = np.hypot(*np.diff(record.path[:, :2], axis=0).T)
    way = float(np.interp(seconds, np.arange(len(steps) + 1), np.concatenate([[0.0], np.cumsum(steps)])))
    return {
        "robot": flight.robot.name,
        "robot_hash": flight.robot.hash,
        "mission_hash": flight.file.hash,
        "seed": flight.seed,
        "seconds": seconds,
        "distance_m": way,
        "servo_energy_wh": float(np.interp(seconds, record.time, record.servo_energy)) / HOUR,
        "battery_energy_wh": float(np.interp(seconds, record.time, record.energy)) / HOUR,
        "whole": {
            "status": one.status,
            "duration_s": one.duration,
            "distance_m": one.distance,
            "battery_energy_wh": one.energy / HOUR,
            "fence_margin_min_m": one.margin_min,
            "position_off_max_m": one.off_max,
        },
        "rows": _rows(record),
    }


def _rows(record: MissionRecord) -> dict[str, Any]:
    """Take what is drawn of a record, to four digits after the point."""
    at = record.every(EVERY)
    columns = {name: np.round(record.data[name][at], 4).tolist() for name in DRAWN}
    return {"modes": list(record.modes), "time": np.round(record.time[at], 4).tolist(), **columns}


def _drawn(told: Mapping[str, Any]) -> MissionRecord:
    """Make a record of the stored rows."""
    file, rows = read_mission(MISSION), told["rows"]
    data = {name: np.array(rows[name], float) for name in DRAWN}
    return MissionRecord(
        file.name, told["robot"], file.mission, np.array(rows["time"]), data, modes=tuple(rows["modes"])
    )


def findings(lake: Lake) -> Iterator[Finding]:
    """Yield way and energy of 30 min on the lake.

    Parameters
    ----------
    lake : Lake

    Yields
    ------
    Finding
    """
    told = lake.record
    if told is None:
        for name in ("lake/distance", "lake/energy"):
            yield Finding(name, LAKE, None, lake.why)
        return
    whole = told["whole"]
    note = (
        f"over ground in the first {told['seconds'] / 60:.3g} min of the mission `lake`, which is {whole['status']} "
        f"after {whole['duration_s'] / 60:.3g} min and {whole['distance_m']:.0f} m"
    )
    yield Finding("lake/distance", LAKE, told["distance_m"], note)
    note = (
        f"of the servos, where the current sensors are; the battery gives {told['battery_energy_wh']:.3g} Wh with "
        "electronics and converter"
    )
    yield Finding("lake/energy", LAKE, told["servo_energy_wh"], note)


def sections(lake: Lake) -> list[Section]:
    """Tell the swim in open water.

    Parameters
    ----------
    lake : Lake

    Returns
    -------
    list of Section
    """
    found = {finding.id: finding for finding in findings(lake)}
    if lake.record is None:
        return [Section("Open water", [f"Not told: {lake.why}."])]
    from hypertuna.mission.plots import plot_mission

    picture = Picture(
        "lake",
        plot_mission(_drawn(lake.record), width=WIDTH),
        "The lake as the twin swam it, where it believed to be, its depth and what it took from its battery.",
        "Seed 0: noise of the sensors, no current. It comes up for a fix every five minutes.",
    )
    way, energy = found["lake/distance"], found["lake/energy"]
    text = f"""The paper swam about 800 m of a lake in 30 min with its gait for 0.5 m/s, on 9.1 Wh. The twin at sea,
under its own pilot, swims {way.computed:.0f} m {way.note}. It takes {energy.computed:.3g} Wh {energy.note}."""
    return [Section("Open water", [picture, text])]
