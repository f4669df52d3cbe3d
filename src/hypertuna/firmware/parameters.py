"""What a robot's description makes of the firmware: every number on board, and which of them the radio may set.

The firmware takes all numbers of controller, pilot, calibration and limits from one row, in the order that
firmware/app/vehicle/parameters.hpp visits them in; a parameter is a number of that row with a name and a range.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.control.controller import controller_columns, sensor_range
from hypertuna.control.guidance import GaitTable, gait_table, pilot_columns
from hypertuna.description.channels import ANALOG, COUNTED
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.firmware import Firmware
from hypertuna.errors import InputError

__all__ = ["FirmwareTable", "Parameter", "firmware_table", "header"]

Array = NDArray[np.float32]

CONVERTER = 65536  # counts of the analog converter's range
SIGNED = 32768  # counts of the upper end of a digital sensor's range
PASCALS = 10.0  # per count of the depth sensor
ATMOSPHERE = 101325.0  # Pa above the water
GRAVITY = 9.81  # m/s^2
MOST_NAME = 16  # characters of a parameter in MAVLink
MOST_PARAMETERS = 96  # firmware/app/vehicle/parameters.hpp
TRIM = 2e-4  # s: largest correction of a servo's pulse

Field = tuple[str, str, int]  # part, column, index


class Parameter(NamedTuple):
    """A number that the radio may read and set."""

    name: str  # At most 16 characters
    low: float  # Range, and the value of the robot's description [SI]
    high: float
    standard: float
    whole: bool  # Whether it is a whole number
    field: int  # Its place in the row of all numbers


@dataclass(frozen=True)
class FirmwareTable:
    """All that the firmware takes from a robot's description."""

    robot: Robot
    gaits: int  # Of its gait table
    fields: tuple[Field, ...]  # Part, column and index of every number on board
    values: Array  # (len(fields) The numbers [SI]
    parameters: tuple[Parameter, ...]

    @property
    def layout(self) -> int:
        """Checksum of the parameters' names and places: a set that was stored under another one is not taken."""
        return zlib.crc32("\n".join(f"{p.name} {p.field}" for p in self.parameters).encode())

    def column(self, name: str) -> Array:
        """Return all numbers of a column of the calibration or the limits."""
        found = [k for k, (_, column, _) in enumerate(self.fields) if column == name]
        return self.values[found]


class _Rule(NamedTuple):
    """A parameter of a column: its range as parts of its value, or as bounds [SI]."""

    name: str
    part: str
    column: str
    low: float = 0.5
    high: float = 2.0
    bounds: bool = False
    whole: bool = False


