"""MCAP files of missions and radio: their common writer, and a reader of all complete chunks.

The checksum of every chunk is checked, also in a file that was cut short. Needs the extra `log`.
"""

import fcntl
import io
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any

from hypertuna.errors import InputError
from hypertuna.io.door import read_bytes
from hypertuna.io.extras import need
from hypertuna.io.files import Closing, check_replaceable, unwritable

CHUNK = 64 * 1024  # bytes before compression: a few seconds of a mission
NANO = 1_000_000_000  # ns in 1 s
METADATA, ENDING = "hypertuna", "hypertuna-end"  # names of the metadata records at the start and the end of a log
LINK = "link"  # metadata key that only a radio log has
MAGIC = b"\x89MCAP0\r\n"  # first and last bytes of a file
# Limits against decompression bombs; logs of missions shrink to a third. Bytes of a chunk; a file may unpack to
# MAX_UNPACKED bytes and MAX_RATIO times its size.
MAX_CHUNK, MAX_UNPACKED, MAX_RATIO = 4 << 20, 4 << 20, 30
FOREIGN_CHUNK = 32 << 20  # bytes of a chunk in files of other programs
# Limits of a file, enough for 40 minutes of a mission: bytes in chunks, in other records, in one metadata record;
# messages.
MOST, OTHERS, HEADER, MESSAGES = 200 << 20, 32 << 20, 1 << 20, 1_000_000
# What is wrong with a record that is too long
LONG = f"longer than is read at once ({MOST >> 20} MB or {MESSAGES} messages)"
LAST = 2**63  # ns: a later time can only be damage


def need_log() -> None:
    """Check that the packages of the extra `log` are installed."""
    need("log", "foxglove", "mcap", by="logs")


