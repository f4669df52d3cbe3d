"""MCAP files of missions and radio: what their writers share, and a reader of all whole chunks.

Chunks are checked by their checksums, also those of a file that was cut short. Needs the extra `log`.
"""

import io
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Self

from hypertuna.errors import InputError
from hypertuna.io.files import read_bytes, unwritable

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


class McapWriter:
    """A log that is being written: a context that closes it."""

    def __init__(self, target: Path | IO[bytes], *, overwrite: bool = True) -> None:
        need_log()
        import foxglove
        from foxglove.mcap import MCAPCompression, MCAPWriteOptions

        self._context = foxglove.Context()
        options = MCAPWriteOptions(chunk_size=CHUNK, compression=MCAPCompression.Zstd, profile="hypertuna")
        try:
            self._file = foxglove.open_mcap(
                target, allow_overwrite=overwrite, context=self._context, writer_options=options
            )
        except OSError as error:
            raise unwritable(target, error) from None
        self.channels: dict[str, Any] = {}  # by topic

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def channel(self, topic: str, make: Callable[..., Any], **options: Any) -> Any:
        """Return the channel of a topic, made at the first call."""
        if topic not in self.channels:
            self.channels[topic] = make(topic, context=self._context, **options)
        return self.channels[topic]

    def write_metadata(self, name: str, facts: Mapping[str, str]) -> None:
        """Write a record of metadata."""
        self._file.write_metadata(name, dict(facts))

    def flush(self) -> None:
        """Write all messages to the disk in whole chunks."""
        self._file.flush()

    def close(self) -> None:
        """Finish the file with its index."""
        self._file.close()


@dataclass
class Messages:
    """Messages of a file until its end or its first fault."""

    times: dict[str, list[int]]  # of the messages of each topic [ns]
    contents: dict[str, list[bytes]]  # of the same messages
    metadata: dict[str, str] | None = None  # of the file's header
    chunks: int = 0  # number of whole chunks
    fault: str = ""  # description, empty for a sound file


def read_messages(path: str | Path, name: Callable[[str, bytes], str] | None = None) -> Messages:
    """Read the messages of all whole chunks of a file by topic, or by the `name` of a topic and a message's content."""
    need_log()
    content = read_bytes(path, "give the path of a .mcap file")
    if not content.startswith(MAGIC):
        raise InputError("must be an MCAP file", file=str(path), value="something else", fix="give a .mcap file")
    from mcap.records import Channel, Message

    messages = Messages({}, {})
    topics: dict[int, str] = {}
    for part in _chunks(content, messages):
        topics |= {record.id: record.topic for record in part if isinstance(record, Channel)}
        for record in part:
            if isinstance(record, Message) and record.channel_id in topics:
                topic = topics[record.channel_id]
                topic = topic if name is None else name(topic, record.data)
                messages.times.setdefault(topic, []).append(record.log_time)
                messages.contents.setdefault(topic, []).append(record.data)
        messages.chunks += 1
    return messages


def _chunks(content: bytes, messages: Messages) -> Iterator[list[Any]]:
    """Yield the records of each whole chunk; store metadata and the first fault."""
    from mcap.records import Chunk, Metadata
    from mcap.stream_reader import StreamReader, breakup_chunk

    stream, size = io.BytesIO(content), len(content)
    try:
        for record in StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=size).records:
            if isinstance(record, Metadata) and record.name == METADATA:
                messages.metadata = dict(record.metadata)
            elif isinstance(record, Metadata) and record.name == ENDING and messages.metadata is not None:
                messages.metadata |= {key: value for key, value in record.metadata.items() if key != "record"}
            elif isinstance(record, Chunk):
                yield breakup_chunk(record, validate_crc=True)
    except Exception as error:  # a damaged file may raise anything in the reader
        messages.fault = f"damaged ({type(error).__name__})" if stream.read(1) else "cut short"
