"""The core against the oracles: random chains and states, every water law; then whole beats.

All access to the core is in the functions of the first part.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hypertuna import _core
from hypertuna.description.schema.water import LAWS
from oracles import beats, lagrangian, mujoco_chain, planar
from oracles.cases import Case, random_case
from oracles.planar import Joints, Real, Water

# See test_oracles.py, where the oracles meet the same limits.
ROUNDING = 1e-10
CANCELLED = 1e-9
# 1001 random states in all, spread over the chains' lengths.
LENGTHS = range(2, 13)
PER_LENGTH = 91


# The core, as these tests see it.


def core_model(case: Case, law: str, areas: str) -> _core.Model:
    """The case as the core's model with a water law; the lumped one reads ``areas``."""
    chain, links = case.chain, len(case.chain.mass)
    columns = {"length": chain.length, "com": chain.com, "mass": chain.mass, "inertia": chain.inertia}
    columns |= {"density": np.array([case.density]), "bandwidth": np.array([np.inf]), "phase_offset": np.zeros(1)}
    columns |= {"lateral_area": case.lateral_area, "wetted_area": case.wetted_area}
    lumped = case.lumped_water(areas)
    columns |= {"friction_area": lumped.friction_area, "drag_area": lumped.drag_area}
    coefficients = getattr(case, law)
    columns |= {name: np.atleast_1d(value).astype(float) for name, value in coefficients.items()}
    body = {"joint_group": [-1] + [0] * (links - 1), "joint_share": [0.0] + [1.0] * (links - 1)}
    return _core.Model(law, columns | body | {"body_length": chain.length.sum()})


def core_joints(joints: Joints) -> Real:
    """Joint motion as the core takes it: (n, 3)."""
    return np.stack([joints.angle, joints.rate, joints.acceleration], axis=-1)


def core_dynamics(case: Case, law: str, areas: str = "consistent") -> tuple[Real, Real]:
    """Rates of the head's twist (3,) in its own axes and torques (n,) at the joints in front of each link."""
    out = _core.dynamics(core_model(case, law, areas), core_joints(case.joints)[None], case.twist[None])
    return out["acceleration"][0], out["torque"][0]


def core_beat(case: Case, law: str, gait: beats.Gait, steps: int) -> Real:
    """State (6,): x, y, heading and their world rates, after one beat of ``gait`` from the origin with the twist."""
    joints = np.stack([core_joints(gait.joints(k / (2 * steps))) for k in range(2 * steps + 1)])
    step = 1 / float(gait.frequency) / steps
    out = _core.advance(core_model(case, law, "consistent"), joints, step=step, twist=case.twist, pose=np.zeros(3))
    pose, (u, v, r) = out["pose"][-1], out["twist"][-1]
    velocity = (u + 1j * v) * np.exp(1j * pose[2])
    return np.concatenate([pose, [velocity.real, velocity.imag, r]])


# Comparisons.


def difference(a: Real, b: Real) -> float:
    """Largest difference relative to the largest entry."""
    return float(abs(a - b).max() / abs(b).max())


def cases(links: int, count: int = PER_LENGTH) -> list[Case]:
    rng = np.random.default_rng([20, links])
    return [random_case(rng, links) for _ in range(count)]


def in_head_axes(world: Real, twist: Real) -> Real:
    """World accelerations (3,) of a head along x to rates of its twist: the axes turn with r."""
    u, v, r = twist
    return world + np.array([r * v, -r * u, 0.0])


def water_of(case: Case, law: str) -> Water:
    waters = {"lumped": case.lumped_water("consistent"), "strip": case.strip_water()}
    return (waters | {"elongated": case.elongated_water()})[law]


@pytest.mark.parametrize("links", LENGTHS)
def test_lumped_law_against_mujoco(links: int) -> None:
    for k, case in enumerate(cases(links)):
        areas = ("consistent", "as-printed")[k % 2]
        base, expected = mujoco_chain.solve(case.chain, case.lumped_water(areas), case.joints, case.state)
        acceleration, torques = core_dynamics(case, "lumped", areas)
        assert difference(acceleration, in_head_axes(base, case.twist)) < ROUNDING
        assert difference(torques[1:], expected) < CANCELLED


@pytest.mark.parametrize("links", [2, 3])
def test_anisotropic_added_mass_against_the_lagrangian(links: int) -> None:
    for case in cases(links):
        pure = case.without_drag()
        base, expected = lagrangian.solve(pure.chain, pure.strip_water(), pure.joints, pure.state)
        acceleration, torques = core_dynamics(pure, "strip")
        assert difference(acceleration, in_head_axes(base, pure.twist)) < ROUNDING
        assert difference(torques[1:], expected) < CANCELLED


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("links", LENGTHS)
def test_every_law_against_newton_and_euler(links: int, law: str) -> None:
    for case in cases(links, count=20):
        water = water_of(case, law)
        acceleration, torques = core_dynamics(case, law)
        assert difference(acceleration, planar.head_acceleration(case.chain, water, case.joints, case.twist)) < ROUNDING
        expected = planar.torques(case.chain, water, case.joints, case.state)
        assert difference(torques[1:], expected[1:]) < CANCELLED


def random_gait(rng: np.random.Generator, links: int) -> beats.Gait:
    """One group per joint."""
    share = np.eye(links)[1:]
    n = links - 1
    return beats.Gait(
        np.array(2.0), rng.uniform(0.02, 0.1, n), rng.uniform(0, 2 * np.pi, n), rng.uniform(-0.2, 0.2, n), share
    )


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("links", [2, 5, 8])
def test_a_beat_against_newton_and_euler(links: int, law: str) -> None:
    """Momentum in body axes and world velocities (oracle) differ by RK4's error, which half the steps show."""
    rng = np.random.default_rng([21, links])
    case = random_case(rng, links)
    case = replace(case, twist=case.twist / 5)  # a speed that the gait can have: much more makes 64 steps unstable
    water = water_of(case, law)
    gait = random_gait(rng, links)
    coarse, fine = (beats.beat(case.chain, water, gait, case.state, steps)[-1] for steps in (64, 128))
    # fourth order: both errors at 128 steps are about a sixteenth of the one at 64
    assert abs(core_beat(case, law, gait, 128) - fine).max() < abs(coarse - fine).max() / 2
