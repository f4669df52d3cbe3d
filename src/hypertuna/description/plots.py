"""Figure of a robot: from the side, and from above with the midlines of a beat."""

from itertools import accumulate
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from hypertuna.arrays import Array
from hypertuna.description.pose import Points, body_points, group_shares
from hypertuna.description.robot import Robot
from hypertuna.display import plots
from hypertuna.figures import BODY, COLORS, EDGE, INK, SHAPES, WIDTH

PHASES = 12  # midlines in one beat


@plots.of(Robot)
def plot_robot(robot: Robot, *, width: float = WIDTH) -> Figure:
    """Plot a robot to scale from the side and from above; `width` [inch]."""
    length, heights = robot.body.length, np.divide(robot.links.lateral_area, robot.links.length)
    midlines = _midlines(robot)
    side_half = heights.max() / 2 / length
    top_half = max(np.abs(midlines.imag).max() / length, 0.06)
    side_above, side_below, top_above, top_below = side_half + 0.11, side_half + 0.10, top_half + 0.08, top_half + 0.03
    total_height = side_above + side_below + top_above + top_below  # body lengths
    total_width = 1.08
    figure = Figure(figsize=(width, width * total_height / total_width), facecolor="white")
    side, top = figure.subplots(2, 1, height_ratios=[side_above + side_below, top_above + top_below])
    figure.subplots_adjust(left=0, right=1, top=1, bottom=0, hspace=0)
    for axes, above, below in ((side, side_above, side_below), (top, top_above, top_below)):
        axes.set_axis_off()
        axes.set(xlim=(-0.04 * length, 1.04 * length), ylim=(-below * length, above * length), aspect="equal")
    _draw_side(side, robot, heights)
    _draw_top(top, robot, midlines)
    return figure


def midline(robot: Robot, angles: Array) -> Points:
    """Return the midline x + i y (links + 1,) [m] at angles of joint groups (groups,) [rad], head held (Eqs 21-24)."""
    return body_points(robot, np.zeros((1, 3)), (group_shares(robot) @ angles)[np.newaxis]).ravel()


def _midlines(robot: Robot) -> Points:
    """Return midlines (phases, links + 1) [m] over a beat of the first named gait; without gaits, the straight one."""
    if not robot.gaits:
        return midline(robot, np.zeros(len(robot.joints)))[np.newaxis]
    gait = next(iter(robot.gaits.values()))
    clock = 2 * np.pi * np.arange(PHASES) / PHASES
    angles = np.array(gait.bias) + np.array(gait.amplitude) * np.sin(clock[:, None] - np.array(gait.phase))
    return np.stack([midline(robot, angle) for angle in angles])


def _draw_side(axes: Axes, robot: Robot, heights: Array) -> None:
    """Draw the links seen from the side, with joints, centers of mass and a scale bar."""
    links, length = robot.links, robot.body.length
    fronts = [0.0, *accumulate(links.length)]
    gap = 0.002 * length
    for x, link_length, link_height, name in zip(fronts, links.length, heights, links.name, strict=False):
        corner = min(0.02 * length, 0.3 * link_length, 0.3 * link_height)
        box = f"round,pad=0,rounding_size={corner}"
        place = (x + gap / 2, -link_height / 2)
        axes.add_patch(FancyBboxPatch(place, link_length - gap, link_height, boxstyle=box, fc=BODY, ec=EDGE, lw=0.9))
        axes.text(
            x + link_length / 2, link_height / 2 + 0.01 * length, name, ha="center", va="bottom", color=INK, fontsize=7
        )
    axes.plot(np.add(fronts[:-1], links.com), np.zeros(len(links.com)), "+", color=INK, ms=6, mew=1.1, zorder=3)
    for g, group in enumerate(robot.joints):
        axes.plot([fronts[i] for i in group.links], [0.0] * len(group.links), **_mark(g), zorder=4)
    _title(axes, f"{robot.name} from the side: {length:.3g} m, {robot.body.mass:.3g} kg; links at their mean height")
    below = -heights.max() / 2 - 0.055 * length
    _legend(axes, robot, below)
    _scale_bar(axes, length, below)


def _draw_top(axes: Axes, robot: Robot, lines: Points) -> None:
    """Draw the midlines of one beat seen from above, the head held still."""
    for line in lines:
        axes.plot(line.real, line.imag, color=EDGE, lw=0.8, alpha=0.6, solid_joinstyle="round")
    widest = lines[np.argmax(lines[:, -1].imag)]
    axes.plot(widest.real, widest.imag, color=INK, lw=2.0, solid_capstyle="round", solid_joinstyle="round")
    for g, group in enumerate(robot.joints):
        joints = widest[list(group.links)]
        axes.plot(joints.real, joints.imag, **_mark(g), zorder=4)
    name = next(iter(robot.gaits), None)
    arrow, above = {"arrowstyle": "->", "color": INK, "lw": 1.0}, 0.05 * robot.body.length
    axes.annotate(
        "swims this way", (0, above), (1.4 * above, above), arrowprops=arrow, color=INK, fontsize=8, va="center"
    )
    _title(axes, f"from above: one beat of {name}, head held still" if name else "from above")


def _title(axes: Axes, text: str) -> None:
    """Write the title of a view in its upper left corner."""
    axes.annotate(text, (0.037, 1), (0, -8), "axes fraction", "offset points", color=INK, fontsize=9, va="top")


def _mark(group: int) -> dict[str, Any]:
    """Return color and marker of a joint group by its index."""
    cycle, index = divmod(group, len(COLORS))  # a color that comes again gets another shape
    color, shape = COLORS[index], SHAPES[(index + cycle) % len(SHAPES)]
    return {"color": color, "marker": shape, "ls": "none", "ms": 6.5, "mec": "white", "mew": 0.8}


def _legend(axes: Axes, robot: Robot, y: float) -> None:
    """Add a legend of joint groups and centers of mass at a height y [m]."""
    for g, group in enumerate(robot.joints):
        axes.plot([], [], label=f"joint {group.name}", **_mark(g))
    axes.plot([], [], "+", color=INK, ms=6, mew=1.1, label="center of mass")
    place: dict[str, Any] = {"bbox_to_anchor": (robot.body.length, y), "bbox_transform": axes.transData}
    spacing: dict[str, Any] = {"borderpad": 0, "borderaxespad": 0, "handletextpad": 0.1, "columnspacing": 1.2}
    axes.legend(loc="center right", ncols=len(robot.joints) + 1, frameon=False, fontsize=8, **place, **spacing)


def _scale_bar(axes: Axes, length: float, y: float) -> None:
    """Draw a scale bar of 1, 2 or 5 times a power of ten, about a sixth of the body long."""
    power = 10 ** np.floor(np.log10(length / 6))
    bar = max(step * power for step in (1, 2, 5) if step * power <= length / 6)
    axes.plot([0, bar], [y, y], color=INK, lw=2, solid_capstyle="butt")
    axes.text(bar + 0.012 * length, y, f"{bar * 1000:g} mm", va="center", color=INK, fontsize=8)
