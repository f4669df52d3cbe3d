"""Radio logs as measurements: steady runs of a tank, and rows of a bench."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.radio.dialect import SILENT
from hypertuna.radio.log import RadioLog, read_radio_log
from hypertuna.swimming.gait import Gait
from hypertuna.trials.steady import SteadyRun

CDEG = math.pi / 18000  # rad
SETTLING = 6.0  # s at the start of a gait that are left out
MIN_BEATS, MIN_PARTS, PART = 5, 4, 1.0  # of a settled run; s of whole beats for one mean position
SAMPLES = 4  # poses in a part
VENTED, STEP = 5e3, 5e3  # Pa: maximum pressure of a vented side, minimum pressure between rows
MAX_RATE = 30e3  # Pa/s that a joint follows

Row = tuple[int, int, float, float, bool, str]  # joint, side, pressure [Pa], angle [rad], unloading, run


def steady_runs(path: str | Path, robot: Robot) -> tuple[SteadyRun, ...]:
    """Return the settled parts of a tank run: the gait as commanded, and its speed in ATT_POS_MOCAP, camera poses.

    The position of the robot itself is dead reckoning by its gait table and carries no information. The speed is the
    mean distance between the mean positions of parts of whole beats, over their time.
    """
    log = read_radio_log(path)
    for name, fix in (
        ("GAIT", "record while the robot swims"),
        ("ATT_POS_MOCAP", "have the tank's camera send the robot's pose to the ground station"),
    ):
        if not log.has(name):
            raise InputError("must have messages of this kind", file=log.file, key=name, value="without", fix=fix)
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


def _gaits(log: RadioLog, joints: int) -> Iterator[tuple[float, float, Gait]]:
    """Yield begin and end [s] of each commanded gait."""
    fields, time = log.fields["GAIT"], log.sent("GAIT")

    def angles(name: str) -> Array:
        return np.concatenate([fields[name], fields[f"{name}_34"]], axis=1)[:, :joints] * CDEG

    rows = np.column_stack([fields["frequency"] * 1e-3, angles("amplitude"), angles("lag"), angles("bias")])
    order = np.argsort(time, kind="stable")
    time, rows = time[order], rows[order]
    ends = np.flatnonzero(np.any(np.diff(rows, axis=0) != 0, axis=1)) + 1
    for part in np.split(np.arange(len(rows)), ends):
        frequency, amplitude, lag, bias = (rows[part[0], cut] for cut in _cuts(joints))
        if frequency[0] > 0 and np.any(amplitude > 0):
            yield (
                float(time[part[0]]),
                float(time[part[-1]]),
                Gait(float(frequency[0]), tuple(amplitude.tolist()), tuple(lag.tolist()), tuple(bias.tolist())),
            )


def _cuts(joints: int) -> tuple[slice, ...]:
    """Return the slices of frequency, amplitudes, lags and biases in a row."""
    return (slice(0, 1), *(slice(1 + k * joints, 1 + (k + 1) * joints) for k in range(3)))


def _speed(log: RadioLog, begin: float, end: float, frequency: float) -> tuple[float, float] | None:
    """Return the mean speed over ground [m/s] and its standard deviation; None for too few beats or poses."""
    time, fields = log.time["ATT_POS_MOCAP"], log.fields["ATT_POS_MOCAP"]
    beats = max(1, math.ceil(PART * frequency))
    width = beats / frequency
    count = int((end - begin) / width)
    if count < MIN_PARTS or count * beats < MIN_BEATS:
        return None
    means = []
    for k in range(count):
        inside = (begin + k * width <= time) & (time < begin + (k + 1) * width)
        if np.count_nonzero(inside) < SAMPLES:
            return None
        means.append([np.mean(fields[axis][inside]) for axis in ("x", "y")] + [np.mean(time[inside])])
    steps = np.diff(np.array(means), axis=0)
    speeds = np.hypot(steps[:, 0], steps[:, 1]) / steps[:, 2]
    return float(np.mean(speeds)), max(float(np.std(speeds, ddof=1)) / math.sqrt(len(speeds)), 1e-6)


def bench_rows(path: str | Path, robot: Robot) -> list[Row]:
    """Return the rows of a bench test: one side of a joint under a slowly changing pressure, the other vented."""
    log = read_radio_log(path)
    if not log.has("HYDRAULICS"):
        raise InputError("must have messages of this kind", file=log.file, key="HYDRAULICS", value="without",
                         fix="record during the bench test")  # fmt: skip
    fields, time = log.fields["HYDRAULICS"], log.sent("HYDRAULICS")
    bend, pressure = (_readings(fields, kind) * unit for kind, unit in (("bend", CDEG), ("pressure", 100.0)))
    rows: list[Row] = []
    for joint in range(len(robot.joints)):
        for side in (0, 1):
            own, other = pressure[:, 2 * joint + side], pressure[:, 2 * joint + 1 - side]
            away = bend[:, joint] * (1 if side == 0 else -1)
            rows += _loading(joint, side, time, own, other, away)
    if not rows:
        kilo = 1e-3
        rule = f"must have a joint with one side under pressure and the other below {VENTED * kilo:g} kPa"
        fix = f"vent the other side, and change the pressure by less than {MAX_RATE * kilo:g} kPa/s"
        raise InputError(rule, file=log.file, fix=fix)
    return rows


def _readings(fields: dict[str, Array], kind: str) -> Array:
    """Return the readings of the sensors of all joints; NaN for sensors that did not answer."""
    counts = np.concatenate([fields[kind], fields[f"{kind}_34"]], axis=1)
    return np.where(counts == SILENT, np.nan, counts)


def _loading(joint: int, side: int, time: Array, own: Array, other: Array, away: Array) -> list[Row]:
    """Return rows of one side, a step of pressure apart; each return to rest ends a run."""
    rows: list[Row] = []
    run, before, top, falling = 0, 0.0, 0.0, False
    valid = np.isfinite(own) & np.isfinite(other) & np.isfinite(away)
    time, own, other, away = time[valid], own[valid], other[valid], away[valid]
    rate = np.abs(np.gradient(own, time)) if len(own) > 1 else np.zeros(len(own))
    for k in range(len(own)):
        if own[k] < VENTED:
            run, before, top, falling = run + (before > 0), 0.0, 0.0, False
            continue
        top = max(top, float(own[k]))
        falling = falling or own[k] < top - STEP
        if abs(other[k]) > VENTED or rate[k] > MAX_RATE or abs(own[k] - before) < STEP:
            continue
        before = float(own[k])
        rows.append((joint, side, before, float(away[k]), falling, f"{joint}{side}-{run}"))
    return rows
