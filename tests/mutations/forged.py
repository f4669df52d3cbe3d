"""Files with a structure, taken apart, damaged and put together again with the right checksums."""

import functools
import io
import json
import random
import struct
import tempfile
import warnings
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from black_box import head, sealed, tick
from hypertuna.io.checkpoint import Journal
from hypertuna.parallel.checks import checksum
from mutations.damage import LONG, of_bytes, of_structure, of_text

SQUARE = ((43.854, 125.302), (43.855, 125.302), (43.855, 125.303))
HOME = "0\t1\t0\t16\t0\t0\t0\t0\t43.854\t125.302\t584\t1"
ITEMS = [{"type": "SimpleItem", "frame": 3, "command": 16, "params": [0, 0, 0, None, *place, -1.5]} for place in SQUARE]
MISSION = {"cruiseSpeed": 0.4, "plannedHomePosition": [*SQUARE[0], 200], "items": ITEMS}
LINES = "\n".join(f"{k}\t0\t3\t16\t0\t0\t0\t0\t{north}\t{east}\t-1.5\t1" for k, (north, east) in enumerate(SQUARE, 1))
POINTS = "".join(f'<rtept lat="{north}" lon="{east}"><ele>-1.5</ele></rtept>' for north, east in SQUARE)
CORNERS = " ".join(f"{east},{north},-1.5" for north, east in SQUARE)
PLANS = {
    "of QGroundControl": json.dumps({"fileType": "Plan", "version": 1, "mission": MISSION}),
    "of ArduPilot": f"QGC WPL 110\n{HOME}\n{LINES}\n",
    "of GPX": f'<?xml version="1.0"?>\n<gpx version="1.1" creator="x"><rte>{POINTS}</rte></gpx>',
    "of KML": f"<kml><Document><Placemark><LineString><altitudeMode>absolute</altitudeMode><coordinates>\n{CORNERS}\n"
    "</coordinates></LineString></Placemark></Document></kml>",
}
DEEPLABCUT = "scorer,a,a,a,a,a,a\nbodyparts,nose,nose,nose,tail,tail,tail\ncoords,x,y,likelihood,x,y,likelihood\n" + (
    "".join(f"{k},{10 + k},{20 + k},0.9,{10 + k},{70 + k},0.95\n" for k in range(20))
)
SLEAP = "track,frame_idx,instance.score,nose.x,nose.y,nose.score,tail.x,tail.y,tail.score\n" + (
    "".join(f"fish,{k},0.9,{10 + k},{20 + k},0.9,{10 + k},{70 + k},0.95\n" for k in range(20))
)
TIMES = (2**63 - 1, 2**63, 2**64 - 1, 0)
HUGE = 100_000_000  # numbers of an array that is not there


# --- logs

CAMERA = """format = 1
width_px = 640
height_px = 360
focal_px = 800.0
center_px = [319.5, 179.5]
lens_k1 = -0.1
place_m = [0.0, 0.0, 1.6]
tilt_deg = [1.0, 0.0, 0.0]
"""
SECTIONS = "from_nose_m,width_m,height_m\n0,0,0\n0.1,0.04,0.07\n0.24,0.01,0.02\n0.3,0.002,0.08\n"
BLINKS = "time_s,blink\n0,0\n0.1,0\n0.2,1\n0.3,1\n0.4,0\n1.7,1\n1.8,0\n"
CORNERS = "u_px,v_px,x_m,y_m\n10,20,-1,0.5\n630,20,1,0.5\n630,340,1,-0.5\n10,340,-1,-0.5\n"


@functools.cache
def film() -> bytes:
    """Return a film of 40 small frames in which a bar moves."""
    import av

    stream, draw = io.BytesIO(), np.random.default_rng(0)
    with av.open(stream, "w", format="mp4") as out:
        video = out.add_stream("mpeg4", rate=60)
        video.width, video.height, video.pix_fmt = 64, 48, "yuv420p"
        for k in range(40):
            picture = draw.integers(170, 190, (48, 64), dtype=np.uint8)
            picture[20:28, k : k + 16] = 40
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
            out.mux(video.encode(frame))
        out.mux(video.encode(None))
    return stream.getvalue()


