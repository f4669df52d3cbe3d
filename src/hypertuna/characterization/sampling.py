"""Randomized fits to bench runs: samples of the unknowns that fit about as well as the best fit."""

from collections.abc import Callable, Mapping

import numpy as np

from hypertuna.arrays import Array
from hypertuna.characterization.problem import BenchProblem

COUNT = 32  # fits tried
PARTS = (0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)  # part of the random noise and prior mean applied at each step
CORRECTIONS = 6  # further steps, with new Jacobians, for a fit that is not yet good
MAX_STEP = 0.5  # largest step of a correction, in prior standard deviations
OUTLIER = 3.0  # rows with a larger residual, in standard deviations, are left out
MAX_SIGMA = 4.0  # standard deviations by which the sum of squares may exceed its expectation


def randomized_fits(
    problem: BenchProblem,
    z: Array,
    levels: Mapping[str, float],
    factor: float,
    jacobian: Array,
    *,
    seed: int = 0,
    tick: Callable[[], None] | None = None,
) -> Array:
    """Return fits (fits, n) to residuals with random noise added and to random prior means.

    This is randomized maximum likelihood. z: the best fit (n,). factor: multiplies the noise [1]. jacobian: of the
    residuals at z, divided by the factor. tick: called at every fit. Fits worse than the noise allows are left out.
    """
    rng, rows = np.random.default_rng(seed), len(problem.measured)
    low, high = problem.bounds()
    start = problem.residual(z, levels)[:rows] / factor
    inliers = np.abs(start) < OUTLIER
    allowed = start[inliers] @ start[inliers] + len(z) + MAX_SIGMA * np.sqrt(2 * len(z))
    fits = []

    def residual_at(x: Array) -> Array:
        return problem.residual(x, levels)[:rows][inliers] / factor

    for _ in range(COUNT):
        if tick is not None:
            tick()
        mean = rng.standard_normal(len(low))  # prior mean: normal about the described values, truncated at the bounds
        while (outside := (mean < low) | (mean > high)).any():
            mean[outside] = rng.standard_normal(int(outside.sum()))
        noise = rng.standard_normal(rows)[inliers]
        x, residual, jacobian_here = z, start[inliers], jacobian[:rows][inliers].copy()
        for fraction in PARTS:
            step = _step(jacobian_here, residual + fraction * noise, x - fraction * mean, low - x, high - x)
            x = np.clip(x + step, low, high)
            new = residual_at(x)
            if (size := step @ step) > 0:
                jacobian_here += np.outer(new - residual - jacobian_here @ step, step / size)
            residual = new
        for _ in range(CORRECTIONS if residual @ residual > allowed else 0):  # each with a new Jacobian
            jacobian_here = problem.jacobian(x, levels, rough=True)[:rows][inliers] / factor
            step = _step(jacobian_here, residual + noise, x - mean, low - x, high - x)
            step *= min(1.0, MAX_STEP / float(np.abs(step).max()))
            x = np.clip(x + step, low, high)
            residual = residual_at(x)
        if residual @ residual < allowed:
            fits.append(x)
    return np.array(fits).reshape(-1, len(z))


def _step(jacobian: Array, residual: Array, prior_offset: Array, low: Array, high: Array) -> Array:
    """Return the least-squares step (n,) of residuals and prior; an unknown that reaches a bound stays on the bound."""
    matrix = np.concatenate([jacobian, np.eye(len(prior_offset))])
    target = -np.concatenate([residual, prior_offset])
    step, free = np.zeros(len(prior_offset)), np.ones(len(prior_offset), dtype=bool)
    for _ in range(len(prior_offset)):
        step[free] = np.linalg.lstsq(matrix[:, free], target - matrix[:, ~free] @ step[~free], rcond=None)[0]
        beyond = free & ((step < low) | (step > high))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, low, high)[beyond]
        free &= ~beyond
    return step
