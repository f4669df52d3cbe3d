"""The tail fin's thrust: that of Lighthill's theory at rest, and enough for a fish of one joint to set off."""

from __future__ import annotations

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.new import new_robot
from hypertuna.description.robot import parse
from hypertuna.description.schema.water import plate_mass
from hypertuna.swimming.model import core_model

AMPLITUDE, LENGTH, HEIGHT = np.radians(5.0), 0.08, 0.04
EDGES = {
    "strip": {},
    "strip, half shed": {"tail_shedding": 0.5},
    "fin": {"edge_height_m": HEIGHT, "edge_aspect": HEIGHT / LENGTH, "edge_added_mass": 0.4, "edge_lift": 0.8},
}


def tail(water: dict[str, object], law: str) -> ht.Robot:
    """A head without height that holds a rigid tail of 80 mm by 40 mm by its leading edge, without drag."""
    document = new_robot("tail", links=2, length=0.3, mass=0.85)
    del document["uncertainty"]
    area = [1e-9, LENGTH * HEIGHT]
    links = {"length_m": [0.22, LENGTH], "mass_kg": [0.8, 0.05], "lateral_area_m2": area, "wetted_area_m2": area}
    column = {"drag_normal": [0.0, 0.0], "drag_tangential": [0.0, 0.0]}
    return parse(document | {"links": links, "water": {law: column | water}, "model": {"water": law}} | {"sources": {}})


def held_thrust(robot: ht.Robot) -> float:
    """Mean forward force [N] of the robot's head, held in still water, at 1 Hz and 5 deg: the momentum has no mean."""
    model, clock = core_model(robot), 2 * np.pi * np.arange(256) / 256
    joints = _core.joint_motion(model, frequency=1.0, amplitude=[AMPLITUDE], phase=[0.0], bias=[0.0], clock=clock)
    return float(-_core.dynamics(model, joints, np.zeros((256, 3)))["wrench"][:, 0].mean())


@pytest.mark.parametrize("edge", [*EDGES, "elongated"])
def test_thrust_at_rest_is_lighthills(edge: str) -> None:
    """mu <w^2> / 2, w the speed of the trailing edge across, for the added mass per length that carries the fin."""
    robot = tail(EDGES.get(edge, {}), "elongated" if edge == "elongated" else "strip")
    mu = 1000 * np.pi / 4 * HEIGHT**2
    if edge == "fin":
        mu *= 0.4 * LENGTH / HEIGHT  # kappa rho pi/4 c^2 b over c
    expected = mu / 2 * (LENGTH * 2 * np.pi * AMPLITUDE) ** 2 / 2
    assert held_thrust(robot) == pytest.approx(expected, rel=0.01)


def test_a_plate_turned_by_a_right_angle_is_the_same_plate() -> None:
    """Its added mass kappa rho pi/4 c^2 b, with span and chord exchanged; rho pi/4 b^2 c for a slender one."""
    for aspect in (0.3, 0.7, 1.0):
        assert plate_mass(aspect) * (1 / aspect) ** 2 == pytest.approx(plate_mass(1 / aspect) / aspect, rel=1e-12)
    assert plate_mass(0.02) == pytest.approx(0.02, rel=0.05)
    assert plate_mass(0.0) == 0.0


def test_a_fish_of_one_joint_starts_from_rest() -> None:
    """It swims forward within the first two beats, and settles at a Strouhal number of fish."""
    robot = parse(new_robot("one", links=2, length=0.3, mass=0.85))
    assert ht.swim(robot, "cruise", from_rest=1.0).speed > 0.02
    swim = ht.swim(robot, "cruise")
    assert swim.reached_from_rest
    assert 0.3 < swim.strouhal < 0.9
    assert swim.efficiency > 0.05


def test_a_fin_that_spans_several_links_pushes_as_one() -> None:
    """From 6 links on, the fin of a first robot is longer than its last link: more links change the speed little."""
    speeds = [
        ht.swim(parse(new_robot("many", links=links, length=0.3, mass=0.85)), "cruise").speed for links in (6, 9, 12)
    ]
    assert speeds == pytest.approx([np.mean(speeds)] * 3, rel=0.05)
