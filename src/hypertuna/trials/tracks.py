"""Measured joint angles and tracked poses of a robot, read from CSV files."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import CELL, check_name

ANGLES = {"rad": 1.0, "deg": math.pi / 180}  # units of angles [rad]
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}  # units of lengths [m]
MIN_SAMPLES = 12  # least number of samples of a series, needed to estimate its noise
MAX_GAP = 5  # longest time between two samples, in median intervals
MAX_LAG, LAGS = 0.1, 401  # largest lag, as a fraction of the series' duration; number of lags tried


@dataclass(frozen=True)
class JointSeries(Plotted, Tabular, data=lambda series: series_columns(series.time, angle=series.angle)):
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
        if (samples := len(time)) < MIN_SAMPLES:
            rule, fix = f"must have at least {MIN_SAMPLES} samples", "record a longer series"
            raise InputError(rule, file=self.file, key="the series", value=f"{samples} long", fix=fix)
        values = np.column_stack([time, angle])
        for k, column in np.argwhere(~np.isfinite(values))[:1]:
            fix = "give a number, or leave out the sample"
            raise self._error(k, column, "must be a finite number", f"{values[k, column]}", fix)
        interval = np.diff(time)
        for k in np.flatnonzero(interval <= 0)[:1] + 1:
            rule = f"must be later than the previous sample, at {time[k - 1]:g} s"
            raise self._error(k, 0, rule, f"{time[k]:g} s", "sort the samples by time, without repeats")
        limit = MAX_GAP * float(np.median(interval))
        for k in np.flatnonzero(interval > limit)[:1] + 1:
            rule = f"must follow the previous sample within {MAX_GAP} median intervals ({limit:.3g} s)"
            gap = f"{interval[k - 1]:.3g} s later"
            raise self._error(k, 0, rule, gap, "cut the series at the gap and replay the parts separately")

    def _error(self, sample: int, column: int, rule: str, value: str, fix: str) -> InputError:
        """Return the error for a sample's value, with its line and column."""
        names = self.columns or ("time", *(f"angle[{g}]" for g in range(self.angle.shape[1])))
        where = f"sample {sample}" if self.lines is None else f"line {self.lines[sample]}"
        return InputError(rule, file=self.file, key=f"{where}, {names[column]}", value=value, fix=fix)


@dataclass(frozen=True)
class Track(
    Plotted,
    Tabular,
    data=lambda track: {
        "time_s": track.time,
        "x_m": track.pose[:, 0],
        "y_m": track.pose[:, 1],
        "yaw_deg": np.degrees(track.pose[:, 2]),
    },
):
    """A tracked run: poses of the center of the head link."""

    run: str  # name of the run
    time: Array  # (frames,) [s]
    pose: Array  # (frames, 3): x, y [m] and the direction that the head faces [rad], counter-clockwise from x


def series_columns(time: Array, **values: Array) -> dict[str, Array]:
    """Return columns of time (times,) [s] and of joint groups' angles (times, groups) [rad], converted to degrees."""
    columns = {"time_s": time}
    for name, table in values.items():
        for g, column in enumerate(np.degrees(table).T):
            columns[f"{name}_{g + 1}_deg" + "_s" * (name == "rate")] = column
    return columns


@checked
def read_joints(path: str | Path, *, time: str, columns: Sequence[str], unit: str) -> JointSeries:
    """Read measured joint angles from a CSV file; empty lines and comments (#) are skipped.

    Parameters
    ----------
    path : str or Path
    time : str
        Column of time [s].
    columns : sequence of str, shape (groups,)
        Columns of angles, one per joint group from head to tail.
    unit : {"deg", "rad"}
        Unit of the angles in the file.

    Returns
    -------
    JointSeries
    """
    if not columns:
        raise InputError("must name at least one column", key="columns", fix="name one column per joint group")
    lines, values, _ = _read_columns(path, [time, *columns])
    check_name(unit, ANGLES, "unit", "unit")
    return JointSeries(values[:, 0], values[:, 1:] * ANGLES[unit], str(path), lines, (time, *columns))


