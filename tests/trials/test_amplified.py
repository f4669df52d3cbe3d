"""Small files of points that say little many times: limits are of what a file becomes in memory, not of its bytes."""

import io
import json
import sqlite3
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import openpyxl
import pytest

from hypertuna.errors import InputError
from hypertuna.io.bags import read_bag
from hypertuna.io.door import NUMBERS, TAG, TAGS
from hypertuna.io.hdf5 import read_hdf5
from hypertuna.io.hdf5_child import LETTERS, attributes
from hypertuna.io.matlab import read_matlab
from hypertuna.io.tables import read_table
from hypertuna.trials.forms import read_points
from hypertuna.trials.markers import read_markers
from mutations.judge import watched

MANY = NUMBERS // 2 + 1  # numbers of each of two arrays


def element(kind: int, content: bytes) -> bytes:
    """Return an element of a MATLAB file."""
    return struct.pack("<2I", kind, len(content)) + content + bytes(-len(content) % 8)


def matlab(*arrays: tuple[bytes, int, tuple[int, int], bytes]) -> bytes:
    """Return a MATLAB file of arrays: name, class, shape, and elements of the numbers; each is compressed."""
    content = b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM"
    for name, kind, shape, numbers in arrays:
        head = element(6, struct.pack("<2I", kind, 0)) + element(5, struct.pack("<2i", *shape)) + element(1, name)
        packed = zlib.compress(element(14, head + numbers))
        content += struct.pack("<2I", 15, len(packed)) + packed
    return content


def pairs() -> bytes:
    """Return x and y of a byte a number."""
    return matlab(*((name, 9, (MANY, 1), element(2, bytes(MANY))) for name in (b"x", b"y")))


def sparse() -> bytes:
    """Return two sparse arrays without any number that is not zero: rows, the begin of the column, values."""
    empty = element(5, b"") + element(5, bytes(8)) + element(9, b"")
    return matlab(*((name, 5, (MANY, 1), empty) for name in (b"x", b"y")))


def archive(**arrays: Any) -> bytes:
    """Return arrays as a compressed archive of NumPy."""
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


def poses() -> bytes:
    """Return places of a byte each."""
    return archive(poseX0=np.zeros(MANY, "i1"), poseY0=np.zeros(MANY, "i1"))


@pytest.mark.parametrize(
    ("name", "make"), [("x.mat", pairs), ("x.mat", sparse), ("x.npz", poses)], ids=["pairs", "sparse", "poses"]
)
def test_numbers_are_counted_as_floats(tmp_path: Path, name: str, make: Callable[[], bytes]) -> None:
    """A number of a byte becomes a float of eight: 240 kB of two arrays took 2.3 GB and more."""
    (tmp_path / name).write_bytes(make())
    assert (tmp_path / name).stat().st_size < 100_000
    with pytest.raises(InputError, match=f"{name} must hold at most {NUMBERS} numbers, but is more: cut it"):
        read_points(tmp_path / name)


def test_a_single_array_has_the_same_limit(tmp_path: Path) -> None:
    np.save(tmp_path / "x.npy", np.zeros((MANY, 1, 2), "i1"))
    with pytest.raises(InputError, match=f"x.npy must hold at most {NUMBERS} numbers, but is more: cut it"):
        read_points(tmp_path / "x.npy")


def test_zeros_of_sparse_arrays_count_in_hdf5(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "x.h5", "w") as file:
        for name in ("x", "y"):
            file[f"{name}/data"], file[f"{name}/ir"], file[f"{name}/jc"] = [1.0], [0], [0, 1]
            file[name].attrs.update({"MATLAB_sparse": MANY, "MATLAB_class": np.bytes_("double")})
    with pytest.raises(InputError, match=f"must hold at most {NUMBERS} numbers"):
        read_points(tmp_path / "x.h5")


def test_the_begin_of_a_long_text_is_read(tmp_path: Path) -> None:
    """40 million letters, of which 10,000 are kept, became a list of 320 MB."""
    (tmp_path / "x.mat").write_bytes(matlab((b"t", 4, (1, 40_000_000), element(4, b"a\0" * 40_000_000))))
    with watched(longest=4.0, hangs=100.0) as watch:
        assert len(read_matlab(tmp_path / "x.mat").texts["t"]) == 10_000
    assert not watch.problem


