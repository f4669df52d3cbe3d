"""Figure of a bend by finite elements: angle over pressure, and the oil that it takes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from hypertuna.figures import COLORS, FAINT, INK, POINTS, TIGHT, WIDTH, styled

KILO, MILLILITER = 1e3, 1e-6
NARROW = 6.0  # inch, below which the legend has one column
DASHED = (0, (5, 2))


@styled
def plot_fe_bend(
    pressure: ArrayLike,
    angle: ArrayLike,
    oil: ArrayLike | None = None,
    analytic: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
    published: tuple[float, float] | None = None,
    title: str = "",
    *,
    width: float = WIDTH,
) -> Figure:
    """Plot bend over pressure, and pressure over the oil taken in.

    `pressure` (n,) [Pa], `angle` (n,) [rad], `oil` (n,) [m^3]; `analytic` has the same three, (m,); `published` is a
    pressure and an angle; `width` in inches.
    """
    figure = Figure(figsize=(width, 0.4 * width + 0.5), layout="constrained")
    panels = figure.subplots(1, 1 if oil is None else 2, squeeze=False)[0]
    x, y = np.asarray(pressure) / KILO, np.degrees(angle)
    _curves(panels[0], x, y, None if analytic is None else (np.asarray(analytic[0]) / KILO, np.degrees(analytic[1])))
    if published is not None:
        place = published[0] / KILO, np.degrees(published[1])
        panels[0].plot(*place, "x", color=INK, ms=7, mew=1.6, zorder=5, label="published")
    panels[0].set(xlabel="gauge pressure [kPa]", ylabel="bend [deg]", xlim=(0, None), ylim=(0, None))
    if oil is not None:
        taken = None if analytic is None else np.asarray(analytic[2]) / MILLILITER
        other = None if analytic is None or taken is None else (taken, np.asarray(analytic[0]) / KILO)
        _curves(panels[1], np.asarray(oil) / MILLILITER, x, other)
        panels[1].set(xlabel="oil taken in [ml]", ylabel="gauge pressure [kPa]", xlim=(0, None), ylim=(0, None))
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5, fontweight="bold")
    columns = 3 if width >= NARROW else 1
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=columns, **TIGHT)
    return figure


def _curves(axes: Axes, x: ArrayLike, y: ArrayLike, analytic: tuple[ArrayLike, ArrayLike] | None) -> None:
    """Draw finite elements as a line with points, the analytic model dashed."""
    if analytic is not None:
        axes.plot(*analytic, color=FAINT, lw=1.2, ls=DASHED, label="analytic model (friction, rising pressure)")
    axes.plot(x, y, "o-", color=COLORS[1], label="finite elements", zorder=3, **POINTS)
