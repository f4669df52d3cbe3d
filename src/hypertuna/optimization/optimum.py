"""Result of a search: the best gait, its margins to the limits, and how flat the optimum is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.design import Variable
from hypertuna.description.robot import Robot
from hypertuna.display import Plotted, Tabular
from hypertuna.optimization.constraints import Limit
from hypertuna.optimization.design_space import DesignSpace
from hypertuna.optimization.objective import UNUSABLE, Evaluation, Objective, objective
from hypertuna.optimization.optimizers import Optimizer
from hypertuna.optimization.problem import Problem
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import Swim, swim

NEAR = 5e-3  # relative distance within which a limit or bound counts as active
MET = 5e-3  # relative error within which an expected speed counts as met
FLAT = 5e-3  # values within this relative difference of the best are near the best
WIDE = 0.1  # a coordinate whose values near the best span more than this part of its bounds is reported
IDLE = 0.05  # body lengths per beat: a gait with a shorter stride hardly swims
MADE_BY = "best design found by hypertuna optimize"  # source of the values of variables
PLACES = 25  # points evaluated between the best and each bound


@dataclass(frozen=True)
class Margin:
    """Distance of a gait from a limit."""

    limit: Limit
    value: float  # the gait's; in a robust search, that of the robot with the smallest margin [unit of the quantity]
    margin: float  # distance from the limit, relative to the limit; negative if it is violated [1]

    @property
    def active(self) -> bool:
        """Whether the limit is active."""
        return self.margin < NEAR


@dataclass(frozen=True)
class Optimum(Plotted, Tabular):
    """The best gait of a search, and the best robot if numbers of its file are variables."""

    robot: Robot  # the robot that swims the gait; with the best design, if numbers are variables
    objective: Objective
    gait: Gait | None  # None if no gait satisfies all limits
    swim: Swim | None  # swim of the gait by `robot`, also in a robust search
    value: float  # value of the objective, to be minimized; over the sampled robots in a robust search
    robust: str | None  # "mean" or "worst5" over robots sampled from the fit
    method: str
    seed: int
    evaluations: int  # gaits swum by all robots, those of a checkpoint included
    seconds: float  # duration of this run [s]
    stop: str  # why the search ended, as a sentence
    history: Array  # (batches,) least value after each batch; infinite before a gait satisfies all limits
    swum: NDArray[np.int_]  # (batches,) number of gaits swum after each batch, counted as in `evaluations`
    margins: tuple[Margin, ...]
    bounds: Mapping[str, str]  # "lower" or "upper" for every coordinate on a bound, by the names of `gait_columns`
    # Range of each coordinate alone in which the value stays within 0.5 % of the best and all limits are kept
    # [Hz or deg]; empty if a speed is expected.
    near_best: Mapping[str, tuple[float, float]]
    # Largest weight k of Eq. 42 with which the speed stays exactly as expected, from the gradients at this gait
    # [m/s per J/(kg m)]; None if no speed is expected or met, in robust searches, and if a limit has no derivatives.
    weight_threshold: float | None
    variables: tuple[Variable, ...]  # numbers of the robot's file that the search varied
    design: Mapping[str, float]  # best values of the variables by name [unit of the file]
    remark: str  # further sentences on the result; may be empty

    @property
    def speed(self) -> float:
        """Speed of the gait [m/s]; NaN without one."""
        return np.nan if self.swim is None else self.swim.speed

    @property
    def cost_of_transport(self) -> float:
        """Cost of transport of the gait [J/(kg m)]; NaN without one."""
        return np.nan if self.swim is None else self.swim.cost_of_transport


def make_optimum(
    problem: Problem, optimizer: Optimizer, *, method: str, seed: int, stop: str, seconds: float
) -> Optimum:
    """Return the result of a search that has ended."""
    best, space, target = optimizer.result, problem.space, problem.objectives[0]
    assert best is not None  # every method asks for at least one batch
    excess = np.where(best.violation[0] == UNUSABLE, np.nan, best.violation[0]).tolist()
    margins = [
        Margin(limit, limit.limit * (1 + part if limit.upper else 1 - part), -part)
        for limit, part in zip(problem.limits, excess, strict=True)
    ]
    feasible = bool(best.feasible[0])
    gait = space.gait(best.x[0]) if feasible else None
    names = [variable.name for variable in space.variables]
    design = dict(zip(names, space.design(best.x[0]).tolist(), strict=True)) if feasible else {}
    robot = space.robot(problem.robot, best.x[0], made_by=MADE_BY) if feasible else problem.robot
    swum = None if gait is None else swim(robot, gait, steps=problem.steps)
    missed = "" if swum is None else _missed_sentence(problem, float(best.quantities["speed"][0]), swum.speed)
    near_best = _near_best(problem, best) if feasible and target.expected is None else {}
    exact = feasible and target.expected is not None and not (missed or problem.non_differentiable or problem.robust)
    robots = len(problem.robots)
    on_bounds = zip(space.names, *_on_bounds(space, best.x[0]), strict=True)
    bounds = {name: "lower" if low else "upper" for name, low, high in on_bounds if low or high}
    return Optimum(
        robot=robot,
        objective=target,
        gait=gait,
        swim=swum,
        value=float(best.value[0, 0]) if feasible else np.nan,
        robust=problem.robust,
        method=method,
        seed=seed,
        evaluations=optimizer.evaluations * robots,
        seconds=seconds,
        stop=stop if feasible else f"{stop} {_infeasible_sentence(margins)} {problem.refusal(best.x[0])}".rstrip(),
        history=np.array(optimizer.history),
        swum=np.cumsum(optimizer.batches) * robots,
        margins=tuple(margins[1:]),
        bounds=bounds if feasible else {},
        near_best=near_best,
        variables=space.variables,
        design=design,
        weight_threshold=_weight_threshold(problem, best) if exact else None,
        remark=" ".join(
            filter(
                None,
                [
                    missed or _flat_sentence(space, near_best),
                    *(() if swum is None else (_idle_sentence(target, swum), _from_rest_sentence(swum))),
                ],
            )
        ),
    )


def _on_bounds(space: DesignSpace, x: Array) -> list[NDArray[np.bool_]]:
    """Return which coordinates (dim,) lie on the lower and which on the upper bound, within `NEAR` of its size."""
    width, ends = space.upper - space.lower, (space.lower, space.upper)
    sizes = [np.where(end == 0, width, np.minimum(width, abs(end))) for end in ends]
    return [abs(x - end) < NEAR * np.where(space.logarithms, 1.0, size) for end, size in zip(ends, sizes, strict=True)]


def _near_best(problem: Problem, best: Evaluation) -> dict[str, tuple[float, float]]:
    """Return for each coordinate alone the range [Hz or deg] in which the value loses at most 0.5 % and limits hold."""
    space, best_point = problem.space, best.x[0]
    edges = np.stack([space.lower, space.upper])
    fractions = np.linspace(0, 1, PLACES + 1)[1:] ** 2  # parts of the way to an edge, denser near the best
    x = np.tile(best_point, (*edges.shape, PLACES, 1))
    for k, edge in enumerate(edges.T):
        x[:, k, :, k] += np.outer(edge - best_point[k], fractions)
    inside = edges != best_point
    evaluation = problem.evaluate(x[inside].reshape(-1, len(best_point)))
    # Part of the allowed loss of value that is not used yet: 1 at the best, 0 at the end of the range.
    reserve = 1 - (evaluation.value[:, 0] - best.value[0, 0]) / (FLAT * abs(best.value[0, 0]))
    reserve[~evaluation.feasible] = -np.inf
    reach = np.ones(edges.shape)
    reach[inside] = [_reach(fractions, parts) for parts in reserve.reshape(-1, PLACES)]
    low, high = (space.shown(ends) for ends in best_point + reach * (edges - best_point))
    return {name: (float(low[k]), float(high[k])) for k, name in enumerate(space.names)}


def _reach(fractions: Array, reserve: Array) -> float:
    """Return the fraction at which the reserve first reaches 0, by linear interpolation; 1 if it never does."""
    used_up = np.flatnonzero(reserve < 0)
    if not len(used_up):
        return 1.0
    k = used_up[0]
    fraction, part = (fractions[k - 1], reserve[k - 1]) if k else (0.0, 1.0)
    return float(fraction + part / (part - reserve[k]) * (fractions[k] - fraction))  # reserve[k] is -inf at a limit


def _idle_sentence(target: Objective, result: Swim) -> str:
    """Return a sentence if a gait has a low cost of transport only because it hardly swims."""
    if not target.name.startswith("cost_of_transport") or result.stride_length > IDLE:
        return ""
    return (
        f"The gait hardly swims, {result.stride_length:.1g} body lengths a beat: the cost of transport falls with the "
        "speed. Give the least speed that the robot must reach, or the speed at which it swims."
    )


def _from_rest_sentence(result: Swim) -> str:
    """Return a sentence if a start from rest does not lead to the gait's settled beat, which searches do not check."""
    if result.reached_from_rest:
        return ""
    settled = result.settled_from_rest
    outcome = "does not settle" if settled is None else f"leads to {settled.speed:.4g} m/s"
    return f"The robot must be brought to speed: from rest the gait {outcome}."


