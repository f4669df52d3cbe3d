"""Table IV and Fig. 13: optimal gaits, by particle swarm and by gradients, beside the paper's."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.optimization.optimize import optimize
from hypertuna.optimization.optimum import Optimum
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import COSTS, OURS, PAPER, TARGETS, Trial
from hypertuna.paper.ledger import Class, Finding, published_value
from hypertuna.reports.html import Section, Table
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import swim

METHODS = ("pso", "gradient")
NAMES = {"pso": "particle swarm", "gradient": "gradient"}
# Variables that the fastest gait has at their bounds.
BOUNDED = {"frequency_hz", "amplitude_I_deg", "amplitude_II_deg"}
# Last part of an id -> variable of a gait.
COLUMNS = {"frequency": "frequency_hz", "phase": "phase_II_deg"} | {
    f"amplitude-{joint}": f"amplitude_{joint}_deg" for joint in ("I", "II")
}
FLAT = 8.0  # deg: this far from the best phase, less than half a percent of the largest speed is lost


@dataclass(frozen=True)
class Optima:
    """Optimal gaits by model, objective and method, with the trials of the published gaits."""

    trials: Trials
    best: Mapping[tuple[str, str, str], Optimum]  # by model, expected speed of Table IV and method

    def gradient(self, model: str, target: str) -> Optimum:
        """Return the optimum of a model and an objective that was found by gradients."""
        return self.best[model, target, "gradient"]


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Optima:
    """Return the best gaits for the paper's four objectives, with the paper's model and ours."""
    best: dict[tuple[str, str, str], Optimum] = {}
    for model in (PAPER, OURS):
        if best:
            step()
        for method in METHODS:
            optima = table_iv(trials[model].robot, method)
            best |= {(model, target, method): optimum for target, optimum in optima.items()}
    return Optima(trials, best)


def table_iv(robot: Robot, method: str = "gradient") -> dict[str, Optimum]:
    """Return a robot's best gait for each of the paper's four objectives, by expected speed."""
    goals: dict[str, dict[str, Any]] = {target: {"speed": float(target)} for target in COSTS}
    goals["max"] = {"maximize": "speed"}
    return {target: optimize(robot, **goals[target], method=method) for target in TARGETS}


def findings(optima: Optima) -> Iterator[Finding]:
    """Yield the numbers of the optima by gradients, with the swarm's numbers in the notes."""
    for model in (PAPER, OURS):
        for finding in optimum_findings(model, {target: optima.gradient(model, target) for target in TARGETS}):
            _, target, key = finding.id.split("/")
            swarm = _numbers(optima.best[model, target, "pso"].gait)
            yield finding._replace(note=f"the particle swarm ends at {swarm[key]:.4g}")


def optimum_findings(model: str, optima: Mapping[str, Optimum]) -> Iterator[Finding]:
    """Yield the numbers of the best gaits, by expected speed of Table IV."""
    for target, best in optima.items():
        for key, value in _numbers(best.gait).items():
            class_: Class = "at a bound" if COLUMNS[key] in best.bounds else "prediction"
            yield Finding(f"optimum/{target}/{key}", model, class_, value)


def sections(optima: Optima) -> list[Section]:
    """Show Table IV and Fig. 13."""
    from hypertuna.paper.figures import plot_changes, plot_descent

    bars = ["speed,\nmaximum", *(f"cost at\n{speed} m/s" for speed in COSTS)]
    return compose(
        "optima",
        {
            "fig13a": plot_descent(_distances(optima), "fitness above the optimum [m/s]"),
            "fig13b": plot_changes(bars, _changes(optima)),
            "gaits": gait_table(optima),
            "methods": method_table(optima),
        },
        **_facts(optima),
    )


def gait_table(optima: Optima) -> Table:
    """Tabulate the gaits of Table IV with their speeds and costs in the models."""
    rows = []
    for target in TARGETS:
        for kind in ("unoptimised", "optimised"):
            swims = [optima.trials[model].gaits[f"{kind}-{target}"] for model in (PAPER, OURS)]
            cells = [cell for swim in swims for cell in (f"{swim.speed:.3f}", f"{swim.cost_of_transport:.3g}")]
            rows.append([_label(target), f"published, {kind.replace('mis', 'miz')}", *_cells(swims[0].gait), *cells])
        for model in (PAPER, OURS):
            best = optima.gradient(model, target)
            cells = [f"{best.speed:.3f}", f"{best.cost_of_transport:.3g}"]
            columns = [*cells, "", ""] if model == PAPER else ["", "", *cells]
            rows.append([_label(target), f"ours, {model}", *_cells(best.gait), *columns])
    angles = ["A I [deg]", "A II [deg]", "f [Hz]", "phase [deg]"]
    models = [f"{model}: {what}" for model in (PAPER, OURS) for what in ("speed [m/s]", "cost [J/(kg m)]")]
    return Table(["objective", "gait", *angles, *models], rows)


def method_table(optima: Optima) -> Table:
    """Tabulate fitness, phase and number of gaits of both methods."""
    rows = []
    for model, target in itertools.product((PAPER, OURS), TARGETS):
        pair = [optima.best[model, target, method] for method in METHODS]
        fitness = [f"{(-1 if target == 'max' else 1) * best.value:.5f}" for best in pair]
        phases = [f"{_numbers(best.gait)['phase']:.1f}" for best in pair]
        rows.append([model, _label(target), *fitness, *phases, *(str(best.evaluations) for best in pair)])
    pairs = [f"{what}, {NAMES[m]}" for what in ("fitness [m/s]", "phase [deg]", "gaits swum") for m in METHODS]
    return Table(["model", "objective", *pairs], rows)


