"""Draws of actuators that meet bench runs: how far products of powers hold where the valley of good fits bends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hypertuna.characterization.search import Problem

__all__ = ["draws"]

Array = NDArray[np.float64]

COUNT = 32
WAY = (0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)  # parts of the way from the fit to a draw; then corrections
CORRECTIONS = 6
LONGEST = 0.5  # step of a correction
OUTLIER = 3.0  # residual, in standard deviations, from which on a row does not guide the draws
UNLIKELY = 4.0  # how many standard deviations of its own sum a draw's misfit may be larger than expected


def draws(
    problem: Problem,
    z: Array,
    level: Array,
    factor: float,
    slope: Array,
    *,
    seed: int = 0,
    tick: Callable[[], None] | None = None,
) -> Array:
    """Draw actuators that meet a bench as well as its noise asks, and are as likely as what was known before.

    A draw minimizes the residuals with noise of its own added to what was measured and drawn values in place of the
    described ones (randomized maximum likelihood: exact where the model is linear). The way there is gone in parts, so
    that it follows the floor of the valley; Broyden's method keeps the slopes up to date.

    Parameters
    ----------
    problem : Problem
    z : ndarray, shape (n,)
        The fit [1].
    level : ndarray, shape (2,)
        Noise that is not stated [rad and m^3].
    factor : float
        What the noise is multiplied by [1].
    slope : ndarray, shape (rows + n, n)
        Of the residuals over the noise times the factor, at the fit [1].
    seed : int
    tick : callable, optional
        Called at every draw.

    Returns
    -------
    ndarray, shape (draws, n)
        Points that meet the bench; 32 at most, fewer where the way was lost [1].
    """
    rng, rows = np.random.default_rng(seed), len(problem.measured)
    low, high = problem.ends()
    start = problem.residual(z, level)[:rows] / factor
    guiding = np.abs(start) < OUTLIER
    most = len(z) + UNLIKELY * np.sqrt(2 * len(z))
    found = []
    for _ in range(COUNT):
        if tick is not None:
            tick()
        aim, noise = _prior(rng, low, high), rng.standard_normal(rows)[guiding]
        x, residual, jacobian = z, start[guiding], slope[:rows][guiding].copy()
        for part in WAY:
            step = _step(jacobian, residual + part * noise, x - part * aim, low - x, high - x)
            there = problem.residual(np.clip(x + step, low, high), level)[:rows][guiding] / factor
            if (size := step @ step) > 0:
                jacobian += np.outer(there - residual - jacobian @ step, step / size)
            x, residual = np.clip(x + step, low, high), there
        allowed = start[guiding] @ start[guiding] + most
        for _ in range(CORRECTIONS if residual @ residual > allowed else 0):  # the way was lost: slopes anew
            jacobian = problem.slope(x, level, rough=True)[:rows][guiding] / factor
            step = _step(jacobian, residual + noise, x - aim, low - x, high - x)
            step *= min(1.0, LONGEST / float(np.abs(step).max()))
            x = np.clip(x + step, low, high)
            residual = problem.residual(x, level)[:rows][guiding] / factor
        if residual @ residual < allowed:
            found.append(x)
    return np.array(found).reshape(-1, len(z))


def _prior(rng: np.random.Generator, low: Array, high: Array) -> Array:
    """Draw a point from what is held possible: normal about the description, within the bounds."""
    point = rng.standard_normal(len(low))
    while (outside := (point < low) | (point > high)).any():
        point[outside] = rng.standard_normal(int(outside.sum()))
    return point


def _step(jacobian: Array, residual: Array, off: Array, low: Array, high: Array) -> Array:
    """Step to the least squares of residuals and what was known; what meets a bound stays there."""
    matrix = np.concatenate([jacobian, np.eye(len(off))])
    right = -np.concatenate([residual, off])
    step, free = np.zeros(len(off)), np.ones(len(off), dtype=bool)
    for _ in range(len(off)):
        step[free] = np.linalg.lstsq(matrix[:, free], right - matrix[:, ~free] @ step[~free], rcond=None)[0]
        beyond = free & ((step < low) | (step > high))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, low, high)[beyond]
        free &= ~beyond
    return step
