"""Bench runs: how far a joint bends under pressure, as a test bench measured it, read from CSV files and logs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.bending import SIDES
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import check_width, read_rows
from hypertuna.trials.radio_log import bench_rows

__all__ = ["COLUMNS", "HIGHEST_PRESSURE", "Bench", "Loop", "joint_index", "read_bench"]

Array = NDArray[np.float64]

BRANCHES = ("load", "unload")
COLUMNS = ("joint", "side", "pressure_kpa", "angle_deg", "branch", "angle_sd_deg", "volume_ml", "run")
NEEDED = COLUMNS[:4]
HIGHEST_PRESSURE = 2e6  # Pa: ten times what soft actuators are made for; what is above was written in another unit
LARGEST_ANGLE = math.pi
SMALL_ANGLES = math.radians(1.0)  # bends that are all below this were likely written in radians


@dataclass(frozen=True)
class Loop:
    """Rows of a bench that share one loading from rest: same joint, side and largest pressure."""

    joint: int
    side: int  # 0 for left, 1 for right
    top: float  # Largest pressure, from which the unloading branch comes back [Pa]
    rows: NDArray[np.int64]  # (rows,) Places in the arrays of the bench


@dataclass(frozen=True)
class Bench:
    """Measured bends; every array has one entry per row of the files."""

    joint: NDArray[np.int64]  # Joint group, counted from 0
    side: NDArray[np.int64]  # Side under pressure: 0 for left, 1 for right
    pressure: Array  # Gauge pressure of that side [Pa]; the other side is at 0
    angle: Array  # Bend toward the passive side as a positive number [rad]
    unload: NDArray[np.bool_]  # Whether pressure was falling
    angle_sd: Array  # Standard deviation of the angle [rad], NaN where it is not known
    volume: Array  # Oil pushed into the drive units of that side since rest [m^3], NaN where it was not measured
    loops: tuple[Loop, ...]  # Every row is in one of them
    files: tuple[str, ...]  # Where each row came from
    lines: tuple[int, ...]
    warnings: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[int, ...]:
        """Joint groups that were measured."""
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
    """Read bench runs from CSV files and logs of the radio; docs/bench.md tells the columns."""
    given = [paths] if isinstance(paths, (str, Path)) else list(paths)
    if not given:
        raise InputError("must name one file at least", key="bench", fix="give a CSV file of pressures and angles")
    rows = [row for path in given for row in _read(path, robot)]
    loops: dict[tuple[int, int, float], list[int]] = {}
    tops: dict[tuple[str, str, int, int], float] = {}
    for row in rows:
        own = (row.file, row.run, row.joint, row.side)
        tops[own] = max(tops.get(own, 0.0), row.pressure)
    for k, row in enumerate(rows):
        loops.setdefault((row.joint, row.side, tops[row.file, row.run, row.joint, row.side]), []).append(k)
    bench = Bench(
        joint=np.array([row.joint for row in rows]),
        side=np.array([row.side for row in rows]),
        pressure=np.array([row.pressure for row in rows]),
        angle=np.array([row.angle for row in rows]),
        unload=np.array([row.unload for row in rows]),
        angle_sd=np.array([row.angle_sd for row in rows]),
        volume=np.array([row.volume for row in rows]),
        loops=tuple(Loop(*own, np.array(members)) for own, members in loops.items()),
        files=tuple(row.file for row in rows),
        lines=tuple(row.line for row in rows),
        warnings=_warnings(rows),
    )
    _check_direction(bench, robot)
    return bench


def _read(path: str | Path, robot: Robot) -> list[_Row]:
    """Read one file: CSV, or a log of the radio."""
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
            raise InputError("must stand once", file=file, key=f"line {line}, {column}", fix="remove one of the two")
    for column in NEEDED:
        if column not in head:
            fix = f"add it; columns are {', '.join(COLUMNS)}"
            raise InputError("must be a column", file=file, key=column, value="missing", fix=fix)
    found = []
    for line, row in rows:
        check_width(row, head, file=file, line=line)
        try:
            found.append(_row(dict(zip(head, row, strict=True)), robot, file, line))
        except InputError as error:
            key = f"line {line}, {error.key}"
            raise InputError(error.rule, file=file, key=key, value=error.value, fix=error.fix) from None
    return found


def _row(cells: Mapping[str, str], robot: Robot, file: str, line: int) -> _Row:
    """Make a row of its cells; errors name the column."""
    pressure = 1e3 * _number(cells, "pressure_kpa", "kPa")
    angle = math.radians(_number(cells, "angle_deg", "deg"))
    spread = math.radians(_number(cells, "angle_sd_deg", "deg", optional=True))
    volume = 1e-6 * _number(cells, "volume_ml", "ml", optional=True)
    if pressure < 0:
        fix = "give the gauge pressure of the side that bends the joint"
        raise InputError("must not be negative", key="pressure_kpa", value=cells["pressure_kpa"], fix=fix)
    if pressure > HIGHEST_PRESSURE:
        fix = "give it in kPa"
        rule = f"must be at most {HIGHEST_PRESSURE / 1e3:g}"
        raise InputError(rule, key="pressure_kpa", value=cells["pressure_kpa"], fix=fix)
    if abs(angle) > LARGEST_ANGLE:
        raise InputError("must be 180 at most", key="angle_deg", value=cells["angle_deg"], fix="give it in deg")
    if spread <= 0:
        fix = "give the standard deviation of the angle, or leave the cell empty"
        raise InputError("must be greater than 0", key="angle_sd_deg", value=cells["angle_sd_deg"], fix=fix)
    return _Row(
        joint=joint_index(cells["joint"], robot),
        side=_choice(cells["side"], "side", SIDES),
        pressure=pressure,
        angle=angle,
        unload=_choice(cells.get("branch") or "load", "branch", BRANCHES) == 1,
        angle_sd=spread,
        volume=volume,
        run=cells.get("run", ""),
        file=file,
        line=line,
    )


def joint_index(text: str, robot: Robot) -> int:
    """Find a joint group by its name, or by its number counted from the head and from 1."""
    names = [group.name for group in robot.joints]
    if text in names:
        return names.index(text)
    if text.isdecimal() and 1 <= int(text) <= len(names):
        return int(text) - 1
    fix = did_you_mean(text, names) if text else f"give one of {', '.join(names)}"
    raise InputError(f"must be a joint of {robot.name}", key="joint", value=shown(text), fix=fix)


def _choice(text: str, key: str, known: Sequence[str]) -> int:
    """Find a word in a list."""
    if text.lower() not in known:
        fix = did_you_mean(text.lower(), known)
        raise InputError(f"must be {' or '.join(known)}", key=key, value=shown(text), fix=fix)
    return known.index(text.lower())


def _number(cells: Mapping[str, str], key: str, unit: str, *, optional: bool = False) -> float:
    """Read a finite number; NaN for an empty cell of a column that may be left out."""
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
    """Check that bends count toward the passive side: those of the right side are positive, too."""
    for loop in bench.loops:
        mine = loop.rows[bench.pressure[loop.rows] > loop.top / 2]
        if len(mine) and np.median(bench.angle[mine]) < 0:
            k = int(mine[np.argmin(bench.angle[mine])])
            rule = f"must be positive for the {SIDES[loop.side]} side of joint {robot.joints[loop.joint].name}, too"
            value, fix = f"{math.degrees(bench.angle[k]):g}", "count every bend from straight, away from the pressure"
            raise InputError(rule, file=bench.files[k], key=f"line {bench.lines[k]}, angle_deg", value=value, fix=fix)


def _warnings(rows: Sequence[_Row]) -> tuple[str, ...]:
    """Say what a reader of the rows should not overlook."""
    largest = max(abs(row.angle) for row in rows)
    if largest < SMALL_ANGLES and any(row.pressure > 0 for row in rows):
        return (
            f"All angles are below 1 deg, the largest is {math.degrees(largest):.3g} deg: if they were measured in "
            "radians, write them in degrees.",
        )
    return ()
