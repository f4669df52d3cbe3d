"""Bags of ROS 2: messages of an MCAP file (the extra `log`) or of a database (.db3), and the few kinds that are read.

The messages are those of the standard packages, in CDR, whose numbers stand at multiples of their size; of Foxglove's,
those in JSON.
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

DATABASE, ROS1 = b"SQLite format 3\0", b"#ROSBAG"
MESSAGES, STRING, NAMES = 1_000_000, 4096, 1000  # of a file; bytes of a text; names or transforms of a message
STEPS = 50_000_000  # of the database's machine, about 10 s


@dataclass
class Topic:
    """The messages of a topic, in the order of the file."""

    kind: str  # of its messages, such as nav_msgs/Odometry
    time: list[int] = field(default_factory=list)  # when they were recorded [ns]
    content: list[bytes] = field(default_factory=list)


class Stamped(NamedTuple):
    """A pose of one frame in another."""

    time: int  # of its header [ns], 0 where the sender gave none
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
    """Return the topics of a bag, and what is wrong with it (nothing for a whole one); a folder has one file of it."""
    path = _only_file(Path(path))
    with opened(path, "bag") as stream:
        first = stream.read(16) or b""
    if first.startswith(MAGIC):
        return _of_mcap(path)
    if first.startswith(DATABASE):
        return _of_database(path), ""
    ros1 = first.startswith(ROS1)
    value = (
        "a bag of ROS 1" if ros1 else "a compressed file" if first.startswith(b"\x28\xb5\x2f\xfd") else "something else"
    )
    fix = "convert it: rosbags-convert --src OLD --dst NEW" if ros1 else "give a .mcap or .db3 file, unpacked"
    raise InputError("must be a bag of ROS 2 or a log (MCAP)", file=str(path), value=value, fix=fix)


def _only_file(path: Path) -> Path:
    """Return the file of messages of the folder of a bag."""
    if not path.is_dir():
        return path
    files = sorted(name for name in os.listdir(path) if name.endswith((".mcap", ".db3")))
    if len(files) != 1:
        value, fix = f"{len(files)} of them", "give the path of one of its files"
        raise InputError("must hold one .mcap or .db3 file", file=str(path), value=value, fix=fix)
    return path / files[0]


def _of_mcap(path: Path) -> tuple[dict[str, Topic], str]:
    """Return the topics of an MCAP file."""
    topics: dict[str, Topic] = {}
    found = read_messages(path, foreign=True)
    for name, (encoding, kind) in found.kinds.items():
        if name in found.times:
            kind = kind.replace("/msg/", "/") if encoding == "cdr" else f"{kind} in {encoding}"
            topics[name] = Topic(kind, found.times[name], found.contents[name])
    return topics, found.fault


def _of_database(path: Path) -> dict[str, Topic]:
    """Return the topics of a database, of which two tables are read and nothing else runs."""
    import sqlite3  # slow to import

    topics: dict[str, Topic] = {}
    content = read_bytes(path, "bag")
    try:
        with sqlite3.connect(":memory:") as base:
            base.deserialize(content)
            steps = iter(range(STEPS // 10_000))
            base.set_progress_handler(lambda: next(steps, None) is None, 10_000)
            base.execute("PRAGMA trusted_schema = OFF")
            base.execute("PRAGMA cell_size_check = ON")
            tables = dict(base.execute("SELECT name, type FROM sqlite_master WHERE name IN ('topics', 'messages')"))
            if set(tables.values()) != {"table"} or len(tables) < 2:
                raise InputError("must have tables of topics and messages", file=str(path), fix="give a bag of ROS 2")
            known = {
                row[0]: row
                for row in base.execute("SELECT id, name, type, serialization_format FROM topics LIMIT 1000")
            }
            rows = base.execute(
                "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp LIMIT ?", (MESSAGES + 1,)
            )
            for k, (number, time, data) in enumerate(rows):
                if k == MESSAGES:
                    rule = f"must hold at most {MESSAGES} messages"
                    raise InputError(rule, file=str(path), value="more", fix="record the topics of the poses alone")
                _, name, kind, form = known.get(number, (None, None, None, None))
                if form == "cdr" and isinstance(data, bytes) and isinstance(time, int):
                    own = topics.setdefault(str(name), Topic(str(kind).replace("/msg/", "/")))
                    own.time.append(time)
                    own.content.append(data)
    except (sqlite3.Error, UnicodeError, MemoryError, OverflowError):
        fix = "record it again, or convert it: rosbags-convert"
        raise InputError("must be a whole bag of ROS 2", file=str(path), value="not", fix=fix) from None
    return topics


class _Reader:
    """The numbers and texts of a message in CDR, one after the other."""

    def __init__(self, content: bytes) -> None:
        if content[:1] != b"\0" or content[1:2] not in (b"\0", b"\1"):
            raise ValueError
        self.body, self.order, self.at = content[4:], "<" if content[1] else ">", 0

    def number(self, form: str) -> Any:
        """Return a number."""
        size = struct.calcsize(form)
        self.at += -self.at % size
        (value,) = struct.unpack_from(self.order + form, self.body, self.at)
        self.at += size
        return value

    def numbers(self, count: int) -> tuple[float, ...]:
        """Return numbers of 64 bits."""
        return tuple(float(self.number("d")) for _ in range(count))

    def text(self) -> str:
        """Return a text."""
        size = self.number("I")
        if size > STRING or self.at + size > len(self.body):
            raise ValueError
        self.at += size
        return self.body[self.at - size : self.at].rstrip(b"\0").decode("utf-8", "replace")

    def count(self) -> int:
        """Return the length of a sequence."""
        size = int(self.number("I"))
        if size > NAMES:
            raise ValueError
        return size

    def header(self) -> tuple[int, str]:
        """Return the time [ns] and the frame of a header."""
        seconds, nanos = self.number("i"), self.number("I")
        return seconds * 1_000_000_000 + nanos, self.text()

    def pose(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return place and quaternion."""
        return self.numbers(3), self.numbers(4)


