"""Steady runs as a kind of trial: speed, cost of transport and bends of hinges of settled gaits are compared."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.beat import directional_derivatives, settle
from hypertuna.swimming.gait import KINDS, Gait, Gaits, gait_text
from hypertuna.trials.kind import FAILED, Kind, Point, Prediction, Quantity, Rows, Sample, evenly_spaced, span_lines
from hypertuna.trials.plausibility import implausible_runs
from hypertuna.trials.steady import MEASURED, SteadyRun, measured_columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

USABLE = (0, 2)  # statuses of beats that have derivatives: settled, and periodic but unstable
UNSTABLE = 2  # status of a beat that is periodic but unstable


def with_cost_factor(at: Point, cost: Array, jacobian: Array, usable: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Multiply mechanical costs or powers, and their Jacobian, by `cost_factor`, which makes them electrical."""
    if not (nuisance := at.nuisances.get("cost_factor")):
        return cost, jacobian
    k, factor, by_scaled = nuisance
    jacobian = factor * jacobian
    jacobian[:, k] = np.where(usable, cost * by_scaled, 0.0)
    return factor * cost, jacobian


def bend_slopes(at: Point, gaits: Gaits, names: Sequence[str]) -> dict[str, Array]:
    """Return derivatives (gaits, n) of hinges' bends by the scaled free coefficients, by name.

    They are central differences of settled beats: exact derivatives exist of what the core measures of a beat alone.
    """
    slopes = {name: np.zeros((len(gaits), at.count)) for name in names}
    if not names or at.beside is None:
        return slopes
    for k in range(at.count):
        *sides, step = at.beside(k)
        low, high = (settle(p.robot, gaits, model=p.model, steps=p.gradient_steps, threads=p.threads) for p in sides)
        for name in names:
            change = high[name] - low[name]
            if name.startswith("bend_lag"):
                change = (change + np.pi) % (2 * np.pi) - np.pi
            slopes[name][:, k] = change / (2 * step)
    return slopes


@dataclass(frozen=True)
class SteadyRows(Rows):
    """Rows of steady runs: settled gaits with measured speed, cost of transport and bends of hinges."""

    gaits: tuple[Gait, ...]
    names: tuple[str, ...]  # name of each element in a settled beat, such as bend_lag_2

    def predict(self, at: Point) -> Prediction:
        """Return the computed speed, cost of transport and bends of every run, as far as they were measured."""
        gaits = Gaits.of(self.gaits)
        beats = settle(at.robot, gaits, model=at.model, steps=at.steps, threads=at.threads)
        by = dict.fromkeys(MEASURED, np.zeros((len(gaits), at.count)))
        bends = [name for name in dict.fromkeys(self.names) if name not in MEASURED]
        if at.along is not None:
            with np.errstate(all="ignore"):  # gaits without a settled beat have no derivatives
                options: dict[str, Any] = {"model": at.model, "steps": at.gradient_steps, "threads": at.threads}
                by = directional_derivatives(at.robot, gaits, beats, at.along, **options)
        by = {**by, **bend_slopes(at, gaits, bends)}
        usable = np.isin(beats["status"], USABLE) & np.isfinite(beats["cost_of_transport"]) & (beats["speed"] != 0)
        mask = usable[:, np.newaxis]
        table = {
            name: (beats[name], np.where(mask & np.isfinite(by[name]), by[name], 0.0)) for name in (*MEASURED, *bends)
        }
        table["cost_of_transport"] = with_cost_factor(at, *table["cost_of_transport"], usable)
        run = [sample.run for sample in self.samples]
        computed, jacobian = (
            np.array([table[name][which][r] for name, r in zip(self.names, run, strict=True)]) for which in (0, 1)
        )
        lag = np.array([name.startswith("bend_lag") for name in self.names])
        turns = np.where(lag, np.round((computed - self.measured) / (2 * np.pi)), 0.0)
        computed = computed - 2 * np.pi * np.where(np.isfinite(turns), turns, 0.0)
        failed = ~usable[run]
        computed[failed] = FAILED * np.maximum(np.abs(self.measured), self.sd)[failed]
        jacobian[failed] = 0.0
        measurable = {name: table[name] for name in MEASURED}
        return Prediction(computed, jacobian, ~usable, usable & (beats["status"] == UNSTABLE), measurable)

    def speed_errors(self) -> list[dict[int, float]]:
        """Return for each run the weight of its speed's element, which makes its error a relative error."""
        weights: list[dict[int, float]] = [{} for _ in self.gaits]
        for k, (sample, value) in enumerate(zip(self.samples, self.measured.tolist(), strict=True)):
            if sample.quantity == "speed" and value:
                weights[sample.run] = {k: 1 / value}
        return weights


