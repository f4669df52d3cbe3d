"""Bounds of what a folder of shards may hold, each tried at and beside its limit, without any swim."""

from __future__ import annotations

import json
import math
import zipfile
from collections import Counter
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from hypertuna.io.door import MB
from hypertuna.parallel.checks import checksum, is_sound
from hypertuna.parallel.executors import LOSSES, _scheduler_address, map_shards
from hypertuna.parallel.layout import Layout
from hypertuna.parallel.shards import (
    LISTED,
    MANIFEST,
    MARK,
    MERGED,
    Cases,
    Shards,
    make_shards,
    open_shards,
    shard_size,
    write_merged,
)

SPEED, NAME = {"units": "m/s", "long_name": "speed"}, {"long_name": "name"}
LAYOUT = Layout({"a": 3}, {"speed": SPEED, "name": NAME}, {"a": ("a", [1, 2, 3], {})}, {}, {"speed": "speed_m_s"})
COLUMNS = {"speed": np.array([0.5, 1.0, 1.5]), "name": np.array(["x", "yy", ""], dtype=object)}


def filled(folder: Path, size: int) -> Shards:
    """Write three items in shards."""
    shards = Shards(folder, {}, 3, size, LAYOUT, "`sweep`", "digest")
    for shard in range(len(shards)):
        shards.write(shard, columns(*shards.range(shard)))
    return shards


def columns(first: int, last: int) -> dict[str, Any]:
    """Return a range of the items."""
    return {name: values[first:last] for name, values in COLUMNS.items()}


