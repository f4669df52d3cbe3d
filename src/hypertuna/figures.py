"""Style of figures: colors for every kind of color vision, fonts, lines; saving."""

import io
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.text import Text

from hypertuna.display import in_notebooks
from hypertuna.io.files import write_atomically

# Colors of Okabe and Ito, distinct for every kind of color vision; markers and dashes repeat the distinction.
COLORS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
SHAPES = ("o", "s", "^", "D", "v", "P")  # Matplotlib's markers, in the order of `COLORS`
LINES = ("-", (0, (5, 2)), (0, (2, 1.5)), (0, (6, 2, 1.5, 2)))  # Matplotlib's line styles
INK, BODY, EDGE = "#222222", "#DCE6EC", "#8A99A3"

P = ParamSpec("P")

WIDTH = 7.2  # width of a figure [inch]: two columns of a journal
FAINT, GRID = "#6B7780", "#D5DCE1"  # of axes; of grid lines

# Colors of rising lightness, distinct in gray and for every kind of color vision.
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
    "axes.formatter.useoffset": False,
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


POINTS: dict[str, Any] = {"ms": 4.2, "mec": "white", "mew": 0.5}  # style of measured points
# Spacing of a legend.
TIGHT: dict[str, Any] = {"borderaxespad": 0.2, "handletextpad": 0.5, "columnspacing": 1.2, "handlelength": 1.6}


def styled(plot: Callable[P, Figure]) -> Callable[P, Figure]:
    """Return a function whose figures are drawn in this style, independent of the user's settings."""

    @wraps(plot)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(STYLE)
            figure = plot(*args, **kwargs)
            _flatten_rounding(figure)
            return in_notebooks(figure)

    return drawn


def _flatten_rounding(figure: Figure) -> None:
    """Widen axes whose values differ by rounding only: ticks such as +6.12e-11 are noise."""
    for axes in figure.axes:
        for kind, set_limits in (("x", axes.set_xlim), ("y", axes.set_ylim)):
            low, high = getattr(axes, f"get_{kind}lim")()
            magnitude = max(abs(low), abs(high))
            if getattr(axes, f"get_{kind}scale")() == "linear" and abs(high - low) < max(1e-9 * magnitude, 1e-9):
                margin = 0.05 * magnitude if magnitude > 1e-9 else 1.0
                set_limits((low + high) / 2 - margin, (low + high) / 2 + margin)


def sequence(count: int) -> list[Any]:
    """Return `count` colors from the first to the last of SEQUENCE; a single color is blue."""
    return [SEQUENCE(fraction) for fraction in np.linspace(0, 1, count)] if count > 1 else [COLORS[1]]


def line_style(k: int, first: int = 0) -> dict[str, Any]:
    """Return color and dashes of the k-th line of a plot, counted from the color `first`; no two lines look alike."""
    return {"color": COLORS[(first + k) % len(COLORS)], "ls": LINES[k // len(COLORS) % len(LINES)]}


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as .svg, .png or .pdf, whole or not at all."""
    disable_formulas(figure)
    kind = Path(path).suffix.removeprefix(".").lower()
    content = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "hypertuna"}):
        figure.savefig(content, format=kind, dpi=200, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(path, content.getvalue())


def disable_formulas(figure: Figure) -> None:
    """Show dollar signs in names as characters: only tick labels of logarithmic axes are formulas."""
    for text in figure.findobj(Text):
        if isinstance(text, Text) and "$" in text.get_text() and "mathdefault" not in text.get_text():
            text.set_parse_math(False)