def _pose(reader: _Reader) -> Iterator[Stamped]:
    time, parent = reader.header()
    yield Stamped(time, parent, "", *reader.pose())


def _odometry(reader: _Reader) -> Iterator[Stamped]:
    (time, parent), child = reader.header(), reader.text()
    yield Stamped(time, parent, child, *reader.pose())


def _transforms(reader: _Reader) -> Iterator[Stamped]:
    for _ in range(reader.count()):
        yield from _odometry(reader)


def _joints(reader: _Reader) -> Iterator[Joints]:
    time, _ = reader.header()
    names = tuple(reader.text() for _ in range(reader.count()))
    yield Joints(time, names, reader.numbers(reader.count()))


def _values(table: Any, *names: str) -> tuple[float, ...]:
    """Return numbers of a JSON object."""
    return tuple(float(table[name]) for name in names)


def _of_json(content: bytes) -> Iterator[Stamped]:
    """Return the pose of a message of Foxglove in JSON: a pose in a frame, or a transform."""
    value = parse_json(content)
    time = value.get("timestamp") or {}
    pose = value.get("pose", value)
    yield Stamped(
        int(time.get("sec", 0)) * 1_000_000_000 + int(time.get("nsec", 0)),
        str(value.get("frame_id", value.get("parent_frame_id", ""))),
        str(value.get("child_frame_id", "")),
        _values(pose.get("position", pose.get("translation")), "x", "y", "z"),
        _values(pose.get("orientation", pose.get("rotation")), "x", "y", "z", "w"),
    )


IN_JSON = ("foxglove.PoseInFrame in json", "foxglove.FrameTransform in json")
POSES: dict[str, Callable[[_Reader], Iterator[Stamped]]] = {
    "geometry_msgs/PoseStamped": _pose,
    "geometry_msgs/PoseWithCovarianceStamped": _pose,
    "geometry_msgs/TransformStamped": _odometry,
    "nav_msgs/Odometry": _odometry,
    "tf2_msgs/TFMessage": _transforms,
}
JOINTS = {"sensor_msgs/JointState": _joints}


def decoded(file: str, name: str, topic: Topic) -> Iterator[tuple[int, Any]]:
    """Yield when it was recorded [ns], and each pose or set of joints of the messages of a topic."""
    decode: Any = _of_json if topic.kind in IN_JSON else {**POSES, **JOINTS}[topic.kind]
    for k, (time, content) in enumerate(zip(topic.time, topic.content, strict=True)):
        try:
            for one in decode(content if decode is _of_json else _Reader(content)):
                yield time, one
        except (ValueError, TypeError, LookupError, AttributeError, struct.error, OverflowError):
            key, fix = f"message {k + 1} of {name}", "record it again"
            raise InputError(
                f"must be a message of {topic.kind}", file=file, key=key, value="damaged", fix=fix
            ) from None
