"""Topics of a log and their fields: one list for writing, reading and telling them."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from hypertuna.mission.record import COLUMNS, READ, parts_of


class Field(NamedTuple):
    """A number of a message: its key with the unit, the quantity and its part, and the factor from SI."""

    key: str
    name: str
    part: int | None
    factor: float


DEGREES, KILO = 180 / np.pi, 1e-3
BORDER = {  # units of messages, and their factor from SI
    "rad": ("deg", DEGREES),
    "rad/s": ("deg_s", DEGREES),
    "Pa": ("kpa", KILO),
    "J": ("wh", 1 / 3600),
    "m": ("m", 1.0),
    "m/s": ("m_s", 1.0),
    "m/s^2": ("m_s2", 1.0),
    "V": ("v", 1.0),
    "A": ("a", 1.0),
    "s": ("us", 1e6),
    "W": ("w", 1.0),
    "Hz": ("hz", 1.0),
    "C": ("ah", 1 / 3600),
    "1": ("", 1.0),
}

# Quantities of each topic; attitude and position in space are transforms.
SCALARS: dict[str, tuple[str, ...]] = {
    "/motion": ("velocity", "turn_rate"),
    "/estimate": (
        *("position_estimated", "depth_estimated", "speed_estimated", "current_estimated"),
        *("factor_estimated", "position_error"),
    ),
    "/mode": ("mode", "reasons", "leg", "control", "armed", "faults", "answer"),
    "/joints": ("angle_set", "angle"),
    "/servos": ("servo_target", "servo_angle", "pulse"),
    "/hydraulics": ("pump_pressure", "unit_pressure"),
    "/fins": ("fin_target", "fin"),
    "/command": (*("frequency_commanded", "amplitude_commanded", "lag_commanded", "bias_commanded", "fin_commanded"),),
    "/battery": ("battery_voltage", "power", "energy", "charge", "charge_left"),
    "/status": ("status",),
    "/sensors": READ,
}


def fields(names: Collection[str], joints: tuple[str, ...], circuits: tuple[str, ...]) -> dict[str, list[Field]]:
    """Return the fields of each topic."""
    topics = {}
    for topic, kinds in SCALARS.items():
        rows = [row for name in kinds if name in names for row in _rows(name, parts_of(name, joints, circuits))]
        if rows or topic == "/motion":
            topics[topic] = rows
    return topics


def schema(topic: str, rows: list[Field]) -> dict[str, object]:
    """Return the JSON schema of a topic's messages."""
    extra: dict[str, object] = {}
    if topic == "/motion":
        extra = {key: _number(text) for key, text in DERIVED.items()}
    if topic == "/mode":
        names = {"type": "array", "items": {"type": "string"}}
        extra = {"mode_name": {"type": "string"}, "reason_names": names}
        if "faults" in (row.name for row in rows):
            extra |= {"control_name": {"type": "string"}, "fault_names": names}
    own = {row.key: _number(COLUMNS[row.name].meaning, silent=COLUMNS[row.name].silent) for row in rows}
    title = f"hypertuna{topic.replace('/', '.')}"
    return {"title": title, "type": "object", "properties": own | extra}


# Further fields of /motion, derived from position and attitude for plots.
DERIVED = {
    "depth_m": "of the nose",
    "speed_m_s": "through the water, ahead positive",
    "roll_deg": "starboard down positive",
    "pitch_deg": "nose up positive",
    "heading_deg": "that the head faces, clockwise from north",
}


def _rows(name: str, parts: tuple[str, ...]) -> list[Field]:
    """Return the fields of one quantity."""
    unit, factor = BORDER[COLUMNS[name].unit]
    tail = f"_{unit}" if unit else ""
    if not parts:
        return [Field(f"{name}{tail}", name, None, factor)]
    texts = (re.sub(r"\W", "_", part) for part in parts)
    return [Field(f"{name}_{text}{tail}", name, k, factor) for k, text in enumerate(texts)]


def _number(text: str, *, silent: bool = False) -> dict[str, object]:
    """Return the schema of a number, null where a reading may be missing."""
    return {"type": ["number", "null"] if silent else "number", "description": text}
