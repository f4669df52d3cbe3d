"""Generate code from the MAVLink dialect, and the dialect's enumerations from the tables of the firmware.

`generate.py DIALECT.xml C|Python3 OUTPUT` writes C headers or a Python module.
`generate.py DIALECT.xml enums` rewrites the enumerations of DIALECT.xml from the C++ tables bound to hypertuna._core.
"""

import contextlib
import io
import re
import shutil
import sys
import tempfile
import textwrap
import warnings
from pathlib import Path
from xml.sax.saxutils import escape

INCLUDED = ("common.xml", "standard.xml", "minimal.xml")
ENUMS = re.compile(r'(?<=  <enums>\n).*(?=    <enum name="MAV_CMD">)', re.DOTALL)  # all before MAV_CMD
WIDTH = 115  # characters of a line
# Fields of the standard dialect behind those of pymavlink's common.xml: numbers that tell whether a plan has changed.
NEWER_FIELDS = {
    "MISSION_CURRENT": ("mission_id", "fence_id", "rally_points_id"),
    "MISSION_COUNT": ("opaque_id",),
    "MISSION_ACK": ("opaque_id",),
}


def generate(dialect: str | Path, language: str, output: str | Path) -> None:
    """Run mavgen ("C" into a folder, or "Python3" into a file) on a dialect that includes common.xml."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import pymavlink.dialects.v20
        from pymavlink.generator import mavgen, mavparse
    with tempfile.TemporaryDirectory() as folder:
        for name in INCLUDED:  # mavgen expects them beside the dialect
            shutil.copy(Path(pymavlink.dialects.v20.__path__[0]) / name, folder)
        common = Path(folder) / "common.xml"
        common.write_text(_extended(common.read_text(encoding="utf-8")), encoding="utf-8")
        source = shutil.copy(dialect, folder)
        options = mavgen.Opts(str(output), mavparse.PROTOCOL_2_0, language=language, validate=True)
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            succeeded = mavgen.mavgen(options, [source])
    if not succeeded:
        raise RuntimeError(printed.getvalue())
    if language == "C":
        _list_messages(Path(output))


def _extended(common: str) -> str:
    """Add the newer fields to common.xml, as extensions: checksums do not change. One that has them stays as it is."""
    for message, fields in NEWER_FIELDS.items():
        head, body, rest = re.split(rf'(<message id="\d+" name="{message}">.*?</message>)', common, flags=re.DOTALL)
        if fields[0] not in body:
            added = "".join(f'<field type="uint32_t" name="{name}">Number of a plan.</field>' for name in fields)
            body = body.replace("</message>", f"{added}</message>")
        common = head + body + rest
    return common


def _list_messages(folder: Path) -> None:
    """Write messages.inc: a line of HYPERTUNA_MESSAGE (firmware/app/radio/wire.hpp) for every message."""
    names = sorted(path.stem.removeprefix("mavlink_msg_") for path in folder.glob("*/mavlink_msg_*.h"))
    lines = [f"HYPERTUNA_MESSAGE({name}, {name.upper()})\n" for name in names]
    (folder / "hypertuna" / "messages.inc").write_text("".join(lines))


def enums() -> str:
    """Return the enumerations of the dialect as XML, from the tables of core and firmware."""
    from hypertuna import _core

    conditions = [(name, text) for name, _, text in _core.condition_table()]
    faults = [(name, text) for name, text, *_ in _core.fault_table()]
    states = [(name, text) for name, text, _ in _core.state_table()]
    tables = [
        (
            "STATE",
            False,
            "States of the robot: HEARTBEAT.custom_mode, and param2 of MAV_CMD_DO_SET_MODE.",
            states,
        ),
        ("MODE", False, "Modes of the pilot (core/include/hypertuna/pilot/reasons.hpp).", _core.mode_table()),
        (
            "REASON",
            True,
            "Reasons for the pilot's mode (core/include/hypertuna/pilot/reasons.hpp).",
            _core.reason_table(),
        ),
        (
            "CONDITION",
            True,
            "Conditions in the controller's status (core/include/hypertuna/control/safety.hpp).",
            conditions,
        ),
        ("FAULT", True, "Faults detected by the supervisor (firmware/app/vehicle/faults.hpp).", faults),
    ]
    bases = {"STATE": _core.MODE_BASE}
    return "".join(
        _enum(f"HYPERTUNA_{name}", bits, text, rows, bases.get(name, 0)) for name, bits, text, rows in tables
    )


def _enum(name: str, bits: bool, text: str, rows: list[tuple[str, str]], base: int = 0) -> str:
    """Return one enumeration: of bits, or of numbers from `base`."""
    lines = [f'    <enum name="{name}"{" bitmask=" + chr(34) + "true" + chr(34) if bits else ""}>', _described(text, 6)]
    for k, (entry, sentence) in enumerate(rows):
        lines.append(f'      <entry value="{1 << k if bits else base + k}" name="{name}_{entry.upper()}">')
        lines += [_described(f"{sentence[0].upper()}{sentence[1:]}.", 8), "      </entry>"]
    return "\n".join([*lines, "    </enum>\n"])


def _described(text: str, indent: int) -> str:
    """Return a description, indented and wrapped."""
    element = f"<description>{escape(text)}</description>"
    return textwrap.fill(element, WIDTH, initial_indent=" " * indent, subsequent_indent=" " * (indent + 2))


if __name__ == "__main__":
    if sys.argv[2:] == ["enums"]:
        path = Path(sys.argv[1])
        path.write_text(ENUMS.sub(lambda _: enums(), path.read_text(encoding="utf-8")), encoding="utf-8")
    else:
        generate(*sys.argv[1:])
