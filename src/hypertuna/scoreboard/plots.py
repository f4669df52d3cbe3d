"""Figures: predicted over published speeds, and Gazzola's line of Reynolds over swimming numbers."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.display import plots
from hypertuna.figures import COLORS, EDGE, FAINT, INK, POINTS, SHAPES, TIGHT, WIDTH, styled
from hypertuna.scoreboard.laws import Shoal, gazzola
from hypertuna.scoreboard.scores import FAR, Scoreboard


@plots.of(Scoreboard)
@styled
def plot_scoreboard(board: Scoreboard, *, width: float = WIDTH) -> Figure:
    """Plot predicted over published speeds, and Reynolds over swimming numbers: `width` [inch]."""
    figure = Figure(figsize=(width, 0.56 * width + 0.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    _draw_speeds(left, board)
    _draw_law(right, board)
    names = dict.fromkeys(score.swimmer for score in board.speeds)
    legend = textwrap.wrap(
        "   ".join(f"{k} {name}".replace(" ", "\N{NO-BREAK SPACE}") for k, name in enumerate(names, 1)),
        round(20 * width),
    )
    figure.supxlabel("\n".join(legend), fontsize=6.5, color=FAINT, x=0.01, ha="left")
    return figure


def _draw_speeds(axes: Axes, board: Scoreboard) -> None:
    """Draw each run with its band, the line of equality, and a factor of two; each swimmer has a number."""
    speeds = board.speeds
    published, predicted, own = (
        np.array([getattr(score, name) for score in speeds]) for name in ("published", "predicted", "own")
    )
    low, high = np.array([score.band or (np.nan, np.nan) for score in speeds]).reshape(-1, 2).T
    positive = np.concatenate([values[values > 0] for values in (published, predicted, low, high, own)] or [np.ones(1)])
    limits = np.array([0.7 * positive.min(initial=1.0), 1.4 * positive.max(initial=1.0)])
    axes.fill_between(limits, limits / FAR, limits * FAR, color=EDGE, alpha=0.18, lw=0, label=f"factor of {FAR:g}")
    axes.plot(limits, limits, color=INK, lw=0.9, label="equal")
    axes.vlines(published, low, high, color=COLORS[1], lw=1.2, alpha=0.6, label="90 % band")
    axes.plot(published, predicted, ls="", marker=SHAPES[0], color=COLORS[1], label="length, mass, nose", **POINTS)
    axes.plot(published, own, ls="", marker=SHAPES[3], color=COLORS[0], mfc="none", ms=4, label="own sections")
    for number, name in enumerate(dict.fromkeys(score.swimmer for score in speeds), 1):
        first = next(score for score in speeds if score.swimmer == name)
        place = (first.published, first.predicted)
        axes.annotate(f"{number}", place, xytext=(4, -6), textcoords="offset points", fontsize=6.5, color=FAINT)
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=limits, title="Speed [m/s]")
    axes.set(xlabel="published", ylabel="predicted")
    axes.legend(loc="upper left", **TIGHT)


def _draw_law(axes: Axes, board: Scoreboard) -> None:
    """Draw Reynolds over swimming numbers of random fish and of the swimmers, and Gazzola's line."""
    shoals: tuple[tuple[Shoal, str, dict[str, Any]], ...] = (
        (board.shoal, f"{len(board.shoal.speed)} random fish", {"color": EDGE, "marker": ".", "ms": 4}),
        (
            board.swum("published"),
            "swimmers, published",
            {"color": COLORS[2], "marker": SHAPES[2], "mfc": "none", "ms": 4},
        ),
        (board.swum("predicted"), "swimmers, predicted", {"color": COLORS[1], "marker": SHAPES[0], **POINTS}),
    )
    for shoal, label, style in shoals:
        axes.plot(shoal.swimming, shoal.reynolds, ls="", label=label, **style)
    numbers = np.concatenate([shoal.swimming[np.isfinite(shoal.swimming)] for shoal, *_ in shoals])
    swimming = np.geomspace(0.7 * numbers.min(), 1.4 * numbers.max(), 200)
    axes.plot(swimming, gazzola(swimming), color=INK, lw=0.9, label="Gazzola et al. 2014")
    axes.set(xscale="log", yscale="log", title="The line of all swimmers")
    axes.set(xlabel="swimming number 2πfAL/ν", ylabel="Reynolds number UL/ν")
    axes.legend(loc="lower right", **TIGHT)
