"""Draws from a normal distribution within bounds, its correlations kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["truncated_normal"]

Array = NDArray[np.float64]

ROUNDS = 12  # trajectories between two draws: one alone forgets the last draw where no bound is met
MOST_BOUNCES = 1000  # of one trajectory
INSIDE = 1e-6  # of its range: how far from its bounds the first point is kept
NONE = 1e-12  # relative variance of a direction that counts as none


def truncated_normal(
    mean: Array, covariance: Array, lower: Array, upper: Array, *, count: int, rng: np.random.Generator
) -> Array:
    """Draw from a normal distribution within bounds.

    Setting on its bounds what an unbounded draw leaves outside would break the correlations that data determine; this
    does not. A particle flies through the distribution in the potential of its logarithm, on ellipses known in closed
    form, and is mirrored where it meets a bound (exact Hamiltonian Monte Carlo; Pakman and Paninski, 2014).

    `mean` (dim,) [any], `covariance` (dim, dim) [any], `lower`, `upper` (dim,) [any]; returns (count, dim) [any].
    """
    width = upper - lower
    spread, axes = np.linalg.eigh(covariance / np.outer(width, width))
    kept = spread > NONE * max(spread.max(), 0.0)
    root = axes[:, kept] * np.sqrt(spread[kept])  # (x - mean) / width = root y with y standard normal
    center = np.clip((mean - lower) / width, INSIDE, 1 - INSIDE)
    if not kept.any():
        return np.tile(lower + width * center, (count, 1))
    # Every wall is normal . y + gap >= 0.
    normals, gaps = np.vstack([root, -root]), np.concatenate([center, 1 - center])
    y, draws = np.zeros(root.shape[1]), []
    for _ in range(count):
        for _ in range(ROUNDS):
            y = _flown(y, normals, gaps, rng)
        draws.append(y)
    return np.asarray(lower + width * np.clip(center + np.array(draws) @ root.T, 0.0, 1.0))


def _flown(y: Array, normals: Array, gaps: Array, rng: np.random.Generator) -> Array:
    """Fly a quarter of an ellipse, y cos t + v sin t, from a random velocity, and bounce off the walls."""
    v, left, last = rng.standard_normal(len(y)), np.pi / 2, -1
    for _ in range(MOST_BOUNCES):
        # On its way normal . y(t) = size cos(t - phase); it meets a wall where that becomes -gap, outwards.
        ahead, across = normals @ y, normals @ v
        size, phase = np.hypot(ahead, across), np.arctan2(across, ahead)
        meets = size > gaps
        time = np.full(len(gaps), np.inf)
        time[meets] = (phase[meets] + np.arccos(np.clip(-gaps[meets] / size[meets], -1, 1))) % (2 * np.pi)
        if last >= 0 and time[last] > 2 * np.pi - 1e-6:  # it just left this wall
            time[last] -= 2 * np.pi
        if last >= 0 and time[last] < 1e-9:
            time[last] = np.inf
        wall = int(np.argmin(time))
        flight = min(float(time[wall]), left)
        y, v = y * np.cos(flight) + v * np.sin(flight), v * np.cos(flight) - y * np.sin(flight)
        left -= flight
        if left <= 0:
            break
        normal = normals[wall]
        v, last = v - 2 * (normal @ v) / (normal @ normal) * normal, wall
    return y
