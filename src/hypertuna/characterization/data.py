"""Bench runs: measurements of joints under pressure, read from CSV files and logs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import CELL, NOT_NEGATIVE, POSITIVE, Range, check_choice
from hypertuna.trials.radio_log import BenchRow, bench_rows


class MeasuredKind(NamedTuple):
    """A kind of measured quantity: its column, its displayed unit, and the noise of a usual instrument."""

    column: str  # ends in the unit
    unit: str
    factor: float  # displayed units per SI unit
    sd: float  # standard deviation of a usual instrument [SI]; negative: relative
    estimated: bool  # whether a fit estimates the noise from its residuals if no standard deviation is stated


KINDS = {
    "angle": MeasuredKind("angle_deg", "deg", 180 / math.pi, math.radians(0.2), estimated=True),
    "volume": MeasuredKind("volume_ml", "ml", 1e6, -0.02, estimated=True),
    "shortening": MeasuredKind("shortening_mm", "mm", 1e3, 0.2e-3, estimated=False),
    "moment": MeasuredKind("moment_n_m", "N m", 1.0, -0.05, estimated=False),  # may be given as a force and its arm
}
SD = {kind: f"{kind}_sd{one.column[len(kind) :]}" for kind, one in KINDS.items()}  # columns of standard deviations
BRANCHES, BOTH = ("load", "unload"), "both"  # words in the columns branch and side
FORCE, FORCE_SD, ARM = "force_n", "force_sd_n", "arm_mm"  # columns of a force that holds a joint
REQUIRED = ("joint", "side", "pressure_kpa")  # columns that every file must have
COLUMNS = (  # all columns of a file
    *(*REQUIRED, "branch", "run"),
    *(name for kind, one in KINDS.items() for name in (one.column, SD[kind])),
    *(FORCE, FORCE_SD, ARM),
)
# Names of the arrays of a `Bench`.
MEASURED = ("joint", "side", "pressure", "unload", "arm", *KINDS, *(f"{kind}_sd" for kind in KINDS))
MAX_PRESSURE = Range(max=2000)  # kPa, ten times the pressure of soft actuators: higher values are in another unit
MAX_ANGLE = Range(max=180)  # deg
MAX_ARM = Range(max=10_000)  # mm
SMALLEST = 1e-12  # smallest usual standard deviation [SI]
SMALL_ANGLES = math.radians(1.0)  # if all bends are smaller, their unit is likely rad


@dataclass(frozen=True)
class Loop:
    """Rows of a bench that share one loading from rest: same joint, side and maximum pressure."""

    joint: int
    side: int  # 0 for left, 1 for right, 2 for both
    top: float  # maximum pressure, where unloading starts [Pa]
    rows: NDArray[np.int64]  # (rows,), indices into the arrays of the bench


@dataclass(frozen=True)
class Bench:
    """Measurements of a bench; every array has one entry per row of the files, NaN where a row lacks the quantity."""

    joint: NDArray[np.int64]  # joint group, from 0
    side: NDArray[np.int64]  # side under pressure: 0 for left, 1 for right, 2 for both
    pressure: Array  # gauge pressure of that side [Pa]; the other side is at 0
    unload: NDArray[np.bool_]  # whether the pressure was falling
    arm: Array  # distance from the middle of the joint to the force that holds it straight [m], infinite for a couple
    angle: Array  # bend [rad], positive toward the passive side
    volume: Array  # oil pumped into that side since rest [m^3]
    shortening: Array  # shortening of the joint's axis [m]
    moment: Array  # moment that holds the joint straight, force times arm [N m]
    angle_sd: Array  # standard deviation, NaN where not stated
    volume_sd: Array
    shortening_sd: Array  # not NaN where the shortening is measured
    moment_sd: Array
    loops: tuple[Loop, ...]  # each row is in one loop, except rows of a held joint
    files: tuple[str, ...]  # file of each row
    lines: tuple[int, ...]  # line of each row in its file
    warnings: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[int, ...]:
        """Indices of the joint groups that were measured."""
        return tuple(int(j) for j in np.unique(self.joint))

    def sides(self, joint: int) -> tuple[int, ...]:
        """Return the sides to which a joint was bent."""
        return tuple(int(s) for s in np.unique(self.side[(self.joint == joint) & np.isfinite(self.angle)]))


def read_bench(paths: str | Path | Sequence[str | Path], robot: Robot) -> Bench:
    """Read bench runs from CSV files and logs of the radio; docs/bench.md lists the columns."""
    files = [paths] if isinstance(paths, (str, Path)) else list(paths)
    if not files:
        raise InputError("must name at least one file", key="bench", fix="give a CSV file of pressures and angles")
    rows = [row for path in files for row in _read(path, robot)]
    top_pressures: dict[tuple[str, str, int, int], float] = {}
    for row in rows:
        key = (row.file, row.run, row.joint, row.side)
        top_pressures[key] = max(top_pressures.get(key, 0.0), row.pressure)
    loops: dict[tuple[int, int, float], list[int]] = {}
    for k, row in enumerate(rows):
        if math.isfinite(row.moment):
            continue
        loops.setdefault((row.joint, row.side, top_pressures[row.file, row.run, row.joint, row.side]), []).append(k)
    columns = {name: np.array([getattr(row, name) for row in rows]) for name in MEASURED}
    loop_tuple = tuple(Loop(*key, np.array(rows_of_loop)) for key, rows_of_loop in loops.items())
    row_files, lines = tuple(row.file for row in rows), tuple(row.line for row in rows)
    bench = Bench(**columns, loops=loop_tuple, files=row_files, lines=lines, warnings=_warnings(rows))
    _check_direction(bench, robot)
    return bench


def _read(path: str | Path, robot: Robot) -> list[BenchRow]:
    """Return the rows of one file: CSV, or a radio log."""
    if Path(path).suffix.lower() == ".mcap":
        return bench_rows(path, robot)
    table = read_table(path, RUNS)
    table.keys({c: c for c in COLUMNS}, {c: c for c in REQUIRED}, fix=f"add it; columns are {', '.join(COLUMNS)}")
    if not set(table.head) & {FORCE, *(one.column for one in KINDS.values())}:
        rule = "must have a column of what was measured"
        raise InputError(rule, file=table.file, fix=f"add {', '.join(one.column for one in KINDS.values())} or {FORCE}")
    return table.parse(lambda line, cells: _row(cells, robot, table.file, line), names={c: c for c in COLUMNS})


def _row(cells: Mapping[str, str], robot: Robot, file: str, line: int) -> BenchRow:
    """Return a row of the bench from its cells; errors name the column."""
    side = check_choice(cells["side"].lower(), (*SIDES, BOTH), "side")
    fix = "give the gauge pressure of the side that bends the joint"
    pressure = _number(cells, "pressure_kpa", (NOT_NEGATIVE, fix), (MAX_PRESSURE, "give it in kPa"))
    measured = {kind: value for kind in KINDS for value in [_measured(cells, kind)] if value is not None}
    moment, arm = _held(cells)
    if moment is not None:
        measured["moment"] = moment
    _check_measured(measured, side)
    values = {kind: value for kind, (value, _) in measured.items()}
    return BenchRow(
        joint=joint_index(cells["joint"], robot),
        side=(*SIDES, BOTH).index(side),
        pressure=1e3 * pressure,
        unload=check_choice((cells.get("branch") or "load").lower(), BRANCHES, "branch") == "unload",
        run=cells.get("run", ""),
        file=file,
        line=line,
        arm=arm,
        **({"angle": math.nan} | values),
        **{f"{kind}_sd": sd for kind, (_, sd) in measured.items()},
    )


def _measured(cells: Mapping[str, str], kind: str) -> tuple[float, float] | None:
    """Return the value of a quantity in a row and its standard deviation [SI]; None for an empty cell."""
    quantity = KINDS[kind]
    if not cells.get(quantity.column):
        return None
    value = _number(cells, quantity.column)
    if kind == "angle":
        MAX_ANGLE.check(abs(value), quantity.column, "give it in deg")
    value /= quantity.factor
    fix = "give the standard deviation, or leave the cell empty"
    if cells.get(SD[kind]):
        return value, _number(cells, SD[kind], (POSITIVE, fix)) / quantity.factor
    return value, math.nan if quantity.estimated else usual_sd(kind, value)


def usual_sd(kind: str, value: float) -> float:
    """Return the standard deviation of a usual instrument for a quantity at a value [SI]."""
    sd = KINDS[kind].sd
    return sd if sd > 0 else max(-sd * abs(value), SMALLEST)


def _held(cells: Mapping[str, str]) -> tuple[tuple[float, float] | None, float]:
    """Return a holding force's moment and its standard deviation [N m], None without a force, and its arm [m]."""
    if not cells.get(FORCE):
        if cells.get(ARM):
            raise InputError("belongs to a force", key=ARM, fix=f"give {FORCE} too, or leave the cell empty")
        return None, math.inf
    if not cells.get(ARM):
        fix = "give the distance of the scale from the middle of the joint in mm"
        raise InputError("must be given with a force", key=ARM, value="empty", fix=fix)
    if cells.get(KINDS["moment"].column):
        raise InputError("must not be given with a moment", key=FORCE, fix="leave one of the two empty")
    fix = "give the distance of the scale from the middle of the joint in mm"
    force, arm = _number(cells, FORCE), 1e-3 * _number(cells, ARM, (POSITIVE, fix), (MAX_ARM, "give it in mm"))
    fix = "give the standard deviation, or leave the cell empty"
    sd = arm * _number(cells, FORCE_SD, (POSITIVE, fix)) if cells.get(FORCE_SD) else usual_sd("moment", arm * force)
    return (arm * force, sd), arm


