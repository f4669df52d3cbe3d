"""Figure of a bend by finite elements: angle over pressure, and pressure over the oil taken in."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from hypertuna.actuation.bending import bend as fast_bend
from hypertuna.display import plots
from hypertuna.fe.bend import FeBend, described_bend
from hypertuna.figures import COLORS, FAINT, INK, POINTS, TIGHT, WIDTH, styled

KILO, MILLILITER = 1e3, 1e-6  # Pa per kPa, m^3 per ml
SMOOTH = 50  # number of pressures of the fast model's curve
NARROW = 6.0  # inch, width of a figure below which the legend has one column
ELEMENTS: dict[str, Any] = POINTS | {"color": COLORS[1], "label": "finite elements", "marker": "o", "zorder": 3}
ANALYTIC: dict[str, Any] = {"color": FAINT, "lw": 1.2, "ls": (0, (5, 2))}
ANALYTIC["label"] = "fast model (no friction)"


@plots.of(FeBend)
def plot_result(bend: FeBend, *, width: float = WIDTH) -> Figure:
    """Plot the bend by finite elements and by the fast model, both without friction; `width` in inches."""
    path = np.linspace(0, max(float(bend.pressure[-1]), 1.0), SMOOTH)
    fast = fast_bend(bend.robot, bend.joint, path, side=bend.side, material=bend.material, friction=False)
    title = f"{bend.robot.name}, joint {bend.joint}, {bend.side} side, material set {bend.material}"
    analytic = (fast.pressure, fast.angle, fast.volume)
    described = described_bend(bend.robot, bend.joint)
    return plot_fe_bend(bend.pressure, bend.angle, bend.oil, analytic, described, title, width=width)


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
    """Plot bend over pressure, and pressure over the oil taken in, by finite elements and by the fast model.

    `pressure` (n,) [Pa], `angle` (n,) [rad] and `oil` (n,) [m^3] are of finite elements; `analytic` has the same three
    (m,) of the fast model; `published` is a pressure and an angle; `width` in inches.
    """
    figure = Figure(figsize=(width, 0.4 * width + 0.5), layout="constrained")
    panels = figure.subplots(1, 1 if oil is None else 2, squeeze=False)[0]
    lines = [(ANALYTIC, analytic)] if analytic else []
    for style, (pressures, angles, oil_taken) in (*lines, (ELEMENTS, (pressure, angle, oil))):
        x = np.asarray(pressures) / KILO
        panels[0].plot(x, np.degrees(angles), **style)
        if oil is not None and oil_taken is not None:
            panels[1].plot(np.asarray(oil_taken) / MILLILITER, x, **style)
    if published is not None:
        described = published[0] / KILO, np.degrees(published[1])
        panels[0].plot(*described, "x", color=INK, ms=7, mew=1.6, zorder=5, label="published")
    panels[0].set(xlabel="gauge pressure [kPa]", ylabel="bend [deg]", xlim=(0, None), ylim=(0, None))
    if oil is not None:
        panels[1].set(xlabel="oil taken in [ml]", ylabel="gauge pressure [kPa]", xlim=(0, None), ylim=(0, None))
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5, fontweight="bold")
    columns = 3 if width >= NARROW else 1
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=columns, **TIGHT)
    return figure
