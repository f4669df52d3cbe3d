"""How figures look: colors for every kind of color vision, letters, lines."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from hypertuna.drawing import COLORS, INK

__all__ = ["FAINT", "GRID", "POINTS", "SEQUENCE", "TIGHT", "WIDTH", "sequence", "styled"]

P = ParamSpec("P")

WIDTH = 7.2  # of a figure, inches: two columns of a journal
FAINT, GRID = "#6B7780", "#D5DCE1"

# A sequence of colors whose lightness rises, so that it also reads in gray and for every kind of color vision.
SEQUENCE = LinearSegmentedColormap.from_list("depth", ["#4059A8", "#1F80BF", "#22A39B", "#7FB24A", "#E3A63C"])

STYLE: Any = {
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.labelsize": 9,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "axes.facecolor": "none",
}


POINTS: dict[str, Any] = {"ms": 4.2, "mec": "white", "mew": 0.5}
TIGHT: dict[str, Any] = {"borderaxespad": 0.2, "handletextpad": 0.5, "columnspacing": 1.2, "handlelength": 1.6}


def styled(plot: Callable[P, Figure]) -> Callable[P, Figure]:
    """Give the figures of a function one look, whatever the user's settings are.

    Parameters
    ----------
    plot : callable
        Returns a figure.

    Returns
    -------
    callable
    """

    @wraps(plot)
    def inside(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(STYLE)
            return plot(*args, **kwargs)

    return inside


def sequence(count: int) -> list[Any]:
    """Return colors from first to last.

    Parameters
    ----------
    count : int

    Returns
    -------
    list
        Of RGBA colors; a single one is the blue of the others' plots.
    """
    return [SEQUENCE(part) for part in np.linspace(0, 1, count)] if count > 1 else [COLORS[1]]
