"""Kinds of trial whose runs are one measured number each: drag, thrust, power or rate of turn."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.beat import DEFAULT_STEPS, directional_derivatives, settle
from hypertuna.swimming.gait import Gait, Gaits, gait_text
from hypertuna.swimming.model import core_model
from hypertuna.trials.kind import (
    FAILED,
    Kind,
    Point,
    Prediction,
    Quantity,
    Rows,
    Sample,
    evenly_spaced,
    span_lines,
    spans,
)
from hypertuna.trials.kind_steady import UNSTABLE, USABLE, with_cost_factor
from hypertuna.trials.numbers import HeldThrust, NumberRun, PowerRun, Tow, TurnRun
from hypertuna.trials.plausibility import FAR, FEW

if TYPE_CHECKING:
    from matplotlib.figure import Figure

R = TypeVar("R", bound=NumberRun)
DRAG_POWERS = (1.3, 3.0)  # of the speed: drag grows by about its square


@dataclass(frozen=True)
class HeldRows(Rows):
    """Rows of runs whose head is towed or held on a straight path, and of which the mean force was measured."""

    gaits: tuple[Gait, ...]
    u: Array  # (runs,): speed of the head through the water [m/s]
    sign: float  # 1 if a positive number is a force toward the head (thrust), -1 for drag

    def predict(self, at: Point) -> Prediction:
        """Return the computed mean force of every run [N]."""
        options: dict[str, Any] = {"steps": at.steps if at.along is None else at.gradient_steps, "threads": at.threads}
        rows = _core.held(at.model, *Gaits.of(self.gaits).columns, self.u, at.model_along, **options)
        none = np.zeros(self.runs, dtype=bool)
        return Prediction(self.sign * rows[:, 0], self.sign * rows[:, 1:], none, none, {})


@dataclass(frozen=True)
class BeatRows(Rows):
    """Rows of runs with settled gaits of which one quantity was measured."""

    gaits: tuple[Gait, ...]
    quantity: str  # name of the measured quantity of a settled beat

    def predict(self, at: Point) -> Prediction:
        """Return the computed quantity of every run."""
        gaits, jacobian = Gaits.of(self.gaits), np.zeros((self.runs, at.count))
        beats = settle(at.robot, gaits, model=at.model, steps=at.steps, threads=at.threads)
        value = beats[self.quantity]
        usable = np.isin(beats["status"], USABLE) & np.isfinite(value) & (value != 0)
        if at.along is not None:
            with np.errstate(all="ignore"):  # gaits without a settled beat have no derivatives
                options: dict[str, Any] = {"model": at.model, "steps": at.gradient_steps, "threads": at.threads}
                slopes = directional_derivatives(at.robot, gaits, beats, at.along, **options)[self.quantity]
            jacobian = np.where(usable[:, np.newaxis] & np.isfinite(slopes), slopes, 0.0)
        if self.quantity == "mechanical_power":
            value, jacobian = with_cost_factor(at, value, jacobian, usable)
        value = np.where(usable, value, FAILED * np.maximum(np.abs(self.measured), self.sd))
        return Prediction(value, jacobian, ~usable, usable & (beats["status"] == UNSTABLE), {})


class Numbers(Kind[R]):
    """Base of the kinds whose runs are one measured number each."""

    def motion(self, trial: R) -> dict[str, float]:
        """Return frequency [Hz] and largest amplitude [rad] of a run's gait; {} for a straight body."""
        gait = trial.gait
        return {} if gait is None else {"frequency": gait.frequency, "amplitude": max(gait.amplitude)}

    def laid_out(self, trials: Sequence[R]) -> tuple[Array, NDArray[np.intp], list[Sample], int]:
        """Return the first four fields of `Rows` for these runs: values, sample indices, samples, number of runs."""
        name = self.quantities[0].name
        deviations = [(abs(run.value) if run.sd is None else run.sd) / math.sqrt(run.repeats) for run in trials]
        samples = [Sample(name, k, deviation, trials[k].sd is not None, 1) for k, deviation in enumerate(deviations)]
        return np.array([run.value for run in trials]), np.arange(len(trials)), samples, len(trials)

    def part(self, trials: Sequence[R], count: int) -> Sequence[R]:
        """Return about `count` evenly spaced runs for a rough search."""
        return evenly_spaced(trials, count)

    def implausible(self, trials: Sequence[R], robot: Robot) -> tuple[list[InputError], list[str]]:
        """Return no errors, but a warning for each file whose numbers are far from the model's or of the other sign."""
        point = Point(robot, core_model(robot), {}, None, 0, {}, {}, DEFAULT_STEPS, DEFAULT_STEPS, 1)
        one, warnings = self.quantities[0], []
        for file in dict.fromkeys(run.file for run in trials):
            rows = self.rows(robot, [run for run in trials if run.file == file], {})[0]
            ratio = float(np.median(rows.measured / rows.predict(point).computed))
            if not math.isfinite(ratio) or 1 / FAR <= ratio <= FAR:
                continue
            rule = f"are {ratio:.2g} times those of the model"
            fix = f"likely causes are another unit than {one.unit}, the sign of the gauge, or a wrong area of the robot"
            warnings.append(str(InputError(rule, file=file, key=f"the measured values of {one.label}", fix=fix)))
        return [], warnings

    def repeated(self, training: Sequence[R], validation: Sequence[R]) -> list[str]:
        """Return a warning if validation runs repeat training runs."""
        trained = {(run.gait, run.u) for run in training}
        count = sum((run.gait, run.u) in trained for run in validation)
        text = f"{count} of {len(validation)} validation runs that are {self.label}s repeat those of the training."
        return [text] if count else []

    def cells(self, trial: R) -> tuple[str, str, str]:
        """Return the texts of a run in a table: name, gait and speed."""
        from hypertuna.display import number

        gait = "straight" if trial.gait is None else gait_text(trial.gait)
        return trial.name, gait, number(trial.u, "m/s") if "u" in trial.columns else ""

    def axis(self, trials: Sequence[R]) -> tuple[list[float], str]:
        """Return the abscissas of a figure (speeds or frequencies) and their label."""
        if any(run.gait is None for run in trials):
            return [run.u for run in trials], "speed [m/s]"
        return [run.gait.frequency for run in trials if run.gait], "frequency [Hz]"

    def picture(self, trials: Sequence[R]) -> str:
        """Return an SVG of the measured numbers over speed or frequency."""
        from hypertuna.pictures import captioned, curve_svg

        one, (x, x_label) = self.quantities[0], self.axis(trials)
        dots = curve_svg(x, [run.value for run in trials], f"{one.label} [{one.unit}] over {x_label}", dots=True)
        return captioned(dots, f"Each dot is a {self.label}.")

    def plot(self, trials: Sequence[R], *, width: float) -> Figure:
        """Return a figure of the measured values over speed or frequency."""
        from matplotlib.figure import Figure

        from hypertuna.figures import COLORS, POINTS

        figure = Figure(figsize=(width, 0.5 * width + 0.6), layout="constrained")
        axes, quantity, (x, over) = figure.subplots(), self.quantities[0], self.axis(trials)
        deviations = [run.sd or 0.0 for run in trials]
        axes.errorbar(x, [run.value for run in trials], deviations, fmt="o", color=COLORS[1], elinewidth=1, **POINTS)
        axes.set(xlabel=over, ylabel=f"{quantity.label} [{quantity.unit}]", title=f"{len(trials)} {self.label}s")
        return figure

    def summaries(self, trials: Sequence[R], robot: Robot) -> list[dict[str, Any]]:
        """Return a summary of each file: minimum and maximum of its measured numbers and gaits."""
        results = []
        for file in dict.fromkeys(run.file for run in trials):
            runs = [run for run in trials if run.file == file]
            columns = {
                "frequency_hz": [run.gait.frequency for run in runs if run.gait],
                "u_m_s": [run.u for run in runs if run.u],
            }
            size = runs[0].per_si
            columns |= {runs[0].columns["value"]: [size * run.value for run in runs]}
            columns |= {runs[0].columns["sd"]: [size * run.sd for run in runs if run.sd is not None]}
            results.append({"file": file, "runs": len(runs)} | spans(columns))
        return results

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Yield the lines of text of a file's summary."""
        yield f"{summary['file']}: {summary['runs']} {self.label}{'s' * (summary['runs'] != 1)}"
        yield from span_lines(summary)


