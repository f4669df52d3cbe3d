"""A settled beat with a hinge against the twin's forward dynamics, and these against MuJoCo's own spring."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.pose import coordinate_shares
from hypertuna.description.robot import Robot, parse
from hypertuna.swimming.model import core_model
from oracles import mujoco_chain
from oracles.planar import Chain, Lumped, Real
from swimming.test_hinge_springs import MOMENT, sprung
from swimming.test_yielding import GAIT, hinged, rigid, spring_moment

HINGE = 2  # the last link, behind the one that is driven
STEPS = 512
OMEGA = 2 * math.pi * GAIT.frequency
LUMPED = {"added_mass": [0.3, 0.8, 1.5], "friction": [0.05, 0.02, 0.02], "drag": [1.5, 1.5, 3.0]}


def in_water(law: str) -> Robot:
    """The fish with a hinge near resonance, in one of the waters."""
    document = rigid().document()
    document["model"]["water"] = law
    document["water"]["lumped"] = LUMPED
    document["water"]["elongated"] = {"drag_normal": [1.5, 1.5, 1.2], "drag_tangential": [0.01] * 3}
    return hinged(1.6, robot=parse(document | {"sources": {}}))


def swing(t: float) -> tuple[float, float, float]:
    """Angle, rate and acceleration of the driven joint."""
    (amplitude,) = GAIT.amplitude
    return (
        amplitude * math.sin(OMEGA * t),
        amplitude * OMEGA * math.cos(OMEGA * t),
        -amplitude * OMEGA**2 * math.sin(OMEGA * t),
    )


def twin_rate(robot: Robot, t: float, y: Real) -> Real:
    """Rate of (x, y, heading, u, v, r, hinges' angles and rates): the twin's dynamics under the moment that drives."""
    (angle, rate, wanted), count = swing(t), len(robot.hinges)
    angles, rates = y[6 : 6 + count], y[6 + count :]
    springs = [spring_moment(*one, OMEGA * t) for one in zip(robot.hinges, angles, rates, strict=True)]
    twist = np.array([y[3], y[4], 0, 0, 0, y[5]])
    bend = np.array([[angle, *angles], [rate, *rates]])
    none, unit = _core.Body(core_model(robot), {"share": coordinate_shares(robot)}).accelerations(
        _core.World({"clamped": False}),
        bend=np.stack([bend, bend]),
        twist=np.stack([twist, twist]),
        pose=np.zeros((2, 9)),
        moment=np.array([[0.0, *springs], [1.0, *springs]]),
    )
    found = none + (wanted - none[6]) / (unit[6] - none[6]) * (unit - none)  # linear in the moment
    cosine, sine = math.cos(y[2]), math.sin(y[2])
    path = [cosine * y[3] - sine * y[4], sine * y[3] + cosine * y[4], y[5]]
    return np.array([*path, found[0], found[1], found[5], *rates, *found[7:]])


def settled(robot: Robot) -> tuple[ht.Swim, Real]:
    """The settled beat and its start (x, y, heading, u, v, r, hinges' angles and rates)."""
    beat = ht.swim(robot, GAIT, steps=STEPS)
    first = beat.trajectory.isel(time=0)
    body = [float(first[name]) for name in ("x", "y", "heading", "u", "v", "r")]
    at = [hinge.link for hinge in robot.hinges]
    return beat, np.array([*body, *first.joint_angle[at].values, *first.joint_rate[at].values])


def beaten(robot: Robot, start: Real) -> Real:
    """The state after a beat of the twin's dynamics."""
    y, h = start, 1 / GAIT.frequency / STEPS
    for k in range(STEPS):
        t = k * h
        a = twin_rate(robot, t, y)
        b = twin_rate(robot, t + h / 2, y + h / 2 * a)
        c = twin_rate(robot, t + h / 2, y + h / 2 * b)
        d = twin_rate(robot, t + h, y + h * c)
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
    return y


@pytest.mark.parametrize("law", ["strip", "lumped", "elongated"])
def test_the_twin_under_the_same_joint_swims_the_settled_beat(law: str) -> None:
    """It ends where it began, at the same speed: within 1e-8 at 512 steps."""
    robot = in_water(law)
    beat, start = settled(robot)
    y = beaten(robot, start)
    assert math.hypot(*(y[:2] - start[:2])) * GAIT.frequency == pytest.approx(beat.speed, rel=1e-8)
    np.testing.assert_allclose(y[3:7], start[3:7], atol=1e-8)


@pytest.mark.parametrize("hinges", [2, 3])
def test_the_twin_with_several_hinges_swims_the_settled_beat(hinges: int) -> None:
    robot = hinged(1.6, hinges=hinges)
    beat, start = settled(robot)
    y = beaten(robot, start)
    assert math.hypot(*(y[:2] - start[:2])) * GAIT.frequency == pytest.approx(beat.speed, rel=1e-8)
    np.testing.assert_allclose(y[3:], start[3:], atol=1e-7)


@pytest.mark.parametrize("keys", [{"rest_deg": 12.0, "cubic": 5.0, **MOMENT}])
def test_the_twin_under_the_same_joint_ends_a_beat_where_it_began(keys: dict[str, float]) -> None:
    """Head and hinge, within 1e-7."""
    robot = sprung(**keys)
    _, start = settled(robot)
    y = beaten(robot, start)
    np.testing.assert_allclose(y[3:], start[3:], atol=1e-7)


def test_accelerations_equal_those_of_a_spring_of_mujoco() -> None:
    """Of head and hinge, along a settled beat in lumped water, whose drag MuJoCo's velocities give."""
    robot = in_water("lumped")
    links, hinge = robot.links, robot.hinge
    assert hinge is not None
    chain = Chain(*(np.array(getattr(links, name)) for name in ("length", "com", "mass", "inertia")))
    areas = np.array(links.wetted_area), np.array(links.lateral_area)
    numbers = {name: np.array(value) for name, value in LUMPED.items()}
    water = Lumped(density=robot.water.density, friction_area=areas[0], drag_area=areas[1], **numbers)
    m = mujoco_chain.model(chain, water)
    m.jnt_stiffness[-1], m.dof_damping[-1] = hinge.stiffness, hinge.damping
    d, motion = mujoco.MjData(m), ht.swim(robot, GAIT, steps=64).trajectory
    free = [0, 1, 2, 4]  # all but the driven joint
    for k in range(64):
        at = motion.isel(time=k)
        angle, rate, wanted = swing(float(at.time))
        u, v, r = (float(at[name]) for name in ("u", "v", "r"))
        bend, bending = float(at.joint_angle[HINGE]), float(at.joint_rate[HINGE])
        d.qpos[:] = [0, 0, 0, angle, bend]
        d.qvel[:] = [u, v, r, rate, bending]
        mujoco.mj_forward(m, d)
        matrix = np.zeros((m.nv, m.nv))
        for row, unit in enumerate(np.eye(m.nv)):
            mujoco.mj_mulM(m, d, matrix[row], unit)
        load = mujoco_chain.drag(m, d, water) + d.qfrc_passive - d.qfrc_bias - wanted * matrix[3]
        expected = np.linalg.solve(matrix[np.ix_(free, free)], load[free])
        rates = twin_rate(robot, float(at.time), np.array([0, 0, 0, u, v, r, bend, bending]))
        got = rates[[3, 4, 5, 7]] + [-v * r, u * r, 0, 0]  # from the head's axes to the world's
        np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-9 * abs(expected).max())
