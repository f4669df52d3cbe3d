"""MCAP files of missions and radio: constants of their writers, and a reader of all whole chunks.

Chunks are checked by their checksums, also those of a file that was cut short. Needs the extra `log`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError

INSTALL = "pip install 'hypertuna[log]'"
CHUNK = 64 * 1024  # bytes before compression: a few seconds of a mission
NANO = 1_000_000_000
METADATA, ENDING = "hypertuna", "hypertuna-end"
LINK = "link"  # metadata key of a radio log
MAGIC = b"\x89MCAP0\r\n"


def need_log() -> None:
    """Check that the packages of the extra `log` are installed."""
    for name in ("foxglove", "mcap"):
        if find_spec(name) is None:
            raise InputError("is needed by logs and is not installed", key=name, fix=INSTALL)


@dataclass
class Messages:
    """Messages of a file until its end or its first fault."""

    times: dict[str, list[int]]  # of the messages of each topic [ns]
    contents: dict[str, list[bytes]]  # of the same messages
    metadata: dict[str, str] | None = None  # of the file's header
    chunks: int = 0  # number of whole chunks
    fault: str = ""  # description, empty for a sound file


def read_messages(path: str | Path) -> Messages:
    """Read the messages of all whole chunks of a file."""
    need_log()
    file = str(path)
    try:
        with Path(path).open("rb") as stream:
            start = stream.read(len(MAGIC))
        size = Path(path).stat().st_size
    except OSError as error:
        value, fix = f"not ({error.strerror})", "give the path of a .mcap file"
        raise InputError("must be a readable file", file=file, value=value, fix=fix) from None
    if start != MAGIC:
        raise InputError("must be an MCAP file", file=file, value="something else", fix="give a .mcap file")
    return _collect(Path(path), size)


def _collect(path: Path, size: int) -> Messages:
    """Collect the messages of whole chunks by topic; those of "/tf" by child frame."""
    from mcap.records import Channel, Message

    messages = Messages({}, {})
    topics: dict[int, str] = {}
    for part in _chunks(path, size, messages):
        topics |= {record.id: record.topic for record in part if isinstance(record, Channel)}
        for record in part:
            if isinstance(record, Message) and record.channel_id in topics:
                topic = topics[record.channel_id]
                if topic == "/tf":
                    topic = f"/tf {_child(record.data)}"
                messages.times.setdefault(topic, []).append(record.log_time)
                messages.contents.setdefault(topic, []).append(record.data)
        messages.chunks += 1
    return messages


def _chunks(path: Path, size: int, messages: Messages) -> Iterator[list[Any]]:
    """Yield the records of each whole chunk; store metadata and the first fault."""
    from mcap.records import Chunk, Footer, Metadata
    from mcap.stream_reader import StreamReader, breakup_chunk

    ended = False
    with path.open("rb") as stream:
        try:
            for record in StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=size).records:
                if isinstance(record, Metadata) and record.name == METADATA:
                    messages.metadata = dict(record.metadata)
                elif isinstance(record, Metadata) and record.name == ENDING and messages.metadata is not None:
                    messages.metadata |= {key: value for key, value in record.metadata.items() if key != "record"}
                elif isinstance(record, Chunk):
                    yield breakup_chunk(record, validate_crc=True)
                ended = ended or isinstance(record, Footer)
        except Exception as error:  # a damaged file may raise anything in the reader
            short = stream.read(1) == b""
            messages.fault = "cut short" if short else f"damaged ({type(error).__name__})"


def _child(content: bytes) -> str:
    """Return the child frame of a transform."""
    return dict(protobuf_fields(content)).get(3, b"").decode(errors="replace")


def protobuf_fields(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield number and content of the fields of a protobuf message (protobuf.dev/programming-guides/encoding)."""
    at = 0
    while at < len(content):
        tag, at = _varint(content, at)
        kind = tag & 7
        if kind == 0:
            begin = at
            _, at = _varint(content, at)
            yield tag >> 3, content[begin:at]
            continue
        if kind == 2:
            length, at = _varint(content, at)
        elif kind in (1, 5):
            length = 8 if kind == 1 else 4
        else:
            raise ValueError("no protobuf message")
        if at + length > len(content):
            raise ValueError("protobuf message cut short")
        yield tag >> 3, content[at : at + length]
        at += length


def _varint(content: bytes, at: int) -> tuple[int, int]:
    """Return a number of seven bits a byte, and the index after it."""
    value = shift = 0
    while True:
        byte = content[at]
        value |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return value, at
