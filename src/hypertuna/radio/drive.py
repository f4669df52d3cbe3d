"""Manual driving: convert keys and gamepad events to commands, and display the robot's state."""

import math
import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rich.columns import Columns
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from hypertuna.radio.dialect import SILENT, dialect

STEP_AHEAD, STEP_TURN, STEP_CLIMB = 0.1, 0.2, 0.2  # change of the stick per key press, as a part of full deflection
KEYS = (  # keys and their meanings
    ("w s", "faster, slower"),
    ("a d", "to port, to starboard"),
    ("r f", "up, down"),
    ("x", "straight and level"),
    ("space", "stop"),
    ("m", "mission"),
    ("enter", "arm, disarm"),
    ("q", "quit, disarmed"),
)
EVENT = struct.Struct("<IhBB")  # Linux joystick interface: time, value, kind, number
SEQUENCE = re.compile(rb"\x1b(\[[0-9;?]*[ -/]*[@-~]|O.)?")  # escape sequences of terminals (ECMA-48)
AXIS, BUTTON = 2, 1  # kinds of joystick events
AXES = {0: "turn", 1: "ahead", 3: "turn", 4: "climb"}  # by number: left stick x and y, right stick x and y
DEAD_ZONE = 0.1  # fraction of full deflection below which an axis counts as centered


@dataclass(frozen=True)
class Stick:
    """Commanded motion, and the last key's command."""

    ahead: float = 0.0  # 0 to 1 of the top speed
    turn: float = 0.0  # -1 to 1, starboard positive
    climb: float = 0.0  # -1 to 1
    order: str = ""  # "arm", "stop", "mission", "quit", or the number of a gait


def keys(typed: bytes) -> str:
    r"""Return the typed keys without escape sequences such as arrows and function keys.

    Examples
    --------
    >>> keys(b"w\x1b[15~\x1b[Ad")
    'wd'
    """
    return SEQUENCE.sub(b"", typed).decode(errors="ignore")


def pressed(stick: Stick, key: str) -> Stick:
    """Return the stick after a key press.

    Examples
    --------
    >>> pressed(Stick(ahead=0.5), "w").ahead
    0.6
    >>> pressed(Stick(ahead=0.5), " ")
    Stick(ahead=0.0, turn=0.0, climb=0.0, order='stop')
    """
    step = {
        "w": ("ahead", STEP_AHEAD),
        "s": ("ahead", -STEP_AHEAD),
        "d": ("turn", STEP_TURN),
        "a": ("turn", -STEP_TURN),
        "r": ("climb", STEP_CLIMB),
        "f": ("climb", -STEP_CLIMB),
    }
    if key in step:
        name, change = step[key]
        low = 0.0 if name == "ahead" else -1.0
        value = round(max(low, min(1.0, getattr(stick, name) + change)), 6)
        return replace(stick, order="", **{name: value})
    if key == "x":
        return replace(stick, turn=0.0, climb=0.0, order="")
    if key == " ":
        return Stick(order="stop")
    orders = {"\r": "arm", "\n": "arm", "m": "mission", "q": "quit", "\x03": "quit"}
    order = orders.get(key, key if key.isdigit() and key != "0" else "")
    return replace(stick, order=order)


def gamepad(content: bytes) -> list[tuple[str, float]]:
    """Parse events of the Linux joystick interface: axis and value from -1 to 1, or "arm", "stop"."""
    events = []
    for k in range(0, len(content) - EVENT.size + 1, EVENT.size):
        _, value, kind, number = EVENT.unpack_from(content, k)
        if kind & AXIS and number in AXES:
            deflection = value / 32767
            deflection = 0.0 if abs(deflection) < DEAD_ZONE else deflection
            name = AXES[number]
            events.append((name, max(-1.0, min(1.0, -deflection if name in ("ahead", "climb") else deflection))))
        elif kind == BUTTON and value and number < 2:
            events.append((("arm", "stop")[number], 1.0))
    return events


def moved(stick: Stick, event: tuple[str, float]) -> Stick:
    """Return the stick after a gamepad event; the event "gone" means that the gamepad was unplugged."""
    name, value = event
    if name in ("stop", "gone"):
        return Stick(order="stop")
    if name == "arm":
        return replace(stick, order="arm")
    return replace(stick, order="", **{name: max(0.0, value) if name == "ahead" else value})


