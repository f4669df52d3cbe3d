"""Files of MATLAB 5: what SciPy writes is read, and bytes by hand in both orders."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from scipy.sparse import csc_array

from hypertuna.errors import InputError
from hypertuna.io.matlab import DEPTH, dense, read_matlab

TYPES = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]


@pytest.mark.parametrize("compressed", [False, True])
def test_numbers_of_every_type_are_read(tmp_path: Path, compressed: bool) -> None:
    arrays = {f"x_{kind}": np.array([[1, 2, 3], [4, 5, 6]], dtype=kind) for kind in TYPES}
    arrays |= {f"low_{kind}": np.array([[np.iinfo(kind).min]], dtype=kind) for kind in ("i1", "i2", "i4", "i8")}
    arrays |= {f"high_{kind}": np.array([[np.iinfo(kind).max]], dtype=kind) for kind in ("u1", "u2", "u4", "u8")}
    savemat(tmp_path / "a.mat", arrays | {"half": np.array([[0.5]])}, do_compression=compressed)
    read = read_matlab(tmp_path / "a.mat").arrays
    assert read.keys() == {*arrays, "half"}
    for name, array in arrays.items():
        assert read[name].tolist() == array.astype(float).tolist()
    assert read["half"].tolist() == [[0.5]]


def test_parts_of_cells_and_structures_have_names(tmp_path: Path) -> None:
    several = np.array([[(1.0, "a"), (2.0, "bc")]], dtype=[("x", object), ("name", object)])
    cell = np.array([[np.array([[7.0]]), "tail"]], dtype=object)
    savemat(tmp_path / "a.mat", {"fish": {"x": 3.0, "fin": {"y": [4.0, 5.0]}}, "data": several, "parts": cell})
    read = read_matlab(tmp_path / "a.mat")
    assert {name: array.tolist() for name, array in read.arrays.items()} == {
        "fish.x": [[3.0]],
        "fish.fin.y": [[4.0, 5.0]],
        "data(1).x": [[1.0]],
        "data(2).x": [[2.0]],
        "parts{1}": [[7.0]],
    }
    assert read.texts == {"data(1).name": "a", "data(2).name": "bc", "parts{2}": "tail"}


def test_a_sparse_array_is_read_as_a_full_one(tmp_path: Path) -> None:
    full = np.array([[0.0, 1.5, 0.0], [2.0, 0.0, 0.0]])
    savemat(tmp_path / "a.mat", {"x": csc_array(full)})
    assert read_matlab(tmp_path / "a.mat").arrays["x"].tolist() == full.tolist()


SPARSE: dict[str, Any] = {"rows": 2, "values": [2.0, 1.5], "row": [1, 0], "begin": [0, 1, 2, 2]}  # the one above


@pytest.mark.parametrize(
    "wrong",
    [
        {"row": [2, 0]},
        {"row": [-1, 0]},
        {"row": [1]},
        {"row": [1.0, 0.0]},
        {"row": [[1, 0]]},
        {"begin": [1, 1, 2, 2]},
        {"begin": [0, 2, 1, 2]},
        {"begin": [0, 1, 2, 3]},
        {"begin": [0]},
        {"begin": [0.0, 1.0, 2.0, 2.0]},
        {"begin": [[0, 1, 2, 2]]},
        {"values": [[2.0, 1.5]]},
        {"rows": 12_000_000},  # three columns: over 256 MB
    ],
    ids=str,
)
def test_the_parts_of_a_sparse_array_agree(wrong: dict[str, Any]) -> None:
    def read(rows: int, **parts: Any) -> Any:
        return dense(rows, *(np.array(part) for part in parts.values()), file="a.mat")

    assert read(**SPARSE).tolist() == [[0.0, 1.5, 0.0], [2.0, 0.0, 0.0]]
    assert read(**SPARSE | {"row": [1, 0, 9]}).tolist() == read(**SPARSE).tolist()  # room that is not used
    with pytest.raises(InputError, match=r"a.mat must be a whole file of MATLAB"):
        read(**SPARSE | wrong)


@pytest.mark.parametrize(("depth", "fits"), [(DEPTH, True), (DEPTH + 1, False)])
def test_cells_lie_in_each_other_eight_deep(tmp_path: Path, depth: int, fits: bool) -> None:
    value: Any = np.array([[1.0]])
    for _ in range(depth):
        cell = np.empty((1, 1), dtype=object)
        cell[0, 0] = value
        value = cell
    savemat(tmp_path / "a.mat", {"x": value})
    if fits:
        assert read_matlab(tmp_path / "a.mat").arrays["x" + "{1}" * depth].tolist() == [[1.0]]
    else:
        with pytest.raises(InputError, match="must hold at most 5000 arrays, 8 deep"):
            read_matlab(tmp_path / "a.mat")


def by_hand(order: str, kind: int = 6, mark: bytes | None = None) -> bytes:
    """Return a file of x = [1; 2], its class and the mark of its order."""

    def element(number: int, content: bytes) -> bytes:
        return struct.pack(f"{order}II", number, len(content)) + content + bytes(-len(content) % 8)

    flags, shape = struct.pack(f"{order}II", kind, 0), struct.pack(f"{order}ii", 2, 1)
    numbers = struct.pack(f"{order}dd", 1.0, 2.0)
    matrix = element(6, flags) + element(5, shape) + element(1, b"x") + element(9, numbers)
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack(f"{order}H", 0x0100)
    return head + (mark or struct.pack(f"{order}H", 0x4D49)) + element(14, matrix)


@pytest.mark.parametrize("order", ["<", ">"])
def test_bytes_of_either_order_are_read(tmp_path: Path, order: str) -> None:
    (tmp_path / "a.mat").write_bytes(by_hand(order))
    assert read_matlab(tmp_path / "a.mat").arrays["x"].tolist() == [[1.0], [2.0]]


@pytest.mark.parametrize(("kind", "names"), [(6, ["x"]), (15, ["x"]), (16, []), (17, [])])
def test_functions_and_objects_are_left_out(tmp_path: Path, kind: int, names: list[str]) -> None:
    (tmp_path / "a.mat").write_bytes(by_hand("<", kind))
    assert [*read_matlab(tmp_path / "a.mat").arrays] == names


@pytest.mark.parametrize("content", [by_hand("<", mark=b"XX"), by_hand("<")[:-8], by_hand("<")[:126], b""])
def test_what_is_no_whole_file_is_told(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mat").write_bytes(content)
    with pytest.raises(InputError, match=r"a.mat must be "):
        read_matlab(tmp_path / "a.mat")


@pytest.mark.parametrize(("spare", "fits"), [(0, True), (-1, False)])
def test_what_is_unpacked_counts_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, spare: int, fits: bool
) -> None:
    """A matrix of 100 doubles unpacks to 800 bytes, and 56 of its tags, flags, shape and name."""
    savemat(tmp_path / "a.mat", {"x": np.zeros((1, 100)), "y": np.zeros((1, 100))}, do_compression=True)
    monkeypatch.setattr("hypertuna.io.matlab.LARGEST", 2 * 856 + spare)
    if fits:
        assert [*read_matlab(tmp_path / "a.mat").arrays] == ["x", "y"]
    else:
        with pytest.raises(InputError, match="must unpack to at most 0 MB, but is more"):
            read_matlab(tmp_path / "a.mat")
