"""Objectives and limits: values checkable by hand, derivatives against differences, gaits that must never win."""

import math
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.optimization.constraints import gait_limits, gait_quantities
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import UNUSABLE, expected_speed, objective
from hypertuna.optimization.problem import Problem
from hypertuna.swimming.beat import settle


@pytest.fixture(scope="module")
def points(tuna: ht.Robot) -> np.ndarray:
    """Eight gaits inside the box, away from its edges and from the phase where no way is made."""
    space = gait_bounds(tuna)
    part = np.random.default_rng(3).uniform(0.2, 0.9, (8, 4))
    return space.lower + part * (space.upper - space.lower)


def everything(robot: ht.Robot) -> Problem:
    """Objectives and limits of every kind."""
    limits = gait_limits(robot, joint_rate=6.0, torque=2.0, amplitude_by_bandwidth=True, strouhal=(0.3, 0.9), speed=0.2)
    targets = (
        objective("speed"),
        objective("cost_of_transport"),
        expected_speed(0.35, 0.1),
        objective("mechanical_power", maximize=True),
    )
    return Problem(robot, gait_bounds(robot), targets, limits)


def test_values_are_those_of_single_swims(tuna: ht.Robot, points: np.ndarray) -> None:
    told = everything(tuna).evaluate(points)
    for x, value in zip(points, told.value, strict=True):
        swum = ht.swim(tuna, gait_bounds(tuna).gait(x))
        tracked = abs(swum.speed - 0.35) + 0.1 * swum.cost_of_transport  # Eq. 42
        assert value.tolist() == pytest.approx(
            [-swum.speed, swum.cost_of_transport, tracked, -swum.mechanical_power], rel=1e-12
        )


def test_violations_are_relative_to_their_limits(tuna: ht.Robot, points: np.ndarray) -> None:
    problem = everything(tuna)
    told = problem.evaluate(points)
    for k, limit in enumerate(problem.limits):
        value = told.quantities[limit.quantity]
        passed = value > limit.limit if limit.upper else value < limit.limit
        assert ((told.violation[:, k] > 0) == passed).all()
        assert np.abs(told.violation[:, k]) == pytest.approx(np.abs(value / limit.limit - 1))
    assert told.feasible.tolist() == (told.violation <= 0).all(axis=1).tolist()
    assert 0 < told.feasible.sum() < len(points)  # both kinds are among the points


def test_rate_and_reach_by_hand(tuna: ht.Robot) -> None:
    gaits = ht.Gaits.of([ht.Gait.from_degrees(frequency=4.7, amplitude=(8, 25), phase=(0, 40))])
    lagging, _ = gait_quantities(tuna, gaits)
    ideal, _ = gait_quantities(tuna.using(joints="ideal"), gaits)
    # At the bandwidth of 4.7 Hz a joint makes 1/sqrt(2) of what it is commanded; a sine's largest rate is 2 pi f A.
    assert ideal["rate_I"][0] == pytest.approx(2 * math.pi * 4.7 * math.radians(8))
    assert lagging["rate_I"][0] == pytest.approx(ideal["rate_I"][0] / math.sqrt(2))
    assert ideal["reach_I"][0] == pytest.approx(math.sqrt(2) * 8 / 16)
    assert ideal["reach_II"][0] == pytest.approx(math.sqrt(2))


@pytest.mark.parametrize("joints", ["bandwidth", "ideal"])
def test_derivatives_are_those_of_differences(tuna: ht.Robot, points: np.ndarray, joints: str) -> None:
    problem = everything(tuna.using(joints=joints))
    told = problem.evaluate(points, derivatives=True)
    assert told.value_jacobian is not None
    assert told.violation_jacobian is not None
    width = problem.space.upper - problem.space.lower
    for k in range(4):
        step = 1e-5 * width[k] * np.eye(4)[k]
        ahead, behind = problem.evaluate(points + step), problem.evaluate(points - step)
        for name, jacobian in (("value", told.value_jacobian), ("violation", told.violation_jacobian)):
            difference = (getattr(ahead, name) - getattr(behind, name)) / 2e-5
            size = np.abs(jacobian * width).max(axis=(0, 2)) + 1e-12
            assert np.abs(difference - jacobian[:, :, k] * width[k]) / size == pytest.approx(0, abs=1e-6)