def log() -> bytes:
    """Return a log of 2 s of a mission."""
    from hypertuna.mission.log import write_log
    from voyage import voyage

    return _written(lambda path: write_log(voyage(2), path))


def radio_log() -> bytes:
    """Return a log of the radio."""
    from tank_log import tank_run

    gaits = [ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, lag)) for lag in (0, 40)]
    return _written(lambda path: tank_run(path, ht.load("hypertuna"), gaits))


def _written(write: Any) -> bytes:
    """Return what is written to a path."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made.mcap"
        write(path)
        return path.read_bytes()


@functools.lru_cache(4)
def _records(content: bytes) -> list[Any]:
    """Return the records of a log."""
    from mcap.stream_reader import StreamReader

    return list(StreamReader(io.BytesIO(content)).records)


def of_log(content: bytes, chance: random.Random) -> bytes:
    """Damage messages, times, metadata and channels of a log, and write it anew."""
    from mcap.records import Channel, Message, Metadata, Schema
    from mcap.writer import CompressionType, Writer

    out = io.BytesIO()
    kind = chance.choice((CompressionType.NONE, CompressionType.ZSTD, CompressionType.LZ4))
    writer = Writer(out, chunk_size=chance.choice((1000, 65536, 10_000_000)), compression=kind)
    writer.start("hypertuna", "")
    records = _records(content)
    count = sum(isinstance(record, Message) for record in records)
    hit = {chance.randrange(count) for _ in range(chance.choice((0, 1, 1, 3)))}
    all_times, meta = chance.random() < 0.1, chance.random() < 0.4
    schemas, channels, k = {0: 0}, {}, 0
    for record in records:
        if isinstance(record, Schema):
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel):
            topic = _text(record.topic, chance, 0.01)
            channels[record.id] = writer.register_channel(
                topic, record.message_encoding, schemas.get(record.schema_id, 0)
            )
        elif isinstance(record, Metadata):
            data = {key: _text(value, chance, 0.5 if meta else 0.0) for key, value in record.metadata.items()}
            if meta and chance.random() < 0.1:
                data["robot_file"] = chance.choice(("/dev/zero", "/etc/passwd", "../../x.toml"))
            if meta and chance.random() < 0.1:
                data |= {f"{k}": LONG for k in range(chance.choice((5, 12)))}
            writer.add_metadata(record.name, data)
        elif isinstance(record, Message):
            time, data = record.log_time, record.data
            if k in hit:
                time = chance.choice((*TIMES, time, time, time, time))
                data = chance.choice((of_bytes, of_text, of_structure))(data, chance) if data else data
            time = time + 2**63 - 10**9 if all_times else time
            for _ in range(chance.choice((0, 2, 100)) if k in hit and chance.random() < 0.2 else 1):
                writer.add_message(channels[record.channel_id], min(time, 2**64 - 1), data, time % 2**64)
            k += 1
    writer.finish()
    whole = out.getvalue()
    return of_bytes(whole, chance) if chance.random() < 0.1 else whole


def _text(text: str, chance: random.Random, often: float) -> str:
    """Damage a text sometimes."""
    if chance.random() >= often or not text:
        return text
    return chance.choice((of_text, of_structure))(text.encode(), chance).decode(errors="replace")


def of_xml(content: bytes, chance: random.Random) -> bytes:
    """Put before XML what other readers follow: entities that grow, files and addresses, encodings."""
    named = "".join(f'<!ENTITY a{k + 1} "{f"&a{k};" * 10}">' for k in range(9))
    entity = chance.choice((
        f'<!DOCTYPE x [<!ENTITY a0 "x">{named}]>', '<!DOCTYPE x SYSTEM "file:///dev/zero">', "<!DOCTYPE x>",
        '<!DOCTYPE x [<!ENTITY % p SYSTEM "file:///dev/zero"> %p;]>',
        '<!DOCTYPE x [<!ENTITY a9 SYSTEM "/etc/passwd">]>',
        '<?xml-stylesheet href="/dev/zero"?>', "<!--" + "-" * 1000, "<![CDATA[" * 1000, f"<a {'x' * 10**6}='1'/>",
    ))  # fmt: skip
    name = chance.choice(("utf-7", "utf-16", "idna", "cp037", "hex", "rot13", "x" * 1000, "utf-8", "ascii", "\u202e"))
    body = content.partition(b"?>")[2] or content
    if chance.random() < 0.5:
        body = body.replace(b">", b">&a9;", chance.choice((1, -1)))
    return f'<?xml version="1.0" encoding="{name}"?>{entity}'.encode() + body


# --- black boxes and journals


def box() -> bytes:
    """Return two boots of 60 ticks."""
    return (head() + b"".join(map(tick, range(60)))) * 2


def of_box(content: bytes, chance: random.Random) -> bytes:
    """Change words of records, whose sums are right again; leave out and repeat records."""
    parts, at = [], 0
    while at < len(content):
        width = 4 * (content[at] + 2)
        body, kind = content[at + 4 : at + width - 4], content[at + 1]
        if chance.random() < 0.05:
            words = [*struct.unpack(f"<{len(body) // 4}I", body)]
            value = (0, 2**32 - 1, 2**31, 0x7F800000, 0x7FC00000, 0x7F7FFFFF, chance.getrandbits(32))
            words[chance.randrange(len(words))] = chance.choice(value)
            body = struct.pack(f"<{len(words)}I", *words)
            kind = chance.choice((kind, kind, kind, chance.getrandbits(8)))
        parts += [sealed(kind, body)] * chance.choice((1,) * 50 + (0, 2, 40))
        at += width
    if chance.random() < 0.2:  # what costs time for each word, or for each record
        mark = bytes([chance.choice((0, 1, 255)), content[1]]) + content[2:4]
        piece = chance.choice((mark, sealed(9, b"") + sealed(10, b""), sealed(chance.getrandbits(8), bytes(1000))))
        parts.insert(chance.randrange(len(parts)), piece * chance.choice((10, 1000, 50_000)))
    return b"".join(parts)


def journal() -> bytes:
    """Return a journal of five answers."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "j.jsonl"
        with Journal(path, {"kind": "search", "options": {"steps": 3}}) as made:
            for k in range(5):
                made.answer({"gait": [1.0, k]}, lambda k=k: {"speed": 0.1 * k})
        return path.read_bytes()


