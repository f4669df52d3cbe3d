"""Bags of ROS 2: messages of an MCAP file (the extra `log`) or of a database (.db3), and the types that are read.

These are types of ROS's standard packages, encoded in CDR, which aligns a number to a multiple of its size, and types
of Foxglove, encoded in JSON.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from hypertuna.errors import InputError
from hypertuna.io.door import opened, parse_json, read_bytes
from hypertuna.io.mcap import MAGIC, read_messages

DATABASE, ROS1 = b"SQLite format 3\0", b"#ROSBAG"  # first bytes of a .db3 file, and of a bag of ROS 1
# Limits: messages of a file; bytes of a text; names or transforms of a message.
MESSAGES, STRING, NAMES = 1_000_000, 4096, 1000
STEPS = 50_000_000  # limit of SQLite's virtual machine, about 10 s


@dataclass
class Topic:
    """The messages of a topic, in the order of the file."""

    kind: str  # type of its messages, such as nav_msgs/Odometry
    time: list[int] = field(default_factory=list)  # when they were recorded [ns]
    content: list[bytes] = field(default_factory=list)


class Stamped(NamedTuple):
    """Pose of the frame `child` in the frame `parent`, with its time."""

    time: int  # time stamp of its header [ns]; 0 if the sender gave none
    parent: str
    child: str
    place: tuple[float, ...]  # x, y, z [m]
    turn: tuple[float, ...]  # quaternion x, y, z, w


class Joints(NamedTuple):
    """Positions of joints [rad]."""

    time: int
    names: tuple[str, ...]
    position: tuple[float, ...]


def read_bag(path: str | Path) -> tuple[dict[str, Topic], str]:
    """Return the topics of a bag, a file or a folder with one file, and its damage in words, empty for a whole bag."""
    path = _only_file(Path(path))
    with opened(path, "bag") as stream:
        magic = stream.read(16) or b""
    if magic.startswith(MAGIC):
        return _mcap_topics(path)
    if magic.startswith(DATABASE):
        return _database_topics(path), ""
    ros1 = magic.startswith(ROS1)
    value = (
        "a bag of ROS 1" if ros1 else "a compressed file" if magic.startswith(b"\x28\xb5\x2f\xfd") else "something else"
    )
    fix = "convert it: rosbags-convert --src OLD --dst NEW" if ros1 else "give a .mcap or .db3 file, unpacked"
    raise InputError("must be a bag of ROS 2 or a log (MCAP)", file=str(path), value=value, fix=fix)


def _only_file(path: Path) -> Path:
    """Return a bag's file of messages: the path itself, or the only such file in a folder."""
    if not path.is_dir():
        return path
    files = sorted(name for name in os.listdir(path) if name.endswith((".mcap", ".db3")))
    if len(files) != 1:
        value, fix = f"{len(files)} of them", "give the path of one of its files"
        raise InputError("must hold one .mcap or .db3 file", file=str(path), value=value, fix=fix)
    return path / files[0]


def _mcap_topics(path: Path) -> tuple[dict[str, Topic], str]:
    """Return the topics of an MCAP file."""
    topics: dict[str, Topic] = {}
    messages = read_messages(path, foreign=True)
    for name, (encoding, kind) in messages.kinds.items():
        if name in messages.times:
            kind = kind.replace("/msg/", "/") if encoding == "cdr" else f"{kind} in {encoding}"
            topics[name] = Topic(kind, messages.times[name], messages.contents[name])
    return topics, messages.fault


