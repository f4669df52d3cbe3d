"""Flights: fly a mission file on the twin part by part, with a journal to resume from and a log."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arguments import checked
from hypertuna.control.mission import fence_distance
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.io.checkpoint import Journal
from hypertuna.io.quantity import Format, Quantity, summarized
from hypertuna.mission.checks import check_current
from hypertuna.mission.file import MissionFile, randomized, read_mission
from hypertuna.mission.log import LogWriter
from hypertuna.mission.record import COLUMNS, MissionRecord, joined, names_of
from hypertuna.mission.run import (
    MissionRun,
    MissionStart,
    Part,
    expected,
    fly_part,
    fly_parts,
    joined_parts,
    mission_start,
)

Report = Callable[[int, int], None]  # called with the amount done and the total


@dataclass(frozen=True)
class Flight(Plotted, Tabular):
    """A flown mission: its file, robot, seed and record."""

    file: MissionFile
    robot: Robot
    seed: int
    record: MissionRecord
    status: str  # one of `hypertuna.mission.run.ENDINGS`


OUTCOME = {  # numbers of an `Outcome` with unit and note, as they are shown
    "waypoints_reached": Format(),
    "waypoints_passed": Format(),
    "waypoints_skipped": Format(),
    "duration": Format("s"),
    "distance": Format("m", "over ground"),
    "energy": Format("Wh", "from the battery"),
    "charge_left": Format("", "part of the whole"),
    "depth_max": Format("m"),
    "fence_margin_min": Format("m"),
    "estimation_error_max": Format("m", "of the position"),
    "goal_distance": Format("m", "at the end"),
    "goal_uncertainty": Format("m", "standard deviation at the end"),
}


@dataclass(frozen=True)
class Outcome:
    """Numbers and end of a flight: waypoints, times, distances, energy."""

    seed: int
    status: str
    waypoints_reached: int
    waypoints_passed: int  # left behind although not reached within the time allowed for position and depth
    waypoints_skipped: int
    duration: float  # s
    distance: float  # m, over ground
    energy: float  # J, from the battery
    charge_left: float  # remaining fraction of the charge
    depth_max: float  # m
    fence_margin_min: float  # m, min distance to the fence, negative outside; infinite without a fence
    estimation_error_max: float  # m, max error of the estimated position
    goal_distance: float  # m, at the end, from home or from the last waypoint of a mission that stays
    goal_uncertainty: float  # m, the pilot's standard deviation of its estimated position at the end
    reasons: dict[str, float]  # s, time at which each of the pilot's reasons first held
    waypoints: list[dict[str, Any]]  # rows from `waypoint_results`

    def summary(self) -> dict[str, Quantity]:
        """Return the numbers of a flight by their keys in the JSON record."""
        return summarized(self, OUTCOME)


@checked
def fly(
    file: MissionFile | str | Path,
    robot: Robot | str | Path,
    *,
    seed: int = 0,
    faults: Iterable[str] = (),
    every: int = 10,
    duration: float | None = None,
    checkpoint: str | Path | None = None,
    log: Path | None = None,
    report: Report | None = None,
) -> Flight:
    """Fly a mission on the robot's twin until it ends.

    Parameters
    ----------
    file : MissionFile, str or Path
        Mission, its name or the path of its file.
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    seed : int
        Seed of the sensors' noise, and of current and GPS gaps where the file scatters them; 0 flies the mission as in
        the file.
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
    file = read_mission(file) if isinstance(file, str | Path) else file
    robot = robot_of(robot)
    faults = tuple(faults)
    check_current(robot, file.mission, file.scatter.current if seed else 0.0)
    start = mission_start(robot, randomized(file, seed), seed=seed, faults=faults, every=every, duration=duration)
    options = {"mission": file.hash, "seed": seed, "faults": list(faults), "every": every, "duration": start.duration}
    facts = _facts(file, robot, seed, faults)
    total = max(1, round(expected(start.mission, start.table.speed[-1])))
    records: list[MissionRecord] = []
    status = "interrupted"
    with Journal(checkpoint, journal_header("mission", robot, options)) as journal:
        writer = None if log is None else LogWriter(log)
        try:
            for ticks_done, part in fly_parts(start, None if checkpoint is None else _from_journal(start, journal)):
                run = joined_parts(start, [part])
                records.append(_record(file, run, ticks_done * start.tick, records, facts))
                if writer is not None:
                    writer.write(records[-1])
                if report is not None:
                    report(min(round((ticks_done + int(part["ticks"][0])) * start.tick), total - 1), total)
            status = run.status
            if report is not None:
                report(total, total)
        finally:
            if writer is not None:
                writer.close({"status": status} if records else None)
    return Flight(file, robot, seed, joined(records), status)


