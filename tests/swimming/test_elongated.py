"""The elongated-body law against Lighthill's theory itself: momentum, energy, and the limit of small amplitude."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.swimming.model import core_model
from models import MODELS, fastest
from oracles import elongated
from oracles.cases import Case, random_case
from oracles.planar import Real, cross, dot
from swimming.test_core_against_oracles import core_dynamics, core_joints
from swimming.test_core_against_oracles import core_model as case_model

# Fourth-order differences of a Taylor motion with accelerations of 300 rad/s^2: 1e-8 of the momenta's rates.
DIFFERENCES = 1e-6


def slender(case: Case) -> elongated.Slender:
    return elongated.slender(case.chain, case.density, case.lateral_area, case.wetted_area, case.elongated)


def world_acceleration(case: Case, twist_rate: Real) -> Real:
    """Accelerations of a head along x from the rates of its twist, whose axes turn with r."""
    u, v, r = case.twist
    return twist_rate + np.array([-r * v, r * u, 0.0])


@pytest.mark.parametrize("links", [2, 3, 5, 8, 12])
def test_momentum_changes_as_lighthill_says(links: int) -> None:
    """Along the core's motion nothing but the water acts on the whole, and each joint's torque on all behind it."""
    rng = np.random.default_rng([31, links])
    for case in (random_case(rng, links) for _ in range(10)):
        water = slender(case)
        acceleration, torques = core_dynamics(case, "elongated")
        base = world_acceleration(case, acceleration)
        scale = abs(elongated.lacking(case.chain, water, case.joints, case.state, 0 * base)).max()
        whole = elongated.lacking(case.chain, water, case.joints, case.state, base)
        assert abs(whole).max() < DIFFERENCES * scale
        for i in range(1, links):
            moment = elongated.lacking(case.chain, water, case.joints, case.state, base, first=i)[2]
            assert moment == pytest.approx(torques[i], rel=DIFFERENCES, abs=DIFFERENCES * abs(torques).max())


def test_the_water_takes_what_drag_dissipates_and_the_wake_carries_off() -> None:
    """Wake: kinetic energy 1/2 mu v_n^2 per length, left behind at the edge's speed along itself."""
    rng = np.random.default_rng(32)
    wakes = 0
    for case in (random_case(rng, links) for links in (2, 4, 7) for _ in range(20)):
        model = case_model(case, "elongated", "consistent")
        out = _core.dynamics(model, core_joints(case.joints)[None], case.twist[None])
        m, water = elongated.moved(case.chain, case.joints, case.state, np.zeros(3), 0.0), slender(case)
        spent = 0.0
        for i in range(len(case.chain.mass)):
            about = complex(m.place[i])
            own, rest = (
                elongated.forces(case.chain, replace(water, mu_edge=0.0), m, about, first) for first in (i, i + 1)
            )
            f = own - rest
            spent -= dot(np.array(f[0] + 1j * f[1]), m.velocity[i]) + f[2] * m.turn[i]
        _, v, _ = m.at(case.chain.length)
        v_t, v_n = dot(m.axis, v)[-1], dot(1j * m.axis, v)[-1]
        wake = water.mu_edge / 2 * v_n**2 * abs(v_t)
        wakes += wake > 0.01 * spent
        assert wake >= 0
        assert out["loss"][0] == pytest.approx(spent + wake, rel=1e-10)
    assert wakes > 10  # the test has seen some


@pytest.mark.parametrize("amplitude", [1e-2, 1e-3])
def test_small_amplitudes_give_lighthills_thrust(amplitude: float) -> None:
    """Towed straight at U, the mean thrust is 1/2 m (h_t^2 - U^2 h_x^2) at the tail, to leading order."""
    robot = MODELS["rexeel-theory-elongated"]
    links, speed, frequency, beats = len(robot.links.name), 0.3, 1.0, 256
    none = {f"water.elongated.{name}": [0.0] * links for name in ("drag_normal", "drag_tangential")}
    gait = replace(fastest(robot), frequency=frequency, amplitude=(amplitude,) * len(robot.joints))
    clock = 2 * np.pi * np.arange(beats) / beats
    model = core_model(robot, none)
    joints = _core.joint_motion(
        model, frequency=frequency, amplitude=gait.amplitude, phase=gait.phase, bias=gait.bias, clock=clock
    )
    twist = np.tile([-speed, 0.0, 0.0], (beats, 1))
    thrust = -_core.dynamics(model, joints, twist)["wrench"][:, 0].mean()

    slope = np.cumsum(joints[:, :, 0], axis=1)
    h_x = slope[:, -1]
    h_t = (np.array(robot.links.length) * np.cumsum(joints[:, :, 1], axis=1)).sum(axis=1)
    depth = robot.links.lateral_area[-1] / robot.links.length[-1]
    mass = robot.water.density * np.pi / 4 * depth**2
    expected = mass / 2 * (h_t**2 - speed**2 * h_x**2).mean()
    assert expected > 0
    assert thrust == pytest.approx(expected, rel=30 * amplitude)


def test_strips_with_the_same_coefficients_are_the_same_body() -> None:
    """Without a wake the law is the strips' one with nothing along the body and strip theory's moment of inertia."""
    tuna = ht.load("hypertuna")
    links = len(tuna.links.name)
    strip = tuna.using(water="strip")
    strip = strip.model_validate(strip.document() | {"water": _plain(tuna, links)})
    slim = core_model(tuna.using(water="elongated"), {"water.elongated.added_mass_edge": [0.0]})
    gait = fastest(tuna)
    clock = np.linspace(0, 2 * np.pi, 17)
    joints = _core.joint_motion(
        slim, frequency=gait.frequency, amplitude=gait.amplitude, phase=gait.phase, bias=gait.bias, clock=clock
    )
    twist = np.tile([-0.5, 0.1, 0.7], (len(clock), 1))
    ours, theirs = _core.dynamics(slim, joints, twist), _core.dynamics(core_model(strip), joints, twist)
    for name in ("inertia", "acceleration", "torque", "loss"):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-12, atol=1e-12 * abs(theirs[name]).max())


def _plain(robot: ht.Robot, links: int) -> dict[str, object]:
    water, none = robot.document()["water"], [0.0] * links
    plain = {
        "edge_aspect": 0.0,
        "added_mass_normal": [1.0] * links,
        "added_mass_tangential": none,
        "drag_beating": none,
    }
    return water | {"strip": water["strip"] | plain | {"blunt_area_m2": none, "tail_shedding": 0.0}}


def test_the_moment_of_a_slender_body_aslant_is_munks() -> None:
    """One straight link, no drag, no edge: the water turns it by -(m_t - m_n) v_t v_n = m v_t v_n, broadside on."""
    case = random_case(np.random.default_rng(33), 2)
    still = replace(
        case,
        strip=case.strip | {"drag_normal": np.zeros(2), "drag_tangential": np.zeros(2)},
        joints=replace(case.joints, angle=np.zeros(2), rate=np.zeros(2), acceleration=np.zeros(2)),
        twist=np.array([-1.0, 0.2, 0.0]),
    )
    water = replace(slender(still), mu_edge=0.0)
    lacking = elongated.lacking(still.chain, water, still.joints, still.state, np.zeros(3))
    added = (water.mu * still.chain.length).sum()
    assert lacking[2] == pytest.approx(cross(np.array(-1.0 + 0.2j), np.array(0.2j * added)), rel=1e-6)