# A limit may be made tighter over the radio, never looser; a gain halved or doubled; a calibration is what it is.
RULES = (
    _Rule("proportional", "controller", "proportional", 0.0, 1.0, bounds=True),
    _Rule("integral", "controller", "integral", 0.0, 2.0, bounds=True),
    _Rule("derivative", "controller", "derivative", 0.0, 1.0, bounds=True),
    _Rule("peak_smoothing", "controller", "peak_smoothing"),
    _Rule("amplitude", "controller", "amplitude", 0.0, 1.0),
    _Rule("pressure_soft", "controller", "pressure_soft", 0.5, 1.0),
    _Rule("pressure_hard", "controller", "pressure_hard", 0.5, 1.0),
    _Rule("frequency_max", "controller", "frequency_most", 0.1, 1.0),
    _Rule("fin_max", "controller", "fin_most", 0.0, 1.0),
    _Rule("voltage_low", "controller", "voltage_low", 1.0, 1.2),
    _Rule("timeout_ticks", "controller", "timeout", 0.2, 1.0, whole=True),
    _Rule("pulse_center", "controller", "pulse_center", 0.9, 1.1),
    _Rule("pulse_per_rad", "controller", "pulse_per_rad", 0.8, 1.25),
    _Rule("pulse_min", "controller", "pulse_least", 1.0, 1.5),
    _Rule("pulse_max", "controller", "pulse_most", 0.75, 1.0),
    _Rule("slew", "controller", "slew", 0.1, 1.0),
    *(
        _Rule(name.replace("_most", "_max").replace("_least", "_min"), "pilot", name)
        for name in [
            "heading_rate",
            "heading_integral",
            "rate_gain",
            "turn_most",
            "curvature",
            "lookahead",
            "depth_lookahead",
            "depth_integral",
            "climb_lead",
            "climb_gain",
            "pitch_damping",
            "speed_least",
            "surface_depth",
            "fence_margin",
            "error_most",
            "fix_timeout",
        ]
    ),
    *(
        rule
        for name in ANALOG
        for rule in (
            _Rule(f"{name}_zero", "calibration", f"{name}_zero", -CONVERTER, CONVERTER, bounds=True),
            _Rule(f"{name}_scale", "calibration", f"{name}_scale"),
        )
    ),
    _Rule("depth_zero", "calibration", "depth_zero", 0.8, 1.2),
    _Rule("field_zero", "calibration", "field_zero", -SIGNED, SIGNED, bounds=True),
    _Rule("field_scale", "calibration", "field_scale"),
    _Rule("servo_trim", "calibration", "servo_trim", -TRIM, TRIM, bounds=True),
    _Rule("manual_timeout", "limits", "manual_timeout", 0.1, 1.0),
    _Rule("link_timeout", "limits", "link_timeout", 0.2, 2.0),
    _Rule("home_timeout", "limits", "home_timeout", 0.2, 10.0),
    _Rule("voltage_empty", "limits", "voltage_empty", 1.0, 1.2),
    _Rule("tilt_max", "limits", "tilt_max", 0.5, 1.0),
    _Rule("rise_depth", "limits", "rise_depth", 0.2, 4.0),
    _Rule("link_rate", "limits", "link_rate", 300.0, 115200.0, bounds=True),
    _Rule("link_share", "limits", "link_share", 0.05, 1.0, bounds=True),
    _Rule("system_id", "limits", "system_id", 1, 250, bounds=True, whole=True),
    _Rule("sign", "limits", "sign", 0, 1, bounds=True, whole=True),
)


def firmware_table(robot: Robot, table: GaitTable | None = None) -> FirmwareTable:
    """Compute what the firmware of a robot is made with: `robot` [firmware]."""
    wired = require(robot.firmware, "firmware", robot)
    table = gait_table(robot) if table is None else table
    columns = {
        "controller": controller_columns(robot),
        "pilot": pilot_columns(robot, table),
        "calibration": _calibration(robot, wired),
        "limits": _limits(wired),
    }
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
        if channel.converter == "analog":
            low, high = sensor_range(robot, name)
            scale = (high - low) / (CONVERTER * (wired.analog_high - wired.analog_low))
            zero = CONVERTER * wired.analog_low - low / scale
        elif name == "depth":
            zero, scale = ATMOSPHERE / PASCALS, PASCALS / (robot.water.density * GRAVITY)
        else:
            zero, scale = 0.0, sensor_range(robot, name)[1] / SIGNED
        count = channel.count(joints)
        columns |= {f"{name}_zero": [zero] * count, f"{name}_scale": [scale] * count}
    columns["servo_trim"] = [0.0] * (2 * joints + 2)
    return columns


def _limits(wired: Firmware) -> dict[str, list[float]]:
    """Return what the supervisor goes by, in the order of firmware/app/vehicle/parameters.hpp."""
    values = {
        "manual_timeout": wired.manual_timeout,
        "link_timeout": wired.link_timeout,
        "home_timeout": wired.home_timeout,
        "voltage_empty": wired.voltage_empty,
        "voltage_after": wired.voltage_after,
        "tilt_max": math.sin(min(wired.tilt_max, math.pi / 2)),
        "tilt_after": wired.tilt_after,
        "leak_after": wired.leak_after,
        "rise_depth": wired.rise_depth,
        "link_rate": wired.link_rate,
        "link_share": wired.link_share,
        "system_id": wired.system_id,
        "sign": 0.0,
    }
    return {name: [float(value)] for name, value in values.items()}


