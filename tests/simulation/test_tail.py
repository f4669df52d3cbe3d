"""The tail's forward dynamics, against MuJoCo and against the prescribed motion of the core."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from hypertuna import _core
from hypertuna.description.schema.water import LAWS
from oracles import mujoco_chain
from oracles.cases import Case, random_case
from oracles.planar import Real
from swimming.test_core_against_oracles import ROUNDING, core_joints, core_model, difference, in_head_axes

COORDINATES = 3


def shares(rng: np.random.Generator, links: int, coordinates: int = COORDINATES) -> Real:
    """Parts that joints take of coordinates that bend them each in its own way; joint 0 does not exist."""
    share = rng.uniform(-1, 1, (links, coordinates))
    share[0] = 0
    # Nearly dependent coordinates accelerate by 1e8 rad/s^2, and a condition of 400 costs three digits.
    return share if np.linalg.cond(share[1:]) < 100 else shares(rng, links, coordinates)


def bent(case: Case, share: Real, angle: Real, rate: Real, acceleration: Real) -> Case:
    """The case with its joints as the coordinates bend them."""
    joints = type(case.joints)(share @ angle, share @ rate, share @ acceleration)
    return Case(**{**vars(case), "joints": joints})


def mujoco_accelerations(case: Case, share: Real, moment: Real, clamped: bool) -> Real:
    """World accelerations of nose x, y and head angle, and of the coordinates, by MuJoCo's mass matrix and bias."""
    water = case.lumped_water("consistent")
    m = mujoco_chain.model(case.chain, water)
    d = mujoco.MjData(m)
    d.qpos[:] = np.concatenate([case.state[:3], case.joints.angle[1:]])
    d.qvel[:] = np.concatenate([case.state[3:], case.joints.rate[1:]])
    mujoco.mj_forward(m, d)
    matrix = np.zeros((m.nv, m.nv))
    for k, unit in enumerate(np.eye(m.nv)):
        mujoco.mj_mulM(m, d, matrix[k], unit)
    load = mujoco_chain.drag(m, d, water) - d.qfrc_bias
    columns = np.zeros((m.nv, 3 + share.shape[1]))
    columns[:3, :3] = np.eye(3)
    columns[3:, 3:] = share[1:]
    reduced, force = columns.T @ matrix @ columns, columns.T @ load + np.concatenate([np.zeros(3), moment])
    if clamped:
        return np.concatenate([np.zeros(3), np.linalg.solve(reduced[3:, 3:], force[3:])])
    return np.linalg.solve(reduced, force)


def planar_accelerations(model: _core.Model, share: Real, bend: Real, twist: Real, moment: Real, clamped: bool) -> Real:
    """The core's accelerations (3 + D,) of head and coordinates in the plane."""
    accelerations = _core.Body(model, {"share": share}).accelerations(
        _core.World({"clamped": clamped}),
        bend=bend[None],
        twist=np.array([[twist[0], twist[1], 0, 0, 0, twist[2]]]),
        pose=np.zeros((1, 9)),
        moment=moment[None],
    )[0]
    result: Real = np.delete(accelerations, [2, 3, 4])
    return result


@pytest.mark.parametrize("clamped", [False, True])
@pytest.mark.parametrize(("links", "coordinates"), [(4, 3), (8, 3), (8, 6), (20, 13)])
def test_accelerations_against_mujoco(links: int, coordinates: int, clamped: bool) -> None:
    rng = np.random.default_rng([40, links])
    for _ in range(30):
        share, moment = shares(rng, links, coordinates), rng.uniform(-1, 1, coordinates)
        angle, rate = rng.uniform(-0.3, 0.3, coordinates), rng.uniform(-5, 5, coordinates)
        case = bent(random_case(rng, links), share, angle, rate, np.zeros(coordinates))
        if clamped:
            case = Case(**{**vars(case), "twist": np.zeros(3)})
        expected = mujoco_accelerations(case, share, moment, clamped)
        if not clamped:
            expected[:3] = in_head_axes(expected[:3], case.twist)
        model = core_model(case, "lumped", "consistent")
        got = planar_accelerations(model, share, np.stack([angle, rate]), case.twist, moment, clamped)
        assert difference(got, expected) < 10 * ROUNDING  # the reduced matrix is worse conditioned than the whole


@pytest.mark.parametrize("law", LAWS)
def test_torques_of_a_prescribed_motion_give_its_accelerations(law: str) -> None:
    rng = np.random.default_rng(41)
    for _ in range(30):
        share = shares(rng, 8)
        angle, rate, wanted = (rng.uniform(-1, 1, COORDINATES) * scale for scale in (0.3, 5.0, 200.0))
        case = bent(random_case(rng, 8), share, angle, rate, wanted)
        model = core_model(case, law, "consistent")
        known = _core.dynamics(model, core_joints(case.joints)[None], case.twist[None])
        got = planar_accelerations(
            model, share, np.stack([angle, rate]), case.twist, (known["torque"] @ share)[0], clamped=False
        )
        assert difference(got, np.concatenate([known["acceleration"][0], wanted])) < ROUNDING
