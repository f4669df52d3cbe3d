"""Tables and pictures of docs/optimize.md and docs/pareto.md; docs/figures.py includes them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from figures_common import FISH, MODELS, change, rows, swum
from matplotlib.figure import Figure

from hypertuna.optimization.constraints import gait_limits
from hypertuna.optimization.objective import OBJECTIVES
from hypertuna.optimization.optimize import METHODS, optimize
from hypertuna.optimization.optimum import Optimum
from hypertuna.optimization.pareto import Front, pareto
from hypertuna.optimization.plots import plot_convergence, plot_pareto
from hypertuna.paper.computed import SPEEDS
from hypertuna.swimming.beat import QUANTITIES
from hypertuna.swimming.swim import swim


@cache
def front() -> Front:
    """Find HyperTuna's Pareto front of speed and cost of transport."""
    return pareto(FISH)


def front_table() -> str:
    """Tabulate the costs of the paper's gaits in the model beside those of the cheapest gaits as fast."""
    body = []
    for name in SPEEDS:
        done = swum(name, "joint bandwidth")
        fast = gait_limits(FISH, speed=done.speed)
        least = optimize(FISH, minimize="cost_of_transport", limits=fast, method="gradient").cost_of_transport
        cells = (f"{done.speed:.3f}", f"{done.cost_of_transport:.3f}", f"{least:.3f}")
        body.append([f"`{name}`", *cells, f"{round(change(least, done.cost_of_transport)):+d}\u00a0%"])
    return rows(["gait", "speed [m/s]", "cost of transport [J/(kg m)]", "of the cheapest", "more"], body)


def objectives_table() -> str:
    """Tabulate the objectives."""
    body = [
        [f"`{name}`", QUANTITIES[name].unit, "large" if large else "small", QUANTITIES[name].meaning]
        for name, large in OBJECTIVES.items()
    ]
    return rows(["objective", "unit", "better", "meaning"], body, left=4)


@cache
def optimum(model: str, method: str, **objective: Any) -> Optimum:
    """Optimize HyperTuna's gait with a model of its joints."""
    return optimize(FISH.using(joints="ideal" if model == "ideal joints" else "bandwidth"), **objective, method=method)


def methods_table() -> str:
    """Tabulate what every method finds, and how many gaits it swims."""
    body = []
    for objective in ({"maximize": "speed"}, {"speed": 0.4}):
        for method in METHODS:
            best = optimum("joint bandwidth", method, **objective)
            assert best.gait is not None
            degrees = [f"{x:.2f}" for x in np.degrees([*best.gait.amplitude, best.gait.phase[1]])]
            cells = (f"{best.gait.frequency:.3f}", *degrees, f"{best.speed:.4f}", f"{best.cost_of_transport:.4f}")
            body.append(
                ["highest" if "maximize" in objective else "0.4 m/s", f"`{method}`", *cells, str(best.evaluations)]
            )
    head = ["speed", "method", "f [Hz]", "A1 [deg]", "A2 [deg]", "phase [deg]", "U [m/s]", "COT [J/(kg m)]", "gaits"]
    return rows(head, body, left=2)


def phases_table() -> str:
    """Tabulate how little the highest speed depends on the phase."""
    printed = swum("optimised-max", MODELS[0]).gait.phase[1]
    body = []
    for model in MODELS[:2]:
        best = optimum(model, "gradient", maximize="speed")
        assert best.gait is not None
        there = swim(best.robot, replace(best.gait, phase=(0.0, printed))).speed
        cells = (f"{np.degrees(best.gait.phase[1]):.1f}", f"{best.speed:.4f}", f"{there:.4f}")
        body.append([model, *cells, f"{change(best.speed, there):.2f}\u00a0%"])
    at = f"at {np.degrees(printed):.2f} deg"
    return rows(["model", "best phase [deg]", "highest speed [m/s]", f"{at} [m/s]", "change"], body)


def weights_table() -> str:
    """Tabulate the largest weight k of Eq. 42 with which the speed stays as expected."""
    body = []
    for speed in (0.2, 0.3, 0.4, 0.5, 0.55, 0.57):
        tracked = [optimum(model, "gradient", speed=speed) for model in MODELS[:2]]
        cells = [f(best) for best in tracked for f in (_threshold, lambda best: f"{best.cost_of_transport:.3f}")]
        body.append([f"{speed:g}", *cells])
    head = [f"{name}, {model}" for model in MODELS[:2] for name in ("largest k", "COT")]
    return rows(["expected speed [m/s]", *head], body)


def _threshold(best: Optimum) -> str:
    """Write the largest weight that holds the speed."""
    return "" if best.weight_threshold is None else f"{best.weight_threshold:.3f}"


TABLES: dict[str, Callable[[], str]] = {
    "front": front_table,
    "objectives": objectives_table,
    "methods": methods_table,
    "phases": phases_table,
    "weights": weights_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {
    "docs/pareto.svg": lambda: plot_pareto(front()),
    "docs/convergence.svg": lambda: plot_convergence([optimum(MODELS[1], m, speed=0.4) for m in METHODS]),
}