def of_journal(content: bytes, chance: random.Random) -> bytes:
    """Damage lines of a journal, whose checksums are right again."""
    total, lines = 0, []
    for line in content.splitlines():
        body = line.partition(b', "crc32"')[0] + b"}\n"
        if chance.random() < 0.3:
            body = chance.choice((of_text, of_structure))(body, chance).replace(b"\n", b" ").rstrip() + b"\n"
        total = zlib.crc32(body, total)
        lines.append(body[:-2] + b', "crc32": "%08x"}\n' % total)
    if chance.random() < 0.1:
        lines.append(chance.choice((b"\n", b"a\n", b"{}\n", b"\r", b"[" * 30)) * chance.choice((1, 1000, 2_000_000)))
    return b"".join(lines)


# --- archives


@functools.lru_cache(4)
def _members(content: bytes) -> dict[str, bytes]:
    """Return the files of an archive."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@functools.cache
def _bomb() -> bytes:
    """Return an array of 200 MB of zeros, compressed."""
    out = io.BytesIO()
    np.savez_compressed(out, weight0=np.zeros(25_000_000))
    return out.getvalue()


@functools.cache
def _lying(size: int) -> bytes:
    """Return an archive of a file of 300 MB of zeros, which says that it has another size."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("weight0.npy", "w") as member:
        for _ in range(300):
            member.write(bytes(1_000_000))
    whole, true = bytearray(out.getvalue()), struct.pack("<I", 300_000_000)
    for at in (whole.find(true), whole.rfind(true)):
        whole[at : at + 4] = struct.pack("<I", size)
    return bytes(whole)


