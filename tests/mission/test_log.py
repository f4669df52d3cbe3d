"""Logs: what goes in comes out, an independent reader agrees, and a file that was cut is read as far as it goes."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import time
import tracemalloc
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from disk import full_disk
from hypertuna.frames import angles_of, rotation_of
from hypertuna.mission.log_fields import fields
from hypertuna.mission.read_log import MALFORMED, Log, _data, protobuf_fields, read_header, read_log
from hypertuna.mission.record import COLUMNS, MissionRecord, joined
from voyage import voyage

foxglove = pytest.importorskip("foxglove", reason="needs the extra log")
from hypertuna.io.mcap import CHUNK, Messages  # noqa: E402
from hypertuna.mission.log import LogWriter, _head, write_log  # noqa: E402


@pytest.fixture(scope="module")
def record() -> MissionRecord:
    return voyage()


@pytest.fixture(scope="module")
def file(record: MissionRecord, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(record, tmp_path_factory.mktemp("log") / "run.mcap")


def same(read: MissionRecord, written: MissionRecord) -> None:
    """What was read is the beginning of what was written."""
    count = len(read.time)
    np.testing.assert_allclose(read.time, written.time[:count], atol=1e-9)
    assert set(read.data) == set(written.data)
    for name, values in written.data.items():
        np.testing.assert_allclose(read.data[name], values[:count], rtol=1e-14, atol=1e-15, err_msg=name)
    for name in (
        "name",
        "robot",
        "mission",
        "joints",
        "circuits",
        "modes",
        "reasons",
        "origin",
        "facts",
        "states",
        "faults",
    ):
        assert getattr(read, name) == getattr(written, name), name


# --- round trip


def test_a_record_comes_back(record: MissionRecord, file: Path) -> None:
    assert set(record.data) == set(COLUMNS)  # the test leaves nothing out
    log = read_log(file)
    same(log.record, record)
    assert len(log.record.time) == len(record.time) == 6000
    assert log.complete
    assert "whole" in log.sentence
    assert set(log.messages.values()) == {6000}
    assert log.chunks > 20


def test_a_record_of_position_and_attitude_alone(tmp_path: Path) -> None:
    bare = voyage(30, bare=True)
    same(read_log(write_log(bare, tmp_path / "bare.mcap")).record, bare)


def test_parts_become_one_file(record: MissionRecord, tmp_path: Path) -> None:
    parts = [voyage(20, seed=k) for k in (1, 2)]
    later = MissionRecord(**{**vars_of(parts[1]), "time": parts[1].time + 20, "facts": parts[0].facts})
    with LogWriter(tmp_path / "run.mcap") as writer:
        writer.write(parts[0])
        writer.write(later)
    same(read_log(tmp_path / "run.mcap").record, joined([parts[0], later]))


def vars_of(record: MissionRecord) -> dict[str, object]:
    return {name: getattr(record, name) for name in MissionRecord.__dataclass_fields__}


def test_a_mission_becomes_a_header_and_back(record: MissionRecord) -> None:
    head = _head(record)
    assert read_header(head).mission == record.mission
    table = json.loads(head)
    table["mission"]["waypoints"] = [[1, 2]]
    with pytest.raises(ht.InputError, match="must have a header in hypertuna's format"):
        read_header(json.dumps(table))


# --- an independent reader


def test_the_mcap_package_finds_every_checksum_right(file: Path, record: MissionRecord) -> None:
    from mcap.reader import make_reader
    from mcap.stream_reader import StreamReader

    with file.open("rb") as stream:
        kinds = Counter(type(one).__name__ for one in StreamReader(stream, validate_crcs=True).records)
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        topics = {channel.topic: channel for channel in summary.channels.values()}
        assert summary.statistics.message_count == kinds["Message"] == 14 * len(record.time)
        schemas = {summary.schemas[channel.schema_id].name for channel in topics.values()}
        assert {"foxglove.FrameTransform", "foxglove.LocationFix", "hypertuna.battery"} <= schemas
        assert topics["/tf"].message_encoding == "protobuf"
        assert topics["/battery"].message_encoding == "json"
        stamps = [message.log_time for _, _, message in reader.iter_messages(topics=["/motion"])]
    assert len(summary.chunk_indexes) > 20
    assert max(chunk.message_end_time - chunk.message_start_time for chunk in summary.chunk_indexes) < 20e9
    np.testing.assert_allclose(np.array(stamps) / 1e9, record.time, atol=1e-9)
    assert max(len(chunk) for chunk in chunks(file)) < 2 * CHUNK


def chunks(file: Path) -> list[bytes]:
    """Contents of all chunks, unpacked."""
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader, get_chunk_data_stream

    with file.open("rb") as stream:
        found = [one for one in StreamReader(stream, emit_chunks=True).records if isinstance(one, Chunk)]
    assert all(one.uncompressed_crc for one in found)
    return [get_chunk_data_stream(one, validate_crc=True)[0].read(one.uncompressed_size) for one in found]


def test_messages_tell_units_in_their_keys(file: Path, record: MissionRecord) -> None:
    from mcap.reader import make_reader

    last: dict[str, dict[str, object]] = {}
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.message_encoding == "json":
                last[channel.topic] = json.loads(message.data)
                assert schema is not None
                assert set(last[channel.topic]) <= set(json.loads(schema.data)["properties"])
    k = len(record.time) - 1
    data = record.data
    assert last["/motion"]["depth_m"] == pytest.approx(-data["position"][k, 2])
    assert last["/motion"]["heading_deg"] == pytest.approx(np.degrees(angles_of(data["attitude"][k])[2]))
    assert last["/motion"]["speed_m_s"] == 0.3
    assert last["/hydraulics"]["pump_pressure_I_left_kpa"] == pytest.approx(data["pump_pressure"][k, 0] / 1e3)
    assert last["/servos"]["servo_angle_II_right_deg"] == pytest.approx(np.degrees(data["servo_angle"][k, 3]))
    assert last["/fins"]["fin_starboard_deg"] == pytest.approx(np.degrees(-0.29))
    assert last["/battery"]["energy_wh"] == pytest.approx(record.energy[-1] / 3600)
    assert (last["/mode"]["mode_name"], last["/mode"]["reason_names"]) == ("surface", ["fix_due"])


def test_transforms_are_forward_left_up(file: Path, record: MissionRecord) -> None:
    """The x axis that viewers show is the way the head faces: minus our axis from nose to tail."""
    from mcap.reader import make_reader

    with file.open("rb") as stream:
        _, _, message = next(iter(make_reader(stream).iter_messages(topics=["/tf"])))
    parts = dict(protobuf_fields(message.data))
    assert (parts[2], parts[3]) == (b"world", b"robot")
    x, y, z, w = (np.frombuffer(dict(protobuf_fields(parts[5])).get(k, bytes(8)))[0] for k in (1, 2, 3, 4))
    ahead = rotation_of(np.array([w, x, y, z])) @ [1.0, 0.0, 0.0]
    ours = rotation_of(record.data["attitude"][0])
    np.testing.assert_allclose(ahead, -ours[:, 0], atol=1e-15)


# --- cut and damaged files


def test_a_full_disk_is_named_and_what_was_written_is_read(record: MissionRecord, tmp_path: Path) -> None:
    path, new = tmp_path / "run.mcap", tmp_path / "new.mcap"
    writer = LogWriter(path)
    with full_disk(200_000), pytest.raises(ht.InputError, match=r"run.mcap must be a writable file, but is not \(File"):
        write_parts(writer, record)
    writer.close({"status": "interrupted"})
    log = read_log(path)
    same(log.record, record)
    assert not log.complete
    with full_disk(0), pytest.raises(ht.InputError, match="new.mcap must be a writable file"), LogWriter(new) as writer:
        writer.write(record)
    assert not new.exists()


def write_parts(writer: LogWriter, record: MissionRecord) -> None:
    for k in range(0, len(record.time), 500):
        writer.write(record.part(slice(k, k + 500)))


def test_bytes_behind_the_end_are_told(file: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(file.read_bytes() + b"more")
    log = read_log(path)
    assert (log.complete, len(log.record.time)) == (False, 6000)
    assert log.sentence.startswith("The log is damaged (4 bytes behind its end)")


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
@pytest.mark.parametrize("stated", [1 << 28, 1000])
def test_a_bomb_is_not_unpacked(compression: str, stated: int, tmp_path: Path) -> None:
    """A chunk that unpacks to a quarter of a gigabyte, or says so: at once, without the memory, as a sentence."""
    import lz4.frame
    import zstandard
    from mcap.data_stream import RecordBuilder
    from mcap.records import Chunk

    size = 1 << 28
    pack = {"zstd": zstandard.ZstdCompressor(), "lz4": lz4.frame}[compression]
    data = pack.compress(bytes(size // 16))  # type: ignore[attr-defined]
    start = file_start(tmp_path)
    builder = RecordBuilder()
    for _ in range(16):
        Chunk(compression, data, 0, 0, 1, stated // 16).write(builder)
    path = tmp_path / "bomb.mcap"
    path.write_bytes(start + builder.end())
    tracemalloc.start()
    log = read_log(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert not log.complete
    assert "unpacks to much more than a log" in log.sentence if stated > 1000 else "ValueError" in log.sentence
    assert peak < 40e6


def file_start(folder: Path) -> bytes:
    """A short log without its end."""
    content = write_log(voyage(30, 10), folder / "start.mcap").read_bytes()
    return content[: content.rindex(b"\x0f" + (4).to_bytes(8, "little"))]  # its record DataEnd


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, MissionRecord]:
    """A log of 300 times in two dozen chunks."""
    whole, path = voyage(30, 10), tmp_path_factory.mktemp("log") / "short.mcap"
    with LogWriter(path) as writer:
        for k in range(0, 300, 25):
            writer.write(whole.part(slice(k, k + 25)))
    return path, whole


def tried(path: Path) -> tuple[Log | None, str]:
    """What a file has, or the error about it."""
    try:
        log = read_log(path)
    except ht.InputError as error:
        return None, str(error)
    return log, log.sentence


def test_a_file_cut_anywhere_is_read_up_to_its_last_whole_chunk(
    short: tuple[Path, MissionRecord], tmp_path: Path
) -> None:
    (file, record), cut, draw = short, tmp_path / "cut.mcap", random.Random(1)
    content, ends = file.read_bytes(), chunk_ends(file)
    assert len(ends) == 24
    rows = {0: 0}
    lengths = [*(draw.randrange(len(content)) for _ in range(30)), *ends, *(end - 1 for end in ends), 0, 4, 8, 50]
    for length in [*lengths, len(content) - 1]:
        cut.write_bytes(content[:length])
        log, told = tried(cut)
        whole = sum(end <= length for end in ends)
        assert "\n" not in told
        assert (log is None) == (whole == 0), length
        if log is not None:
            assert (log.chunks, log.complete) == (whole, False)
            assert rows.setdefault(whole, len(log.record.time)) == len(log.record.time)
            assert "cut short" in told
            same(log.record, record)
    times = [rows[whole] for whole in sorted(rows)]
    assert times == sorted(set(times))  # every chunk has some times more
    assert len(times) == 25
    assert times[-1] == 300


def chunk_ends(file: Path) -> list[int]:
    """Where every chunk ends in the file."""
    from mcap.reader import make_reader

    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return [chunk.chunk_start_offset + chunk.chunk_length for chunk in summary.chunk_indexes]


def test_a_flipped_bit_is_found(short: tuple[Path, MissionRecord], tmp_path: Path) -> None:
    (file, record), path, draw = short, tmp_path / "bad.mcap", random.Random(2)
    content, end, compared = file.read_bytes(), chunk_ends(file)[-1], 0
    for k in range(60):
        spoiled = bytearray(content)
        at = draw.randrange(8, end if k % 4 else len(content))
        spoiled[at] ^= 1 << draw.randrange(8)
        path.write_bytes(spoiled)
        log, told = tried(path)
        assert "\n" not in told
        assert log is None or not log.complete or at >= end  # behind the chunks is the index, which is not needed
        if log is not None:  # all that is read is right, or the head names it otherwise
            rows = len(log.record.time)
            np.testing.assert_allclose(log.record.time, record.time[:rows], atol=1e-9)
            for name in set(log.record.data) & set(record.data):
                np.testing.assert_allclose(log.record.data[name], record.data[name][:rows], rtol=1e-14, atol=1e-15)
                compared += 1
    assert compared > 60


CHILD = """
import sys, time
from pathlib import Path
from voyage import voyage
from hypertuna.mission.log import LogWriter
from hypertuna.mission.record import MissionRecord
whole = voyage(150)
names = MissionRecord.__dataclass_fields__
writer = LogWriter(Path(sys.argv[1]))
for k in range(0, len(whole.time), 200):
    here = slice(k, k + 200)
    part = {name: getattr(whole, name) for name in names}
    part |= {"time": whole.time[here], "data": {name: values[here] for name, values in whole.data.items()}}
    writer.write(MissionRecord(**part))
    print(k + 200, flush=True)
    time.sleep(0.02)
