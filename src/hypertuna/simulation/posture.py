"""Test posture control as in the paper's Fig. 8: how soon peak bends reach the set angle, and which limits act."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.arrays import Array
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.description.schema.body import JointGroup
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.io.files import dataset
from hypertuna.ranges import POSITIVE
from hypertuna.simulation.plant import check_bend
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.twin import twins
from hypertuna.swimming.gait import Gait

if TYPE_CHECKING:
    import xarray as xr

MAX_ERROR = math.radians(0.5)  # rad: a peak bend with a smaller error has reached the set angle
RESOLUTION = math.radians(0.5)  # rad: to which the largest amplitude is found
TRIAL_TIME, TRIAL_BEATS = 8.0, 8  # length of the run that tries an amplitude: s or beats, whichever is longer
MAX_BEND = math.radians(45)  # rad: first trial if the description has no largest bend
EASED = 0.9  # fraction of the largest amplitude, to which joints are set that do not reach the set angle
STEP_DOWN = 0.8  # smallest ratio of a trial amplitude to the last one, which failed
MAX_FREQUENCIES = 100  # of one test
MAX_DURATION = 600.0  # s: longest run
HARMONICS = 3  # fitted to each beat of the bend sensor's readings
CURVE_POINTS = 360  # per beat, at which the fitted curve is evaluated


@dataclass(frozen=True)
class Held:
    """Result of one joint group at one frequency: its peak bends in each beat, the limits that acted, and the run."""

    joint: int  # index of the joint group
    frequency: float  # [Hz]
    angle_set: float  # peak bend commanded to both sides [rad]
    time: Array  # (beats,) end of each beat [s]
    peaks: Array  # (beats, 2) peak bend to the left and to the right, both positive [rad]
    measured: Array  # (beats, 2) peak bends by the bend sensor, from harmonics fitted to each beat [rad]
    limits: tuple[str, ...]  # names of the limits that acted in the last beats
    run: TwinRun

    @property
    def name(self) -> str:
        """Name of the joint group."""
        return self.run.robot.joints[self.joint].name

    @property
    def error(self) -> Array:
        """Larger error of the two peak bends of each beat (beats,) [rad]."""
        return np.asarray(np.abs(self.peaks - self.angle_set).max(axis=1))

    @property
    def error_measured(self) -> Array:
        """Larger error of the two peak bends of each beat (beats,) [rad], by the bend sensor."""
        return np.asarray(np.abs(self.measured - self.angle_set).max(axis=1))

    @property
    def settling(self) -> float | None:
        """Time after which the error stays below half a degree [s]; None if that does not happen."""
        return _settling(self.time, self.error)

    @property
    def settling_measured(self) -> float | None:
        """As `settling`, but with the error by the bend sensor [s]."""
        return _settling(self.time, self.error_measured)


class Reach(NamedTuple):
    """Largest amplitude that a joint group holds at a frequency, and the limits that prevent a larger one."""

    joint: int
    frequency: float  # [Hz]
    amplitude_max: float  # [rad]
    limits: tuple[str, ...]  # names of the limits that acted at the smallest amplitude not held


@dataclass(frozen=True)
class PostureTest(Plotted, Tabular):
    """Result of the paper's Fig. 8, computed: joints commanded to a set angle at several frequencies."""

    robot: Robot
    medium: str  # "air" or "water"
    angle: Array  # (groups,) set angle of each joint group [rad]; those with 0 stay straight
    duration: float  # duration of each run [s]
    held: tuple[Held, ...]  # a result for each frequency and moving joint group, in order of frequency
    reach: tuple[Reach, ...]  # in the order of `held`; empty if not asked for
    eased: tuple[Held, ...]  # runs at 90 % of the largest amplitude, for joints that do not reach the set angle
    seed: int
    temperature: float  # oil temperature [K]

    @property
    def cases(self) -> list[tuple[Held, Reach | None, Held | None]]:
        """For each joint and frequency: the run at the set angle, the largest amplitude, and the eased run, if made."""
        reach = {(held.joint, held.frequency): held for held in self.reach}
        eased = {(held.joint, held.frequency): held for held in self.eased}
        keys = [(held.joint, held.frequency) for held in self.held]
        return [(held, reach.get(key), eased.get(key)) for held, key in zip(self.held, keys, strict=True)]

    def dataset(self) -> xr.Dataset:
        """Return the result as a data set with dimensions frequency, joint, beat and side."""
        frequencies = list(dict.fromkeys(held.frequency for held in self.held))
        joints = list(dict.fromkeys(held.joint for held in self.held))
        shape = (len(frequencies), len(joints), max(len(held.time) for held in self.held))
        time, settling, largest = (np.full(size, np.nan) for size in (shape, shape[:2], shape[:2]))
        peaks, measured = (np.full((*shape, 2), np.nan) for _ in range(2))
        for held in self.held:
            cell = (frequencies.index(held.frequency), joints.index(held.joint))
            beats = len(held.time)
            time[cell][:beats], peaks[cell][:beats], measured[cell][:beats] = held.time, held.peaks, held.measured
            settling[cell] = np.nan if held.settling is None else held.settling
        for limit in self.reach:
            largest[frequencies.index(limit.frequency), joints.index(limit.joint)] = limit.amplitude_max
        grid, beat = ("frequency", "joint"), ("frequency", "joint", "beat")
        variables = {
            "time": (beat, time, "s", "end of the beat"),
            "peak": ((*beat, "side"), peaks, "rad", "peak bend to each side"),
            "peak_measured": ((*beat, "side"), measured, "rad", "peak bend to each side by the bending sensor, fitted"),
            "settling": (grid, settling, "s", "time after which the error stays below 0.5 deg"),
            "reach": (grid, largest, "rad", "largest amplitude that is held"),
        }
        coordinates = {
            "frequency": ("frequency", frequencies, "Hz", "beat frequency"),
            "joint": ("joint", [self.robot.joints[j].name for j in joints]),
            "set_angle": ("joint", self.angle[joints], "rad", "angle set to either side"),
            "side": ("side", list(SIDES)),
        }
        facts = {"medium": self.medium, "duration_s": self.duration, "seed": self.seed}
        return dataset(variables, coordinates, provenance(self.robot) | facts)