@functools.cache
def _directory(count: int) -> bytes:
    """Return an archive that is a list of files without them."""
    name = b"weight0.npy"
    entry = b"PK\1\2" + bytes(24) + struct.pack("<H", len(name)) + bytes(16) + name
    return (
        entry * count
        + b"PK\5\6"
        + struct.pack("<HHHHIIH", 0, 0, count % 2**16, count % 2**16, count * len(entry), 0, 0)
    )


def of_npz(content: bytes, chance: random.Random) -> bytes:
    """Change arrays of an archive: types, shapes, headers, what is pickled, what is there twice, bombs."""
    members = dict(_members(content))
    name = chance.choice([*members])
    array = np.load(io.BytesIO(members[name]))
    kind = chance.randrange(12)
    if kind == 0:
        return _bomb()
    if kind == 9:
        return _lying(chance.choice((0, 1, 100, 2**31, 2**32 - 1)))
    if kind == 10:
        return chance.choice((_directory(10), _directory(100_000), content + b"x" * 30, content + content))
    if kind == 11:
        name = chance.choice(("step", "task", "weight0"))
        size = chance.choice((0, 1, 3_000_000))
        members[name] = _npy(np.zeros(size, chance.choice(("i1", "?"))))
    if kind == 1:
        members[name] = _npy(np.array([{"a": 1}, ht], dtype=object)[:1])
    elif kind == 2:
        members[name] = _npy(np.zeros(array.shape, chance.choice(("<f2", "<i1", "<c16", "U7", "?", "<M8[s]"))))
    elif kind == 3:
        shape = str(array.shape).encode()
        other = chance.choice((b"(100000000,)", b"(-1,)", b"(0, 0, 0)", b"(1e9,)", b"()", b"(" * 2000, shape + b"*2"))
        members[name] = members[name].replace(shape, other, 1)
    elif kind == 4:
        members[name] = _npy(
            np.full(chance.choice((array.shape, (*array.shape, 1), (0, 5), (5,))), chance.choice((np.nan, 1, 1e308)))
        )
    elif kind == 5:
        members[name] = of_bytes(members[name], chance)
    elif kind == 6:
        members[chance.choice(("../../up.npy", "/abs.npy", "x" * 60000, "weight9.npy", "weight0"))] = members[name]
    elif kind == 7:
        del members[name]
    return _zipped(members, chance, twice=kind == 8)


def _npy(array: Any) -> bytes:
    """Return an array as a file."""
    out = io.BytesIO()
    np.lib.format.write_array(out, array, allow_pickle=True)
    return out.getvalue()


def _zipped(
    members: dict[str, bytes], chance: random.Random, *, twice: bool = False, method: int | None = None
) -> bytes:
    """Return an archive; maybe with a file that is there twice, or is a link."""
    out = io.BytesIO()
    ways = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)
    with warnings.catch_warnings(action="ignore"), zipfile.ZipFile(out, "w") as archive:
        for name, content in [*members.items()] * (2 if twice else 1):
            entry = zipfile.ZipInfo(name)
            entry.compress_type = chance.choice((*ways[:1] * 20, *ways)) if method is None else method
            if chance.random() < 0.01:
                entry.external_attr = 0o120777 << 16  # a link
            archive.writestr(entry, content)
    return out.getvalue()


# --- shards: packed as one file, which `unpack` makes a folder of


def shards() -> bytes:
    """Return a folder of three shards as an archive."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "a.shards"
        ht.sweep_shards("hypertuna", [GAIT] * 5, place, size=2, command="hypertuna sweep -o a.shards")
        return packed(place)


def packed(folder: Path) -> bytes:
    """Return the files of a folder as an archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for file in sorted(folder.iterdir()):
            archive.write(file, file.name)
    return out.getvalue()


