"""Decays as kinds of trial: the speed of a glide, and the yaw rate of a turn on the spot."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.model import core_model, parameter_names
from hypertuna.trials.decay import Decay, Glide, YawDecay
from hypertuna.trials.kind import FAILED, Kind, Point, Prediction, Quantity, Rows, Sample
from hypertuna.trials.plausibility import FAR

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

D = TypeVar("D", bound=Decay)
STEPS = 1000  # per decay; the error of linear interpolation between them is 1e-6 of the first value
DIFFERENCE_STEP = 1e-4  # relative change of the first value for central differences
SLOW = 0.25  # part of the first value, at which the rate of a decay is taken
COASTED = 10.0  # lengths, or rad, that a decay of the model is computed for
STOP, USUAL = 0.3, 6.0  # of the first value, and usual drops, that make one drop a sudden stop
RISE, STEADY = 0.25, 0.98  # parts of the largest value: a rise beyond noise, an end that is not slower
ITERATIONS, TOLERANCE = 30, 1e-12  # Gauss-Newton iterations for the first value, and relative change that ends them


@dataclass(frozen=True)
class DecayRows(Rows):
    """Rows of a decay, computed from the first value that fits the measured rows best."""

    time: Array  # (rows,) from the first one [s]
    axis: int  # component of the pose's rate: 0 for x, 2 for the heading
    begin: Array  # (3,): initial twist per unit of the first value, whose sign is that of its `axis`

    def predict(self, at: Point) -> Prediction:
        """Return the computed values and their Jacobian, which includes the change of the best first value."""
        along = at.model_along
        step = self.time[-1] / STEPS
        sign, no_flag = math.copysign(1.0, self.begin[self.axis]), np.zeros(1, dtype=bool)

        def decay(first: float) -> tuple[Array, Array, Array]:
            track = _coasted(at.robot, at.model, along, step, first * self.begin)
            values = np.column_stack([track["rate"][:, self.axis], track["rate_gradient"][:, self.axis]])
            place = np.clip(self.time / step, 0, STEPS)
            before = np.minimum(place.astype(int), STEPS - 1)
            at_rows = sign * (values[before] + (place - before)[:, np.newaxis] * (values[before + 1] - values[before]))
            return at_rows[:, 0], at_rows[:, 1:4] @ self.begin, at_rows[:, 4:]

        first = float(self.measured[0])
        for _ in range(ITERATIONS):
            computed, by_first, by = decay(first)
            change = float(by_first @ (self.measured - computed) / (by_first @ by_first))
            if not np.isfinite(computed).all() or not abs(change) > TOLERANCE * abs(first):
                break
            first += change
        if not np.isfinite(computed).all() or not np.isfinite(by).all():
            far = np.full(len(self.time), FAILED * np.abs(self.measured).max())
            return Prediction(far, np.zeros((len(far), at.count)), ~no_flag, no_flag, {})
        # implicit derivative: the best first value keeps the residual orthogonal to its own derivative
        size = DIFFERENCE_STEP * max(abs(first), 1e-300)
        (_, low, by_low), (_, high, by_high) = decay(first - size), decay(first + size)
        residual = self.measured - computed
        curvature, curves = (residual @ (high - low) / (2 * size), residual @ (by_high - by_low) / (2 * size))
        shift = (curves - by_first @ by) / (by_first @ by_first - curvature)
        return Prediction(computed, by + np.outer(by_first, shift), no_flag, no_flag, {})


def _coasted(robot: Robot, model: _core.Model, along: Array, step: float, twist: Array) -> dict[str, Array]:
    """Return the track of a robot that coasts straight from a twist (3,) of the nose, for STEPS steps [s]."""
    joints = np.zeros((2 * STEPS + 1, len(robot.links.name), 3))
    return _core.track(model, joints, along, step=step, twist=twist, rates=True)


class Decays(Kind[D]):
    """Base of glides and turns on the spot: decays of a straight body."""

    transient = True
    axis: ClassVar[int]

    @abstractmethod
    def begin(self, robot: Robot) -> Array:
        """Return the twist (3,) of the nose for a first value of 1 [m/s or rad/s]."""

    def motion(self, trial: D) -> dict[str, float]:
        """Return {}: a decay has no beat."""
        return {}

    def rows(self, robot: Robot, trials: Sequence[D], lowest: Mapping[str, float]) -> list[Rows]:
        """Return each decay's rows: a sample per row if the standard deviation is stated, otherwise one in all."""
        return [self._laid_out(robot, trial) for trial in trials]

    def _laid_out(self, robot: Robot, trial: D) -> DecayRows:
        name, count = self.quantities[0].name, len(trial.time)
        sample, samples = np.zeros(count, dtype=int), [Sample(name, 0, 1.0, False, count)]
        if trial.sd is not None:
            sample, samples = np.arange(count), [Sample(name, 0, trial.sd, True, 1)] * count
        motion = (trial.time - trial.time[0], self.axis, self.begin(robot))
        return DecayRows(trial.value, sample, samples, 1, *motion)

    def implausible(self, trials: Sequence[D], robot: Robot) -> tuple[list[InputError], list[str]]:
        """Return no errors, but a warning for each decay that rises, stops at once, or is far from the model's."""
        warnings = []
        for trial in trials:
            doubts = [*_rises(trial), *_stops(trial), *self._too_fast(trial, robot)]
            fixes = (str(InputError(rule, file=trial.file, key=f"run {trial.name}", fix=fix)) for rule, fix in doubts)
            warnings += [*fixes][:1]
        return [], warnings

    def _too_fast(self, trial: D, robot: Robot) -> list[tuple[str, str]]:
        """Return a doubt about a decay whose 1/value grows at another rate than the model's by a factor of FAR."""
        level = np.abs(_smooth(trial.value))
        slower = np.flatnonzero(level < SLOW * level[0])
        k = int(slower[0]) if len(slower) else len(level) - 1  # before noise is all that is left
        first, last, seconds = float(level[0]), float(level[k]), float(trial.time[k + 1] - trial.time[1])
        if not 0 < last < first:
            return []
        size = robot.body.length if self.axis == 0 else 1.0
        span = min(seconds, COASTED * size / first)  # the model's rate is that of its first lengths or radians
        along = np.zeros((len(parameter_names(robot)), 0))
        track = _coasted(robot, core_model(robot), along, span / STEPS, first * self.begin(robot))
        end = abs(float(track["rate"][-1, self.axis]))
        if not (math.isfinite(end) and 0 < end < first):
            return []
        ratio = (1 / last - 1 / first) / seconds / ((1 / end - 1 / first) / span)
        if 1 / FAR <= ratio <= FAR:
            return []
        rule = f"decays at {ratio:.2g} times the rate of the model"
        return [(rule, f"likely causes are another unit than s and {self.shown}, or a wrong area or mass of the robot")]

    def repeated(self, training: Sequence[D], validation: Sequence[D]) -> list[str]:
        """Return a warning if decays are in both sets, since all decays are one motion except for the first value."""
        text = f"The validation runs that are {self.label}s are of the motion of those of the training."
        return [text] if training and validation else []

    def cells(self, trial: D) -> tuple[str, str, str]:
        """Return the texts of a decay in a table: name, number of rows and first value."""
        from hypertuna.display import number

        quantity = self.quantities[0]
        return trial.name, f"{len(trial.time)} rows", number(float(trial.value[0]) * quantity.per_si, self.shown)

    @property
    def shown(self) -> str:
        """Unit of the decay's values in its file."""
        return "deg/s" if self.quantities[0].error == "deg_s" else "m/s"

    def picture(self, trials: Sequence[D]) -> str:
        """Return an SVG of the first decay over time."""
        from hypertuna.pictures import captioned, curve_svg

        quantity, decay = self.quantities[0], trials[0]
        label = f"{quantity.label} [{self.shown}] over time [s]"
        return captioned(curve_svg(decay.time, quantity.per_si * decay.value, label, dots=True), f"Run {decay.name}.")

    def plot(self, trials: Sequence[D], *, width: float) -> Figure:
        """Return a figure of the decays over time."""
        from matplotlib.figure import Figure

        from hypertuna.figures import COLORS

        figure = Figure(figsize=(width, 0.5 * width + 0.6), layout="constrained")
        axes, label = figure.subplots(), f"{self.quantities[0].label} [{self.shown}]"
        for k, decay in enumerate(trials):
            color, name = COLORS[k % len(COLORS)], f"run {decay.name}"
            axes.plot(decay.time, decay.per_si * decay.value, ".", color=color, label=name)
        axes.set(xlabel="time [s]", ylabel=label, title=f"{len(trials)} {self.label}s")
        return figure

    def table(self, trials: Sequence[D]) -> pd.DataFrame:
        """Return a table with the duration [s] of each decay."""
        import pandas as pd

        durations = [float(np.ptp(one.time)) for one in trials]
        return pd.DataFrame({"run": [one.name for one in trials], "duration_s": durations})

    def summaries(self, trials: Sequence[D], robot: Robot) -> list[dict[str, Any]]:
        """Return a summary of each decay: number of rows, duration [s], minimum and maximum."""
        quantity, results = self.quantities[0], []
        for trial in trials:
            ends = [float(quantity.per_si * value) for value in (trial.value.min(), trial.value.max())]
            sd = None if trial.sd is None else quantity.per_si * trial.sd
            head = {"name": trial.name, "file": trial.file, "rows": len(trial.time)}
            head |= {"time_s": [float(trial.time[0]), float(trial.time[-1])]}
            results.append(head | {trial.columns["value"]: ends, trial.columns["sd"]: sd})
        return results

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Yield the lines of text of a decay's summary."""
        yield f"{summary['name']}: {self.label} of {summary['rows']} rows"
        for name, span in summary.items():
            if isinstance(span, list):
                yield f"  {name}: {span[0]:.4g} to {span[1]:.4g}"
            elif name not in ("name", "file", "rows"):
                yield f"  {name}: {'not given' if span is None else f'{span:.4g}'}"


