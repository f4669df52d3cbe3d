"""Fly missions on the twin at sea under its pilot: prepare the core's arguments, and run it part by part."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.actuation.battery import battery_columns
from hypertuna.arrays import Array
from hypertuna.control.guidance import GaitTable, gait_table, mission_columns, pilot_columns
from hypertuna.control.mission import Mission
from hypertuna.control.sensors import fault_texts, pilot_sensor_columns
from hypertuna.control.sensors import faults as read_faults
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.robot import Robot
from hypertuna.description.twin import require_controller
from hypertuna.mission.checks import PILOTED, check_fit
from hypertuna.mission.mishaps import split_mishaps
from hypertuna.ranges import POSITIVE_WHOLE, Range
from hypertuna.simulation.plant import SEEDS, controller_of, parts_of, steps_of
from hypertuna.simulation.sea import Sea, world_columns

Part = dict[str, Array]  # the core's record of a part: arrays (T,) or (T, n) by name [SI], and the number of ticks

MAX_DURATION = 1e5  # s of a mission; with 10 rows per second, its record takes half a gigabyte
PART_DURATION = 30.0  # s of flight per part
DURATION_FACTOR = 2.0  # default duration, over the time of the course at its speeds; ten minutes are added
DISTANCE_STEP = 2.0  # s between the places whose distances are summed: whole beats for most gaits
ENDINGS = dict(_core.ending_table())  # how a flight ends: name and sentence


@dataclass(frozen=True)
class MissionStart:
    """A mission checked for a robot, with the arguments of the core's simulation."""

    robot: Robot = field(repr=False)
    mission: Mission
    table: GaitTable
    duration: float  # s, after which the mission is given up
    every: int  # ticks from one row of the record to the next
    tick: float  # control tick [s]
    capacity: float  # charge of the full battery [C]
    core: dict[str, Any] = field(repr=False)  # arguments of `_core.simulate`

    @property
    def ticks(self) -> int:
        """Largest number of control ticks."""
        return int(self.duration / self.tick * (1 + 1e-12))


@dataclass(frozen=True)
class MissionRun:
    """A mission as the core recorded it."""

    start: MissionStart
    time: Array = field(repr=False)  # (T,), start of every recorded control tick [s]
    data: dict[str, Array] = field(repr=False)  # by the names of `_core.simulate`, (T,) or (T, n) [SI]
    status: str  # one of `ENDINGS`

    @cached_property
    def distance(self) -> float:
        """Distance over ground [m], without the beat's swing."""
        stride = max(1, round(DISTANCE_STEP / (self.start.tick * self.start.every)))
        track = self.data["position"][::stride, :2]
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
    every: int = 10,
    duration: float | None = None,
    resets: Sequence[float] = (),
    released: float = 0.0,
) -> MissionStart:
    """Check a mission against a robot and collect the arguments of the core.

    The satellite receiver restarts at the times `resets` [s]. The robot is held at its start until `released` [s].
    """
    require_at_sea(robot, *PILOTED)
    control = require_controller(robot)
    tick = 1 / control.rate
    table = gait_table(robot)
    parts = parts_of(robot, "water", None)
    check_fit(robot, mission)
    every = POSITIVE_WHOLE.check(every, "every", "give a whole number of ticks")
    # Also for a mission that stays, the default allows for the way home, since the robot may turn home early.
    default_duration = max(mission.duration, DURATION_FACTOR * expected(replace(mission, stay=False))) + 600.0
    fix = "give the seconds after which to give up"
    given_up = min(default_duration, MAX_DURATION) if duration is None else duration
    limit = Range(min=tick, max=MAX_DURATION, unit="s").check(given_up, "duration", fix)
    sensors, mishaps = split_mishaps(robot, fault_texts(faults), control.fin_max)
    capacity = battery_columns(robot)["charge"]
    controller = _core.LiveController(controller_of(robot))
    hindrances = {"resets": np.array(resets, dtype=np.float64), "released": released, "snags": np.array(mishaps.snags)}
    core: dict[str, Any] = {
        "plant": parts.plant,
        "command": _core.Pilot(controller, pilot_columns(robot, table), mission_columns(mission)),
        "world": _core.World(flight_columns(robot, mission) | hindrances),
        "sensors": _core.Sensors(pilot_sensor_columns(robot), SEEDS.check(seed, "seed")),
        "faults": list(read_faults(sensors, robot, limit, pilot=True)),
        "servo_faults": mishaps.servos,
        "oil_losses": mishaps.oil,
        "twist": np.zeros(6),
        "pose": _pose(mission),
        "charge": (1 - mission.battery) * capacity,
        "steps": steps_of(tick, parts, robot),
        "every": every,
    }
    return MissionStart(robot, mission, table, limit, every, tick, capacity, core)


