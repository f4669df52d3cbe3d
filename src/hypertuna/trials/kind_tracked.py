"""Recordings as a kind of trial: measured joint angles are replayed, and the head's poses are compared."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.swimming.model import core_model, parameter_names
from hypertuna.trials.comparison import repeatability
from hypertuna.trials.head_motion import LONGEST_STRIDE, speed_of
from hypertuna.trials.kind import FAILED, Kind, Point, Prediction, Quantity, Rows, Sample
from hypertuna.trials.manifest import Recording
from hypertuna.trials.plausibility import implausible_recording
from hypertuna.trials.replay import AXES, BORDER, joint_grid, replay_jacobian, seen_from_start
from hypertuna.trials.smoothing import SmoothSeries
from hypertuna.trials.start import UnknownBegin, beat_of, begin_of, between, fit_begin, head_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

TURN = math.radians(20)  # of a run, measured and computed, whose sides are compared
AGAINST = -0.8  # correlation of measured and computed yaw below which they are of opposite signs
MIN_RUNS = 4  # least number of runs whose scatter gives a recording's noise; otherwise the fit estimates it


@dataclass(frozen=True)
class TrackedRows(Rows):
    """Rows of a recording: its joint motion to replay, and the tracked poses at the frames of its runs."""

    recording: Recording
    curve: SmoothSeries  # smoothed joint angles
    joints: Array  # (2 * steps + 1, links, 3): joint motion of `joint_grid`
    step: float  # step of the replay [s]
    time: Array  # (steps + 1,) times of the replay's steps on the clock of the tracks [s]
    frames: Array  # (frames,) times of all runs' frames [s]
    turn: Array  # (frames,) rad: rotation from the axes of the replay to those of the run
    twist: Array | None  # (3,) initial twist of runs that begin in motion, given or guessed; None at rest
    error: Array  # (runs, 3): guessed errors of the first poses
    unknown: UnknownBegin | None  # unknown twist or first poses, which are fitted; None if all are known

    one_motion: ClassVar[bool] = True

    @property
    def uncertain(self) -> bool:
        """Whether the joint angles have noise."""
        return bool(self.curve.noise.any())

    def drawn(self, robot: Robot, rng: np.random.Generator) -> Self:
        """Return the rows with new random noise in the joint angles."""
        redrawn = replace(self.recording, joints=self.curve.drawn(rng))
        return replace(self, joints=joint_grid(robot, redrawn.smoothed())[0])

    def predict(self, at: Point) -> Prediction:
        """Return the computed poses at the frames of all runs, axis by axis."""
        frames, n = len(self.frames), at.count
        along = at.model_along if at.along is not None else at.model_along[:, :0]
        half = at.columns.get("links.length", at.robot.links.length)[0] / 2
        by_half = along[parameter_names(at.robot).index("links.length[0]")] / 2
        # frames are interpolated between two steps of the replay; before its start the robot rests
        offset = at.nuisances.get(f"time_offset[{self.recording.name}]")
        shift = 0.0 if offset is None else offset[1] - self.recording.time_offset
        clock = (self.frames - shift - self.time[0]) / self.step

        def replayed(twist: Array | None) -> tuple[Array, Array, Array]:
            pose, _, by = replay_jacobian(at.robot, self.joints, self.step, along, model=at.model, twist=twist)
            twist_columns = 0 if twist is None else 3
            by_head = by_half if twist is None else np.append(np.zeros(3), by_half)
            center, by = head_of(half, pose, by, by_head)
            at_frames, by = between(center, by, clock)
            if offset is not None and at.along is not None:
                before = np.clip(np.floor(clock).astype(int), 0, len(center) - 2)
                rate = (center[before + 1] - center[before]) / self.step * offset[2]
                by[:, :, twist_columns + offset[0]] = np.where((clock < 0)[:, np.newaxis], 0.0, -rate)
            return at_frames, by[..., :twist_columns], by[..., twist_columns:]

        if self.unknown is None:
            at_frames, _, by = replayed(self.twist)
        else:
            at_frames, by = fit_begin(self.unknown, replayed, self.twist, self.error, self._noise(at.levels))[2:]
        by = by if at.along is not None else np.zeros((frames, 3, n))
        runs = np.zeros(self.runs, dtype=bool)
        if not (np.isfinite(at_frames).all() and np.isfinite(by).all()):
            far = FAILED * np.array([at.robot.body.length, at.robot.body.length, 1.0])
            return Prediction(np.repeat(far, frames), np.zeros((3 * frames, n)), ~runs, runs, {})
        turn = self.turn
        rotation = np.stack([np.cos(turn), -np.sin(turn), np.sin(turn), np.cos(turn)], -1).reshape(-1, 2, 2)
        at_frames[:, :2] = np.einsum("fij,fj->fi", rotation, at_frames[:, :2])
        by[:, :2] = np.einsum("fij,fjn->fin", rotation, by[:, :2])
        return Prediction(at_frames.T.ravel(), np.moveaxis(by, 1, 0).reshape(3 * frames, n), runs, runs, {})

    def speed_errors(self) -> list[dict[int, float]]:
        """Return weights by element: the weighted sum of errors is the relative error of the runs' mean speed."""
        row: dict[int, float] = {}
        for run in range(self.runs):
            # the last frame's error along its displacement, over that displacement
            of_run = (k for k, sample in enumerate(self.samples) if sample.run == run and sample.quantity in ("x", "y"))
            last_frames = [int(np.flatnonzero(self.sample == k)[-1]) for k in of_run]
            distance = max(float(np.sum(self.measured[last_frames] ** 2)), 1e-300)
            row |= {k: self.measured[k] / distance / self.runs for k in last_frames}
        return [row]

    def _noise(self, levels: Mapping[str, float]) -> Array:
        """Return the standard deviation (3,) [m, m, rad] of a frame's pose, as the root mean square over runs."""
        level = {quantity.name: levels.get(quantity.name, quantity.level) for quantity in Tracked.quantities}
        sd = np.array([(1.0 if sample.known else level[sample.quantity]) * sample.sd for sample in self.samples])
        names = np.array([sample.quantity for sample in self.samples])
        return np.array([np.sqrt(np.mean(sd[names == axis] ** 2)) for axis in AXES])


