"""Measured joint angles and tracked poses of a robot, read from CSV files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import check_width, read_rows

ANGLES = {"rad": 1.0, "deg": math.pi / 180}  # in rad
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}  # in m
MIN_SAMPLES = 12  # of a series, for the estimate of its noise
MAX_GAP = 5  # median intervals between two samples


@dataclass(frozen=True)
class JointSeries:
    """Measured angles of the joint groups over time.

    At least 12 samples, all finite, time increasing, without gaps longer than 5 median intervals; else InputError.
    """

    time: Array  # (samples,) [s]
    angle: Array  # (samples, groups) [rad], bend of each joint group, counter-clockwise
    file: str | None = None  # file of the series, for errors
    lines: Sequence[int] | None = None  # line of each sample in the file
    columns: Sequence[str] | None = None  # names of time and angles in the file

    def __post_init__(self) -> None:
        time, angle = np.asarray(self.time, dtype=float), np.asarray(self.angle, dtype=float)
        if time.ndim != 1 or angle.ndim != 2 or len(angle) != len(time) or not angle.size:
            shapes = f"of shapes {time.shape} and {angle.shape}"
            fix = "give one row of angles per time, one column per joint group"
            raise InputError("must have shapes (K,) and (K, groups)", key="time and angle", value=shapes, fix=fix)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "angle", angle)
        self._check()

    def _check(self) -> None:
        """Check the values."""
        samples = len(self.time)
        if samples < MIN_SAMPLES:
            rule, fix = f"must have at least {MIN_SAMPLES} samples", "record a longer series"
            raise InputError(rule, file=self.file, key="the series", value=f"{samples} long", fix=fix)
        values = np.column_stack([self.time, self.angle])
        for k, column in np.argwhere(~np.isfinite(values))[:1]:
            fix = "give a number, or leave out the sample"
            raise self._error(k, column, "must be a finite number", f"{values[k, column]}", fix)
        interval = np.diff(self.time)
        for k in np.flatnonzero(interval <= 0)[:1] + 1:
            rule = f"must be later than the sample before, at {self.time[k - 1]:g} s"
            raise self._error(k, 0, rule, f"{self.time[k]:g} s", "sort the samples by time, each time once")
        limit = MAX_GAP * float(np.median(interval))
        for k in np.flatnonzero(interval > limit)[:1] + 1:
            rule = f"must follow the sample before within {MAX_GAP} median intervals ({limit:.3g} s)"
            gap = f"{interval[k - 1]:.3g} s later"
            raise self._error(k, 0, rule, gap, "cut the series at the gap and replay the parts separately")

    def _error(self, sample: int, column: int, rule: str, value: str, fix: str) -> InputError:
        """Return the error of a value, with its line and column."""
        names = self.columns or ("time", *(f"angle[{g}]" for g in range(self.angle.shape[1])))
        where = f"sample {sample}" if self.lines is None else f"line {self.lines[sample]}"
        return InputError(rule, file=self.file, key=f"{where}, {names[column]}", value=value, fix=fix)


@dataclass(frozen=True)
class Track:
    """A tracked run: poses of the center of the head link."""

    run: str  # its name
    time: Array  # (frames,) [s]
    pose: Array  # (frames, 3): x, y [m] and the direction that the head faces [rad], counter-clockwise from x


def read_joints(path: str | Path, *, time: str, columns: Sequence[str], unit: str) -> JointSeries:
    """Read measured joint angles from a CSV file; empty lines and comments (#) are skipped.

    Parameters
    ----------
    path : str or Path
    time : str
        Name of the column of time [s].
    columns : sequence of str, shape (groups,)
        Names of the columns of angles, one per joint group from head to tail.
    unit : {"deg", "rad"}
        Unit of the angles in the file.

    Returns
    -------
    JointSeries

    Raises
    ------
    InputError
        If the file or a column is missing, or a value is not a number or not valid in a `JointSeries`.
    """
    if not columns:
        raise InputError("must name at least one column", key="columns", fix="name one column per joint group")
    table = _read_table(path, [time, *columns])
    values = np.column_stack([table.numbers(name) for name in (time, *columns)])
    scale = _factor(ANGLES, unit, "unit")
    return JointSeries(values[:, 0], values[:, 1:] * scale, str(path), table.lines, (time, *columns))


def read_tracks(
    path: str | Path,
    *,
    time: str,
    pose: Sequence[str],
    run: str | None = None,
    length_unit: str,
    angle_unit: str,
    yaw_zero: float = 0.0,
    clockwise: bool = False,
) -> tuple[Track, ...]:
    """Read tracked poses of the head link's center from a CSV file of one run or several.

    Parameters
    ----------
    path : str or Path
    time : str
        Name of the column of time [s].
    pose : sequence of str, shape (3,)
        Names of the columns of x, y and yaw, the direction that the head faces.
    run : str, optional
        Name of the column of run names; default: the file is one run.
    length_unit : {"m", "cm", "mm"}
        Unit of x and y in the file.
    angle_unit : {"deg", "rad"}
        Unit of yaw in the file.
    yaw_zero : float
        Direction of yaw 0 [rad], counter-clockwise from x.
    clockwise : bool
        Whether yaw is positive clockwise: from y to x.

    Returns
    -------
    tuple of Track
        In the order of the file; yaw without jumps by whole turns.

    Raises
    ------
    InputError
        If the file or a column is missing, a value is not a finite number, or time goes back within a run.
    """
    if len(pose) != 3:
        fix = "name the columns of x, y and yaw"
        raise InputError("must be 3 names", key="pose", value=f"{len(pose)}", fix=fix)
    table = _read_table(path, [time, *pose, *([run] if run else [])])
    values = np.column_stack([table.numbers(name) for name in (time, *pose)])
    values[:, 1:3] *= _factor(LENGTHS, length_unit, "length_unit")
    yaw = _factor(ANGLES, angle_unit, "angle_unit") * values[:, 3]
    values[:, 3] = yaw_zero + (-yaw if clockwise else yaw)
    rows: dict[str, list[int]] = {}
    for k, name in enumerate(table.cells[run] if run else [Path(path).stem] * len(values)):
        if not name:
            key, fix = f"line {table.lines[k]}, {run}", "give the run's name, or leave out the line"
            raise InputError("must not be empty", file=table.file, key=key, fix=fix)
        rows.setdefault(name, []).append(k)
    return tuple(_track(table, time, name, members, values[members]) for name, members in rows.items())


@dataclass(frozen=True)
class _Table:
    """Columns of a CSV file as text, and the line of each row."""

    file: str
    lines: list[int]
    cells: Mapping[str, list[str]]

    def numbers(self, column: str) -> Array:
        """Return a column as finite numbers."""
        values = np.empty(len(self.lines))
        for k, cell in enumerate(self.cells[column]):
            try:
                values[k] = float(cell)
            except ValueError:
                values[k] = np.nan
            if not math.isfinite(values[k]):
                key, fix = f"line {self.lines[k]}, {column}", "give a number, or leave out the line"
                raise InputError("must be a finite number", file=self.file, key=key, value=shown(cell), fix=fix)
        return values


def _read_table(path: str | Path, columns: Sequence[str]) -> _Table:
    """Read the named columns of a CSV file."""
    file = str(path)
    (_, head), *rows = read_rows(path)
    for name in columns:
        if name not in head:
            fix = did_you_mean(name, [other for other in head if other not in columns])
            raise InputError("must be a column of the file", file=file, key=f"column {name}", value="missing", fix=fix)
    for line, row in rows:
        check_width(row, head, file=file, line=line)
    cells = {name: [row[head.index(name)] for _, row in rows] for name in columns}
    return _Table(file, [line for line, _ in rows], cells)


def _track(table: _Table, time: str, run: str, members: Sequence[int], values: Array) -> Track:
    """Return the run of its rows."""
    for k in np.flatnonzero(np.diff(values[:, 0]) <= 0)[:1] + 1:
        rule = f"must be later than the frame before, at {values[k - 1, 0]:g} s"
        key, value = f"line {table.lines[members[k]]}, {time}", f"{values[k, 0]:g} s"
        fix = "sort the frames of each run by time, or name the column of the run"
        raise InputError(rule, file=table.file, key=key, value=value, fix=fix)
    return Track(run, values[:, 0], np.column_stack([values[:, 1:3], np.unwrap(values[:, 3])]))


def _factor(units: Mapping[str, float], unit: str, key: str) -> float:
    """Return a unit in SI units."""
    if unit not in units:
        raise InputError("must be a known unit", key=key, value=shown(unit), fix=did_you_mean(unit, units))
    return units[unit]
