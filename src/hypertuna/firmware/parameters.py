"""Numbers of the firmware from a robot's description, and those that may be set over the radio.

The numbers of controller, pilot, calibration and limits are one row, in the order of visit_fields
(firmware/app/vehicle/parameters.hpp). A parameter is a number of that row with a name and a range.
"""

import itertools
import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.actuation.hydraulics import drive_names
from hypertuna.control.controller import controller_columns, sensor_range
from hypertuna.control.guidance import GaitTable, gait_table, pilot_columns
from hypertuna.control.sensors import sensor_absent
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.channels import ANALOG, COUNTED
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.firmware import Firmware
from hypertuna.description.schema.firmware import wired as channel_wired
from hypertuna.errors import InputError

Array = NDArray[np.float32]

CONVERTER = 65536  # counts of the analog converter's range
SIGNED = 32768  # counts of the upper end of a digital sensor's range
PASCALS = 10.0  # per count of the depth sensor
NAME_LENGTH_MAX = 16  # characters of a name in MAVLink
TRIM = 2e-4  # maximum correction of a servo's pulse [s]
OFFSET = SIGNED / 100  # maximum correction of an axis of gyroscope or accelerometer [counts]

Field = tuple[str, str, int]  # part, column, index


class Parameter(NamedTuple):
    """A number that the radio may read and set."""

    name: str  # at most 16 characters
    low: float  # range [SI]
    high: float
    standard: float  # value of the description [SI]
    whole: bool  # a whole number
    field: int  # index in the row of all numbers


@dataclass(frozen=True)
class FirmwareTable:
    """All numbers of the firmware of a robot."""

    robot: Robot
    gaits: int  # in the gait table
    fields: tuple[Field, ...]  # part, column and index of every number
    values: Array  # (len(fields),) [SI]
    parameters: tuple[Parameter, ...]

    @property
    def layout(self) -> int:
        """Checksum of the parameters' names and indices: a stored set of another layout is ignored."""
        return zlib.crc32("\n".join(f"{p.name} {p.field}" for p in self.parameters).encode())

    def column(self, name: str) -> Array:
        """Return all numbers of a column of the calibration or the limits."""
        return self.values[[k for k, (_, column, _) in enumerate(self.fields) if column == name]]


class _Rule(NamedTuple):
    """Parameters of a column: their range as fractions of their value, or as bounds [SI]."""

    part: str
    name: str
    low: float = 0.5
    high: float = 2.0
    bounds: bool = False
    whole: bool = False
    column: str = ""  # if it has another name


PILOT = (  # columns of the pilot that may be set
    "heading_rate", "heading_integral", "rate_gain", "turn_max", "curvature", "lookahead", "depth_lookahead",
    "depth_integral", "climb_lead", "climb_gain", "pitch_damping", "speed_min", "surface_depth", "fence_margin",
    "error_max", "fix_timeout",
)  # fmt: skip

# Over the radio a limit may only become tighter, and a gain may be halved or doubled.
RULES = (
    _Rule("controller", "learning", 0.0, 1.0, bounds=True),
    _Rule("controller", "amplitude", 0.0, 1.0),
    _Rule("controller", "pressure_work", 0.5, 1.0),
    _Rule("controller", "pressure_soft", 0.5, 1.0),
    _Rule("controller", "pressure_hard", 0.5, 1.0),
    _Rule("controller", "frequency_max", 0.1, 1.0),
    _Rule("controller", "fin_max", 0.0, 1.0),
    _Rule("controller", "voltage_low", 1.0, 1.2),
    _Rule("controller", "timeout_ticks", 0.2, 1.0, whole=True, column="timeout"),
    _Rule("controller", "pulse_center", 0.9, 1.1),
    _Rule("controller", "pulse_per_rad", 0.8, 1.25),
    _Rule("controller", "pulse_min", 1.0, 1.5),
    _Rule("controller", "pulse_max", 0.75, 1.0),
    _Rule("controller", "slew", 0.1, 1.0),
    *(_Rule("pilot", name) for name in PILOT),
    *itertools.chain.from_iterable(
        (
            _Rule("calibration", f"{name}_zero", -CONVERTER, CONVERTER, bounds=True),
            _Rule("calibration", f"{name}_scale", 0.25, 4.0),
        )
        for name in ANALOG
    ),
    _Rule("calibration", "rate_zero", -OFFSET, OFFSET, bounds=True),
    _Rule("calibration", "rate_scale", 0.9, 1.1),
    _Rule("calibration", "accel_zero", -OFFSET, OFFSET, bounds=True, column="acceleration_zero"),
    _Rule("calibration", "accel_scale", 0.9, 1.1, column="acceleration_scale"),
    _Rule("calibration", "depth_zero", 0.8, 1.2),
    _Rule("calibration", "depth_scale", 0.9, 1.1),
    _Rule("calibration", "field_zero", -SIGNED, SIGNED, bounds=True),
    _Rule("calibration", "field_scale", 0.1, 200.0),  # counts of a compass depend on its chip
    _Rule("calibration", "servo_trim", -TRIM, TRIM, bounds=True),
    _Rule("limits", "manual_timeout", 0.1, 1.0),
    _Rule("limits", "link_timeout", 0.2, 2.0),
    _Rule("limits", "home_timeout", 0.2, 10.0),
    _Rule("limits", "voltage_empty", 1.0, 1.2),
    _Rule("limits", "tilt_max", 0.5, 1.0),
    _Rule("limits", "rise_depth", 0.2, 4.0),
    _Rule("limits", "depth_max", 0.05, 1.0),
    _Rule("limits", "link_rate", 300.0, 115200.0, bounds=True),
    _Rule("limits", "link_share", 0.05, 1.0, bounds=True),
    _Rule("limits", "system_id", 1, 250, bounds=True, whole=True),
    _Rule("limits", "sign", 0, 1, bounds=True, whole=True),
)
LIMITS = (  # of the supervisor, in the order of firmware/app/vehicle/parameters.hpp
    "manual_timeout", "link_timeout", "home_timeout", "voltage_empty", "voltage_after", "tilt_max", "tilt_after",
    "leak_after", "rise_depth", "depth_max", "link_rate", "link_share", "system_id", "sign",
)  # fmt: skip


