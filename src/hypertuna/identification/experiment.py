"""Trials laid out for a fit: measured elements, the independent samples that they form, and the noise of each."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import Free, position
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.trials.comparison import repeatability
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import joint_grid, seen_from_start
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.start import Unknown, beat_of, begin_of
from hypertuna.trials.trials import Trials

Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]

KINDS = ("speed", "cost_of_transport", "x", "y", "yaw")
# First noise levels where neither a file nor repeated runs state them: relative for steady runs, m and rad for tracks.
FIRST_LEVEL = {"speed": 0.05, "cost_of_transport": 0.05, "x": 0.01, "y": 0.01, "yaw": 0.03}
LARGE_ERROR = 0.15  # relative, of speeds, and of tracks over their distance from the start: no noise is larger
MIN_RUNS = 4  # of a recording, for its noise to be computed from their scatter; that of fewer is estimated with the fit


@dataclass(frozen=True)
class Replayed:
    """A recording ready to be replayed: its joint motion, and the frames of its runs."""

    name: str
    joints: Array  # (2 * steps + 1, links, 3)
    step: float  # s
    time: Array  # (steps + 1,) s, on the clock of the tracks
    offset: float  # s, included in `time`
    frames: Array  # (frames,) s, of all runs
    turn: Array  # (frames,) rad, from the axes of the replay to those of the run
    runs: int
    twist: Array | None = None  # (3,) at the start, of a run that begins in motion: given, or a guess
    error: Array = field(default_factory=lambda: np.zeros((1, 3)))  # (runs, 3), of the first poses: a guess
    unknown: Unknown | None = None  # of how the runs begin


@dataclass(frozen=True)
class Experiment:
    """Trials laid out for a fit: elements are single numbers, a sample is one independent measurement.

    All frames of a tracked run along one axis are one sample, because their errors are correlated from frame to frame.
    """

    robot: Robot
    trials: Trials
    free: tuple[Free, ...]
    measured: Array  # (elements,): speed [m/s], cost of transport [J/(kg m)], x, y [m] and yaw [rad] from the start
    sample: Indices  # (elements,), the sample of each element
    kind: Indices  # (samples,), index into KINDS
    run: Indices  # (samples,), index into trials.runs
    sd: Array  # (samples,), standard deviation [SI]; where unknown, the factor on the noise level
    known: Flags  # (samples,), whether `sd` is known
    count: Indices  # (samples,), elements of each sample
    recordings: tuple[Replayed, ...]
    loss: str = "linear"  # of `loss_terms`
    steps: int = DEFAULT_STEPS  # Runge-Kutta steps per beat
    threads: int = 1

    @property
    def unknown_kinds(self) -> tuple[str, ...]:
        """Kinds of samples whose noise has to be estimated."""
        return tuple(name for k, name in enumerate(KINDS) if (~self.known & (self.kind == k)).any())

    @property
    def sizes(self) -> dict[str, float]:
        """What an error of 1 is, by kind: 1 of steady runs, the rms distance from the start [m], and its yaw [rad]."""
        kinds, rms = self.kind[self.sample], {}
        for k, name in enumerate(KINDS):
            own = self.measured[np.isin(kinds, (2, 3) if name in "xy" else (k,))]
            if len(own):
                rms[name] = 1.0 if k < 2 else float(np.sqrt(np.mean(own**2) * (2 if name in "xy" else 1)))
        return rms

    @property
    def level_caps(self) -> dict[str, float]:
        """Largest noise levels of the kinds: beyond them the model is wrong, not the measurement."""
        return {name: max(LARGE_ERROR * size, FIRST_LEVEL[name]) for name, size in self.sizes.items()}

    def frame_noise(self, name: str, levels: Mapping[str, float]) -> Array:
        """Return the standard deviation (3,) of frames of a recording [m, m, rad], its root mean square over runs."""
        own = np.isin(self.run, [k for k, run in enumerate(self.trials.runs) if run.rpartition("/")[0] == name])
        sd = self.noise({kind: levels.get(kind, first) for kind, first in FIRST_LEVEL.items()})
        return np.array([np.sqrt(np.mean(sd[own & (self.kind == kind)] ** 2)) for kind in (2, 3, 4)])

    def noise(self, levels: Mapping[str, float]) -> Array:
        """Return the standard deviation (samples,) [SI]; levels: of the kinds whose noise is unknown."""
        level = np.array([levels.get(name, 1.0) for name in KINDS])[self.kind]
        return np.where(self.known, 1.0, level) * self.sd


def experiment(robot: Robot, trials: Trials, frees: Sequence[Free] = (), **options: Any) -> Experiment:
    """Lay out trials for a fit; options: loss, steps and threads of the `Experiment`.

    Where the time offset of a recording is free, only frames are used that the replay spans for all its values.
    """
    if not trials.runs:
        raise InputError("must have at least one run", key="trials", fix="give measured runs")
    values, samples = [], []
    for r, run in enumerate(trials.steady):
        both = [(run.speed, run.speed_sd), (run.cost_of_transport, run.cost_of_transport_sd)]
        for quantity, (value, sd) in enumerate(both):
            if value == 0 and sd is None:
                key, fix = f"line {run.line}, speed_m_s", "give speed_sd_m_s"
                rule = "must have a standard deviation where it is 0: a relative error is not defined"
                raise InputError(rule, file=run.file, key=key, fix=fix)
            if value is not None:
                size = (abs(value) if sd is None else sd) / math.sqrt(run.repeats)
                samples.append((quantity, r, size, sd is not None, 1))
                values.append(value)
    measured, sample = [np.array(values, dtype=float)], [np.arange(len(values))]
    recordings, first = [], len(trials.steady)
    for recording in trials.recordings:
        replayed, poses, sizes = _replayed(robot, recording, frees)
        runs, scatter = len(recording.tracks), np.full(3, np.nan)
        if runs >= MIN_RUNS:
            scatter = repeatability(recording.tracks) * math.sqrt(runs / (runs - 1))
        for axis in range(3):  # all frames of all runs along x, then y, then yaw
            sample.append(len(samples) + np.repeat(np.arange(len(sizes)), sizes))
            measured.append(poses[:, axis])
            known = bool(np.isfinite(scatter[axis]) and scatter[axis] > 0)
            sd = float(scatter[axis]) if known else 1 / math.sqrt(recording.repeats)
            samples += [(2 + axis, first + r, sd, known, size) for r, size in enumerate(sizes)]
        first += len(sizes)
        recordings.append(replayed)
    kind, run_of, sds, known_sds, count = (np.array(column) for column in zip(*samples, strict=True))
    elements = np.concatenate(measured), np.concatenate(sample).astype(np.intp)
    samples_of = (*elements, kind, run_of, sds, known_sds, count)
    return Experiment(robot, trials, tuple(frees), *samples_of, tuple(recordings), **options)


def _replayed(robot: Robot, recording: Recording, frees: Sequence[Free]) -> tuple[Replayed, Array, list[int]]:
    """Return what to replay, the tracked poses (frames, 3) seen from the first of each run, and the frames per run."""
    curve = smooth(recording.joints, noise=recording.noise)
    joints, step = joint_grid(robot, curve)
    time = recording.joints.time[0] + recording.time_offset + step * np.arange(len(joints) // 2 + 1)
    k = position(frees, "time_offset", recording.name)
    # for all time offsets the replay spans the last frame; before its first one the robot rests
    begin, end = time[0], time[-1]
    if k is not None and recording.moving:
        fix = "give its time_offset_s, or write begin = 'rest'"
        raise InputError("cannot be free where the runs begin in motion", key=frees[k].name, fix=fix)
    if k is not None:
        begin, end = -math.inf, end + min(0.0, frees[k].lower - recording.time_offset)
    times, turns, poses, replay_axes, sizes = [], [], [], [], []
    for name, track in zip(recording.runs, recording.tracks, strict=True):
        inside = (track.time >= begin) & (track.time <= end)
        if not inside.any():
            rule = f"must overlap the recording, {time[0]:g} to {time[-1]:g} s"
            value = f"{track.time[0]:g} to {track.time[-1]:g} s"
            fix = "put both on the same clock, or narrower bounds of time_offset"
            raise InputError(rule, file=recording.file, key=f"run {name}", value=value, fix=fix)
        heading = track.pose[0, 2]
        times.append(track.time[inside])
        turns.append(np.full(inside.sum(), heading - math.pi))
        poses.append(seen_from_start(track.pose, heading)[inside])
        replay_axes.append(seen_from_start(track.pose, math.pi)[inside])
        sizes.append(int(inside.sum()))
    frames = np.concatenate(times), np.concatenate(turns)
    begin_at, inexact = recording.begin(robot)
    period = 1 / beat_of(curve)[0]
    twist, error = begin_of(robot, joints, step, recording.tracks, begin_at, inexact, until=period)
    unknown = Unknown.of(replay_axes, begin_at, inexact)
    own = (joints, step, time, recording.time_offset, *frames, len(sizes), twist, error, unknown)
    replayed = Replayed(recording.name, *own)
    return replayed, np.concatenate(poses), sizes
