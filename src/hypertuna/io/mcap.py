"""MCAP files: what all logs share, and reading them chunk by chunk, each checked by its checksum.

Of a file that was cut short all whole chunks are read. Needs the extra `log`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError

__all__ = ["CHUNK", "ENDING", "HOW", "LINK", "METADATA", "NANO", "Pile", "need_log", "pile_of", "wire"]

HOW = "pip install 'hypertuna[log]'"
CHUNK = 64 * 1024  # bytes before compression: a few seconds of a mission
NANO = 1_000_000_000
METADATA, ENDING = "hypertuna", "hypertuna-end"
LINK = "link"  # in the head of a log of the radio
MAGIC = b"\x89MCAP0\r\n"


def need_log() -> None:
    """Check that the packages for logs are there.

    Raises
    ------
    InputError
        If one is not installed.
    """
    for name in ("foxglove", "mcap"):
        if find_spec(name) is None:
            raise InputError("is needed by logs and is not installed", key=name, fix=HOW)


@dataclass
class Pile:
    """What is taken from a file until its end or its first fault.

    Attributes
    ----------
    times : dict of str to list of int
        Of the messages of each topic, in ns.
    contents : dict of str to list of bytes
    metadata : dict of str to str or None
        Of the file's head.
    chunks : int
        Whole ones.
    fault : str
        What is wrong with the file, empty if nothing is.
    """

    times: dict[str, list[int]]
    contents: dict[str, list[bytes]]
    metadata: dict[str, str] | None = None
    chunks: int = 0
    fault: str = ""


def pile_of(path: str | Path) -> Pile:
    """Take the messages of all whole chunks of a file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Pile

    Raises
    ------
    InputError
        If the extra `log` is missing, or it is no MCAP file.
    """
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
    return _pile(Path(path), size)


def _pile(path: Path, size: int) -> Pile:
    """Take the messages of whole chunks, by topic."""
    from mcap.records import Channel, Message, Schema

    pile = Pile({}, {})
    topics: dict[int, str] = {}
    children: dict[int, bool] = {}  # channels of transforms
    for part in _chunks(path, size, pile):
        names: dict[int, str] = {}
        for record in part:
            if isinstance(record, Schema):
                children[record.id] = record.name == "foxglove.FrameTransform"
            elif isinstance(record, Channel):
                names[record.id] = record.topic
        topics |= names
        for record in part:
            if isinstance(record, Message) and record.channel_id in topics:
                topic = topics[record.channel_id]
                if topic == "/tf":
                    topic = f"/tf {_child(record.data)}"
                pile.times.setdefault(topic, []).append(record.log_time)
                pile.contents.setdefault(topic, []).append(record.data)
        pile.chunks += 1
    return pile


def _chunks(path: Path, size: int, pile: Pile) -> Iterator[list[Any]]:
    """Yield the records of every whole chunk; note metadata, and the first fault."""
    from mcap.records import Chunk, Footer, Metadata
    from mcap.stream_reader import StreamReader, breakup_chunk

    ended = False
    with path.open("rb") as stream:
        try:
            for record in StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=size).records:
                if isinstance(record, Metadata) and record.name == METADATA:
                    pile.metadata = dict(record.metadata)
                elif isinstance(record, Metadata) and record.name == ENDING and pile.metadata is not None:
                    pile.metadata |= {key: value for key, value in record.metadata.items() if key != "record"}
                elif isinstance(record, Chunk):
                    yield breakup_chunk(record, validate_crc=True)
                ended = ended or isinstance(record, Footer)
        except Exception as error:  # a damaged file ends the reader in any way whatever
            short = stream.read(1) == b""
            pile.fault = "cut short" if short else f"damaged ({type(error).__name__})"


def _child(content: bytes) -> str:
    """Name of the child frame of a transform."""
    return dict(wire(content)).get(3, b"").decode(errors="replace")


def wire(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Walk over the fields of a protobuf message (protobuf.dev/programming-guides/encoding).

    Parameters
    ----------
    content : bytes

    Yields
    ------
    int
        Number of the field.
    bytes
        Its content.

    Raises
    ------
    ValueError
        If it is no such message.
    """
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
    """Read a whole number of seven bits a byte: its value, and where it ends."""
    value = shift = 0
    while True:
        byte = content[at]
        value |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return value, at
