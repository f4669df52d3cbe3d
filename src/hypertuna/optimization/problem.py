"""Optimization problems: objectives and limits over a design space, for one robot or for robots sampled from a fit."""

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import sample_robots
from hypertuna.optimization.constraints import Limit, gait_quantities
from hypertuna.optimization.design_space import DesignSpace
from hypertuna.optimization.objective import UNUSABLE, Evaluation, Objective
from hypertuna.parallel.executors import map_shards
from hypertuna.ranges import Whole, check_choice
from hypertuna.swimming.beat import DEFAULT_STEPS, DIFFERENTIABLE, QUANTITIES, STATUSES, directional_derivatives, settle
from hypertuna.swimming.designs import model_features, rates
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.yielding import bend_table

PART = 16  # points per task of an executor
MIN_STRIDE = 1e-3  # body lengths per beat: a gait with a shorter stride stands still
SAMPLES = Whole(min=1, max=10_000)  # allowed number of sampled robots
PER = {  # quantities divided by the robot's mass or length, which are no parameters of the core's model
    "robot_mass": ("cost_of_transport", "cost_of_transport_positive"),
    "robot_length": ("speed_bl", "stride_length"),
}
WORST = 0.05  # part of the robots over which "worst5" is the mean
STATISTICS = {"mean": "mean over all robots", "worst5": "mean of the worst 5 % of the robots"}


