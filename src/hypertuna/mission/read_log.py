"""Reading of logs: every chunk is checked by its checksum; of a file that was cut short, all whole chunks are read."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.frames import attitude_from
from hypertuna.io.mcap import LINK, NANO, Messages, protobuf_fields, read_messages
from hypertuna.mission.log_fields import fields
from hypertuna.mission.record import COLUMNS, MissionRecord, mission_from


@dataclass(frozen=True)
class Log:
    """A log, read from its file."""

    record: MissionRecord  # every time that all topics have
    complete: bool  # whether the file is whole and every checksum is right
    sentence: str  # the same in words, with the extent read
    messages: dict[str, int]  # number of messages of each topic in whole chunks
    chunks: int  # whole ones
    size: int  # bytes of the file


def read_log(path: str | Path) -> Log:
    """Read a log."""
    file, size = str(path), Path(path).stat().st_size if Path(path).is_file() else 0
    content = read_messages(path)
    if content.metadata is not None and LINK in content.metadata:
        fix = "open it in Foxglove, or give it to identify or actuator fit; the robot's card has a black box"
        raise InputError("must be a log of a mission or a black box", file=file, value="one of the radio", fix=fix)
    if content.metadata is None or "record" not in content.metadata:
        cut = f", and it is {content.fault}" if content.fault else ""
        raise InputError(f"must be a hypertuna log: it lacks the header{cut}", file=file, fix="give another file")
    try:
        record = _record(content)
    except InputError as error:
        raise InputError(error.rule, file=file, key=error.key, value=error.value, fix=error.fix) from None
    counts = {topic: len(times) for topic, times in content.times.items()}
    sentence = "The log is whole; all checksums are right."
    if content.fault:
        sentence = f"The log is {content.fault}: {content.chunks} whole chunks are read, up to {record.time[-1]:.4g} s."
    return Log(record, not content.fault, sentence, counts, content.chunks, size)


def _record(content: Messages) -> MissionRecord:
    """Make a record of the times that all topics have."""
    assert content.metadata is not None
    try:
        head = json.loads(content.metadata["record"])
        names, joints, circuits = head["columns"], tuple(head["joints"]), tuple(head["circuits"])
        known = [name for name in names if name in COLUMNS]
        origin = None if head["origin"] is None else (float(head["origin"][0]), float(head["origin"][1]))
        mission = mission_from(head["mission"])
        texts = (str(head["name"]), str(head["robot"]))
        modes, reasons = tuple(head["modes"]), tuple(head["reasons"])
        controls, faults = tuple(head.get("controls", ())), tuple(head.get("faults", ()))
    except (ValueError, KeyError, TypeError, IndexError):
        raise InputError("must have a header in hypertuna's format", key="record", fix="record the log again") from None
    topics = fields(known, joints, circuits)
    frames = {"/tf robot": "attitude", "/tf estimate": "attitude_estimated"}
    required = [*(topic for topic, name in frames.items() if name in known), *topics]
    count = min(len(content.times.get(topic, [])) for topic in required)
    if not count:
        rule = "has no time that all topics have" + (f": it is {content.fault}" if content.fault else "")
        raise InputError(rule, key=next(t for t in required if not content.times.get(t)), fix="give another file")
    stamps = np.array(content.times[required[0]][:count], dtype=np.int64)
    try:
        data = _data(content, topics, count)
        if "/tf robot" in required:
            data["position"], data["attitude"] = _poses(content.contents["/tf robot"][:count])
        if "/tf estimate" in required:
            data["attitude_estimated"] = _poses(content.contents["/tf estimate"][:count])[1]
    except (ValueError, KeyError, TypeError, IndexError, struct.error):
        fix = "record the log again"
        raise InputError("must have messages in hypertuna's format", key="topics", fix=fix) from None
    facts = {key: value for key, value in content.metadata.items() if key != "record"}
    return MissionRecord(
        *texts, mission, stamps / NANO, data, joints, circuits, modes, reasons, origin, facts, controls, faults
    )


def _data(content: Messages, topics: dict[str, list[Any]], count: int) -> dict[str, Array]:
    """Read the numbers of all topics but the transforms."""
    data: dict[str, list[Array] | Array] = {}
    for topic, rows in topics.items():
        messages = [json.loads(text) for text in content.contents[topic][:count]]
        for row in rows:
            column = np.array([message[row.key] for message in messages], dtype=np.float64) / row.factor
            if row.part is None:
                data[row.name] = column
            else:
                parts = data.setdefault(row.name, [])
                assert isinstance(parts, list)
                parts.append(column)
    return {
        name: np.column_stack(parts) if isinstance(parts, list) else np.asarray(parts) for name, parts in data.items()
    }


def _poses(contents: list[bytes]) -> tuple[Array, Array]:
    """Read positions and attitudes of transforms, in our body axes."""
    place, turn = np.zeros((len(contents), 3)), np.zeros((len(contents), 4))
    for k, content in enumerate(contents):
        parts = dict(protobuf_fields(content))
        for number, value in protobuf_fields(parts[4]):
            (place[k, number - 1],) = struct.unpack("<d", value)
        for number, value in protobuf_fields(parts[5]):  # x, y, z, w
            (turn[k, number % 4],) = struct.unpack("<d", value)
    return place, attitude_from("enu", turn)
