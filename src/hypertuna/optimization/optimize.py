"""Optimize: from a wish to the gait that fulfills it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.checkpoint import Journal
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.gradient import Descents
from hypertuna.optimization.objective import Goal, Limit, Problem, expected_speed, goal
from hypertuna.optimization.optimizers import CovarianceAdaptation, Optimizer, de, pso
from hypertuna.optimization.optimum import Margin, Optimum, concluded
from hypertuna.optimization.robust import over_fit
from hypertuna.swimming.beat import DEFAULT_STEPS, check_steps

__all__ = ["METHODS", "WEIGHT", "Margin", "Optimum", "make_optimizer", "optimize", "wish"]

Array = NDArray[np.float64]

METHODS = ("pso", "cma", "gradient", "de")
SIZES = {"pso": (15, 60), "de": (15, 60), "cma": (None, 200), "gradient": (6, 60)}  # gaits per batch and batches
MOST = 10_000  # gaits per batch, and batches

# k of Eq. 42 [m/s per J/(kg m)]. Up to 1/(dCOT/dU) along the cheapest gaits, |U - U_e| holds the speed exactly where it
# is expected: 0.12 for HyperTuna at 0.5 m/s, more at lower speeds (docs/optimize.md). Less than half of it is safe.
WEIGHT = 0.05


def wish(
    *, maximize: str | None = None, minimize: str | None = None, speed: float | None = None, weight: float | None = None
) -> Goal:
    """Make a goal of what a user says.

    Parameters
    ----------
    maximize, minimize : str, optional
        A quantity: "speed", "cost_of_transport" ...
    speed : float, optional
        Expected speed, at low cost of transport (Eq. 42) [m/s].
    weight : float, optional
        k of Eq. 42, `WEIGHT` if left out [m/s per J/(kg m)].

    Returns
    -------
    Goal

    Raises
    ------
    InputError
        If not exactly one of maximize, minimize and speed is given, or its value cannot be used.
    """
    given = [
        key for key, value in (("maximize", maximize), ("minimize", minimize), ("speed", speed)) if value is not None
    ]
    if len(given) != 1:
        fix = "give --maximize speed, --speed 0.4 or --minimize cost_of_transport"
        rule = "must be one of maximize, minimize and speed"
        raise InputError(rule, key="goal", value=" and ".join(given) or "none", fix=fix)
    if speed is not None:
        return expected_speed(speed, WEIGHT if weight is None else weight)
    if weight is not None:
        raise InputError("goes with an expected speed only", key="weight", fix="leave it out, or give --speed")
    name = maximize or minimize
    assert name is not None
    return goal(name, largest=maximize is not None)


def optimize(
    robot: Robot,
    *,
    maximize: str | None = None,
    minimize: str | None = None,
    speed: float | None = None,
    weight: float | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    limits: Sequence[Limit] = (),
    method: str = "pso",
    particles: int | None = None,
    iterations: int | None = None,
    robust: str | None = None,
    samples: int = 32,
    seed: int = 1,
    steps: int = DEFAULT_STEPS,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Optimum:
    """Find the gait that fulfills a wish best.

    Parameters
    ----------
    robot : Robot
    maximize, minimize : str, optional
        A quantity of `QUANTITIES` to make large or small. One of these two and `speed` must be given.
    speed : float, optional
        Expected speed U_e; the fitness is ``|U - U_e| + k COT`` (Eq. 42) [m/s].
    weight : float, optional
        k of it [m/s per J/(kg m)].
    bounds : mapping, optional
        Lowest and highest values in Hz or degrees beside those of the robot's file, as for
        `hypertuna.optimization.design_space.gait_bounds` [Hz or deg].
    limits : sequence of Limit
        From `gait_limits`.
    method : {"pso", "cma", "gradient", "de"}
        Particle swarm, CMA-ES, gradient descents with exact derivatives, differential evolution.
    particles : int, optional
        Gaits per batch; starts of "gradient".
    iterations : int, optional
        Batches at most; steps of every start of "gradient".
    robust : {"mean", "worst5"}, optional
        Take the goal as its mean, or the mean of its worst 5 %, over robots drawn from the robot's fit, each of which
        must keep the limits. The swim of the result is that of the robot itself.
    samples : int
        Robots to draw.
    seed : int
        The same seed gives the same result.
    steps : int
        Runge-Kutta steps per beat, a multiple of 4.
    checkpoint : str or Path, optional
        A file to take the work up from after any end, and to keep it in.
    progress : callable, optional
        Called with the number of gaits done and the most there may be, now and then.

    Returns
    -------
    Optimum
        Its gait is None if no gait keeps all limits, which `stop` then says.

    Raises
    ------
    InputError
        If something cannot be used: the sentence names it.

    Examples
    --------
    >>> import hypertuna as ht
    >>> best = ht.optimize(ht.load("hypertuna"), maximize="speed", method="gradient")
    >>> round(best.speed, 3), round(best.gait.frequency, 3)
    (0.582, 6.0)
    """
    check_steps(steps)
    target = wish(maximize=maximize, minimize=minimize, speed=speed, weight=weight)
    problem = Problem(robot, gait_bounds(robot, bounds), (target,), tuple(limits), steps)
    optimizer, most = make_optimizer(problem, method, particles, iterations, seed)
    started = time.monotonic()  # of the search, not of the import of libraries
    posed = problem if robust is None else over_fit(problem, robust, samples=samples, seed=seed)
    options = _options(problem, method, particles, iterations, seed)
    options |= {} if robust is None else {"robust": robust, "samples": samples}
    with Journal(checkpoint, journal_header("optimize", robot, options)) as journal:
        while (stop := optimizer.stop) is None:
            x = optimizer.ask()
            found = journal.answer(x, partial(posed.swim, x, slopes=optimizer.needs_slopes))
            optimizer.tell(posed.judge(x, found))
            if progress is not None:
                done = optimizer.evaluations
                progress(done * len(posed.robots), max(most, done) * len(posed.robots))
    return concluded(posed, optimizer, method=method, seed=seed, stop=stop, seconds=time.monotonic() - started)


def make_optimizer(
    problem: Problem, method: str, particles: int | None, iterations: int | None, seed: int
) -> tuple[Optimizer, int]:
    """Make the optimizer of a method for a problem with one goal.

    Parameters
    ----------
    problem : Problem
    method : str
        One of `METHODS`.
    particles, iterations : int or None
        The method's own choice if None.
    seed : int

    Returns
    -------
    optimizer : Optimizer
    most : int
        Evaluations at most.

    Raises
    ------
    InputError
        If there is no such method, or a number is out of range.
    """
    if method not in METHODS:
        fix = did_you_mean(method, METHODS)
        raise InputError("must be a method", key="method", value=shown(method), fix=fix)
    size = SIZES[method][0] if particles is None else particles
    batches = SIZES[method][1] if iterations is None else iterations
    least = 2 if method in ("pso", "cma") else 4 if method == "de" else 1
    for key, value, low in (("particles", size, least), ("iterations", batches, 1)):
        if value is not None and not low <= value <= MOST:
            raise InputError(f"must be from {low} to {MOST}", key=key, value=str(value), fix="or leave it out")
    if not 0 <= seed < 2**32:
        raise InputError("must be from 0 to 4294967295", key="seed", value=str(seed), fix="take 1")
    assert batches is not None
    lower, upper = problem.space.lower, problem.space.upper
    if method == "cma":
        if len(lower) < 2:
            rule, fix = "must fit a search with one free value of the gait", "take pso, gradient or de, or free another"
            raise InputError(rule, key="method", value="'cma', which varies two at least", fix=fix)
        strategy = CovarianceAdaptation(lower, upper, particles=size, iterations=batches, seed=seed)
        return strategy, strategy.particles * batches
    assert size is not None  # the others have a number of their own
    if method == "gradient":
        if problem.rough:
            rule = f"must do without derivatives, which {' and '.join(problem.rough)} does not have"
            raise InputError(rule, key="method", value="'gradient'", fix="take pso, cma or de")
        target = problem.goals[0]
        # Differences of the value are scaled to what matters in it: to the cost of transport beside |U - U_e|.
        scale = target.terms[0][1] if target.expected is not None and target.terms[0][1] > 0 else 1.0
        sizes = {"starts": size, "iterations": batches, "seed": seed}
        return Descents(lower, upper, target.expected, scale, **sizes), size * batches
    make = pso if method == "pso" else de
    return make(lower, upper, particles=size, iterations=batches, seed=seed), size * batches


def _options(problem: Problem, method: str, particles: int | None, iterations: int | None, seed: int) -> dict[str, Any]:
    """Return everything that the course of a search depends on, beside the robot, for its journal."""
    space = problem.space
    bounds = {name: [low, high] for name, low, high in zip(space.columns, space.low, space.high, strict=True)}
    goals = [asdict(target) for target in problem.goals]
    chosen = {"method": method, "particles": particles, "iterations": iterations, "seed": seed, "steps": problem.steps}
    return {"goals": goals, "bounds": bounds, "limits": [asdict(limit) for limit in problem.limits]} | chosen
