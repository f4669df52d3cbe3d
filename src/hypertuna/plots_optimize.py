"""Figures of optimizations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from hypertuna.figures import POINTS, TIGHT, WIDTH, sequence, styled
from hypertuna.optimize import Optimum
from hypertuna.swimming.beat import QUANTITIES

__all__ = ["plot_convergence"]


@styled
def plot_convergence(runs: Sequence[Optimum]) -> Figure:
    """Draw the best value so far against the gaits swum, as Fig. 13(a) of the paper does.

    Parameters
    ----------
    runs : sequence of Optimum
        With the same goal.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    axes = figure.subplots()
    target = runs[0].goal
    name, factor = target.terms[0]
    sign = np.sign(factor) if target.expected is None else 1.0  # a quantity to maximize is drawn as it is
    for run, color in zip(runs, sequence(len(runs)), strict=True):
        label = f"{run.method}, seed {run.seed}: {run.evaluations} gaits"
        axes.step(run.swum, sign * run.history, where="post", color=color, label=label)
        if run.gait is not None:
            axes.plot(run.swum[-1], sign * run.history[-1], "o", color=color, **POINTS)
    quantity = f"{name.replace('_', ' ')} [{QUANTITIES[name].unit}]"
    label = quantity if target.expected is None else "|U − $U_e$| + k COT [m/s]"
    axes.set(xlabel="gaits swum", ylabel=label, title="Best value so far")
    axes.set_xlim(0, max(run.evaluations for run in runs) * 1.02)
    if any(np.isfinite(run.history).any() for run in runs):
        axes.legend(**TIGHT)
    return figure
