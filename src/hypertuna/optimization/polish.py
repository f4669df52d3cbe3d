"""Polish a Pareto front by exact derivatives, and measure how stationary its points are.

Each search improves one objective while the others are bounded (epsilon constraints; Haimes, Lasdon and Wismer, 1971).
All searches advance in lockstep: every round evaluates the next point of each search in one batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hypertuna.arrays import Array
from hypertuna.optimization.design_space import DesignSpace
from hypertuna.optimization.objective import Evaluation
from hypertuna.optimization.sqp import MARGIN, PENALTY, SQP, SqpPoint

MAX_ROUNDS = 40  # most evaluations in one search
ON_BOUND = 1e-9  # a variable this near its bound, as a part of its range, is on the bound


class _Differentiable(Protocol):
    """A problem that evaluates points with derivatives: a `Problem`, or one that also keeps a journal."""

    space: DesignSpace

    def evaluate(self, x: Array, *, derivatives: bool = False) -> Evaluation:
        """Return the evaluation of points, shape (points, dim) [Hz or rad]."""


@dataclass(frozen=True)
class Target:
    """A search from one point of the front: objective to minimize, and bounds on the others."""

    start: Array  # (dim,) [unit of each variable]
    objective: int  # index of the objective to minimize
    limits: Array  # (objectives,) upper bounds of the other objectives, infinite if free [unit of each objective]


@dataclass(frozen=True)
class _Scaled:
    """Evaluation of a point, with variables scaled by their bounds and objectives by the range of the front."""

    u: Array  # (dim,) point of the unit box
    value: Array  # (objectives,)
    violation: Array  # (constraints,), not violated if <= 0
    value_jacobian: Array  # (objectives, dim)
    violation_jacobian: Array  # (constraints, dim)


def run_targets(problem: _Differentiable, targets: Sequence[Target], scale: Array) -> Array:
    """Run all searches to their end; `scale` is the range of the front in each objective, shape (objectives,).

    Return the best feasible point of each search, or the start if there is none, shape (targets, dim).
    """
    lower, width = problem.space.lower, problem.space.upper - problem.space.lower
    searches = [SQP(np.clip((target.start - lower) / width, 0.0, 1.0), MAX_ROUNDS) for target in targets]
    for _ in range(MAX_ROUNDS):
        pairs = zip(searches, targets, strict=True)
        running = [(search, target, search.u) for search, target in pairs if search.u is not None]
        if not running:
            break
        evaluation = problem.evaluate(lower + width * np.stack([u for _, _, u in running]), derivatives=True)
        for k, (search, target, u) in enumerate(running):
            search.tell(_sqp_point(target, _scaled(evaluation, k, u, width, scale), scale))
    results = zip(targets, [search.best for search in searches], strict=True)
    return np.stack([target.start if best is None else lower + width * best.u for target, best in results])


def stationarity(problem: _Differentiable, evaluation: Evaluation, scale: Array) -> Array:
    """Return the residual of the Karush-Kuhn-Tucker conditions at points, shape (points,) [1].

    A point is stationary if no direction improves all objectives: a mean of their gradients is balanced by gradients
    of the active constraints and bounds. The residual is the norm of the remainder over the steepest gradient: 0 for a
    stationary point, 1 at most. Variables are scaled by their bounds, objectives by the range of the front `scale`.
    """
    lower, width = problem.space.lower, problem.space.upper - problem.space.lower
    points = ((x - lower) / width for x in evaluation.x)
    return np.array([_residual(_scaled(evaluation, k, u, width, scale)) for k, u in enumerate(points)])


def _residual(point: _Scaled) -> float:
    """Return the KKT residual [1]: the least norm of the Lagrangian's gradient, over that of the steepest objective."""
    from scipy.optimize import nnls

    steepest = float(np.linalg.norm(point.value_jacobian, axis=1).max())
    if not np.isfinite(steepest) or steepest == 0:
        return np.nan if steepest else 0.0
    # A constraint is active if a step of a hundred-thousandth of the bounds can reach it.
    reach = 1e-5 * np.linalg.norm(point.violation_jacobian, axis=1) + 1e-12
    active = point.violation_jacobian[point.violation > -reach]
    identity = np.eye(len(point.u))
    bounds = np.concatenate([-identity[point.u < ON_BOUND], identity[point.u > 1 - ON_BOUND]])
    objectives = len(point.value)
    gradients = np.concatenate([point.value_jacobian / steepest, active, bounds])
    # The weights of the objectives must add up to one, otherwise zero weights would be a solution.
    matrix = np.vstack([gradients.T, [1.0] * objectives + [0.0] * (len(gradients) - objectives)])
    weights, _ = nnls(matrix, np.append(np.zeros(len(identity)), 1.0))
    total = weights[:objectives].sum()
    return float(np.linalg.norm(gradients.T @ weights) / total) if total > 0 else 1.0


def _sqp_point(target: Target, scaled: _Scaled, scale: Array) -> SqpPoint:
    """Return a point for SQP, with the bounded objectives as constraints."""
    bounded = np.flatnonzero(np.isfinite(target.limits))
    value = scaled.value[target.objective]
    return SqpPoint(
        scaled.u,
        value,
        scaled.value_jacobian[target.objective],
        np.concatenate([target.limits[bounded] / scale[bounded] - scaled.value[bounded], -scaled.violation]) - MARGIN,
        -np.concatenate([scaled.value_jacobian[bounded], scaled.violation_jacobian]),
        merit=value,
        feasible=bool((scaled.value * scale <= target.limits).all() and (scaled.violation <= 0).all()),
    )


def _scaled(evaluation: Evaluation, k: int, u: Array, width: Array, scale: Array) -> _Scaled:
    """Return point k of an evaluation, scaled; an unusable point gets a large penalty and zero gradient."""
    assert evaluation.value_jacobian is not None
    assert evaluation.violation_jacobian is not None
    value, violation = evaluation.value[k] / scale, evaluation.violation[k]
    jacobians = evaluation.value_jacobian[k] * width / scale[:, np.newaxis], evaluation.violation_jacobian[k] * width
    if not np.isfinite([*evaluation.value[k], *violation]).all():
        value, violation = np.full_like(value, PENALTY), np.full_like(violation, PENALTY)
        jacobians = np.zeros_like(jacobians[0]), np.zeros_like(jacobians[1])
    return _Scaled(u, value, violation, *jacobians)
