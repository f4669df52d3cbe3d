"""What a search found: the best gait, how it keeps its limits, and what else there is to say of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna.description import Robot
from hypertuna.gait import Gait
from hypertuna.limits import Limit
from hypertuna.objective import Evaluation, Goal, Problem, goal
from hypertuna.optimizers import Optimizer
from hypertuna.swim import Swim, swim

__all__ = ["Margin", "Optimum", "concluded", "weight_threshold"]

Array = NDArray[np.float64]

NEAR = 5e-3  # a limit or bound so near, relative, is active
MET = 5e-3  # an expected speed so near, relative, is met


@dataclass(frozen=True)
class Margin:
    """How a gait keeps a limit.

    Attributes
    ----------
    limit : Limit
    value : float
        Of the gait [unit of the quantity].
    margin : float
        What is left to the limit, relative to it; negative where it is passed [1].
    """

    limit: Limit
    value: float
    margin: float

    @property
    def active(self) -> bool:
        """Whether the limit holds the gait back."""
        return self.margin < NEAR


@dataclass(frozen=True)
class Optimum:
    """The best gait that was found.

    Attributes
    ----------
    robot : Robot
    goal : Goal
    gait : Gait or None
        None if no gait keeps all limits.
    swim : Swim or None
        How it swims.
    value : float
        Of the goal, minimized.
    method : str
    seed : int
    evaluations : int
        Gaits that were swum, those of a checkpoint included.
    seconds : float
        Taken by this run.
    stop : str
        Why the search ended, in a sentence.
    history : ndarray, shape (batches,)
        Least value of the goal after each batch; infinite before a gait keeps all limits.
    swum : ndarray, shape (batches,)
        Gaits swum until then.
    margins : tuple of Margin
        Of the limits.
    bounds : mapping
        Which end of its bounds the gait lies on, "lower" or "upper", by the names of `hypertuna.space.gait_columns`.
    weight_threshold : float or None
        Up to this k of Eq. 42 the speed stays exactly as expected, judged by the slopes at this gait
        [m/s per J/(kg m)]; None where no speed is expected, or it is not met.
    remark : str
        What else there is to know about the result; empty if nothing.
    """

    robot: Robot
    goal: Goal
    gait: Gait | None
    swim: Swim | None
    value: float
    method: str
    seed: int
    evaluations: int
    seconds: float
    stop: str
    history: Array
    swum: NDArray[np.int_]
    margins: tuple[Margin, ...]
    bounds: Mapping[str, str]
    weight_threshold: float | None
    remark: str

    @property
    def speed(self) -> float:
        """Speed of the gait [m/s]; not a number without one."""
        return np.nan if self.swim is None else self.swim.speed

    @property
    def cost_of_transport(self) -> float:
        """Cost of transport of the gait [J/(kg m)]; not a number without one."""
        return np.nan if self.swim is None else self.swim.cost_of_transport


def concluded(problem: Problem, optimizer: Optimizer, *, method: str, seed: int, stop: str, seconds: float) -> Optimum:
    """Make the result of a search that has ended.

    Parameters
    ----------
    problem : Problem
    optimizer : Optimizer
    method : str
    seed : int
    stop : str
    seconds : float
        [s].

    Returns
    -------
    Optimum
    """
    best, space, target = optimizer.result, problem.space, problem.goals[0]
    assert best is not None  # every method asks for one batch at least
    margins = tuple(
        Margin(limit, float(best.found[limit.quantity][0]), -float(best.violation[0, k]))
        for k, limit in enumerate(problem.limits)
    )
    feasible = bool(best.feasible[0])
    ends = zip(space.names, best.x[0] - space.lower, space.upper - best.x[0], space.upper - space.lower, strict=True)
    bounds = {name: "lower" if low < high else "upper" for name, low, high, w in ends if min(low, high) < NEAR * w}
    missed = _missed(target, float(best.found["speed"][0])) if feasible else ""
    threshold = weight_threshold(problem, best) if feasible and target.expected is not None and not missed else None
    gait = space.gait(best.x[0]) if feasible else None
    return Optimum(
        robot=problem.robot,
        goal=target,
        gait=gait,
        swim=None if gait is None else swim(problem.robot, gait, steps=problem.steps),
        value=float(best.value[0, 0]) if feasible else np.nan,
        method=method,
        seed=seed,
        evaluations=optimizer.evaluations,
        seconds=seconds,
        stop=stop if feasible else f"{stop} {_infeasible(margins)}",
        history=np.array(optimizer.history),
        swum=np.cumsum(optimizer.batches),
        margins=margins[1:],
        bounds=bounds if feasible else {},
        weight_threshold=threshold,
        remark=missed,
    )


def weight_threshold(problem: Problem, best: Evaluation) -> float:
    """Return the k of Eq. 42 up to which |U - U_e| holds the speed exactly (exact penalty).

    Where the speed is as expected, k COT pulls along the cheapest gaits with k dCOT/dU and |U - U_e| holds with 1. That
    slope is the multiplier of the speed in the conditions of Karush, Kuhn and Tucker, here by least squares over what
    is not on its bounds.

    Parameters
    ----------
    problem : Problem
    best : Evaluation
        One row, at the optimum.

    Returns
    -------
    float
        [m/s per J/(kg m)]; infinite where a higher speed costs nothing.
    """
    space = problem.space
    width = space.upper - space.lower
    costs = Problem(problem.robot, space, (goal("cost_of_transport"),), problem.limits, problem.steps)
    at = costs.evaluate(best.x, slopes=True)
    assert at.value_slopes is not None
    assert at.speed_slopes is not None
    assert at.violation_slopes is not None
    inside = np.minimum(best.x[0] - space.lower, space.upper - best.x[0]) > NEAR * width
    held = at.violation_slopes[0, 1:][-at.violation[0, 1:] < NEAR]
    columns = np.vstack([at.speed_slopes[0], held])[:, inside] * width[inside]
    slope = at.value_slopes[0, 0, inside] * width[inside]
    multiplier = float(np.linalg.lstsq(columns.T, slope, rcond=None)[0][0]) if inside.any() else 0.0
    return 1 / multiplier if multiplier > 0 else np.inf


def _infeasible(margins: Sequence[Margin]) -> str:
    """Say which limits the nearest gait does not keep."""
    forward, *others = margins
    passed = [f"{m.limit.quantity} by {-100 * m.margin:.3g} %" for m in others if m.margin < 0]
    if forward.margin < 0 or not passed:
        return "No gait was found that settles and swims forward."
    return f"No gait was found that keeps all limits: the nearest one passes {' and '.join(passed)}."


def _missed(target: Goal, speed: float) -> str:
    """Say so if the expected speed is not met."""
    if target.expected is None or abs(speed / target.expected - 1) < MET:
        return ""
    return (
        f"The gait swims at {speed:.4g} m/s instead of the expected {target.expected:.4g} m/s: that speed is out of "
        f"reach, or the weight of {target.terms[0][1]:g} lets the cost of transport prevail."
    )
