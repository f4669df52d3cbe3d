"""Goals, observations, rewards and actions by hand."""

from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.learning.spans import LAG, Span, knobs, sensed_size, span_of, ticks_of
from hypertuna.learning.tasks import TASKS, Goto, Outcome, Seen, Station, Swim, Turn, wrapped


class Part:
    """Draws numbers at a part of their range."""

    def __init__(self, part: float) -> None:
        self.part = part

    def uniform(self, low: float, high: float, size: int | None = None) -> Any:
        """Draw."""
        value = low + self.part * (high - low)
        return value if size is None else np.full(size, value)


@pytest.mark.parametrize(
    ("task", "goals"),
    [
        (Swim(), [(0.3,), (0.9,), (1.5,)]),
        (Turn(), [(-np.pi,), (0.0,), (np.pi,)]),
        (Goto(), [(-3.0, 0.0), (5.5, 0.0), (-8.0, 0.0)]),  # bearings -180, 0 and 180 deg
        (Station(), [(0.0, 0.0)] * 3),
    ],
)
def test_goals_are_drawn_from_their_range(task: Any, goals: list[tuple[float, ...]]) -> None:
    for part, goal in zip((0, 0.5, 1), goals, strict=True):
        np.testing.assert_allclose(task.goal(Part(part)), goal, atol=1e-12)


def test_episodes_and_currents() -> None:
    assert {name: (kind.size, kind().seconds, kind().current) for name, kind in TASKS.items()} == {
        "Swim": (1, 10.0, 0.0),
        "Turn": (2, 40.0, 0.0),
        "Goto": (3, 60.0, 0.0),
        "Station": (5, 60.0, 0.5),
    }


def seen(*positions: tuple[float, float], heading: float = 0.0, speed: float = 0.0, effort: float = 0.0) -> Seen:
    """Swimmers that differ by their place."""
    count = len(positions)
    return Seen(np.array(positions, float), np.full(count, heading), np.full(count, speed), np.full(count, effort))


def judged(outcome: Outcome) -> list[tuple[float, bool, bool]]:
    """Return the parts of an outcome by swimmer."""
    return [(round(float(r), 9), bool(d), bool(s)) for r, d, s in zip(*outcome, strict=True)]


def test_a_speed_counts_within_a_tenth() -> None:
    for speed, close in ((1.09, True), (1.11, False), (0.91, True), (0.89, False)):
        error = round(-abs(speed - 1.0) - 0.05, 9)
        found = Swim().outcome(np.array([[1.0, 9.0]]), seen((0, 0), speed=speed, effort=0.5), seen((0, 0)))
        assert judged(found) == [(error, False, close)]


def test_a_heading_counts_within_ten_degrees_around_the_circle() -> None:
    for heading, reward, close in ((350.5, -9.5 / 180, True), (10.5, -10.5 / 180, False), (180.0, -1.0, False)):
        found = Turn().outcome(np.array([[0.0, 1.0]]), seen((0, 0), heading=np.radians(heading)), seen((0, 0)))
        assert judged(found) == [(round(reward, 9), False, close)]
    np.testing.assert_allclose(wrapped(np.array([-np.pi, 0, 3 * np.pi / 2])), [-np.pi, 0, -np.pi / 2])


def test_a_point_is_reached_within_half_a_length() -> None:
    goal, before = np.array([[3.0, 0.0]]), seen((2.0, 0.0))
    for x, reached in ((2.51, True), (2.49, False)):
        reward = round(x - 2.0 - 0.1 + 5.0 * reached, 9)
        assert judged(Goto().outcome(goal, seen((x, 0), effort=1.0), before)) == [(reward, reached, reached)]


def test_a_place_is_held_within_a_length() -> None:
    goal = np.array([[1.0, 0.0]] * 2)
    at = seen((1.0, 0.9), (1.0, 2.0), effort=1.0)
    assert judged(Station().outcome(goal, at, at)) == [(round(1 / 1.81 - 0.1, 9), False, True), (0.1, False, False)]
    # heads north; the place is 0.9 and 2 lengths to the south, behind; a current to the east is to the right
    turned = Station().observe(goal, at._replace(heading=np.full(2, np.pi / 2)), np.array([[0.3, 0.0]] * 2))
    np.testing.assert_allclose(turned, [(-1, 0, 0.225, 0, -0.3), (-1, 0, 0.5, 0, -0.3)], atol=1e-12)


def test_an_action_is_a_gait() -> None:
    span = Span(2.0, np.array([0.2, 0.4, 0.8]))
    low, middle, high = (np.full((1, 9), value) for value in (-1.0, 0.0, 1.0))
    for action, frequency, bend, lag, bias in (
        (low, 0.0, 0.0, 0.0, -0.5),
        (middle, 1.0, 0.5, 0.5, 0.0),
        (high, 2.0, 1.0, 1.0, 0.5),
        (2 * high, 2.0, 1.0, 1.0, 0.5),  # an action ends at 1
        (2 * low, 0.0, 0.0, 0.0, -0.5),
    ):
        found = span.gait(action)
        expected: tuple[Any, ...] = ([frequency], [bend * span.bend], [lag * LAG * np.arange(3)], [bias * span.bend])
        for one, value in zip(found, expected, strict=True):
            np.testing.assert_allclose(one, value)
    each = span.gait(np.array([[-1, -0.5, 0, 0.5, 0, 1, 0, 0, 1]]))
    np.testing.assert_allclose(each[1], [[0.05, 0.2, 0.6]])
    np.testing.assert_allclose(each[2], [[0, LAG / 2, 1.5 * LAG]])
    np.testing.assert_allclose(each[3], [[0, 0, 0.4]])


def test_a_robot_of_two_joints_has_six_knobs() -> None:
    robot = ht.load("hypertuna")
    assert knobs(robot) == (
        *("frequency", "amplitude of I", "amplitude of II", "lag of II", "bias of I", "bias of II"),
    )
    assert sensed_size(robot) == 2 + 4 + 6
    span = span_of(robot)
    np.testing.assert_array_equal(span.bend, [group.bend_max for group in robot.joints])


@pytest.mark.parametrize(("step", "ticks"), [(0.1, 10), (0.01, 1), (0.05, 5), (0.005, 0), (0.015, 0), (0.1 + 1e-8, 0)])
def test_a_step_is_whole_ticks_of_ten_milliseconds(step: float, ticks: int) -> None:
    robot = ht.load("hypertuna")
    if ticks:
        assert ticks_of(robot, step) == ticks
    else:
        with pytest.raises(InputError, match=r"step must be whole control ticks of 0.01 s"):
            ticks_of(robot, step)
