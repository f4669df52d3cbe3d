"""Files: CSV and NetCDF with provenance, written whole or not at all; the files that ship with the package."""

from __future__ import annotations

import csv
import functools
import io
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hypertuna.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


@functools.cache
def version() -> str:
    """Return the version of hypertuna."""
    from importlib.metadata import version  # slow to import

    return version("hypertuna")


def dataset(variables: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]) -> xr.Dataset:
    """Return a labeled dataset."""
    import xarray as xr  # slow to import

    return xr.Dataset(variables, coordinates, attributes)


def columns_csv(facts: Mapping[str, Any], columns: Mapping[str, Iterable[float]], *, digits: int = 6) -> str:
    """Return columns as CSV below comments with their provenance; NaN leaves its cell empty."""
    cells = ([f"{value + 0.0:.{digits}g}" if value == value else "" for value in column] for column in columns.values())
    rows = zip(*cells, strict=True)
    return _csv(facts, [list(columns), *rows])


def rows_csv(facts: Mapping[str, Any], rows: Iterable[Mapping[str, Any]]) -> str:
    """Return rows as CSV, numbers in full, below comments with their provenance; the first row's keys are the head."""
    rows = list(rows)
    return _csv(facts, [list(row) for row in rows[:1]] + [list(row.values()) for row in rows])


def _csv(facts: Mapping[str, Any], rows: Iterable[Iterable[Any]]) -> str:
    """Return comments and rows as CSV."""
    text = io.StringIO()
    text.writelines("# " + f"{key}: {value}".replace("\n", " ") + "\n" for key, value in facts.items())
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def write_atomically(path: str | Path, content: bytes) -> Path:
    """Write a file whole or not at all: under a temporary name beside the path, then renamed."""
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise _unwritable(path, error) from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(name, 0o666 & ~umask)
        os.replace(name, path)
    except OSError as error:
        Path(name).unlink(missing_ok=True)
        raise _unwritable(path, error) from None
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return path


def write_netcdf(dataset: xr.Dataset | xr.DataTree, path: str | Path) -> Path:
    """Write a dataset, or a tree as groups, as NetCDF, whole or not at all."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "result.nc"
        dataset.to_netcdf(file, engine="h5netcdf")
        return write_atomically(path, file.read_bytes())


def _unwritable(path: Path, error: OSError) -> InputError:
    fix = "choose a path that can be written"
    return InputError("must be a writable file", file=str(path), value=f"not ({error.strerror})", fix=fix)


def shipped(name: str) -> Path:
    """Return the folder of files that ship with the package: ``"robots"``, ``"missions"``, ``"data/published"``, ..."""
    package = Path(__file__).parents[1]  # in a wheel; in a source tree the folders stand at its root
    root = package.parents[1]
    return next(path for base in (package, root, root / "firmware") if (path := base / name).is_dir())
