"""Logs of the radio: every received message in an MCAP file, for Foxglove and `identify`.

Topic /mavlink/NAME has the messages of that name as JSON; fields are in the dialect's units, stated in the schema.
"""

import json
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.door import parse_json
from hypertuna.io.files import version
from hypertuna.io.mcap import LINK, METADATA, NANO, McapWriter, read_messages

TOPIC = "/mavlink/"  # prefix of all topics
MALFORMED = (ValueError, KeyError, TypeError, IndexError, AttributeError)  # errors that a damaged message raises
FLUSH_INTERVAL = 2.0  # s between writes to disk: a crash loses no more than this


class RadioLogWriter(McapWriter):
    """A log in an MCAP file, to which messages are written as they are received."""

    def __init__(self, path: str | Path, robot: str) -> None:
        check_new(path)
        super().__init__(Path(path), overwrite=False)
        self.write_metadata(METADATA, {LINK: json.dumps({"robot": robot, "hypertuna_version": version()})})
        self.counts: Counter[str] = Counter()  # messages of each name
        self._flushed = time.monotonic()

    def write(self, message: Any, stamp: float | None = None) -> None:
        """Append a message received at `stamp` [s since 1970]; now if omitted."""
        from foxglove import Channel

        units = getattr(message, "fieldunits_by_name", {})
        properties = {field: {"description": units.get(field, "")} for field in message.get_fieldnames()}
        schema = {"title": f"mavlink.{message.get_type()}", "type": "object", "properties": properties}
        content = {key: _plain(value) for key, value in message.to_dict().items() if key != "mavpackettype"}
        text = json.dumps(content | {"source": message.get_srcSystem()}, allow_nan=False).encode()
        stamp = time.time() if stamp is None else stamp
        self.channel(TOPIC + message.get_type(), Channel, schema=schema).log(text, log_time=int(stamp * NANO))
        self.counts[message.get_type()] += 1
        if time.monotonic() - self._flushed > FLUSH_INTERVAL:
            self._flushed = time.monotonic()
            self.flush()


def check_new(path: str | Path) -> None:
    """Check that a log overwrites no file, since measurements cannot be repeated."""
    if Path(path).exists():
        raise InputError("must be a new file", file=str(path), value="an existing one", fix="choose another name")


@dataclass(frozen=True)
class RadioLog:
    """Content of a log of the radio."""

    robot: str
    time: dict[str, Array]  # arrival of the messages of each name [s since the first message]
    fields: dict[str, dict[str, Array]]  # numeric fields by names of message and field, in the dialect's units
    complete: bool  # whether the file is complete
    file: str

    def has(self, *names: str) -> bool:
        """Return whether there are messages of all these names."""
        return all(len(self.time.get(name, ())) for name in names)

    def sent(self, name: str) -> Array:
        """Return when the robot sent messages [s since the first one], by its clock, aligned to the shortest delay."""
        arrival, fields = self.time[name], self.fields[name]
        if "time_boot_ms" not in fields:
            return arrival
        clock = fields["time_boot_ms"] * 1e-3
        return clock + float(np.min(arrival - clock))


def read_radio_log(path: str | Path) -> RadioLog:
    """Read a log of the radio; a truncated file is read up to its last complete chunk."""
    messages = read_messages(path)
    if messages.metadata is None or LINK not in messages.metadata:
        fix = "give a file that `hypertuna radio log` or `hypertuna radio drive` wrote"
        raise InputError("must have the metadata of a radio log", file=str(path), fix=fix)
    topics = {topic.removeprefix(TOPIC): topic for topic in messages.times if topic.startswith(TOPIC)}
    stamps = {name: np.array(messages.times[topic], dtype=np.int64) for name, topic in topics.items()}
    first_stamp = min((int(times[0]) for times in stamps.values()), default=0)
    try:
        robot = str(parse_json(messages.metadata[LINK]).get("robot", ""))
        fields = {name: _columns(messages.contents[topic]) for name, topic in topics.items()}
    except MALFORMED:
        rule = "must have messages in hypertuna's format"
        raise InputError(rule, file=str(path), key="topics", fix="record the log again") from None
    seconds = {name: (times - first_stamp) / NANO for name, times in stamps.items()}
    return RadioLog(robot, seconds, fields, not messages.fault, str(path))


def _columns(texts: list[bytes]) -> dict[str, Array]:
    """Return the numeric fields of messages, each with one row per message."""
    first = {key: value for key, value in parse_json(texts[0]).items() if not isinstance(value, str)}
    columns = {key: np.empty((len(texts), *np.shape(value))) for key, value in first.items()}
    for k, text in enumerate(texts):
        message = parse_json(text)
        for key, column in columns.items():
            column[k] = message[key]
    return columns


def _plain(value: Any) -> Any:
    """Return a field's value for JSON, with None for NaN and infinity."""
    if isinstance(value, float) and not np.isfinite(value):
        return None
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    return value
