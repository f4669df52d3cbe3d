"""Read measurements from radio logs: steady runs of a tank, and rows of a bench test."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.radio.dialect import SILENT
from hypertuna.radio.log import RadioLog, read_radio_log
from hypertuna.swimming.gait import Gait
from hypertuna.trials.steady import SteadyRun

CENTIDEGREE = math.pi / 18000  # rad
SETTLING = 6.0  # s at the start of a gait that are not used
MIN_BEATS, MIN_PARTS, PART = 5, 4, 1.0  # least number of beats and of parts of a run; least length of a part [s]
MIN_POSES = 4  # in a part
MAX_VENTED, PRESSURE_STEP = 5e3, 5e3  # Pa: largest pressure of a vented side; least change between two rows
MAX_RATE = 30e3  # Pa/s: fastest change of pressure that a joint follows quasi-statically


class BenchRow(NamedTuple):
    """One row of a bench test."""

    joint: int  # index of the joint group, from 0
    side: int  # 0 for left, 1 for right, 2 for both
    pressure: float  # gauge pressure of that side [Pa]; the other side has 0
    angle: float  # bend [rad], positive toward the passive side, NaN if not measured
    unload: bool  # whether pressure was falling
    run: str
    file: str
    line: int  # line of a file; in a log, number of the row
    angle_sd: float = math.nan  # standard deviation [rad], NaN if unknown
    volume: float = math.nan  # oil pumped since rest [m^3], NaN if not measured
    volume_sd: float = math.nan
    shortening: float = math.nan  # shortening of the joint's axis [m]
    shortening_sd: float = math.nan
    moment: float = math.nan  # moment that holds the joint straight [N m]
    moment_sd: float = math.nan
    arm: float = math.inf  # lever arm of the force that makes this moment [m]


def steady_runs(path: str | Path, robot: Robot) -> tuple[SteadyRun, ...]:
    """Return the steady runs in a log of the tank: each commanded gait, with its speed from camera poses.

    The poses are ATT_POS_MOCAP messages. Each gait is cut into parts of whole beats; its speed is the mean distance
    between mean positions of successive parts, over the time between them.
    """
    camera = "have the tank's camera send the robot's pose to the ground station"
    log = _read_log(path, {"GAIT": "record while the robot swims", "ATT_POS_MOCAP": camera})
    runs: list[SteadyRun] = []
    for begin, end, gait in _gaits(log, len(robot.joints)):
        speed = _speed(log, begin + SETTLING, end, gait.frequency)
        if speed is not None:
            name = f"{Path(path).stem}/{len(runs) + 1}"
            runs.append(SteadyRun(name=name, gait=gait, speed=speed[0], speed_sd=speed[1], file=log.file))
    if not runs:
        duration = SETTLING + MIN_PARTS * PART
        fix = f"swim each gait for at least {duration:g} s, in view of the camera"
        raise InputError("must have a gait that settled", file=log.file, fix=fix)
    return tuple(runs)


def _read_log(path: str | Path, fixes: Mapping[str, str]) -> RadioLog:
    """Read a log, and check that it has these messages; fixes: by name, the advice if a message is missing."""
    log = read_radio_log(path)
    for name, fix in fixes.items():
        if not log.has(name):
            raise InputError("must have messages of this kind", file=log.file, key=name, value="without", fix=fix)
    return log


def _gaits(log: RadioLog, joints: int) -> Iterator[tuple[float, float, Gait]]:
    """Yield begin and end [s] of each commanded gait."""
    fields, time = log.fields["GAIT"], log.sent("GAIT")
    angles = [_both(fields, name)[:, :joints] * CENTIDEGREE for name in ("amplitude", "lag", "bias")]
    rows = np.column_stack([fields["frequency"] * 1e-3, *angles])
    order = np.argsort(time, kind="stable")
    time, rows = time[order], rows[order]
    ends = np.flatnonzero(np.any(np.diff(rows, axis=0) != 0, axis=1)) + 1
    for part in np.split(np.arange(len(rows)), ends):
        frequency, *values = rows[part[0]].tolist()
        amplitude, lag, bias = (tuple(values[k * joints : (k + 1) * joints]) for k in range(3))
        if frequency > 0 and any(angle > 0 for angle in amplitude):
            yield float(time[part[0]]), float(time[part[-1]]), Gait(frequency, amplitude, lag, bias)


def _speed(log: RadioLog, begin: float, end: float, frequency: float) -> tuple[float, float] | None:
    """Return the mean speed over ground [m/s] and its standard error; None for too few beats or poses."""
    time, fields = log.time["ATT_POS_MOCAP"], log.fields["ATT_POS_MOCAP"]
    beats = max(1, math.ceil(PART * frequency))
    width = beats / frequency
    count = int((end - begin) / width)
    if count < MIN_PARTS or count * beats < MIN_BEATS:
        return None
    means = []
    for k in range(count):
        inside = (begin + k * width <= time) & (time < begin + (k + 1) * width)
        if np.count_nonzero(inside) < MIN_POSES:
            return None
        means.append([np.mean(fields[axis][inside]) for axis in ("x", "y")] + [np.mean(time[inside])])
    steps = np.diff(np.array(means), axis=0)
    speeds = np.hypot(steps[:, 0], steps[:, 1]) / steps[:, 2]
    return float(np.mean(speeds)), max(float(np.std(speeds, ddof=1)) / math.sqrt(len(speeds)), 1e-6)


def bench_rows(path: str | Path, robot: Robot) -> list[BenchRow]:
    """Return the rows of a bench test in which one side of a joint is slowly pressurized, the other vented."""
    log = _read_log(path, {"HYDRAULICS": "record during the bench test"})
    fields, time = log.fields["HYDRAULICS"], log.sent("HYDRAULICS")
    # NaN for sensors that did not answer
    bend, pressure = (
        np.where(counts == SILENT, np.nan, counts) * unit
        for counts, unit in ((_both(fields, "bend"), CENTIDEGREE), (_both(fields, "pressure"), 100.0))
    )
    rows: list[BenchRow] = []
    for joint in range(len(robot.joints)):
        for side in (0, 1):
            pressed, vented = pressure[:, 2 * joint + side], pressure[:, 2 * joint + 1 - side]
            rows += _loading(joint, side, time, pressed, vented, bend[:, joint] * (1 - 2 * side))
    if not rows:
        rule = f"must have a joint with one side under pressure and the other below {MAX_VENTED / 1e3:g} kPa"
        fix = f"vent the other side, and change the pressure by less than {MAX_RATE / 1e3:g} kPa/s"
        raise InputError(rule, file=log.file, fix=fix)
    return [row._replace(file=str(path), line=k) for k, row in enumerate(rows, 1)]


def _both(fields: Mapping[str, Array], name: str) -> Array:
    """Return a quantity of all joints, which a message splits into two fields."""
    return np.concatenate([fields[name], fields[f"{name}_34"]], axis=1)


def _loading(joint: int, side: int, time: Array, own: Array, other: Array, away: Array) -> list[BenchRow]:
    """Return bench rows of one side of a joint, at each pressure step; a run ends when the pressure returns to zero."""
    rows: list[BenchRow] = []
    run, last_pressure, highest, falling = 0, 0.0, 0.0, False
    valid = np.isfinite(own) & np.isfinite(other) & np.isfinite(away)
    time, own, other, away = time[valid], own[valid], other[valid], away[valid]
    rate = np.abs(np.gradient(own, time)) if len(own) > 1 else np.zeros(len(own))
    for k in range(len(own)):
        if own[k] < MAX_VENTED:
            run, last_pressure, highest, falling = run + (last_pressure > 0), 0.0, 0.0, False
            continue
        highest = max(highest, float(own[k]))
        falling = falling or own[k] < highest - PRESSURE_STEP
        if abs(other[k]) > MAX_VENTED or rate[k] > MAX_RATE or abs(own[k] - last_pressure) < PRESSURE_STEP:
            continue
        last_pressure = float(own[k])
        rows.append(BenchRow(joint, side, last_pressure, float(away[k]), falling, f"{joint}{side}-{run}", "", 0))
    return rows
