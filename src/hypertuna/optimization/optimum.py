"""What a search found: the best gait, how it keeps its limits, and what else there is to say of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.optimization.constraints import Limit
from hypertuna.optimization.design_space import Space
from hypertuna.optimization.objective import UNUSABLE, Evaluation, Goal, Problem, goal
from hypertuna.optimization.optimizers import Optimizer
from hypertuna.optimization.robust import RobustProblem
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import Swim, swim

__all__ = ["Margin", "Optimum", "concluded"]

Array = NDArray[np.float64]

NEAR = 5e-3  # a limit or bound so near, relative, is active
MET = 5e-3  # an expected speed so near, relative, is met
FLAT = 5e-3  # values so near the best, relative, are told to be near it
WIDE = 0.1  # part of its bounds over which a coordinate near the best is worth a remark
PLACES = 25  # that are tried for that from the best to each bound


@dataclass(frozen=True)
class Margin:
    """How a gait keeps a limit.

    Attributes
    ----------
    limit : Limit
    value : float
        Of the gait; over robots drawn, of the one that keeps the limit least [unit of the quantity].
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
        Of the goal, minimized; over the robots drawn in a robust search.
    robust : {"mean", "worst5"} or None
        How the goal is taken over robots drawn from the fit. Swim, speed and cost are those of the robot itself.
    method : str
    seed : int
    evaluations : int
        Gaits swum by the search, of a robust one by every robot drawn, those of a checkpoint included.
    seconds : float
        Taken by this run.
    stop : str
        Why the search ended, in a sentence.
    history : ndarray, shape (batches,)
        Least value of the goal after each batch; infinite before a gait keeps all limits.
    swum : ndarray, shape (batches,)
        Gaits swum until then, counted as `evaluations`.
    margins : tuple of Margin
        Of the limits.
    bounds : mapping
        Which end of its bounds the gait lies on, "lower" or "upper", by the names of `gait_columns`.
    near_best : mapping
        How flat the best is: by the same names, the lowest and highest value between which, all others held, the value
        of the goal stays within 0.5 % of the best and all limits are kept [Hz or deg]; empty where a speed is expected.
    weight_threshold : float or None
        Up to this k of Eq. 42 the speed stays exactly as expected, judged by the slopes at this gait
        [m/s per J/(kg m)]; None where no speed is expected or it is not met, over robots drawn, and with limits that
        have no derivatives.
    remark : str
        What else there is to know about the result; empty if nothing.
    """

    robot: Robot
    goal: Goal
    gait: Gait | None
    swim: Swim | None
    value: float
    robust: str | None
    method: str
    seed: int
    evaluations: int
    seconds: float
    stop: str
    history: Array
    swum: NDArray[np.int_]
    margins: tuple[Margin, ...]
    bounds: Mapping[str, str]
    near_best: Mapping[str, tuple[float, float]]
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


def concluded(
    problem: Problem | RobustProblem, optimizer: Optimizer, *, method: str, seed: int, stop: str, seconds: float
) -> Optimum:
    """Make the result of a search that has ended.

    Parameters
    ----------
    problem : Problem or RobustProblem
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
    margins = tuple(_margin(limit, float(over)) for limit, over in zip(problem.limits, best.violation[0], strict=True))
    feasible = bool(best.feasible[0])
    ends = zip(space.names, best.x[0] - space.lower, space.upper - best.x[0], space.upper - space.lower, strict=True)
    bounds = {name: "lower" if low < high else "upper" for name, low, high, w in ends if min(low, high) < NEAR * w}
    gait = space.gait(best.x[0]) if feasible else None
    swum = None if gait is None else swim(problem.robot, gait, steps=problem.steps)
    robust = problem.how if isinstance(problem, RobustProblem) else None
    missed = "" if swum is None else _missed(target, float(best.found["speed"][0]), swum.speed if robust else None)
    near = _near_best(problem, best) if feasible and target.expected is None else {}
    threshold = None
    if isinstance(problem, Problem) and feasible and target.expected is not None and not (missed or problem.rough):
        threshold = _weight_threshold(problem, best)
    return Optimum(
        robot=problem.robot,
        goal=target,
        gait=gait,
        swim=swum,
        value=float(best.value[0, 0]) if feasible else np.nan,
        robust=robust,
        method=method,
        seed=seed,
        evaluations=optimizer.evaluations * len(problem.robots),
        seconds=seconds,
        stop=stop if feasible else f"{stop} {_infeasible(margins)}",
        history=np.array(optimizer.history),
        swum=np.cumsum(optimizer.batches) * len(problem.robots),
        margins=margins[1:],
        bounds=bounds if feasible else {},
        near_best=near,
        weight_threshold=threshold,
        remark=missed or _flat(space, near),
    )