def sea_of(mission: Mission) -> Sea:
    """Return the water, the air and the magnetic field of a mission."""
    return Sea(
        current=mission.current,
        current_bottom=mission.current_bottom if math.isfinite(mission.bottom) else None,
        bottom=mission.bottom,
        dip=mission.dip,
        declination=mission.field_declination,
        air_pressure=mission.air_pressure,
    )


def flight_columns(robot: Robot, mission: Mission) -> dict[str, Any]:
    """Return the core's columns of a mission's surroundings: weather, satellite receiver and water."""
    m = mission
    weather = {"tide_east": m.tide[0], "tide_north": m.tide[1], "tide_period": m.tide_period}
    weather |= {"gust_east": m.gust[0], "gust_north": m.gust[1], "gust_depth": m.gust_depth, "gust_time": m.gust_time}
    receiver = {"cold": m.cold, "jump": m.jump, "jump_every": m.jump_every, "honest": m.jump_told}
    return (
        world_columns(robot, sea_of(m), m.gaps)
        | {f"weather.{name}": value for name, value in weather.items()}
        | {f"receiver.{name}": float(value) for name, value in receiver.items()}
    )


def expected(mission: Mission, fastest: float = math.inf) -> float:
    """Return the duration [s] of a mission in still water at its speeds, limited to `fastest` [m/s]."""
    legs = np.hypot(*np.diff(np.array(mission.course), axis=0).T)
    return float((legs / np.minimum(mission.speeds, fastest)).sum())


def fly_part(start: MissionStart, ticks: int, state: bytes | None = None) -> tuple[Part, bytes]:
    """Fly a number of ticks of a mission from a state; return the record and the state at the end."""
    record, end_state = _core.simulate(**start.core, ticks=ticks, state=state)
    return record, end_state


def fly_parts(
    start: MissionStart,
    fly: Callable[[int, int, bytes | None], tuple[Part, bytes]] | None = None,
    ended: Callable[[Part], bool] | None = None,
) -> Iterator[tuple[int, Part]]:
    """Fly part after part until the mission has ended; yield each part with the number of ticks before it.

    fly: replaces `fly_part`; it takes ticks flown, ticks to fly, and the state. ended: returns whether a part was the
    last one; by default, when the pilot has ended the mission.
    """
    length = max(1, round(PART_DURATION / (start.tick * start.every))) * start.every  # whole rows of the record
    state, ticks_done = None, 0
    while ticks_done < start.ticks:
        part_ticks = min(length, start.ticks - ticks_done)
        part, state = fly_part(start, part_ticks, state) if fly is None else fly(ticks_done, part_ticks, state)
        flown = int(part["ticks"][0])
        part["ticks"] = np.array([flown, part_ticks], dtype=np.float64)
        yield ticks_done, part
        ticks_done += flown
        finished = _ended(start, part) if ended is None else ended(part)
        if flown < part_ticks or finished:
            return


def joined_parts(start: MissionStart, parts: Sequence[Part]) -> MissionRun:
    """Join consecutive parts of a mission into a run, cut where the mission ended."""
    rows = [_row_count(start, part) for part in parts]
    diverged = parts[-1]["ticks"][0] < parts[-1]["ticks"][-1]
    names = [name for name in parts[0] if name != "ticks"]
    data = {name: np.concatenate([part[name][:n] for part, n in zip(parts, rows, strict=True)]) for name in names}
    ended = np.flatnonzero([has_ended(mode) for mode in data["mode"]])
    last = int(ended[0]) + 1 if len(ended) else len(data["mode"])
    data = {name: values[:last] for name, values in data.items()}
    status = "diverged" if diverged and not len(ended) else ending(data["mode"][-1], data["reasons"][-1])
    return MissionRun(start, np.arange(last, dtype=np.float64) * start.tick * start.every, data, status)


def has_ended(mode: float) -> bool:
    """Return whether a mode of the pilot ends the mission."""
    return _core.mode_table()[int(mode)][0] in ("done", "ended")


def ending(mode: float, reasons: float) -> str:
    """Return how a mission ended, a key of `ENDINGS`, from the pilot's last mode and reasons."""
    return list(ENDINGS)[_core.ending(int(mode), int(reasons))]


def _row_count(start: MissionStart, part: Part) -> int:
    """Return the number of valid rows of a part: one at least; fewer than in its arrays where the flight diverged."""
    return max(-(-int(part["ticks"][0]) // start.every), 1)


def _ended(start: MissionStart, part: Part) -> bool:
    """Return whether the mission has ended at the end of a part."""
    rows = _row_count(start, part)
    return has_ended(part["mode"][rows - 1])


def _pose(mission: Mission) -> Array:
    """Return the initial pose (9,): position [m], attitude (upright, at the mission's heading), fin angles."""
    attitude = np.array([math.cos(mission.heading / 2), 0.0, 0.0, math.sin(mission.heading / 2)])
    return np.concatenate([[*mission.start, -mission.depth], attitude, [0.0, 0.0]])
