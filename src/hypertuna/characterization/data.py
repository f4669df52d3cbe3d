"""Bench runs: measured bends of joints under pressure, read from CSV files and logs."""

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
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import CELL, NOT_NEGATIVE, POSITIVE, Range, check_choice
from hypertuna.trials.radio_log import BenchRow, bench_rows

BRANCHES = ("load", "unload")
COLUMNS = ("joint", "side", "pressure_kpa", "angle_deg", "branch", "angle_sd_deg", "volume_ml", "run")
REQUIRED = COLUMNS[:4]
MEASURED = ("joint", "side", "pressure", "angle", "unload", "angle_sd", "volume")  # arrays of a bench
MAX_PRESSURE = Range(max=2000)  # kPa, ten times that of soft actuators: higher values have another unit
MAX_ANGLE = Range(max=180)  # deg
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


def read_bench(paths: str | Path | Sequence[str | Path], robot: Robot) -> Bench:
    """Read bench runs from CSV files and logs of the radio; docs/bench.md lists the columns."""
    files = [paths] if isinstance(paths, (str, Path)) else list(paths)
    if not files:
        raise InputError("must name at least one file", key="bench", fix="give a CSV file of pressures and angles")
    rows = [row for path in files for row in _read(path, robot)]
    tops: dict[tuple[str, str, int, int], float] = {}
    for row in rows:
        key = (row.file, row.run, row.joint, row.side)
        tops[key] = max(tops.get(key, 0.0), row.pressure)
    loops: dict[tuple[int, int, float], list[int]] = {}
    for k, row in enumerate(rows):
        loops.setdefault((row.joint, row.side, tops[row.file, row.run, row.joint, row.side]), []).append(k)
    columns = {name: np.array([getattr(row, name) for row in rows]) for name in MEASURED}
    members = tuple(Loop(*key, np.array(own)) for key, own in loops.items())
    of_rows, lines = tuple(row.file for row in rows), tuple(row.line for row in rows)
    bench = Bench(**columns, loops=members, files=of_rows, lines=lines, warnings=_warnings(rows))
    _check_direction(bench, robot)
    return bench


def _read(path: str | Path, robot: Robot) -> list[BenchRow]:
    """Read one file: CSV, or a radio log."""
    if Path(path).suffix.lower() == ".mcap":
        return bench_rows(path, robot)
    table = read_table(path)
    table.keys({c: c for c in COLUMNS}, {c: c for c in REQUIRED}, fix=f"add it; columns are {', '.join(COLUMNS)}")
    return table.parse(lambda line, cells: _row(cells, robot, table.file, line))


def _row(cells: Mapping[str, str], robot: Robot, file: str, line: int) -> BenchRow:
    """Return the row of its cells; errors name the column."""
    side = "give the gauge pressure of the side that bends the joint"
    pressure = _number(cells, "pressure_kpa", (NOT_NEGATIVE, side), (MAX_PRESSURE, "give it in kPa"))
    angle = _number(cells, "angle_deg")
    MAX_ANGLE.check(abs(angle), "angle_deg", "give it in deg")
    unknown = "give the standard deviation of the angle, or leave the cell empty"
    sd = _number(cells, "angle_sd_deg", (POSITIVE, unknown)) if cells.get("angle_sd_deg") else math.nan
    volume = _number(cells, "volume_ml") if cells.get("volume_ml") else math.nan
    return BenchRow(
        joint=joint_index(cells["joint"], robot),
        side=SIDES.index(check_choice(cells["side"].lower(), SIDES, "side")),
        pressure=1e3 * pressure,
        angle=math.radians(angle),
        unload=check_choice((cells.get("branch") or "load").lower(), BRANCHES, "branch") == "unload",
        run=cells.get("run", ""),
        file=file,
        line=line,
        angle_sd=math.radians(sd),
        volume=1e-6 * volume,
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


def _number(cells: Mapping[str, str], key: str, *limits: tuple[Range, str]) -> float:
    """Return a finite number within limits, each with the fix for a number beyond it."""
    value = parse_float(cells[key])
    if not math.isfinite(value):
        given, fix = cells[key], f"give it in {key.rpartition('_')[2]}, or remove the line"
        raise InputError("must be a finite number", key=key, value=shown(given) if given else "empty", fix=fix)
    CELL.check(value, key, "correct that number, or remove the line")
    for limit, fix in limits:
        limit.check(value, key, fix)
    return value


def _check_direction(bench: Bench, robot: Robot) -> None:
    """Check that bends are positive toward the passive side, on the right side too."""
    for loop in bench.loops:
        high = loop.rows[bench.pressure[loop.rows] > loop.top / 2]
        if len(high) and np.median(bench.angle[high]) < 0:
            k = int(high[np.argmin(bench.angle[high])])
            rule = f"must be positive for the {SIDES[loop.side]} side of joint {robot.joints[loop.joint].name}, too"
            key, value = f"line {bench.lines[k]}, angle_deg", f"{math.degrees(bench.angle[k]):g}"
            fix = "measure the angle from the straight joint, positive away from the pressurized side"
            raise InputError(rule, file=bench.files[k], key=key, value=value, fix=fix)


def _warnings(rows: Sequence[BenchRow]) -> tuple[str, ...]:
    """Return a warning if the angles are likely in radians."""
    largest = max(abs(row.angle) for row in rows)
    if largest < SMALL_ANGLES and any(row.pressure > 0 for row in rows):
        return (
            f"All angles are below 1 deg, the largest is {math.degrees(largest):.3g} deg: if they were measured in "
            "radians, write them in degrees.",
        )
    return ()