def posture_test(
    robot: Robot,
    *,
    frequencies: Sequence[float],
    angle: Sequence[float],
    duration: float = 8.0,
    medium: str = "air",
    temperature: float | None = None,
    seed: int = 0,
    limits: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> PostureTest:
    """Test posture control as in the paper's Fig. 8: run joints from rest to a set angle, at several frequencies.

    `frequencies` [Hz], `angle` (groups,) [rad], `duration` [s], `temperature` [K].
    """
    _check(robot, frequencies, angle, duration)
    moving = sum(value > 0 for value in angle)
    conditions: Any = {"medium": medium, "temperature": temperature, "seed": seed}
    total = len(frequencies) * (1 + moving * limits)
    held = _hold(robot, [Request(f, tuple(angle), duration) for f in frequencies], **conditions)
    largest: list[Reach] = []
    if limits:
        report = None if progress is None else lambda done: progress(len(frequencies) + done, total)
        largest = _reach(robot, [(one.joint, one.frequency) for one in held], report, **conditions)
    retries = [
        Request(one.frequency, _alone(robot, one.joint, EASED * limit.amplitude_max), duration)
        for one, limit in zip(held, largest, strict=False)
        if one.settling is None and one.angle_set > limit.amplitude_max > 0
    ]
    eased = _hold(robot, retries, **conditions)
    if progress is not None:
        progress(total, total)
    parts = tuple(held), tuple(largest), tuple(eased)
    return PostureTest(robot, medium, np.array(angle), duration, *parts, seed, held[0].run.temperature)


def hold(robot: Robot, frequency: float, angle: Sequence[float], *, duration: float, **options: Any) -> list[Held]:
    """Run joints at set angles and one frequency, and measure their peak bends; options are those of `twin`."""
    return _hold(robot, [Request(frequency, tuple(angle), duration)], **options)


class Request(NamedTuple):
    """Request for a run: frequency, angle of each joint group, and duration."""

    frequency: float  # [Hz]
    angle: tuple[float, ...]  # (groups,) [rad]
    duration: float  # [s]


def _hold(robot: Robot, requests: Sequence[Request], **options: Any) -> list[Held]:
    """Make the requested runs, and measure the peak bends of all joints that they move; options are those of `twin`."""
    gaits = [Gait(request.frequency, request.angle, (0.0,) * len(request.angle)) for request in requests]
    runs = [
        {"robot": robot, "gait": gait, "duration": request.duration, **options}
        for request, gait in zip(requests, gaits, strict=True)
    ]
    return [held for measured in twins(runs, measure=_held) for held in measured]


def _held(run: TwinRun) -> list[Held]:
    """Return a `Held` for each joint that a run moves."""
    held = []
    for joint, angle in enumerate(run.gait.amplitude):
        if angle > 0:
            time, peaks = peak_bends(run.time, run.data["angle"][:, joint], run.gait.frequency)
            _, measured = fitted_peaks(run.time, run.data["angle_measured"][:, joint], run.gait.frequency)
            held.append(Held(joint, run.gait.frequency, angle, time, peaks, measured, run.limits, run))
    return held


def _alone(robot: Robot, joint: int, angle: float) -> tuple[float, ...]:
    """Return angles (groups,) [rad] with one joint group at `angle` and the others at 0."""
    return tuple(angle if j == joint else 0.0 for j in range(len(robot.joints)))


def reach(robot: Robot, joint: int, frequency: float, *, medium: str = "air", **options: Any) -> Reach:
    """Return the largest amplitude that a joint group holds at a frequency [Hz], the others kept straight.

    An amplitude is held if in a run of 8 s and 8 beats the mean peak bend of the last second and beat is within 0.5 deg
    of it. Trials start from the largest bend of the description and step down to one that is held; bisection follows.
    """
    return _reach(robot, [(joint, frequency)], None, medium=medium, **options)[0]


def _reach(
    robot: Robot, cases: Sequence[tuple[int, float]], report: Callable[[int], None] | None, **options: Any
) -> list[Reach]:
    """Find the largest amplitude for each case (joint, frequency); trials of all cases run at the same time."""
    searches = [_search(robot.joints[joint]) for joint, _ in cases]
    results: dict[int, Reach] = {}
    answers: dict[int, Held | None] = dict.fromkeys(range(len(cases)))
    while answers:
        trials: dict[int, Request] = {}
        for k, held in answers.items():
            joint, frequency = cases[k]
            try:
                angle = _alone(robot, joint, searches[k].send(held))
                trials[k] = Request(frequency, angle, max(TRIAL_TIME, TRIAL_BEATS / frequency))
            except StopIteration as end:
                results[k] = Reach(joint, frequency, *end.value)
        if report is not None:
            report(len(results))
        answers = dict(zip(trials, _hold(robot, list(trials.values()), **options), strict=True))
    return [results[k] for k in range(len(cases))]


def _search(group: JointGroup) -> Generator[float, Any, tuple[float, tuple[str, ...]]]:
    """Search the largest amplitude: yield one to try, receive its `Held`; return the largest held, and its limits."""
    low, high = 0.0, math.inf
    trial = group.bend_max or group.amplitude_max or MAX_BEND
    limits: tuple[str, ...] = ()
    while high - low > RESOLUTION and trial > RESOLUTION:
        held = yield trial
        settled_beats = held.time >= max(held.time, default=0.0) - max(1.0, 1.5 / held.frequency)
        reached = float(held.peaks[settled_beats].mean()) if settled_beats.any() else math.nan
        if held.run.status != "diverged" and abs(reached - trial) < MAX_ERROR:
            low = trial
            if math.isinf(high):
                break  # the first trial, the largest amplitude that may be tried, was held
        else:
            high, limits = trial, held.limits
        lower = min(reached + MAX_ERROR / 2, trial - RESOLUTION) if math.isfinite(reached) else 0.0
        trial = (low + high) / 2 if low > 0 else max(lower, STEP_DOWN * trial)
    return low, limits


def peak_bends(time: Array, angle: Array, frequency: float) -> tuple[Array, Array]:
    """Return the end of each beat [s] and its peak bends to both sides [rad], refined by a parabola.

    `time` (times,) [s], `angle` (times,) [rad], `frequency` [Hz]; returns `end` (beats,) [s], `peaks` (beats, 2) [rad].
    """
    end, edges = _beats(time, frequency)
    peaks = [
        [_top(signed, first + int(signed[first:last].argmax())) for signed in (angle, -angle)]
        for first, last in pairwise(edges)
    ]
    return end, np.reshape(peaks, (len(end), 2))


def fitted_peaks(time: Array, angle: Array, frequency: float) -> tuple[Array, Array]:
    """Return the end of each beat [s] and its peak bends [rad], from mean and harmonics fitted to noisy readings.

    The largest of noisy readings would be too large: by 0.2 deg for HyperTuna's sensor at 1 Hz. With noise s in each of
    n readings, the fitted curve's noise is s sqrt(7 / n). Arguments and results are those of `peak_bends`.
    """
    end, edges = _beats(time, frequency)
    peaks = np.empty((len(end), 2))
    for beat, (first, last) in enumerate(pairwise(edges)):
        order = max(1, min(HARMONICS, (last - first - 1) // 3))
        phase = 2 * math.pi * frequency * (time[first:last] - time[first])
        weights = np.linalg.lstsq(_harmonics(phase, order), angle[first:last], rcond=None)[0]
        curve = _harmonics(np.linspace(0, 2 * math.pi, CURVE_POINTS), order) @ weights
        peaks[beat] = curve.max(), -curve.min()
    return end, peaks


def _beats(time: Array, frequency: float) -> tuple[Array, NDArray[np.int_]]:
    """Return the end of each beat (beats,) [s], and the indices of samples where beats begin and end (beats + 1,)."""
    if len(time) < 2:  # the run diverged at once
        return np.empty(0), np.zeros(1, dtype=int)
    step = time[1] - time[0]
    beats = int((time[-1] - time[0]) * frequency + 1e-9)
    edges = np.round(np.arange(beats + 1) / (frequency * step)).astype(int)
    return time[0] + edges[1:] * step, edges


def _harmonics(phase: Array, order: int) -> Array:
    """Return the design matrix (instants, 2 order + 1) of 1, cosines and sines of a phase [rad]."""
    turns = np.outer(phase, np.arange(1, order + 1))
    return np.column_stack([np.ones_like(phase), np.cos(turns), np.sin(turns)])


def _top(values: Array, k: int) -> float:
    """Return the top of the parabola through sample k and its neighbors; the sample itself if no local maximum."""
    if not 0 < k < len(values) - 1:
        return float(values[k])
    left, center, right = values[k - 1 : k + 2]
    curve = left - 2 * center + right
    if not (curve < 0 and center >= left and center >= right):
        return float(center)
    return float(center - (left - right) ** 2 / (8 * curve))


def _settling(time: Array, error: Array) -> float | None:
    """Return the end of the first beat after which all errors are small [s]; None if the last beat's error is large."""
    too_large = np.flatnonzero(~(error < MAX_ERROR))  # NaN counts as too large
    first = too_large[-1] + 1 if too_large.size else 0
    return None if first == len(time) else float(time[first])


def _check(robot: Robot, frequencies: Sequence[float], angle: Sequence[float], duration: float) -> None:
    """Check frequencies, angles and duration of a test: every run must have at least two beats."""
    if len(angle) != len(robot.joints):
        names = ", ".join(group.name for group in robot.joints)
        rule, fix = f"must be {len(robot.joints)} values, for joint groups {names}", "give one angle for each"
        raise InputError(rule, key="angle", value=f"{len(angle)} long", fix=fix)
    if not any(value > 0 for value in angle) or min(angle) < 0:
        value = ", ".join(f"{math.degrees(a):g}" for a in angle)
        raise InputError("must have one angle above 0, and none below", key="angle", value=f"{value} deg")
    for group, bend in zip(robot.joints, angle, strict=True):
        check_bend(group, bend, "angle")
    if not 1 <= len(frequencies) <= MAX_FREQUENCIES:
        rule = f"must be 1 to {MAX_FREQUENCIES} values"
        raise InputError(rule, key="frequency", value=f"{len(frequencies)} long", fix="ask for fewer")
    for frequency in frequencies:
        POSITIVE.check(frequency, "frequency", "give it in Hz")
        if not 2 / frequency <= duration <= MAX_DURATION:
            rule, value = f"must be from two beats to {MAX_DURATION:g} s", f"{duration:g} s at {frequency:g} Hz"
            raise InputError(rule, key="duration", value=value, fix=f"give {max(8.0, 4 / frequency):g}")