def firmware_table(robot: Robot, table: GaitTable | None = None) -> FirmwareTable:
    """Compute the numbers of a robot's firmware; needs the tables of controller, pilot, sensors and [firmware]."""
    require_at_sea(robot, "battery", "controller", "guidance", "firmware")
    wired = require(robot.firmware, "firmware", robot)
    table = gait_table(robot) if table is None else table
    columns = {
        "controller": controller_columns(robot),
        "pilot": pilot_columns(robot, table),
        "calibration": _calibration(robot, wired),
        "limits": {name: [float(getattr(wired, name, 0.0))] for name in LIMITS},  # no key: messages need no signature
    }
    columns["limits"]["tilt_max"] = [math.sin(min(wired.tilt_max, math.pi / 2))]
    gaits = len(table.gaits)
    fields = [*_core.pilot_fields(len(robot.joints), gaits)]
    for part in ("calibration", "limits"):
        fields += [(part, name, k) for name, values in columns[part].items() for k in range(len(values))]
    values = np.array([columns[part][name][k] for part, name, k in fields], dtype=np.float32)
    return FirmwareTable(robot, gaits, tuple(fields), values, _parameters(fields, values))


def _calibration(robot: Robot, wired: Firmware) -> dict[str, list[float]]:
    """Compute zero [counts] and scale [SI per count] of every channel from the ranges of its sensors."""
    joints = len(robot.joints)
    columns: dict[str, list[float]] = {}
    for name, channel in COUNTED.items():
        if sensor_absent(robot, name):
            zero, scale = 0.0, 1.0
        elif channel.converter == "analog":
            low, high = sensor_range(robot, name)
            scale = (high - low) / (CONVERTER * (wired.analog_high - wired.analog_low))
            zero = CONVERTER * wired.analog_low - low / scale
        elif name == "depth":
            zero, scale = _core.ATMOSPHERE / PASCALS, PASCALS / (robot.water.density * _core.GRAVITY)
        else:
            zero, scale = 0.0, sensor_range(robot, name)[1] / SIGNED
        count = channel.count(joints)
        columns |= {f"{name}_zero": [zero] * count, f"{name}_scale": [scale] * count}
    columns["servo_trim"] = [0.0] * (2 * joints + 2)
    return columns


def _parameters(fields: list[Field], values: Array) -> tuple[Parameter, ...]:
    """Return the numbers that the radio may set, with their ranges."""
    parameters = []
    for rule in RULES:
        column = rule.part, rule.column or rule.name
        places = [k for k, field in enumerate(fields) if field[:2] == column]
        for place in places:
            name = rule.name if len(places) == 1 else f"{rule.name}_{fields[place][2]}"
            value = float(values[place])
            ends = (rule.low, rule.high) if rule.bounds else (rule.low * value, rule.high * value)
            low, high = np.float32(min(ends)), np.float32(max(ends))
            parameters.append(Parameter(name, float(low), float(high), value, rule.whole, place))
            if len(name) > NAME_LENGTH_MAX or not low <= value <= high:
                bounds = f"must fit a parameter of {NAME_LENGTH_MAX} characters within {low:g} to {high:g}"
                raise InputError(bounds, key=name, value=f"{value:g}", fix="correct the robot's description")
    return tuple(parameters)


def pins_of(robot: Robot) -> dict[str, list[int]]:
    """Return the pins of the servos and of every analog sensor by their places, -1 where nothing is wired."""
    wired = require(robot.firmware, "firmware", robot)
    direct = [group.direct for group in robot.joints]
    sensors = {sensor.quantity for sensor in robot.sensors if sensor.quantity is not None}
    pins = {"servo": _placed(wired.servo_pins, [*map(bool, drive_names(robot)), True, True])}
    return pins | {name: _placed(wired.analog_pins(name), channel_wired(name, direct, sensors)) for name in ANALOG}


def _placed(pins: Sequence[int], there: Sequence[bool]) -> list[int]:
    """Return the pin of each place, -1 where nothing is wired."""
    given = iter(pins)
    return [next(given) if here else -1 for here in there]
