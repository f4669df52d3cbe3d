"""Figure of a fit to bench runs: measured against fitted with the loops, and the spectrum of combinations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hypertuna.actuation.bending import SIDES, bend
from hypertuna.characterization.combinations import DETERMINED
from hypertuna.characterization.data import Loop
from hypertuna.characterization.fit import BenchFit
from hypertuna.figures import COLORS, FAINT, INK, TIGHT, WIDTH, styled

__all__ = ["plot_bench"]

Array = NDArray[np.float64]

POINTS = 24  # pressures of a drawn curve
FAR = 5.0  # standard deviations of a row's angle, from which on it was likely misread
LEAST = 1e-3  # singular value at which the axis ends: what is below is nothing


@styled
def plot_bench(fit: BenchFit, *, width: float = WIDTH) -> Figure:
    """Plot a fit to bench runs.

    Parameters
    ----------
    fit : BenchFit
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
        For each joint the bends of both sides, measured and fitted, loading and unloading; below, how many times
        better the bench knows each combination of the unknowns than it was known before.
    """
    joints = fit.bench.joints
    figure = Figure(figsize=(width, 0.42 * width + 0.36 * width), layout="constrained")
    grid = figure.add_gridspec(2, len(joints), height_ratios=(1.15, 1))
    for column, joint in enumerate(joints):
        _draw_joint(figure.add_subplot(grid[0, column]), fit, joint)
    below = grid[1, :].subgridspec(1, 2, width_ratios=(1, 1.15))
    _draw_spectrum(figure.add_subplot(below[0]), fit)
    _draw_unknowns(figure.add_subplot(below[1]), fit)
    known: dict[str, Any] = {}
    for axes in figure.axes[: len(joints)]:
        known |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(list(known.values()), list(known), loc="outside upper right", ncols=5, **TIGHT)
    return figure


def _draw_joint(axes: Axes, fit: BenchFit, joint: int) -> None:
    """Draw the loops of a joint: left bends upwards, right bends downwards."""
    bench = fit.bench
    for loop in bench.loops:
        if loop.joint != joint:
            continue
        sign, color = 1 - 2 * loop.side, COLORS[1 - loop.side]
        _draw_loop(axes, fit, loop, color)
        for unload, face in ((False, color), (True, "white")):
            rows = loop.rows[bench.unload[loop.rows] == unload]
            if len(rows):
                label = f"{SIDES[loop.side]}, {'unloading' if unload else 'loading'}"
                known = label in axes.get_legend_handles_labels()[1]
                angles = sign * np.degrees(bench.angle[rows])
                style: Any = {"ms": 4.2, "mec": color, "mfc": face, "mew": 0.9, "color": color}
                axes.plot(bench.pressure[rows] / 1e3, angles, "o", label=None if known else label, **style)
    off = np.flatnonzero((bench.joint == joint) & _misread(fit))
    if len(off):
        signs = 1 - 2 * bench.side[off]
        place = (bench.pressure[off] / 1e3, signs * np.degrees(bench.angle[off]))
        axes.plot(*place, "x", color=INK, ms=10, mew=1.3, zorder=5, label="far from the fit")
    axes.axhline(0, color=FAINT, lw=0.8)
    axes.set_title(f"joint {fit.robot.joints[joint].name}")
    axes.set(xlabel="gauge pressure [kPa]", ylabel="bend [deg]", xlim=(0, None))


def _misread(fit: BenchFit) -> NDArray[np.bool_]:
    """Tell which angles are so far from the fit that they were likely misread."""
    noise = np.where(np.isnan(fit.bench.angle_sd), fit.noise.get("angle", np.nan), fit.bench.angle_sd)
    return np.asarray(np.abs(fit.angle - fit.bench.angle) > FAR * fit.residual_scale * noise)


def _draw_loop(axes: Axes, fit: BenchFit, loop: Loop, color: str) -> None:
    """Draw what the fit says of a loop."""
    sign = 1 - 2 * loop.side
    pressure = np.linspace(0, loop.top, POINTS)
    back = bool(fit.bench.unload[loop.rows].any())
    found = bend(fit.robot, loop.joint, pressure, side=SIDES[loop.side], unload=back)
    axes.plot(pressure / 1e3, sign * np.degrees(found.angle), color=color, lw=1.2)
    if found.unload_pressure is not None and found.unload_angle is not None:
        path = (found.unload_pressure / 1e3, sign * np.degrees(found.unload_angle))
        axes.plot(*path, color=color, lw=1.2, ls=(0, (4, 2)))


def _draw_spectrum(axes: Axes, fit: BenchFit) -> None:
    """Draw the singular values: what the bench knows over what was known."""
    values = np.array([one.singular_value for one in fit.directions])
    rank = np.arange(1, len(values) + 1)
    known = np.array([one.determined for one in fit.directions])
    threshold = math.sqrt(DETERMINED**2 - 1)  # 1 / sqrt(1 + s^2) of an interval is left
    axes.axhspan(LEAST / 2, threshold, color=FAINT, alpha=0.12, lw=0)
    zero = values < LEAST
    if zero.any():
        axes.plot(
            rank[zero], np.full(zero.sum(), LEAST), "v", mec=FAINT, mfc="white", ms=5, label="nothing known", zorder=3
        )
    for mine, color, label in ((known, COLORS[1], "determined"), (~known & ~zero, FAINT, "left free")):
        if mine.any():
            axes.vlines(rank[mine], LEAST / 2, values[mine], color=color, lw=1.0)
            axes.plot(rank[mine], values[mine], "o", color=color, ms=5, label=label)
    axes.set_yscale("log")
    axes.set(xlabel="combination of the unknowns", ylabel="singular value")
    axes.set_ylim(LEAST / 2, 100 * max(values.max(), LEAST))  # room for the legend
    axes.set_xticks(rank)
    axes.tick_params(axis="x", labelsize=7.5)
    axes.set_title("spectrum")
    axes.legend(loc="upper right")


def _draw_unknowns(axes: Axes, fit: BenchFit) -> None:
    """Draw each unknown's interval within its bounds."""
    for row, (one, value, low, high, narrowing) in enumerate(
        zip(fit.free, fit.values, fit.low, fit.high, fit.narrowing, strict=True)
    ):
        color = COLORS[1] if narrowing >= DETERMINED else FAINT
        lower, extent = math.log(one.lower), math.log(one.upper / one.lower)
        ends = [(math.log(x) - lower) / extent for x in (low, value, high)]
        axes.plot([0, 1], [-row, -row], color=FAINT, lw=0.6, alpha=0.5)
        axes.plot([ends[0], ends[2]], [-row, -row], color=color, lw=3, solid_capstyle="butt")
        axes.plot(ends[1], -row, "o", color=color, mec="white", ms=4.5)
    axes.set_yticks(-np.arange(len(fit.free)), [one.name for one in fit.free], fontsize=7.5, color=INK)
    axes.set_xticks([0, 1], ["lower", "upper"])
    axes.set_xlabel("bounds, logarithmic")
    axes.set_title("95 % intervals")
    axes.grid(axis="y", visible=False)