def _database_topics(path: Path) -> dict[str, Topic]:
    """Return the topics of a database: only its two tables are read, and nothing stored in it is executed."""
    import sqlite3  # slow to import

    topics: dict[str, Topic] = {}
    content = read_bytes(path, "bag")
    try:
        with sqlite3.connect(":memory:") as database:
            database.deserialize(content)
            steps = iter(range(STEPS // 10_000))
            database.set_progress_handler(lambda: next(steps, None) is None, 10_000)
            database.execute("PRAGMA trusted_schema = OFF")
            database.execute("PRAGMA cell_size_check = ON")
            if not all(_is_stored(database, name) for name in ("topics", "messages")):
                raise InputError("must have tables of topics and messages", file=str(path), fix="give a bag of ROS 2")
            described = {
                row[0]: row
                for row in database.execute("SELECT id, name, type, serialization_format FROM topics LIMIT 1000")
            }
            rows = database.execute(
                "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp LIMIT ?", (MESSAGES + 1,)
            )
            for k, (number, time, data) in enumerate(rows):
                if k == MESSAGES:
                    rule = f"must hold at most {MESSAGES} messages"
                    raise InputError(rule, file=str(path), value="more", fix="record the topics of the poses alone")
                _, name, kind, encoding = described.get(number, (None, None, None, None))
                if encoding == "cdr" and isinstance(data, bytes) and isinstance(time, int):
                    topic = topics.setdefault(str(name), Topic(str(kind).replace("/msg/", "/")))
                    topic.time.append(time)
                    topic.content.append(data)
    except (sqlite3.Error, UnicodeError, MemoryError, OverflowError):
        fix = "record it again, or convert it: rosbags-convert"
        raise InputError("must be a whole bag of ROS 2", file=str(path), value="not", fix=fix) from None
    return topics


def _is_stored(database: Any, name: str) -> bool:
    """Return whether a database has a table of this name whose cells are all stored, and none computed."""
    kinds = database.execute("SELECT type FROM pragma_table_list(?) WHERE schema = 'main'", (name,)).fetchall()
    hidden = database.execute("SELECT max(hidden) FROM pragma_table_xinfo(?)", (name,)).fetchone()
    return bool(kinds == [("table",)] and hidden == (0,))


class _Reader:
    """A reader of a message in CDR, which returns its numbers and texts one after the other."""

    def __init__(self, content: bytes) -> None:
        if content[:1] != b"\0" or content[1:2] not in (b"\0", b"\1"):
            raise ValueError
        self.body, self.order, self.offset = content[4:], "<" if content[1] else ">", 0

    def number(self, form: str) -> Any:
        """Return the next number; form: its format in `struct`."""
        size = struct.calcsize(form)
        self.offset += -self.offset % size
        (value,) = struct.unpack_from(self.order + form, self.body, self.offset)
        self.offset += size
        return value

    def numbers(self, count: int) -> tuple[float, ...]:
        """Return the next numbers of 64 bits."""
        return tuple(float(self.number("d")) for _ in range(count))

    def text(self) -> str:
        """Return the next text."""
        size = self.number("I")
        if size > STRING or self.offset + size > len(self.body):
            raise ValueError
        self.offset += size
        return self.body[self.offset - size : self.offset].rstrip(b"\0").decode("utf-8", "replace")

    def count(self) -> int:
        """Return the length of the next sequence."""
        size = int(self.number("I"))
        if size > NAMES:
            raise ValueError
        return size

    def header(self) -> tuple[int, str]:
        """Return the time [ns] and the frame of the next header."""
        seconds, nanos = self.number("i"), self.number("I")
        return seconds * 1_000_000_000 + nanos, self.text()

    def pose(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return place [m] and quaternion x, y, z, w of the next pose."""
        return self.numbers(3), self.numbers(4)


def _decode_pose(reader: _Reader) -> Iterator[Stamped]:
    time, parent = reader.header()
    yield Stamped(time, parent, "", *reader.pose())


def _decode_odometry(reader: _Reader) -> Iterator[Stamped]:
    (time, parent), child = reader.header(), reader.text()
    yield Stamped(time, parent, child, *reader.pose())


def _decode_transforms(reader: _Reader) -> Iterator[Stamped]:
    for _ in range(reader.count()):
        yield from _decode_odometry(reader)


def _decode_joints(reader: _Reader) -> Iterator[Joints]:
    time, _ = reader.header()
    names = tuple(reader.text() for _ in range(reader.count()))
    yield Joints(time, names, reader.numbers(reader.count()))


def _numbers_of(table: Any, *names: str) -> tuple[float, ...]:
    """Return the numbers of these names in a JSON object."""
    return tuple(float(table[name]) for name in names)


def _json_pose(content: bytes) -> Iterator[Stamped]:
    """Return the pose of a message of Foxglove in JSON: a pose in a frame, or a transform."""
    value = parse_json(content)
    time = value.get("timestamp") or {}
    pose = value.get("pose", value)
    yield Stamped(
        int(time.get("sec", 0)) * 1_000_000_000 + int(time.get("nsec", 0)),
        str(value.get("frame_id", value.get("parent_frame_id", ""))),
        str(value.get("child_frame_id", "")),
        _numbers_of(pose.get("position", pose.get("translation")), "x", "y", "z"),
        _numbers_of(pose.get("orientation", pose.get("rotation")), "x", "y", "z", "w"),
    )


# Message types, and their decoders.
IN_JSON = ("foxglove.PoseInFrame in json", "foxglove.FrameTransform in json")
POSES: dict[str, Callable[[_Reader], Iterator[Stamped]]] = {
    "geometry_msgs/PoseStamped": _decode_pose,
    "geometry_msgs/PoseWithCovarianceStamped": _decode_pose,
    "geometry_msgs/TransformStamped": _decode_odometry,
    "nav_msgs/Odometry": _decode_odometry,
    "tf2_msgs/TFMessage": _decode_transforms,
}
JOINTS = {"sensor_msgs/JointState": _decode_joints}


def decoded(file: str, name: str, topic: Topic) -> Iterator[tuple[int, Any]]:
    """Yield the time of recording [ns] and the content, a pose or joints, of each message of a topic."""
    decode: Any = _json_pose if topic.kind in IN_JSON else {**POSES, **JOINTS}[topic.kind]
    for k, (time, content) in enumerate(zip(topic.time, topic.content, strict=True)):
        try:
            for value in decode(content if decode is _json_pose else _Reader(content)):
                yield time, value
        except (ValueError, TypeError, LookupError, AttributeError, struct.error, OverflowError):
            key, fix = f"message {k + 1} of {name}", "record it again"
            raise InputError(
                f"must be a message of {topic.kind}", file=file, key=key, value="damaged", fix=fix
            ) from None
