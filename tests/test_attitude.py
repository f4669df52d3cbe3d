"""Attitudes: signs that can be checked by hand, and the way there and back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hypertuna.attitude import angles, attitude, multiplied, rotated, turned_about

AXES = np.eye(3)


@pytest.mark.parametrize(("heading", "ahead"), [(0, [0, 1, 0]), (90, [1, 0, 0]), (180, [0, -1, 0]), (270, [-1, 0, 0])])
def test_heading_is_a_compass_s(heading: float, ahead: list[float]) -> None:
    level = attitude(0.0, 0.0, math.radians(heading))
    np.testing.assert_allclose(rotated(level, -AXES[0]), ahead, atol=1e-15)  # the head faces minus x
    np.testing.assert_allclose(rotated(level, AXES[2]), AXES[2], atol=1e-15)
    starboard = [ahead[1], -ahead[0], 0]  # a quarter turn clockwise from above
    np.testing.assert_allclose(rotated(level, AXES[1]), starboard, atol=1e-15)


def test_pitch_is_nose_up_and_roll_is_starboard_down() -> None:
    up = attitude(0.0, 0.3, 0.0)
    np.testing.assert_allclose(rotated(up, -AXES[0]), [0, math.cos(0.3), math.sin(0.3)], atol=1e-15)
    over = attitude(0.3, 0.0, 0.0)
    np.testing.assert_allclose(rotated(over, AXES[1]), [math.cos(0.3), 0, -math.sin(0.3)], atol=1e-15)


@given(roll=st.floats(-3.1, 3.1), pitch=st.floats(-1.5, 1.5), heading=st.floats(0, 6.28))
def test_there_and_back(roll: float, pitch: float, heading: float) -> None:
    q = attitude(roll, pitch, heading)
    assert np.linalg.norm(q) == pytest.approx(1, abs=1e-14)
    told = angles(q)
    assert told[:2] == pytest.approx([roll, pitch], abs=1e-9)
    assert math.cos(told[2] - heading) == pytest.approx(1, abs=1e-12)


@given(a=st.floats(-3, 3), b=st.floats(-3, 3), axis=st.integers(0, 2), other=st.integers(0, 2))
def test_a_product_turns_twice(a: float, b: float, axis: int, other: int) -> None:
    first, second = turned_about(axis, a), turned_about(other, b)
    v = np.array([0.3, -0.5, 0.8])
    np.testing.assert_allclose(rotated(multiplied(first, second), v), rotated(first, rotated(second, v)), atol=1e-14)


def test_many_at_once() -> None:
    many = attitude(np.zeros(5), np.linspace(-1, 1, 5), np.zeros(5))
    np.testing.assert_allclose(angles(many)[:, 1], np.linspace(-1, 1, 5))
    assert rotated(many, AXES[0]).shape == (5, 3)
