"""The folder of shards: a manifest, and a Zarr file for each range of items, there whole or not at all."""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.checkpoint import check_same_header
from hypertuna.io.door import MB, damage, parse_json, read_bytes
from hypertuna.io.extras import need
from hypertuna.io.files import by_conventions, columns_csv, replaced, scratch, variable_columns, write_atomically
from hypertuna.parallel.checks import checksum, is_sound, read_columns
from hypertuna.parallel.executors import Executors, map_shards
from hypertuna.parallel.layout import NO_LAYOUT, Layout
from hypertuna.ranges import Whole

if TYPE_CHECKING:
    import xarray as xr

MARK = "hypertuna shards"  # format's name in the manifest
MANIFEST = "manifest.json"
SUFFIX = ".shards"  # of the folder's name
LARGEST, SMALLEST = 131_072, 256  # limits of the default size of a shard [items]; the largest is 20 MB of gaits
USUAL = 64  # shards of work whose default size is within these limits
SIZES = Whole(min=1, max=1_000_000)  # items of a shard: 200 MB of gaits
MOST = 1_000_000  # shards of a folder
MERGED = 50_000_000  # values merged at once: 0.8 GB
LISTED = 10  # shards that an error names
# Fix for missing shards. A manifest may come from a stranger, so its command is not printed for pasting.
AGAIN = f"run the command again that made the folder; {MANIFEST} has it, for you to read before"
IN_FLIGHT = 2048  # shards submitted at once: each returns only a number
WHOLE = {"write_empty_chunks": True}  # store zeros too, so that a missing piece is noticed
TEXT = np.dtypes.StringDType()  # the type of texts in Zarr

Columns = Mapping[str, Array]


