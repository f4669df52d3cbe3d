"""Checks of a folder of shards before its numbers are read: the folder may come from a stranger."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.io.door import KINDS, MB, archived, opened, parse_json, unpacked
from hypertuna.parallel.layout import Layout

NAME = re.compile(r"\w[\w .+-]{0,99}", re.ASCII)  # allowed names of variables and dimensions
METADATA = "zarr.json"  # file with the metadata of a group or an array
# zarr codecs that a column may have, and the data type that each requires ("": any).
CODECS = {"bytes": "", "vlen-utf8": "string"}
TEXTS = 2_000_000  # texts of a column, which take 100 bytes of memory each


def checksum(facts: Mapping[str, Any]) -> str:
    """Return the checksum of a manifest's facts."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def is_sound(layout: Layout, total: int) -> bool:
    """Return whether the parts of a layout have the right types and agree with each other."""
    maps = (*vars(layout).values(), *layout.variables.values())
    if not all(isinstance(mapping, dict) for mapping in maps) or not layout.sizes:
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
    """Return whether NetCDF can hold a value: a number, a text, or a list of either."""
    if isinstance(value, list):
        kinds = {str if isinstance(part, str) else float if isinstance(part, int | float) else None for part in value}
        return len(kinds) < 2 and None not in kinds
    return isinstance(value, str | int | float) and (isinstance(value, str) or abs(value) < 2**63 or value != value)


def read_columns(
    path: Path, names: Iterable[str] | None, count: int, entries: int | None
) -> tuple[dict[str, Array], dict[str, Any]]:
    """Return columns of a shard, by default all, each of `count` rows in one whole piece; and its attributes.

    A row has `entries` values, if given. Zarr itself would accept any shape, and read a missing piece as zeros. The
    archive holds the checksum of each piece. The file is opened once, so that the content checked is the content read.
    """
    with opened(path, "shard") as file, archived(file, KINDS["shard"].largest, stored=True) as archive:
        members = {member.filename: member for member in archive.infolist()}
        if sum(member.file_size for member in members.values()) > os.fstat(file.fileno()).st_size:
            raise ValueError("its pieces lie on each other")
        if any(member.file_size > MB for name, member in members.items() if name.endswith(METADATA)):
            raise ValueError("its metadata is too large")
        stored = sorted(name.removesuffix(f"/{METADATA}") for name in members if name.endswith(f"/{METADATA}"))
        names = stored if names is None else names
        columns = {name: _column(archive, members, name, count, entries) for name in names}
        return columns, dict(parse_json(unpacked(archive, METADATA))["attributes"])


def _column(
    archive: zipfile.ZipFile, members: Mapping[str, zipfile.ZipInfo], name: str, count: int, entries: int | None
) -> Array:
    """Return a column, checked to have one piece, of the size that its shape and type need."""
    import zarr
    from zarr.buffer.cpu import Buffer

    text = unpacked(archive, f"{name}/{METADATA}")
    metadata = parse_json(text)
    shape, dtype = metadata["shape"], metadata["data_type"]
    chunk = "/".join(["c", *("0" for _ in shape)])
    piece = members[f"{name}/{chunk}"]
    fits = len(shape) in (1, 2) and all(type(size) is int and size > 0 for size in shape) and shape[0] == count
    if not fits or (entries is not None and math.prod(shape[1:]) != entries):
        raise ValueError(f"the shape of {name} is another")
    if metadata["chunk_grid"] != {"name": "regular", "configuration": {"chunk_shape": shape}}:
        raise ValueError(f"{name} is not in one piece")
    codecs = [codec["name"] for codec in metadata["codecs"]]
    if len(codecs) != 1 or CODECS.get(codecs[0]) not in ("", dtype):
        raise ValueError(f"{name} is compressed")
    total = math.prod(shape)
    if codecs == ["bytes"]:
        complete = piece.file_size == total * np.dtype(dtype).itemsize
    else:
        with archive.open(piece) as content:
            complete = int.from_bytes(content.read(4), "little") == total <= TEXTS
    if not complete:
        raise ValueError(f"the size of {name} is not that of its shape")
    parts = {METADATA: text, chunk: unpacked(archive, piece)}
    store = {key: Buffer.from_bytes(part) for key, part in parts.items()}
    column: Any = zarr.open_array(zarr.storage.MemoryStore(store), mode="r")
    return np.asarray(column[...])