class Tows(Numbers[Tow]):
    """Drag of straight bodies that are towed."""

    trial = Tow
    key, label, others = "tows", "tow", "speeds of towing"
    quantities = (Quantity("drag", "N", "relative", "%", 100.0, 0.05, "drag"),)

    def rows(self, robot: Robot, trials: Sequence[Tow], lowest: Mapping[str, float]) -> list[Rows]:
        """Return the rows of all runs as one `Rows`, computed together."""
        zero = [0.0] * len(robot.joints)
        straight = Gait(frequency=1.0, amplitude=tuple(zero), phase=tuple(zero))
        u = np.array([run.u for run in trials])
        return [HeldRows(*self.laid_out(trials), (straight,) * len(trials), u, -1.0)]

    def implausible(self, trials: Sequence[Tow], robot: Robot) -> tuple[list[InputError], list[str]]:
        """Return no errors, but warnings as for all numbers, and on drag that is no square of the speed."""
        errors, warnings = super().implausible(trials, robot)
        for file in dict.fromkeys(run.file for run in trials):
            tows = [run for run in trials if run.file == file and run.value > 0]
            if len({run.u for run in tows}) < FEW or max(run.u for run in tows) < 1.5 * min(run.u for run in tows):
                continue
            power = np.polyfit(np.log([run.u for run in tows]), np.log([run.value for run in tows]), 1)[0]
            if not DRAG_POWERS[0] <= power <= DRAG_POWERS[1]:
                rule = f"grows as the power {power:.1f} of the speed, where drag grows by about its square"
                fix = "was the gauge zeroed in still water, and are both columns of the same runs?"
                warnings.append(str(InputError(rule, file=file, key="the drag", fix=fix)))
        return errors, warnings


