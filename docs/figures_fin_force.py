"""Picture of docs/model.md: forces on a fin, and its thrust beside a vortex lattice; docs/figures.py includes it."""

from __future__ import annotations

import json
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.figures import BODY, COLORS, EDGE, FAINT, INK, POINTS, WIDTH, styled

FLOW = Path(__file__).parents[1] / "validation/flow"
ASPECT = 5.0  # span of the plate over its chord
# Fin's angle [rad], its rate, and velocity of its leading edge, with the chord as length and the speed as 1.
ANGLE, TURN, PATH = np.radians(-20), 0.6, np.array([-1.0, 0.9])
SPEED, FORCE = 0.21, 0.23  # lengths of arrows [chords] per unit of speed and of force
ALONG = np.array([np.cos(ANGLE), np.sin(ANGLE)])  # from the leading to the trailing edge
ACROSS = np.array([-ALONG[1], ALONG[0]])


def arrow(axes: Axes, start: Any, vector: Any, color: str, *, label: str = "", at: Any = (0, 0), **style: Any) -> None:
    """Draw an arrow, and its label beside its head."""
    end = np.asarray(start) + vector
    style = {"arrowstyle": "-|>", "lw": 1.6, "mutation_scale": 9, "shrinkA": 0, "shrinkB": 0} | style
    axes.annotate("", end, start, arrowprops={"color": color, **style})
    axes.annotate(label, end, at, textcoords="offset points", color=color, fontsize=8, va="center")


def draw_forces(axes: Axes, part: Any) -> None:
    """Draw a fin from above with its velocities and forces at an instant of the stroke, to scale."""
    v_t, front = PATH @ ALONG, PATH @ ACROSS

    def across(x: float) -> float:
        return float(front + x * TURN)

    axes.plot(*np.array([-0.3 * ALONG, 0 * ALONG]).T, color=EDGE, lw=7, solid_capstyle="round")
    axes.plot(*np.array([0 * ALONG, ALONG]).T, color=INK, lw=3.5)
    axes.plot(0, 0, "o", color=BODY, mec=INK, ms=6, zorder=5)
    places = ((0.0, "leading edge", -34), (0.5, "middle", -20), (0.75, "3/4 chord", -16), (1.0, "trailing edge", -4))
    for x, name, left in places:
        arrow(axes, x * ALONG, SPEED * (v_t * ALONG + across(x) * ACROSS), COLORS[1], label=name, at=(left, 7), lw=1.1)
    for x in np.linspace(0.1, 0.9, 5):  # drag of a beating plate, per length
        arrow(axes, x * ALONG, -0.29 * across(x) ** 2 * ACROSS, COLORS[4], lw=1, mutation_scale=6)
    axes.annotate("drag across", (-0.22, -0.14), fontsize=8, color=COLORS[4], va="center")
    kept = abs(v_t) / np.hypot(v_t, across(0.75))  # H, for stall
    lift = FORCE * part.lift * kept * v_t * across(0.75) * ACROSS
    start = (0.25 + part.mass / part.lift) * ALONG
    arrow(axes, start, lift, COLORS[0], label="lift, by the speed at 3/4 chord", at=(-14, -9), lw=2.2)
    axial = FORCE * TURN * part.mass * across(0.5) * ALONG
    thin = {"arrowstyle": "-", "color": COLORS[3], "lw": 0.5}
    texts = {
        1: ("Kirchhoff's axial force, ω M v(middle)", (66, -33)),
        -1: ("the fin's axial force\ncancels it", (-70, -40)),
    }
    for sign, (text, at) in texts.items():
        start = 0.5 * ALONG - 0.045 * ACROSS
        arrow(axes, start, sign * 2 * axial, COLORS[3], lw=1.8, ls="-" if sign < 0 else (0, (2, 1)))
        style = {"textcoords": "offset points", "fontsize": 8, "color": COLORS[3], "arrowprops": thin}
        axes.annotate(text, start + sign * 1.2 * axial, at, **style)
    wake = ALONG + np.array([[0.14, 0.02], [0.34, 0.16], [0.54, 0.02]])
    for center, turn in zip(wake, (1, -1, 1), strict=True):
        angle = np.linspace(0, 1.6 * np.pi, 40) * turn
        axes.plot(*(center[:, np.newaxis] + 0.05 * np.array([np.cos(angle), np.sin(angle)])), color=FAINT, lw=1)
    axes.text(*(wake[1] + [-0.05, 0.09]), "wake: takes energy", fontsize=8, color=FAINT)
    arrow(axes, (-0.1, 0.38), np.array([-0.2, 0]), INK, label="swims", at=(2, 7), lw=1.1)
    axes.set(xlim=(-0.42, 1.74), ylim=(-0.72, 0.45), aspect="equal")
    axes.axis("off")
    axes.set_title("Forces on a fin in mid-stroke, from above")


def draw_thrust(axes: Axes, forms: dict[str, Any], part: Any) -> None:
    """Plot the thrust of a plate that pitches about a hinge a chord ahead, by the law and by the vortex lattice."""
    name = forms["MOTIONS"][1]
    grid = np.linspace(0, 1.3, 100)
    scale = part.lift * forms["AMPLITUDE"] ** 2 / 2
    for form, label, style in (("quarter", "law", "-"), ("before", "axial force kept", "--")):
        values = [
            forms["thrust_and_power"](forms["response"](form, part, k, *(m := forms["motion"](name, k))), k, *m)[0]
            for k in grid
        ]
        axes.plot(grid, np.array(values) / scale, style, color=COLORS[0 if form == "quarter" else 3], label=label)
    rows = [row for row in json.loads((FLOW / "forms.json").read_text())["stream"] if row["aspect"] == ASPECT]
    found = []
    for row in rows:
        heave, pitch = forms["motion"](name, row["k"])
        force = heave * complex(*row["heave"][:2]) + pitch * complex(*row["pitch"][:2])
        found.append((force * np.conj(pitch)).real / 2 / scale)
    axes.plot([row["k"] for row in rows], found, "o", color=COLORS[1], label="vortex lattice", **POINTS)
    axes.set(xlabel="reduced frequency k", ylabel="mean thrust over drag at k = 0", xlim=(0, 1.3))
    axes.set_title("Plate, hinge 1 chord ahead")
    axes.legend(loc="upper left")


@styled
def plot_fin_force() -> Figure:
    """Draw the forces on a fin and plot its thrust."""
    forms = runpy.run_path(str(FLOW / "forms.py"))
    (row,) = (row for row in json.loads((FLOW / "forms.json").read_text())["plates"] if row["aspect"] == ASPECT)
    part = forms["Plate"](row["mass"], row["lift"], row["inertia"])
    figure = Figure(figsize=(WIDTH, 3.3), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.9, 1))
    draw_forces(left, part)
    draw_thrust(right, forms, part)
    return figure


TABLES: dict[str, Callable[[], str]] = {}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/fin-force.svg": plot_fin_force}