def lag_of(measured: JointSeries, targets: JointSeries) -> tuple[float, ...]:
    """Return how much each measured angle lags behind its target [s]: the shift with the largest correlation."""
    time = measured.time
    limit = MAX_LAG * float(time[-1] - time[0])
    inside = (time >= time[0] + limit) & (time <= time[-1] - limit)
    shifts = np.linspace(-limit, limit, LAGS)
    lags = []
    for angle, target in zip(measured.angle.T, targets.angle.T, strict=True):
        shifted = np.array([np.interp(time[inside] - shift, time, target) for shift in shifts])
        shifted, centered = shifted - shifted.mean(axis=1, keepdims=True), angle[inside] - angle[inside].mean()
        size = np.linalg.norm(shifted, axis=1) * np.linalg.norm(centered)
        correlation = np.divide(shifted @ centered, size, out=np.zeros(LAGS), where=size > 0)
        lags.append(float(shifts[np.argmax(correlation)]) if correlation.any() else 0.0)
    return tuple(lags)


@checked
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
    time, run : str
        Columns of time [s] and, if the file is not one run, of the names of runs.
    pose : sequence of str, shape (3,)
        Columns of x, y and yaw, the direction that the head faces.
    length_unit, angle_unit : str
        Units in the file: "m", "cm" or "mm"; "deg" or "rad".
    yaw_zero : float
        Direction of yaw 0 [rad], counter-clockwise from x.
    clockwise : bool
        Whether yaw is positive clockwise: from y to x.

    Returns
    -------
    tuple of Track
        In the order of the file; yaw without jumps by whole turns.
    """
    if len(pose) != 3:
        raise InputError("must be 3 names", key="pose", value=f"{len(pose)}", fix="name the columns of x, y and yaw")
    lines, values, names = _read_columns(path, [time, *pose], run)
    check_name(length_unit, LENGTHS, "length_unit", "unit")
    check_name(angle_unit, ANGLES, "angle_unit", "unit")
    values[:, 1:3] *= LENGTHS[length_unit]
    yaw = ANGLES[angle_unit] * values[:, 3]
    values[:, 3] = yaw_zero + (-yaw if clockwise else yaw)
    rows: dict[str, list[int]] = {}
    for k, name in enumerate(names):
        if not name:
            key, fix = f"line {lines[k]}, {run}", "give the run's name, or leave out the line"
            raise InputError("must not be empty", file=str(path), key=key, fix=fix)
        rows.setdefault(name, []).append(k)
    tracks = []
    for name, indices in rows.items():
        clock, x, y, angle = values[indices].T
        for k in np.flatnonzero(np.diff(clock) <= 0)[:1] + 1:
            rule = f"must be later than the previous frame, at {clock[k - 1]:g} s"
            key, value = f"line {lines[indices[k]]}, {time}", f"{clock[k]:g} s"
            fix = "sort the frames of each run by time, or name the column of the run"
            raise InputError(rule, file=str(path), key=key, value=value, fix=fix)
        tracks.append(Track(name, clock, np.column_stack([x, y, np.unwrap(angle)])))
    return tuple(tracks)


def _read_columns(
    path: str | Path, columns: Sequence[str], run: str | None = None
) -> tuple[list[int], Array, list[str]]:
    """Return lines, numbers (rows, columns) and names of runs (default: the file's name) of a CSV file's rows."""
    table = read_table(path)
    for name in [*columns, *([run] if run else [])]:
        if name not in table.head:
            key, fix = f"column {name}", did_you_mean(name, [other for other in table.head if other not in columns])
            raise InputError("must be a column of the file", file=table.file, key=key, value="missing", fix=fix)
    table.check_once([*columns, *([run] if run else [])])

    def numbers(_: int, cells: dict[str, str]) -> list[float]:
        values = [parse_float(cells[name]) for name in columns]
        for name, value in zip(columns, values, strict=True):
            fix = "give a number, or leave out the line"
            if not math.isfinite(value):
                raise InputError("must be a finite number", key=name, value=shown(cells[name]), fix=fix)
            CELL.check(value, name, fix)
        return values

    values = np.array(table.parse(numbers))
    names = [row[table.head.index(run)] for _, row in table.rows] if run else [Path(path).stem] * len(values)
    return [line for line, _ in table.rows], values, names
