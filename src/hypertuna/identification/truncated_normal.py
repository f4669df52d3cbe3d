"""Draw samples from a multivariate normal distribution truncated at bounds."""

import numpy as np

from hypertuna.arrays import Array

ROUNDS = 12  # trajectories between two samples; without bounds, one trajectory gives an independent sample
MAX_BOUNCES = 1000  # largest number of reflections of one trajectory
INSIDE = 1e-6  # least distance of the first point from its bounds, as a fraction of the range
ZERO = 1e-12  # relative variance below which a direction has none


def truncated_normal(
    mean: Array, covariance: Array, lower: Array, upper: Array, *, count: int, rng: np.random.Generator
) -> Array:
    """Return samples (count, dim) of a normal distribution with mean (dim,) and covariance (dim, dim), truncated.

    Exact Hamiltonian Monte Carlo (Pakman and Paninski, 2014): a particle moves on ellipses, which are known in closed
    form, and is reflected at the bounds. The covariance may be singular.
    """
    width = upper - lower
    spread, axes = np.linalg.eigh(covariance / np.outer(width, width))
    nonzero = spread > ZERO * max(spread.max(), 0.0)
    root = axes[:, nonzero] * np.sqrt(spread[nonzero])  # (x - mean) / width = root y with y standard normal
    center = np.clip((mean - lower) / width, INSIDE, 1 - INSIDE)
    if not nonzero.any():
        return np.tile(lower + width * center, (count, 1))
    # Every wall is normal . y + gap >= 0.
    normals, gaps = np.vstack([root, -root]), np.concatenate([center, 1 - center])
    y, samples = np.zeros(root.shape[1]), []
    for _ in range(count):
        for _ in range(ROUNDS):
            y = _moved(y, normals, gaps, rng)
        samples.append(y)
    return np.asarray(lower + width * np.clip(center + np.array(samples) @ root.T, 0.0, 1.0))


def _moved(y: Array, normals: Array, gaps: Array, rng: np.random.Generator) -> Array:
    """Move y along a quarter of an ellipse, y cos t + v sin t with a random velocity v, and reflect it at the walls."""
    v, remaining, last_wall = rng.standard_normal(len(y)), np.pi / 2, -1
    for _ in range(MAX_BOUNCES):
        # normal . y(t) = size cos(t - phase); a wall is hit when this falls to -gap
        position_term, velocity_term = normals @ y, normals @ v
        size, phase = np.hypot(position_term, velocity_term), np.arctan2(velocity_term, position_term)
        meets = size > gaps
        time = np.full(len(gaps), np.inf)
        time[meets] = (phase[meets] + np.arccos(np.clip(-gaps[meets] / size[meets], -1, 1))) % (2 * np.pi)
        if last_wall >= 0 and time[last_wall] > 2 * np.pi - 1e-6:  # the particle has just left this wall
            time[last_wall] -= 2 * np.pi
        if last_wall >= 0 and time[last_wall] < 1e-9:
            time[last_wall] = np.inf
        wall = int(np.argmin(time))
        flight = min(float(time[wall]), remaining)
        y, v = y * np.cos(flight) + v * np.sin(flight), v * np.cos(flight) - y * np.sin(flight)
        remaining -= flight
        if remaining <= 0:
            break
        normal = normals[wall]
        v, last_wall = v - 2 * (normal @ v) / (normal @ normal) * normal, wall
    return y