def _check_measured(measured: Mapping[str, tuple[float, float]], side: str) -> None:
    """Check that a row measures something, and that its quantities belong together."""
    columns = [quantity.column for quantity in KINDS.values()]
    if not measured:
        raise InputError("must have a measured value", value="empty", fix=f"give {', '.join(columns)} or {FORCE}")
    if side == BOTH and (others := [KINDS[kind].column for kind in measured if kind != "shortening"]):
        rule = f"must be empty with both sides under pressure: the row is for {KINDS['shortening'].column}"
        raise InputError(rule, key=others[0], fix="give it on a line of one side")
    if "moment" in measured and (others := [KINDS[kind].column for kind in measured if kind != "moment"]):
        rule = "must be empty on a line of a held joint, with a force or a moment"
        raise InputError(rule, key=others[0], fix="give it on a line of its own")


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
    """Return the number in a cell, which must be finite and within `limits`: ranges, each with the fix of its error."""
    value = parse_float(cells[key])
    if not math.isfinite(value):
        text, fix = cells[key], f"give it in {key.rpartition('_')[2]}, or remove the line"
        raise InputError("must be a finite number", key=key, value=shown(text) if text else "empty", fix=fix)
    CELL.check(value, key, "correct that number, or remove the line")
    for limit, fix in limits:
        limit.check(value, key, fix)
    return value


