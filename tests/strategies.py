"""Hypothesis strategies: robots, gaits and states of motion as they can occur."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.description.schema.water import LAWS

Array = NDArray[np.float64]


def _column(draw: st.DrawFn, count: int, low: float, high: float) -> list[float]:
    return [draw(st.floats(low, high)) for _ in range(count)]


@st.composite
def robots(draw: st.DrawFn, water: str | None = None) -> ht.Robot:
    """A robot of 2 to 12 links with the coefficients of every law; which one it uses is drawn unless given.

    Its tail behind link 1 or later is divided among one to three joint groups.
    """
    n = draw(st.integers(2, 12))
    length = _column(draw, n, 0.02, 0.3)
    mass = _column(draw, n, 0.02, 2.0)
    height = _column(draw, n, 0.03, 0.2)
    lateral = [h * x for h, x in zip(height, length, strict=True)]
    rigid = draw(st.integers(0, n - 2))  # joints behind the head that do not bend
    bending = np.arange(1 + rigid, n)
    groups = np.array_split(bending, draw(st.integers(1, min(3, len(bending)))))
    document: dict[str, Any] = {
        "format": 1,
        "name": "drawn",
        "description": "a robot drawn at random",
        "body": {"length_m": sum(length), "mass_kg": 1.2 * sum(mass)},
        "links": {
            "name": [f"L{i}" for i in range(n)],
            "length_m": length,
            "com_m": [c * x for c, x in zip(_column(draw, n, 0.2, 0.8), length, strict=True)],
            "mass_kg": mass,
            "lateral_area_m2": lateral,
            "wetted_area_m2": [w * a for w, a in zip(_column(draw, n, 1.5, 3.0), lateral, strict=True)],
        },
        "joints": [
            {"name": str(g), "links": links.tolist(), "bandwidth_hz": draw(st.floats(2.0, 10.0))}
            for g, links in enumerate(groups)
        ],
        "model": {
            "water": water or draw(st.sampled_from(sorted(LAWS))),
            "joints": draw(st.sampled_from(["ideal", "bandwidth"])),
            "areas": draw(st.sampled_from(["consistent", "as-printed"])),
        },
        "water": {
            "density_kg_m3": draw(st.floats(990.0, 1030.0)),
            "lumped": {
                "added_mass": _column(draw, n, 0.0, 1.0),
                "friction": _column(draw, n, 0.0, 1.0),
                "drag": _column(draw, n, 0.0, 30.0),
            },
            "strip": {
                "added_mass_normal": _column(draw, n, 0.2, 1.5),
                "added_mass_tangential": _column(draw, n, 0.0, 0.3),
                "added_inertia": _column(draw, n, 0.5, 1.5),
                "drag_normal": _column(draw, n, 0.0, 3.0),
                "drag_tangential": _column(draw, n, 0.0, 0.1),
                "linear_normal_pa_s": _column(draw, n, 0.0, 1.0),
                "linear_tangential_pa_s": _column(draw, n, 0.0, 1.0),
                "cross_flow": draw(st.booleans()),
                "tail_shedding": draw(st.floats(0.0, 1.0)),
                "edge_height_m": draw(st.sampled_from([0.0, 0.02, 0.1])),
                "edge_lift": draw(st.floats(0.2, 1.0)),
            },
            "elongated": {
                "added_mass_normal": _column(draw, n, 0.2, 1.5),
                "added_mass_edge": draw(st.floats(0.0, 2.0)),
                "drag_normal": _column(draw, n, 0.0, 3.0),
                "drag_tangential": _column(draw, n, 0.0, 0.1),
            },
        },
    }
    return parse(document)


@st.composite
def gaits(draw: st.DrawFn, robot: ht.Robot, *, bias: float = 0.0) -> ht.Gait:
    """A gait of the robot: 5 to 20 deg, each group 0 to 80 deg behind the one before, biased by up to `bias` [rad]."""
    groups = len(robot.joints)
    lags = np.cumsum([0.0, *_column(draw, groups - 1, 0.0, math.radians(80))])
    return ht.Gait(
        draw(st.floats(0.5, 6.0)),
        tuple(_column(draw, groups, math.radians(5), math.radians(20))),
        tuple(lags.tolist()),
        tuple(_column(draw, groups, -bias, bias)),
    )


@st.composite
def states(draw: st.DrawFn, robot: ht.Robot) -> tuple[Array, Array]:
    """Joint angles, rates, accelerations (links, 3) and a twist (3,) of the head, as vehement as fish move."""
    links = len(robot.links.name)
    joints = np.array([_column(draw, links, -size, size) for size in (0.7, 10.0, 300.0)]).T
    joints[0] = 0.0
    twist = np.array([draw(st.floats(-size, size)) for size in (1.0, 1.0, 5.0)])
    return joints, twist