class Steady(Kind[SteadyRun]):
    """Steady runs: speed, cost of transport and bends of hinges of settled gaits."""

    trial = SteadyRun
    key, label, others, nuisance, hinges_bend = "steady", "steady run", "gaits", "cost_factor", True
    quantities = (
        Quantity("speed", "m/s", "relative", "%", 100.0, 0.05, "speed"),
        Quantity("cost_of_transport", "J/(kg m)", "relative", "%", 100.0, 0.05, "cost of transport"),
        Quantity("bend_amplitude", "rad", "relative", "%", 100.0, 0.05, "amplitude of the hinge's bend"),
        Quantity(
            "bend_lag", "rad", "deg", "deg", 1.0, math.radians(3), "lag of the hinge's bend", per_si=180 / math.pi
        ),
    )

    def depends_on(self, trial: SteadyRun, nuisance: str) -> bool:
        """Return whether a run's cost of transport, which `cost_factor` scales, was measured."""
        return nuisance == self.nuisance and trial.cost_of_transport is not None

    def motion(self, trial: SteadyRun) -> dict[str, float]:
        """Return a run's "frequency" [Hz], largest "amplitude" [rad] and, if it was measured, "speed" [m/s]."""
        beat = {"frequency": trial.gait.frequency, "amplitude": max(trial.gait.amplitude)}
        return beat if trial.speed is None else beat | {"speed": trial.speed}

    def rows(self, robot: Robot, trials: Sequence[SteadyRun], lowest: Mapping[str, float]) -> list[Rows]:
        """Return the rows of all runs as one `Rows`, computed together."""
        values, samples, names = [], [], []
        for r, run in enumerate(trials):
            if run.bends and len(run.bends) != len(robot.hinges):
                rule = f"must be one of each of the {len(robot.hinges)} hinges of {robot.name}"
                fix = "give one of each hinge, or none"
                raise InputError(rule, file=run.file, key=f"{run.name}: bends", value=f"{len(run.bends)}", fix=fix)
            for name, (quantity, value, sd) in run.measured().items():
                if value == 0 and sd is None and quantity != "bend_lag":
                    key, fix = f"line {run.line}, speed_m_s", "give speed_sd_m_s"
                    rule = "must have a standard deviation where it is 0: a relative error is not defined"
                    raise InputError(rule, file=run.file, key=key, fix=fix)
                unit = 1.0 if quantity == "bend_lag" else abs(value)  # of the noise level
                samples.append(
                    Sample(quantity, r, (unit if sd is None else sd) / math.sqrt(run.repeats), sd is not None, 1)
                )
                values.append(value)
                names.append(name)
        gaits = tuple(run.gait for run in trials)
        measured = np.array(values, dtype=float)
        return [SteadyRows(measured, np.arange(len(values)), samples, len(trials), gaits, tuple(names))]

    def part(self, trials: Sequence[SteadyRun], count: int) -> Sequence[SteadyRun]:
        """Return about `count` evenly spaced runs for a rough search."""
        return evenly_spaced(trials, count)

    def implausible(self, trials: Sequence[SteadyRun], robot: Robot) -> tuple[list[InputError], list[str]]:
        """Return errors on files with wrong units, and warnings about unlikely speeds or amplitudes."""
        return implausible_runs(trials, robot)

    def repeated(self, training: Sequence[SteadyRun], validation: Sequence[SteadyRun]) -> list[str]:
        """Return a warning if validation runs repeat gaits of the training runs."""
        gaits = {run.gait for run in training}
        count = sum(run.gait in gaits for run in validation)
        runs = f"{count} of {len(validation)} steady validation runs"
        return [f"{runs} repeat gaits of the training runs."] if count else []

    def cells(self, trial: SteadyRun) -> tuple[str, str, str]:
        """Return the texts of a run in a table: name, gait and speed."""
        from hypertuna.display import number

        return trial.name, gait_text(trial.gait), number(trial.speed if trial.speed is not None else np.nan, "m/s")

    def picture(self, trials: Sequence[SteadyRun]) -> str:
        """Return an SVG of the first measured quantity over the frequency."""
        from hypertuna.pictures import captioned, curve_svg

        name, shown = next(self.shown(trials))
        runs = [run for run in trials if name in run.measured()]
        unit, size = border(shown)
        label = f"measured {words(name)} [{unit}] over frequency [Hz]"
        values = [size * run.measured()[name][1] for run in runs]
        dots = curve_svg([run.gait.frequency for run in runs], values, label, dots=True)
        return captioned(dots, "Each dot is a steady run.")

    def plot(self, trials: Sequence[SteadyRun], *, width: float) -> Figure:
        """Return a figure of the measured values over the frequency, with a panel for each quantity."""
        from matplotlib.figure import Figure

        from hypertuna.figures import COLORS, POINTS

        shown = [*self.shown(trials)]
        figure = Figure(figsize=(width, 0.36 * width + 0.6), layout="constrained")
        for axes, (name, quantity) in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown, strict=True):
            measured = [(run.gait.frequency, *run.measured()[name][1:]) for run in trials if name in run.measured()]
            unit, size = border(quantity)
            frequency, values, deviations = zip(
                *((f, size * value, size * (sd or 0.0)) for f, value, sd in measured), strict=True
            )
            axes.errorbar(frequency, values, deviations, fmt="o", color=COLORS[1], elinewidth=1, **POINTS)
            label = f"{words(name)} [{unit}]"
            axes.set(xlabel="frequency [Hz]", ylabel=label, ylim=(0, None), title=f"{len(measured)} steady runs")
        return figure

    def shown(self, trials: Sequence[SteadyRun]) -> Iterator[tuple[str, Quantity]]:
        """Yield the measured quantities of any of the runs, by name in a settled beat."""
        measured = {name: quantity for run in trials for name, (quantity, *_) in run.measured().items()}
        yield from ((name, one) for one in self.quantities for name, of in measured.items() if of == one.name)

    def summaries(self, trials: Sequence[SteadyRun], robot: Robot) -> list[dict[str, Any]]:
        """Return a summary of each file: minimum and maximum of each of its columns."""
        files = dict.fromkeys(run.file for run in trials)
        return [_summary(file, [run for run in trials if run.file == file], robot) for file in files]

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Yield the lines of text of a file's summary."""
        counts = (f"{summary[key]} {noun}{'s' * (summary[key] != 1)}" for key, noun in COUNTED.items())
        yield f"{summary['file']}: {' of '.join(counts)}"
        yield from span_lines(summary)