def test_a_body_of_all_points_of_a_c3d_file_is_read(tmp_path: Path) -> None:
    """Each name was sought among all others: 65,535 points took over a minute."""
    head = struct.pack("<BBHHHHHfHHf", 2, 80, 65535, 0, 1, 2, 0, -1.0, 3, 0, 60.0).ljust(512, b"\0")
    (tmp_path / "x.c3d").write_bytes(head + b"\1\120\1\124".ljust(512, b"\0") + np.ones((2, 65535, 4), "<f4").tobytes())
    with watched(longest=5.0, hangs=100.0) as watch:
        assert read_points(tmp_path / "x.c3d").names[-1] == "65535"
    assert not watch.problem


def test_midlines_have_frames_as_a_table_has_cells(tmp_path: Path) -> None:
    """Each frame takes eleven points, also one without a midline."""
    count = 3_000_000 // 22 + 1
    parts = {"midline_points": np.zeros((3, 2)), "midline_lengths": np.append(np.zeros(count - 1), 3)}
    (tmp_path / "x.npz").write_bytes(archive(**parts, frames=np.arange(count)))
    with pytest.raises(InputError, match="midline_lengths must have at most 136363 frames, but is more"):
        read_points(tmp_path / "x.npz")


def test_the_number_of_a_pose_is_short(tmp_path: Path) -> None:
    """Python refuses to read whole numbers of over 4,300 digits."""
    (tmp_path / "x.npz").write_bytes(archive(**{f"pose{axis}{'9' * 5000}": np.zeros(3) for axis in "XY"}))
    with pytest.raises(InputError, match="must hold points of TRex"):
        read_points(tmp_path / "x.npz")


def workbook(rows: str) -> bytes:
    """Return a workbook of these rows, in XML."""
    book, out = io.BytesIO(), io.BytesIO()
    openpyxl.Workbook().save(book)
    with zipfile.ZipFile(book) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            sheet = f'<worksheet xmlns="{MAIN}"><sheetData>{rows}</sheetData></worksheet>'.encode()
            new.writestr(name, sheet if name == "xl/worksheets/sheet1.xml" else old.read(name))
    return out.getvalue()


MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
CELL = "<c><v>1</v></c>"
TEXT = f'<c t="inlineStr"><is><t>{"x" * 1_000_000} </t></is></c>'


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        (f'<row><c r="XFD1"><v>1</v></c></row>{f"<row>{CELL}</row>" * 200}', "must have at most 3000000 cells"),
        (f"<row>{TEXT * 65}</row>", "and as CSV 64 MB"),
        ("<row>" + "<a/>" * TAGS + "</row>", "must have at most 750000 cells, but is larger: save the sheet as CSV"),
        (f"<row {' '.join(f'a{k}=' + chr(34) * 2 for k in range(TAG // 5))}>{CELL}</row>", "must have at most 750000"),
    ],
    ids=["a wide row above short ones", "long texts", "empty elements", "many attributes"],
)
def test_a_sheet_is_as_large_as_its_table(tmp_path: Path, rows: str, sentence: str) -> None:
    """Short rows are filled to the longest: 30 kB took 3 GB. A text is stored once and may stand in all cells."""
    (tmp_path / "x.xlsx").write_bytes(workbook(rows))
    with pytest.raises(InputError, match=sentence):
        read_points(tmp_path / "x.xlsx")


CREATE = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB{})"


@pytest.mark.parametrize(
    ("messages", "sentence"),
    [
        (CREATE.format(""), None),
        (CREATE.format(" AS (zeroblob(900000000))"), "must have tables of topics and messages"),
        ("CREATE VIRTUAL TABLE messages USING fts4(topic_id, timestamp, data)", "must have tables of topics and"),
    ],
    ids=["stored", "computed", "virtual"],
)
def test_cells_of_a_bag_are_stored(tmp_path: Path, messages: str, sentence: str | None) -> None:
    """A column may be computed: 12 kB of a hundred messages were sorted as 90 GB."""
    base = sqlite3.connect(tmp_path / "x.db3")
    base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
    base.execute("INSERT INTO topics VALUES(1, '/odom', 'nav_msgs/msg/Odometry', 'cdr')")
    base.execute(messages)
    base.execute("INSERT INTO messages(topic_id, timestamp) VALUES(1, 2)")
    base.commit()
    base.close()
    if sentence is None:
        assert read_bag(tmp_path / "x.db3") == ({}, "")
    else:
        with pytest.raises(InputError, match=sentence):
            read_bag(tmp_path / "x.db3")


