"""The door: what is no file of its kind is refused in a sentence, before it takes memory or time."""

import ast
import io
import json
import math
import os
import resource
import struct
import threading
import time
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from disk import full_disk
from hypertuna.errors import InputError
from hypertuna.io import door
from hypertuna.io.checkpoint import Journal, read_header
from hypertuna.io.door import DEPTH, DIGITS, KINDS, MB, ROWS, parse_json, parse_toml, read_bytes, read_npz
from hypertuna.io.files import Csv, replaced, scratch, write_netcdf
from hypertuna.io.mcap import McapWriter
from hypertuna.io.tables import parse_float, read_table
from hypertuna.learning.policy import read_policy

SOURCES = Path(door.__file__).parents[1]

# What opens or parses a file: a call by its last name, or with the name of its module.
OPENERS = {
    *("open", "FileIO", "fdopen", "read_text", "read_bytes", "readall", "getlines", "mmap", "memmap"),
    *("loadtxt", "genfromtxt", "fromfile", "read_csv", "ZipFile", "ZipStore", "open_group", "open_array"),
    *("open_dataset", "load_dataset", "open_datatree", "open_zarr", "open_mfdataset", "unpack_archive", "get_reader"),
    *(
        "np.load",
        "numpy.load",
        "pickle.load",
        "pickle.loads",
        "json.load",
        "json.loads",
        "tomllib.load",
        "tomllib.loads",
    ),
    *("tomlkit.parse", "tomlkit.load", "tomlkit.loads", "ElementTree.parse", "ElementTree.fromstring", "pv.read"),
    *("csv.reader", "csv.DictReader", "h5py.File", "h5netcdf.File", "netCDF4.Dataset", "netcdf_file", "loadmat"),
    *(
        "load_dataarray",
        "open_dataarray",
        "read_hdf",
        "read_model_description",
        "fmpy.extract",
        "simulate_fmu",
        "load_workbook",
        "sqlite3.connect",
        "deserialize",
    ),
}
# Calls outside the door, by file: how many, and why no stranger's file comes there unchecked.
ALLOWED = {
    "cli/console.py": {"json.loads": 1},  # what it has just written
    "cli/drive.py": {"open": 1},  # a gamepad is a device; read without waiting, 1 kB at a time
    "cli/streams.py": {"open": 1},  # nothing, in place of a closed stream
    "cli/studio.py": {"open": 1},  # a browser
    "description/writer.py": {"tomlkit.parse": 1},  # text from the door
    "export/fmu.py": {"read_bytes": 1, "ZipFile": 1},  # binaries of the package; the archive that it writes
    "fe/fields.py": {"read_bytes": 1},  # what it has just written
    "fe/geometry.py": {"read_bytes": 1},
    "fe/pictures.py": {"pv.read": 1},  # after the door
    "film/overlay.py": {"open": 1},  # a film that it writes
    "film/record.py": {"open": 4},  # a camera, an address or a pipe, which are no files; a film that it writes
    "film/source.py": {"open": 1},  # a stream from the door, of a form that names no other files
    "firmware/boards.py": {"open": 2, "fdopen": 1, "read_bytes": 1},  # pipes and a file of its own folder
    "firmware/in_the_loop.py": {"read_bytes": 1},  # a program, which then runs
    "identification/names.py": {"tomllib.loads": 1, "read_text": 1},  # shipped
    "io/checkpoint.py": {
        "FileIO": 1,
        "open": 1,
        "readall": 1,
        "json.loads": 5,
    },  # after the door's check; what it wrote
    "io/files.py": {"json.loads": 1, "tomllib.loads": 1, "read_text": 2, "read_bytes": 1},  # shipped; what it wrote
    "io/bags.py": {"sqlite3.connect": 1, "deserialize": 1},  # in memory; content from the door
    "io/hdf5.py": {"json.loads": 1},  # of the program that it started
    "io/hdf5_child.py": {"open": 1, "h5py.File": 1},  # its input, which the door opened
    "io/mcap.py": {"FileIO": 1},  # for writing
    "io/tables.py": {"csv.reader": 1},  # a line from the door
    "mission/gpx.py": {"ElementTree.fromstring": 1},  # content from the door
    "paper/chapters/budget.py": {"json.loads": 1, "read_text": 1, "read_bytes": 1},  # shipped
    "paper/chapters/finite_elements.py": {"json.loads": 3, "read_text": 3, "read_bytes": 1},
    "paper/chapters/lake.py": {"json.loads": 1, "read_text": 1},
    "paper/seeds.py": {"json.loads": 1, "read_text": 1},
    "parallel/checks.py": {"open": 1, "open_array": 1},  # of an archive from the door; of its content
    "parallel/shards.py": {"json.loads": 1, "read_bytes": 1, "ZipStore": 1},  # what it has just written
    "trials/form_workbook.py": {"load_workbook": 1},  # after the door
    "radio/dialect.py": {"read_bytes": 3},  # shipped; what it has just written
    "reports/studio.py": {"json.loads": 1, "read_text": 1},  # shipped
}


