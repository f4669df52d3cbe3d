"""The uncertainty budget: its percentiles, draws that diverge, and what is drawn."""

import budget
import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.bending import bend


def test_percentiles_of_equal_weights_are_plain_ones() -> None:
    values = np.random.default_rng(0).normal(size=2001)
    for percent in (5, 50, 95):
        expected = np.percentile(values, percent)
        assert budget.weighted(values, np.ones(2001), percent) == pytest.approx(expected, abs=0.01)


def test_a_weight_of_two_counts_as_two_draws() -> None:
    values, weight = np.array([1.0, 2.0, 5.0]), np.array([1.0, 2.0, 1.0])
    twice = np.array([1.0, 2.0, 2.0, 5.0])
    assert budget.weighted(values, weight, 50) == budget.weighted(twice, np.ones(4), 50) == 2


def test_draws_that_diverge_are_counted_and_left_out() -> None:
    """Speeds of 1 to 5 m/s; the draw without a number changes no interval."""
    runs = np.arange(1.0, 6.0)[:, None, None] * np.ones((5, 8, 2))
    lost = np.concatenate([runs, np.full((1, 8, 2), np.nan)])
    shipped = np.full((8, 2), 2.5)
    one, other = (budget.summary(part, np.ones(len(part)), shipped) for part in (runs, lost))
    assert (one.pop("diverged"), other.pop("diverged")) == (0, 1)
    assert one == other
    assert one["speed_m_s"]["optimised-max"][1] == 3
    assert one["shipped"]["percentile_power"] == 40  # of five draws, two are below 2.5 W


def test_a_drawn_robot_meets_both_published_bends_and_its_controller_knows_the_description() -> None:
    robot = ht.load("hypertuna")
    weight, drawn, known = next(budget.robots(robot, 1, seed=3))
    angles = [np.degrees(bend(drawn, joint, [250e3]).angle[0]) for joint in ("I", "II")]
    np.testing.assert_allclose(angles, (18.2, 31.2), atol=0.02)
    assert weight > 0
    assert drawn.joints[0].line != robot.joints[0].line == known.joints[0].line
    assert drawn.hinge is not None
    assert known.joints[0].actuator == robot.joints[0].actuator
