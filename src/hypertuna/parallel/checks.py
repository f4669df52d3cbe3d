"""Checks of a folder of shards before its numbers are read: it may come from a stranger."""

from __future__ import annotations

import hashlib
import json
import math
import re
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.io.door import KINDS, members, opened, parse_json
from hypertuna.parallel.layout import Layout

NAME = re.compile(r"\w[\w .+-]{0,99}", re.ASCII)  # of variables and dimensions
ABOUT = "zarr.json"
CODECS = {"bytes": "", "vlen-utf8": "string"}  # of columns: their type, if it is one alone


def checksum(facts: Mapping[str, Any]) -> str:
    """Return the checksum of a manifest's facts."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def is_sound(layout: Layout, total: int) -> bool:
    """Whether the parts of a layout are of their types and agree."""
    maps = (*vars(layout).values(), *layout.variables.values())
    if not all(isinstance(one, dict) for one in maps) or not layout.sizes:
        return False
    names = (*layout.sizes, *layout.variables, *layout.coordinates, *layout.table)
    attributes = (layout.facts, *layout.variables.values(), *(about for _, _, about in layout.coordinates.values()))
    return (
        all(type(size) is int and size > 0 for size in layout.sizes.values())
        and math.prod(layout.sizes.values()) % total == 0  # an item may have several entries
        and all(NAME.fullmatch(name) for name in names)
        and not layout.variables.keys() & (layout.coordinates.keys() | layout.sizes.keys())
        and all(isinstance(about, dict) and all(map(_is_plain, about.values())) for about in attributes)
        and all(
            isinstance(values, list) and len(values) == layout.sizes[dim] and _is_plain(values)
            for dim, values, _ in layout.coordinates.values()
        )
        and all(isinstance(head, str) for head in layout.table.values())
        and layout.table.keys() <= layout.variables.keys()
    )


def _is_plain(value: Any) -> bool:
    """Whether a value is one that NetCDF holds: a number, a text, or a list of either."""
    if isinstance(value, list):
        kinds = {str if isinstance(part, str) else float if isinstance(part, int | float) else None for part in value}
        return len(kinds) < 2 and None not in kinds
    return isinstance(value, str | int | float) and (isinstance(value, str) or abs(value) < 2**63 or value != value)


def check_shard(path: Path, names: Iterable[str] | None, count: int, entries: int | None) -> list[str]:
    """Check the file of a shard and return its columns, by default all: each of `count` rows in one whole piece.

    A row has so many `entries`, if it is known. Zarr would take any shape, and zeros for a piece that is missing. The
    checksum of each piece is in the archive.
    """
    with opened(path, "shard") as file, zipfile.ZipFile(file) as archive:
        there = {one.filename: one for one in members(archive, KINDS["shard"].largest, stored=True)}
        if sum(one.file_size for one in there.values()) > path.stat().st_size:
            raise ValueError("its pieces lie on each other")
        found = sorted(name.removesuffix(f"/{ABOUT}") for name in there if name.endswith(f"/{ABOUT}"))
        for name in found if names is None else names:
            _check_column(archive, there, name, count, entries)
        return found if names is None else list(names)


def _check_column(
    archive: zipfile.ZipFile, there: Mapping[str, zipfile.ZipInfo], name: str, count: int, entries: int | None
) -> None:
    """Check that a column has one piece, of the size that its shape and type need."""
    about = parse_json(archive.read(there[f"{name}/{ABOUT}"]))
    shape, kind = about["shape"], about["data_type"]
    piece = there["/".join([name, "c", *("0" for _ in shape)])]
    rows = len(shape) in (1, 2) and all(type(size) is int and size > 0 for size in shape) and shape[0] == count
    if not rows or (entries is not None and math.prod(shape[1:]) != entries):
        raise ValueError(f"the shape of {name} is another")
    if about["chunk_grid"] != {"name": "regular", "configuration": {"chunk_shape": shape}}:
        raise ValueError(f"{name} is not in one piece")
    codecs = [codec["name"] for codec in about["codecs"]]
    if len(codecs) != 1 or CODECS.get(codecs[0]) not in ("", kind):
        raise ValueError(f"{name} is compressed")
    with archive.open(piece) as content:
        if codecs == ["bytes"]:
            whole = piece.file_size == math.prod(shape) * np.dtype(kind).itemsize
        else:
            whole = int.from_bytes(content.read(4), "little") == math.prod(shape)
    if not whole:
        raise ValueError(f"the size of {name} is not that of its shape")
