"""Robust objectives: what gaits are worth over the robots that a fit leaves possible, not the likeliest one alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, shown
from hypertuna.identification.coefficients import draws
from hypertuna.optimization.constraints import Limit
from hypertuna.optimization.design_space import Space
from hypertuna.optimization.objective import Evaluation, Goal, Problem

__all__ = ["WAYS", "How", "RobustProblem", "over_fit", "robust_problem"]

Array = NDArray[np.float64]

How = Literal["mean", "worst5"]

MOST_SAMPLES = 10_000
WORST = 0.05  # part of the robots that count for "worst5"
WAYS = {"mean": "mean over all of them", "worst5": "mean of the worst 5 % of them"}


@dataclass(frozen=True)
class RobustProblem:
    """A problem posed to several robots at once: optimizers take it for a `Problem`.

    Attributes
    ----------
    problem : Problem
        As posed to the robot itself; what all share is its.
    problems : tuple of Problem
        The same for every other robot.
    how : {"mean", "worst5"}
        Each goal counts as its mean over the robots, or as the mean of its worst ceil(0.05 n) values (conditional value
        at risk; Rockafellar and Uryasev, 2000), whichever robots those are. Limits must be kept with every robot.
    """

    problem: Problem
    problems: tuple[Problem, ...]
    how: How

    @property
    def robot(self) -> Robot:
        """The robot itself."""
        return self.problem.robot

    @property
    def robots(self) -> tuple[Robot, ...]:
        """All robots that a gait is swum by: those drawn."""
        return tuple(problem.robot for problem in self.problems)

    @property
    def space(self) -> Space:
        """Where gaits are sought."""
        return self.problem.space

    @property
    def goals(self) -> tuple[Goal, ...]:
        """What is minimized."""
        return self.problem.goals

    @property
    def limits(self) -> tuple[Limit, ...]:
        """What is kept."""
        return self.problem.limits

    @property
    def needs(self) -> tuple[str, ...]:
        """Quantities that goals and limits are made of."""
        return self.problem.needs

    @property
    def rough(self) -> tuple[str, ...]:
        """Quantities that goals and limits need and that have no derivatives."""
        return self.problem.rough

    @property
    def steps(self) -> int:
        """Runge-Kutta steps per beat."""
        return self.problem.steps

    def evaluate(self, x: Array, *, slopes: bool = False) -> Evaluation:
        """Swim the gaits at points with every robot, one batch for each, and judge them together.

        Parameters
        ----------
        x : ndarray, shape (points, dim)
            [Hz or rad].
        slopes : bool
            Whether to differentiate, too.

        Returns
        -------
        Evaluation
            As `judge` makes it.
        """
        return self.judge(x, self.swim(x, slopes=slopes))

    def swim(self, x: Array, *, slopes: bool = False) -> dict[str, Array]:
        """Swim the gaits at points with every robot, one batch for each.

        Parameters
        ----------
        x : ndarray, shape (points, dim)
            [Hz or rad].
        slopes : bool
            Whether to differentiate, too.

        Returns
        -------
        dict of ndarray
            As `Problem.swim`, each with the robots as its first dimension.
        """
        found = [problem.swim(x, slopes=slopes) for problem in self.problems]
        return {name: np.stack([each[name] for each in found]) for name in found[0]}

    def judge(self, x: Array, found: Mapping[str, Any]) -> Evaluation:
        """Make goals and violations of quantities.

        Parameters
        ----------
        x : ndarray, shape (points, dim)
            [Hz or rad].
        found : mapping of array_like
            As `swim` returns it.

        Returns
        -------
        Evaluation
            Quantities are means over the robots, the status is the worst; a gait that is unusable with one robot is
            unusable.
        """
        count = len(self.problems)
        told = [p.judge(x, {name: of[k] for name, of in found.items()}) for k, p in enumerate(self.problems)]
        tail = count if self.how == "mean" else math.ceil(WORST * count)
        value, violation = (np.stack([getattr(each, name) for each in told]) for name in ("value", "violation"))
        worst = np.argsort(-value, axis=0, kind="stable")[:tail]  # (tail, points, goals)
        hardest = violation.argmax(axis=0)[np.newaxis]  # (1, points, limits)
        slopes = {}
        if told[0].value_slopes is not None:
            slopes = {
                "value_slopes": _taken(told, "value_slopes", worst).mean(axis=0),
                "violation_slopes": _taken(told, "violation_slopes", hardest)[0],
                "speed_slopes": np.mean([np.asarray(each.speed_slopes) for each in told], axis=0),
            }
        quantities = {name: np.stack([each.found[name] for each in told]) for name in told[0].found}
        return Evaluation(
            told[0].x,
            np.take_along_axis(value, worst, axis=0).mean(axis=0),
            np.take_along_axis(violation, hardest, axis=0)[0],
            {name: q.max(axis=0) if name == "status" else q.mean(axis=0) for name, q in quantities.items()},
            **slopes,
        )


def over_fit(problem: Problem, how: str, *, samples: int, seed: int) -> RobustProblem:
    """Pose a problem to robots drawn from the fit of its robot.

    Parameters
    ----------
    problem : Problem
        Whose robot has a table ``[fit]``.
    how : {"mean", "worst5"}
    samples : int
        Robots to draw.
    seed : int

    Returns
    -------
    RobustProblem

    Raises
    ------
    InputError
        If `how` is something else, no robot is to be drawn, or there is no fit to draw from.
    """
    _check_way(how)
    if not 1 <= samples <= MOST_SAMPLES:
        rule, fix = f"must be from 1 to {MOST_SAMPLES}", "or leave it out"
        raise InputError(rule, key="samples", value=str(samples), fix=fix)
    return robust_problem(problem, draws(problem.robot, samples, seed), how)


def robust_problem(problem: Problem, robots: Sequence[Robot], how: str) -> RobustProblem:
    """Pose a problem to several robots at once.

    Parameters
    ----------
    problem : Problem
    robots : sequence of Robot
        Such as `hypertuna.identification.coefficients.draws` gives.
    how : {"mean", "worst5"}

    Returns
    -------
    RobustProblem

    Raises
    ------
    InputError
        If `how` is something else, or there is no robot.
    """
    _check_way(how)
    if not robots:
        raise InputError("must hold one robot at least", key="robots", value="empty", fix="draw some from a fit")
    return RobustProblem(problem, tuple(replace(problem, robot=robot) for robot in robots), cast(How, how))


def _check_way(how: str) -> None:
    """Check how a goal is to be taken over robots."""
    if how not in WAYS:
        raise InputError("must be mean or worst5", key="robust", value=shown(how), fix="choose one of them")


def _taken(told: Sequence[Evaluation], name: str, index: NDArray[np.intp]) -> Array:
    """Slopes of the evaluations that an index picks for each point and goal or limit."""
    slopes = np.stack([getattr(each, name) for each in told])  # (robots, points, goals or limits, dim)
    return np.take_along_axis(slopes, index[..., np.newaxis], axis=0)