def _parameters(fields: list[Field], values: Array) -> tuple[Parameter, ...]:
    """Find the numbers that the radio may set, with their ranges."""
    parameters = []
    for rule in RULES:
        places = [k for k, (part, column, _) in enumerate(fields) if (part, column) == (rule.part, rule.column)]
        for place in places:
            name = rule.name if len(places) == 1 else f"{rule.name}_{fields[place][2]}"
            value = float(values[place])
            ends = (rule.low, rule.high) if rule.bounds else (rule.low * value, rule.high * value)
            low, high = np.float32(min(ends)), np.float32(max(ends))
            parameters.append(Parameter(name, float(low), float(high), value, rule.whole, place))
            if len(name) > MOST_NAME or not low <= value <= high:
                rule_ = f"must fit a parameter of {MOST_NAME} characters within {low:g} to {high:g}"
                raise InputError(rule_, key=name, value=f"{value:g}", fix="correct the robot's description")
    if len(parameters) > MOST_PARAMETERS:
        raise InputError(
            f"must make at most {MOST_PARAMETERS} parameters",
            key="joints",
            value=f"{len(parameters)}",
            fix="raise max_parameters of firmware/app/vehicle/parameters.hpp and MOST_PARAMETERS",
        )
    return tuple(parameters)


def header(table: FirmwareTable) -> str:
    """Write a robot's table as the C++ header that the firmware is compiled with."""
    robot = table.robot
    wired = require(robot.firmware, "firmware", robot)
    lines = [
        f"/// {robot.name}: written by `hypertuna firmware params` from its description. Do not edit.",
        "#pragma once",
        "",
        '#include "app/vehicle/parameters.hpp"',
        "",
        "// clang-format off",
        "namespace hypertuna::firmware::robot {",
        "",
        "inline constexpr float values[] = {",
    ]
    for (part, name, k), value in zip(table.fields, table.values, strict=True):
        lines.append(f"    {_literal(value)},  // {part} {name}[{k}]")
    lines += ["};", "", "inline constexpr ParameterInfo parameters[] = {"]
    for p in table.parameters:
        numbers = ", ".join(_literal(x) for x in (p.low, p.high, p.standard))
        lines.append(f'    {{"{p.name}", {numbers}, {"true" if p.whole else "false"}, {p.field}}},')
    lines += [
        "};",
        "",
        "inline constexpr Description description = {",
        f'    "{robot.name}", {len(robot.joints)}, {table.gaits}, values, {len(table.values)}, parameters, '
        f"{len(table.parameters)}, {table.layout:#010x}}};",
        "",
        "inline constexpr struct {",
        *(f"    int {name}[{len(pins)}];" for name, pins in _pins(wired).items()),
        "    int imu_serial, position_serial, radio_serial, radio_baud;",
        "    float watchdog;  // s",
        "} wiring = {",
        *(f"    {{{', '.join(map(str, pins))}}}," for pins in _pins(wired).values()),
        f"    {wired.imu_serial}, {wired.position_serial}, {wired.radio_serial}, {wired.radio_baud},",
        f"    {_literal(wired.watchdog)},",
        "};",
        "",
        "}  // namespace hypertuna::firmware::robot",
        "// clang-format on",
        "",
    ]
    return "\n".join(lines)


def _pins(wired: Firmware) -> dict[str, tuple[int, ...]]:
    """Return the pins by what is wired to them; analog pins in the order of the channels."""
    analog = tuple(pin for name in ANALOG for pin in wired.analog_pins(name))
    return {"servo": wired.servo_pins, "analog": analog, "leak": (wired.leak_pin,)}


def _literal(value: float) -> str:
    """Spell a number so that C++ reads the same 32 bits."""
    text = str(np.float32(value))
    return f"{text}f" if any(c in text for c in ".e") else f"{text}.0f"