@dataclass(frozen=True)
class Problem:
    """Objectives and limits over a design space; every gait must also swim forward, and every robot be valid."""

    robot: Robot
    space: DesignSpace
    objectives: tuple[Objective, ...]
    limits: tuple[Limit, ...] = ()
    steps: int = DEFAULT_STEPS  # Runge-Kutta steps per beat
    threads: int = 1  # results do not depend on it; one thread is faster for small batches
    samples: tuple[Robot, ...] = ()  # robots of a robust problem
    robust: str | None = None  # key of `STATISTICS`, the statistic over the samples; None for the robot alone
    executor: Executor | None = field(default=None, compare=False, repr=False)  # results do not depend on it

    def __post_init__(self) -> None:
        forward = Limit("stride_length", MIN_STRIDE, upper=False)
        object.__setattr__(self, "limits", (forward, *(limit for limit in self.limits if limit != forward)))

    @cached_property
    def needs(self) -> tuple[str, ...]:
        """Names of the quantities that objectives and limits use."""
        names = ["speed", "cost_of_transport", "stride_length"]
        names += [name for objective in self.objectives for name, _ in objective.terms]
        return tuple(dict.fromkeys([*names, *(limit.quantity for limit in self.limits)]))

    @property
    def robots(self) -> tuple[Robot, ...]:
        """Robots that swim every gait."""
        return (self.robot,) if self.robust is None else self.samples

    @property
    def non_differentiable(self) -> tuple[str, ...]:
        """Quantities in objectives and limits that have no derivatives."""
        swum = {*QUANTITIES, *bend_table(self.robot)}
        return tuple(name for name in self.needs if name in swum and name not in DIFFERENTIABLE)

    @property
    def options(self) -> dict[str, Any]:
        """All inputs of a search besides the robot, for the header of its journal."""
        bounds, variables = zip(self.space.columns, self.space.low, self.space.high, strict=True), self.space.variables
        return {
            "objectives": [asdict(objective) for objective in self.objectives],
            "bounds": {name: [low, high] for name, low, high in bounds} | {v.name: [v.low, v.high] for v in variables},
            "limits": [asdict(limit) for limit in self.limits],
            "steps": self.steps,
        }

    def evaluate(self, x: Array, *, derivatives: bool = False) -> Evaluation:
        """Swim the gaits at points, shape (points, dim) [Hz or rad], and evaluate objectives and limits."""
        return self.judge(x, self.swim(x, derivatives=derivatives))

    def swim(self, x: Array, *, derivatives: bool = False) -> dict[str, Array]:
        """Swim the gaits at points, shape (points, dim) [Hz or rad], in one batch for each robot.

        Return the quantities in `needs` and the status, shape (points,), and derivatives as ``d_NAME``, shape
        (points, dim). In a robust problem the robots are a first axis.
        """
        if derivatives and self.non_differentiable:
            fix = "choose a method without gradients"
            raise InputError("has no derivatives", key=" and ".join(self.non_differentiable), fix=fix)
        worker_problem = replace(self, samples=(), executor=None)  # a worker needs neither
        parts = [x[k : k + PART] for k in range(0, len(x), PART)] if self.executor else [x]
        tasks = ((robot, part) for robot in self.robots for part in parts)
        swims = list(map_shards(partial(_swim_part, worker_problem, derivatives), tasks, self.executor))
        rows = [swims[k : k + len(parts)] for k in range(0, len(swims), len(parts))]  # a list for each robot
        names = swims[0]
        if self.robust is None:
            return {name: np.concatenate([each[name] for each in rows[0]]) for name in names}
        return {name: np.stack([np.concatenate([each[name] for each in row]) for row in rows]) for name in names}

    def refusal(self, x: Array) -> str:
        """Return the sentence with which a robot at one point (dim,) is refused; empty if all swim there."""
        try:
            for robot in self.robots:
                settle(self.space.robot(robot, x), self.space.gaits(x[np.newaxis]), steps=self.steps)
        except InputError as error:
            return f"A robot of the search was refused: {error}"
        return ""

    def judge(self, x: Array, quantities: Mapping[str, Any]) -> Evaluation:
        """Evaluate objectives and limits from simulated or measured quantities, in the form that `swim` returns."""
        if self.robust is None:
            return self._judge(x, quantities)
        samples = [{name: rows[k] for name, rows in quantities.items()} for k in range(len(self.samples))]
        return _aggregate([self._judge(x, sample) for sample in samples], self.robust)

    def _swim(self, robot: Robot, x: Array, derivatives: bool) -> dict[str, Array]:
        """Return the quantities of gaits at points x (points, dim); the robot gets the variables of each point."""
        if not self.space.variables:
            return self._swim_gaits(robot, self.space.gaits(x), derivatives)
        rows = [self._swim_design(robot, point, derivatives) for point in x]
        return {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}

    def _swim_design(self, robot: Robot, x: Array, derivatives: bool) -> dict[str, Array]:
        """Return the quantities of the gait and robot at one point; NaN if the robot's file would be invalid."""
        gaits, values = self.space.gaits(x[np.newaxis]), self.space.design(x)

        def features(varied: Robot) -> Array:
            return np.append(model_features(varied), [*gait_quantities(varied, gaits)[0].values()])

        try:
            designed = self.space.robot(robot, x)
            slopes = self.space.slopes(x)
            robot_rates = rates(robot, self.space.variables, values, features) * slopes if derivatives else None
            return self._swim_gaits(designed, gaits, derivatives, robot_rates)
        except InputError:
            unknown = {name: np.full(1, np.nan) for name in self.needs}
            gradients = {f"d_{name}": np.full((1, len(x)), np.nan) for name in self.needs if derivatives}
            return unknown | gradients | {"status": np.array([STATUSES.index("unsettled")], np.int8)}

    def _swim_gaits(
        self, robot: Robot, gaits: Gaits, derivatives: bool, variable_rates: Array | None = None
    ) -> dict[str, Array]:
        """Return the quantities of gaits, shape (gaits,), and with `derivatives` their gradients as ``d_NAME``.

        variable_rates: derivatives with respect to the robot's variables, shape (rows, variables): of the
        `model_features`, then of the quantities that `gait_quantities` returns.
        """
        beats = settle(robot, gaits, steps=self.steps, threads=self.threads)
        of_gait, d_gait = gait_quantities(robot, gaits)
        quantities = {name: (of_gait | beats)[name] for name in (*self.needs, "status")}
        if not derivatives:
            return quantities
        directions = self.space.directions(robot)
        d_gait = {name: gradient[:, self.space.free[: directions.shape[1]]] for name, gradient in d_gait.items()}
        if variable_rates is not None:
            d_variables = dict(zip(d_gait, variable_rates[len(directions) :], strict=True))
            directions = np.hstack([directions, variable_rates[: len(directions)]])
            d_gait = {name: np.hstack([gradient, d_variables[name][np.newaxis]]) for name, gradient in d_gait.items()}
        gradients = directional_derivatives(robot, gaits, beats, directions, steps=self.steps)
        for size, names in PER.items() if variable_rates is not None else ():
            for name in names:
                gradients[name] = gradients[name] - beats[name][:, np.newaxis] * d_gait[size] / of_gait[size][0]
        return quantities | {f"d_{name}": (gradients | d_gait)[name] for name in self.needs}

    def _judge(self, x: Array, quantities: Mapping[str, Any]) -> Evaluation:
        """Return the objectives and violations of one robot from its quantities."""
        swum = {name: np.asarray(value, dtype=np.float64) for name, value in quantities.items()}
        with np.errstate(invalid="ignore"):
            violation = np.stack([_violation(limit, swum[limit.quantity]) for limit in self.limits], axis=1)
            value = np.stack([_value(each, swum) for each in self.objectives], axis=1)
        usable = (swum["status"] == 0) & np.isfinite(value).all(axis=1) & np.isfinite(violation).all(axis=1)
        violation[~usable] = UNUSABLE
        value[~usable | (violation[:, 0] > 0)] = np.inf
        derivatives: dict[str, Any] = {}
        if "d_speed" in swum:
            values = [_value_gradient(each, swum) for each in self.objectives]
            sides = [(1 if limit.upper else -1) / limit.limit * swum[f"d_{limit.quantity}"] for limit in self.limits]
            derivatives = {"value_jacobian": np.stack(values, axis=1), "violation_jacobian": np.stack(sides, axis=1)}
            derivatives["speed_gradient"] = swum["d_speed"]
        names = (*self.needs, "status")
        return Evaluation(np.asarray(x), value, violation, {name: swum[name] for name in names}, **derivatives)


