"""Figures of the ledger, as wide as a column of its page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from hypertuna.figures import COLORS, FAINT, GRID, INK, LINES, POINTS, SEQUENCE, SHAPES, TIGHT, styled
from hypertuna.paper.computed import COSTS
from hypertuna.paper.passive import KINDS, LAWS, PLACE
from hypertuna.reports.html import WIDTH
from hypertuna.swimming.swim import Swim

if TYPE_CHECKING:
    import xarray as xr


# Color, marker and filling of each kind of number.
DOTS = {
    "other": (FAINT, "o", FAINT),
    "fish": (COLORS[2], "D", "none"),
    "measured": (INK, "s", INK),
    "computed": (COLORS[0], "s", "none"),
}


def _axes(height: float) -> tuple[Figure, Axes]:
    """Return a figure with one plot, and its axes; the height is in inches."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots()


def _name_rows(axes: Axes, names: Sequence[str]) -> None:
    """Label the rows of a plot, from top to bottom."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)


@styled
def plot_map(
    grid: xr.Dataset,
    quantity: str,
    label: str,
    levels: Mapping[str, float | None],
    *,
    lowest: bool = False,
) -> Figure:
    """Map a quantity over frequency and phase difference, a panel for each amplitude; dots mark the best phases.

    `levels` has the published best phase of each amplitude [deg].
    """
    grid = grid.isel(bias=0).where(grid.settled.isel(bias=0))
    values = grid[quantity].transpose("amplitude", "phase", "frequency").values
    frequency = grid.frequency.values
    phase = np.degrees(grid[[str(name) for name in grid.coords if str(name).startswith("phase_")][-1]].values)
    figure = Figure(figsize=(WIDTH, 0.75 * WIDTH), layout="constrained")
    panels = figure.subplots(1, len(levels), sharex=True, sharey=True)
    norm = Normalize(0, np.nanmax(values))
    for axes, panel_values, (level, published) in zip(panels, values, levels.items(), strict=True):
        axes.pcolormesh(frequency, phase, panel_values, norm=norm, cmap=SEQUENCE, shading="nearest", ec="white", lw=0.4)
        best = np.nanargmin(panel_values, axis=0) if lowest else np.nanargmax(panel_values, axis=0)
        axes.plot(frequency, phase[best], "o", color="white", mec=INK, mew=0.7, ms=4)
        if published is not None and not lowest:
            axes.axhline(published, color=INK, lw=1.1, ls=(0, (4, 2)))
        axes.set_title(level)
        axes.grid(visible=False)
        axes.set(xticks=frequency[1::2], yticks=phase[::2])
    panels[0].set_ylabel("phase difference [deg]")
    figure.supxlabel("frequency [Hz]", fontsize=9)
    figure.colorbar(ScalarMappable(norm, SEQUENCE), ax=panels, location="top", aspect=40, label=label)
    return figure


@styled
def plot_dots(rows: Sequence[tuple[str, float, str]], label: str, *, log: bool = False) -> Figure:
    """Draw named numbers as dots on one scale, linear or logarithmic."""
    figure, axes = _axes(0.235 * len(rows) + 0.6)
    if log:
        axes.set_xscale("log")
    low = 0.6 * min(value for _, value, _ in rows) if log else 0.0
    for k, (_, value, kind) in enumerate(rows):
        color, marker, fill = DOTS[kind]
        axes.hlines(k, low, value, color=color, lw=1.0, alpha=0.5)
        axes.plot(value, k, marker, mec=color, mfc=fill, ms=6, mew=1.4)
        text = f"{value:.3g}" if value < 1000 else f"{value:.0f}"
        axes.annotate(text, (value, k), (6, 0), "data", "offset points", va="center", color=INK, fontsize=8.5)
    _name_rows(axes, [name for name, _, _ in rows])
    axes.set(xlabel=label, xlim=(low, (6 if log else 1.15) * max(value for _, value, _ in rows)))
    axes.spines["left"].set_visible(False)
    return figure


@styled
def plot_start(swims: Mapping[str, Swim]) -> Figure:
    """Plot the forward speed from rest: at every instant, and its mean over each beat."""
    figure, axes = _axes(0.62 * WIDTH)
    for k, (name, swim) in enumerate(swims.items()):
        motion, steps = swim.trajectory, swim.steps
        time, speed = motion.time.values, motion.forward_speed.values
        beats = (len(time) - 1) // steps
        mean = speed[: beats * steps].reshape(beats, steps).mean(axis=1)
        middle = (np.arange(beats) + 0.5) / swim.gait.frequency
        axes.plot(time, speed, color=COLORS[k], lw=0.8, alpha=0.55)
        axes.plot(middle, mean, color=COLORS[k], lw=1.8, label=f"{name}, mean of each beat")
    axes.set(xlabel="time [s]", ylabel="forward speed [m/s]", xlim=(0, time[-1]), ylim=(0, None))
    axes.legend(loc="lower right")
    return figure


@styled
def plot_against(published: ArrayLike, computed: Mapping[str, ArrayLike], *, within: float = 0.05) -> Figure:
    """Plot computed against published speeds."""
    figure, axes = _axes(0.8 * WIDTH)
    speeds = np.asarray(published, dtype=np.float64)
    ends = np.array([0.9 * speeds.min(), 1.05 * speeds.max()])
    band = f"within {100 * within:g} %"
    axes.fill_between(ends, (1 - within) * ends, (1 + within) * ends, color=GRID, lw=0, label=band)
    axes.plot(ends, ends, color=FAINT, lw=1)
    for k, (name, values) in enumerate(computed.items()):
        axes.plot(speeds, values, SHAPES[k], color=COLORS[k], ms=6, mec="white", mew=0.6, label=name)
    axes.set(xlabel="published speed [m/s]", ylabel="computed speed [m/s]", xlim=tuple(ends))
    figure.legend(loc="outside upper left", ncols=2, **TIGHT)
    return figure


@styled
def plot_normalized(
    frequency: ArrayLike,
    cost: Mapping[str, ArrayLike],
    published: Sequence[tuple[float, float, str]],
) -> Figure:
    """Plot normalized cost of transport against frequency."""
    figure, axes = _axes(0.62 * WIDTH)
    for k, (name, values) in enumerate(cost.items()):
        axes.plot(frequency, values, color=COLORS[k], marker=SHAPES[k], **POINTS, label=f"{name}, mechanical")
    for hertz, value, name in published:
        axes.plot(hertz, value, "*", color=INK, ms=12, mec="white")
        axes.annotate(name, (hertz, value), (-4, 9), "data", "offset points", ha="right", color=INK, fontsize=8.5)
    axes.set(xlabel="frequency [Hz]", ylabel="cost of transport\nover that of the fastest gait", ylim=(0, 1.3))
    axes.legend(loc="upper left")
    return figure


@styled
def plot_descent(curves: Mapping[str, ArrayLike], label: str, *, lowest: float = 1e-7) -> Figure:
    """Plot the distance of searches from their optimum over iterations, on a logarithmic scale."""
    figure, axes = _axes(0.68 * WIDTH)
    for k, (name, values) in enumerate(curves.items()):
        value = np.asarray(values, dtype=np.float64)
        visible = np.where(np.isfinite(value) & (value > lowest), value, np.nan)
        axes.semilogy(np.arange(1, len(value) + 1), visible, color=COLORS[k], ls=LINES[k % len(LINES)], label=name)
    axes.set(xlabel="iteration", ylabel=label)
    axes.legend(loc="upper right", ncols=2)
    return figure


@styled
def plot_changes(names: Sequence[str], bars: Mapping[str, Sequence[float]]) -> Figure:
    """Draw changes in percent as groups of bars."""
    figure, axes = _axes(0.2 * len(bars) * len(names) + 1.3)
    rows, thickness = np.arange(len(names)), 0.8 / len(bars)
    for k, (name, values) in enumerate(bars.items()):
        heights = rows + (k - (len(bars) - 1) / 2) * thickness
        color = (INK, *COLORS)[k]
        axes.barh(heights, values, 0.85 * thickness, color=color, label=name)
        for y, value in zip(heights, values, strict=True):
            offset, side = (3, "left") if value >= 0 else (-3, "right")
            style: dict[str, Any] = {"va": "center", "ha": side, "color": INK, "fontsize": 8}
            axes.annotate(f"{value:+.1f}", (value, y), (offset, 0), textcoords="offset points", **style)
    axes.axvline(0, color=FAINT, lw=0.8)
    axes.margins(x=0.16)
    axes.set(xlabel="change by optimization [%]")
    _name_rows(axes, names)
    figure.legend(loc="outside upper left", ncols=2, **TIGHT)
    return figure


@styled
def plot_intervals(
    names: Sequence[str],
    bounds: tuple[ArrayLike, ArrayLike],
    published: ArrayLike,
    identified: Mapping[str, tuple[ArrayLike, ArrayLike, ArrayLike]],
) -> Figure:
    """Draw coefficients and their intervals between their bounds."""
    low, high = (np.asarray(side, dtype=np.float64) for side in bounds)
    figure, axes = _axes(0.38 * len(names) + 1.1)
    rows = np.arange(len(names))
    for k, (name, columns) in enumerate(identified.items()):
        value, lower, upper = ((np.asarray(column, dtype=np.float64) - low) / (high - low) for column in columns)
        heights = rows + 0.26 * (k - (len(identified) - 1) / 2)
        axes.hlines(heights, lower, upper, color=COLORS[k], lw=2.4, alpha=0.45)
        axes.plot(value, heights, SHAPES[k], color=COLORS[k], ms=6, mec="white", mew=0.6, label=name, clip_on=False)
    axes.plot((np.asarray(published) - low) / (high - low), rows, "|", color=INK, ms=16, mew=2.4, label="published")
    _name_rows(axes, names)
    axes.set(xlabel="place between the bounds of Table III", xlim=(0, 1))
    axes.set_xticks([0, 0.5, 1], ["lower", "middle", "upper"])
    figure.legend(loc="outside upper left", ncols=3, **TIGHT)
    return figure


@styled
def plot_paths(paths: Mapping[str, ArrayLike], names: Sequence[str]) -> Figure:
    """Plot coefficients over iterations, relative to their bounds [1]: a column for each model, a row for each kind."""
    kinds = [name.partition("[")[0] for name in names]
    links = [name.partition("[")[2].rstrip("]") for name in names]
    rows, lines = list(dict.fromkeys(kinds)), list(dict.fromkeys(links))
    figure = Figure(figsize=(WIDTH, 0.28 * WIDTH * len(rows) + 0.7), layout="constrained")
    panels = figure.subplots(len(rows), len(paths), sharex="col", sharey=True, squeeze=False)
    for column, (model, path) in zip(panels.T, paths.items(), strict=True):
        for kind, link, values in zip(kinds, links, np.asarray(path, dtype=np.float64).T, strict=True):
            k = lines.index(link)
            style = {"color": COLORS[k], "ls": LINES[k], "lw": 2.4 - 0.5 * k}  # narrow lines on top of wide ones
            column[rows.index(kind)].plot(np.arange(len(values)), values, label=f"link {link}", **style)
        column[0].set_title(model)
        column[-1].set_xlabel("iteration")
    for kind, axes in zip(rows, panels[:, 0], strict=True):
        axes.set(ylabel=kind, ylim=(-0.06, 1.06), yticks=[0, 1], yticklabels=["lower", "upper"])
    handles, texts = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside upper left", ncols=3, **TIGHT)
    return figure


@styled
def plot_passive(record: Mapping[str, Any], width: float = WIDTH) -> Figure:
    """Plot electrical costs over speed with the range of the family, and the best stiffness over speed."""
    stacked = width == WIDTH
    figure = Figure(figsize=(width, (1.6 if stacked else 0.95) * WIDTH), layout="constrained")
    costs, springs = figure.subplots(*((2, 1) if stacked else (1, 2)))
    for k, (law, label) in enumerate(LAWS.items()):
        for j, kind in enumerate(KINDS):
            best, style = record["electrical"][law][kind], {"color": COLORS[j], "ls": LINES[k]}
            points = [(float(name), best[name]["cost"]) for name in COSTS if best[name]]
            costs.plot(*np.transpose(points), marker=SHAPES[k], **style, **POINTS, label=f"{kind}, {label}")
            for speed in COSTS:
                family = [one[kind][speed]["cost"] for one in record["family"][law].values() if one[kind][speed]]
                if family:
                    x = float(speed) + 0.012 * (j - 0.5) + 0.005 * (k - 0.5)
                    costs.vlines(x, *np.percentile(family, (5, 95)), color=COLORS[j], lw=3, alpha=0.3)
        tuned = record["mechanical"][law][PLACE]["tuned"]
        speeds = np.array([float(name) for name in tuned])
        spring, low, high = ([one[key] for one in tuned.values()] for key in ("stiffness", "low", "high"))
        springs.fill_between(speeds, low, high, color=COLORS[2 + k], alpha=0.2, lw=0)
        springs.plot(speeds, spring, color=COLORS[2 + k], ls=LINES[k], marker=SHAPES[k], **POINTS, label=label)
        springs.plot(
            speeds, spring[0] * (speeds / speeds[0]) ** 2, color=FAINT, lw=1, label="square law" if k else None
        )
    costs.set(xlabel="speed [m/s]", ylabel="electrical cost [J/(kg m)]", ylim=(0, None), xticks=[0.3, 0.4, 0.5])
    springs.set(xlabel="speed [m/s]", ylabel="best stiffness [N m/rad]", xscale="log", yscale="log")
    springs.set_xticks([0.2, 0.3, 0.4], ["0.2", "0.3", "0.4"])
    springs.minorticks_off()
    springs.legend(loc="upper left")
    figure.legend(*costs.get_legend_handles_labels(), loc="outside upper left", ncols=2, **TIGHT)
    return figure