def test_gaits_that_stand_still_or_swim_backwards_never_win(tuna: ht.Robot) -> None:
    problem = Problem(tuna, gait_bounds(tuna, {"phase_II": (0, 360)}), (objective("cost_of_transport"),))
    still = [2.0, 0.0, 0.0, 0.0]
    backwards = [2.0, math.radians(16), math.radians(25), math.radians(210)]
    forwards = [2.0, math.radians(16), math.radians(25), math.radians(30)]
    told = problem.evaluate(np.array([still, backwards, forwards]))
    assert told.quantities["speed"][1] < 0 < told.quantities["speed"][2]
    assert told.value[:2, 0].tolist() == [np.inf, np.inf]
    assert told.feasible.tolist() == [False, False, True]
    assert told.total_violation[2] == 0 < told.total_violation[0] < told.total_violation[1]


@pytest.mark.parametrize("status", [1, 2, 3])
@pytest.mark.parametrize("broken", [{}, {"speed": np.nan}, {"cost_of_transport": -np.inf}])
def test_gaits_that_do_not_settle_never_win(tuna: ht.Robot, status: int, broken: dict[str, float]) -> None:
    """However good what they seem to reach, and where it is no number even if they claim to be settled."""
    problem = Problem(tuna, gait_bounds(tuna), (objective("speed"), objective("cost_of_transport")))
    found: dict[str, Any] = {"speed": 9.0, "cost_of_transport": 0.0, "stride_length": 1.0, "status": status} | broken
    told = problem.judge(np.zeros((1, 4)), {name: [value] for name, value in found.items()})
    assert (told.value == np.inf).all()
    assert not told.feasible[0]
    assert told.violation.tolist() == [[UNUSABLE]]
    if broken:
        settled = problem.judge(np.zeros((1, 4)), {name: [value] for name, value in (found | {"status": 0}).items()})
        assert not settled.feasible[0]


def test_a_limit_passed_however_far_is_better_than_a_gait_that_does_not_settle(tuna: ht.Robot) -> None:
    """A torque limit of a micronewton meter is passed a hundred thousand times over."""
    problem = Problem(tuna, gait_bounds(tuna), (objective("speed"),), gait_limits(tuna, torque=1e-6))
    fast = problem.swim(problem.space.upper[np.newaxis])
    settled = problem.judge(np.zeros((1, 4)), fast)
    unsettled = problem.judge(np.zeros((1, 4)), fast | {"status": [1]})
    assert 1e4 < settled.total_violation < unsettled.total_violation


def test_threads_and_batches_do_not_change_what_is_found(tuna: ht.Robot, points: np.ndarray) -> None:
    problem = everything(tuna)
    whole = problem.evaluate(points, derivatives=True)
    parts = problem.evaluate(points[:3], derivatives=True).followed_by(problem.evaluate(points[3:], derivatives=True))
    for name in ("x", "value", "violation", "value_jacobian", "violation_jacobian", "speed_gradient"):
        assert getattr(whole, name).tolist() == getattr(parts, name).tolist()
    assert whole.rows([2]).quantities["speed"][0] == whole.quantities["speed"][2]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda _: objective("sped"), "must be a quantity to optimize, but is 'sped': did you mean speed"),
        (lambda _: expected_speed(0.0, 0.1), "speed must be greater than 0"),
        (lambda _: expected_speed(0.4, -1.0), "weight must not be negative"),
        (lambda _: expected_speed(0.4, np.nan), "weight must be a finite number"),
        (lambda fish: gait_limits(fish, joint_rate=0.0), "joint_rate must be greater than 0"),
        (lambda fish: gait_limits(fish, torque=np.inf), "torque must be a finite number"),
        (lambda fish: gait_limits(fish, strouhal=(0.4, 0.2)), "strouhal must have the lower value first"),
        (lambda fish: gait_limits(fish, strouhal=(0.0, 0.2)), "strouhal must be greater than 0"),
        (
            lambda _: gait_limits(ht.load("rexeel"), amplitude_by_bandwidth=True),
            r"joints\[0\].amplitude_max_deg is needed",
        ),
    ],
)
def test_objectives_that_make_no_sense_are_refused(tuna: ht.Robot, make: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        make(tuna)


def test_largest_rate_of_the_gait_is_that_of_its_swim(tuna: ht.Robot, points: np.ndarray) -> None:
    for robot in (tuna, tuna.using(joints="ideal")):
        gaits = gait_bounds(robot).gaits(points)
        rates, _ = gait_quantities(robot, gaits)
        swum = settle(robot, gaits)
        assert np.maximum(rates["rate_I"], rates["rate_II"]) == pytest.approx(swum["rate_peak"], rel=1e-12)


def test_quantities_without_derivatives_are_refused(tuna: ht.Robot, points: np.ndarray) -> None:
    problem = Problem(tuna, gait_bounds(tuna), (objective("efficiency"),))
    assert np.isfinite(problem.evaluate(points).value).all()
    with pytest.raises(InputError, match="efficiency has no derivatives: choose a method without gradients"):
        problem.evaluate(points, derivatives=True)
