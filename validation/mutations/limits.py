"""Read the most dangerous files that are just within the limits of `hypertuna.io.door`, and show time and memory.

    python validation/mutations/limits.py          # a table for README.md; some minutes
    python validation/mutations/limits.py journal  # files whose names begin so

Each file is read in its own process. Exit code 1 if one takes more than 10 s of processor or 1 GB, or ends otherwise
than in a result or a sentence.
"""

import contextlib
import io
import json
import os
import resource
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

import numpy as np  # noqa: E402

from black_box import head, sealed, tick  # noqa: E402
from hypertuna import _core  # noqa: E402
from hypertuna.errors import InputError  # noqa: E402
from hypertuna.fe.fields import DISPLACEMENT, FACE, STRAIN, STRESS  # noqa: E402
from hypertuna.firmware.black_box import record_dtype  # noqa: E402
from hypertuna.io.checkpoint import Journal, _with_checksum  # noqa: E402
from hypertuna.io.door import CELLS, DEPTH, KINDS, MAX_MEMORY, MB, ROWS, RUNS, UNPACKED  # noqa: E402
from hypertuna.mission.read_log import read_log  # noqa: E402
from hypertuna.parallel.checks import TEXTS, checksum  # noqa: E402
from mutations import forged, surfaces  # noqa: E402
from mutations.judge import LONGEST  # noqa: E402
from mutations.strangers import READERS, whole  # noqa: E402

ABOVE = 1000 * MB  # memory that a reader may take for a file
BY_NAME = {reader.name: reader for reader in READERS}
PARTS = ".a" * (DEPTH - 2)  # of a key, as deep as the limit allows
Make = Callable[[], bytes]


def filled(kind: str, piece: bytes, begin: bytes = b"", end: bytes = b"") -> bytes:
    """Return the largest file that its kind allows, filled with copies of a piece."""
    return begin + piece * ((KINDS[kind].largest - len(begin) - len(end)) // len(piece)) + end


def table(reader: str, rows: int) -> bytes:
    """Return a table of many rows: the last row of a valid one repeated, with frames numbered on."""
    lines = [line for line in whole(BY_NAME[reader]).splitlines(keepends=True) if line[:1] != b"#"]
    lines[-1] = lines[-1].rstrip() + b"\n"
    kept = lines[:3] if reader == "markers of DeepLabCut" else lines[:1]
    names, cells = lines[0].strip().split(b","), lines[-1].split(b",")
    count = min(rows, CELLS // len(cells), KINDS["csv"].largest // (len(lines[-1]) + 6)) - 10
    place = next((names.index(name) for name in (b"time_s", b"frame_idx", b"scorer") if name in names), None)
    if place is None:
        return b"".join(kept) + lines[-1] * count
    before, after = cells[:place], cells[place + 1 :]
    return b"".join(kept) + b"".join(b",".join([*before, b"%d" % k, *after]) for k in range(count))


def journal(record: bytes, size: int) -> bytes:
    """Return a journal of one record repeated, with the right checksums."""
    with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / "j", {"kind": "search"}) as made:
        content = (made._path).read_bytes()
        total, lines = made._sum, [content]
    while size > 0:
        line, total = _with_checksum(record, total)
        lines.append(line)
        size -= len(line)
    return b"".join(lines)


def log(size: int, *, empty: bool = False) -> bytes:
    """Return a mission's log that unpacks to a given size, also one of empty messages."""
    from mcap.records import Channel, Message, Metadata, Schema
    from mcap.writer import CompressionType, Writer

    out, records = io.BytesIO(), forged._records(whole(BY_NAME["log"]))
    writer = Writer(out, chunk_size=65536, compression=CompressionType.ZSTD)
    writer.start("hypertuna", "")
    schemas, channels = {0: 0}, {}
    for record in records:
        if isinstance(record, Schema):
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel):
            place = schemas.get(record.schema_id, 0)
            channels[record.id] = writer.register_channel(record.topic, record.message_encoding, place)
        elif isinstance(record, Metadata):
            writer.add_metadata(record.name, dict(record.metadata))
    messages = [record for record in records if isinstance(record, Message)]
    for k in range(1_000_000):
        for one in messages:
            data = b"" if empty else one.data
            writer.add_message(channels[one.channel_id], one.log_time + k * 2 * 10**9, data, 0)
            size -= len(data) + 31
        if size < 0:
            break
    writer.finish()
    return out.getvalue()