class Tracked(Kind[Recording]):
    """Recordings: measured joint angles, and tracked poses of the runs with these joint angles."""

    trial = Recording
    key, label, others, transient = "recordings", "tracked recording", "motions", True
    nuisance = "time_offset"
    quantities = (
        Quantity("x", "m", "m", "cm", 100.0, 0.01, "tracks", "path"),
        Quantity("y", "m", "m", "cm", 100.0, 0.01, "tracks", "path"),
        Quantity("yaw", "rad", "deg", "deg", 1.0, 0.03, "tracks", per_si=180 / math.pi),
    )

    def runs(self, trial: Recording) -> tuple[str, ...]:
        """Return the names of a recording's runs, as RECORDING/RUN."""
        return trial.runs

    def only(self, trial: Recording, names: Collection[str]) -> Recording | None:
        """Return the recording with only the runs of some names, or None if it has none of them."""
        tracks = tuple(track for name, track in zip(trial.runs, trial.tracks, strict=True) if name in names)
        return replace(trial, tracks=tracks) if tracks else None

    def leaves_rigid(self, trial: Recording) -> bool:
        """Return whether the recording lacks the hinges' angles."""
        return not trial.hinges

    def motion(self, trial: Recording) -> dict[str, float]:
        """Return frequency and largest amplitude of the joint angles, and the mean speed from first to last frame."""
        frequency, amplitude = beat_of(trial.smoothed())
        amplitude = amplitude[: len(amplitude) - trial.hinges]
        ends = ((track.time, seen_from_start(track.pose, 0.0)[-1, :2]) for track in trial.tracks)
        speeds = [float(np.linalg.norm(end) / (time[-1] - time[0])) for time, end in ends]
        return {"frequency": frequency, "amplitude": float(amplitude.max()), "speed": float(np.mean(speeds))}

    def rows(self, robot: Robot, trials: Sequence[Recording], lowest: Mapping[str, float]) -> list[Rows]:
        """Return each recording's rows: x of all frames of all runs, then y, then yaw."""
        return [_rows(robot, recording, lowest.get(f"time_offset[{recording.name}]")) for recording in trials]

    def implausible(self, trials: Sequence[Recording], robot: Robot) -> tuple[list[InputError], list[str]]:
        """Return errors on recordings that must be in wrong units, and warnings on those that are unlikely."""
        results = [implausible_recording(recording, robot) for recording in trials]
        errors = [error for errors, _ in results for error in errors]
        warnings = [text for _, texts in results for text in texts]
        return errors, warnings if errors else [*warnings, *(text for one in trials for text in _against(one, robot))]

    def repeated(self, training: Sequence[Recording], validation: Sequence[Recording]) -> list[str]:
        """Return a warning if validation runs repeat joint motions of the training runs."""
        trained = {recording.name for recording in training}
        names = ", ".join(recording.name for recording in validation if recording.name in trained)
        text = (
            f"The validation runs of {names} repeat joint motions of the training runs: they separate "
            "noise from model error, but do not show how well other motions are predicted. Fit one recording and "
            "replay another to see that."
        )
        return [text] if names else []

    def cells(self, trial: Recording) -> tuple[str, str, str]:
        """Return the texts of a recording in a table: name, number of runs, and no speed."""
        return trial.name, f"{len(trial.tracks)} tracked runs", ""

    def picture(self, trials: Sequence[Recording]) -> str:
        """Return an SVG of the path of the first run."""
        from hypertuna.pictures import captioned, curve_svg

        track = trials[0].tracks[0]
        x, y = track.pose[:, :2].T
        return captioned(curve_svg(x, y, "y [m] over x [m]", equal=True), f"Run {track.run} from above.")

    def plot(self, trials: Sequence[Recording], *, width: float) -> Figure:
        """Return a figure of the paths of all runs from above."""
        from hypertuna.trials.plots_series import plot_paths

        return plot_paths(trials, width=width)

    def table(self, trials: Sequence[Recording]) -> pd.DataFrame:
        """Return a table with the duration [s] of each run."""
        import pandas as pd

        runs = {name: track for one in trials for name, track in zip(one.runs, one.tracks, strict=True)}
        return pd.DataFrame({"run": list(runs), "duration_s": [float(np.ptp(track.time)) for track in runs.values()]})

    def summaries(self, trials: Sequence[Recording], robot: Robot) -> list[dict[str, Any]]:
        """Return a summary of each recording: samples, frames, times [s] and repeatability."""
        return [_summary(recording) for recording in trials]

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Yield the lines of text of a recording's summary."""
        runs, frames, spread = len(summary["runs"]), sum(summary["frames"]), summary["repeatability"]
        yield f"{summary['name']}: recording of {runs} run{'s' * (runs != 1)}, {frames} frame{'s' * (frames != 1)}"
        for series, count in (("joints", f"{summary['joint_samples']} samples"), ("poses", "tracked")):
            begin, end = summary[f"{series}_s"]
            yield f"  {series}: {count} from {begin:.4g} to {end:.4g} s"
        axes = ", ".join(f"{axis.split('_')[0]} {spread[axis]:.2f} {axis.split('_')[1]}" for axis in spread)
        yield f"  repeatability: {axes if runs > 1 else 'not known, one run'}"
        moving = f"in motion, velocity {summary['velocity']}"
        yield f"  begin: {'at rest' if summary['begin'] == 'rest' else moving}"
        if summary["lag_s"]:
            lags = ", ".join(f"{1000 * lag:.0f}" for lag in summary["lag_s"])
            yield f"  joints lag behind their targets by {lags} ms"
        if summary["ended_by_a_wall"]:
            yield f"  ended near a wall: {', '.join(summary['ended_by_a_wall'])}"


