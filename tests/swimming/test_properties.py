"""Properties of every robot, every water law and every gait, with any numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import simpson

import hypertuna as ht
from hypertuna import _core
from hypertuna.swimming.model import core_model
from models import MODELS, fastest, has_linear_drag, later, mirrored, turning
from strategies import gaits, robots, states

Array = NDArray[np.float64]

FAR = 1e-12 * 100  # rounding of places up to 100 m or rad away
SEARCHED = 1e-6  # of two solutions found in different ways: each is settled to 1e-7 of its way
SOLVED = 1e-9  # of two solutions found by the same steps of Newton's method


def swum(robot: ht.Robot, gait: ht.Gait, *, twist: Array, pose: Array, steps: int = 64) -> dict[str, Array]:
    """A beat of the gait from a twist and a pose."""
    model, instants = core_model(robot), 2 * steps + 1
    angles = {name: getattr(gait, name) for name in ("frequency", "amplitude", "phase", "bias")}
    joints = _core.joint_motion(model, **angles, clock=np.linspace(0, 2 * np.pi, instants))
    found: dict[str, Array] = _core.advance(model, joints, step=1 / gait.frequency / steps, twist=twist, pose=pose)
    # Some drawn robots are too stiff for these steps: what they do then says nothing about the physics.
    assume(abs(found["twist"]).max() < 100)
    return found


# --- any robot


@given(st.data())
def test_the_water_only_takes(data: st.DataObject) -> None:
    robot = data.draw(robots())
    joints, twist = data.draw(states(robot))
    found = _core.dynamics(core_model(robot), joints[None], twist[None])
    assert found["loss"][0] >= 0
    assert found["energy"][0] >= 0


@given(st.data())
def test_a_mirrored_gait_makes_a_mirrored_path(data: st.DataObject) -> None:
    robot = data.draw(robots())
    gait = data.draw(gaits(robot, bias=0.2))
    twist, mirror = data.draw(states(robot))[1] / 4, np.array([1.0, -1.0, -1.0])
    path = swum(robot, gait, twist=twist, pose=np.zeros(3))
    image = swum(robot, mirrored(gait), twist=twist * mirror, pose=np.zeros(3))
    for name in ("pose", "twist"):
        np.testing.assert_allclose(image[name] * mirror, path[name], atol=1e-9 * abs(path[name]).max(), rtol=0)
    np.testing.assert_allclose(image["torque"], -path["torque"], atol=1e-9 * abs(path["torque"]).max(), rtol=0)
    np.testing.assert_allclose(image["loss"], path["loss"], atol=1e-9 * path["loss"].max(), rtol=0)


@given(st.data())
def test_where_and_whither_the_robot_starts_does_not_change_how_it_moves(data: st.DataObject) -> None:
    robot = data.draw(robots())
    gait = data.draw(gaits(robot, bias=0.2))
    twist = data.draw(states(robot))[1] / 10
    start = np.array([data.draw(st.floats(-10, 10)) for _ in range(3)])
    here = swum(robot, gait, twist=twist, pose=np.zeros(3))
    there = swum(robot, gait, twist=twist, pose=start)
    for name in ("twist", "torque", "loss", "energy"):
        np.testing.assert_array_equal(there[name], here[name])
    path = here["pose"][:, 0] + 1j * here["pose"][:, 1]
    moved = there["pose"][:, 0] + 1j * there["pose"][:, 1]
    np.testing.assert_allclose(moved, start[0] + 1j * start[1] + np.exp(1j * start[2]) * path, atol=FAR, rtol=0)
    np.testing.assert_allclose(there["pose"][:, 2], start[2] + here["pose"][:, 2], atol=FAR, rtol=0)


@given(st.data())
def test_work_goes_into_the_water_and_into_motion(data: st.DataObject) -> None:
    """Along a transient: work of the joints - loss = change of kinetic energy, in the limit of small steps."""
    robot = data.draw(robots())
    gait = data.draw(gaits(robot))
    twist = data.draw(states(robot))[1] / 10

    def imbalance(steps: int) -> float:
        found = swum(robot, gait, twist=twist, pose=np.zeros(3), steps=steps)
        joints = _core.joint_motion(
            core_model(robot),
            frequency=gait.frequency,
            amplitude=gait.amplitude,
            phase=gait.phase,
            bias=gait.bias,
            clock=np.linspace(0, 2 * np.pi, steps + 1),
        )
        power = (found["torque"] * joints[:, :, 1]).sum(axis=1)
        spent = simpson(power - found["loss"], dx=1 / gait.frequency / steps)
        scale = simpson(abs(power) + found["loss"], dx=1 / gait.frequency / steps)
        return float(abs(spent - (found["energy"][-1] - found["energy"][0])) / scale)

    # below 1e-6, or on the way there where a drawn motion is fast: the order is 2.5 at least
    assert imbalance(4096) < max(1e-6, imbalance(2048) / 5)


# --- every shipped model


@given(data=st.data())
def test_the_mirrored_gait_swims_as_fast_and_turns_the_other_way(every_model: ht.Robot, data: st.DataObject) -> None:
    gait = data.draw(gaits(every_model, bias=0.1))
    swim, image = ht.swim(every_model, gait), ht.swim(every_model, mirrored(gait))
    assert image.status == swim.status
    assert image.speed == pytest.approx(swim.speed, rel=SOLVED)
    assert image.mechanical_power == pytest.approx(swim.mechanical_power, rel=SOLVED)
    assert image.turn_rate == pytest.approx(-swim.turn_rate, rel=SOLVED, abs=SOLVED * gait.frequency)


MEANS = ("mechanical_power", "mechanical_power_positive", "power_to_water", "tail_excursion", "stride_length", "speed")


def test_the_beginning_of_a_straight_beat_is_arbitrary(every_model: ht.Robot) -> None:
    """Means over a settled beat do not depend on where the beat is taken to begin."""
    gait = fastest(every_model)
    swim, shifted = ht.swim(every_model, gait), ht.swim(every_model, later(gait, 0.25))
    for name in MEANS:
        assert getattr(shifted, name) == pytest.approx(getattr(swim, name), rel=SEARCHED), name


def test_the_beginning_of_a_turning_beat_is_arbitrary(every_model: ht.Robot) -> None:
    gait = turning(every_model)
    swim, shifted = ht.swim(every_model, gait), ht.swim(every_model, later(gait, 0.25))
    for name in ("turn_rate", "turn_radius", *MEANS):
        assert getattr(shifted, name) == pytest.approx(getattr(swim, name), rel=SEARCHED), name


def test_speed_is_proportional_to_frequency(every_model: ht.Robot) -> None:
    """Inertia and quadratic drag have no time of their own: U/f, P/f^3 and the multipliers are constants."""
    if has_linear_drag(every_model):
        pytest.skip("linear drag has a time of its own")
    robot, gait = every_model.using(joints="ideal"), fastest(every_model)
    slow = ht.swim(robot, gait)
    for factor in (0.1, 3.0, 17.0):
        fast = ht.swim(robot, replace(gait, frequency=factor * gait.frequency))
        assert fast.speed == pytest.approx(factor * slow.speed, rel=SOLVED)
        assert fast.mechanical_power == pytest.approx(factor**3 * slow.mechanical_power, rel=SOLVED)
        assert fast.strouhal == pytest.approx(slow.strouhal, rel=SOLVED)
        np.testing.assert_allclose(fast.multipliers, slow.multipliers, rtol=SEARCHED, atol=SEARCHED)


@pytest.mark.parametrize("name", [name for name, robot in MODELS.items() if has_linear_drag(robot)])
def test_linear_drag_and_bandwidth_have_a_time_of_their_own(name: str) -> None:
    """The counterpart: the test above would notice."""
    robot = MODELS[name].using(joints="ideal")
    gait = fastest(robot)
    slow, fast = ht.swim(robot, gait), ht.swim(robot, replace(gait, frequency=3 * gait.frequency))
    assert fast.stride_length > slow.stride_length * 1.001


def test_work_of_the_joints_is_what_the_water_takes(every_model: ht.Robot) -> None:
    """Over a settled beat, in the limit of small steps."""
    gait = fastest(every_model)

    def imbalance(steps: int) -> float:
        swim = ht.swim(every_model, gait, steps=steps)
        return abs(swim.mechanical_power / swim.power_to_water - 1)

    assert imbalance(128) < 1e-5
    assert imbalance(512) < 1e-6  # how it falls with the steps: test_convergence.py


@given(data=st.data())
def test_a_settled_beat_closes(every_model: ht.Robot, data: st.DataObject) -> None:
    swim = ht.swim(every_model, data.draw(gaits(every_model, bias=0.1)))
    assert swim.status in ("settled", "unstable")
    motion, frequency = swim.trajectory, swim.gait.frequency
    for name, size in {
        "u": every_model.body.length * frequency,
        "v": every_model.body.length * frequency,
        "r": frequency,
    }.items():
        # the status promises 1e-7 of the distance traveled in a beat, and the change over a beat is less than that
        assert abs(float(motion[name][-1] - motion[name][0])) < 2e-7 * size