def _flat_sentence(space: DesignSpace, near_best: Mapping[str, tuple[float, float]]) -> str:
    """Return a sentence on coordinates that may vary over a tenth of their bounds or more; empty if there are none."""
    variables = {variable.name: (variable.label, variable.unit) for variable in space.variables}
    width = dict(zip(space.names, space.shown(space.upper) - space.shown(space.lower), strict=True))
    ranges = []
    for name, (low, high) in near_best.items():
        if high - low > WIDE * width[name]:
            *words, unit = name.split("_")
            label, unit = variables.get(name, (" ".join(words), "Hz" if unit == "hz" else unit))
            ranges.append(f"{label} from {low:.3g} to {high:.3g} {unit}".rstrip())
    return f"The best is flat: within {100 * FLAT:g} % of it for {' and '.join(ranges)}." if ranges else ""


def _weight_threshold(problem: Problem, best: Evaluation) -> float:
    """Return the largest k of Eq. 42 with which the optimal speed is exactly as expected; infinite if any k does.

    At the expected speed, k COT changes along the cheapest gaits with the slope k dCOT/dU, and |U - U_e| with the slope
    1 (an exact penalty). dCOT/dU is the multiplier of the speed in the Karush-Kuhn-Tucker conditions, found by least
    squares over the coordinates that are not on their bounds.
    """
    space = problem.space
    width = space.upper - space.lower
    evaluation = replace(problem, objectives=(objective("cost_of_transport"),)).evaluate(best.x, derivatives=True)
    assert evaluation.value_jacobian is not None
    assert evaluation.speed_gradient is not None
    assert evaluation.violation_jacobian is not None
    inside = ~np.logical_or(*_on_bounds(space, best.x[0]))
    active = evaluation.violation_jacobian[0, 1:][-evaluation.violation[0, 1:] < NEAR]
    columns = np.vstack([evaluation.speed_gradient[0], active])[:, inside] * width[inside]
    gradient = evaluation.value_jacobian[0, 0, inside] * width[inside]
    multiplier = float(np.linalg.lstsq(columns.T, gradient, rcond=None)[0][0]) if inside.any() else 0.0
    return 1 / multiplier if multiplier > 0 else np.inf


