"""Randomized fits to bench runs, which show how widely products of powers hold along the set of good fits."""

from collections.abc import Callable, Mapping

import numpy as np

from hypertuna.arrays import Array
from hypertuna.characterization.problem import BenchProblem

COUNT = 32
PARTS = (0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)  # of the perturbation, step by step; then corrections
CORRECTIONS = 6
MAX_STEP = 0.5  # of a correction
OUTLIER = 3.0  # residual, in standard deviations, above which a row does not guide the fits
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

    Randomized maximum likelihood. z: the fit (n,); factor: on the noise [1]; jacobian: of the residuals at the fit,
    over the noise times the factor; tick: called at every fit. Only fits as good as the noise allows are returned.
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
        mean = rng.standard_normal(len(low))  # of the prior, normal about the description, truncated at the bounds
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
        for _ in range(CORRECTIONS if residual @ residual > allowed else 0):  # with a new Jacobian
            jacobian_here = problem.jacobian(x, levels, rough=True)[:rows][inliers] / factor
            step = _step(jacobian_here, residual + noise, x - mean, low - x, high - x)
            step *= min(1.0, MAX_STEP / float(np.abs(step).max()))
            x = np.clip(x + step, low, high)
            residual = residual_at(x)
        if residual @ residual < allowed:
            fits.append(x)
    return np.array(fits).reshape(-1, len(z))


def _step(jacobian: Array, residual: Array, prior_offset: Array, low: Array, high: Array) -> Array:
    """Return the least-squares step (n,) of residuals and prior; unknowns that meet a bound stay on it."""
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
