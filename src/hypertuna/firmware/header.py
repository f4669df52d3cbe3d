"""C++ header of a robot, firmware/robots/NAME.hpp: numbers, parameters with their descriptions, and wiring."""

import json
import lzma
import zlib
from typing import Any, NamedTuple

import numpy as np

from hypertuna.control.sensors import sensor_of
from hypertuna.description.channels import ANALOG
from hypertuna.description.robot import require
from hypertuna.firmware.parameters import TABLES, FirmwareTable, Parameter, pins_of

GENERAL, PARAMETERS = "general.json", "parameters.json.xz"  # names in firmware/app/radio/files.hpp
# Unit of a key in a robot's file -> SI unit on board.
SI = {"deg": "rad", "deg/s": "rad/s", "us": "s", "us/rad": "s/rad"}
TEXTS = {  # parameter or column that is no key of a robot's file -> its text and SI unit
    "amplitude": ("largest amplitude of joint", "rad"),
    "curvature": ("curvature of the path at the largest bias of the tail", "1/m"),
    "sign": ("1: messages must be signed", ""),
    "servo_trim": ("time added to the pulse of servo", "s"),
    "timeout_ticks": ("time without a command after which the tail rests, in ticks of the controller", ""),
    "tilt_max": ("sine of roll or pitch beyond which the tail rests", ""),
}
DIGITS = 6  # significant digits: the last bits of a fit differ from machine to machine


def header(table: FirmwareTable) -> str:
    """Return the C++ header firmware/robots/NAME.hpp of a robot."""
    import jinja2

    robot = table.robot
    wired = require(robot.firmware, "firmware", robot)
    parts = pins_of(robot)
    analog = [pin for name in ANALOG for pin in parts[name]]  # in the order of the channels
    pins = {"servo": parts["servo"], "analog": analog, "leak": (wired.leak_pin,), "recovery": (wired.recovery_pin,)}
    loader = jinja2.PackageLoader("hypertuna.firmware")
    environment = jinja2.Environment(loader=loader, trim_blocks=True, keep_trailing_newline=True)
    environment.filters["literal"] = _literal
    period = require(sensor_of(robot, "position").period, "sensors.period_s", robot)
    return environment.get_template("robot.hpp.j2").render(
        table=table, robot=robot, wired=wired, pins=pins, fix_ms=round(1000 * period), files=metadata(table)
    )


def _literal(value: float) -> str:
    """Return a float literal of the same 32 bits in C++."""
    text = str(np.float32(value))
    return f"{text}f" if any(c in text for c in ".e") else f"{text}.0f"


class File(NamedTuple):
    """A file that the robot serves."""

    name: str
    content: bytes

    @property
    def crc(self) -> int:
        """CRC-32 as MAVLink's file transfer computes it: from zero, not inverted."""
        return zlib.crc32(self.content, 0xFFFFFFFF) ^ 0xFFFFFFFF


def metadata(table: FirmwareTable) -> tuple[File, File]:
    """Return the general file, and that of the parameters that it names."""
    text = json.dumps({"version": 1, "parameters": [_entry(table, p) for p in table.parameters]})
    compressed = lzma.compress(text.encode(), check=lzma.CHECK_CRC32, preset=9 | lzma.PRESET_EXTREME)
    parameters = File(PARAMETERS, compressed)
    types = [{"type": 1, "uri": f"mftp://{PARAMETERS}", "fileCrc": parameters.crc}]
    general = json.dumps({"version": 1, "metadataTypes": types}, separators=(",", ":"))
    return File(GENERAL, general.encode()), parameters


def _entry(table: FirmwareTable, parameter: Parameter) -> dict[str, Any]:
    """Return a parameter's entry in the file of parameters, as MAVLink defines it."""
    part, column, index = table.fields[parameter.field]
    number = f" {index}" if parameter.name.endswith(f"_{index}") else ""
    text, unit = describe(part, column, parameter.name)
    numbers = {"min": parameter.low, "max": parameter.high, "default": parameter.standard}
    base = {"name": parameter.name.upper(), "type": "Float", "group": part.capitalize(), "shortDesc": f"{text}{number}"}
    return (
        base | {key: float(f"{value:.{DIGITS}g}") for key, value in numbers.items()} | ({"units": unit} if unit else {})
    )


def describe(part: str, column: str, name: str) -> tuple[str, str]:
    """Return text and SI unit of a parameter: those of its key in a robot's file, where it has one."""
    stated = TEXTS.get(name) or TEXTS.get(column)
    if stated is not None:
        return stated
    if part == "calibration":
        sensor, kind = column.rsplit("_", 1)
        return (f"counts at zero of {sensor}", "") if kind == "zero" else (f"SI units per count of {sensor}", "")
    field = TABLES[part].model_fields[column]
    extra = field.json_schema_extra
    unit = str(extra["unit"]) if isinstance(extra, dict) else ""
    return str(field.description), SI.get(unit, unit)
