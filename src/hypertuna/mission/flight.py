"""Flights: a mission file flown on the twin part by part, with a journal to resume from and a log; many seeds."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.actuation.battery import battery_columns
from hypertuna.arrays import Array
from hypertuna.control.mission import Mission, fence_distance
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.checkpoint import Journal
from hypertuna.io.quantity import Quantity
from hypertuna.mission.file import MissionFile, randomized
from hypertuna.mission.log import LogWriter
from hypertuna.mission.record import COLUMNS, MissionRecord, joined
from hypertuna.mission.run import MissionRun, MissionStart, fly_part, mission_start, over, part_ticks
from hypertuna.mission.run import joined as joined_parts
from hypertuna.swimming.sweep import thread_count

Report = Callable[[int, int], None]

MAX_SEEDS = 10_000


@dataclass(frozen=True)
class Flight:
    """A flown mission."""

    file: MissionFile
    robot: Robot
    seed: int
    record: MissionRecord
    status: str  # "done"; "home" before all waypoints were reached; "hold", "given up" or "diverged"


@dataclass(frozen=True)
class Outcome:
    """Summary of a flight."""

    seed: int
    status: str
    reached: int  # waypoints reached
    duration: float  # s
    distance: float  # m, over ground
    energy: float  # J, from the battery
    charge_left: float  # remaining fraction of the charge
    depth_max: float  # m
    margin_min: float  # m, min distance to the fence, negative outside; infinite without a fence
    off_max: float  # m, max error of the estimated position
    home_distance: float  # m, at the end, from home or from the last waypoint of a mission that stays
    reasons: dict[str, float]  # s, time at which each of the pilot's reasons first held

    def summary(self) -> dict[str, Quantity]:
        """Return the numbers of a flight, by the names of the JSON record."""
        return {
            "waypoints_reached": Quantity(self.reached, "", "waypoints reached"),
            "duration_s": Quantity(self.duration, "s", "time"),
            "distance_m": Quantity(self.distance, "m", "distance over ground"),
            "energy_wh": Quantity(self.energy / 3600, "Wh", "energy from the battery"),
            "charge_left": Quantity(self.charge_left, "", "part of the charge left"),
            "depth_max_m": Quantity(self.depth_max, "m", "max depth"),
            "fence_margin_min_m": Quantity(self.margin_min, "m", "min distance to the fence"),
            "position_off_max_m": Quantity(self.off_max, "m", "max error of the estimated position"),
            "goal_distance_m": Quantity(self.home_distance, "m", "from home at the end"),
        }


def fly(
    file: MissionFile,
    robot: Robot,
    *,
    seed: int = 0,
    faults: Iterable[str] = (),
    every: int = 10,
    duration: float | None = None,
    checkpoint: str | Path | None = None,
    log: Path | None = None,
    report: Report | None = None,
) -> Flight:
    """Fly a mission to its end.

    Parameters
    ----------
    file : MissionFile
    robot : Robot
    seed : int
        Of the sensors' noise, and of the water and the satellites where the file scatters them; 0 for the mission as
        it stands.
    faults : iterable of str
        Of sensors and fins, as `hypertuna.mission.run.mission_start` takes them.
    every : int
        Ticks from one row of the record to the next.
    duration : float, optional
        Give the mission up after this time [s].
    checkpoint : str or Path, optional
        Journal to resume from.
    log : Path, optional
        MCAP file to write while the mission is flown.
    report : callable, optional
        Called with the seconds flown and those expected.

    Returns
    -------
    Flight

    Raises
    ------
    InputError
        If the robot lacks a table, or something does not fit.
    """
    faults = tuple(faults)
    mission = randomized(file, seed)
    start = mission_start(robot, mission, seed=seed, faults=faults, every=every, duration=duration)
    options = {"mission": file.hash, "seed": seed, "faults": list(faults), "every": every, "duration": start.duration}
    facts = _facts(file, robot, seed, faults)
    records: list[MissionRecord] = []
    status, ended = "given up", False
    with Journal(checkpoint, journal_header("mission", robot, options)) as journal:
        writer = None if log is None else LogWriter(log)
        try:
            for run, begin in _parts(start, journal, checkpoint is not None, report):
                before = records[-1] if records else None
                records.append(_record(file, run, begin, before, facts))
                status = run.status
                if writer is not None:
                    writer.write(records[-1])
            ended = True
        finally:
            if writer is not None:
                writer.close({"status": status if ended else "interrupted"} if records else None)
    whole = joined(records)
    return Flight(file, robot, seed, whole, status)


def fly_seeds(
    file: MissionFile,
    robot: Robot,
    seeds: Sequence[int],
    *,
    threads: int | None = None,
    faults: Iterable[str] = (),
    duration: float | None = None,
    checkpoint: str | Path | None = None,
    report: Report | None = None,
) -> list[Outcome]:
    """Fly a mission with many seeds."""
    if not 1 <= len(seeds) <= MAX_SEEDS:
        rule = f"must be from 1 to {MAX_SEEDS} seeds"
        raise InputError(rule, key="seeds", value=f"{len(seeds)}", fix="write from:to, as 0:100")
    faults = tuple(faults)
    options = {"mission": file.hash, "seeds": list(seeds), "faults": list(faults), "duration": duration}
    mission_start(robot, file.mission, faults=faults, duration=duration)  # what does not fit is answer before any work
    outcomes: list[Outcome] = []
    with (
        Journal(checkpoint, journal_header("mission seeds", robot, options)) as journal,
        ThreadPoolExecutor(thread_count(threads)) as pool,
    ):
        work: dict[int, Future[dict[str, Any]]] = {
            seed: pool.submit(_outcome_of, file, robot, seed, faults, duration) for seed in seeds[journal.known :]
        }
        try:
            for k, seed in enumerate(seeds):
                outcomes.append(Outcome(**journal.answer(seed, lambda seed=seed: work[seed].result())))  # type: ignore[misc]  # a default argument is not inferred
                if report is not None:
                    report(k + 1, len(seeds))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return outcomes


def outcome(flight: Flight) -> Outcome:
    """Return the summary of a flight."""
    record, mission = flight.record, flight.record.mission
    place = record.data["position"][:, :2]
    off = np.hypot(*(record.data["position_estimated"] - place).T)
    goal = mission.waypoints[-1][:2] if mission.stay else mission.home
    flags = record.data["reasons"].astype(np.int64)
    held = {name: flags >> bit & 1 == 1 for bit, name in enumerate(record.reasons)}
    first = {name: float(record.time[there.argmax()]) for name, there in held.items() if there.any()}
    return Outcome(
        seed=flight.seed,
        status=flight.status,
        reached=int(record.data["leg"][-1]),
        duration=float(record.time[-1]),
        distance=record.distance,
        energy=float(record.energy[-1]),
        charge_left=float(record.data["charge_left"][-1]),
        depth_max=float(record.depth.max()),
        margin_min=float(fence_distance(mission, place).min()),
        off_max=float(off.max()),
        home_distance=float(np.hypot(*(place[-1] - goal))),
        reasons=dict(sorted(first.items(), key=lambda item: item[1])),
    )


def expected(mission: Mission, fastest: float = math.inf) -> float:
    """Return the duration [s] of a mission at its speeds through still water."""
    points, places = mission.waypoints, [mission.start, *(point[:2] for point in mission.waypoints)]
    speeds = [point.speed for point in points]
    if not mission.stay:
        places.append(mission.home)
        speeds.append(mission.home_speed)
    legs = np.hypot(*np.diff(np.array(places), axis=0).T)
    return float((legs / np.minimum(speeds, fastest)).sum())


def _outcome_of(
    file: MissionFile, robot: Robot, seed: int, faults: Sequence[str], duration: float | None
) -> dict[str, Any]:
    """Fly one seed and return its summary for the journal."""
    return vars(outcome(fly(file, robot, seed=seed, faults=faults, duration=duration)))


def _parts(
    start: MissionStart, journal: Journal, keep: bool, report: Report | None
) -> Iterable[tuple[MissionRun, float]]:
    """Fly part after part: each with the time at its start [s]."""
    ticks, length = start.ticks, part_ticks(start)
    state: bytes | None = None
    made, total = 0, max(1, round(expected(start.mission, start.table.speed[-1])))
    while made < ticks:
        asked, begin = min(length, ticks - made), made * start.tick
        record, state = _part(start, journal, asked, made, state) if keep else fly_part(start, asked, state)
        made += int(record["ticks"][0])
        yield joined_parts(start, [record]), begin
        if report is not None:
            report(min(round(made * start.tick), total), total)
        if over(start, record, asked):
            return


def _part(
    start: MissionStart, journal: Journal, asked: int, made: int, state: bytes | None
) -> tuple[dict[str, Array], bytes]:
    """Fly a part, or take it from the journal."""

    def work() -> dict[str, Any]:
        record, after = fly_part(start, asked, state)
        return {"record": record, "state": base64.b64encode(after).decode()}

    answer = journal.answer(made, work)
    return {name: np.asarray(values, float) for name, values in answer["record"].items()}, base64.b64decode(
        answer["state"]
    )


def _record(
    file: MissionFile, run: MissionRun, begin: float, before: MissionRecord | None, facts: Mapping[str, str]
) -> MissionRecord:
    """Make a record of a part of a run; energy is what the battery gave, its voltage integrated over the charge."""
    robot, mission = run.start.robot, run.start.mission
    data = {name: values for name, values in run.data.items() if name in COLUMNS}
    full = battery_columns(robot)["charge"]
    taken = float(run.start.core["charge"]) if before is None else float(before.data["charge"][-1])
    given = 0.0 if before is None else float(before.energy[-1])
    data["energy"] = given + np.cumsum(data["battery_voltage"] * np.diff(data["charge"], prepend=taken))
    data["charge_left"] = 1 - data["charge"] / full
    joints = tuple(group.name for group in robot.joints)
    return MissionRecord(
        name=file.name,
        robot=robot.name,
        mission=mission,
        time=run.time + begin,
        data=data,
        joints=joints,
        circuits=tuple(f"{joint}-{side}" for joint in joints for side in ("left", "right")),
        modes=tuple(_core.mode_names()),
        reasons=tuple(name for name, _ in _core.reason_table()),
        origin=file.origin,
        facts=facts,
    )


def _facts(file: MissionFile, robot: Robot, seed: int, faults: Sequence[str]) -> dict[str, str]:
    """Return the provenance of a record."""
    given = {"mission_file": file.file, "mission_hash": file.hash, "seed": str(seed), "faults": " ".join(faults)}
    made_by = {key: value for key, value in provenance(robot).items() if key != "joints"}  # the twin moves its own
    return {key: str(value) for key, value in (made_by | given).items()}