def calls(tree: ast.AST, own: set[str]) -> Counter[str]:
    """Count the calls of OPENERS in a module but those that it imports from the door."""
    found: Counter[str] = Counter()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and (name := ast.unparse(node.func)) not in own:
            found.update(one for one in {name.split(".")[-1], ".".join(name.split(".")[-2:])} if one in OPENERS)
    return found


def test_no_other_module_opens_the_file_of_a_stranger() -> None:
    unknown = {}
    for path in sorted(SOURCES.rglob("*.py")):
        name = path.relative_to(SOURCES).as_posix()
        tree = ast.parse(path.read_text(encoding="utf-8"))
        of_door = [n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.module == "hypertuna.io.door"]
        own = {alias.asname or alias.name for node in of_door for alias in node.names}
        extra = calls(tree, own) - Counter(ALLOWED.get(name, {}))
        if extra and name != "io/door.py":
            unknown[name] = extra
    assert unknown == {}


@pytest.mark.parametrize(
    "line",
    [
        "Path(x).read_text()",
        "open(x)",
        "np.load(x)",
        "self.path.open('rb')",
        "json.load(f)",
        "xr.open_dataset(x)",
        "fmpy.extract(x)",
    ],
)
def test_a_reader_beside_the_door_is_found(line: str) -> None:
    assert calls(ast.parse(line), set())


# --- what is no regular file


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_pipes_devices_and_folders_are_refused_at_once(kind: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for name in ("pipe", "link"):
        with pytest.raises(InputError, match=f"{name} must be a regular file, but is a pipe or a device: copy"):
            read_bytes(tmp_path / name, kind)
    for name, words in ((".", "is a folder"), ("loop", "must be readable"), ("none", "must be a file, but is missing")):
        with pytest.raises(InputError, match=words):
            read_bytes(tmp_path / name, kind)


def test_a_file_is_bounded_by_its_size_and_by_what_it_gives(tmp_path: Path) -> None:
    with (tmp_path / "hole").open("wb") as file:
        file.truncate(KINDS["toml"].largest + 1)
    with pytest.raises(InputError, match="hole must be at most 1 MB, but is larger"):
        read_bytes(tmp_path / "hole", "toml")
    with pytest.raises(InputError, match="must be at most 0.001 MB"):
        read_bytes("/proc/self/maps", "key")  # states no size


def test_a_journal_and_outputs_are_no_pipes(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    with pytest.raises(InputError, match="must be a regular file"):
        Journal(tmp_path / "pipe.mcap", {})
    with pytest.raises(InputError, match="must be a regular file"):
        Journal("/dev/zero", {})
    for write in (lambda path: replaced(path).__enter__(), McapWriter):
        with pytest.raises(InputError, match=r"pipe.mcap must be a file, but is a pipe or a device: choose another"):
            write(tmp_path / "pipe.mcap")
    assert (tmp_path / "pipe.mcap").is_fifo()


# --- texts


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a" + ".a" * 1000 + " = 1", "tables and lists in each other"),
        ("[a" + " . 'b'" * 20_000 + "]", "tables and lists in each other"),
        ("a = " + "[" * 1000 + "]" * 1000, "tables and lists in each other"),
        ("a = " + "{a=" * 1000 + "1" + "}" * 1000, "tables and lists in each other"),
        (("a" + ".a" * 20 + " = {") * 8 + "b = 1" + "}" * 8, "tables and lists in each other"),
        ("a = " + "9" * 400, "a number of more than 100 digits"),
        ("a = " + "9" * 9000, "4300"),
        ("[[joints]]\n" * 50_000, "a list of more than 5000 tables"),
        ("a = [" + "1," * 200_000 + "]", "more than 100000 values"),
    ],
)
def test_toml_is_bounded(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_toml(text)


@pytest.mark.parametrize(
    "text", ["# " + "[" * 99, 'a = "' + "x.y." * 99 + '"', "a = '''\n" + "{" * 99 + "'''", 'a = """"q""""']
)
def test_texts_and_comments_of_toml_are_not_counted(text: str) -> None:
    assert set(parse_toml(text)) <= {"a"}


@pytest.mark.parametrize(("deep", "fits"), [(DEPTH - 2, True), (DEPTH - 1, False), (1000, False)])
def test_lists_beside_each_other_are_not_in_each_other(deep: int, fits: bool) -> None:
    text = "a = [" + "[]," * 2000 + "[" * deep + "]" * deep + "]"
    if fits:
        assert len(parse_toml(text)["a"]) == 2001
    else:
        with pytest.raises(InputError, match=f"more than {DEPTH} tables and lists in each other"):
            parse_toml(text)


def test_long_words_of_toml_take_no_time() -> None:
    parse_toml("k" * 500_000 + " = 1\n" + "k" + " " * 400_000 + "= 1")


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, "[" * (DEPTH + 2) + "]" * (DEPTH + 2), "9" * (DIGITS + 1), '{"a":' * 2000 + "1" + "}" * 2000],
)
def test_json_is_bounded(text: str) -> None:
    with pytest.raises(ValueError, match="more than|digits"):
        parse_json(text)


