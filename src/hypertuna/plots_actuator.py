"""Figure of a bending joint: its hysteresis loop, and what the material sets make of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.actuator import Bend
from hypertuna.figures import COLORS, FAINT, INK, TIGHT, WIDTH, styled

__all__ = ["plot_bend"]

DASHES = ((0, (5, 2)), (0, (1, 1.5)), (0, (5, 1.5, 1, 1.5)))


@styled
def plot_bend(bend: Bend, sets: Mapping[str, Bend], *, width: float = WIDTH) -> Figure:
    """Plot a joint's angle over the pressure.

    Parameters
    ----------
    bend : Bend
        The one to tell: loading, and unloading where it has that.
    sets : mapping of Bend
        The same joint by every material set, `bend` among them: the band that they span, and their lines.
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
        With the largest bend of the robot's description as a cross.
    """
    figure = Figure(figsize=(width, 0.4 * width + 1.4), layout="constrained")
    axes = figure.subplots()
    pressure = bend.pressure / 1e3
    angles = np.degrees([found.angle for found in sets.values()])
    if len(angles) > 1:
        axes.fill_between(pressure, angles.min(axis=0), angles.max(axis=0), color=FAINT, alpha=0.15, lw=0)
    _draw_loop(axes, bend)
    others = (found for name, found in sets.items() if name != bend.material)
    for found, dashes in zip(others, DASHES, strict=False):
        axes.plot(pressure, np.degrees(found.angle), color=FAINT, lw=1.1, ls=dashes, label=f"{found.material} set")
    group = next(group for group in bend.robot.joints if group.name == bend.joint)
    if group.bend_max is not None and group.pressure_max is not None:
        place = (group.pressure_max / 1e3, np.degrees(group.bend_max))
        axes.plot(*place, "x", color=INK, ms=7, mew=1.6, zorder=5, label="largest bend, as described")
    equations = "" if bend.law == "corrected" else ", equations as printed"
    axes.set_title(f"{bend.robot.name}, joint {bend.joint}, {bend.side} side{equations}")
    axes.set(xlabel="gauge pressure [kPa]", ylabel="bend [deg]", xlim=(0, None), ylim=(0, None))
    figure.legend(loc="outside lower left", ncols=3 if width > 6 else 2, **TIGHT)
    return figure


def _draw_loop(axes: Axes, bend: Bend) -> None:
    """Draw both branches, with an arrow in the middle of each."""
    color = COLORS[1]
    branches = [(bend.pressure / 1e3, np.degrees(bend.angle), "-", "loading")]
    if bend.unload_pressure is not None and bend.unload_angle is not None:
        branches.append((bend.unload_pressure / 1e3, np.degrees(bend.unload_angle), "-", "unloading"))
    for k, (pressure, angle, line, text) in enumerate(branches):
        shade = color if k == 0 else COLORS[0]
        axes.plot(pressure, angle, line, color=shade, zorder=3, label=f"{bend.material}, {text}")
        middle = len(pressure) // 2
        if len(branches) > 1 and 0 < middle < len(pressure) - 1:
            before, after = ((pressure[k], angle[k]) for k in (middle - 1, middle))
            style = {"arrowstyle": "-|>", "color": shade, "lw": 0, "mutation_scale": 13}
            axes.annotate("", after, before, arrowprops=style)
