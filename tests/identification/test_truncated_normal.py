"""A normal distribution within bounds: its moments, and that correlations stay."""

from __future__ import annotations

import numpy as np
import pytest

from hypertuna.identification.truncated_normal import truncated_normal

COUNT = 400


def samples(*problem: list, seed: int = 1, count: int = COUNT) -> np.ndarray:
    """Draw; the problem is mean, covariance, lower and upper."""
    arrays = (np.array(values, dtype=float) for values in problem)
    return truncated_normal(*arrays, count=count, rng=np.random.default_rng(seed))


def test_half_of_a_normal_distribution() -> None:
    x = samples([0.0], [[1.0]], [0.0], [100.0])
    assert x.min() >= 0
    # Mean sqrt(2/pi) and variance 1 - 2/pi, each within four standard errors.
    assert x.mean() == pytest.approx(np.sqrt(2 / np.pi), abs=4 * np.sqrt((1 - 2 / np.pi) / COUNT))
    assert x.var() == pytest.approx(1 - 2 / np.pi, rel=4 * np.sqrt(3 / COUNT))


def test_wide_bounds_leave_the_normal_distribution_as_it_is() -> None:
    covariance = np.array([[4.0, 1.9], [1.9, 1.0]])
    x = samples([1.0, -2.0], covariance.tolist(), [-50, -50], [50, 50])
    np.testing.assert_allclose(x.mean(axis=0), [1, -2], atol=4 * 2 / np.sqrt(COUNT))
    np.testing.assert_allclose(np.cov(x.T), covariance, rtol=4 * np.sqrt(2 / COUNT))


def test_moments_are_those_of_the_draws_that_fall_inside() -> None:
    mean, covariance, lower, upper = [0.0, 0.0], [[1, 0.95], [0.95, 1]], [-0.5, -0.2], [1.0, 3.0]
    free = np.random.default_rng(2).multivariate_normal(mean, covariance, size=200_000)
    inside = free[((free >= lower) & (free <= upper)).all(axis=1)]
    x = samples(mean, covariance, lower, upper)
    assert ((x >= lower) & (x <= upper)).all()
    error = 4 * inside.std(axis=0) / np.sqrt(COUNT)
    assert (np.abs(x.mean(axis=0) - inside.mean(axis=0)) < error).all()
    np.testing.assert_allclose(np.cov(x.T), np.cov(inside.T), rtol=0.25)


def test_what_is_determined_stays_determined() -> None:
    # The sum of two coefficients is known to 1e-3, their difference not at all; both lie within 0 and 1.
    known, unknown = np.array([1.0, 1.0]) / np.sqrt(2), np.array([1.0, -1.0]) / np.sqrt(2)
    covariance = 1e-6 * np.outer(known, known) + 25 * np.outer(unknown, unknown)
    x = samples([0.5, 0.5], covariance.tolist(), [0, 0], [1, 1], count=200)
    assert (x.sum(axis=1) / np.sqrt(2)).std() == pytest.approx(1e-3, rel=0.2)
    assert np.ptp(x[:, 0]) > 0.9
    assert np.mean(x[:, 0]) == pytest.approx(0.5, abs=0.09)


def test_a_direction_without_variance_does_not_move() -> None:
    x = samples([0.5, 0.2], [[0.04, 0.0], [0.0, 0.0]], [0, 0], [1, 1])
    np.testing.assert_allclose(x[:, 1], 0.2, rtol=1e-12)
    assert x[:, 0].std() > 0.1
    np.testing.assert_allclose(samples([0.5], [[0.0]], [0], [1]), 0.5)


def test_a_mean_on_its_bound_is_no_trap() -> None:
    x = samples([0.0, 1.0], [[0.01, 0.0], [0.0, 0.01]], [0, 0], [1, 1])
    np.testing.assert_allclose(x.mean(axis=0), [0.0798, 1 - 0.0798], atol=4 * 0.06 / np.sqrt(COUNT))


def test_same_seed_same_draws() -> None:
    problem = ([0.2, 0.9], [[0.3, 0.1], [0.1, 0.2]], [0, 0], [1, 1])
    first, again, other = (samples(*problem, seed=seed, count=5) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