def _check_direction(bench: Bench, robot: Robot) -> None:
    """Check that bends are positive toward the side without pressure, whichever side is under pressure."""
    for loop in bench.loops:
        upper_rows = loop.rows[(bench.pressure[loop.rows] > loop.top / 2) & np.isfinite(bench.angle[loop.rows])]
        if len(upper_rows) and np.median(bench.angle[upper_rows]) < 0:
            k = int(upper_rows[np.argmin(bench.angle[upper_rows])])
            rule = f"must be positive for the {SIDES[loop.side]} side of joint {robot.joints[loop.joint].name}, too"
            key, value = f"line {bench.lines[k]}, angle_deg", f"{math.degrees(bench.angle[k]):g}"
            fix = "measure the angle from the straight joint, positive away from the pressurized side"
            raise InputError(rule, file=bench.files[k], key=key, value=value, fix=fix)


def _warnings(rows: Sequence[BenchRow]) -> tuple[str, ...]:
    """Return a warning if the angles are likely in radians."""
    largest = max((abs(row.angle) for row in rows if math.isfinite(row.angle)), default=math.inf)
    if largest < SMALL_ANGLES and any(row.pressure > 0 for row in rows):
        return (
            f"All angles are below 1 deg, the largest is {math.degrees(largest):.3g} deg: if they were measured in "
            "radians, write them in degrees.",
        )
    return ()
