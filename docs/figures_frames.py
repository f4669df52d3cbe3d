"""Picture of docs/conventions.md: frames and signs; docs/figures.py includes it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.figures import BODY, COLORS, EDGE, INK


def _arrow(axes: Axes, start: complex, end: complex, color: str, text: str = "", shift: complex = 0j) -> None:
    """Draw an arrow with a label at its end."""
    style = {"arrowstyle": "-|>", "color": color, "lw": 1.5, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    axes.annotate("", (end.real, end.imag), (start.real, start.imag), arrowprops=style, zorder=5)
    at = end + shift
    axes.text(at.real, at.imag, text, color=color, ha="center", va="center", fontsize=9.5)


def _arc(
    axes: Axes, center: complex, radius: float, start: float, stop: float, color: str, text: str, out: float
) -> None:
    """Draw an angle from start to stop [rad] with an arrow head at its end, and its name beside its middle."""
    points = center + radius * np.exp(1j * np.linspace(start, stop, 40))
    axes.plot(points.real, points.imag, color=color, lw=1.1)
    _arrow(axes, points[-3], points[-1], color)
    at = center + out * radius * np.exp(0.5j * (start + stop))
    axes.text(at.real, at.imag, text, color=color, ha="center", va="center", fontsize=9.5)


def _draw_body(axes: Axes) -> None:
    """Draw world and body axes, and the angles and axes of a link."""
    red, blue, green = COLORS[:3]
    theta, psi = math.radians(14), np.radians([0, 20, 48])
    lengths, nose = (2.6, 1.5, 1.9), 1.95 + 0.75j
    joints = nose + np.concatenate([[0], np.cumsum(lengths * np.exp(1j * (theta + psi)))])
    origin, ahead = 0.45 + 0.15j, np.exp(1j * theta)
    _arrow(axes, origin, origin + 0.9, INK, "$x$ (east)", 0.45)
    _arrow(axes, origin, origin + 0.9j, INK, "$y$ (north)", 0.14j)
    for a, b, width in zip(joints, joints[1:], (11, 8, 6), strict=False):
        axes.plot([a.real, b.real], [a.imag, b.imag], color=BODY, lw=width, solid_capstyle="round", zorder=1)
        axes.plot([a.real, b.real], [a.imag, b.imag], color=EDGE, lw=1.0, zorder=2)
    axes.plot(joints[1:-1].real, joints[1:-1].imag, "o", color="white", mec=INK, ms=6, zorder=6)
    # from the nose: heading, body axes, twist
    _dashes(axes, nose, nose + 1.9)
    _arc(axes, nose, 1.6, 0, theta, INK, r"$\theta$", 1.1)
    _arrow(axes, nose, nose + 1.0 * ahead, blue, "$x_0,\\,u$", 0.2j - 0.1)
    _arrow(axes, nose, nose + 1.0j * ahead, blue, "$y_0,\\,v$", 0.15j)
    _arc(axes, nose, 0.32, theta + 0.2, theta + 1.3, blue, "$r$", 1.5)
    _arrow(axes, nose - 0.12 * ahead, nose - 1.0 * ahead, EDGE, "swims\nthis way", 0.36j - 0.02)
    # a link: its angles and its axes
    middle, axis = 0.5 * (joints[2] + joints[3]), np.exp(1j * (theta + psi[2]))
    _dashes(axes, joints[2], joints[2] + 1.0 * np.exp(1j * (theta + psi[1])))
    _arc(axes, joints[2], 0.7, theta + psi[1], theta + psi[2], green, r"$\varphi_i$", 1.25)
    _dashes(axes, joints[2], joints[2] + 1.5 * ahead)
    _arc(axes, joints[2], 1.3, theta, theta + psi[2], green, r"$\psi_i$", 1.12)
    axes.plot(middle.real, middle.imag, "+", color=INK, ms=8, mew=1.4, zorder=6)
    _arrow(axes, middle, middle + 0.75 * axis, red, "$t,\\,v_t$", 0.3 - 0.02j)
    _arrow(axes, middle, middle + 0.75j * axis, red, "$n,\\,v_n$", -0.3 + 0.02j)
    axes.set(xlim=(-0.15, 8.2), ylim=(-0.1, 4.1), aspect="equal")


def _dashes(axes: Axes, start: complex, end: complex) -> None:
    """Draw a line that only shows where an angle begins."""
    axes.plot([start.real, end.real], [start.imag, end.imag], color=EDGE, lw=0.9, ls=(0, (4, 3)), zorder=0)


def _draw_conventions(axes: Axes) -> None:
    """Draw the axes that count as positive in three conventions, on a robot that faces left."""
    cases = (
        ("hypertuna: from the nose to the tail", 1, 1j, "$u$", "$v$", 1),
        ("ENU world, forward-left-up body", -1, -1j, "forward", "left", 1),
        ("NED world, forward-right-down body", -1, 1j, "surge", "sway", -1),
    )
    for k, (title, along, across, first, second, sense) in enumerate(cases):
        nose = 2.78 * k + 1.15 + 0j
        for a, b, width in ((0, 0.8, 9), (0.8, 1.25, 5)):
            axes.plot([nose.real + a, nose.real + b], [0, 0], color=BODY, lw=width, solid_capstyle="round", zorder=1)
        _arrow(axes, nose, nose + 0.7 * along, COLORS[1], first, 0.17j)
        _arrow(axes, nose, nose + 0.6 * across, COLORS[1], second, 0.14 * across)
        start = float(np.angle(along))
        _arc(axes, nose, 0.33, start + 0.3 * sense, start + 1.3 * sense, COLORS[1], "$r$", 1.5)
        axes.text(nose.real + 0.1, -1.12, title, ha="center", fontsize=8, color=INK)
    axes.set(xlim=(-0.15, 8.2), ylim=(-1.25, 0.95), aspect="equal")


def draw_frames() -> Figure:
    """Draw the frames and signs of docs/conventions.md."""
    figure = Figure(figsize=(7.2, 5.45), facecolor="white")
    body, conventions = figure.subplots(2, 1, height_ratios=[4.05, 2.2])
    figure.subplots_adjust(left=0, right=1, top=1, bottom=0, hspace=0)
    _draw_body(body)
    _draw_conventions(conventions)
    for axes in (body, conventions):
        axes.set_axis_off()
    return figure


TABLES: dict[str, Callable[[], str]] = {}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/frames.svg": draw_frames}