class _Memory(io.RawIOBase):
    """Buffer of the bytes written since the last call of `taken`; positions count from the start of the file."""

    def __init__(self) -> None:
        self._before, self._content = 0, io.BytesIO()

    def write(self, content: Any) -> int:
        """Keep bytes."""
        return self._content.write(content)

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Go to a position."""
        return self._before + self._content.seek(offset - self._before * (whence == io.SEEK_SET), whence)

    def tell(self) -> int:
        """Return the position."""
        return self._before + self._content.tell()

    def taken(self) -> bytes:
        """Return the buffered bytes and clear the buffer."""
        content, self._content = self._content.getvalue(), io.BytesIO()
        self._before += len(content)
        return content


class McapWriter(Closing):
    """A log that is being written: a context that closes it.

    The library writes to memory, for it cannot handle a full disk; `flush` writes to the file, and raises InputError.
    """

    def __init__(self, target: Path | IO[bytes], *, overwrite: bool = True) -> None:
        need_log()
        import foxglove
        from foxglove.mcap import MCAPCompression, MCAPWriteOptions

        self._context = foxglove.Context()
        options = MCAPWriteOptions(chunk_size=CHUNK, compression=MCAPCompression.Zstd, profile="hypertuna")
        self._target: Any = target
        try:
            if isinstance(target, Path):
                self._target = _open_locked(target, overwrite)
        except OSError as error:
            raise unwritable(target, error) from None
        self._memory = _Memory()
        self._file = foxglove.open_mcap(self._memory, context=self._context, writer_options=options)
        self.channels: dict[str, Any] = {}  # by topic

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
        self._write()

    def close(self) -> None:
        """Finish the file with its index; an empty one is removed."""
        self._file.close()
        try:
            self._write()
        finally:
            if isinstance(self._target, io.FileIO):
                self._target.close()

    def _write(self) -> None:
        """Write the bytes in memory to the file; nothing more after a failure."""
        unwritten = memoryview(self._memory.taken())
        try:
            while unwritten and not self._target.closed:
                unwritten = unwritten[self._target.write(unwritten) :]
        except OSError as error:
            empty = not self._target.tell()
            self._target.close()
            if empty:
                Path(self._target.name).unlink(missing_ok=True)
            raise unwritable(self._target.name, error) from None


def _open_locked(path: Path, overwrite: bool) -> io.FileIO:
    """Open and empty a file for writing, locked against other processes that would write it."""
    check_replaceable(path)
    file = io.FileIO(path, "a" if overwrite else "x")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        file.truncate(0)
    except BlockingIOError:
        file.close()
        fix = "wait until that run ends, or give another file"
        raise InputError("is being written by another run", file=str(path), fix=fix) from None
    except OSError:  # a file system without locks
        file.truncate(0)
    return file


@dataclass
class Messages:
    """Messages of a file until its end or its first fault."""

    times: dict[str, list[int]]  # of the messages of each topic [ns]
    contents: dict[str, list[bytes]]  # contents of the same messages
    metadata: dict[str, str] | None = None  # of the file's header
    chunks: int = 0  # number of whole chunks
    fault: str = ""  # description, empty for a sound file
    kinds: dict[str, tuple[str, str]] = field(default_factory=dict)  # topic -> encoding and name of its schema


def read_messages(
    path: str | Path, name: Callable[[str, bytes], str] | None = None, *, foreign: bool = False
) -> Messages:
    """Read the messages of all complete chunks of a file, by topic.

    name: returns another key for a message, from its topic and content. foreign: the file is that of another program,
    which may write messages outside of chunks.
    """
    need_log()
    content = read_bytes(path, "log")
    if not content.startswith(MAGIC):
        raise InputError("must be an MCAP file", file=str(path), value="something else", fix="give a .mcap file")
    from mcap.records import Channel, Message, Schema

    messages = Messages({}, {})
    topics: dict[int, str] = {}
    schemas: dict[int, str] = {}
    count = 0
    for records in _chunks(content, messages, foreign=foreign):
        schemas |= {record.id: record.name for record in records if isinstance(record, Schema)}
        for channel in (record for record in records if isinstance(record, Channel)):
            topics[channel.id] = channel.topic
            messages.kinds[channel.topic] = channel.message_encoding, schemas.get(channel.schema_id, "")
        received = [record for record in records if isinstance(record, Message) and record.channel_id in topics]
        count += len(received)
        if count > MESSAGES:
            messages.fault = LONG
            break
        if any(record.log_time >= LAST for record in received):
            messages.fault = "damaged (a time beyond 2262)"
            break
        for record in received:
            topic = topics[record.channel_id]
            topic = topic if name is None else name(topic, record.data)
            messages.times.setdefault(topic, []).append(record.log_time)
            messages.contents.setdefault(topic, []).append(record.data)
        messages.chunks += 1
    return messages


def is_radio_log(path: str | Path) -> bool:
    """Return whether a file is a log of the radio: its metadata comes before the first chunk."""
    need_log()
    messages = Messages({}, {})
    next(_chunks(read_bytes(path, "log"), messages), None)
    return LINK in (messages.metadata or {})


def _chunks(content: bytes, messages: Messages, *, foreign: bool = False) -> Iterator[list[Any]]:
    """Yield the records of each whole chunk (of a foreign file, also those outside); store metadata and first fault."""
    from mcap.records import Channel, Chunk, Message, Metadata, Schema
    from mcap.stream_reader import StreamReader, breakup_chunk

    stream, size = io.BytesIO(content), len(content)
    chunk_limit = FOREIGN_CHUNK if foreign else MAX_CHUNK
    room, largest = MAX_UNPACKED + MAX_RATIO * size, min(size, chunk_limit + HEADER)
    done = packed = 0  # bytes of the chunks so far, unpacked and as stored
    try:
        for record in StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=largest).records:
            if isinstance(record, Metadata) and sum(map(len, record.metadata.values())) > HEADER:
                raise ValueError("a header is too large")
            if isinstance(record, Metadata) and record.name == METADATA:
                messages.metadata = dict(record.metadata)
            elif isinstance(record, Metadata) and record.name == ENDING and messages.metadata is not None:
                messages.metadata |= {key: value for key, value in record.metadata.items() if key != "record"}
            elif isinstance(record, Chunk):
                done, packed = done + record.uncompressed_size, packed + len(record.data)
                if record.uncompressed_size > chunk_limit or done > room:
                    messages.fault = "damaged (it unpacks to much more than a log)"
                    return
                if done > MOST:
                    messages.fault = LONG
                    return
                unpacked = replace(record, compression="", data=_unpacked(record))
                yield breakup_chunk(unpacked, validate_crc=True)
            elif foreign and isinstance(record, Schema | Channel | Message):
                yield [record]
            if stream.tell() - packed > OTHERS:
                raise ValueError("it is no log but in small part")
        if trailing := len(stream.read()):
            messages.fault = f"damaged ({trailing} bytes behind its end)"
    except MemoryError:
        raise
    except Exception as error:  # a damaged file may raise anything in the reader
        messages.fault = f"damaged ({type(error).__name__})" if stream.read(1) else "cut short"


def _unpacked(chunk: Any) -> bytes:
    """Return the content of a chunk, never more than the size that it states."""
    size: int = chunk.uncompressed_size
    if chunk.compression == "zstd":
        import zstandard

        with zstandard.ZstdDecompressor(max_window_size=FOREIGN_CHUNK).stream_reader(chunk.data) as reader:
            data: bytes = reader.read(size + 1)
    elif chunk.compression == "lz4":
        import lz4.frame

        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
    else:
        data = chunk.data
    if len(data) != size:
        raise ValueError("the size of a chunk is wrong")
    return data
