"""Profile likelihood of problems whose curvature is known."""

from __future__ import annotations

import numpy as np
import pytest

from hypertuna.identification.profile import ProfileProblem, profile_sd

WIDE, NARROW = 0.5, 0.01  # standard deviations along the profile and across it


def banana(bend: float, *, upper: float = 10.0) -> ProfileProblem:
    """A problem whose profile along x is y = bend x^2."""

    def at(point: np.ndarray) -> np.ndarray:
        y, x = point
        return np.array([(y - bend * x**2) / NARROW, x / WIDE])

    ends = (np.array([-10.0, -10.0]), np.array([10.0, upper]))
    return ProfileProblem(at, np.diag([1 / NARROW, 1 / WIDE]), *ends, np.eye(2), np.array([NARROW, WIDE]), 2.0)


@pytest.mark.parametrize("bend", [0.0, 0.01, 1.0, -3.0])
def test_a_curved_profile_widens_the_narrow_direction(bend: float) -> None:
    """One standard deviation along the profile, y is off by bend WIDE^2, which the linear problem lacks."""
    expected = np.hypot(NARROW, abs(bend) * WIDE**2)
    assert profile_sd(banana(bend)) == pytest.approx([expected, WIDE], rel=0.02)


def test_a_bound_ends_the_profile() -> None:
    """From the bound only one side is open: half of the mean."""
    expected = np.hypot(NARROW, np.sqrt(1 / 2) * WIDE**2)
    assert profile_sd(banana(1.0, upper=0.0))[0] == pytest.approx(expected, rel=0.02)


def test_a_straight_profile_that_gets_wider_is_followed_to_its_end() -> None:
    """Residual x / (1 + x) for x > 0 reaches its standard deviation of 1/2 at x = 1, twice as far as linear."""

    def at(point: np.ndarray) -> np.ndarray:
        x = float(point[0])
        return np.array([2 * x / (1 + max(x, 0.0))])

    ends = (np.array([-10.0]), np.array([10.0]))
    found = profile_sd(ProfileProblem(at, np.array([[2.0]]), *ends, np.eye(1), np.array([0.5]), 2.0))
    assert found[0] == pytest.approx(np.sqrt((0.5**2 + 1.0**2) / 2), rel=0.03)