def _near_best(problem: Problem | RobustProblem, best: Evaluation) -> dict[str, tuple[float, float]]:
    """Find how far every coordinate alone can go until the value is worse by 0.5 %, or a limit is passed."""
    space, at = problem.space, best.x[0]
    edges = np.stack([space.lower, space.upper])
    way = np.linspace(0, 1, PLACES + 1)[1:] ** 2  # places from the best to an edge, closer where it matters
    x = np.tile(at, (*edges.shape, PLACES, 1))
    for k, edge in enumerate(edges.T):
        x[:, k, :, k] += np.outer(edge - at[k], way)
    ahead = edges != at
    found = problem.evaluate(x[ahead].reshape(-1, len(at)))
    # What is left of what the value may lose: 1 at the best, 0 at the end of the range.
    left = 1 - (found.value[:, 0] - best.value[0, 0]) / (FLAT * abs(best.value[0, 0]))
    left[~found.feasible] = -np.inf
    reach = np.ones(edges.shape)
    reach[ahead] = [_reach(way, parts) for parts in left.reshape(-1, PLACES)]
    low, high = (at + reach * (edges - at)) / space.unit[space.free]
    return {name: (float(low[k]), float(high[k])) for k, name in enumerate(space.names)}


def _reach(way: Array, left: Array) -> float:
    """Return where what is left comes to 0 for the first time, on lines between places; 1 if it never does."""
    gone = np.flatnonzero(left < 0)
    if not len(gone):
        return 1.0
    k = gone[0]
    place, part = (way[k - 1], left[k - 1]) if k else (0.0, 1.0)
    return float(place + part / (part - left[k]) * (way[k] - place))  # no step further where a limit ends it


def _flat(space: Space, near: Mapping[str, tuple[float, float]]) -> str:
    """Say where the best is flat: which coordinates may go over a tenth of their bounds or more."""
    width = dict(zip(space.names, (space.upper - space.lower) / space.unit[space.free], strict=True))
    wide = []
    for name, (low, high) in near.items():
        if high - low > WIDE * width[name]:
            *words, unit = name.split("_")
            wide.append(f"{' '.join(words)} from {low:.3g} to {high:.3g} {'Hz' if unit == 'hz' else unit}")
    return f"The best is flat: within {100 * FLAT:g} % of it for {' and '.join(wide)}." if wide else ""


def _weight_threshold(problem: Problem, best: Evaluation) -> float:
    """Return the k of Eq. 42 up to which |U - U_e| holds the speed exactly (exact penalty); infinite if any does.

    Where the speed is as expected, k COT pulls along the cheapest gaits with k dCOT/dU and |U - U_e| holds with 1. That
    slope is the multiplier of the speed in the conditions of Karush, Kuhn and Tucker, here by least squares over what
    is not on its bounds.
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


def _margin(limit: Limit, over: float) -> Margin:
    """Tell how a limit is kept, from how far it is passed; not numbers of a gait that cannot be used."""
    part = np.nan if over == UNUSABLE else over
    return Margin(limit, limit.limit * (1 + part if limit.upper else 1 - part), -part)


def _infeasible(margins: Sequence[Margin]) -> str:
    """Say which limits the nearest gait does not keep."""
    forward, *others = margins
    passed = [f"{m.limit.quantity} by {-100 * m.margin:.3g} %" for m in others if m.margin < 0]
    if forward.margin < 0 or not passed:
        return "No gait was found that settles and swims forward."
    return f"No gait was found that keeps all limits: the nearest one passes {' and '.join(passed)}."


def _missed(target: Goal, speed: float, own: float | None) -> str:
    """Say so if the expected speed is not met: over robots drawn the mean, beside the robot's own speed."""
    if target.expected is None or abs(speed / target.expected - 1) < MET:
        return ""
    weight = f"the weight of {target.terms[0][1]:g} lets the cost of transport prevail"
    if own is None:
        return (
            f"The gait swims at {speed:.4g} m/s instead of the expected {target.expected:.4g} m/s: that speed is out "
            f"of reach, or {weight}."
        )
    return (
        f"The robots drawn swim the gait at {speed:.4g} m/s on average, the robot itself at {own:.4g} m/s, instead of "
        f"the expected {target.expected:.4g} m/s: no gait brings all of them to that speed, or {weight}."
    )
