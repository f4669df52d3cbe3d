"""The program that reads an HDF5 file for the package: what it writes of each kind of array."""

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from hypertuna.io.hdf5_child import DEPTH, attributes, texts

MAIN = "from hypertuna.io import hdf5_child as c; c.LARGEST, c.MOST, c.OBJECTS, c.LETTERS, c.TEXTS = {}; c.main()"
LIMITS = (6, 14, 40, 400, 4)


def read(path: Path, limits: tuple[int, ...] = LIMITS) -> tuple[dict[str, Any], list[str], list[str]]:
    """Return arrays and texts by name, what was left out, and all names with attributes."""
    with path.open("rb") as file:
        line = [sys.executable, "-c", MAIN.format(limits)]
        head, _, rest = subprocess.run(line, stdin=file, capture_output=True, check=True).stdout.partition(b"\n")
    told, found = json.loads(head), {}
    for one in told["entries"]:
        if "type" in one:
            size = int(np.prod(one["shape"])) * np.dtype(one["type"]).itemsize
            found[one["name"]] = np.frombuffer(rest[:size], one["type"]).reshape(one["shape"]).tolist()
            rest = rest[size:]
        elif "texts" in one:
            found[one["name"]] = one["texts"]
    assert not rest
    return found, told["left_out"], [one["name"] for one in told["entries"] if "attributes" in one]


def test_numbers_and_texts_are_read_and_other_kinds_left(tmp_path: Path) -> None:
    pair = np.array([(1, 2.5, b"a")], dtype=[("frame", "i4"), ("x", "f8", (2,)), ("name", "S1")])
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["big_end"] = np.array([1, -2], dtype=">i2")
        file["true"] = np.array([True])
        file["fish/points"] = pair
        file["names"] = np.array([b"nose", b"tail"])
        file["words"] = np.array(["nose", "é"], dtype=h5py.string_dtype())
        file["complex"] = np.array([1j])
        file["opaque"] = np.array([b"ab"], dtype="V2")
        file["empty"] = h5py.Empty("f8")
        file["_i_table"] = np.array([1.0])
        file["link"] = h5py.SoftLink("/true")
    assert read(tmp_path / "a.h5") == (
        {
            "big_end": [1, -2],
            "true": [True],
            "fish/points/frame": [1],
            "fish/points/x": [[2.5, 2.5]],
            "names": ["nose", "tail"],
            "words": ["nose", "é"],
        },
        [],
        ["big_end", "complex", "empty", "fish", "fish/points", "names", "opaque", "true", "words"],
    )


def test_limits_leave_out_what_is_beyond(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["a"] = np.zeros(6)
        file["b"] = np.zeros(7)  # more than one array has
        file["c"] = np.zeros(6)
        file["d"] = np.zeros(3)  # 15 of all, where 14 are the most
        file["e"] = np.zeros(2)
        file["f"] = np.zeros(1)
        file["t"] = np.array([b"x"] * 4)
        file["u"] = np.array([b"x"] * 5)
        file["v"] = np.array([b"x" * 389])  # with 4 and 5 letters, 398; below 400
        file["w"] = np.array([b"x", b"x"])  # 400
    found, left_out, names = read(tmp_path / "a.h5")
    assert [*found] == ["a", "c", "e", "t", "v"]
    assert (left_out, len(names)) == (["b", "d", "f"], 10)
    _, left_out, names = read(tmp_path / "a.h5", (*LIMITS[:2], 5, *LIMITS[3:]))
    assert (left_out, names) == (["b", "d", "..."], [*"abcde"])


def test_groups_lie_in_each_other_eight_deep(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["g/" * DEPTH + "x"] = np.array([1.0])
        file["h/" * (DEPTH + 1) + "x"] = np.array([1.0])
    assert [*read(tmp_path / "a.h5")[0]] == ["g/" * DEPTH + "x"]


def test_attributes_are_texts_and_single_numbers(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.attrs.update({"rate": 50.0, "one": np.array([3]), "unit": "mm", "raw": np.bytes_(b"m"), "list": [1, 2]})
        assert attributes(file, Counter()) == {"rate": 50.0, "one": 3, "unit": "mm", "raw": "m"}


@pytest.mark.parametrize("array", [np.array([[b"a", b"b"]]), np.array([["a"], ["b"]], dtype=object)])
def test_texts_are_those_of_a_flat_array(array: Any) -> None:
    assert texts(array) == ["a", "b"]
