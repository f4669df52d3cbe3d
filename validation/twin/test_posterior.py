"""What the speeds say of the family afterwards: weights, intervals, and what is stored."""

from __future__ import annotations

import json

import budget
import family
import numpy as np
import posterior
import pytest

import hypertuna as ht
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.description.changes import changed
from hypertuna.paper.computed import SPEEDS
from hypertuna.paper.seeds import taken_hash

ROBOT = ht.load("hypertuna")


def test_a_member_that_is_twice_as_wrong_counts_a_sixteenth() -> None:
    """Four relative errors of one unknown size: the sum of their squares to the power of minus two."""
    wrong = np.exp(np.outer([0.1, 0.2], np.ones(8))) * budget.PUBLISHED
    weights = posterior.weights(wrong)
    assert weights.sum() == pytest.approx(1)
    assert weights[0] / weights[1] == pytest.approx(16)


def test_the_four_optimised_gaits_have_no_part_in_the_weights() -> None:
    speeds = np.exp(np.random.default_rng(1).normal(0, 0.2, (5, 8))) * budget.PUBLISHED
    other = speeds.copy()
    other[:, 4:] *= 3
    np.testing.assert_array_equal(posterior.weights(speeds), posterior.weights(other))


def test_a_member_whose_run_diverged_does_not_count() -> None:
    speeds = np.exp(np.random.default_rng(1).normal(0, 0.2, (5, 8))) * budget.PUBLISHED
    speeds[2, 5] = np.nan
    weights = posterior.weights(speeds)
    assert weights[2] == 0
    assert weights.sum() == pytest.approx(1)


def test_a_weight_of_two_counts_as_two_members() -> None:
    values, weight = np.array([1.0, 2.0, 5.0, np.nan]), np.array([1.0, 2.0, 1.0, 0.0])
    twice = np.array([1.0, 2.0, 2.0, 5.0])
    assert posterior.interval(values, weight)[1] == posterior.interval(twice, np.ones(4))[1] == 2


def test_a_free_axis_carries_what_its_film_buckles_at() -> None:
    """The film of the default robot has buckled in the filled joint."""
    for joint, group in enumerate(ROBOT.joints):
        assert group.actuator is not None
        assert posterior.held(ROBOT, joint) == pytest.approx(group.actuator.axis_buckling)


def test_an_axis_that_never_buckles_carries_its_stiffness_times_its_strain() -> None:
    other = changed(ROBOT, {"joints.actuator.axis_stiffness_n": 1e4, "joints.actuator.axis_buckling_n": 1e5})
    model = joint_models(other)[0]
    assert posterior.held(other, 0) >= -1e4 * model["rest"] > 10


def test_what_is_stored_is_fitted_and_of_the_present_robot_and_family() -> None:
    record = json.loads(posterior.FILE.read_text())
    assert record["class"] == "fitted"
    assert record["taken_hash"] == taken_hash(ROBOT), f"run: {record['command']}"
    assert record["family_hash"] == budget.family_hash(), f"run: {record['command']}"


def test_the_best_robots_meet_the_facts_and_swim_as_stored() -> None:
    record = json.loads(posterior.FILE.read_text())["robots"]
    for name, stored in record.items():
        robot = changed(ROBOT, stored["changes"])
        bends = [family.straightness(robot, joint)[0] for joint in range(len(robot.joints))]
        np.testing.assert_allclose(np.degrees(bends), (18.2, 31.2), rtol=0.1, err_msg=name)
        one = family.Candidate(robot, {})
        family.judge([one])
        assert not one.excluded, name
        runs = budget.swim([robot], SPEEDS, name)
        np.testing.assert_allclose(budget.eight(runs, "speed")[0], stored["speed_m_s"], rtol=0.03, err_msg=name)
