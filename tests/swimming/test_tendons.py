"""Joints on tendons in settled beats: virtual work, the bits of equal shares, exact derivatives by shares."""

from __future__ import annotations

import copy
import tomllib
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import Robot, parse
from hypertuna.optimization.optimize import optimize
from hypertuna.swimming.designs import design_of

FISH = tomllib.loads(first_robot("fish", links=5, joints=["tail"], actuation="tendons"))


def on_tendons(**tendons: Any) -> Robot:
    """The fish of four joints and one servo with other tendons."""
    document = copy.deepcopy(FISH)
    document["joints"][0]["tendons"] |= tendons
    return parse(document)


def apart(drums: list[float]) -> dict[str, Any]:
    """Tendons that end at their joints on levers of 8 mm and run through the axles before."""
    return {"drum_m": drums, "lever_m": [[0.0] * i + [0.008] for i in range(len(drums))]}


UNEQUAL = on_tendons(**apart([0.002, 0.004, 0.006, 0.010]))


def test_the_motor_does_the_work_of_all_joints() -> None:
    """Torque at the drum by its rate: the power of the joints, at every instant; turning, too."""
    for bias in (0.0, 5.0):
        gait = ht.Gait.from_degrees(frequency=2, amplitude=(30,), phase=(0,), bias=(bias,))
        motion = ht.swim(UNEQUAL, gait).trajectory
        joints = (motion.joint_torque * motion.joint_rate).sum("link").to_numpy()
        turns = UNEQUAL.joints[0].turns
        assert turns == pytest.approx(0.008 / 0.022, rel=1e-14)
        rate = turns * motion.joint_rate.isel(link=4).to_numpy() / UNEQUAL.joints[0].share[3]
        power = motion.motor_torque.isel(group=0).to_numpy() * rate
        np.testing.assert_allclose(power, joints, atol=1e-12 * abs(joints).max())
        parts = np.outer(motion.bend, [1 / 11, 2 / 11, 3 / 11, 5 / 11])
        np.testing.assert_allclose(motion.joint_angle[:, 1:], parts, atol=1e-15)


def test_equal_bends_have_the_bits_of_equal_shares() -> None:
    """Settled, turning and through time: the file without the table tendons is the same robot."""
    document = copy.deepcopy(FISH)
    del document["joints"][0]["tendons"], document["sources"]["joints.tendons"]
    plain, equal = parse(document), on_tendons(**apart([0.002] * 4))
    assert equal.joints[0].share == plain.joints[0].share
    assert equal.joints[0].turns == 1.0
    for bias in (0.0, 5.0):
        gait = ht.Gait.from_degrees(frequency=2, amplitude=(30,), phase=(0,), bias=(bias,))
        one, other = ht.swim(plain, gait), ht.swim(equal, gait)
        for name in one.trajectory.data_vars:
            np.testing.assert_array_equal(one.trajectory[name], other.trajectory[name], err_msg=str(name))
        assert one.power_to_water == other.power_to_water


def test_derivatives_by_shares_are_exact() -> None:
    """Against differences of fourth order, of robots whose shares no longer add up to one: nothing asks for that."""
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(30,), phase=(0,), bias=(4,))
    found = ht.gradient(UNEQUAL, gait)
    names = [f"joints.share[{k}]" for k in (1, 2, 3, 4)]
    assert [*found.names[-4:]] == names
    group = UNEQUAL.joints[0]
    quantities = ("speed", "mechanical_power", "mechanical_power_positive", "cost_of_transport", "turn_rate")
    for k in range(4):
        values = []
        for step in (-2, -1, 1, 2):
            share = list(group.share)
            share[k] += 1e-3 * step
            other = group.model_copy(update={"share": tuple(share)})
            values.append(
                [getattr(ht.swim(UNEQUAL.model_copy(update={"joints": (other,)}), gait), q) for q in quantities]
            )
        slopes = np.array([1, -8, 8, -1]) @ np.array(values) / 12e-3
        wanted = [found.derivatives[q][found.names.index(names[k])] for q in quantities]
        np.testing.assert_allclose(wanted, slopes, rtol=1e-6)


def test_levers_are_variables_of_a_design() -> None:
    """The search ends where its own derivative by the last lever is zero, or at a bound, and is no slower."""
    key = "joints.tail.tendons.drum_m[3]"
    best = optimize(
        UNEQUAL, maximize="speed", bounds={"frequency": (2, 2), "amplitude": (30, 30)}, design={key: (0.006, 0.02)}
    )
    assert best.robot.joints[0].tendons is not None
    assert best.swim.speed > ht.swim(UNEQUAL, ht.Gait.from_degrees(frequency=2, amplitude=(30,), phase=(0,))).speed


def test_beside_hinges_levers_have_no_derivative() -> None:
    document = UNEQUAL.document()
    document["joints"][0] |= {"links": [1, 2, 3]}
    document["joints"][0]["tendons"] = apart([0.002, 0.004, 0.006])
    document["hinge"] = {"link": 4, "stiffness_n_m_per_rad": 0.05, "damping_n_m_s_per_rad": 1e-4}
    fish, key = parse(document), "joints.tail.tendons.drum_m[1]"
    with pytest.raises(ht.InputError, match="has no derivative beside passive hinges"):
        design_of(fish, {key: (0.004, 0.005)})
    swept = ht.sweep(
        fish, [ht.Gait.from_degrees(frequency=2, amplitude=(20,), phase=(0,))], design={key: (0.004, 0.005)}
    )
    assert swept.settled.all()
    assert swept.speed.values[0] != swept.speed.values[1]
