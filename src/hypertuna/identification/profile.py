"""The valley of nearly equally good fits: how it bends along the directions that the runs leave open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Valley", "lengths"]

Array = NDArray[np.float64]

LOOSE = 0.2  # length of the 95 % interval along a direction from which on bending is looked for
STEPS = 4  # along a direction, to its standard deviation; longer ones from there on
MOST_STEPS = 9
CORRECTIONS = 2  # back to the floor, in each step
HELD = 100.0  # how stiffly, beside a change of the predictions by one standard deviation in each step


@dataclass(frozen=True)
class Valley:
    """Where a fit ended: everything in units of the coefficients, seen from there.

    Attributes
    ----------
    at : callable
        Weighted residuals at a point (n,).
    slope : ndarray, shape (elements, n)
        Their derivatives at the result.
    lower, upper : ndarray, shape (n,)
        Bounds.
    directions : ndarray, shape (n, n)
        Unit vectors, from the best to the least known.
    sd : ndarray, shape (n,)
        Standard deviations along them of the linear problem.
    quantile : float
        Of the 95 % interval, in standard deviations.
    """

    at: Callable[[Array], Array]
    slope: Array
    lower: Array
    upper: Array
    directions: Array
    sd: Array
    quantile: float


def lengths(valley: Valley) -> Array:
    """Return the standard deviation of every direction, with what the bending of the valley adds.

    The floor of the valley is followed along each direction whose 95 % interval is longer than a fifth, to either side,
    until the predictions have changed by one standard deviation or the bounds are met. Where that is further than in
    the linear problem, the direction itself has that standard deviation. By how far a better known direction is shifted
    there widens its own. All these ways lead into the same valley, so the largest counts, not the sum. (A normal error
    would make the mean square of a shift that grows with the square of the way three times as large; the bounds and the
    widening cut its tails. See validation/identify for how often the truth is held.)

    Parameters
    ----------
    valley : Valley

    Returns
    -------
    ndarray, shape (n,)
        In the units of the directions [1].
    """
    start = valley.at(np.zeros(len(valley.sd)))
    own, shifts = valley.sd**2, np.zeros(len(valley.sd))
    for k in np.flatnonzero(2 * valley.quantile * valley.sd > LOOSE):
        ends = np.array([valley.directions @ _floor(valley, int(k), side, start) for side in (-1, 1)])
        own[k] = max(own[k], float(np.mean(ends[:, k] ** 2)))
        shifts[:k] = np.maximum(shifts[:k], np.mean(ends[:, :k] ** 2, axis=0))
    return np.sqrt(own + shifts)


def _floor(valley: Valley, k: int, side: int, start: Array) -> Array:
    """Follow the floor of the valley along direction k; Broyden's method keeps the slopes up to date."""
    direction = valley.directions[k]
    extent = valley.upper - valley.lower
    step = side * min(float(valley.sd[k]), 1 / float(np.max(np.abs(direction) / extent))) / STEPS
    slope, x, residual, grown, along = valley.slope.copy(), np.zeros(len(direction)), start, 0.0, direction

    def go(to: Array) -> tuple[Array, Array]:
        # the secant of this way becomes part of the slopes
        there = np.clip(to, valley.lower, valley.upper)
        new = valley.at(there)
        if (way := there - x) @ way > 0:
            slope[:] += np.outer(new - residual - slope @ way, way / (way @ way))
        return there, new

    for n in range(MOST_STEPS):
        before, last, target = x, grown, float(direction @ x) + step
        x, residual = go(x + step * along)
        for _ in range(CORRECTIONS):
            x, residual = go(x + _back(valley, slope, residual - start, x, direction, target, abs(step)))
        grown = float(np.linalg.norm(residual - start))
        if not grown < 1:  # one standard deviation: where exactly, by interpolation
            part = (1 - last) / (grown - last) if np.isfinite(grown) else 0.0
            return np.asarray(before + part * (x - before))
        way = x - before
        if abs(direction @ way) < abs(step) / 10:
            break  # the bounds are met
        along = way / (direction @ way)
        step *= 2 if n >= STEPS - 1 else 1
    return x


def _back(valley: Valley, slope: Array, off: Array, x: Array, direction: Array, target: float, step: float) -> Array:
    """Step to the floor within the bounds: least squares with the way along the direction held."""
    from scipy.optimize import lsq_linear  # here, because it takes longer to import than a swim takes

    hold = HELD / step
    rows = np.concatenate([slope, [hold * direction]])
    right = np.append(-off, hold * (target - direction @ x))
    bounds = (np.minimum(valley.lower - x, 0.0), np.maximum(valley.upper - x, 0.0))
    found: Array = lsq_linear(rows, right, bounds=bounds).x
    return found
