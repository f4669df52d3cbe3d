"""Figures of a Pareto front, with the robot's named gaits, and of the convergence of searches."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from hypertuna.arrays import Array
from hypertuna.display import plots
from hypertuna.figures import FAINT, INK, POINTS, SEQUENCE, TIGHT, WIDTH, line_style, styled
from hypertuna.optimization.optimum import Optimum
from hypertuna.optimization.pareto import Front
from hypertuna.swimming.beat import QUANTITIES
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.sweep import sweep

NEAR = 0.18  # inch: points closer than this over the figure's width, relative to the largest value, share a label


@plots.of(Front)
@styled
def plot_pareto(front: Front, *, width: float = WIDTH) -> Figure:
    """Plot the second objective of a front against the first, colored by the third objective, else by frequency."""
    figure = Figure(figsize=(width, 0.45 * width + 1.6), layout="constrained")
    axes = figure.subplots()
    third = len(front.objectives) > 2
    shade = front.values[:, 2] if third else front.space.gaits(front.x).frequency
    colors = Normalize(shade.min(), shade.max()) if len(shade) else Normalize(0, 1)
    labels = [f"{name.replace('_', ' ')} [{unit}]" for name, unit in zip(front.objectives, front.units, strict=True)]
    _plot_named(axes, front, NEAR / width)
    if front.polished:
        axes.plot(*front.evolved[:, :2].T, "x", color=FAINT, ms=4.5, mew=0.9, label="before polishing")
    if not third:  # the front is a curve
        axes.plot(*front.values[:, :2].T, color=SEQUENCE(0.5), lw=0.8, alpha=0.6, zorder=2.5)
    style: dict[str, Any] = {"s": 26, "linewidths": 0.5, "edgecolors": "white", "zorder": 3}
    axes.scatter(front.values[:, 0], front.values[:, 1], c=shade, cmap=SEQUENCE, norm=colors, **style)
    axes.plot([], [], "o", color=SEQUENCE(0.5), mec="white", label="polished front" if front.polished else "front")
    axes.set(xlabel=labels[0], ylabel=labels[1])
    bar = labels[2] if third else "beat frequency [Hz]"
    figure.colorbar(ScalarMappable(colors, SEQUENCE), ax=axes, label=bar, aspect=30, pad=0.02)
    figure.legend(loc="outside lower left", ncols=2 if width < 6 else 3, **TIGHT)
    return figure


def _plot_named(axes: Axes, front: Front, label_distance: float) -> None:
    """Plot the robot's named gaits without a bias, as the model swims them, with numbers that the legend explains."""
    named = {name: gait for name, gait in front.robot.gaits.items() if not any(gait.bias)}
    if not named or front.robust is not None:
        return
    gaits = [Gait(gait.frequency, gait.amplitude, gait.phase) for gait in named.values()]
    swims = sweep(front.robot, gaits, threads=1)
    points = np.stack([swims[name].where(swims.settled).values for name in front.objectives[:2]], axis=1)
    for k, (name, point) in enumerate(zip(named, points, strict=True), start=1):
        if np.isfinite(point).all():
            axes.plot(*point, "s", color=INK, mfc="none", ms=5.5, mew=1.1, zorder=4, label=f"{k}  {name}")
    for place, numbers in _shared_labels(points, label_distance):
        text = ", ".join(map(str, numbers))
        axes.annotate(text, place, (-5, 3), textcoords="offset points", ha="right", fontsize=8, color=INK)


def _shared_labels(points: Array, distance: float) -> list[tuple[tuple[float, float], list[int]]]:
    """Return a place, and the numbers of its points, for every label; points near each other share a label."""
    size = np.nanmax(points, axis=0)
    groups: list[list[int]] = []
    for k in np.flatnonzero(np.isfinite(points).all(axis=1)).tolist():
        group = next((g for g in groups if np.abs((points[k] - points[g[0]]) / size).max() < distance), None)
        if group is None:
            groups.append([k])
        else:
            group.append(k)
    return [((points[g, 0].min(), points[g, 1].max()), [k + 1 for k in g]) for g in groups]


@plots.of(Optimum)
@styled
def plot_convergence(runs: Optimum | Sequence[Optimum], *, width: float = WIDTH) -> Figure:
    """Plot the best value so far against the number of gaits swum, as Fig. 13(a) of the paper; `width` [inch]."""
    runs = [runs] if isinstance(runs, Optimum) else runs
    figure = Figure(figsize=(width, 2.9), layout="constrained")
    axes = figure.subplots()
    target = runs[0].objective
    name, factor = target.terms[0]
    sign = np.sign(factor) if target.expected is None else 1.0  # a quantity to maximize is plotted with its own sign
    for k, run in enumerate(runs):
        label = f"{run.method}, seed {run.seed}: {run.evaluations} gaits"
        axes.step(run.swum, sign * run.history, where="post", **line_style(k, 1), label=label)
        if run.gait is not None:
            axes.plot(run.swum[-1], sign * run.history[-1], "o", color=line_style(k, 1)["color"], **POINTS)
    quantity = f"{name.replace('_', ' ')} [{QUANTITIES[name].unit}]"
    label = quantity if target.expected is None else "|U − Uₑ| + k COT [m/s]"
    axes.set(xlabel="gaits swum", ylabel=label, title="Best value so far")
    axes.set_xlim(0, max(run.evaluations for run in runs) * 1.02)
    if any(np.isfinite(run.history).any() for run in runs):
        axes.legend(**TIGHT)
    return figure
