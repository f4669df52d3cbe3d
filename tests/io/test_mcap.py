"""MCAP files: chunks of a stated size, and what is refused of a file that unpacks to much more than it has."""

from pathlib import Path
from zlib import crc32

import pytest

from hypertuna.errors import InputError

pytest.importorskip("foxglove", reason="needs the extra log")

import foxglove
import lz4.frame
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, Header, Message, Metadata
from mcap.stream_reader import StreamReader

from hypertuna.io import mcap
from hypertuna.io.mcap import MAGIC, McapWriter, Messages, is_radio_log, read_messages

MIB = 1 << 20
PACK = {"zstd": zstandard.ZstdCompressor().compress, "lz4": lz4.frame.compress, "": bytes}


def content(size: int) -> bytes:
    """A channel and a message of zeros, together of a size [bytes]."""
    builder = RecordBuilder()
    Channel(id=1, topic="/a", message_encoding="", metadata={}, schema_id=0).write(builder)
    first: bytes = builder.end()
    Message(1, 7, bytes(size - len(first) - 31), 0, 0).write(builder)  # 9 bytes before a record, 22 before its data
    whole: bytes = first + builder.end()
    assert len(whole) == size
    return whole


def read(
    path: Path, *sizes: int, pack: str = "zstd", stated: int | None = None, wrong: int = 0, link: str = ""
) -> Messages:
    """Read a file of chunks; the last has another stated size, all have checksums that are `wrong` by some bits."""
    builder = RecordBuilder()
    Header(profile="hypertuna", library="").write(builder)
    if link:
        Metadata(name="hypertuna", metadata={link: "udp"}).write(builder)
    for k, size in enumerate(sizes):
        part = content(size)
        told = size if stated is None or k < len(sizes) - 1 else stated
        Chunk(pack, PACK[pack](part), 7, 7, crc32(part) ^ wrong, told).write(builder)
    path.write_bytes(MAGIC + builder.end())
    return read_messages(path)


@pytest.mark.parametrize("pack", PACK)
def test_whole_chunks_are_read(pack: str, tmp_path: Path) -> None:
    messages = read(tmp_path / "a.mcap", 100, 1000, pack=pack)
    assert messages.times == {"/a": [7, 7]}
    assert (messages.chunks, len(messages.contents["/a"][1]) - len(messages.contents["/a"][0])) == (2, 900)


@pytest.mark.parametrize("pack", PACK)
@pytest.mark.parametrize(("stated", "wrong"), [(99, 0), (101, 0), (100, 1)])
def test_a_wrong_size_or_checksum_is_a_fault(pack: str, stated: int, wrong: int, tmp_path: Path) -> None:
    messages = read(tmp_path / "a.mcap", 100, pack=pack, stated=stated, wrong=wrong)
    assert not messages.times
    assert messages.fault


@pytest.mark.parametrize(("size", "chunks"), [(4 * MIB, 1), (4 * MIB + 1, 0)])
def test_a_chunk_unpacks_to_four_mebibytes_at_most(size: int, chunks: int, tmp_path: Path) -> None:
    messages = read(tmp_path / "a.mcap", size)
    assert messages.chunks == chunks
    assert ("unpacks to much more" in messages.fault) == (not chunks)


def test_a_file_unpacks_to_thirty_times_its_size_and_four_mebibytes(tmp_path: Path) -> None:
    path, sizes = tmp_path / "a.mcap", (4 * MIB, 1000)
    read(path, *sizes)
    most = 30 * path.stat().st_size  # of the second chunk, which states it
    for stated, refused in ((most, False), (most + 1, True)):  # not refused, it is unpacked, and of another size
        messages = read(path, *sizes, stated=stated)
        assert messages.chunks == 1
        assert ("unpacks to much more than a log" in messages.fault) is refused


def test_a_long_log_is_read_up_to_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its fault says that it is longer, not that it is damaged: logs of hours are sound."""
    for name, value in (("MOST", 2500), ("MESSAGES", 2)):
        with monkeypatch.context() as patch:
            patch.setattr(mcap, name, value)
            messages = read(tmp_path / "a.mcap", 1000, 1000, 1000)
        assert messages.chunks == 2
        assert messages.fault.startswith("longer than is read at once")
    assert read(tmp_path / "a.mcap", 1000, 1000, 1000).chunks == 3


def test_other_records_than_chunks_are_bounded(tmp_path: Path) -> None:
    """Each of 400,000 parts of metadata, or entries of an index: minutes and gigabytes, if the file is of them."""
    builder = RecordBuilder()
    Header(profile="hypertuna", library="").write(builder)
    Metadata(name="hypertuna", metadata={"record": "x" * (mcap.HEADER + 1)}).write(builder)
    (path := tmp_path / "a.mcap").write_bytes(MAGIC + builder.end())
    assert read_messages(path).metadata is None
    Header(profile="hypertuna", library="").write(builder)
    Metadata(name="other", metadata={f"{k}": "" for k in range(50_000)}).write(builder)
    record = builder.end()
    path.write_bytes(MAGIC + record * (mcap.OTHERS // len(record) + 20))
    assert read_messages(path).fault == "damaged (ValueError)"


def test_another_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"MCAP")
    with pytest.raises(InputError, match="must be an MCAP file, but is something else: give a .mcap file"):
        read_messages(tmp_path / "a.mcap")


def test_a_log_of_the_radio_names_its_link_before_its_first_chunk(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    for link, radio in (("link", True), ("robot", False), ("", False)):
        assert read(path, 100, link=link).metadata == ({link: "udp"} if link else None)
        assert is_radio_log(path) is radio


def test_a_writer_fills_chunks_of_64_kibibytes(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with McapWriter(path) as writer:
        channel = writer.channel("/a", foxglove.Channel, schema={"type": "object"})
        for k in range(200):
            channel.log(bytes(1000), log_time=k)
    with path.open("rb") as file:
        sizes = [
            one.uncompressed_size for one in StreamReader(file, emit_chunks=True).records if isinstance(one, Chunk)
        ]
    assert all(64 * 1024 - 1100 < size < 64 * 1024 + 1100 for size in sizes[:-1])
    assert read_messages(path).times == {"/a": list(range(200))}