def _smooth(value: Array) -> Array:
    """Return the medians of 3 neighbors, without the two ends."""
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(value, 3), axis=1))


def _rises(trial: Decay) -> list[tuple[str, str]]:
    """Return a doubt about a decay that does not get slower, or has another sign than a body that swims ahead."""
    level = _smooth(trial.value)
    if isinstance(trial, Glide) and np.median(level) < 0:
        return [("moves backward", "give speeds that are positive where the head leads")]
    level = np.abs(level)
    rise = level - np.minimum.accumulate(level)
    k, most = int(np.argmax(rise)), float(rise.max())
    if most > RISE * level.max():
        fix = "leave out the rows before the body was let go, and give each run a name in a column run"
        return [(f"gets faster until {trial.time[k + 1]:.4g} s", fix)]
    if level[-1] > STEADY * level[0]:
        return [("does not slow down", "give the run until the body has slowed down")]
    return []


def _stops(trial: Decay) -> list[tuple[str, str]]:
    """Return a doubt about a decay that stops at once, as at a wall or at the end of a tether."""
    drop = -np.diff(np.abs(trial.value))
    k = int(np.argmax(drop))
    late = k > 0 and drop[k] > STOP * abs(float(trial.value[0])) and drop[k] > USUAL * float(np.median(np.abs(drop)))
    if not late or abs(float(trial.value[k + 1])) > STOP * abs(float(trial.value[k])):
        return []
    fix = "did it touch a wall, or was it stopped? Leave out the rows from there on"
    return [(f"stops at once at {trial.time[k + 1]:.4g} s", fix)]


class Glides(Decays[Glide]):
    """Glides."""

    trial = Glide
    key, label, others, axis = "glides", "glide", "glides from other speeds", 0
    quantities = (Quantity("glide_speed", "m/s", "m_s", "cm/s", 100.0, 0.005, "glides"),)

    def begin(self, robot: Robot) -> Array:
        """Return the twist (3,) of a glide of 1 m/s: the head leads, toward -x."""
        return np.array([-1.0, 0.0, 0.0])


class YawDecays(Decays[YawDecay]):
    """Decaying turns on the spot."""

    trial = YawDecay
    key, label, others, axis = "yaw_decays", "yaw decay", "yaw decays from other rates", 2
    quantities = (Quantity("yaw_rate", "rad/s", "deg_s", "deg/s", 1.0, 0.02, "yaw decays", per_si=180 / math.pi),)

    def begin(self, robot: Robot) -> Array:
        """Return the twist (3,) of the nose for a turn of 1 rad/s about the center of mass."""
        mass = np.array(robot.links.mass)
        front = np.concatenate([[0.0], np.cumsum(robot.links.length)[:-1]])
        return np.array([0.0, -float(mass @ (front + np.array(robot.links.com)) / mass.sum()), 1.0])
