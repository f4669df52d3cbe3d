"""Figure of a robot: from the side, and from above with the midlines of a beat."""

from __future__ import annotations

from itertools import accumulate
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.figures import BODY, COLORS, EDGE, INK, SHAPES
from hypertuna.swimming.gait import Gait, named_gait
from hypertuna.swimming.trajectory import body_points

PHASES = 12  # midlines in one beat
WIDTH = 7.2  # of the figure, inches


def plot_robot(robot: Robot, *, width: float = WIDTH) -> Figure:
    """Plot a robot to scale from the side and from above: `width` [inch]."""
    length, heights = robot.body.length, np.divide(robot.links.lateral_area, robot.links.length)
    lines = _midlines(robot)
    side_half = heights.max() / 2 / length
    top_half = max(np.abs(lines[..., 1]).max() / length, 0.06)
    side_above, side_below, top_above, top_below = side_half + 0.11, side_half + 0.10, top_half + 0.08, top_half + 0.03
    tall = side_above + side_below + top_above + top_below  # body lengths, as everything here
    wide = 1.08
    figure = Figure(figsize=(width, width * tall / wide), facecolor="white")
    side, top = figure.subplots(2, 1, height_ratios=[side_above + side_below, top_above + top_below])
    figure.subplots_adjust(left=0, right=1, top=1, bottom=0, hspace=0)
    for axes, above, below in ((side, side_above, side_below), (top, top_above, top_below)):
        axes.set_axis_off()
        axes.set(xlim=(-0.04 * length, 1.04 * length), ylim=(-below * length, above * length), aspect="equal")
    _draw_side(side, robot, heights)
    _draw_top(top, robot, lines)
    return figure


def midline(robot: Robot, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the joints' positions (links + 1, 2) [m] at angles (groups,) [rad], head held still (Eqs 21-24)."""
    bends = np.zeros(len(robot.links.length))
    for group, angle in zip(robot.joints, angles, strict=True):
        bends[list(group.links)] = np.multiply(group.share, angle)
    line: NDArray[np.float64] = body_points(robot, np.zeros((1, 3)), bends[np.newaxis])[0]
    return line


def _midlines(robot: Robot) -> NDArray[np.float64]:
    """Return the midlines over one beat of the first gait, or the straight one: shape (phases, links + 1, 2)."""
    groups = len(robot.joints)
    rest = Gait(1.0, (0.0,) * groups, (0.0,) * groups)
    gait = named_gait(robot, next(iter(robot.gaits))) if robot.gaits else rest
    clock = 2 * np.pi * np.arange(PHASES) / PHASES
    angles = np.array(gait.bias) + np.array(gait.amplitude) * np.sin(clock[:, None] - np.array(gait.phase))
    return np.stack([midline(robot, angle) for angle in angles])


def _draw_side(axes: Axes, robot: Robot, heights: NDArray[np.float64]) -> None:
    """Draw the links seen from the side, with joints, centers of mass and a scale bar."""
    links, length = robot.links, robot.body.length
    fronts = [0.0, *accumulate(links.length)]
    gap = 0.002 * length
    for x, long, high, name in zip(fronts, links.length, heights, links.name, strict=False):
        corner = min(0.02 * length, 0.3 * long, 0.3 * high)
        box = f"round,pad=0,rounding_size={corner}"
        axes.add_patch(
            FancyBboxPatch((x + gap / 2, -high / 2), long - gap, high, boxstyle=box, fc=BODY, ec=EDGE, lw=0.9)
        )
        axes.text(x + long / 2, high / 2 + 0.01 * length, name, ha="center", va="bottom", color=INK, fontsize=7)
    axes.plot(np.add(fronts[:-1], links.com), np.zeros(len(links.com)), "+", color=INK, ms=6, mew=1.1, zorder=3)
    for g, group in enumerate(robot.joints):
        axes.plot([fronts[i] for i in group.links], [0.0] * len(group.links), **_mark(g), zorder=4)
    _title(axes, f"{robot.name} from the side: {length:.3g} m, {robot.body.mass:.3g} kg; links at their mean height")
    below = -heights.max() / 2 - 0.055 * length
    _legend(axes, robot, below)
    _scale_bar(axes, length, below)


def _draw_top(axes: Axes, robot: Robot, lines: NDArray[np.float64]) -> None:
    """Draw the midlines of one beat seen from above, the head held still."""
    for line in lines:
        axes.plot(*line.T, color=EDGE, lw=0.8, alpha=0.6, solid_joinstyle="round")
    widest = lines[np.argmax(lines[:, -1, 1])]
    axes.plot(*widest.T, color=INK, lw=2.0, solid_capstyle="round", solid_joinstyle="round")
    for g, group in enumerate(robot.joints):
        axes.plot(*widest[list(group.links)].T, **_mark(g), zorder=4)
    name = next(iter(robot.gaits), None)
    axes.annotate(
        "swims this way",
        (0, 0.05 * robot.body.length),
        (0.07 * robot.body.length, 0.05 * robot.body.length),
        arrowprops={"arrowstyle": "->", "color": INK, "lw": 1.0},
        color=INK,
        fontsize=8,
        va="center",
    )
    _title(axes, f"from above: one beat of {name}, head held still" if name else "from above")


def _title(axes: Axes, text: str) -> None:
    """Write what a view shows in its upper left corner."""
    axes.annotate(text, (0.037, 1), (0, -8), "axes fraction", "offset points", color=INK, fontsize=9, va="top")


def _mark(group: int) -> dict[str, Any]:
    """Return color and shape of a joint group."""
    color, shape = COLORS[group % len(COLORS)], SHAPES[group % len(SHAPES)]
    return {"color": color, "marker": shape, "ls": "none", "ms": 6.5, "mec": "white", "mew": 0.8}


def _legend(axes: Axes, robot: Robot, y: float) -> None:
    """Add the legend."""
    for g, group in enumerate(robot.joints):
        axes.plot([], [], label=f"joint {group.name}", **_mark(g))
    axes.plot([], [], "+", color=INK, ms=6, mew=1.1, label="center of mass")
    axes.legend(
        loc="center right",
        bbox_to_anchor=(robot.body.length, y),
        bbox_transform=axes.transData,
        ncols=len(robot.joints) + 1,
        frameon=False,
        fontsize=8,
        borderpad=0,
        borderaxespad=0,
        handletextpad=0.1,
        columnspacing=1.2,
    )


def _scale_bar(axes: Axes, length: float, y: float) -> None:
    """Draw a bar of 1, 2 or 5 times a power of ten, about a sixth of the body."""
    power = 10 ** np.floor(np.log10(length / 6))
    bar = max(step * power for step in (1, 2, 5) if step * power <= length / 6)
    axes.plot([0, bar], [y, y], color=INK, lw=2, solid_capstyle="butt")
    axes.text(bar + 0.012 * length, y, f"{bar * 1000:g} mm", va="center", color=INK, fontsize=8)