@dataclass(frozen=True)
class Shards:
    """Folder of shards, whose manifest has been read or written."""

    folder: Path
    header: Mapping[str, Any]  # what the results depend on
    total: int  # items
    size: int  # items of a shard; the last may have fewer
    layout: Layout
    command: str  # the command that made the folder, according to its manifest
    digest: str = ""  # checksum of the manifest, which each shard carries

    def __len__(self) -> int:
        return -(-self.total // self.size)

    def range(self, shard: int) -> tuple[int, int]:
        """Return the first item of a shard, and the one after its last."""
        return shard * self.size, min((shard + 1) * self.size, self.total)

    def path(self, shard: int) -> Path:
        """Return the path of a shard's file."""
        return self.folder / f"shard-{shard:06}.zarr.zip"

    def missing(self, part: tuple[int, int] = (1, 1)) -> list[int]:
        """Return the shards without a file, in part I of N: every N-th shard from the I-th."""
        return [shard for shard in range(part[0] - 1, len(self), part[1]) if not self.path(shard).exists()]

    def write(self, shard: int, columns: Columns) -> int:
        """Write a shard; return its bytes."""
        import zarr

        attributes = {"manifest": self.digest, "shard": shard, "range": list(self.range(shard))}
        with scratch() as folder:
            file = folder / "shard.zip"
            with zarr.storage.ZipStore(file, mode="w") as store:
                group = zarr.create_group(store, attributes=attributes)
                for name, values in columns.items():
                    stored = values.astype(TEXT) if values.dtype.kind in "UO" else values
                    group.create_array(name, data=stored, chunks=values.shape, compressors=None, config=WHOLE)
            content = file.read_bytes()
        write_atomically(self.path(shard), content)
        return len(content)

    def read(self, shard: int, names: Iterable[str] | None = None) -> dict[str, Array]:
        """Return the columns of a shard, or some of them, checked."""
        path, first, last = self.path(shard), *self.range(shard)
        again = f"remove it, then {AGAIN}"
        sizes = self.layout.sizes.values()
        try:
            entries = math.prod(sizes) // self.total if sizes else None
            columns, attributes = read_columns(path, names, last - first, entries)
            columns |= {name: values.astype(object) for name, values in columns.items() if values.dtype == TEXT}
        except InputError as error:
            raise InputError(error.rule, file=str(path), value=error.value, fix=again) from None
        except damage() as error:
            raise InputError(f"is damaged ({error})", file=str(path), fix=again) from None
        if attributes.get("manifest") != self.digest:
            raise InputError(
                "must be a shard of the manifest in its folder", file=str(path), value="of another", fix=again
            )
        if attributes.get("shard") != shard:
            value = f"shard {attributes.get('shard')}"
            raise InputError(f"must be shard {shard}", file=str(path), value=value, fix=again)
        return columns


def shard_size(total: int, size: int | None = None) -> int:
    """Return the number of items of a shard; it depends only on `total`, so that all machines split the work alike."""
    if size is not None:
        SIZES.check(size, "size", "leave it out for the default")
    else:
        size = min(LARGEST, max(SMALLEST, -(-total // USUAL)))
    if total > MOST * size:
        value = f"{-(-total // size)}: {total} results, {size} in a shard"
        fix = f"compute at most {MOST * size} results, or put more into a shard"
        raise InputError(f"must be at most {MOST}", key="the number of shards", value=value, fix=fix)
    return size


def open_shards(folder: str | Path) -> Shards:
    """Read the manifest of a folder of shards."""
    need("cluster", "zarr", by="a folder of shards")
    path = Path(folder) / MANIFEST
    fix = f"give the folder that a command wrote with -o NAME{SUFFIX}"
    try:
        content = read_bytes(path, "manifest")
    except InputError as error:
        raise InputError(error.rule, file=str(path), value=error.value, fix=fix) from None
    try:
        manifest = parse_json(content)
        if manifest.pop("mark") != MARK:
            raise ValueError
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError("must be a manifest of shards", file=str(path), fix=fix) from None
    digest, restart = manifest.pop("sha256", None), "start over in another folder"
    if digest is None:
        raise InputError("must be a manifest with a checksum, which earlier versions lack", file=str(path), fix=restart)
    if digest != checksum(manifest):
        raise InputError("is damaged", file=str(path), fix=restart)
    try:
        shards = Shards(Path(folder), layout=Layout(**manifest.pop("layout")), **manifest, digest=digest)
        counts_fit = all(type(count) is int and count > 0 for count in (shards.total, shards.size))
        texts_fit = isinstance(shards.header, dict) and isinstance(shards.command, str)
        if not (counts_fit and texts_fit and len(shards) <= MOST and is_sound(shards.layout, shards.total)):
            raise ValueError
        return shards
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError):
        raise InputError("must be a manifest of shards", file=str(path), fix=fix) from None


@dataclass(frozen=True)
class Cases:
    """Independent cases; each shard holds a range of them."""

    header: Mapping[str, Any]  # what the results depend on
    total: int
    layout: Layout
    work: Callable[[int, int], Columns]  # columns of the cases from first to last


def make_shards(
    cases: Cases,
    folder: str | Path,
    executor: Executors | None = None,
    *,
    size: int | None = None,
    part: tuple[int, int] = (1, 1),
    command: str,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Compute and write the missing shards of part I of N parts; return the number of shards made."""
    if not 1 <= part[0] <= part[1]:
        raise InputError("must be I and N, I from 1 to N", key="part", value=f"{part}", fix="give (3, 100), say")
    shards = _opened(folder, cases, size, command)
    missing = shards.missing(part)
    part_size = len(range(part[0] - 1, len(shards), part[1]))
    # Workers need no labels, and may run in another folder.
    shards = replace(shards, layout=NO_LAYOUT, folder=shards.folder.absolute())
    task, made = _ShardTask(shards, cases.work), 0
    for made, _ in enumerate(map_shards(task, missing, executor, in_flight=IN_FLIGHT), 1):
        if progress is not None:
            progress(part_size - len(missing) + made, part_size)
    return made


def _opened(folder: str | Path, cases: Cases, size: int | None, command: str) -> Shards:
    """Return a folder of shards: a new one, or the present one if its header is the same."""
    need("cluster", "zarr", by="a folder of shards")
    shards = Shards(Path(folder), cases.header, cases.total, shard_size(cases.total, size), cases.layout, command)
    path = shards.folder / MANIFEST
    if not path.exists():
        if shards.folder.is_dir() and any(shards.folder.glob("[!.]*")):
            rule, fix = "must be a new or empty folder, or one of shards", "choose another folder"
            raise InputError(rule, file=str(folder), fix=fix)
        facts = {name: getattr(shards, name) for name in ("header", "total", "size", "command")}
        facts = json.loads(json.dumps({**facts, "layout": vars(cases.layout)}, default=np.ndarray.tolist))
        text = json.dumps({"mark": MARK, "sha256": checksum(facts), **facts}, indent=1)
        write_atomically(path, text.encode())
    present = open_shards(folder)  # the manifest of the process that wrote it first
    sizes = {"items": shards.total, "shard size": present.size if size is None else shards.size}
    old = {**present.header, "items": present.total, "shard size": present.size}
    check_same_header(
        str(path), old, {**cases.header, **sizes}, "give another folder, or remove this one to start over"
    )
    return present


@dataclass(frozen=True)
class _ShardTask:
    """A task of an executor: compute a shard and write it."""

    shards: Shards
    work: Callable[[int, int], Columns]  # columns of the items from first to last

    def __call__(self, shard: int) -> int:
        return self.shards.write(shard, self.work(*self.shards.range(shard)))


@checked
def merge_shards(folder: str | Path) -> xr.Dataset:
    """Merge a folder of shards, after a check that each is there once, whole, and of this work.

    Parameters
    ----------
    folder : str or Path
        What `sweep_shards`, `hypertuna.mission.seeds.fly_seed_shards`, `hypertuna.fe.joint_map.joint_map_shards`, or a
        command with ``-o NAME.shards``, wrote.

    Returns
    -------
    xarray.Dataset
        What the same work returns without shards, to the bit.

    Raises
    ------
    InputError
        If a shard is missing, damaged, or of other work, or if there are more values than memory holds.
    """
    shards = open_shards(folder)
    _check_values(shards, len(shards.layout.variables))
    check_complete(shards)
    return _merged_dataset(shards, lambda *_: None)


def _merged_dataset(shards: Shards, progress: Callable[[int, int], None]) -> xr.Dataset:
    """Return the dataset of all shards, merged in memory."""
    parts = []
    for shard in range(len(shards)):
        parts.append(shards.read(shard, shards.layout.variables))
        progress(shard + 1, len(shards))
    return shards.layout.dataset(
        {name: np.concatenate([p.pop(name) for p in parts]) for name in shards.layout.variables}
    )


def write_merged(shards: Shards, path: str | Path | None, progress: Callable[[int, int], None]) -> None:
    """Check all shards and merge them into a file, NetCDF variable by variable: memory holds one of them."""
    is_csv = path is not None and str(path).lower().endswith(".csv")
    _check_values(shards, len(shards.layout.variables) if is_csv else int(path is not None))
    check_complete(shards)
    if path is None:
        for shard in range(len(shards)):
            shards.read(shard)
            progress(shard + 1, len(shards))
        return
    if is_csv:
        data = _merged_dataset(shards, progress).assign_attrs(command=shards.command)
        columns_csv(data.attrs, variable_columns(data, shards.layout.heads), digits=None).write(path)
        return
    names = list(shards.layout.variables)
    with replaced(path) as file:
        for v, name in enumerate(names):
            parts = []
            for shard in range(len(shards)):
                parts.append(shards.read(shard, [name])[name])
                progress(v * len(shards) + shard + 1, len(names) * len(shards))
            data = shards.layout.dataset({name: np.concatenate(parts)}).assign_attrs(command=shards.command)
            if shutil.disk_usage(file.parent).free < data.nbytes + MB:  # else HDF5 would end the program
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            by_conventions(data).to_netcdf(file, mode="a" if v else "w", engine="h5netcdf")


def _check_values(shards: Shards, variables: int) -> None:
    """Check that a number of variables, of the sizes in the manifest, has few enough values to merge at once."""
    values = math.prod(shards.layout.sizes.values()) * variables
    if values > MERGED:
        rule = f"must have at most {MERGED} values to merge at once"
        fix = "merge into a NetCDF file, which takes a variable at a time" if variables > 1 else "compute it in parts"
        raise InputError(rule, file=str(shards.folder), value=f"{values}", fix=fix)


def check_complete(shards: Shards) -> None:
    """Check that all shards are there, and none of other work."""
    expected = {shards.path(shard).name for shard in range(len(shards))}
    if foreign := sorted(file.name for file in shards.folder.glob("shard-*") if file.name not in expected):
        fix = "remove it" if len(foreign) == 1 else f"remove it and {len(foreign) - 1} more"
        raise InputError("must be a shard of the manifest in its folder", file=str(shards.folder / foreign[0]), fix=fix)
    if missing := shards.missing():
        numbers = ", ".join(map(str, missing[:LISTED])) + f" and {len(missing) - LISTED} more" * (len(missing) > LISTED)
        lacking = f"{len(missing)} {'are' if missing[1:] else 'is'} missing ({numbers})"
        rule = f"must have all {len(shards)} shards, but {lacking}"
        raise InputError(rule, file=str(shards.folder), fix=AGAIN)