def outcome(flight: Flight) -> Outcome:
    """Return the outcome of a flight: numbers, status, and the result at each waypoint."""
    record, mission = flight.record, flight.record.mission
    results = waypoint_results(record)
    reached, passed, skipped = (
        sum(waypoint["outcome"] == name for waypoint in results) for name in ("reached", "passed", "skipped")
    )
    place = record.position[:, :2]
    goal = mission.course[-1]
    return Outcome(
        seed=flight.seed,
        status=flight.status,
        waypoints_reached=reached,
        waypoints_passed=passed,
        waypoints_skipped=skipped,
        duration=float(record.time[-1]),
        distance=record.distance,
        energy=float(record.energy[-1]),
        charge_left=float(record.data["charge_left"][-1]),
        depth_max=float(record.depth.max()),
        fence_margin_min=float(fence_distance(mission, place).min()),
        estimation_error_max=float(record.estimation_error.max()),
        goal_distance=float(np.hypot(*(place[-1] - goal))),
        goal_uncertainty=float(record.data["position_error"][-1]),
        reasons=record.first_reasons,
        waypoints=results,
    )


def _from_journal(start: MissionStart, journal: Journal) -> Callable[[int, int, bytes | None], tuple[Part, bytes]]:
    """Return a function that flies a part of a mission, or takes the part's record from the journal."""

    def fly(ticks_done: int, ticks: int, state: bytes | None) -> tuple[Part, bytes]:
        def work() -> dict[str, Any]:
            part, end_state = fly_part(start, ticks, state)
            return {"record": part, "state": base64.b64encode(end_state).decode()}

        answer = journal.answer(ticks_done, work)
        part = {name: np.asarray(values, float) for name, values in answer["record"].items()}
        return part, base64.b64decode(answer["state"])

    return fly


def _record(
    file: MissionFile, run: MissionRun, begin: float, before: Sequence[MissionRecord], facts: Mapping[str, str]
) -> MissionRecord:
    """Return the record of a part of a run, with energy [J]: the battery's voltage integrated over the charge."""
    start = run.start
    data = {name: values for name, values in run.data.items() if name in COLUMNS}
    data["angle"] = data["angle"][:, : len(start.robot.joints)]  # without the passive hinges, whose columns follow
    charge_before, energy_before = float(start.core["charge"]), 0.0
    if before:
        charge_before, energy_before = float(before[-1].data["charge"][-1]), float(before[-1].energy[-1])
    data["energy"] = energy_before + np.cumsum(data["battery_voltage"] * np.diff(data["charge"], prepend=charge_before))
    data["charge_left"] = 1 - data["charge"] / start.capacity
    return MissionRecord(
        name=file.name,
        robot=start.robot.name,
        mission=start.mission,
        time=run.time + begin,
        data=data,
        origin=file.origin,
        facts=facts,
        **names_of(start.robot),
    )


def _facts(file: MissionFile, robot: Robot, seed: int, faults: Sequence[str]) -> dict[str, str]:
    """Return the provenance of a record as texts: robot, mission file, seed and faults."""
    inputs = {"mission_file": file.file, "mission_hash": file.hash, "seed": str(seed), "faults": " ".join(faults)}
    # The twin has its own joint model.
    made_by = {key: value for key, value in provenance(robot).items() if key != "joints"}
    return {key: str(value) for key, value in (made_by | inputs).items()}


def waypoint_results(record: MissionRecord) -> list[dict[str, Any]]:
    """Return a row per waypoint: number from 1, outcome, time, believed and true distance, uncertainty, depth.

    Values are those when the robot turned to the next waypoint; None for a waypoint that is still ahead.
    """
    outcomes = list(_outcomes(record))
    left = len(record.mission.waypoints) - len(outcomes)
    empty = dict.fromkeys(("time_s", "believed_m", "true_m", "uncertainty_m", "depth_m"))
    rows = [_result(record, k, *result) for k, result in enumerate(outcomes)] + [{"outcome": "ahead"} | empty] * left
    return [{"waypoint": number} | row for number, row in enumerate(rows, 1)]


def _outcomes(record: MissionRecord) -> Iterator[tuple[str, int]]:
    """Yield for every waypoint that was left, in order, its outcome and the record's row at that time."""
    legs, reached, passed = (record.data[name].astype(int) for name in ("leg", "reached", "passed"))
    for k in np.flatnonzero(np.diff(legs)) + 1:
        counts = {"reached": reached[k] - reached[k - 1], "passed": passed[k] - passed[k - 1]}
        counts["skipped"] = legs[k] - legs[k - 1] - sum(counts.values())
        for name, count in counts.items():
            yield from [(name, int(k))] * max(count, 0)


def _result(record: MissionRecord, k: int, outcome: str, row: int) -> dict[str, Any]:
    """Return the row of `waypoint_results` for waypoint k, from its outcome and a row of the record."""
    place = record.mission.waypoints[k][:2]
    believed = record.data["position_estimated"][row] - place
    true = record.position[row, :2] - place if record.true else None
    return {
        "outcome": outcome,
        "time_s": float(record.time[row]),
        "believed_m": float(np.hypot(*believed)),
        "true_m": None if true is None else float(np.hypot(*true)),
        "uncertainty_m": float(record.data["position_error"][row]),
        "depth_m": float(record.depth[row]),
    }