def _swim_part(problem: Problem, derivatives: bool, task: tuple[Robot, Array]) -> dict[str, Array]:
    """Return the quantities of a task's points, swum by the task's robot."""
    robot, x = task
    return problem._swim(robot, x, derivatives)


def over_fit(problem: Problem, statistic: str, *, samples: int, seed: int) -> Problem:
    """Return the robust problem over robots sampled from the fit of its robot."""
    check_choice(statistic, STATISTICS, "robust")
    SAMPLES.check(samples, "samples", "leave it out for the default")
    return robust_problem(problem, sample_robots(problem.robot, samples, seed), statistic)


def robust_problem(problem: Problem, robots: Sequence[Robot], statistic: str) -> Problem:
    """Return the robust problem over several robots, all of which must keep the limits."""
    check_choice(statistic, STATISTICS, "robust")
    if not robots:
        raise InputError("must hold at least one robot", key="robots", value="empty", fix="sample robots from a fit")
    return replace(problem, samples=tuple(robots), robust=statistic)


def _aggregate(samples: Sequence[Evaluation], statistic: str) -> Evaluation:
    """Combine the evaluations of points by several robots into one evaluation.

    Each objective is its mean over the robots, or over its worst ceil(0.05 n) values (conditional value at risk;
    Rockafellar and Uryasev, 2000). Violations and the status are the worst, other quantities are means.
    """
    tail = len(samples) if statistic == "mean" else math.ceil(WORST * len(samples))
    value, violation = (np.stack([getattr(each, name) for each in samples]) for name in ("value", "violation"))
    worst = np.argsort(-value, axis=0, kind="stable")[:tail]  # (tail, points, objectives)
    hardest = violation.argmax(axis=0)[np.newaxis]  # (1, points, limits)

    def selected(name: str, index: NDArray[np.intp]) -> Array:
        jacobians = np.stack([getattr(each, name) for each in samples])  # (robots, points, objectives or limits, dim)
        return np.take_along_axis(jacobians, index[..., np.newaxis], axis=0)

    derivatives = {}
    if samples[0].value_jacobian is not None:
        derivatives = {
            "value_jacobian": selected("value_jacobian", worst).mean(axis=0),
            "violation_jacobian": selected("violation_jacobian", hardest)[0],
            "speed_gradient": np.mean([np.asarray(each.speed_gradient) for each in samples], axis=0),
        }
    quantities = {name: np.stack([each.quantities[name] for each in samples]) for name in samples[0].quantities}
    return Evaluation(
        samples[0].x,
        np.take_along_axis(value, worst, axis=0).mean(axis=0),
        np.take_along_axis(violation, hardest, axis=0)[0],
        {name: q.max(axis=0) if name == "status" else q.mean(axis=0) for name, q in quantities.items()},
        **derivatives,
    )


def _violation(limit: Limit, value: Array) -> Array:
    """Return the excess of a value over a limit, relative to the limit [1]."""
    excess = value / limit.limit - 1
    return np.asarray(excess if limit.upper else -excess)


def _value(objective: Objective, swum: Mapping[str, Array]) -> Array:
    """Return the value of an objective at points, shape (points,)."""
    value = np.sum([factor * swum[name] for name, factor in objective.terms], axis=0)
    return np.asarray(value if objective.expected is None else value + np.abs(swum["speed"] - objective.expected))


def _value_gradient(objective: Objective, swum: Mapping[str, Array]) -> Array:
    """Return the gradient of an objective, shape (points, dim); that of |U - U_e| is the one-sided gradient."""
    gradient = np.sum([factor * swum[f"d_{name}"] for name, factor in objective.terms], axis=0)
    if objective.expected is not None:
        gradient = gradient + np.sign(swum["speed"] - objective.expected)[:, np.newaxis] * swum["d_speed"]
    return np.asarray(gradient)