def test_attributes_of_a_group_of_many_names_count_each_time(tmp_path: Path) -> None:
    """12 MB of attributes at 1,900 names would be 23 GB."""
    counts = {"attributes": 0, "about": 0}
    with h5py.File(tmp_path / "x.h5", "w", libver="latest") as file:
        group = file.create_group("g")
        for k in range(100):
            group.attrs[f"a{k}"] = "x" * 60_000
        for k in range(1900):
            file[f"l{k}"] = group
        assert len(attributes(group, counts)) == LETTERS // 60_000 + 1
        assert attributes(group, counts) == {}
    with watched(longest=5.0, hangs=60.0) as watch:
        assert len(read_hdf5(tmp_path / "x.h5").attributes) == 1901
    assert not watch.problem


def test_mistakes_of_a_wide_table_take_no_time(tmp_path: Path) -> None:
    """Each repeated name was sought from the first on: 16,500 took 9 s."""
    (tmp_path / "x.csv").write_text(",".join(["u"] * 49_000) + "\n" + ",".join(["1"] * 49_000) + "\n")
    with watched(InputError, longest=3.0, hangs=100.0) as watch:
        read_table(tmp_path / "x.csv").keys({"u": "u"}, {}, fix="")
    assert "u must appear only once" in str(watch.raised)
    assert not watch.problem


def test_a_chunk_of_an_array_is_bounded(tmp_path: Path) -> None:
    """40 numbers may lie in a chunk of 1.9 GB, of which a file has 8 MB."""
    with h5py.File(tmp_path / "x.h5", "w") as file:
        about: dict[str, Any] = {"chunks": (1_100_000_000,), "maxshape": (None,), "compression": "gzip"}
        array = file.create_dataset("x", (40,), "i1", **about)
        packer = zlib.compressobj(1)
        array.id.write_direct_chunk((0,), b"".join(packer.compress(bytes(10**7)) for _ in range(110)) + packer.flush())
    with pytest.raises(InputError, match="must be a whole HDF5 file"):
        read_hdf5(tmp_path / "x.h5")


def test_a_fish_has_at_most_300_markers(tmp_path: Path) -> None:
    """Markers are compared with each other: a thousand took 11 s to import, 6,000 minutes."""
    for count in (300, 301):
        head = ["time_s", *(f"m{k}_{axis}" for k in range(count) for axis in "xy")]
        rows = [[j / 30, *(k + j for k in range(2 * count))] for j in range(12)]
        lines = [head, *([f"{cell:g}" for cell in row] for row in rows)]
        (tmp_path / f"{count}.csv").write_text("\n".join(",".join(line) for line in lines) + "\n")
    assert len(read_markers(tmp_path / "300.csv", scale=1.0).names) == 300
    with pytest.raises(InputError, match="must have at most 300 markers, but is 301 of them: leave those of the fish"):
        read_markers(tmp_path / "301.csv", scale=1.0)


@pytest.mark.parametrize(
    "document",
    [[{f"x{k}": 1} for k in range(2000)], {"time_s": [0] * 3000, **{f"x{k}": 1 for k in range(1500)}}],
    ids=["names", "numbers"],
)
def test_cells_of_json_are_counted_before_they_are_made(tmp_path: Path, document) -> None:
    """Records of different names, and numbers that hold for all rows: 25 kB became millions of cells."""
    (tmp_path / "x.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match="x.json must have at most 3000000 cells and 1000000 records, but is"):
        read_points(tmp_path / "x.json")


def test_names_of_json_do_not_grow_with_their_depth(tmp_path: Path) -> None:
    """A long name over many values would be there once for each."""
    (tmp_path / "x.json").write_text(json.dumps([{"n" * 50_000: {f"x{k}": 1 for k in range(50_000)}}]))
    with pytest.raises(InputError, match="must have names of at most 200 characters, but is longer"):
        read_points(tmp_path / "x.json")
