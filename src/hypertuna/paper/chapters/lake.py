"""The swim in open water of section III.G: the stored flight of the mission `lake`, beside 800 m and 9.1 Wh."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.description.robot import load
from hypertuna.io.files import shipped
from hypertuna.mission.file import read_mission
from hypertuna.mission.flight import Flight, fly, outcome
from hypertuna.mission.record import MissionRecord
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.ledger import Finding, published, published_value
from hypertuna.paper.seeds import read_seeds
from hypertuna.paper.studies import LAKE_GAITS, ROBOT
from hypertuna.reports.html import WIDTH, Section

LAKE = "mission lake"  # the model in the ledger
MISSION = "lake"
STORED = "missions/lake.json"  # below data
AGAIN = "validation/missions/lake.py flies it again"  # which command repeats the stored flight, for reasons
HOUR = 3600.0  # s
# Columns of the flight that are stored and plotted.
PLOTTED = ("position", "attitude", "position_estimated", "depth_estimated", "mode", "energy", "charge_left")
EVERY = 5.0  # s between stored rows


@dataclass(frozen=True)
class Lake:
    """The stored record of a flight of the mission `lake`, or why there is no valid one."""

    record: Mapping[str, Any] | None  # from `lake_record`; None where there is no valid one
    reason: str = ""  # why there is none; without a full stop


def read_lake() -> Lake:
    """Return the stored flight; without a record if the robot or the mission has changed since."""
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
    """Fly the mission `lake`, and return its record."""
    file = read_mission(MISSION)
    return Lake(lake_record(fly(file, load(file.robot or ""))))


def lake_record(flight: Flight) -> dict[str, Any]:
    """Return the numbers of a flight for the ledger: of its first 30 min and the whole, and rows to plot."""
    record, result = flight.record, outcome(flight)
    seconds = min(published()["lake"]["duration_s"], float(record.time[-1]))
    steps = np.hypot(*np.diff(record.path[:, :2], axis=0).T)
    distance = float(np.interp(seconds, np.arange(len(steps) + 1), np.concatenate([[0.0], np.cumsum(steps)])))
    return {
        "robot": flight.robot.name,
        "robot_hash": flight.robot.hash,
        "mission_hash": flight.file.hash,
        "seed": flight.seed,
        "seconds": seconds,
        "distance_m": distance,
        "servo_energy_wh": float(np.interp(seconds, record.time, record.servo_energy)) / HOUR,
        "battery_energy_wh": float(np.interp(seconds, record.time, record.energy)) / HOUR,
        "whole": {
            "status": result.status,
            "duration_s": result.duration,
            "distance_m": result.distance,
            "battery_energy_wh": result.energy / HOUR,
            "fence_margin_min_m": result.fence_margin_min,
            "estimation_error_max_m": result.estimation_error_max,
        },
        "rows": _rows(record),
    }


def _rows(record: MissionRecord) -> dict[str, Any]:
    """Return the plotted columns of a record at a few instants, to four decimals."""
    plotted = record.every(EVERY)
    columns = {name: np.round(record.data[name][plotted], 4).tolist() for name in PLOTTED}
    return {"modes": list(record.modes), "time": np.round(record.time[plotted], 4).tolist(), **columns}


def _stored_record(stored: Mapping[str, Any]) -> MissionRecord:
    """Return a record of the stored rows."""
    file, rows = read_mission(MISSION), stored["rows"]
    data = {name: np.array(rows[name], float) for name in PLOTTED}
    return MissionRecord(
        file.name, stored["robot"], file.mission, np.array(rows["time"]), data, modes=tuple(rows["modes"])
    )


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Lake:
    """Return the stored flight; in full a new one."""
    return fly_lake() if full else read_lake()


def findings(lake: Lake) -> Iterator[Finding]:
    """Yield distance and energy of the mission; both are weak evidence, for its course and its gait are chosen."""
    record = lake.record
    if record is None:
        yield Finding("lake/distance", LAKE, "input", None, lake.reason)
        yield Finding("lake/energy", LAKE, "in sight", None, lake.reason)
        return
    whole_flight, minutes = record["whole"], record["seconds"] / 60
    note = (
        f"over ground in the first {minutes:.3g} min of the mission `lake`, whose course is 800 m long for "
        f"any robot; its status is {whole_flight['status']} after {whole_flight['duration_s'] / 60:.3g} min and "
        f"{whole_flight['distance_m']:.0f} m"
    )
    yield Finding("lake/distance", LAKE, "input", record["distance_m"], note)
    note = (
        f"energy of the servos in {minutes:.3g} min; their loop, rotor and currents were chosen with this number in "
        f"view; the battery gives {record['battery_energy_wh']:.3g} Wh with electronics and converter"
    )
    yield Finding("lake/energy", LAKE, "in sight", record["servo_energy_wh"], note)


def sections(lake: Lake) -> list[Section]:
    """Show the swim in open water."""
    from hypertuna.mission.plots import plot_mission

    distance, energy = findings(lake)
    record = lake.record
    figures = {} if record is None else {"lake": plot_mission(_stored_record(record), width=WIDTH)}
    straight_runs = read_seeds("lakes", load(ROBOT))
    swum = {
        f"{name} {what}": float(np.median(straight_runs.numbers[f"{name} {what}"]))
        for name in LAKE_GAITS
        for what in ("speed", "power")
    }
    return compose(
        "lake",
        figures,
        record=record,
        distance=distance,
        energy=energy,
        straight=straight_runs,
        swum=swum,
        gaits=LAKE_GAITS,
        speed=published_value("lake/speed"),
        power=published_value("power/lake"),
    )


CHAPTER = Chapter("lake", sections, findings, compute)
