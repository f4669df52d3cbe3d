"""Bench runs: measured bends of joints under pressure, read from CSV files and logs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import check_width, read_rows
from hypertuna.trials.radio_log import bench_rows

BRANCHES = ("load", "unload")
COLUMNS = ("joint", "side", "pressure_kpa", "angle_deg", "branch", "angle_sd_deg", "volume_ml", "run")
REQUIRED = COLUMNS[:4]
MAX_PRESSURE = 2e6  # Pa, ten times that of soft actuators: higher values have another unit
MAX_ANGLE = math.pi
SMALL_ANGLES = math.radians(1.0)  # if all bends are smaller, their unit is likely rad


@dataclass(frozen=True)
class Loop:
    """Rows of a bench that share one loading from rest: same joint, side and maximum pressure."""

    joint: int
    side: int  # 0 for left, 1 for right
    top: float  # maximum pressure, where unloading starts [Pa]
    rows: NDArray[np.int64]  # (rows,), indices into the arrays of the bench


@dataclass(frozen=True)
class Bench:
    """Measured bends; every array has one entry per row of the files."""

    joint: NDArray[np.int64]  # joint group, from 0
    side: NDArray[np.int64]  # side under pressure: 0 for left, 1 for right
    pressure: Array  # gauge pressure of that side [Pa]; that of the other side is 0
    angle: Array  # bend [rad], positive toward the passive side
    unload: NDArray[np.bool_]  # whether pressure was falling
    angle_sd: Array  # standard deviation of the angle [rad], NaN if unknown
    volume: Array  # oil pumped into that side since rest [m^3], NaN if not measured
    loops: tuple[Loop, ...]  # each row is in one
    files: tuple[str, ...]  # file and line of each row
    lines: tuple[int, ...]
    warnings: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[int, ...]:
        """Measured joint groups."""
        return tuple(int(j) for j in np.unique(self.joint))

    def sides(self, joint: int) -> tuple[int, ...]:
        """Sides of a joint that were under pressure."""
        return tuple(int(s) for s in np.unique(self.side[self.joint == joint]))


@dataclass(frozen=True)
class _Row:
    """One row of a file, in SI units."""

    joint: int
    side: int
    pressure: float
    angle: float
    unload: bool
    angle_sd: float
    volume: float
    run: str
    file: str
    line: int


def read_bench(paths: str | Path | Sequence[str | Path], robot: Robot) -> Bench:
    """Read bench runs from CSV files and logs of the radio; docs/bench.md lists the columns."""
    files = [paths] if isinstance(paths, (str, Path)) else list(paths)
    if not files:
        raise InputError("must name at least one file", key="bench", fix="give a CSV file of pressures and angles")
    rows = [row for path in files for row in _read(path, robot)]
    loops: dict[tuple[int, int, float], list[int]] = {}
    tops: dict[tuple[str, str, int, int], float] = {}
    for row in rows:
        key = (row.file, row.run, row.joint, row.side)
        tops[key] = max(tops.get(key, 0.0), row.pressure)
    for k, row in enumerate(rows):
        loops.setdefault((row.joint, row.side, tops[row.file, row.run, row.joint, row.side]), []).append(k)
    columns = ("joint", "side", "pressure", "angle", "unload", "angle_sd", "volume")
    bench = Bench(
        **{name: np.array([getattr(row, name) for row in rows]) for name in columns},
        loops=tuple(Loop(*key, np.array(members)) for key, members in loops.items()),
        files=tuple(row.file for row in rows),
        lines=tuple(row.line for row in rows),
        warnings=_warnings(rows),
    )
    _check_direction(bench, robot)
    return bench


def _read(path: str | Path, robot: Robot) -> list[_Row]:
    """Read one file: CSV, or a radio log."""
    file = str(path)
    if Path(path).suffix.lower() == ".mcap":
        return [
            _Row(joint, side, pressure, angle, unload, math.nan, math.nan, run, file, k + 1)
            for k, (joint, side, pressure, angle, unload, run) in enumerate(bench_rows(path, robot))
        ]
    (line, head), *rows = read_rows(path)
    for k, column in enumerate(head):
        if column not in COLUMNS:
            fix = did_you_mean(column, [name for name in COLUMNS if name not in head])
            raise InputError("is not a known column", file=file, key=f"line {line}, {column}", fix=fix)
        if column in head[:k]:
            raise InputError(
                "must appear only once", file=file, key=f"line {line}, {column}", fix="remove one of the two"
            )
    for column in REQUIRED:
        if column not in head:
            fix = f"add it; columns are {', '.join(COLUMNS)}"
            raise InputError("must be a column", file=file, key=column, value="missing", fix=fix)
    read = []
    for line, row in rows:
        check_width(row, head, file=file, line=line)
        try:
            read.append(_row(dict(zip(head, row, strict=True)), robot, file, line))
        except InputError as error:
            key = f"line {line}, {error.key}"
            raise InputError(error.rule, file=file, key=key, value=error.value, fix=error.fix) from None
    return read


def _row(cells: Mapping[str, str], robot: Robot, file: str, line: int) -> _Row:
    """Return the row of its cells; errors name the column."""
    pressure = 1e3 * _number(cells, "pressure_kpa", "kPa")
    angle = math.radians(_number(cells, "angle_deg", "deg"))
    sd = math.radians(_number(cells, "angle_sd_deg", "deg", optional=True))
    volume = 1e-6 * _number(cells, "volume_ml", "ml", optional=True)
    if pressure < 0:
        fix = "give the gauge pressure of the side that bends the joint"
        raise InputError("must not be negative", key="pressure_kpa", value=cells["pressure_kpa"], fix=fix)
    if pressure > MAX_PRESSURE:
        fix = "give it in kPa"
        rule = f"must be at most {MAX_PRESSURE / 1e3:g}"
        raise InputError(rule, key="pressure_kpa", value=cells["pressure_kpa"], fix=fix)
    if abs(angle) > MAX_ANGLE:
        raise InputError("must be at most 180", key="angle_deg", value=cells["angle_deg"], fix="give it in deg")
    if sd <= 0:
        fix = "give the standard deviation of the angle, or leave the cell empty"
        raise InputError("must be greater than 0", key="angle_sd_deg", value=cells["angle_sd_deg"], fix=fix)
    return _Row(
        joint=joint_index(cells["joint"], robot),
        side=_choice(cells["side"], "side", SIDES),
        pressure=pressure,
        angle=angle,
        unload=_choice(cells.get("branch") or "load", "branch", BRANCHES) == 1,
        angle_sd=sd,
        volume=volume,
        run=cells.get("run", ""),
        file=file,
        line=line,
    )


def joint_index(text: str, robot: Robot) -> int:
    """Return the index of a joint group, given its name or its number from 1, counted from the head."""
    names = [group.name for group in robot.joints]
    if text in names:
        return names.index(text)
    if text.isdecimal() and 1 <= int(text) <= len(names):
        return int(text) - 1
    fix = did_you_mean(text, names) if text else f"give one of {', '.join(names)}"
    raise InputError(f"must be a joint of {robot.name}", key="joint", value=shown(text), fix=fix)


def _choice(text: str, key: str, known: Sequence[str]) -> int:
    """Return the index of a word in a list."""
    if text.lower() not in known:
        fix = did_you_mean(text.lower(), known)
        raise InputError(f"must be {' or '.join(known)}", key=key, value=shown(text), fix=fix)
    return known.index(text.lower())


def _number(cells: Mapping[str, str], key: str, unit: str, *, optional: bool = False) -> float:
    """Return a finite number; NaN for an empty optional cell."""
    text = cells.get(key, "")
    if optional and not text:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        fix = f"give it in {unit}, or remove the line"
        raise InputError("must be a finite number", key=key, value=shown(text) if text else "empty", fix=fix)
    return value


def _check_direction(bench: Bench, robot: Robot) -> None:
    """Check that bends are positive toward the passive side, on the right side too."""
    for loop in bench.loops:
        high = loop.rows[bench.pressure[loop.rows] > loop.top / 2]
        if len(high) and np.median(bench.angle[high]) < 0:
            k = int(high[np.argmin(bench.angle[high])])
            rule = f"must be positive for the {SIDES[loop.side]} side of joint {robot.joints[loop.joint].name}, too"
            value, fix = f"{math.degrees(bench.angle[k]):g}", "count every bend from straight, away from the pressure"
            raise InputError(rule, file=bench.files[k], key=f"line {bench.lines[k]}, angle_deg", value=value, fix=fix)


def _warnings(rows: Sequence[_Row]) -> tuple[str, ...]:
    """Return a warning if the angles are likely in radians."""
    largest = max(abs(row.angle) for row in rows)
    if largest < SMALL_ANGLES and any(row.pressure > 0 for row in rows):
        return (
            f"All angles are below 1 deg, the largest is {math.degrees(largest):.3g} deg: if they were measured in "
            "radians, write them in degrees.",
        )
    return ()
