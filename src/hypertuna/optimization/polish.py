"""Polish a Pareto front by exact derivatives, and measure how stationary its points are.

Each point descends in one objective while the others are held where they are (epsilon constraints; Haimes, Lasdon and
Wismer, 1971). All descents go in lockstep: every round evaluates, in one batch, the next point that each of them asks
for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hypertuna.optimization.design_space import Space
from hypertuna.optimization.gradient import MARGIN, STEEP, Stop, Walk
from hypertuna.optimization.objective import Evaluation

__all__ = ["Descent", "descend", "stationarity"]

Array = NDArray[np.float64]

MOST_ROUNDS = 40  # evaluations of one descent
ON_BOUND = 1e-9  # of the range of a variable


class _Posed(Protocol):
    """What can be polished: a `Problem`, or what stands for one."""

    @property
    def space(self) -> Space:
        """Where points are sought."""

    def evaluate(self, x: Array, *, slopes: bool = False) -> Evaluation:
        """Evaluate points, shape (points, dim) [Hz or rad]."""


@dataclass(frozen=True)
class Descent:
    """One way down from a point of the front.

    Attributes
    ----------
    start : ndarray, shape (dim,)
        Where it starts [unit of each variable].
    goal : int
        The objective that falls.
    limits : ndarray, shape (goals,)
        What the objectives must not exceed, infinite where one is free [unit of each objective].
    """

    start: Array
    goal: int
    limits: Array


@dataclass(frozen=True)
class _Known:
    """What is known of a point; variables scaled by their bounds, objectives by the range of the front."""

    u: Array  # (dim,)
    value: Array  # (goals,)
    violation: Array  # (constraints,), feasible when <= 0
    value_slopes: Array  # (goals, dim)
    violation_slopes: Array  # (constraints, dim)


def descend(problem: _Posed, descents: Sequence[Descent], scale: Array) -> Array:
    """Follow every descent to its end.

    Parameters
    ----------
    problem : Problem
        With slopes of all its objectives and constraints; or what stands for one.
    descents : sequence of Descent
    scale : ndarray, shape (goals,)
        Range of the front in each objective [unit of each objective].

    Returns
    -------
    ndarray, shape (descents, dim)
        The lowest point that each came by within its limits and the constraints; its start where there is none
        [unit of each variable].
    """
    lower, width = problem.space.lower, problem.space.upper - problem.space.lower
    walks = [Walk(np.clip((d.start - lower) / width, 0.0, 1.0), MOST_ROUNDS) for d in descents]
    running = list(range(len(descents)))
    for _ in range(MOST_ROUNDS):
        asked = {k: u for k in running if (u := walks[k].ask()) is not None}
        running = list(asked)
        if not running:
            break
        points = np.stack(list(asked.values()))
        told = problem.evaluate(lower + width * points, slopes=True)
        for k, point in zip(running, _scaled(told, points, width, scale), strict=True):
            walks[k].learn(_stop(descents[k], point, scale))
    bests = [walk.best() for walk in walks]
    return np.stack([d.start if at is None else lower + width * at.u for d, at in zip(descents, bests, strict=True)])


def stationarity(problem: _Posed, found: Evaluation, scale: Array) -> Array:
    """Measure how far points are from stationary, by the conditions of Karush, Kuhn and Tucker.

    A point is stationary when no direction lowers all objectives at once: a mean of their slopes is balanced by slopes
    of the active constraints and bounds.

    Parameters
    ----------
    problem : Problem
        Or what stands for one.
    found : Evaluation
        With slopes.
    scale : ndarray, shape (goals,)
        Range of the front in each objective [unit of each objective].

    Returns
    -------
    ndarray, shape (points,)
        What remains of the weighted mean of slopes, over the largest slope of the objectives; variables are scaled by
        their bounds [1]. It is 0 for a stationary point and at most 1.
    """
    lower, width = problem.space.lower, problem.space.upper - problem.space.lower
    points = _scaled(found, (found.x - lower) / width, width, scale)
    return np.array([_residual(point) for point in points])


def _residual(point: _Known) -> float:
    """Least norm of the mean slope plus multiples of the active slopes, all weights at least zero."""
    from scipy.optimize import nnls

    steepest = float(np.linalg.norm(point.value_slopes, axis=1).max())
    if not np.isfinite(steepest) or steepest == 0:
        return np.nan if steepest else 0.0
    active = point.violation_slopes[point.violation > -_slack(point.violation_slopes)]
    unit = np.eye(len(point.u))
    bounds = np.concatenate([-unit[point.u < ON_BOUND], unit[point.u > 1 - ON_BOUND]])
    goals = len(point.value)
    slopes = np.concatenate([point.value_slopes / steepest, active, bounds])
    # Weights of the objectives add up to one. The least residual is the same when they need not, but are drawn to it.
    matrix = np.vstack([slopes.T, [1.0] * goals + [0.0] * (len(slopes) - goals)])
    weights, _ = nnls(matrix, np.append(np.zeros(len(unit)), 1.0))
    total = weights[:goals].sum()
    return float(np.linalg.norm(slopes.T @ weights) / total) if total > 0 else 1.0


def _slack(slopes: Array) -> Array:
    """How near zero a constraint counts as active: what it changes within a hundred-thousandth of the bounds."""
    return np.asarray(1e-5 * np.linalg.norm(slopes, axis=1) + 1e-12)


def _stop(descent: Descent, point: _Known, scale: Array) -> Stop:
    """Tell what is known of a point as a descent takes it: the other objectives are limits."""
    held = np.flatnonzero(np.isfinite(descent.limits))
    value = point.value[descent.goal]
    return Stop(
        point.u,
        value,
        point.value_slopes[descent.goal],
        np.concatenate([descent.limits[held] / scale[held] - point.value[held], -point.violation]) - MARGIN,
        -np.concatenate([point.value_slopes[held], point.violation_slopes]),
        worth=value,
        kept=bool((point.value * scale <= descent.limits).all() and (point.violation <= 0).all()),
    )


def _scaled(found: Evaluation, u: Array, width: Array, scale: Array) -> list[_Known]:
    """Scale what was found; a point that cannot be used costs much, and has no slope."""
    assert found.value_slopes is not None
    assert found.violation_slopes is not None
    points = []
    for k in range(len(u)):
        usable = np.isfinite(found.value[k]).all() and np.isfinite(found.violation[k]).all()
        points.append(
            _Known(
                u[k],
                found.value[k] / scale if usable else np.full(len(scale), STEEP),
                found.violation[k] if usable else np.full(found.violation.shape[1], STEEP),
                found.value_slopes[k] * width / scale[:, np.newaxis] if usable else np.zeros((len(scale), len(width))),
                found.violation_slopes[k] * width if usable else np.zeros((found.violation.shape[1], len(width))),
            )
        )
    return points