def _against(recording: Recording, robot: Robot) -> list[str]:
    """Return warnings if the head of the first run goes too far a beat, or yaws or turns against the model's."""
    try:
        rows = _rows(robot, recording, None)
    except InputError:  # another part says what is wrong
        return []
    track, where = recording.tracks[0], {"file": recording.file, "key": f"run {recording.runs[0]}"}
    stride = speed_of(track.time, track.pose) / (beat_of(rows.curve)[0] * robot.body.length)
    if stride > LONGEST_STRIDE:
        rule, fix = (
            f"goes {stride:.3g} of the robot's lengths a beat, more than any swimmer",
            "check length_unit and time",
        )
        return [str(InputError(rule, **where, fix=fix))]
    point = Point(robot, core_model(robot), {}, None, 0, {}, {}, DEFAULT_STEPS, DEFAULT_STEPS, 1)
    computed = rows.predict(point).computed
    frames = slice(2 * len(rows.frames), 2 * len(rows.frames) + int((rows.sample == rows.sample[0]).sum()))
    clock = np.polynomial.polynomial.polyvander(np.linspace(-1, 1, frames.stop - frames.start), 2)
    courses = [np.linalg.lstsq(clock, yaw[frames])[0] for yaw in (rows.measured, computed)]
    pairs = zip((rows.measured, computed), courses, strict=True)
    beats = [yaw[frames] - clock @ course for yaw, course in pairs]
    sizes, turns = [float(np.linalg.norm(one)) for one in beats], [2 * float(course[1]) for course in courses]
    against = min(sizes) > 0 and beats[0] @ beats[1] < AGAINST * math.prod(sizes)
    if not against and not (min(map(abs, turns)) > TURN and turns[0] * turns[1] < 0):
        return []
    rule = f"{'yaws' if against else 'turns'} against the model, with the joint angles that it has"
    fix = "is yaw counted clockwise, do the joints count the other way, or is their clock half a beat off?"
    return [str(InputError(rule, **where, fix=fix))]