def box(boot: int) -> bytes:
    """Return the largest black box, whose clock restarts after every `boot` ticks."""
    one = np.frombuffer(tick(0), "<u4")
    table = np.tile(one, (KINDS["box"].largest // one.nbytes - 1, 1))
    place = record_dtype(2).fields["tick"][1] // 4  # type: ignore[index]
    table[:, 1 + place] = np.arange(len(table)) % boot
    table[:, -1] = np.cumsum(table[:, :-1], axis=1, dtype=np.uint32).sum(axis=1, dtype=np.uint32)
    return head() + table.tobytes()


def records(opcode: int, body: bytes, size: int) -> bytes:
    """Return records of a log outside of its chunks."""
    one = bytes([opcode]) + struct.pack("<Q", len(body)) + body
    return b"\x89MCAP0\r\n" + one * (size // len(one))


def manifest(labels: int) -> bytes:
    """Return a manifest with a number of labels."""
    layout = {"sizes": {"i": labels}, "variables": {"v": {}}, "coordinates": {"i": ["i", ["ab"] * labels, {}]}}
    facts = {"header": {}, "total": labels, "size": 1000, "command": "", "layout": layout | {"facts": {}, "table": {}}}
    return json.dumps({"mark": "hypertuna shards", "sha256": checksum(facts), **facts}).encode()


def shards(columns: dict[str, Any]) -> bytes:
    """Return a folder with one shard, as an archive."""
    from hypertuna.parallel.layout import Layout
    from hypertuna.parallel.shards import Cases, make_shards

    count = len(next(iter(columns.values())))
    layout = Layout({"i": count}, {name: {} for name in columns}, {}, {}, {})
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "a.shards"
        make_shards(Cases({}, count, layout, lambda *_: columns), place, size=count, command="")
        return forged.packed(place)


def surface(faces: int) -> bytes:
    """Return a surface of many triangles on three points."""
    parts: dict[str, Any] = {"Points": np.eye(3), "connectivity": np.arange(3 * faces, dtype="<i4") % 3}
    parts |= {"offsets": np.arange(3, 3 * faces + 1, 3, dtype="<i4"), "types": np.full(faces, 5, np.uint8)}
    return surfaces.written(parts | {DISPLACEMENT: np.eye(3), STRESS: np.ones(3), STRAIN: np.ones(3), FACE: np.ones(3)})


def maps(*, index: bool) -> bytes:
    """Return the body of a record with many entries: metadata, or an index of messages."""
    if index:
        return struct.pack("<HI", 0, 4_800_000) + bytes(4_800_000)
    entries = b"".join(struct.pack("<I8sI", 8, b"%08d" % k, 0) for k in range(300_000))
    return struct.pack("<II", 0, len(entries)) + entries


def npz(**arrays: Any) -> bytes:
    """Return arrays as an archive, compressed."""
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


MARKS = (_core.RECORD_MARK >> 16 << 16) | (_core.RECORD_TICK << 8)  # mark and kind of a tick's record in a black box
# Tables that readers turn into objects, with a lower limit of rows
OBJECTS = ("steady runs", "places", "bench", "calibration")
NUMBERS = b'{"asked": [' + b"0.12345678901234567, " * 30_000 + b'0], "told": 1}'  # record with a long list of numbers
# Name, reader, content. Kinds that are read whole and compared (key, header, state) need memory of their size.
FILES: tuple[tuple[str, str, Make], ...] = (
    ("toml, dotted keys below a deep heading", "robot", lambda: (
        "[b" + ".b" * (DEPTH - 4) + "]\n" + "\n".join(f"k{k}{PARTS} = 1" for k in range(MB // 55))).encode()),
    ("toml, headings", "robot", lambda: "\n".join(f"[k{k}{PARTS}]" for k in range(MB // 55)).encode()),
    ("toml, open texts", "robot", lambda: filled("toml", b'\\"""\n', b'a = """\n')),
    ("toml, escaped quotes", "robot", lambda: filled("toml", b'\\"', b'a = \\"')),
    *((f"csv, {name}", name, lambda name=name: table(name, RUNS if name in OBJECTS else ROWS)) for name in (
        "steady runs", "markers", "markers of DeepLabCut", "markers of SLEAP", "places", "bench", "tensile test",
        "calibration")),
    ("csv, rows of two cells", "markers", lambda: b"x,y\n" + b"1.234567,1.234567\n" * (ROWS - 2)),
    ("csv, a sign of four bytes", "markers", lambda: filled("csv", b"x" * 90_000 + b"\n", "x,y\U0001f600\n".encode())),
    ("plan, deep and open", "plan of GPX", lambda: filled("plan", b"<a>", b"<gpx>")),
    ("plan, elements", "plan of GPX", lambda: filled("plan", b"<a b=''/>", b"<gpx>", b"</gpx>")),
    ("plan, points of KML", "plan of KML", lambda: filled("plan", b"<Point/>", b"<kml>", b"</kml>")),
    ("plan, short lines", "plan of ArduPilot", lambda: filled("plan", b"1\n", b"QGC WPL 110\n")),
    ("plan, objects", "plan of QGroundControl", lambda: filled("plan", b'{"a":1},', b'{"a":[', b"1]}")),
    ("log, a mission of 38 minutes", "log", lambda: log(190 * MB)),
    ("log, empty messages", "log", lambda: log(31_000_000, empty=True)),
    ("log, radio", "radio log", lambda: log(31_000_000, empty=True)),
    ("log, metadata", "log", lambda: records(0x0C, maps(index=False), 250 * MB)),
    ("log, indices", "log", lambda: records(0x07, maps(index=True), 250 * MB)),
    ("box, of ticks", "black box", lambda: box(10**9)),
    ("box, boots of three ticks", "black box", lambda: box(3)),
    ("box, marks", "black box", lambda: filled("box", struct.pack("<I", MARKS | 255), head())),
    ("box, records of nothing", "black box", lambda: filled("box", sealed(9, b"") + sealed(10, b""), head())),
    ("journal, numbers", "journal", lambda: journal(NUMBERS, KINDS["journal"].largest - len(NUMBERS) - 1000)),
    ("journal, small records", "journal", lambda: journal(b'{"a": 1}', MAX_MEMORY // 672 * 29)),
    ("journal, short lines", "journal", lambda: filled("journal", b"a\n", journal(b"", 0))),
    ("manifest, labels", "shards", lambda: manifest(5_500_000)),
    ("manifest, objects", "shards", lambda: b'{"a":[' + b'{"a":1},' * (MAX_MEMORY // 450) + b"1]}"),
    ("shard, numbers", "shards", lambda: shards({f"v{k}": np.ones(1_000_000) for k in range(30)})),
    ("surface, faces", "surface", lambda: surface(KINDS["surface"].largest // 17 - 100)),
    ("shard, texts", "shards", lambda: shards({"v": np.full(TEXTS // 2, "texts of 15 let", dtype=object)})),
    ("policy, weights of a byte", "policy", lambda: npz(
        weight0=np.zeros((5000, UNPACKED // 5100), "i1"), bias0=np.zeros(5000, "i1"))),
    ("policy, texts", "policy", lambda: npz(weight0=np.full((2000, UNPACKED // 8200), "1", "U1"))),
    ("scheduler, objects", "scheduler file", lambda: filled("scheduler", b'{"a":1},', b'{"address":[', b"1]}")),
)  # fmt: skip


def read(name: str, content: bytes) -> tuple[float, float, str]:
    """Read a file in its own process; return processor time [s], memory added [MB], and the outcome."""
    reader = BY_NAME[name]
    call = read_log if name == "log" else reader.read  # which reads it twice
    here, there = os.pipe()
    if (child := os.fork()) == 0:
        outcome = ""
        with tempfile.TemporaryDirectory() as folder:
            (path := Path(folder) / reader.file).parent.mkdir(exist_ok=True)
            path.write_bytes(whole(reader))
            with contextlib.suppress(InputError):
                reader.read(path)  # so that libraries are not counted
            for other in path.parent.iterdir():
                other.unlink()
            path.write_bytes(content)
            resource.setrlimit(resource.RLIMIT_CPU, (120, 120))
            Path("/proc/self/clear_refs").write_text("5")
            before, begin = peak(), time.process_time()
            try:
                call(path)
                outcome = "read"
            except InputError as error:
                outcome = "refused" if "\n" not in str(error) else "refused at length"
            except BaseException as error:  # of a reader: a fault
                outcome = f"**{type(error).__name__}**"
            spent = time.process_time() - begin
            os.write(there, json.dumps((spent, (peak() - before) / MB, outcome)).encode())
        os._exit(0)
    os.close(there)
    with open(here, "rb") as line:
        told = line.read()
    os.waitpid(child, 0)
    return tuple(json.loads(told)) if told else (120.0, 0.0, "**killed**")


def peak() -> int:
    """Return the largest memory so far [bytes]."""
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.split("VmHWM:")[1].split()[0])


def rows() -> Iterator[bool]:
    """Print each file's row; yield whether the file is within the limits."""
    chosen = [one for one in FILES if not sys.argv[1:] or one[0].startswith(tuple(sys.argv[1:]))]
    print("| file | MB | processor, s | memory, MB | outcome |\n|---|---|---|---|---|")
    for name, reader, make in chosen:
        content = make()
        seconds, memory, outcome = read(reader, content)
        print(f"| {name} | {len(content) / MB:.2f} | {seconds:.1f} | {memory:.0f} | {outcome} |", flush=True)
        yield seconds <= LONGEST and memory <= ABOVE / MB and "*" not in outcome


if __name__ == "__main__":
    sys.exit(not all([*rows()]))
