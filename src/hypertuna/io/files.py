"""Files: CSV and NetCDF with provenance, written whole or not at all; the files that ship with the package."""

from __future__ import annotations

import contextlib
import csv
import errno
import functools
import io
import json
import os
import re
import tempfile
import tomllib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from hypertuna.errors import InputError
from hypertuna.io.quantity import suffix

if TYPE_CHECKING:
    import xarray as xr


class Closing(ABC):
    """A context manager that calls `close` at its end."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def close(self) -> None:
        """Release what the context holds, such as a file."""


@functools.cache
def version() -> str:
    """Return the version of hypertuna."""
    from importlib.metadata import version  # slow to import

    return version("hypertuna")


def dataset(variables: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]) -> xr.Dataset:
    """Return a labeled dataset; variables and coordinates are (dims, values), or (dims, values, unit, meaning)."""
    import xarray as xr  # slow to import

    def labeled(part: Any) -> Any:
        described = isinstance(part, tuple) and len(part) == 4
        return (*part[:2], {"units": part[2], "long_name": part[3]}) if described else part

    coords = {name: labeled(part) for name, part in coordinates.items()}
    return xr.Dataset({name: labeled(part) for name, part in variables.items()}, coords, attributes)


class Csv(NamedTuple):
    """A CSV file: a line of names, and rows; its provenance `facts` goes into a JSON file beside it."""

    text: str
    facts: Mapping[str, Any]

    def write(self, path: str | Path) -> None:
        """Write NAME.csv and, if there are facts, NAME.csv.json: both whole, or neither."""
        with contextlib.ExitStack() as files:  # neither takes its place before both are on the disk
            files.enter_context(replaced(path)).write_bytes(self.text.encode())
            if self.facts:
                facts = json.dumps(self.facts, indent=2, ensure_ascii=False, default=lambda value: value.tolist())
                files.enter_context(replaced(f"{path}.json")).write_bytes(f"{facts}\n".encode())


def columns_csv(facts: Mapping[str, Any], columns: Mapping[str, Iterable[Any]], *, digits: int | None = 6) -> Csv:
    """Return columns as a CSV file with their provenance.

    Numbers have `digits` significant digits, and NaN an empty cell; text, and without `digits` all cells, are in full.
    """

    def cell(value: Any) -> str:
        if digits is None or isinstance(value, str):
            return f"{value}"
        return f"{value + 0.0:.{digits}g}" if value == value else ""

    cells = ([cell(value) for value in column] for column in columns.values())
    return _csv(facts, [list(columns), *zip(*cells, strict=True)])


def variable_columns(data: xr.Dataset, names: Mapping[str, str] | Iterable[str]) -> dict[str, Any]:
    """Return variables and coordinates as columns NAME_LABEL_unit: angles in degrees, pressures in kPa, codes in words.

    A dimension with labels (joints, sides) stands in the names of columns, every combination of the others is a row.
    `names` may map variables to the names of their columns, which may end in the unit. The attribute ``key`` of a
    number of a robot's file is the name of its column.
    """
    import numpy as np  # imported here: `hypertuna version` does not need it

    names = names if isinstance(names, Mapping) else {name: name for name in names}
    labels = {dim: data[dim].values for dim in data.dims if dim in data.coords and data[dim].dtype.kind in "UO"}
    rows = {dim: size for dim, size in data.sizes.items() if dim not in labels}
    columns: dict[str, Any] = {}
    for name, head in names.items():
        variable, labeled = data[name], [dim for dim in data[name].dims if dim in labels]
        if not all(labels[dim].size for dim in labeled):
            continue
        unit, values = _unit_and_values(variable)
        full = variable.copy(data=values).expand_dims({dim: n for dim, n in rows.items() if dim not in variable.dims})
        table = full.transpose(*labeled, *rows).values.reshape(*(len(labels[dim]) for dim in labeled), -1)
        if "key" in variable.attrs:
            columns[variable.attrs["key"]] = table
            continue
        for index in np.ndindex(*table.shape[:-1]):
            parts = [head, *(labels[dim][k] for dim, k in zip(labeled, index, strict=True))]
            column = "_".join(str(part).replace("-", "_") for part in parts)
            columns[f"{column}{unit}" if not column.endswith(unit) else column] = table[index]
    return columns


def data_columns(data: xr.Dataset) -> dict[str, Any]:
    """Return all coordinates and variables of a dataset as columns, as `variable_columns` does."""
    return variable_columns(data, [*coordinate_names(data), *(str(name) for name in data.data_vars)])


def coordinate_names(data: xr.Dataset) -> list[str]:
    """Return the names of the numeric coordinates, without those that only repeat another (attribute `same_as`)."""
    coordinates = data.coords.items()
    return [str(name) for name, c in coordinates if c.dtype.kind not in "UO" and "same_as" not in c.attrs]


def _unit_and_values(variable: xr.DataArray) -> tuple[str, Any]:
    """Return the unit's suffix for a column's name, and the values in that unit; coordinates in degrees are rounded."""
    import numpy as np

    values, unit = variable.values, variable.attrs.get("units", "1")
    if "flag_values" in variable.attrs:
        return "", np.array(variable.attrs["flag_meanings"].split())[values]
    if unit == "rad":
        return "_deg", np.degrees(values).round(10) if variable.name in variable.coords else np.degrees(values)
    if unit == "Pa":
        return "_kpa", values / 1e3
    return suffix(unit), values


def rows_csv(facts: Mapping[str, Any], rows: Iterable[Mapping[str, Any]]) -> Csv:
    """Return rows as a CSV file, numbers in full, with their provenance; the first row's keys are the head."""
    rows = list(rows)
    return _csv(facts, [list(row) for row in rows[:1]] + [list(row.values()) for row in rows])