def test_json_is_as_it_was() -> None:
    state = json.dumps([2**127, 1e300, None, {"a": ["x"] * 99}])
    assert parse_json(state) == parse_json(state.encode()) == json.loads(state)


def test_a_table_is_bounded(tmp_path: Path) -> None:
    (tmp_path / "wide.csv").write_text("a\n" + "1," * 200_000)
    with pytest.raises(InputError, match="wide.csv: line 2 must have at most 100000 characters"):
        read_table(tmp_path / "wide.csv")
    (tmp_path / "long.csv").write_text("a\n" + (";" * 99 + "\n") * 50_000)
    with pytest.raises(InputError, match="long.csv must have at most 3000000 cells"):
        read_table(tmp_path / "long.csv")


# --- archives


def npz(path: Path, **members: bytes) -> Path:
    """Write an archive."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return path


def npy(array: Any) -> bytes:
    out = io.BytesIO()
    np.lib.format.write_array(out, array, allow_pickle=True)
    return out.getvalue()


def test_an_archive_unpacks_to_what_its_headers_say(tmp_path: Path) -> None:
    small = npy(np.zeros(5))
    assert read_npz(npz(tmp_path / "a.npz", w=small))["w"].shape == (5,)
    huge = npz(tmp_path / "huge.npz", w=small.replace(b"(5,)", b"(400000000,)"[:12]))
    for path in (
        huge,
        npz(tmp_path / "object.npz", w=npy(np.array([{}], dtype=object))),
        npz(tmp_path / "b.npz", w=b"x"),
    ):
        with pytest.raises(InputError, match=r"must be a whole .npz file of numbers"):
            read_npz(path)
    with pytest.raises(InputError, match="must unpack to at most 1000 files and 32 MB"):
        read_npz(npz(tmp_path / "bomb.npz", w=npy(np.zeros(10_000_000))))


# --- what takes more time or memory than it has bytes


def within(seconds: float, memory: int, read: Callable[[], Any]) -> str:
    """Return what reading says in a process of its own, of which processor [s] and memory [bytes] are limited."""
    here, there = os.pipe()
    if (child := os.fork()) == 0:
        now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (now + memory, now + memory))
        begin, told = time.process_time(), "read"
        try:
            read()
        except BaseException as error:  # also MemoryError
            told = f"{type(error).__name__}: {error}"
        spent = time.process_time() - begin
        os.write(there, (told if spent <= seconds else f"took {spent:.1f} s").encode()[:4000])
        os._exit(0)
    os.close(there)
    with os.fdopen(here, "rb") as line:
        told = line.read().decode(errors="replace")
    os.waitpid(child, 0)
    return told


@pytest.mark.parametrize("text", ['a = """\n' + '\\"""\n' * 100_000, "a = \\" + '"\\' * 250_000, "'\n" * 250_000])
def test_open_texts_of_toml_take_no_time(text: str) -> None:
    """Each quotation mark began a text that was sought to the end of the file: 38 s for 100 kB."""
    assert "must be valid TOML" in within(5, 500 * MB, lambda: parse_toml(text))


def lying(content: bytes, size: int) -> bytes:
    """Return an archive of a compressed file that says that it has another size."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("weight0.npy", content)
    return out.getvalue().replace(struct.pack("<I", len(content)), struct.pack("<I", size))


def test_no_more_of_an_archive_is_unpacked_than_it_states(tmp_path: Path) -> None:
    (path := tmp_path / "lying.npz").write_bytes(lying(bytes(700_000_000), 100))
    assert within(5, 100 * MB, lambda: read_npz(path)).startswith("InputError: ")


@pytest.mark.parametrize("tail", [b"", b"x"])
def test_the_list_of_files_of_an_archive_is_bounded(tmp_path: Path, tail: bytes) -> None:
    """A list of 300,000 files, also where its end is hidden in a comment."""
    entry = b"PK\1\2" + bytes(24) + struct.pack("<H", 1) + bytes(16) + b"a"
    end = struct.pack("<4sHHHHIIH", b"PK\5\6", 0, 0, 1, 1, 300_000 * len(entry), 0, len(tail)) + tail
    (path := tmp_path / "list.npz").write_bytes(entry * 300_000 + end)
    assert within(1, 40 * MB, lambda: read_npz(path)).startswith("InputError: ")