def view(
    last: Mapping[str, Any], texts: Sequence[str], stick: Stick, gaits: Sequence[str], age: float
) -> RenderableType:
    """Lay out the robot's state: `last` message of each kind, `age` of the last message [s]."""
    heartbeat = last.get("HEARTBEAT")
    armed = heartbeat is not None and bool(heartbeat.base_mode & 128)
    state = {"link": f"{age:.1f} s ago" if age < 60 else "lost", "armed": "yes" if armed else "no"}
    side = "starboard" if stick.turn > 0 else "port"
    turn = f"{abs(stick.turn):.0%} to {side}" if stick.turn else "straight"
    panels = {
        "robot": state | _rows_of(last, {"HEARTBEAT": _state_rows, "SYS_STATUS": _battery_rows, "PILOT": _pilot_rows}),
        "motion": _rows_of(last, {"LOCAL_POSITION_NED": _position_rows, "ATTITUDE": _attitude_rows}),
        "tail": _rows_of(last, {"GAIT": _gait_rows, "HYDRAULICS": _hydraulics_rows}),
        "stick": {"ahead": f"{stick.ahead:.0%}", "turn": turn, "climb": f"{stick.climb:+.0%}"},
    }
    tables = [Panel(_table(rows or {"": "no data yet"}), title=title) for title, rows in panels.items()]
    # Texts of the robot come first, since a low terminal cuts off the end.
    messages = Text("\n".join(texts[-3:]) or " ", style="yellow")
    return Group(
        messages, Columns(tables), _key_line(KEYS), _key_line([(str(k + 1), name) for k, name in enumerate(gaits[:9])])
    )


def _key_line(rows: Sequence[tuple[str, str]]) -> Columns:
    """Return keys and their meanings, laid out side by side."""
    return Columns([Text.assemble((key, "bold"), f" {meaning}") for key, meaning in rows], padding=(0, 2))


def _table(rows: Mapping[str, str]) -> Table:
    """Return a table of names and values."""
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(style="dim")
    table.add_column()
    for row in rows.items():
        table.add_row(*row)
    return table


def _rows_of(last: Mapping[str, Any], kinds: Mapping[str, Callable[[Any], dict[str, str]]]) -> dict[str, str]:
    """Return the rows, label to text, of the received messages of these kinds."""
    return {name: text for kind, rows in kinds.items() if kind in last for name, text in rows(last[kind]).items()}


def _state_rows(heartbeat: Any) -> dict[str, str]:
    states = dialect().enums["HYPERTUNA_STATE"]
    if heartbeat.custom_mode not in states:
        return {}
    return {"state": states[heartbeat.custom_mode].name.removeprefix("HYPERTUNA_STATE_").lower()}


def _battery_rows(status: Any) -> dict[str, str]:
    return {"battery": f"{status.voltage_battery / 1000:.2f} V, {status.battery_remaining} %"}


def _pilot_rows(pilot: Any) -> dict[str, str]:
    return {"faults": _flags("HYPERTUNA_FAULT", pilot.fault), "pilot": _flags("HYPERTUNA_REASON", pilot.reason)}


def _position_rows(position: Any) -> dict[str, str]:
    rows = {"north": f"{position.x:.1f} m", "east": f"{position.y:.1f} m", "depth": f"{position.z:.2f} m"}
    return rows | {"speed": f"{math.hypot(position.vx, position.vy):.2f} m/s"}


def _attitude_rows(attitude: Any) -> dict[str, str]:
    heading, pitch, roll = (math.degrees(angle) for angle in (attitude.yaw, attitude.pitch, attitude.roll))
    return {"heading": f"{heading % 360:.0f} deg", "pitch": f"{pitch:.1f} deg", "roll": f"{roll:.1f} deg"}


def _gait_rows(gait: Any) -> dict[str, str]:
    angles = {name: f"{_texts(getattr(gait, name), 100, '.1f')} deg" for name in ("amplitude", "bias")}
    return {"frequency": f"{gait.frequency / 1000:.2f} Hz"} | angles


def _hydraulics_rows(m: Any) -> dict[str, str]:
    readings = {"bend": f"{_texts(m.bend, 100, '.1f')} deg", "pressure": f"{_texts(m.pressure, 10, '.0f')} kPa"}
    return readings | {"condition": _flags("HYPERTUNA_CONDITION", m.condition)}


def _flags(enum: str, flags: int) -> str:
    """Return the names of the flags that are set, as a text."""
    entries = dialect().enums[enum]
    names = [entries[1 << k].name for k in range(32) if flags >> k & 1 and 1 << k in entries]
    return ", ".join(name.removeprefix(f"{enum}_").lower() for name in names) or "none"


def _texts(counts: Sequence[int], step: float, form: str) -> str:
    """Return the readings, count / step, as a text; "silent" for a sensor that does not answer."""
    return ", ".join("silent" if count == SILENT else f"{count / step:{form}}" for count in counts)