GAIT = ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 40))


def unpack(path: Path) -> None:
    """Make the folder of a packed one, where it is one."""
    try:
        files = _members(path.read_bytes()) if path.is_file() and 0 < path.stat().st_size < 1 << 30 else {}
    except Exception:  # damaged: so that the manifest is
        files = {"manifest.json": path.read_bytes()}
    if not files and not path.is_dir():
        path.rename(path.parent / "manifest.json")
    for name, content in files.items():
        if "/" not in name and len(name) < 200 and "\0" not in name:
            (path.parent / name).write_bytes(content)
    if files:
        path.unlink()


def of_shards(content: bytes, chance: random.Random) -> bytes:
    """Damage the manifest, with its checksum right or not, or the columns of a shard."""
    files = dict(_members(content))
    if chance.random() < 0.5:
        manifest = json.loads(files["manifest.json"])
        files["manifest.json"] = _manifest(manifest, chance)
        return _zipped(files, chance, method=zipfile.ZIP_STORED)
    name = chance.choice([file for file in files if file.endswith(".zip")])
    members = dict(_members(files[name]))
    inner = chance.choice([*members])
    kind = chance.randrange(8)
    if kind == 0:
        del members[inner]
    elif kind == 6:
        files[name] = chance.choice((_directory(100_000), _lying(100), files[name] + b"x"))
        return _zipped(files, chance, method=zipfile.ZIP_STORED)
    elif kind == 7:
        members["zarr.json"] = members["zarr.json"][:-1] + b', "a": [' + b"[]," * chance.choice((1, 400_000)) + b"1]}"
    elif kind == 1 and inner.endswith("json"):
        members[inner] = chance.choice((of_text, of_structure))(members[inner], chance)
    elif kind == 2 and inner.endswith("json"):
        number = chance.choice((b"0", b"-1", b"100000000", b"[1]", b"1e400", b"9" * 400))
        members[inner] = members[inner].replace(b"2", number)
    elif kind == 3:
        members[inner] = of_bytes(members[inner], chance) if members[inner] else b"x"
    elif kind == 4:
        members = {key: value for key, value in members.items() if "/c/" not in key}
    twice = kind == 5 and chance.random() < 0.5
    files[name] = _zipped(members, chance, twice=twice, method=chance.choice((zipfile.ZIP_STORED,) * 4 + (None,)))
    return _zipped(files, chance, method=zipfile.ZIP_STORED)


def _manifest(manifest: dict[str, Any], chance: random.Random) -> bytes:
    """Return a damaged manifest."""
    if chance.random() < 0.5:
        text = chance.choice((of_text, of_structure))(json.dumps(manifest, indent=1).encode(), chance)
        try:
            facts = json.loads(text)
            facts["sha256"] = checksum({key: value for key, value in facts.items() if key not in ("sha256", "mark")})
            return json.dumps(facts).encode()
        except (ValueError, RecursionError, TypeError):
            return text
    path = [manifest]
    while isinstance(path[-1], (dict, list)) and path[-1] and (len(path) == 1 or chance.random() < 0.7):
        keys = [*path[-1]] if isinstance(path[-1], dict) else [*range(len(path[-1]))]
        path.append(path[-1][key := chance.choice(keys)])
    values = (0, -1, 10**8, 2**64, 10**50, 1.5, float("nan"), None, True, "x", "a/b", "", [], {}, [[1], [2]], {"a": {}})
    if len(path) > 1:
        path[-2][key] = chance.choice((*values, "$(touch /tmp/x)", LONG, [1, "a"]))
    facts = {key: value for key, value in manifest.items() if key not in ("sha256", "mark")}
    if chance.random() < 0.9 and "sha256" in manifest:
        manifest["sha256"] = checksum(facts)
    return json.dumps(manifest).encode()
