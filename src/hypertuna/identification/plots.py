"""Figures of a fit: coefficients with intervals, correlations, computed over measured values, errors of runs."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_rgba
from matplotlib.figure import Figure

from hypertuna.arrays import Array
from hypertuna.display import plots
from hypertuna.figures import COLORS, FAINT, INK, POINTS, TIGHT, WIDTH, styled
from hypertuna.identification.coefficients import bounds_of, to_scale
from hypertuna.identification.identify import Fit
from hypertuna.identification.names import two_lines
from hypertuna.identification.posterior import Posterior
from hypertuna.identification.residuals import LABELS, NUMBERS
from hypertuna.io import quantity

DARK = 0.85  # correlation above which the text of a cell is white
PARTS = {"training": (COLORS[1], "o"), "validation": (COLORS[0], "s")}  # color and marker


@plots.of(Fit)
@styled
def plot_intervals(fit: Fit, *, sampled: Posterior | None = None, width: float = WIDTH) -> Figure:
    """Plot each coefficient and its 95 % interval, on an axis from its lower to its upper bound; width [inch]."""
    frees, uncertainty = fit.free, fit.uncertainty
    lower, upper = bounds_of(frees)

    def place(values: Array) -> Array:
        return np.asarray((to_scale(frees, values) - lower) / (upper - lower))

    rows = np.arange(len(frees))[::-1]
    figure = Figure(figsize=(width, 0.42 * len(frees) + 1.0), layout="constrained")
    axes = figure.subplots()
    colors = [COLORS[1] if constrained else COLORS[0] for constrained in uncertainty.constrained]
    axes.hlines(rows, place(uncertainty.low), place(uncertainty.high), colors=colors, lw=4, alpha=0.45)
    for constrained, label in ((True, "constrained"), (False, "not constrained")):
        selected = np.array(uncertainty.constrained) == constrained
        if selected.any():
            color, marker = (COLORS[1], "o") if constrained else (COLORS[0], "s")
            axes.plot(place(fit.values)[selected], rows[selected], marker, color=color, label=label, **POINTS)
    if sampled is not None:
        axes.hlines(rows - 0.25, place(sampled.low), place(sampled.high), colors=INK, lw=1.2, label="posterior")
    axes.set(xlim=(-0.02, 1.02), ylim=(-0.7, len(frees) - 0.4), xlabel="between its bounds")
    axes.set_xticks([0, 1], ["lower", "upper"])
    units = [" deg" if f.unit == "rad" else "" for f in frees]
    values = [f"{f.border[1] * value:.3g}{unit}" for f, value, unit in zip(frees, fit.values, units, strict=True)]
    axes.set_yticks(rows, [f"{two_lines(f.name)}: {value}" for f, value in zip(frees, values, strict=True)])
    axes.grid(axis="y", visible=False)
    figure.legend(loc="outside upper left", ncols=3, **TIGHT)
    return figure


@plots.of(Posterior)
@styled
def plot_posterior(sampled: Posterior, *, width: float = WIDTH) -> Figure:
    """Plot the samples of each coefficient as a histogram, with the 95 % interval; width [inch]."""
    count, columns = len(sampled.free), 3 if width > 5 else 1
    rows = -(-count // columns)
    figure = Figure(figsize=(width, 1.5 * rows + 0.5), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, free, values in zip(panels, sampled.free, sampled.samples.T, strict=False):
        shown = free.border[1] * values
        panel.hist(shown, 30, color=COLORS[1], alpha=0.75)
        for end in np.quantile(shown, (0.025, 0.975)):
            panel.axvline(end, color=INK, lw=1, ls=(0, (4, 2)))
        panel.set(xlabel=f"{two_lines(free.name)}{' [deg]' if free.unit == 'rad' else ''}", yticks=[])
    for panel in panels[count:]:
        panel.set_axis_off()
    figure.suptitle("Posterior; dashed: 95 % interval", x=0.01, ha="left", fontsize=9.5, fontweight="bold")
    return figure


@styled
def plot_correlation(fit: Fit, *, width: float = WIDTH) -> Figure:
    """Plot the correlation of the coefficients; width [inch]."""
    matrix, names = fit.uncertainty.correlation, [two_lines(f.name) for f in fit.free]
    n = len(names)
    figure = Figure(figsize=(width, 0.85 * width), layout="constrained")
    axes = figure.subplots()
    # transparent in the middle, for any background
    shades = [to_rgba(COLORS[0]), to_rgba(COLORS[0], 0.0), to_rgba(COLORS[1], 0.0), to_rgba(COLORS[1])]
    colors = LinearSegmentedColormap.from_list("correlation", list(zip([0, 0.5, 0.5, 1], shades, strict=True)))
    mesh = axes.pcolormesh(matrix, cmap=colors, vmin=-1, vmax=1, edgecolors="none")
    size = max(4.0, min(8.0, 52 / n))
    for i in range(n):
        for j in range(n):
            text = f"{matrix[i, j]:.2f}".replace("0.", ".")
            color = "white" if abs(matrix[i, j]) > DARK else INK
            axes.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=size, color=color)
    centers = np.arange(n) + 0.5
    axes.set_xticks(centers, names, rotation=90)
    axes.set_yticks(centers, names)
    axes.set(xlim=(0, n), ylim=(n, 0), aspect="equal")
    axes.grid(visible=False)
    axes.tick_params(length=0)
    figure.colorbar(mesh, ax=axes, shrink=0.6, label="correlation")
    return figure


@styled
def plot_measured(fit: Fit, *, width: float = WIDTH) -> Figure:
    """Plot computed over measured numbers, such as speed, for training and validation runs; width [inch]."""
    runs = [run for part in fit.parts.values() for run in part.runs]
    names = {
        kind: [quantity.key_of(f"{kind}_{of}", unit) for of in ("measured", "computed")]
        for kind, unit in NUMBERS.items()
    }
    kinds = [kind for kind in NUMBERS if any(names[kind][0] in run for run in runs)]
    figure = Figure(figsize=(width, width / len(kinds) + 0.4), layout="constrained")
    for axes, kind in zip(figure.subplots(1, len(kinds), squeeze=False)[0], kinds, strict=True):
        extremes: list[float] = []
        for name, part in fit.parts.items():
            pairs = np.array([[run[key] for key in names[kind]] for run in part.runs if names[kind][0] in run])
            if len(pairs):
                color, marker = PARTS[name]
                part_label = name if kind == kinds[0] else None
                axes.plot(*pairs.T, marker, color=color, label=part_label, alpha=0.8, **POINTS)
                extremes += [float(pairs.min()), float(pairs.max())]
        diagonal = [min(extremes), max(extremes)]
        axes.plot(diagonal, diagonal, color=FAINT, lw=1, zorder=0)
        axes.set(title=quantity.label(kind), xlabel=f"measured ({NUMBERS[kind]})", ylabel="computed", aspect="equal")
    figure.legend(loc="outside upper left", ncols=2, **TIGHT)
    return figure


@styled
def plot_errors(fit: Fit, *, width: float = WIDTH) -> Figure:
    """Plot the error of every run: relative for single numbers, rms over the frames of tracked runs; width [inch]."""
    panels = fit.quantities
    order = {run: k for k, run in enumerate(run for trials in fit.trials for run in trials.runs)}
    figure = Figure(figsize=(width, 1.5 * len(panels) + 0.7), layout="constrained")
    for row, (axes, key) in enumerate(zip(figure.subplots(len(panels), 1, squeeze=False)[:, 0], panels, strict=True)):
        name, unit, factor = LABELS[key]
        relative = key.endswith("_relative")
        field = key if relative else f"{key}_rms"
        for part, errors in fit.parts.items():
            points = [(order[run["run"]], factor * run[field]) for run in errors.runs if field in run]
            if points:
                color, marker = PARTS[part]
                x, y = np.array(points).T
                axes.vlines(x, 0, y, colors=[color], lw=0.8, alpha=0.5)
                axes.plot(x, y, marker, color=color, label=part if row == 0 else None, **(POINTS | {"ms": 3.2}))
        axes.set_ylabel(f"{name} ({unit})" if relative else f"{name}, rms ({unit})")
        if relative:
            axes.axhline(0, color=FAINT, lw=1, zorder=0)
    axes.set_xlabel("run: training, then validation")
    figure.legend(loc="outside upper left", ncols=2, **TIGHT)
    return figure