def _csv(facts: Mapping[str, Any], rows: Iterable[Iterable[Any]]) -> Csv:
    """Return rows as a CSV file."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return Csv(text.getvalue(), facts)


def check_replaceable(path: str | Path) -> None:
    """Check that a path is free or a regular file, so that a new file replaces no device or pipe."""
    if os.path.exists(path) and not os.path.isfile(path):
        value = "a folder" if os.path.isdir(path) else "a pipe or a device"
        raise InputError("must be a file", file=str(path), value=value, fix="choose another path")


@contextlib.contextmanager
def replaced(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path; the file that is written there then replaces `path`, whole or not at all."""
    path = Path(path)
    try:
        check_replaceable(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise unwritable(path, error) from None
    try:
        os.close(handle)
        yield Path(name)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(name, 0o666 & ~umask)
        os.replace(name, path)
    except BaseException as error:
        Path(name).unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise unwritable(path, error) from None
        raise


@contextlib.contextmanager
def scratch() -> Iterator[Path]:
    """Yield a temporary folder; where it cannot be written, the error names it."""
    try:
        folder = tempfile.TemporaryDirectory()
    except OSError as error:
        raise _no_room(os.environ.get("TMPDIR", "the temporary folder"), error) from None
    with folder as name:
        try:
            yield Path(name)
        except OSError as error:
            if error.errno not in FULL:
                raise
            raise _no_room(str(Path(name).parent), error) from None


def _no_room(folder: str, error: OSError) -> InputError:
    """Return the error of a temporary folder that cannot be written."""
    value, fix = f"not ({error.strerror or error})", "make room there, or set TMPDIR to another folder"
    return InputError("must be a folder that can be written", file=folder, value=value, fix=fix)


def write_atomically(path: str | Path, content: bytes) -> Path:
    """Write a file whole or not at all."""
    with replaced(path) as file:
        file.write_bytes(content)
    return Path(path)


FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # error codes of a full disk, quota or file
CONVENTIONS = "CF-1.11"  # version of the CF conventions, in NetCDF files
CF_UNITS = {"deg": "degree", "Wh": "W h"}  # unit -> its name in UDUNITS
# New names of coordinates: CF's own `time` is a date, its `pressure` that of the air.
CF_NAMES = {"time": "elapsed_time", "pressure": "gauge_pressure"}


def write_netcdf(dataset: xr.Dataset | xr.DataTree, path: str | Path) -> Path:
    """Write a dataset, or a tree as groups, as NetCDF by the CF conventions, whole or not at all."""
    tree: Any = dataset
    data: Any = tree.map_over_datasets(by_conventions) if hasattr(dataset, "groups") else by_conventions(tree)
    content = io.BytesIO()  # in memory, since HDF5 ends the program if the disk is full
    data.to_netcdf(content, engine="h5netcdf")
    return write_atomically(path, content.getvalue())


def by_conventions(data: xr.Dataset) -> xr.Dataset:
    """Return a dataset as the CF conventions want it in a file.

    CF's `time` is a date and its `pressure` that of the air; its axes are numbers, so that labels along `joint` are
    `joint_name`.
    """
    import numpy as np  # imported here: `hypertuna version` does not need it

    labels = {name: f"{name}_name" for name in data.indexes if data[name].dtype.kind in "UO"}
    names = {name: re.sub(r"\W", "_", str(name)) for name in data.variables}
    names |= {name: new for name, new in CF_NAMES.items() if name in data.indexes}
    data = data.rename({name: new for name, new in names.items() if name != new}).rename_vars(labels)
    for name, variable in data.variables.items():
        flags = {key: value for key, value in variable.attrs.items() if key in ("flag_values", "flag_masks")}
        units = {key: CF_UNITS.get(unit, unit) for key, unit in variable.attrs.items() if key == "units"}
        variable.attrs |= units | {key: np.asarray(value, variable.dtype) for key, value in flags.items()}
        if name in data.coords:
            variable.encoding["_FillValue"] = None
    made_by, robot = f"hypertuna {version()}", data.attrs.get("robot", "")
    title = f"Robot {robot}, computed by {made_by}" if robot else f"Computed by {made_by}"
    history = f"{made_by}: {data.attrs.get('command', 'in Python')}"
    return data.assign_attrs({"Conventions": CONVENTIONS, "title": title, "history": history})


def unwritable(path: object, error: OSError) -> InputError:
    """Return the error of a file that cannot be written."""
    value, fix = f"not ({error.strerror or error})", "choose a path that can be written"
    return InputError("must be a writable file", file=str(path), value=value, fix=fix)


def shipped(name: str) -> Path:
    """Return the folder of files that ship with the package: ``"robots"``, ``"missions"``, ``"data/published"``, ..."""
    package = Path(__file__).parents[1]  # of a wheel; in a source tree, the folders are at its root
    root = package.parents[1]
    return next(path for base in (package, root, root / "firmware") if (path := base / name).is_dir())


@functools.cache
def published(name: str = "published") -> dict[str, Any]:
    """Read a file of data/published: "published" for the paper's numbers, "others" for other fish and robots."""
    return tomllib.loads((shipped("data/published") / f"{name}.toml").read_text(encoding="utf-8"))


@functools.cache
def verdicts() -> dict[str, Any]:
    """Read the stored verdicts of the ledger on the paper's numbers, with what made them."""
    record: dict[str, Any] = json.loads((shipped("data/published") / "verdicts.json").read_text(encoding="utf-8"))
    return record
