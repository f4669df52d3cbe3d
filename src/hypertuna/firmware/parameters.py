"""Numbers of the firmware from a robot's description, and the parameters among them, which the radio may set.

The numbers of controller, pilot, calibration and limits are one row, in the order of visit_fields
(firmware/app/vehicle/parameters.hpp). A parameter is a number of that row with a name and a range.
"""

import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.actuation.hydraulics import drive_names
from hypertuna.control.controller import controller_columns, given_constants, sensor_range
from hypertuna.control.guidance import gait_table, pilot_columns
from hypertuna.control.sensors import sensor_absent
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.channels import ANALOG, COUNTED
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.base import Part, Radio
from hypertuna.description.schema.control import Controller, Guidance
from hypertuna.description.schema.firmware import Firmware
from hypertuna.description.schema.firmware import wired as channel_wired
from hypertuna.errors import InputError

Array = NDArray[np.float32]

CONVERTER = 65536  # counts of the analog converter's range
SIGNED = 32768  # counts of the upper end of a digital sensor's range
PASCALS = 10.0  # Pa per count of the depth sensor
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


ANALOG_RANGES = {"zero": Radio(0, -CONVERTER, CONVERTER, bounds=True), "scale": Radio(0, 0.25, 4.0)}
# Part -> its table in a robot's file.
TABLES: dict[str, type[Part]] = {"controller": Controller, "pilot": Guidance, "limits": Firmware}
EXTRA = {  # part -> column -> range of parameters that are no keys of a robot's file
    "controller": {"amplitude": Radio(2, 0.0, 1.0)},
    "pilot": {"curvature": Radio(5)},
    "calibration": {
        **{f"{name}_{column}": radio for name in ANALOG for column, radio in ANALOG_RANGES.items()},
        "rate_zero": Radio(0, -OFFSET, OFFSET, bounds=True),
        "rate_scale": Radio(0, 0.9, 1.1),
        "acceleration_zero": Radio(0, -OFFSET, OFFSET, bounds=True, name="accel_zero"),
        "acceleration_scale": Radio(0, 0.9, 1.1, name="accel_scale"),
        "depth_zero": Radio(0, 0.8, 1.2),
        "depth_scale": Radio(0, 0.9, 1.1),
        "field_zero": Radio(0, -SIGNED, SIGNED, bounds=True),
        "field_scale": Radio(0, 0.1, 200.0),  # counts of a compass depend on its chip
        "servo_trim": Radio(0, -TRIM, TRIM, bounds=True),
    },
    "limits": {"sign": Radio(11, 0, 1, bounds=True, whole=True)},
}


def firmware_table(robot: Robot) -> FirmwareTable:
    """Return the numbers of a robot's firmware; needs the tables of controller, pilot, sensors and [firmware]."""
    require_at_sea(robot, "battery", "controller", "guidance", "firmware")
    firmware, table = require(robot.firmware, "firmware", robot), gait_table(robot)
    columns = {
        "controller": controller_columns(robot),
        "pilot": pilot_columns(robot, table),
        "calibration": _calibration(robot, firmware),
        "limits": {name: [value] for name, value in given_constants("limits", firmware).items()},
    }
    columns["limits"] |= {"tilt_max": [math.sin(min(firmware.tilt_max, math.pi / 2))], "sign": [0.0]}
    gaits, part_order = len(table.gaits), list(columns)
    fields = [field for field in _core.onboard_fields(len(robot.joints), gaits) if field[0] in columns]
    fields += [("calibration", name, k) for name, row in columns["calibration"].items() for k in range(len(row))]
    fields.sort(key=lambda field: part_order.index(field[0]))
    values = np.array([columns[part][name][k] for part, name, k in fields], dtype=np.float32)
    return FirmwareTable(robot, gaits, tuple(fields), values, _parameters(fields, values))


def _calibration(robot: Robot, wired: Firmware) -> dict[str, list[float]]:
    """Return zero [counts] and scale [SI per count] of every channel, from the ranges of its sensors."""
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


def _settable() -> Iterator[tuple[str, str, Radio]]:
    """Yield part, column and range of the numbers that the radio may set, in the order of the parameters."""
    for part, extra in EXTRA.items():
        keys = TABLES[part].declared if part in TABLES else {}
        columns = {name: key.radio for name, key in keys.items() if key.radio is not None} | extra
        for column, radio in sorted(columns.items(), key=lambda one: one[1].place):
            yield part, column, radio


def _parameters(fields: list[Field], values: Array) -> tuple[Parameter, ...]:
    """Return the numbers that the radio may set, with their ranges."""
    parameters = []
    for part, column, radio in _settable():
        indices = [k for k, field in enumerate(fields) if field[:2] == (part, column)]
        for index in indices:
            name = radio.name or column
            name = name if len(indices) == 1 else f"{name}_{fields[index][2]}"
            value = float(values[index])
            limits = (radio.low, radio.high) if radio.bounds else (radio.low * value, radio.high * value)
            low, high = np.float32(min(limits)), np.float32(max(limits))
            parameters.append(Parameter(name, float(low), float(high), value, radio.whole, index))
            if len(name) > NAME_LENGTH_MAX or not low <= value <= high:
                bounds = f"must fit a parameter of {NAME_LENGTH_MAX} characters within {low:g} to {high:g}"
                raise InputError(bounds, key=name, value=f"{value:g}", fix="correct the robot's description")
    return tuple(parameters)


def pins_of(robot: Robot) -> dict[str, list[int]]:
    """Return the pins of the servos and of every analog sensor by their places, -1 where nothing is wired."""
    table = require(robot.firmware, "firmware", robot)
    drives = [group.drive for group in robot.joints]
    sensors = {sensor.quantity for sensor in robot.sensors if sensor.quantity is not None}
    pins = {"servo": _placed(table.servo_pins, [*map(bool, drive_names(robot)), True, True])}
    return pins | {name: _placed(table.analog_pins(name), channel_wired(name, drives, sensors)) for name in ANALOG}


def _placed(pins: Sequence[int], wired: Sequence[bool]) -> list[int]:
    """Return the pin of each place, -1 where nothing is wired."""
    remaining = iter(pins)
    return [next(remaining) if used else -1 for used in wired]