def members(shards: Shards) -> dict[str, bytes]:
    """Return the files of the first shard."""
    with zipfile.ZipFile(shards.path(0)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def write_members(shards: Shards, files: dict[str, bytes], compression: int = zipfile.ZIP_STORED) -> None:
    """Write the first shard again."""
    with zipfile.ZipFile(shards.path(0), "w", compression) as archive:
        for name, content in files.items():
            archive.writestr(name, content)


@pytest.mark.parametrize(
    ("value", "sound"),
    [
        (1, True),
        ("text", True),
        (math.nextafter(2**63, 0), True),
        (2**63 - 1, True),
        (2**63, False),
        (-(2**63) + 1, True),
        (-(2**63), False),  # NetCDF holds it; a bound that is the same for either sign is simpler
        (float(2**63), False),
        (math.inf, False),
        (math.nan, True),
        ([1, 2.5], True),
        (["a", "b"], True),
        ([], True),
        ([1, "b"], False),
        ([1, None], False),
        ([[1]], False),
        (None, False),
        ({"a": 1}, False),
    ],
    ids=str,
)
def test_a_fact_is_what_netcdf_holds(value: Any, sound: bool) -> None:
    assert is_sound(replace(LAYOUT, facts={"fact": value}), 3) is sound


@pytest.mark.parametrize(
    ("part", "sound"),
    [
        ({}, True),
        ({"sizes": {"a": 3, "part": 2}}, True),  # an item may have two entries
        ({"sizes": {"a": 1, "part": 3}}, False),  # the three labels of a
        ({"sizes": {}}, False),
        ({"sizes": {"a": 3, "part": 0}}, False),
        ({"sizes": {"a": 3, "part": True}}, False),
        ({"variables": {"a": SPEED}}, False),  # a name of two things
        ({"variables": {"a" * 100: SPEED}, "table": {}}, True),
        ({"variables": {"a" * 101: SPEED}, "table": {}}, False),
        ({"table": {"other": "head"}}, False),
        ({"table": {"speed": 1}}, False),
        ({"coordinates": {"b": ("a", [1, 2], {})}}, False),
        ({"coordinates": {"b": ("a", (1, 2, 3), {})}}, False),  # of Python alone, never read
        ({"coordinates": {"b": ("a", [1, 2, 3], 1)}}, False),
        ({"facts": []}, False),
    ],
    ids=str,
)
def test_the_parts_of_a_layout_agree(part: dict[str, Any], sound: bool) -> None:
    assert is_sound(replace(LAYOUT, **part), 3) is sound


@pytest.mark.parametrize(
    ("total", "size", "sound"), [(3, 1, True), (1, 1, True), (0, 1, False), (3, 0, False), (3, True, False)]
)
def test_a_manifest_counts_from_one(tmp_path: Path, total: int, size: int, sound: bool) -> None:
    facts = {"header": {}, "total": total, "size": size, "layout": vars(LAYOUT), "command": "`sweep`"}
    (tmp_path / MANIFEST).write_text(json.dumps(facts | {"mark": MARK, "sha256": checksum(facts)}))
    if sound:
        assert len(open_shards(tmp_path)) == total
    else:
        with pytest.raises(ht.InputError, match="must be a manifest of shards"):
            open_shards(tmp_path)


def test_a_shard_and_their_number_are_at_most_a_million() -> None:
    assert [shard_size(10, size) for size in (1, 1_000_000)] == [1, 1_000_000]
    for size in (0, 1_000_001):
        with pytest.raises(ht.InputError, match=rf"size must be from 1 to 1000000, but is {size}"):
            shard_size(10, size)
    assert shard_size(2_000_000, 2) == 2
    with pytest.raises(ht.InputError, match=r"but is 1000001: 2000001 results, 2 in a shard: compute at most 2000000 "):
        shard_size(2_000_001, 2)


@pytest.mark.parametrize(("size", "ranges"), [(1, [(0, 1), (1, 2), (2, 3)]), (2, [(0, 2), (2, 3)]), (3, [(0, 3)])])
def test_columns_are_read_as_written(tmp_path: Path, size: int, ranges: list[tuple[int, int]]) -> None:
    shards = filled(tmp_path, size)
    assert [shards.range(shard) for shard in range(len(shards))] == ranges
    for shard, (first, last) in enumerate(ranges):
        read = shards.read(shard)
        assert {name: (values.dtype, list(values)) for name, values in read.items()} == {
            name: (values.dtype, list(values[first:last])) for name, values in COLUMNS.items()
        }
        assert [*shards.read(shard, ["speed"])] == ["speed"]
    with pytest.raises(ht.InputError, match="must be a shard of the manifest in its folder, but is of another"):
        replace(shards, digest="other").read(0)
    if len(shards) == 3:
        shards.path(1).write_bytes(shards.path(0).read_bytes())
        with pytest.raises(ht.InputError, match="must be shard 1, but is shard 0"):
            shards.read(1)


@pytest.mark.parametrize(("name", "steps"), [("a.nc", 4), ("a.csv", 2), (None, 2)])
def test_a_merge_tells_each_shard_of_each_variable(tmp_path: Path, name: str | None, steps: int) -> None:
    shards, told = filled(tmp_path / "a.shards", 2), []
    write_merged(shards, name and tmp_path / name, lambda done, total: told.append((done, total)))
    assert told == [(step, steps) for step in range(1, steps + 1)]
    if name == "a.nc":
        with xr.open_dataset(tmp_path / name) as data:
            assert data.speed.values.tolist() == [0.5, 1.0, 1.5]
            assert data.name.values.tolist() == ["x", "yy", ""]
    if name == "a.csv":
        rows = [row for row in (tmp_path / name).read_text().splitlines() if not row.startswith("#")]
        assert rows == ["a,speed_m_s", "1,0.5", "2,1.0", "3,1.5"]


@pytest.mark.parametrize(
    ("name", "values", "sentence"),
    [
        ("a.nc", MERGED, "must have all 1 shards"),
        ("a.nc", MERGED + 1, rf"but is {MERGED + 1}: compute it in parts"),
        ("a.csv", MERGED // 2, "must have all 1 shards"),
        ("a.csv", MERGED // 2 + 1, rf"but is {MERGED + 2}: merge into a NetCDF file"),
    ],
)
def test_memory_holds_so_many_values(tmp_path: Path, name: str, values: int, sentence: str) -> None:
    shards = Shards(tmp_path, {}, values, values, replace(LAYOUT, sizes={"a": values}), "")
    with pytest.raises(ht.InputError, match=sentence):
        write_merged(shards, tmp_path / name, lambda done, total: None)


@pytest.mark.parametrize(
    ("missing", "words"),
    [(1, r"1 is missing \(0\)"), (LISTED, f"{LISTED} are missing .*[0-9]\\)"), (LISTED + 1, "1 more")],
)
def test_missing_shards_are_listed(tmp_path: Path, missing: int, words: str) -> None:
    with pytest.raises(ht.InputError, match=words):
        write_merged(Shards(tmp_path, {}, missing, 1, LAYOUT, ""), None, lambda done, total: None)


@pytest.mark.parametrize(("port", "known"), [(0, False), (1, True), (65535, True), (65536, False)])
def test_a_port_has_sixteen_bits(port: int, known: bool) -> None:
    pytest.importorskip("distributed")
    place = f"tcp://127.0.0.1:{port}"
    if known:
        assert _scheduler_address(place) == place
    else:
        with pytest.raises(ValueError):  # noqa: PT011 - no sentence: `cluster` has it
            _scheduler_address(place)


class Losing(Executor):
    """Lose the worker of each shard a number of times before it returns."""

    def __init__(self, times: int, error: BaseException) -> None:
        self.times, self.error, self.tries = times, error, Counter[int]()

    def submit(self, task: Any, /, shard: Any, *_: Any, **__: Any) -> Future[Any]:
        """Return what has happened at once."""
        future: Future[Any] = Future()
        self.tries[shard] += 1
        if self.tries[shard] > self.times:
            future.set_result(task(shard))
        elif isinstance(self.error, CancelledError):
            future.cancel()
        else:
            future.set_exception(self.error)
        return future


@pytest.mark.parametrize("error", [BrokenExecutor(), CancelledError()], ids=["broken", "cancelled"])
def test_a_shard_may_lose_its_worker_five_times_in_a_row(error: BaseException) -> None:
    patient = Losing(LOSSES, error)
    assert [*map_shards(str, [7], patient)] == ["7"]
    assert patient.tries == {7: LOSSES + 1}
    with pytest.raises(ht.InputError, match=f"executor lost the worker of shard 7 {LOSSES + 1} times in a row"):
        [*map_shards(str, [7], Losing(LOSSES + 1, error))]
    assert [*map_shards(str, range(9), Losing(1, error))] == [*"012345678"]  # each anew


def test_an_error_of_the_work_is_no_loss() -> None:
    failing = Losing(1, ZeroDivisionError())
    with pytest.raises(ZeroDivisionError) as caught:
        [*map_shards(str, [7], failing)]
    assert caught.value.__notes__ == ["in shard 7"]
    assert failing.tries == {7: 1}


def test_no_more_shards_are_in_flight_than_asked() -> None:
    pool = Losing(0, BrokenExecutor())
    results = map_shards(str, range(9), pool, in_flight=4)
    assert [(next(results), pool.tries.total()) for _ in range(3)] == [("0", 4), ("1", 5), ("2", 6)]


@pytest.mark.parametrize(
    ("part", "made", "steps"), [((1, 1), [0, 1, 2], 3), ((1, 2), [0, 2], 2), ((2, 2), [1], 1), ((4, 4), [], 0)]
)
def test_a_part_makes_every_nth_shard(tmp_path: Path, part: tuple[int, int], made: list[int], steps: int) -> None:
    work, told = Cases({}, 3, LAYOUT, columns), []
    count = make_shards(
        work, tmp_path, size=1, part=part, command="c", progress=lambda done, total: told.append((done, total))
    )
    shards = open_shards(tmp_path)
    assert (count, told) == (steps, [(step, steps) for step in range(1, steps + 1)])
    assert [shard for shard in range(3) if shards.path(shard).exists()] == made
    for shard in made:
        assert shards.read(shard)["speed"].tolist() == [COLUMNS["speed"][shard]]


@pytest.mark.parametrize("part", [(0, 1), (2, 1), (-1, 1)])
def test_a_part_is_one_of_its_number(tmp_path: Path, part: tuple[int, int]) -> None:
    with pytest.raises(ht.InputError, match="part must be I and N, I from 1 to N"):
        make_shards(Cases({}, 3, LAYOUT, columns), tmp_path, size=1, part=part, command="c")
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize(("size", "fits"), [(MB, True), (MB + 1, False)])
def test_the_metadata_of_a_column_has_a_megabyte(tmp_path: Path, size: int, fits: bool) -> None:
    shards = filled(tmp_path, 3)
    files = members(shards)
    files["speed/zarr.json"] = files["speed/zarr.json"].ljust(size)
    write_members(shards, files)
    if fits:
        assert shards.read(0)["speed"].tolist() == [0.5, 1.0, 1.5]
    else:
        with pytest.raises(ht.InputError, match="its metadata is too large"):
            shards.read(0)


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        (b'"shape": [\n    3\n  ]', b'"shape": [\n    3, 2\n  ]', "the shape of speed is another"),
        (b'"shape": [\n    3\n  ]', b'"shape": [\n    3, 0\n  ]', "the shape of speed is another"),
        (b'"shape": [\n    3\n  ]', b'"shape": [\n    3, 1.0\n  ]', "the shape of speed is another"),
        (b'"shape": [\n    3\n  ]', b'"shape": [\n    3, 1, 1\n  ]', "the shape of speed is another"),
        (b'"name": "bytes"', b'"name": "gzip"', "speed is compressed"),
        (b'"name": "bytes"', b'"name": "vlen-utf8"', "speed is compressed"),
    ],
)
def test_a_column_has_one_entry_an_item_and_is_not_compressed(
    tmp_path: Path, before: bytes, after: bytes, sentence: str
) -> None:
    shards = filled(tmp_path, 3)
    files = members(shards)
    about = files["speed/zarr.json"]
    assert before in about
    files["speed/zarr.json"] = about.replace(before, after, 1)
    for dimension in (2, 3):
        place = "/".join("0" * dimension)
        files[f"speed/c/{place}"] = files["speed/c/0"]
    write_members(shards, files)
    with pytest.raises(ht.InputError, match=sentence):
        shards.read(0)


def test_no_file_of_a_shard_is_compressed(tmp_path: Path) -> None:
    shards = filled(tmp_path, 3)
    files = members(shards)
    write_members(shards, files, zipfile.ZIP_DEFLATED)
    with pytest.raises(ht.InputError, match="a file is compressed in another way"):
        shards.read(0)