"""


def test_what_was_written_before_a_kill_is_there(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    command = [sys.executable, "-c", CHILD, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1]) as child:
        assert child.stdout is not None
        done = 0
        for line in child.stdout:
            done = int(line)
            if done >= 1000:
                child.send_signal(signal.SIGKILL)
                break
        child.wait()
    log = read_log(path)
    assert not log.complete
    assert len(log.record.time) >= done
    same(log.record, voyage(150))


# --- what is no log


def test_other_files_are_told(tmp_path: Path) -> None:
    with pytest.raises(ht.InputError, match=r"nowhere.mcap must be a file, but is missing"):
        read_log(tmp_path / "nowhere.mcap")
    (tmp_path / "text.mcap").write_text("not this")
    with pytest.raises(ht.InputError, match=r"text.mcap must be an MCAP file, but is something else"):
        read_log(tmp_path / "text.mcap")
    context = foxglove.Context()
    with foxglove.open_mcap(tmp_path / "other.mcap", context=context):
        foxglove.Channel("/x", context=context).log({"a": 1})
    with pytest.raises(ht.InputError, match=r"other.mcap must be a hypertuna log: it lacks the header"):
        read_log(tmp_path / "other.mcap")
    with pytest.raises(ht.InputError, match="must be a writable file"):
        LogWriter(tmp_path / "nowhere" / "a.mcap")


def test_a_value_beyond_the_largest_number_is_malformed() -> None:
    """Energy is stored in Wh: 1e308 Wh are 3.6e311 J, which no double holds."""
    (row,) = [field for rows in fields(["energy"], (), ()).values() for field in rows if field.name == "energy"]
    content = Messages({"/power": [0]}, {"/power": [json.dumps({row.key: 1e308}).encode()]})
    with pytest.raises(MALFORMED):
        _data(content, {"/power": [row]}, 1)


def test_without_the_extra_it_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, record: MissionRecord, tmp_path: Path
) -> None:
    monkeypatch.setattr("hypertuna.io.extras.find_spec", lambda name: None)
    with pytest.raises(ht.InputError, match="foxglove is needed by logs and is not installed: pip install '"):
        write_log(record, tmp_path / "run.mcap")
    assert not list(tmp_path.iterdir())


# --- records


def test_a_record_knows_its_way(record: MissionRecord) -> None:
    """80 m of legs at 0.3 m/s last 267 s; the nose's swing to and fro does not count as way."""
    assert record.distance == pytest.approx(80, abs=1.0)
    assert record.depth[-1] == pytest.approx(2)
    assert record.energy[-1] == pytest.approx(300 * (8 + 2 * 2 / np.pi), rel=1e-2)