def test_a_policy_has_one_step(tmp_path: Path) -> None:
    """Its step was a list of 30 million numbers: 1.5 GB."""
    path = npz(tmp_path / "a.npz", step=npy(np.zeros(11_000_000, "i1")))
    assert "step must be one value, but is 11000000" in within(5, 300 * MB, lambda: read_policy(path))


def test_short_lines_of_a_journal_take_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "j.jsonl"
    Journal(path, {}).close()
    with path.open("ab") as file:
        file.write(b"a\n" * 20_000_000)
    read_header(path)
    assert within(5, 300 * MB, lambda: read_header(path)) == "read"
    assert "DamageWarning" in within(5, 300 * MB, lambda: Journal(path, {}))


def test_json_is_bounded_by_its_memory(tmp_path: Path) -> None:
    text = '{"a": [' + '{"a":1},' * 2_000_000 + "1]}"
    with pytest.raises(ValueError, match="more values than 600 MB of memory hold"):
        parse_json(text)


@pytest.mark.parametrize(
    ("head", "line"), [("x,y\n", "1.234567,1.234567\n"), ("x\U0001f600,y\n", "1,2\n"), ("a,b\n", '"1","2"\n')]
)
def test_a_table_at_its_limit_takes_less_than_a_gigabyte(tmp_path: Path, head: str, line: str) -> None:
    (path := tmp_path / "a.csv").write_text(head + line * (ROWS - 2))
    assert within(10, 1000 * MB, lambda: read_table(path)) == "read"
    (path := tmp_path / "b.csv").write_text(head + line * ROWS * 2)
    assert f"must have at most {ROWS} lines" in within(2, 1000 * MB, lambda: read_table(path))


def test_numbers_of_tables_are_plain(tmp_path: Path) -> None:
    assert parse_float("1e-400") == 0.0
    assert [parse_float(" 1.5e3"), parse_float("-.5")] == [1500.0, -0.5]
    assert all(math.isnan(parse_float(text)) for text in ("1_000", "\u0663", "\uff11", "0x1p3", "1,5"))


# --- writing


def test_a_table_and_its_facts_are_there_together_or_not_at_all(tmp_path: Path) -> None:
    (tmp_path / "a.csv.json").mkdir()
    with pytest.raises(InputError, match=r"a.csv.json must be a file, but is a folder"):
        Csv("x\n1\n", {"seed": 1}).write(tmp_path / "a.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv.json"]


def test_a_full_disk_leaves_neither_a_table_nor_its_facts(tmp_path: Path) -> None:
    with full_disk(1000), pytest.raises(InputError, match="a.csv must be a writable file"):
        Csv("x\n" * 1000, {"seed": 1}).write(tmp_path / "a.csv")
    with full_disk(1000), pytest.raises(InputError, match=r"a.csv.json must be a writable file"):
        Csv("x\n", {"seed": "1" * 2000}).write(tmp_path / "a.csv")
    assert not [*tmp_path.iterdir()]


def test_a_log_has_one_writer(tmp_path: Path) -> None:
    with McapWriter(tmp_path / "a.mcap") as writer:
        writer.write_metadata("a", {"b": "c"})
        writer.flush()
        before = (tmp_path / "a.mcap").read_bytes()
        with pytest.raises(InputError, match=r"a.mcap is being written by another run: wait"):
            McapWriter(tmp_path / "a.mcap")
        assert (tmp_path / "a.mcap").read_bytes() == before != b""
    McapWriter(tmp_path / "a.mcap").close()


def test_a_full_temporary_folder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    rule = f"{tmp_path} must be a folder that can be written.*set TMPDIR"
    with pytest.raises(InputError, match=rule), scratch():
        raise OSError(28, "No space left on device")
    assert not [*tmp_path.iterdir()]


def test_netcdf_needs_no_temporary_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a full one, HDF5 would end the program."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    assert xr.load_dataset(write_netcdf(xr.Dataset({"speed": 0.3}), tmp_path / "a.nc")).speed == 0.3


def test_readers_wait_for_no_writer(tmp_path: Path) -> None:
    """Robots, missions and logs by the public functions, each with a pipe, in a thread that must end."""
    for name, read in (("a.toml", ht.load), ("a.toml", ht.read_mission), ("a.mcap", ht.studio)):
        path = tmp_path / read.__name__ / name
        path.parent.mkdir()
        os.mkfifo(path)
        told: list[str] = []

        def call(read: Any = read, path: Path = path, told: list[str] = told) -> None:
            try:
                read(path)
            except InputError as error:
                told.append(str(error))

        thread = threading.Thread(target=call, daemon=True)
        thread.start()
        thread.join(10)
        assert told
        assert "must be a regular file" in told[0]
