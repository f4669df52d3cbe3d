"""Table and picture of the fins in docs/spatial.md; docs/figures.py includes them."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from figures_common import FISH, PAPER, rows
from matplotlib.figure import Figure

from hypertuna.figures import COLORS, WIDTH, styled
from hypertuna.simulation.dive import Dive, dive
from hypertuna.swimming.gait import named_gait

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from oracles.space import Space, fins

ANGLES = (5, 10, 15, 20, 25, 30, 35, 40, 45)  # deg


@cache
def dives() -> tuple[Dive, ...]:
    """Dive and float at the gait of the paper's test with the fins at several angles."""
    gait = named_gait(FISH, PAPER["diving"]["gait"])
    return tuple(dive(FISH, gait, angle=math.radians(angle), depth=4) for angle in ANGLES)


def coefficients(degrees: float) -> tuple[float, float]:
    """Return lift and drag coefficient of a fin at an angle of attack [deg], from the law in the tests."""
    assert FISH.fins is not None
    names = ("x", "y", "z", "span", "chord", "stall", "drag_zero")
    space = Space({}, {name: getattr(FISH.fins, name) for name in names}, {"density": 1000.0})
    force = fins(space, np.array([-1.0, 0, 0, 0, 0, 0]), np.full(2, math.radians(degrees)))
    area = 1000 * FISH.fins.span * FISH.fins.chord  # of both fins, times half of the density
    return float(force[2] / area), float(force[0] / area)


def dive_table() -> str:
    """Tabulate dives over the angle of the fins."""
    body = []
    for angle, result in zip(ANGLES, dives(), strict=True):
        down, up = result.legs
        lift, drag = coefficients(angle)
        speeds = f"{down.speed:.3f}", f"{up.speed:.3f}"
        body.append(
            [
                f"{angle}",
                f"{lift:.2f}",
                f"{drag:.2f}",
                f"{100 * down.depth_rate:.1f}",
                f"{-100 * up.depth_rate:.1f}",
                *speeds,
            ]
        )
    head = ["fins [deg]", "$C_L$", "$C_D$", "down [cm/s]", "up [cm/s]", "speed down [m/s]", "speed up [m/s]"]
    return rows(head, body, 0)


@styled
def plot_fins() -> Figure:
    """Plot lift and drag coefficient over the angle of attack, and rates of dives over the angle of the fins."""
    figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
    force, rate = figure.subplots(1, 2)
    angles = np.linspace(0, 90, 181)
    lift, drag = np.array([coefficients(angle) for angle in angles]).T
    force.plot(angles, lift, color=COLORS[0], label="lift")
    force.plot(angles, drag, color=COLORS[1], ls="--", label="drag")
    force.set(xlabel="angle of attack [deg]", ylabel="coefficient", xlim=(0, 90), ylim=(0, None))
    for leg, (name, mark) in enumerate((("down", "o-"), ("up", "s--"))):
        rates = [100 * abs(result.legs[leg].depth_rate) for result in dives()]
        rate.plot(ANGLES, rates, mark, color=COLORS[leg], ms=4, label=name)
    rate.set(xlabel="angle of the fins [deg]", ylabel="rate of the depth [cm/s]", xlim=(0, 48), ylim=(0, None))
    for axes in (force, rate):
        axes.legend()
    return figure


TABLES: dict[str, Callable[[], str]] = {"fin angles": dive_table}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/fins.svg": plot_fins}
