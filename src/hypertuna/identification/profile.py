"""Profile likelihood: find how far fits of nearly equal quality extend along poorly constrained directions."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array

MIN_INTERVAL = 0.2  # length of a direction's linear 95 % interval, in units, above which its profile is computed
STEPS_PER_SD = 4  # steps from the optimum to one linear standard deviation; beyond it each is twice the last
MAX_STEPS = 9  # along a direction to one side
CORRECTIONS = 2  # per step, which move the point back to the profile
CONSTRAINT_WEIGHT = 100.0  # weight of holding the position along the direction, relative to other residuals


@dataclass(frozen=True)
class ProfileProblem:
    """A least-squares problem near its optimum; points u (n,) are differences from the optimum, in units."""

    residual: Callable[[Array], Array]  # weighted residuals at a point
    jacobian: Array  # (elements, n), Jacobian of these residuals at the optimum
    lower: Array  # (n,), lower bounds of u
    upper: Array
    directions: Array  # (n, n), unit vectors, from the best to the least constrained
    sd: Array  # (n,), standard deviations along the directions in the linear problem
    quantile: float  # half length of a 95 % interval, in standard deviations


def profile_sd(problem: ProfileProblem) -> Array:
    """Compute the standard deviation (n,) along every direction, including the curvature of the profile.

    The profile of each direction whose linear 95 % interval is longer than a fifth is followed to both sides, until the
    residuals have changed by one standard deviation or a bound is met. The distance covered is the standard deviation
    if it exceeds the linear one; shifts of better constrained directions on the way widen those.
    """
    start = problem.residual(np.zeros(len(problem.sd)))
    variance, shifts = problem.sd**2, np.zeros(len(problem.sd))
    for k in np.flatnonzero(2 * problem.quantile * problem.sd > MIN_INTERVAL):
        ends = np.array([problem.directions @ _follow(problem, int(k), side, start) for side in (-1, 1)])
        variance[k] = max(variance[k], float(np.mean(ends[:, k] ** 2)))
        shifts[:k] = np.maximum(shifts[:k], np.mean(ends[:, :k] ** 2, axis=0))
    return np.sqrt(variance + shifts)


def _follow(problem: ProfileProblem, k: int, side: int, start: Array) -> Array:
    """Return the point (n,) of the profile along direction k at one standard deviation, by Broyden's method."""
    from scipy.optimize import lsq_linear  # imported here: slow to import

    direction = problem.directions[k]
    extent = problem.upper - problem.lower
    step = side * min(float(problem.sd[k]), 1 / float(np.max(np.abs(direction) / extent))) / STEPS_PER_SD
    jacobian, x, residual, distance = problem.jacobian.copy(), np.zeros(len(direction)), start, 0.0
    tangent = direction

    def move(to: Array) -> tuple[Array, Array]:
        point = np.clip(to, problem.lower, problem.upper)
        new_residual = problem.residual(point)
        if (change := point - x) @ change > 0:
            jacobian[:] += np.outer(new_residual - residual - jacobian @ change, change / (change @ change))
        return point, new_residual

    def correction() -> Array:
        # step back to the profile, within bounds: least squares that holds the position along the direction
        weight = CONSTRAINT_WEIGHT / abs(step)
        rows = np.concatenate([jacobian, [weight * direction]])
        right_side = np.append(start - residual, weight * (target - direction @ x))
        bounds = (np.minimum(problem.lower - x, 0.0), np.maximum(problem.upper - x, 0.0))
        q, r = np.linalg.qr(rows)  # reduces the rows to the number of unknowns, with the same minimum
        return np.asarray(lsq_linear(r, q.T @ right_side, bounds=bounds).x)

    for n in range(MAX_STEPS):
        before, last_distance, target = x, distance, float(direction @ x) + step
        x, residual = move(x + step * tangent)
        for _ in range(CORRECTIONS):
            x, residual = move(x + correction())
        distance = float(np.linalg.norm(residual - start))
        if not distance < 1:  # interpolate to one standard deviation
            share = (1 - last_distance) / (distance - last_distance) if np.isfinite(distance) else 0.0
            return np.asarray(before + share * (x - before))
        change = x - before
        if abs(direction @ change) < abs(step) / 10:
            break  # the bounds are met
        tangent = change / (direction @ change)
        step *= 2 if n >= STEPS_PER_SD - 1 else 1
    return x
