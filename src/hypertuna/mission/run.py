"""Fly a mission: the twin at sea under its pilot, part by part."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.actuation.battery import battery_columns
from hypertuna.arrays import Array
from hypertuna.control.guidance import GaitTable, gait_table, mission_columns, pilot_columns
from hypertuna.control.mission import Mission, fence_distance
from hypertuna.control.sensors import FOREVER, fault_texts, pilot_sensor_columns
from hypertuna.control.sensors import faults as read_faults
from hypertuna.description.robot import Robot, require
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import FINITE, POSITIVE_WHOLE
from hypertuna.simulation.plant import SEEDS, controller_of, parts_of, steps_needed
from hypertuna.simulation.sea import Sea, world_at_sea
from hypertuna.simulation.sea_run import Motion

MAX_DURATION = 1e5  # s of a mission: at 10 rows a second half a gigabyte of record
PART = 30.0  # s, flown at a time
SLACK = 2.0  # times the course at its speeds, plus ten minutes: default duration
FIN = re.compile(r"(?P<which>fin-port|fin-starboard|fins):(?P<kind>[^:@]+)@(?P<start>[^:@]+)")
FIN_KINDS = {"stuck": math.nan, "level": 0.0, "up": 1.0, "down": -1.0}  # parts of the largest angle
DISTANCE_STEP = 2.0  # s between the places that a distance is summed over: whole beats of most gaits


@dataclass(frozen=True)
class MissionStart:
    """A mission ready to fly, with the arguments of the core."""

    robot: Robot = field(repr=False)
    mission: Mission
    table: GaitTable
    seed: int
    faults: tuple[str, ...]  # as given
    duration: float  # s, then it is given up
    every: int  # ticks from one row of the record to the next
    tick: float  # control tick [s]
    core: dict[str, Any] = field(repr=False)  # arguments of `_core.simulate`

    @property
    def ticks(self) -> int:
        """Max number of control ticks."""
        return int(self.duration / self.tick * (1 + 1e-12))


@dataclass(frozen=True)
class MissionRun(Motion):
    """A flown mission."""

    start: MissionStart
    time: Array = field(repr=False)  # (T,), start of every recorded control tick [s]
    data: dict[str, Array] = field(repr=False)  # by the names of `_core.simulate`, (T,) or (T, n) [SI]
    status: str  # "done"; "home" before all waypoints were reached; "hold", "given up" (out of time) or "diverged"

    @property
    def modes(self) -> tuple[str, ...]:
        """Mode of the pilot in every row."""
        names = _core.mode_names()
        return tuple(names[int(mode)] for mode in self.data["mode"])

    @property
    def reasons(self) -> dict[str, float]:
        """The pilot's reasons, by the time at which each first held [s]."""
        flags = self.data["reasons"].astype(np.int64)
        first = {}
        for bit, (name, _) in enumerate(_core.reason_table()):
            held = flags >> bit & 1 == 1
            if held.any():
                first[name] = float(self.time[held.argmax()])
        return dict(sorted(first.items(), key=lambda item: item[1]))

    @cached_property
    def distance(self) -> float:
        """Distance over ground [m], without the beat's swing."""
        stride = max(1, round(DISTANCE_STEP / (self.start.tick * self.start.every)))
        track = self.position[::stride, :2]
        return float(np.hypot(*np.diff(track, axis=0).T).sum())

    @cached_property
    def energy(self) -> float:
        """Electrical energy of all servos [J]."""
        return float(self.data["power"].sum() * self.start.tick * self.start.every)


def mission_start(
    robot: Robot,
    mission: Mission,
    *,
    seed: int = 0,
    faults: str | Iterable[str] = (),
    table: GaitTable | None = None,
    every: int = 10,
    duration: float | None = None,
) -> MissionStart:
    """Check a mission against a robot and collect the arguments of the core."""
    control = require(robot.controller, "controller", robot)
    tick = 1 / control.rate
    table = gait_table(robot) if table is None else table
    parts = parts_of(robot, "water", None)
    _check_margin(robot, mission)
    every = POSITIVE_WHOLE.check(every, "every", "give a whole number of ticks")
    limit = min(_default_duration(mission), MAX_DURATION)
    if duration is not None:
        limit = FINITE.check(duration, "duration", "give seconds")
    if not tick <= limit <= MAX_DURATION:
        rule = f"must be from {tick:g} to {MAX_DURATION:g} s"
        raise InputError(rule, key="duration", value=f"{limit:g}", fix="give the seconds after which to give up")
    given = fault_texts(faults)
    fins = [fault for fault in given if FIN.fullmatch(fault.strip())]
    sensors = tuple(fault for fault in given if fault not in fins)
    controller = _core.Controller(controller_of(robot))
    core: dict[str, Any] = {
        "plant": parts.plant,
        "command": _core.Pilot(controller, pilot_columns(robot, table), mission_columns(mission)),
        "world": world_at_sea(robot, _sea(mission), mission.gaps),
        "sensors": _core.Sensors(pilot_sensor_columns(robot), SEEDS.check(seed, "seed")),
        "faults": list(read_faults(sensors, robot, limit)),
        "fin_faults": [row for fault in fins for row in _fin_fault(fault, control.fin_max)],
        "twist": np.zeros(6),
        "pose": _pose(mission),
        "charge": (1 - mission.battery) * battery_columns(robot)["charge"],
        "steps": steps_needed(tick, parts, robot),
        "every": every,
    }
    return MissionStart(robot, mission, table, seed, given, limit, every, tick, core)


