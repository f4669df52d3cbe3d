"""Fields of a log's messages: their keys, units, schemas and values, for MCAP and CSV."""

import re
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.mission.record import COLUMNS, TOPICS, MissionRecord, parts_of


class Field(NamedTuple):
    """A number of a message: key with unit, recorded quantity, index of its part (None: a scalar), factor from SI."""

    key: str
    name: str
    part: int | None
    factor: float

    def of(self, record: MissionRecord) -> Array:
        """Return the field's values (T,) in a record, in the unit of the key."""
        values = record.data[self.name]
        return np.asarray((values if self.part is None else values[:, self.part]) * self.factor)


DEGREES = 180 / np.pi  # per radian
BORDER = {  # by SI unit: suffix of a key, and factor from SI
    "rad": ("deg", DEGREES),
    "rad/s": ("deg_s", DEGREES),
    "Pa": ("kpa", 1e-3),
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
# Fields of /motion that are derived from the pose for plots, with their meanings.
DERIVED = {
    "depth_m": "of the nose",
    "speed_m_s": "through the water, ahead positive",
    "roll_deg": "starboard down positive",
    "pitch_deg": "nose up positive",
    "heading_deg": "that the head faces, clockwise from north",
}


def record_columns(record: MissionRecord) -> dict[str, Array]:
    """Return a record as the columns of its table."""
    columns = {"time_s": record.time} | dict(zip(("x_m", "y_m", "z_m"), record.position.T, strict=True))
    columns |= {key: values for key, values in derived(record).items() if key != "speed_m_s"}
    for rows in fields(record.data, record.joints, record.circuits).values():
        columns |= {row.key: row.of(record) for row in rows}
    return columns


def derived(record: MissionRecord) -> dict[str, Array]:
    """Return the values of `DERIVED` (T,); the speed is the true or the estimated one."""
    speed = np.zeros(len(record.time))
    if "velocity" in record.data:
        speed = -record.data["velocity"][:, 0]
    elif not record.true:
        speed = record.data.get("speed_estimated", speed)
    return dict(zip(DERIVED, (record.depth, speed, *(record.angles * DEGREES).T), strict=True))


def fields(names: Collection[str], joints: tuple[str, ...], circuits: tuple[str, ...]) -> dict[str, list[Field]]:
    """Return the fields of each topic of messages in JSON."""
    topics = {}
    for topic, columns in TOPICS.items():
        rows = [row for name in columns if name in names for row in _rows(name, parts_of(name, joints, circuits))]
        if topic != "/tf" and (rows or topic == "/motion"):
            topics[topic] = rows
    return topics


def _rows(name: str, parts: tuple[str, ...]) -> list[Field]:
    """Return the fields of a recorded quantity, one for each of its parts."""
    unit, factor = BORDER[COLUMNS[name].unit]
    suffix = f"_{unit}" if unit else ""
    if not parts:
        return [Field(f"{name}{suffix}", name, None, factor)]
    texts = (re.sub(r"\W", "_", part) for part in parts)
    return [Field(f"{name}_{text}{suffix}", name, k, factor) for k, text in enumerate(texts)]


def schema(topic: str, rows: list[Field]) -> dict[str, object]:
    """Return the JSON schema of a topic's messages."""
    properties = {row.key: _number(COLUMNS[row.name].meaning, silent=COLUMNS[row.name].silent) for row in rows}
    if topic == "/motion":
        properties |= {key: _number(text) for key, text in DERIVED.items()}
    if topic == "/mode":
        text: dict[str, object] = {"type": "string"}
        texts: dict[str, object] = {"type": "array", "items": text}
        properties |= {"mode_name": text, "state_name": text, "reason_names": texts, "fault_names": texts}
    return {"title": f"hypertuna{topic.replace('/', '.')}", "type": "object", "properties": properties}


def _number(text: str, *, silent: bool = False) -> dict[str, object]:
    """Return the JSON schema of a number; silent: null stands for a missing reading."""
    return {"type": ["number", "null"] if silent else "number", "description": text}