def test_energy_of_the_servos_is_exact_for_power_that_changes_steadily(record: MissionRecord) -> None:
    """Power 3 + 2 t W at uneven times: 3 t + t^2 J, by the trapezoidal rule alone."""
    time = np.array([0.0, 0.5, 2.0, 2.25, 7.0])
    pose = {name: record.data[name][:5] for name in ("position", "attitude")}
    metered = replace(record, time=time, data=pose | {"power": 3 + 2 * time})
    assert metered.energy == pytest.approx(3 * time + time**2, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"speeed": 1}, "speeed is not a known quantity"),
        ({"depth": np.zeros(3)}, "depth is not a known quantity"),
        ({"charge_left": np.zeros(3)}, r"charge_left must have the shape \(600,\), but is of shape \(3,\)"),
        ({"position": None}, "position is missing"),
        ({"power": np.full(600, np.nan)}, "power must be finite, but is not finite at 0 s"),
    ],
)
def test_bad_records_are_told(change: dict[str, object], sentence: str) -> None:
    short = voyage(30)
    data = {name: values for name, values in {**short.data, **change}.items() if values is not None}
    with pytest.raises(ht.InputError, match=sentence):
        MissionRecord("a", "b", short.mission, short.time, data, short.joints, short.circuits)
    with pytest.raises(ht.InputError, match="must have at least one time, all of them finite and increasing"):
        MissionRecord("a", "b", short.mission, short.time[::-1], short.data, short.joints, short.circuits)


def test_writing_keeps_up(record: MissionRecord, tmp_path: Path) -> None:
    """5 minutes at 20 Hz, 14 topics: far faster than the mission is flown."""
    begin = time.monotonic()
    write_log(record, tmp_path / "run.mcap")
    assert time.monotonic() - begin < 30
