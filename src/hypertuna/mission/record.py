"""Record of a mission: true and estimated motion, commands and decisions, as plain arrays with units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.actuation.hydraulics import drive_names
from hypertuna.arrays import Array
from hypertuna.control.mission import Mission
from hypertuna.description.channels import COUNTED
from hypertuna.description.robot import Robot
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, did_you_mean
from hypertuna.frames import angles_of
from hypertuna.io.quantity import Quantity, key_of, quantity

WINDOW = 1.0  # s: distances are along the nose's path averaged over this time, without the swing of the beat


class Column(NamedTuple):
    """A recorded quantity: dimension in addition to time, unit, meaning, and whether readings may be missing (NaN)."""

    dim: str
    unit: str
    meaning: str
    silent: bool = False  # whether NaN stands for a missing reading


# By dimension whose length does not depend on the robot: names of its parts.
PARTS = {
    "axis": ("x", "y", "z"),
    "quaternion": ("w", "x", "y", "z"),
    "plane": ("x", "y"),
    "fin": ("port", "starboard"),
}
# A record has at least one of these two groups.
TRUE, ESTIMATED = ("position", "attitude"), ("position_estimated", "depth_estimated", "attitude_estimated")

# Quantities of each topic of a log; those of /tf are transforms. Their order is that of messages and CSV columns.
TOPICS: dict[str, dict[str, Column]] = {
    "/tf": {
        "position": Column("axis", "m", "of the nose: east, north, up from the surface"),
        "attitude": Column("quaternion", "1", "from the body (x nose to tail, y starboard, z up) to the world"),
        "attitude_estimated": Column("quaternion", "1", "estimated attitude, from the body to the world"),
    },
    "/motion": {
        "velocity": Column("axis", "m/s", "of the nose through the water, in body axes"),
        "turn_rate": Column("axis", "rad/s", "angular velocity, in body axes"),
    },
    "/estimate": {
        "position_estimated": Column("plane", "m", "estimated position: east, north"),
        "depth_estimated": Column("", "m", "estimated depth of the nose"),
        "speed_estimated": Column("", "m/s", "estimated speed through the water"),
        "current_estimated": Column("plane", "m/s", "estimated current: east, north"),
        "factor_estimated": Column("", "1", "estimated ratio of the speed to that of the gait table"),
        "position_error": Column("", "m", "uncertainty of the estimated position: its standard deviation"),
    },
    "/mode": {
        "mode": Column("", "1", "index in the list of modes"),
        "reasons": Column("", "1", "one bit each in the order of the list of reasons"),
        "leg": Column("", "1", "current waypoint, from 0"),
        "state": Column("", "1", "state of the robot, index in the list of states"),
        "reached": Column("", "1", "waypoints reached so far"),
        "passed": Column("", "1", "waypoints passed without being reached so far"),
        "armed": Column("", "1", "whether the robot is armed"),
        "faults": Column("", "1", "known to the supervisor, one bit each in the order of the list of faults"),
        "answer": Column("", "1", "response to faults: 0 warn, 1 home, 2 surface, 3 disarm, 4 rest"),
    },
    "/joints": {
        "angle_set": Column("joint", "rad", "setpoint of the bend"),
        "angle": Column("joint", "rad", "bend of the joint group, counter-clockwise from above"),
    },
    "/servos": {
        "servo_target": Column("circuit", "rad", "setpoint of the servo angle"),
        "servo_angle": Column("circuit", "rad", "servo angle from neutral"),
        "pulse": Column("servo", "s", "servo pulse without trim"),
    },
    "/hydraulics": {
        "pump_pressure": Column("circuit", "Pa", "gauge pressure in the cylinder"),
        "unit_pressure": Column("circuit", "Pa", "gauge pressure in the drive units"),
    },
    "/fins": {
        "fin_target": Column("fin", "rad", "setpoint of the fin angle, leading edge up positive"),
        "fin": Column("fin", "rad", "fin angle, leading edge up positive"),
    },
    "/command": {
        "frequency_commanded": Column("", "Hz", "beat frequency commanded by the pilot"),
        "amplitude_commanded": Column("joint", "rad", "bend amplitude commanded by the pilot"),
        "lag_commanded": Column("joint", "rad", "lag behind the first joint commanded by the pilot"),
        "bias_commanded": Column("joint", "rad", "mean bend commanded by the pilot"),
        "fin_commanded": Column("fin", "rad", "fin angle commanded by the pilot"),
    },
    "/battery": {
        "battery_voltage": Column("", "V", "at the battery's terminals"),
        "power": Column("", "W", "electrical power of all servos"),
        "energy": Column("", "J", "taken from the battery since the start"),
        "charge": Column("", "C", "taken from the battery"),
        "charge_left": Column("", "1", "remaining fraction of the charge"),
    },
    "/status": {"status": Column("", "1", "flags of the controller's status")},
    "/sensors": {
        c.column: Column(c.per if c.per != "robot" else "axis" if c.size == 3 else "", c.unit, c.meaning, silent=True)
        for c in COUNTED.values()
    },
}
COLUMNS = {name: column for columns in TOPICS.values() for name, column in columns.items()}  # of all topics, by name


@dataclass(frozen=True)
class MissionRecord(Plotted, Tabular):
    """Time series of a mission."""

    name: str  # name of the mission
    robot: str
    mission: Mission  # as flown, with the current and GPS gaps that its seed drew
    time: Array = field(repr=False)  # (T,), increasing [s]
    data: Mapping[str, Array] = field(repr=False)  # by `COLUMNS`, (T,) or (T, parts); at least a pose
    joints: tuple[str, ...] = ()  # names of the joint groups; the tuples below also hold names
    circuits: tuple[str, ...] = ()
    modes: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()
    origin: tuple[float, float] | None = None  # latitude and longitude of x = y = 0 [rad]
    facts: Mapping[str, str] = field(default_factory=dict)  # version, hashes, seed, status
    states: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        time = np.asarray(self.time, float)
        if time.ndim != 1 or not len(time) or not np.isfinite(time).all() or (np.diff(time) <= 0).any():
            raise InputError(
                "must have at least one time, all of them finite and increasing", key="time", fix="give them in s"
            )
        estimated = self.data.keys().isdisjoint(TRUE) and not self.data.keys().isdisjoint(ESTIMATED)
        for name in ESTIMATED if estimated else TRUE:
            if name not in self.data:
                raise InputError("is missing", key=name, fix="record the true or the estimated pose")
        for name, values in self.data.items():
            if name not in COLUMNS:
                raise InputError("is not a known quantity", key=name, fix=did_you_mean(name, COLUMNS))
            parts = parts_of(name, self.joints, self.circuits)
            shape = (len(time), len(parts)) if parts else (len(time),)
            if np.shape(values) != shape:
                value, fix = f"of shape {np.shape(values)}", "give one row per time"
                raise InputError(f"must have the shape {shape}", key=name, value=value, fix=fix)
            if not COLUMNS[name].silent and not np.isfinite(values).all():
                k = int(np.argwhere(~np.isfinite(values))[0][0])
                value, fix = f"not finite at {time[k]:g} s", "end the record before that time"
                raise InputError("must be finite", key=name, value=value, fix=fix)

    def part(self, cut: slice) -> MissionRecord:
        """Return the part of the record in a slice of rows."""
        return replace(self, time=self.time[cut], data={name: values[cut] for name, values in self.data.items()})

    @property
    def true(self) -> bool:
        """Whether the true pose is recorded; otherwise position and attitude are estimates."""
        return "position" in self.data

    @cached_property
    def position(self) -> Array:
        """Position of the nose (T, 3): east, north, up from the surface [m]."""
        if self.true:
            return np.asarray(self.data["position"])
        return np.column_stack([self.data["position_estimated"], -self.data["depth_estimated"]])

    @property
    def attitude(self) -> Array:
        """Attitude (T, 4): quaternion from the body to the world."""
        return np.asarray(self.data["attitude" if self.true else "attitude_estimated"])

    @cached_property
    def angles(self) -> Array:
        """Roll, pitch and heading (T, 3) [rad], starboard down, nose up, clockwise from north."""
        return angles_of(self.attitude)

    def every(self, seconds: float) -> NDArray[np.int64]:
        """Return the indices of rows at an interval in seconds, and of the last row."""
        instants = np.append(np.arange(self.time[0], self.time[-1], seconds), self.time[-1])
        return np.unique(np.searchsorted(self.time, instants))

    @property
    def depth(self) -> Array:
        """Depth of the nose (T,) [m]."""
        return np.asarray(-self.position[:, 2])

    @property
    def estimation_error(self) -> Array:
        """Error of the estimated position (T,) [m]."""
        return np.asarray(np.hypot(*(self.data["position_estimated"] - self.data["position"][:, :2]).T))

    @property
    def first_reasons(self) -> dict[str, float]:
        """Time [s] at which each of the pilot's reasons first held, in order of time."""
        flags = self.data["reasons"].astype(np.int64)
        flags_by_name = {name: flags >> bit & 1 == 1 for bit, name in enumerate(self.reasons)}
        first_times = {name: float(self.time[flag.argmax()]) for name, flag in flags_by_name.items() if flag.any()}
        return dict(sorted(first_times.items(), key=lambda item: item[1]))

    @property
    def metered(self) -> bool:
        """Whether energy or power is recorded."""
        return not self.data.keys().isdisjoint(("energy", "power"))

    @cached_property
    def energy(self) -> Array:
        """Electrical energy since the start (T,) [J]: as recorded, or else `servo_energy`."""
        return np.asarray(self.data["energy"]) if "energy" in self.data else self.servo_energy

    @cached_property
    def servo_energy(self) -> Array:
        """Energy of the servos since the start (T,) [J], integrated from their power by the trapezoidal rule."""
        if "power" not in self.data:
            return np.zeros(len(self.time))
        power = self.data["power"]
        steps = np.diff(self.time) * (power[1:] + power[:-1]) / 2
        return np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def path(self) -> Array:
        """Position of the nose over ground once a second, averaged over that second (seconds, 3) [m]."""
        span = self.time[-1] - self.time[0]
        if span < 2 * WINDOW:
            return np.asarray(self.position[[0, -1]])
        edges = np.unique(np.searchsorted(self.time, np.arange(self.time[0], self.time[-1] + 1e-9, WINDOW)))
        sums = np.add.reduceat(self.position, edges, axis=0)
        return np.asarray(sums / np.diff([*edges, len(self.time)])[:, np.newaxis])

    @property
    def distance(self) -> float:
        """Length of `path` seen from above [m]."""
        return float(np.hypot(*np.diff(self.path[:, :2], axis=0).T).sum())

    @property
    def mean_speed(self) -> float:
        """Mean speed along `path`, seen from above [m/s]."""
        span = float(self.time[-1] - self.time[0])
        return self.distance / span if span else 0.0

    @property
    def mode_at_end(self) -> str | int | None:
        """Name of the pilot's last mode, or its number without a name; None if modes are not recorded."""
        if "mode" not in self.data:
            return None
        mode = int(self.data["mode"][-1])
        return self.modes[mode] if 0 <= mode < len(self.modes) else mode

    def summary(self) -> dict[str, Quantity]:
        """Return the record's extent and main numbers by their keys in the JSON object."""
        numbers = {
            "begin": (self.time[0], "s", None),
            "end": (self.time[-1], "s", None),
            "distance": (self.distance, "m", "over ground"),
            "mean_speed": (self.mean_speed, "m/s", "over ground"),
            "depth_max": (self.depth.max(), "m", ""),
        }
        if self.metered:
            numbers["energy"] = (self.energy[-1], "Wh", "")
        if "charge_left" in self.data:
            numbers["charge_left"] = (self.data["charge_left"][-1], "", "part of the whole")
        if self.true and "position_estimated" in self.data:
            numbers["estimation_error_max"] = (self.estimation_error.max(), "m", "of the position")
        names = {"mission": self.name, "robot": self.robot, "times": len(self.time)}
        facts = {name: Quantity(value, "", None) for name, value in names.items()}
        shown = {
            key_of(name, unit): quantity(name, float(value), unit, note)
            for name, (value, unit, note) in numbers.items()
        }
        mode = self.mode_at_end
        return facts | shown | ({} if mode is None else {"mode_at_end": quantity("mode_at_end", mode)})


