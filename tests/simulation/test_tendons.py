"""Tendons in the twin: beside the settled beat, and beside an axle with the drum's servo as the joints feel it."""

from __future__ import annotations

import copy
import tomllib
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.new import first_robot
from hypertuna.control.controller import controller_columns
from hypertuna.description.robot import Robot, parse
from hypertuna.simulation.plant import parts_of
from hypertuna.swimming.model import core_model

FISH = tomllib.loads(first_robot("fish", links=5, joints=["tail"], actuation="tendons"))
SMALL = ht.Gait.from_degrees(frequency=1.5, amplitude=(10,), phase=(0,))  # within the pulses of any drum
GAIT = ht.Gait.from_degrees(frequency=1.5, amplitude=(30,), phase=(0,))


def fish(drums: list[float] | None, **servo: float) -> Robot:
    """The fish of four joints and one servo; drums [m] of tendons that end on levers of 10 mm, or without tendons."""
    document = copy.deepcopy(FISH)
    group = document["joints"][0]
    group["servo"] |= {"friction_n_m": 0.0, "inertia_kg_m2": 1e-4, "stall_current_a": 0.5} | servo
    del group["tendons"], document["sources"]["joints.tendons"]
    if drums is not None:
        group["tendons"] = {"drum_m": drums, "lever_m": [[0.0] * i + [0.01] for i in range(4)]}
    return parse(document)


SMALL_DRUM = fish([0.001, 0.002, 0.003, 0.002])  # 1.25 turns of the drum a turn of the tail


def test_the_plant_moves_as_the_settled_beat_under_its_torque() -> None:
    """The settled beat's torque at the drum, and that of the rotor, make the twin's plant move as the beat does."""
    swim = ht.swim(SMALL_DRUM, GAIT)
    motion, group = swim.trajectory, SMALL_DRUM.joints[0]
    clock = 2 * np.pi * np.linspace(0, 1, 129)
    joints = _core.joint_motion(core_model(SMALL_DRUM), **vars(GAIT), clock=clock)
    bend = joints[:, 1:].sum(axis=1)  # angle, rate and acceleration of the group
    assert group.servo is not None
    torque = motion.motor_torque.to_numpy()[:, 0] + group.servo.inertia * group.turns * bend[:, 2]
    got = parts_of(SMALL_DRUM, "water", None).plant.accelerations(
        _core.World({"clamped": 0.0}),
        bend=np.ascontiguousarray(bend[:, :2, np.newaxis]),
        twist=np.stack([motion.u, motion.v, *np.zeros((3, 129)), motion.r], axis=1),
        pose=np.zeros((129, 9)),
        moment=np.ascontiguousarray(group.turns * torque[:, np.newaxis]),
    )
    np.testing.assert_allclose(got[:, 6], bend[:, 2], atol=1e-8 * abs(bend[:, 2]).max())


@pytest.mark.parametrize("turns", [1.25, 3.0])
def test_the_drum_is_an_axle_with_its_torque_speed_and_inertia_as_the_joints_feel_them(turns: float) -> None:
    """T n, w / n and I n^2, n the turns of the drum: to rounding the same motion and power, and n times the angle."""
    drums = [0.01 / (4 * turns)] * 4
    run, own = ht.twin(fish(drums), SMALL, duration=4), FISH["joints"][0]["servo"]
    assert run.robot.joints[0].turns == pytest.approx(turns, rel=1e-14)
    seen = {"torque_n_m": turns * own["torque_n_m"], "speed_rad_s": own["speed_rad_s"] / turns}
    axle = ht.twin(fish(None, **seen, inertia_kg_m2=1e-4 * turns**2), SMALL, duration=4)
    for name in ("angle", "rate", "speed", "electrical_power"):
        scale = abs(axle.data[name]).max()
        np.testing.assert_allclose(run.data[name], axle.data[name], atol=1e-8 * scale, err_msg=name)
    for name, factor in {"servo_angle": turns, "servo_rate": turns, "servo_target": turns}.items():
        scale = turns * abs(axle.data[name]).max()
        np.testing.assert_allclose(run.data[name], factor * axle.data[name], atol=1e-8 * scale, err_msg=name)
    torque = run.data["servo_torque"]
    np.testing.assert_allclose(torque, axle.data["servo_torque"] / turns, atol=1e-8 * abs(torque).max())
    assert abs(torque).max() <= own["torque_n_m"] * (1 + 1e-9)
    pulses = controller_columns(run.robot)["pulse_per_rad"][0] * run.data["servo_target"][:, 0]
    center = controller_columns(run.robot)["pulse_center"][0]
    np.testing.assert_allclose(run.data["pulse"][:, 0], center + pulses, atol=1e-12)


def test_one_turn_has_the_bits_of_an_axle() -> None:
    one, other = (ht.twin(robot, "cruise", duration=1) for robot in (fish([0.0025] * 4), fish(None)))
    for name, values in one.data.items():
        np.testing.assert_array_equal(values, other.data[name], err_msg=name)


def test_runs_side_by_side_differ_in_their_drums() -> None:
    """Lanes of robots with other turns have the bits that each has alone."""
    from hypertuna.simulation.twin import twins

    robots = [fish([drum] * 4) for drum in (0.0025, 0.002, 0.001)]
    options: list[dict[str, Any]] = [{"robot": one, "gait": GAIT, "duration": 0.5, "seed": 1} for one in robots]
    together = twins(options, measure=lambda run: run)
    for one, run in zip(options, together, strict=True):
        alone = ht.twin(**one)
        for name in ("angle", "servo_angle", "servo_torque", "speed"):
            np.testing.assert_array_equal(run.data[name], alone.data[name], err_msg=name)
    assert np.ptp(together[0].data["servo_angle"]) < np.ptp(together[2].data["servo_angle"])


def test_the_twin_swims_as_the_settled_beat_does() -> None:
    """A strong servo follows the command: after the transient, speed and swing are those of the settled beat."""
    strong = fish([0.001, 0.002, 0.003, 0.002], torque_n_m=2.0, speed_rad_s=40.0)
    run = ht.twin(strong, GAIT, duration=20)
    settled = ht.swim(strong, GAIT)
    assert np.degrees(run.swing) == pytest.approx([30], rel=1e-3)
    assert run.speed == pytest.approx(settled.speed, rel=1e-3)
