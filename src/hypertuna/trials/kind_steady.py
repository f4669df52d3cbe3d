"""Steady runs as a kind of trial: speed and cost of transport of settled gaits are compared."""

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
from hypertuna.trials.steady import COLUMNS, MEASURED, SteadyRun

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


@dataclass(frozen=True)
class SteadyRows(Rows):
    """Rows of steady runs: settled gaits with measured speed and cost of transport."""

    gaits: tuple[Gait, ...]

    def predict(self, at: Point) -> Prediction:
        """Return the computed speed and cost of transport of every run."""
        gaits = Gaits.of(self.gaits)
        beats = settle(at.robot, gaits, model=at.model, steps=at.steps, threads=at.threads)
        by = dict.fromkeys(MEASURED, np.zeros((len(gaits), at.count)))
        if at.along is not None:
            with np.errstate(all="ignore"):  # gaits without a settled beat have no derivatives
                options: dict[str, Any] = {"model": at.model, "steps": at.gradient_steps, "threads": at.threads}
                by = directional_derivatives(at.robot, gaits, beats, at.along, **options)
        usable = np.isin(beats["status"], USABLE) & np.isfinite(beats["cost_of_transport"]) & (beats["speed"] != 0)
        mask = usable[:, np.newaxis]
        table = {name: (beats[name], np.where(mask & np.isfinite(by[name]), by[name], 0.0)) for name in MEASURED}
        table["cost_of_transport"] = with_cost_factor(at, *table["cost_of_transport"], usable)
        run = np.array([sample.run for sample in self.samples])
        kind = np.array([MEASURED.index(sample.quantity) for sample in self.samples])
        computed, jacobian = (np.stack([table[name][which] for name in MEASURED])[kind, run] for which in (0, 1))
        failed = ~usable[run]
        computed[failed] = FAILED * np.maximum(np.abs(self.measured), self.sd)[failed]
        jacobian[failed] = 0.0
        return Prediction(computed, jacobian, ~usable, usable & (beats["status"] == UNSTABLE), table)

    def speed_errors(self) -> list[dict[int, float]]:
        """Return for each run the weight of its speed's element, which makes its error a relative error."""
        weights: list[dict[int, float]] = [{} for _ in self.gaits]
        for k, (sample, value) in enumerate(zip(self.samples, self.measured.tolist(), strict=True)):
            if sample.quantity == "speed" and value:
                weights[sample.run] = {k: 1 / value}
        return weights


class Steady(Kind[SteadyRun]):
    """Steady runs: speed and cost of transport of settled gaits."""

    trial = SteadyRun
    key, label, others, nuisance, hinges_bend = "steady", "steady run", "gaits", "cost_factor", True
    quantities = (
        Quantity("speed", "m/s", "relative", "%", 100.0, 0.05, "speed"),
        Quantity("cost_of_transport", "J/(kg m)", "relative", "%", 100.0, 0.05, "cost of transport"),
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
        values, samples = [], []
        for r, run in enumerate(trials):
            for name in MEASURED:
                value, sd = getattr(run, name), getattr(run, f"{name}_sd")
                if value == 0 and sd is None:
                    key, fix = f"line {run.line}, speed_m_s", "give speed_sd_m_s"
                    rule = "must have a standard deviation where it is 0: a relative error is not defined"
                    raise InputError(rule, file=run.file, key=key, fix=fix)
                if value is not None:
                    size = (abs(value) if sd is None else sd) / math.sqrt(run.repeats)
                    samples.append(Sample(name, r, size, sd is not None, 1))
                    values.append(value)
        gaits = tuple(run.gait for run in trials)
        return [SteadyRows(np.array(values, dtype=float), np.arange(len(values)), samples, len(trials), gaits)]

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

        shown = next(q for q in self.quantities if any(getattr(run, q.name) is not None for run in trials))
        runs = [run for run in trials if getattr(run, shown.name) is not None]
        label = f"measured {shown.label} [{shown.unit}] over frequency [Hz]"
        values = [getattr(run, shown.name) for run in runs]
        dots = curve_svg([run.gait.frequency for run in runs], values, label, dots=True)
        return captioned(dots, "Each dot is a steady run.")

    def plot(self, trials: Sequence[SteadyRun], *, width: float) -> Figure:
        """Return a figure of the measured values over the frequency, with a panel for each quantity."""
        from matplotlib.figure import Figure

        from hypertuna.figures import COLORS, POINTS

        shown = [one for one in self.quantities if any(getattr(run, one.name) is not None for run in trials)]
        figure = Figure(figsize=(width, 0.36 * width + 0.6), layout="constrained")
        for axes, quantity in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown, strict=True):
            measured = [run for run in trials if getattr(run, quantity.name) is not None]
            deviations = [getattr(run, f"{quantity.name}_sd") or 0.0 for run in measured]
            frequency = [run.gait.frequency for run in measured]
            values = [getattr(run, quantity.name) for run in measured]
            axes.errorbar(frequency, values, deviations, fmt="o", color=COLORS[1], elinewidth=1, **POINTS)
            label = f"{quantity.label} [{quantity.unit}]"
            axes.set(xlabel="frequency [Hz]", ylabel=label, ylim=(0, None), title=f"{len(measured)} steady runs")
        return figure

    def summaries(self, trials: Sequence[SteadyRun], robot: Robot) -> list[dict[str, Any]]:
        """Return a summary of each file: minimum and maximum of each of its columns."""
        files = dict.fromkeys(run.file for run in trials)
        return [_summary(file, [run for run in trials if run.file == file], robot) for file in files]

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """Yield the lines of text of a file's summary."""
        counts = (f"{summary[key]} {noun}{'s' * (summary[key] != 1)}" for key, noun in COUNTED.items())
        yield f"{summary['file']}: {' of '.join(counts)}"
        yield from span_lines(summary)


COUNTED = {"runs": "steady run", "swims": "swim"}  # by key of a summary: noun for what it counts


def _summary(file: str, runs: Sequence[SteadyRun], robot: Robot) -> dict[str, Any]:
    """Return the summary of a file of steady runs: minimum and maximum of each column."""
    columns: dict[str, list[float | None]] = {"frequency_hz": [run.gait.frequency for run in runs]}
    for g, group in enumerate(robot.joints):
        for kind in KINDS:
            columns[f"{kind}_{group.name}_deg"] = [np.degrees(getattr(run.gait, kind)[g]) for run in runs]
    for key in (name for measured in MEASURED for name in (measured, f"{measured}_sd")):
        columns[COLUMNS[key]] = [getattr(run, key) for run in runs]
    filled = {name: [value for value in column if value is not None] for name, column in columns.items()}
    spans = {name: [min(values), max(values)] if values else None for name, values in filled.items()}
    return {"file": file, "runs": len(runs), "swims": sum(run.repeats for run in runs)} | spans