def parts_of(name: str, joints: tuple[str, ...], circuits: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of a quantity's parts, such as the joints; none for a single number."""
    dim = COLUMNS[name].dim
    servos = (*circuits, *(f"fin-{side}" for side in PARTS["fin"]))
    return {"joint": joints, "circuit": circuits, "servo": servos}.get(dim, PARTS.get(dim, ()))


def names_of(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Return the names of joints, circuits, modes and flags in a robot's records, by fields of `MissionRecord`."""
    joints = tuple(group.name for group in robot.joints)
    return {
        "joints": joints,
        "circuits": tuple(name or f"{joints[circuit // 2]}-unused" for circuit, name in enumerate(drive_names(robot))),
        "modes": tuple(row[0] for row in _core.mode_table()),
        "reasons": tuple(row[0] for row in _core.reason_table()),
        "states": tuple(row[0] for row in _core.state_table()),
        "faults": tuple(row[0] for row in _core.fault_table()),
    }


def joined(records: Sequence[MissionRecord]) -> MissionRecord:
    """Join records that follow each other in time into one."""
    first, last = records[0], records[-1]
    data = {name: np.concatenate([part.data[name] for part in records]) for name in first.data}
    time = np.concatenate([part.time for part in records])
    return replace(first, time=time, data=data, facts=last.facts)
