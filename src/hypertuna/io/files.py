"""Results as labeled arrays: units on every quantity, and what made them."""

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

__all__ = ["columns_csv", "dataset", "rows_csv", "shipped", "version", "write_atomically", "write_netcdf"]


@functools.cache
def version() -> str:
    """Return the version of hypertuna.

    Returns
    -------
    str
    """
    from importlib.metadata import version  # slow to import

    return version("hypertuna")


def dataset(variables: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]) -> xr.Dataset:
    """Make a labeled dataset; what labels it is imported only now, because that takes longer than a swim.

    Parameters
    ----------
    variables, coordinates, attributes : mapping
        As `xarray.Dataset` takes them.

    Returns
    -------
    xarray.Dataset
    """
    import xarray as xr

    return xr.Dataset(variables, coordinates, attributes)


def columns_csv(facts: Mapping[str, Any], columns: Mapping[str, Iterable[float]], *, digits: int = 6) -> str:
    """Write columns as comma-separated values, below comments that say what made them.

    Parameters
    ----------
    facts : mapping of str
    columns : mapping of str to iterable of float
        By their heads, all of one length; a value that is not a number leaves its cell empty.
    digits : int
        Of every number.

    Returns
    -------
    str
    """
    cells = ([f"{value + 0.0:.{digits}g}" if value == value else "" for value in column] for column in columns.values())
    rows = zip(*cells, strict=True)
    return _csv(facts, [list(columns), *rows])


def rows_csv(facts: Mapping[str, Any], rows: Iterable[Mapping[str, Any]]) -> str:
    """Write rows as comma-separated values, numbers in full, below comments that say what made them.

    Parameters
    ----------
    facts : mapping of str
    rows : iterable of mapping of str
        All of the same keys, which become the head.

    Returns
    -------
    str
    """
    rows = list(rows)
    return _csv(facts, [list(row) for row in rows[:1]] + [list(row.values()) for row in rows])


def _csv(facts: Mapping[str, Any], rows: Iterable[Iterable[Any]]) -> str:
    """Write comments and rows; what holds a comma is quoted."""
    text = io.StringIO()
    text.writelines("# " + f"{key}: {value}".replace("\n", " ") + "\n" for key, value in facts.items())
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def write_atomically(path: str | Path, content: bytes) -> Path:
    """Write a file whole or not at all: under a temporary name beside it, then renamed.

    Parameters
    ----------
    path : str or Path
    content : bytes

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
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
    """Write a dataset as NetCDF, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset or xarray.DataTree
        A tree becomes groups of one file.
    path : str or Path

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "result.nc"
        dataset.to_netcdf(whole, engine="h5netcdf")
        return write_atomically(path, whole.read_bytes())


def _unwritable(path: Path, error: OSError) -> InputError:
    fix = "choose a path that can be written"
    return InputError("must be a writable file", file=str(path), value=f"not ({error.strerror})", fix=fix)


def shipped(name: str) -> Path:
    """Return the folder of files that ship with the package: ``"robots"``, ``"missions"``, ``"data/published"``, ..."""
    package = Path(__file__).parents[1]  # in a wheel; in a source tree the folders stand at its root
    root = package.parents[1]
    return next(path for base in (package, root, root / "firmware") if (path := base / name).is_dir())
