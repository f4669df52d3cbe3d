"""What a robot would have done in the trials, with exact derivatives by its free coefficients, beside what it did."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import Free, columns, directions, position
from hypertuna.swimming.beat import DEFAULT_STEPS, settle, slopes
from hypertuna.swimming.model import core_model, parameter_names
from hypertuna.trials.comparison import repeatability
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import joint_grid, replay_slopes, seen_from_start
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.tracks import Track
from hypertuna.trials.trials import Trials

__all__ = ["KINDS", "Experiment", "Prediction", "experiment", "loss_terms", "predict", "weighted"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]

KINDS = ("speed", "cost_of_transport", "x", "y", "yaw")
# Noise to begin with where neither a file nor repeated runs tell it: relative for steady runs, in m and rad for tracks.
FIRST_LEVEL = {"speed": 0.05, "cost_of_transport": 0.05, "x": 0.01, "y": 0.01, "yaw": 0.03}
FAILED = 10.0  # times what was measured, or body lengths, or rad: how wrong a run that has no settled beat counts
ENOUGH = 4  # runs of a recording that tell their own noise; of fewer it is estimated with the fit
USABLE = (0, 2)  # settled, and periodic but unstable: both have derivatives
LOSSES = ("linear", "soft_l1", "huber", "cauchy")


@dataclass(frozen=True)
class Experiment:
    """Trials laid out for a fit: elements are single numbers, a sample is what counts as one independent measurement.

    The speed of a steady run is a sample of one element. So is its cost of transport. All frames of a tracked run along
    one axis are together one sample, because their errors go on from frame to frame.

    Attributes
    ----------
    robot : Robot
    trials : Trials
    measured : ndarray, shape (elements,)
        Speed [m/s], cost of transport [J/(kg m)], x and y [m] and yaw [rad] of each frame seen from the first.
    sample : ndarray, shape (elements,)
        Which sample an element belongs to.
    kind, run : ndarray, shape (samples,)
        Index into `KINDS`, and into ``trials.runs``.
    sd : ndarray, shape (samples,)
        Standard deviation [SI]; where it is not known, what the unknown level of noise is to be multiplied by.
    known : ndarray, shape (samples,)
        Whether ``sd`` is known.
    count : ndarray, shape (samples,)
        Elements of each sample.
    """

    robot: Robot
    trials: Trials
    measured: Array
    sample: Indices
    kind: Indices
    run: Indices
    sd: Array
    known: Flags
    count: Indices
    swims: tuple[_Replayed, ...]

    @property
    def unknown_kinds(self) -> tuple[str, ...]:
        """Kinds of samples whose noise has to be estimated."""
        return tuple(name for k, name in enumerate(KINDS) if (~self.known & (self.kind == k)).any())


@dataclass(frozen=True)
class Prediction:
    """What a robot would have done.

    Attributes
    ----------
    computed : ndarray, shape (elements,)
        In the units of what was measured.
    slope : ndarray, shape (elements, n)
        Derivatives by the free coefficients, each in its scale.
    failed, unstable : ndarray, shape (runs,)
        Whether a run has no settled beat, or one that the robot would not keep.
    others : dict of ndarray
        Speed and cost of transport of every steady run, measured or not, with their slopes: what could be measured.
    """

    computed: Array
    slope: Array
    failed: Flags
    unstable: Flags
    others: dict[str, tuple[Array, Array]]


@dataclass(frozen=True)
class _Replayed:
    """A recording ready to be replayed: its joint motion, and the frames of its runs."""

    name: str
    joints: Array  # (2 * steps + 1, links, 3)
    step: float
    time: Array  # of the steps, on the clock of the tracks
    offset: float  # in `time` already
    frames: Array  # times of all frames of all runs
    turn: Array  # (frames,) from the axes of the replay to those of the run
    runs: int


def experiment(robot: Robot, trials: Trials, frees: Sequence[Free] = ()) -> Experiment:
    """Lay out trials for a fit.

    Parameters
    ----------
    robot : Robot
    trials : Trials
    frees : sequence of Free
        Where the time offset of a recording is among them, only frames are used that the replay spans whatever it is.

    Returns
    -------
    Experiment

    Raises
    ------
    InputError
        If there is no run, a recording spans no frame, or a speed of 0 has no standard deviation.
    """
    if not trials.runs:
        raise InputError("must have one run at least", key="trials", fix="give measured runs")
    steady = [
        (kind, r, value, sd, run.repeats)
        for r, run in enumerate(trials.steady)
        for kind, (value, sd) in enumerate(
            [(run.speed, run.speed_sd), (run.cost_of_transport, run.cost_of_transport_sd)]
        )
        if value is not None
    ]
    for _, r, value, sd, _ in steady:
        if value == 0 and sd is None:
            run, fix = trials.steady[r], "give speed_sd_m_s"
            rule = "must have a standard deviation where it is 0: a relative error is not defined"
            raise InputError(rule, file=run.file, key=f"line {run.line}, speed_m_s", fix=fix)
    measured = [np.array([value for _, _, value, _, _ in steady], dtype=float)]
    sample = [np.arange(len(steady))]
    samples = [
        (kind, r, (abs(value) if sd is None else sd) / math.sqrt(repeats), sd is not None, 1)
        for kind, r, value, sd, repeats in steady
    ]
    swims, first = [], len(trials.steady)
    for recording in trials.recordings:
        replayed, poses, sizes = _replayed(robot, recording, frees)
        spread = _spread_of(recording)
        for axis in range(3):  # all frames of all runs along x, then y, then yaw: as `_tracked` computes them
            sample.append(len(samples) + np.repeat(np.arange(len(sizes)), sizes))
            measured.append(poses[:, axis])
            known = bool(np.isfinite(spread[axis]) and spread[axis] > 0)
            sd = float(spread[axis]) if known else 1 / math.sqrt(recording.repeats)
            samples += [(2 + axis, first + r, sd, known, size) for r, size in enumerate(sizes)]
        first += len(sizes)
        swims.append(replayed)
    kind, run_of, sds, knowns, count = (np.array(column) for column in zip(*samples, strict=True))
    whole = np.concatenate(measured)
    return Experiment(
        robot, trials, whole, np.concatenate(sample).astype(np.intp), kind, run_of, sds, knowns, count, tuple(swims)
    )


def predict(
    data: Experiment,
    frees: Sequence[Free],
    values: Sequence[float] | Array,
    *,
    steps: int = DEFAULT_STEPS,
    slope_steps: int | None = DEFAULT_STEPS,
    threads: int = 1,
) -> Prediction:
    """Compute every run of the trials with some values of the free coefficients.

    One search for settled beats and one pass of derivatives serve all steady runs; one replay serves all runs of a
    recording. A run without a settled beat is not a number that a search could use: it counts as ten times as far off
    as what was measured (a recording as ten body lengths and ten radians), with no slope, so that a search turns back.

    Parameters
    ----------
    data : Experiment
    frees : sequence of Free
    values : array_like, shape (n,)
        In SI units [SI].
    steps : int
        Runge-Kutta steps per beat.
    slope_steps : int, optional
        The same of the derivatives of steady runs; None leaves all slopes zero.
    threads : int
        The result does not depend on it.

    Returns
    -------
    Prediction
    """
    robot = data.robot
    model = core_model(robot, columns(robot, frees, values))
    along = None if slope_steps is None else directions(robot, frees, values)
    runs = len(data.trials.runs)
    failed, unstable = np.zeros(runs, dtype=bool), np.zeros(runs, dtype=bool)
    computed: list[Array] = []
    slopes_by: list[Array] = []
    others: dict[str, tuple[Array, Array]] = {}
    if steady := data.trials.steady:
        others, status = _steady(data, frees, values, model, along, (steps, slope_steps or steps), threads)
        failed[: len(steady)], unstable[: len(steady)] = ~np.isin(status, USABLE), status == 2
        here = data.kind[: (data.kind < 2).sum()]
        at = data.run[: len(here)]
        for table, parts in enumerate((computed, slopes_by)):
            both = np.stack([others[name][table] for name in KINDS[:2]])
            parts.append(both[here, at])
        wrong = failed[at]
        size = np.maximum(np.abs(data.measured[: len(here)]), data.sd[: len(here)])
        computed[0][wrong] = FAILED * size[wrong]
        slopes_by[0][wrong] = 0.0
    first = len(steady)
    for swim in data.swims:
        track, by, sound = _tracked(data, swim, frees, values, model, along)
        computed.append(track)
        slopes_by.append(by)
        failed[first : first + swim.runs] = not sound
        first += swim.runs
    return Prediction(np.concatenate(computed), np.concatenate(slopes_by), failed, unstable, others)


def weighted(data: Experiment, found: Prediction, levels: dict[str, float]) -> tuple[Array, Array]:
    """Put residuals in units of their standard deviation, so that a sample's sum of squares is 1 on average.

    Parameters
    ----------
    data : Experiment
    found : Prediction
    levels : dict of float
        Noise of the kinds whose noise is unknown: relative for speed and cost of transport [1], [m] and [rad].

    Returns
    -------
    residual : ndarray, shape (elements,)
        Computed minus measured [1].
    slope : ndarray, shape (elements, n)
        Its derivatives by the free coefficients, each in its scale [1 per SI].
    """
    level = np.array([levels.get(name, 1.0) for name in KINDS])[data.kind]
    scale = (np.where(data.known, 1.0, level) * data.sd * np.sqrt(data.count))[data.sample]
    return (found.computed - data.measured) / scale, found.slope / scale[:, np.newaxis]


def loss_terms(loss: str, square: Array) -> Array:
    """Evaluate a loss rho(z) of samples, and its first and second derivative by z.

    Parameters
    ----------
    loss : {"linear", "soft_l1", "huber", "cauchy"}
        As SciPy's least_squares defines them: z, 2 (sqrt(1 + z) - 1), z up to 1 and then 2 sqrt(z) - 1, ln(1 + z).
    square : ndarray, shape (samples,)
        Squared residual z of each sample, in units of its variance [1].

    Returns
    -------
    ndarray, shape (3, samples)
        [1].
    """
    z = square
    one, none = np.ones_like(z), np.zeros_like(z)
    if loss == "soft_l1":
        t = 1 + z
        return np.stack([2 * (np.sqrt(t) - 1), t**-0.5, -0.5 * t**-1.5])
    if loss == "huber":
        far = np.where(z > 1, z, 1.0)
        return np.where(z > 1, np.stack([2 * np.sqrt(far) - 1, far**-0.5, -0.5 * far**-1.5]), np.stack([z, one, none]))
    if loss == "cauchy":
        t = 1 + z
        return np.stack([np.log1p(z), 1 / t, -1 / t**2])
    return np.stack([z, one, none])


def _steady(
    data: Experiment,
    frees: Sequence[Free],
    values: Sequence[float] | Array,
    model: Any,
    along: Array | None,
    steps: tuple[int, int],
    threads: int,
) -> tuple[dict[str, tuple[Array, Array]], NDArray[Any]]:
    """Speed and cost of transport of every steady run, with slopes, and its status."""
    gaits = [run.gait for run in data.trials.steady]
    frequency = np.array([gait.frequency for gait in gaits])
    amplitude, phase, bias = (
        np.array([getattr(gait, name) for gait in gaits]) for name in ("amplitude", "phase", "bias")
    )
    arrays = (frequency, amplitude, phase, bias)
    found = settle(data.robot, *arrays, model=model, steps=steps[0], threads=threads)
    by: dict[str, Array] = dict.fromkeys(KINDS[:2], np.zeros((len(gaits), len(frees))))
    if along is not None:
        with np.errstate(all="ignore"):  # of gaits without a settled beat, which have none
            by = slopes(data.robot, *arrays, found, along, model=model, steps=steps[1], threads=threads)
    usable = np.isin(found["status"], USABLE) & np.isfinite(found["cost_of_transport"]) & (found["speed"] != 0)
    status = np.where(usable, found["status"], 3)
    table = {
        name: (found[name], np.where(usable[:, np.newaxis] & np.isfinite(by[name]), by[name], 0.0))
        for name in KINDS[:2]
    }
    if (k := position(frees, "cost_factor")) is not None:
        # the measured cost is a factor more than the mechanical one
        cost, slope = table["cost_of_transport"]
        factor = float(values[k])
        slope = factor * slope
        slope[:, k] = np.where(usable, cost * (factor if frees[k].scale == "log" else 1.0), 0.0)
        table["cost_of_transport"] = factor * cost, slope
    return table, status


def _tracked(
    data: Experiment,
    swim: _Replayed,
    frees: Sequence[Free],
    values: Sequence[float] | Array,
    model: Any,
    along: Array | None,
) -> tuple[Array, Array, bool]:
    """Poses at the frames of all runs of a recording, axis by axis, with slopes, and whether the replay is sound."""
    frames, n = len(swim.frames), len(frees)
    along = np.zeros((len(parameter_names(data.robot)), 0)) if along is None else along
    pose, _, by = replay_slopes(data.robot, swim.joints, swim.step, along, model=model)
    if not along.size:
        by, along = np.zeros((*pose.shape, n)), np.zeros((len(along), n))
    if not (np.isfinite(pose).all() and np.isfinite(by).all()):
        far = FAILED * np.array([data.robot.body.length, data.robot.body.length, 1.0])
        return np.repeat(far, frames), np.zeros((3 * frames, n)), False
    # the center of the head, seen from its start
    half = columns(data.robot, frees, values).get("links.length", data.robot.links.length)[0] / 2
    by_half = along[parameter_names(data.robot).index("links.length[0]")] / 2
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    center = np.column_stack([pose[:, 0] + half * (c - 1), pose[:, 1] + half * s, pose[:, 2]])
    slope = by.copy()
    slope[:, 0] += np.outer(c - 1, by_half) - (half * s)[:, np.newaxis] * by[:, 2]
    slope[:, 1] += np.outer(s, by_half) + (half * c)[:, np.newaxis] * by[:, 2]
    # at the frames, between two steps of the replay; before its start the robot rests
    k = position(frees, "time_offset", swim.name)
    shift = 0.0 if k is None else float(values[k]) - swim.offset
    clock = (swim.frames - shift - swim.time[0]) / swim.step
    early = clock < 0
    left = np.clip(np.floor(clock).astype(int), 0, len(pose) - 2)
    part = np.clip(clock - left, 0.0, 1.0)[:, np.newaxis]
    at = center[left] * (1 - part) + center[left + 1] * part
    slope_at = slope[left] * (1 - part[..., np.newaxis]) + slope[left + 1] * part[..., np.newaxis]
    if k is not None:
        rate = (center[left + 1] - center[left]) / swim.step
        slope_at[:, :, k] = np.where(early[:, np.newaxis], 0.0, -rate)
    turn = np.stack([np.cos(swim.turn), -np.sin(swim.turn), np.sin(swim.turn), np.cos(swim.turn)], -1).reshape(-1, 2, 2)
    at[:, :2] = np.einsum("fij,fj->fi", turn, at[:, :2])
    slope_at[:, :2] = np.einsum("fij,fjn->fin", turn, slope_at[:, :2])
    return at.T.ravel(), np.moveaxis(slope_at, 1, 0).reshape(3 * frames, n), True


def _replayed(robot: Robot, recording: Recording, frees: Sequence[Free]) -> tuple[_Replayed, Array, list[int]]:
    """Lay out a recording: what to replay, the tracked poses seen from the first of each run, and frames per run."""
    joints, step = joint_grid(robot, smooth(recording.joints, noise=recording.noise))
    time = recording.joints.time[0] + recording.time_offset + step * np.arange(len(joints) // 2 + 1)
    k = position(frees, "time_offset", recording.name)
    # however the clock of the joints moves, the replay spans the last frame; before its first one the robot rests
    begin, end = time[0], time[-1]
    if k is not None:
        begin, end = -math.inf, end + min(0.0, frees[k].lower - recording.time_offset)
    times, turns, poses, sizes = [], [], [], []
    for name, track in zip(recording.runs, recording.tracks, strict=True):
        inside = (track.time >= begin) & (track.time <= end)
        if not inside.any():
            rule = f"must overlap the recording, {time[0]:g} to {time[-1]:g} s"
            value = f"{track.time[0]:g} to {track.time[-1]:g} s"
            fix = "give both on one clock, or narrower bounds of time_offset"
            raise InputError(rule, file=recording.file, key=f"run {name}", value=value, fix=fix)
        direction = track.pose[0, 2]
        times.append(track.time[inside])
        turns.append(np.full(inside.sum(), direction - math.pi))
        poses.append(seen_from_start(track.pose, direction)[inside])
        sizes.append(int(inside.sum()))
    ends, whole = recording.time_offset, (np.concatenate(times), np.concatenate(turns))
    swim = _Replayed(recording.name, joints, step, time, ends, *whole, len(sizes))
    return swim, np.concatenate(poses), sizes


def _spread_of(recording: Recording) -> Array:
    """Return the standard deviation of runs about their mean along each axis; not a number for few."""
    tracks: Sequence[Track] = recording.tracks
    if len(tracks) < ENOUGH:
        return np.full(3, np.nan)
    return repeatability(tracks) * math.sqrt(len(tracks) / (len(tracks) - 1))