class Thrusts(Numbers[HeldThrust]):
    """Mean thrust of gaits whose head is held."""

    trial = HeldThrust
    key, label, others = "thrusts", "held thrust", "gaits of a held fish"
    quantities = (Quantity("thrust", "N", "relative", "%", 100.0, 0.05, "thrust"),)

    def rows(self, robot: Robot, trials: Sequence[HeldThrust], lowest: Mapping[str, float]) -> list[Rows]:
        """Return the rows of all runs as one `Rows`, computed together."""
        gaits, u = tuple(run.gait for run in trials if run.gait), np.array([run.u for run in trials])
        return [HeldRows(*self.laid_out(trials), gaits, u, 1.0)]


class Powers(Numbers[PowerRun]):
    """Mean power of settled gaits."""

    trial = PowerRun
    key, label, others, nuisance, hinges_bend = "powers", "power log", "gaits", "cost_factor", True
    quantities = (Quantity("power", "W", "relative", "%", 100.0, 0.05, "power"),)

    def rows(self, robot: Robot, trials: Sequence[PowerRun], lowest: Mapping[str, float]) -> list[Rows]:
        """Return the rows of all runs as one `Rows`, computed together."""
        return [BeatRows(*self.laid_out(trials), tuple(run.gait for run in trials if run.gait), "mechanical_power")]


class Turns(Numbers[TurnRun]):
    """Rates of turn of settled gaits."""

    trial = TurnRun
    key, label, others, hinges_bend = "turns", "turn", "turning gaits", True
    quantities = (Quantity("turn_rate", "rad/s", "relative", "%", 100.0, 0.05, "rate of turn"),)

    def rows(self, robot: Robot, trials: Sequence[TurnRun], lowest: Mapping[str, float]) -> list[Rows]:
        """Return the rows of all runs as one `Rows`, computed together."""
        return [BeatRows(*self.laid_out(trials), tuple(run.gait for run in trials if run.gait), "turn_rate")]