def _rows(robot: Robot, recording: Recording, lowest: float | None) -> TrackedRows:
    """Return a recording's rows: joint motion on the replay's grid, and poses seen from the first of each run.

    lowest: lower bound of a free time offset [s]; only frames that the replay spans for all allowed offsets are used.
    """
    curve = recording.smoothed()
    joints, step = joint_grid(robot, curve)
    time = recording.joints.time[0] + recording.time_offset + step * np.arange(len(joints) // 2 + 1)
    begin, end = time[0], time[-1]
    if lowest is not None and recording.moving:
        fix = "give its time_offset_s, or write begin = 'rest'"
        key = f"time_offset[{recording.name}]"
        raise InputError("cannot be free where the runs begin in motion", key=key, fix=fix)
    if lowest is not None:  # before the first frame of the replay the robot rests
        begin, end = -math.inf, end + min(0.0, lowest - recording.time_offset)
    times, turns, poses, replay_axes = [], [], [], []
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
    samples = _samples(recording, [len(clock) for clock in times])
    begin_at, inexact = recording.begin(robot)
    period = 1 / beat_of(curve)[0]
    twist, error = begin_of(robot, joints, step, recording.tracks, begin_at, inexact, until=period)
    measured = np.concatenate(poses).T.ravel()
    sample = np.repeat(np.arange(len(samples)), [one.count for one in samples])
    own = (recording, curve, joints, step, time, np.concatenate(times), np.concatenate(turns), twist, error)
    return TrackedRows(measured, sample, samples, len(times), *own, UnknownBegin.of(replay_axes, begin_at, inexact))


def _samples(recording: Recording, sizes: Sequence[int]) -> list[Sample]:
    """Return a sample for each axis and run, with the number of the run's frames."""
    runs, scatter = len(recording.tracks), np.full(3, np.nan)
    if runs >= MIN_RUNS:
        scatter = repeatability(recording.tracks) * math.sqrt(runs / (runs - 1))
    samples = []
    for axis, spread in zip(AXES, scatter.tolist(), strict=True):
        repeated = math.isfinite(spread) and spread > 0
        sd = spread if repeated else 1 / math.sqrt(recording.repeats)
        samples += [Sample(axis, run, sd, repeated, size) for run, size in enumerate(sizes)]
    return samples


def _summary(recording: Recording) -> dict[str, Any]:
    """Return the summary of a recording: samples, frames, times [s], repeatability, units in the names."""
    time, offset, tracks = recording.joints.time, recording.time_offset, recording.tracks
    borders = [(axis, *BORDER[unit]) for axis, unit in AXES.items()]
    scatter = zip(borders, repeatability(tracks), strict=True)
    spread = {f"{axis}_{unit}": size * factor for (axis, unit, factor), size in scatter}
    return {
        "name": recording.name,
        "file": recording.file,
        "joint_file": recording.joints.file,
        "joint_samples": len(time),
        "joints_s": [time[0] + offset, time[-1] + offset],
        "time_offset_s": offset,
        "runs": [track.run for track in tracks],
        "frames": [len(track.time) for track in tracks],
        "poses_s": [min(track.time[0] for track in tracks), max(track.time[-1] for track in tracks)],
        "repeatability": spread,
        "begin": "rest" if not recording.moving else "moving",
        "velocity": "given" if recording.velocity else "estimated" if recording.moving else "0",
        "lag_s": recording.lag,
        "ended_by_a_wall": recording.ended,
    }
