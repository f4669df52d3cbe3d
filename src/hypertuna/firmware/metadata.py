"""Descriptions of the parameters for ground stations: files of the component metadata service, kept in the firmware.

mavlink.io/en/services/component_information.html. The robot serves both files (firmware/app/radio/files.hpp).
"""

import json
import lzma
import zlib
from typing import Any, NamedTuple

from hypertuna.firmware.parameters import TABLES, FirmwareTable, Parameter

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