def border(quantity: Quantity) -> tuple[str, float]:
    """Return the unit of a quantity in figures, and its size per SI unit: angles are in degrees."""
    return ("deg", 180 / math.pi) if quantity.unit == "rad" else (quantity.unit, 1.0)


def words(name: str) -> str:
    """Return the name of a quantity in words, such as "bend lag 2"."""
    return name.replace("_", " ")


COUNTED = {"runs": "steady run", "swims": "swim"}  # by key of a summary: noun for what it counts


def _summary(file: str, runs: Sequence[SteadyRun], robot: Robot) -> dict[str, Any]:
    """Return the summary of a file of steady runs: minimum and maximum of each column."""
    columns: dict[str, list[float | None]] = {"frequency_hz": [run.gait.frequency for run in runs]}
    for g, group in enumerate(robot.joints):
        for kind in KINDS:
            columns[f"{kind}_{group.name}_deg"] = [np.degrees(getattr(run.gait, kind)[g]) for run in runs]
    rows = [measured_columns(run) for run in runs]
    columns |= {name: [row.get(name) for row in rows] for name in max(rows, key=len)}
    filled = {name: [value for value in column if value is not None] for name, column in columns.items()}
    spans = {name: [min(values), max(values)] if values else None for name, values in filled.items()}
    return {"file": file, "runs": len(runs), "swims": sum(run.repeats for run in runs)} | spans
