"""Bounds of what a folder of shards may hold, each tried at and beside its limit, without any swim."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from hypertuna.parallel.checks import checksum, is_sound
from hypertuna.parallel.executors import _checked
from hypertuna.parallel.layout import Layout
from hypertuna.parallel.shards import LISTED, MANIFEST, MARK, MERGED, Shards, open_shards, shard_size, write_merged

SPEED, NAME = {"units": "m/s", "long_name": "speed"}, {"long_name": "name"}
LAYOUT = Layout({"a": 3}, {"speed": SPEED, "name": NAME}, {"a": ("a", [1, 2, 3], {})}, {}, {"speed": "speed_m_s"})
COLUMNS = {"speed": np.array([0.5, 1.0, 1.5]), "name": np.array(["x", "yy", ""], dtype=object)}


def filled(folder: Path, size: int) -> Shards:
    """Write three items in shards."""
    shards = Shards(folder, {}, 3, size, LAYOUT, "`sweep`", "digest")
    for shard in range(len(shards)):
        first, last = shards.range(shard)
        shards.write(shard, {name: values[first:last] for name, values in COLUMNS.items()})
    return shards


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
        assert _checked(place) == place
    else:
        with pytest.raises(ValueError):  # noqa: PT011 - no sentence: `cluster` has it
            _checked(place)
