"""Read logs of missions: each chunk's checksum is tested; of a truncated file, all complete chunks are read."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.control.mission import Mission
from hypertuna.errors import InputError
from hypertuna.frames import attitude_from
from hypertuna.io.door import parse_json
from hypertuna.io.mcap import LINK, NANO, Messages, read_messages
from hypertuna.mission.log_fields import Field, fields
from hypertuna.mission.record import COLUMNS, MissionRecord

FRAMES = {"/tf robot": "attitude", "/tf estimate": "attitude_estimated"}  # by frame of /tf: its quantity
AGAIN = "record the log again"  # fix in errors
# Errors that a damaged message raises
MALFORMED = (ValueError, KeyError, TypeError, IndexError, FloatingPointError, struct.error)


@dataclass(frozen=True)
class Log:
    """Content of a log file."""

    record: MissionRecord  # up to the last time that all topics have
    complete: bool  # whether the file is complete and all checksums are right
    sentence: str  # says whether it is complete, and how much was read
    messages: dict[str, int]  # number of messages of each topic, in complete chunks
    chunks: int  # number of complete chunks
    size: int  # size of the file [bytes]


@dataclass(frozen=True)
class Header:
    """Header of a log: names of columns, joints and circuits, and other facts of its record."""

    name: str
    robot: str
    mission: Mission
    columns: tuple[str, ...]
    joints: tuple[str, ...]
    circuits: tuple[str, ...]
    modes: tuple[str, ...]
    reasons: tuple[str, ...]
    origin: tuple[float, float] | None
    states: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()


def read_header(text: str) -> Header:
    """Parse the header of a log from its JSON text."""
    from pydantic import TypeAdapter  # slow to import

    try:
        return TypeAdapter(Header).validate_json(text)
    except ValueError:
        raise InputError("must have a header in hypertuna's format", key="record", fix=AGAIN) from None


def read_log(path: str | Path) -> Log:
    """Read a log of a mission from an MCAP file."""
    file, size = str(path), Path(path).stat().st_size if Path(path).is_file() else 0
    content = read_messages(path, _name)
    metadata = content.metadata or {}
    if LINK in metadata:
        fix = "open it in Foxglove, or read it by log info, identify or joint fit; the robot's card has the black box"
        raise InputError("must be a log of a mission or a black box", file=file, value="a log of the radio", fix=fix)
    if "record" not in metadata:
        cut_note = f", and it is {content.fault}" if content.fault else ""
        raise InputError(f"must be a hypertuna log: it lacks the header{cut_note}", file=file, fix="give another file")
    try:
        record = _record(content, metadata)
    except InputError as error:
        raise InputError(error.rule, file=file, key=error.key, value=error.value, fix=error.fix) from None
    counts = {topic: len(times) for topic, times in content.times.items()}
    sentence = "The log is whole; all checksums are right."
    if content.fault:
        sentence = (
            f"The log is {content.fault}: {content.chunks} whole chunks were read, up to {record.time[-1]:.4g} s."
        )
    return Log(record, not content.fault, sentence, counts, content.chunks, size)


def _record(content: Messages, metadata: dict[str, str]) -> MissionRecord:
    """Build the record from a log's messages, up to the last time that all topics have."""
    header = read_header(metadata["record"])
    quantities = [name for name in header.columns if name in COLUMNS]
    topics = fields(quantities, header.joints, header.circuits)
    frames = [frame for frame, name in FRAMES.items() if name in quantities]
    required = [*frames, *topics]
    count = min(len(content.times.get(topic, [])) for topic in required)
    if not count:
        rule = "has no messages" + (f", and the file is {content.fault}" if content.fault else "")
        raise InputError(rule, key=next(t for t in required if not content.times.get(t)), fix="give another file")
    try:
        data = _data(content, topics, count)
        for frame in frames:
            position, data[FRAMES[frame]] = _poses(content.contents[frame][:count])
            if frame == "/tf robot":
                data["position"] = position
    except MALFORMED:
        raise InputError("must have messages in hypertuna's format", key="topics", fix=AGAIN) from None
    return MissionRecord(
        time=np.array(content.times[required[0]][:count], dtype=np.int64) / NANO,
        data=data,
        facts={key: value for key, value in metadata.items() if key != "record"},
        **{key: value for key, value in vars(header).items() if key != "columns"},
    )


def _data(content: Messages, topics: dict[str, list[Field]], count: int) -> dict[str, Array]:
    """Return the record's columns, read from the messages of all topics except /tf."""
    columns: dict[str, list[Array]] = {}
    for topic, rows in topics.items():
        table = np.empty((count, len(rows)))
        for k, text in enumerate(content.contents[topic][:count]):
            message = parse_json(text)
            table[k] = [message[row.key] for row in rows]
        for row, values in zip(rows, table.T, strict=True):
            with np.errstate(over="raise"):
                columns.setdefault(row.name, []).append(values / row.factor)
    single = {row.name for rows in topics.values() for row in rows if row.part is None}
    return {name: parts[0] if name in single else np.column_stack(parts) for name, parts in columns.items()}


def _name(topic: str, content: bytes) -> str:
    """Return the name of a message: its topic, with the child frame for a transform."""
    return f"/tf {dict(protobuf_fields(content)).get(3, b'').decode(errors='replace')}" if topic == "/tf" else topic


def _poses(contents: list[bytes]) -> tuple[Array, Array]:
    """Return positions (T, 3) [m] and attitudes (T, 4) of transforms, converted to the record's body axes."""
    place, turn = np.zeros((len(contents), 3)), np.zeros((len(contents), 4))
    for k, content in enumerate(contents):
        parts = dict(protobuf_fields(content))
        for number, value in protobuf_fields(parts[4]):
            (place[k, number - 1],) = struct.unpack("<d", value)
        for number, value in protobuf_fields(parts[5]):  # x, y, z, w
            (turn[k, number % 4],) = struct.unpack("<d", value)
    return place, attitude_from("enu", turn)


def protobuf_fields(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield number and content of a transform's protobuf fields: doubles, and texts or messages under 128 bytes.

    Stop at the first field of another type (protobuf.dev/programming-guides/encoding).
    """
    offset = 0
    while offset + 1 < len(content):
        number, kind = divmod(content[offset], 8)
        begin, size = (offset + 1, 8) if kind == 1 else (offset + 2, content[offset + 1])
        if kind not in (1, 2) or size > 127 or begin + size > len(content):
            return
        yield number, content[begin : begin + size]
        offset = begin + size
