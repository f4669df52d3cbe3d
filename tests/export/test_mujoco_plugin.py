"""The water as an engine plugin of MuJoCo: the core's accelerations to rounding, its speeds."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.simulation.sea import Sea, space_columns, world_at_sea
from hypertuna.swimming.model import core_model
from models import changed
from mujoco_play import load_plugin, model, speed

LAWS = ("lumped", "strip", "elongated")
SIDES = ("port", "starboard")


def robot(law: str) -> ht.Robot:
    """HyperTuna with ideal joints."""
    return ht.load("hypertuna").using(joints="ideal", water=law)


def mass_matrix(m: mujoco.MjModel, d: mujoco.MjData) -> Array:
    """The mass matrix (nv, nv) that MuJoCo computes with."""
    matrix = np.zeros((m.nv, m.nv))
    for row, unit in zip(matrix, np.eye(m.nv), strict=True):
        mujoco.mj_mulM(m, d, row, unit)
    return matrix


def shares(fish: ht.Robot) -> Array:
    """Share of each joint group in the front joint of each link (links, groups)."""
    share = np.zeros((len(fish.links.name), len(fish.joints)))
    for g, group in enumerate(fish.joints):
        share[list(group.links), g] = group.share
    return share


def test_all_position_servos_have_the_same_poles() -> None:
    """500 rad/s and the damping of a maximally flat response, for the rotor that each of them turns."""
    m = model(robot("lumped"), plugin=True, free=True)
    for side in SIDES:
        servo, dof = m.actuator(f"pectoral-{side}"), m.joint(f"pectoral-{side}").dofadr[0]
        inertia = m.dof_armature[dof]
        assert servo.gainprm[0] == pytest.approx(500.0**2 * inertia)
        assert -servo.biasprm[2] == pytest.approx(np.sqrt(2) * 500.0 * inertia)
    for group in robot("lumped").joints:
        inertia = m.dof_armature[m.joint(f"joint-{robot('lumped').links.name[group.links[0]]}").dofadr[0]]
        squares = sum(part**2 for part in group.share)
        assert m.actuator(group.name).gainprm[0] == pytest.approx(500.0**2 * inertia * squares)


@pytest.mark.parametrize("law", LAWS)
def test_accelerations_in_space_are_the_cores(law: str) -> None:
    """At random states, under water and at the surface: weight, buoyancy, added mass, drag, wake, fins."""
    rng, heights = np.random.default_rng(20), [0.004, -0.003, 0.002, 0.001, 0.002, -0.001, 0.003, -0.002]
    fish = changed(robot(law), {"spatial.buoyancy_height_m": heights}).using(joints="ideal", water=law)
    m = model(fish, plugin=True, free=True)
    d, share, fins = mujoco.MjData(m), shares(fish), [m.body(f"pectoral-{side}").id for side in SIDES]
    driven = [(m.joint(f"joint-{fish.links.name[i]}"), share[i]) for i in np.flatnonzero(share.any(axis=1))]
    # Neither rotors nor the fins' own milligrams, which the core has not.
    for joint, _ in driven:
        m.dof_armature[joint.dofadr] = 0
    m.body_mass[m.body(fish.links.name[0]).id] += m.body_mass[fins].sum()
    m.body_mass[fins], m.body_inertia[fins] = 0, 0
    body = _core.Body(core_model(fish), {"share": share, **space_columns(fish)})
    world = world_at_sea(fish, Sea())
    for depth in (2.0, 0.05) * 10:
        q, v, w = rng.normal(size=4), rng.uniform(-1, 1, 3), rng.uniform(-4, 4, 3)
        q /= np.linalg.norm(q)
        angle, rate, fin, moment = rng.uniform(-1, 1, (4, 2)) * np.array([[0.4], [6], [1], [1]])
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, q)
        turn = turn.reshape(3, 3)
        d.qpos[:7], d.qvel[:6] = [0.3, -1, -depth, *q], [*turn @ v, *w]
        columns = np.zeros((m.nv, 8))  # from twist and bends to MuJoCo's velocities
        columns[:3, :3], columns[3:6, 3:6] = turn, np.eye(3)
        for joint, part in driven:
            d.qpos[joint.qposadr], d.qvel[joint.dofadr] = part @ angle, part @ rate
            columns[joint.dofadr, 6:] = part
        for side, at in zip(SIDES, fin, strict=True):
            d.joint(f"pectoral-{side}").qpos[:] = at
        mujoco.mj_forward(m, d)
        matrix, turning = mass_matrix(m, d), np.zeros(m.nv)
        turning[:3] = turn @ np.cross(w, v)  # d/dt of the nose's velocity in the world is R (v' + w x v)
        load = columns.T @ (d.qfrc_passive - d.qfrc_bias - matrix @ turning)
        load[6:] += moment
        accelerations = np.linalg.solve(columns.T @ matrix @ columns, load)
        expected = body.accelerations(
            world,
            bend=np.array([[angle, rate]]),
            twist=np.concatenate([v, w])[np.newaxis],
            pose=np.array([[0.3, -1, -depth, *q, *fin]]),
            moment=moment[np.newaxis],
        )[0]
        assert accelerations == pytest.approx(expected, abs=1e-11 * abs(expected).max())


@pytest.mark.parametrize("law", LAWS)
def test_speeds_are_the_cores(law: str) -> None:
    """After 60 beats, by the integrator and the time step of the file; all gaits are in validation/mujoco."""
    fish, gait = robot(law), "optimised-0.4"
    assert speed(model(fish, plugin=True), gait, beats=60) == pytest.approx(ht.swim(fish, gait).speed, rel=1e-3)


def test_a_robot_of_strips_without_a_space_of_its_own_swims_too() -> None:
    eel = ht.load("rexeel")
    assert speed(model(eel, plugin=True), "wave-30", beats=12) == pytest.approx(ht.swim(eel, "wave-30").speed, rel=2e-3)


def test_a_robot_a_thousand_times_lighter_than_its_water_swims() -> None:
    """As an explicit force, added mass would make time-stepping diverge."""
    fish = robot("strip")
    light = changed(fish, {"links.mass_kg": [mass / 1000 for mass in fish.links.mass]})
    assert speed(model(light, plugin=True), "unoptimised-max", beats=60) == pytest.approx(
        ht.swim(light, "unoptimised-max").speed, rel=1e-3
    )


def test_the_mass_matrix_is_made_anew_each_time() -> None:
    """Repeated and partial computations of a state give the same result."""
    m = model(robot("strip"), plugin=True)
    d = mujoco.MjData(m)
    d.qvel[:] = 0.1
    mujoco.mj_forward(m, d)
    matrix, acceleration = mass_matrix(m, d), d.qacc.copy()
    mujoco.mj_forwardSkip(m, d, mujoco.mjtStage.mjSTAGE_POS, 0)
    mujoco.mj_forward(m, d)
    assert (mass_matrix(m, d) == matrix).all()
    assert d.qacc == pytest.approx(acceleration, rel=1e-9)


def test_columns_that_are_not_a_robots_are_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)  # where MuJoCo writes its log
    load_plugin()
    text = ht.mjcf(robot("strip"), plugin=True)
    for broken, sentence in (
        (text.replace('value="strip"', 'value="stripes"'), "law: must be one of lumped, strip, elongated"),
        (text.replace("wetted_area 8 1", "area 8 1"), "lacks wetted_area"),
        (text.replace('<plugin instance="water" />', "", 1), "must be the plugin of 8 bodies, but is of 7"),
        (text.replace("joint_group 8 1", "joint_group 4294967295 0"), "joint_group: must have one link or more"),
        (
            text.replace("joint_group 8 1", "joint_group 9223372036854775812 2"),
            "joint_group: must have one link or more",
        ),
        (re.sub(r"wetted_area 8 1 \S+", "wetted_area 8 1 nan", text), "wetted_area: has a number that no robot has"),
    ):
        with pytest.raises(ValueError, match=sentence):
            mujoco.MjModel.from_xml_string(broken)