def fly_part(start: MissionStart, ticks: int, state: bytes | None = None) -> tuple[dict[str, Array], bytes]:
    """Fly a part of a mission."""
    record, after = _core.simulate(**start.core, ticks=ticks, state=state)
    return record, after


def fly_mission(
    robot: Robot,
    mission: Mission,
    *,
    seed: int = 0,
    faults: str | Iterable[str] = (),
    table: GaitTable | None = None,
    every: int = 10,
    duration: float | None = None,
    report: Callable[[float, dict[str, Array]], None] | None = None,
) -> MissionRun:
    """Fly a mission to its end."""
    start = mission_start(robot, mission, seed=seed, faults=faults, table=table, every=every, duration=duration)
    ticks, length = start.ticks, part_ticks(start)
    records: list[dict[str, Array]] = []
    state, made = None, 0
    while made < ticks:
        asked = min(length, ticks - made)
        record, state = fly_part(start, asked, state)
        made += int(record["ticks"][0])
        records.append(record)
        if report is not None:
            report(made * start.tick, record)
        if over(start, record, asked):
            break
    return joined(start, records)


def part_ticks(start: MissionStart) -> int:
    """Return the ticks of a part: whole rows of the record."""
    return max(1, round(PART / (start.tick * start.every))) * start.every


def over(start: MissionStart, record: dict[str, Array], asked: int) -> bool:
    """Return whether a part was the last: done, or diverged."""
    made = int(record["ticks"][0])
    rows = -(-made // start.every)
    return made < asked or (rows > 0 and _mode(record["mode"][rows - 1]) == "done")


def joined(start: MissionStart, records: list[dict[str, Array]]) -> MissionRun:
    """Join the records of a mission's parts, up to where it was done."""
    kept = []
    diverged = False
    for record in records:
        made = int(record["ticks"][0])
        rows = -(-made // start.every)
        diverged = rows < len(record["mode"])
        kept.append({name: values[:rows] for name, values in record.items() if name != "ticks"})
    data = {name: np.concatenate([record[name] for record in kept]) for name in kept[0]}
    done = np.flatnonzero(data["mode"] == _core.mode_names().index("done"))
    last = int(done[0]) + 1 if len(done) else len(data["mode"])
    data = {name: values[:last] for name, values in data.items()}
    end = _mode(data["mode"][-1])
    early = end == "done" and data["leg"][-1] < len(start.mission.waypoints)
    status = "diverged" if diverged else "home" if early else end if end in ("done", "hold") else "given up"
    time = np.arange(last, dtype=np.float64) * start.tick * start.every
    return MissionRun(start, time, data, status)


def _mode(number: float) -> str:
    return _core.mode_names()[int(number)]


def _sea(mission: Mission) -> Sea:
    bottom = mission.bottom if math.isfinite(mission.bottom) else math.inf
    sheared = mission.current_bottom if math.isfinite(bottom) else None
    return Sea(current=mission.current, current_bottom=sheared, bottom=bottom)


def _pose(mission: Mission) -> Array:
    """Position, attitude and fins at the start: upright, the axis from nose to tail along the heading."""
    attitude = np.array([math.cos(mission.heading / 2), 0.0, 0.0, math.sin(mission.heading / 2)])
    return np.concatenate([[*mission.start, -mission.depth], attitude, [0.0, 0.0]])


def _check_margin(robot: Robot, mission: Mission) -> None:
    """Check that no waypoint is within the pilot's fence margin."""
    margin = require(robot.guidance, "guidance", robot).fence_margin
    room = fence_distance(mission, np.array([(point.x, point.y) for point in mission.waypoints]).reshape(-1, 2))
    for k in np.flatnonzero(room < margin)[:1]:
        rule = f"must be {margin:g} m inside the fence, guidance.fence_margin_m of the robot"
        fix = "move it, or widen the fence"
        raise InputError(rule, key=f"waypoints[{k}]", value=f"{room[k]:.3g} m inside", fix=fix)


def _default_duration(mission: Mission) -> float:
    """Return the duration [s] after which a mission without one is given up."""
    places = np.array([mission.start, *[(w.x, w.y) for w in mission.waypoints], mission.home])
    legs = np.hypot(*np.diff(places, axis=0).T)
    speeds = np.array([*[w.speed for w in mission.waypoints], mission.home_speed])
    return max(mission.duration, SLACK * float((legs / speeds).sum())) + 600.0


def _fin_fault(spelled: str, limit: float) -> list[tuple[int, float, float, float]]:
    """Read the fault of a fin's servo: which, angle, from, to."""
    match = FIN.fullmatch(spelled.strip())
    assert match is not None
    if match["kind"] not in FIN_KINDS:
        fix = did_you_mean(match["kind"], FIN_KINDS)
        raise InputError("must be of a known kind", key="fault", value=shown(spelled), fix=fix)
    first, dash, last = match["start"].partition("-")
    try:
        start, end = float(first), float(last) if dash else FOREVER
    except ValueError:
        start, end = math.nan, math.nan
    if not 0 <= start < end:
        fix = "give seconds from the start of the mission, the end after the start"
        raise InputError("must have a time", key="fault", value=shown(spelled), fix=fix)
    which = {"fin-port": (0,), "fin-starboard": (1,), "fins": (0, 1)}[match["which"]]
    return [(fin, FIN_KINDS[match["kind"]] * limit, start, end) for fin in which]