def _numbers(gait: Gait | None) -> dict[str, float]:
    """Return a gait in the paper's numbers: amplitudes and phase in degrees, frequency in Hz."""
    if gait is None:
        return dict.fromkeys(("amplitude-I", "amplitude-II", "frequency", "phase"), np.nan)
    a, b = np.degrees(gait.amplitude)
    lag = np.degrees(gait.phase[1] - gait.phase[0])
    return {"amplitude-I": float(a), "amplitude-II": float(b), "frequency": gait.frequency, "phase": float(lag)}


def _cells(gait: Gait | None) -> list[str]:
    """Return a gait as Table IV writes it."""
    return [f"{value:.4g}" for value in _numbers(gait).values()]


def _label(target: str) -> str:
    """Return the label of an objective."""
    return "maximum" if target == "max" else f"at\N{NO-BREAK SPACE}{target} m/s"


def _facts(optima: Optima) -> dict[str, Any]:
    """Return the values that fill in the text on the optima."""
    best = {model: optima.gradient(model, "max") for model in (PAPER, OURS)}
    gaits = optima.trials[OURS].gaits
    phase = published_value("optimum/max/phase")
    phases = {model: _numbers(optimum.gait)["phase"] for model, optimum in best.items()}
    near = [model for model, value in phases.items() if abs(value - phase) <= FLAT]
    texts = {0: "with neither joint model", 1: f"only with {near[0] if near else ''}", 2: "with either joint model"}
    losses = {model: 100 * (1 - _speed_at(optimum, phase) / optimum.speed) for model, optimum in best.items()}
    cheapest = [_numbers(optima.gradient(OURS, target).gait) for target in COSTS]
    return {
        "weight": optima.gradient(OURS, COSTS[0]).objective.terms[0][1],
        "gap_ideal": _largest_gap(optima, PAPER),
        "gap": _largest_gap(optima, OURS),
        "on_bounds": all(set(optimum.bounds) >= BOUNDED for optimum in best.values()),
        "tolerance": FLAT,
        "near": texts[len(near)],
        "phases": " and ".join(f"{value:.1f} deg with {model}" for model, value in phases.items()),
        "phase": phase,
        "losses": " and ".join(f"{part:.2f} % with {model}" for model, part in losses.items()),
        "loss_optimized": 100 * (1 - gaits["optimised-max"].speed / best[OURS].speed),
        "loss_unoptimized": 100 * (1 - gaits["unoptimised-max"].speed / best[OURS].speed),
        "gain": published_value("speed/change-max"),
        "spans": {key: _span([gait[key] for gait in cheapest]) for key in cheapest[0]},
    }


def _speed_at(best: Optimum, phase: float) -> float:
    """Return the speed [m/s] of an optimal gait with its phase difference changed to another [deg]."""
    assert best.gait is not None
    return swim(best.robot, replace(best.gait, phase=(0.0, math.radians(phase)))).speed


def _largest_gap(optima: Optima, model: str) -> float:
    """Return the largest difference between swarm and gradients in a model's best fitness, over objectives [m/s]."""
    return max(abs(optima.best[model, t, "pso"].value - optima.gradient(model, t).value) for t in TARGETS)


def _span(values: Sequence[float]) -> str:
    """Return the range of values as text."""
    low, high = (f"{value:.3g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _distances(optima: Optima) -> dict[str, Array]:
    """Return the distance of the swarm's fitness from the optimum after each iteration, by objective [m/s]."""
    curves = {}
    for target in TARGETS:
        swarm, best = optima.best[OURS, target, "pso"], optima.gradient(OURS, target)
        curves["maximum" if target == "max" else f"{target} m/s"] = swarm.history - min(best.value, swarm.value)
    return curves


def _changes(optima: Optima) -> dict[str, list[float]]:
    """Return changes by optimization [%], as published and by model: of the highest speed, and of each cost."""
    keys = ("speed/change-max", *(f"cost-of-transport/change-{speed}" for speed in COSTS))
    bars = {"published": [published_value(key) for key in keys]}
    for model in (PAPER, OURS):
        trial = optima.trials[model]
        bars[f"authors' gaits, {model}"] = _change(trial, {t: trial.gaits[f"optimised-{t}"] for t in TARGETS})
    ours = {target: optima.gradient(OURS, target).swim for target in TARGETS}
    return bars | {f"our gaits, {OURS}": _change(optima.trials[OURS], ours)}


def _change(trial: Trial, after: Mapping[str, Any]) -> list[float]:
    """Return changes from unoptimized to other gaits [%]: of the highest speed, and of the cost at each speed."""
    before = {target: trial.gaits[f"unoptimised-{target}"] for target in TARGETS}
    speed = after["max"].speed / before["max"].speed
    costs = [after[target].cost_of_transport / before[target].cost_of_transport for target in COSTS]
    return [100 * (ratio - 1) for ratio in (speed, *costs)]


CHAPTER = Chapter("optima", sections, findings, compute, steps=2, full_steps=2)