def _infeasible_sentence(margins: Sequence[Margin]) -> str:
    """Return a sentence on the limits violated by the gait that comes nearest to satisfying all of them."""
    forward, *others = margins
    violated = [f"{m.limit.quantity} by {-100 * m.margin:.3g} %" for m in others if m.margin < 0]
    if forward.margin < 0 or not violated:
        return "No gait was found that settles and swims forward."
    return f"No gait was found that satisfies all limits: the nearest one violates {' and '.join(violated)}."


def _missed_sentence(problem: Problem, speed: float, own_speed: float) -> str:
    """Return a sentence if the expected speed is not met; speed: mean over robots, own_speed: the robot's [m/s]."""
    target = problem.objectives[0]
    if target.expected is None or abs(speed / target.expected - 1) < MET:
        return ""
    weight = f"the weight of {target.terms[0][1]:g} lets the cost of transport prevail"
    if problem.robust is None:
        return (
            f"The gait swims at {speed:.4g} m/s instead of the expected {target.expected:.4g} m/s: that speed is out "
            f"of reach, or {weight}."
        )
    return (
        f"The sampled robots swim the gait at {speed:.4g} m/s on average, the robot itself at {own_speed:.4g} m/s, "
        f"instead of the expected {target.expected:.4g} m/s: no gait brings all of them to that speed, or {weight}."
    )
