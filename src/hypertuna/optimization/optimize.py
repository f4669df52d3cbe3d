"""Find the gait that is best for an objective."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.checkpoint import Journal
from hypertuna.optimization.constraints import Limit
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import Objective, expected_speed, objective
from hypertuna.optimization.optimizers import CMAES, Optimizer, de, pso
from hypertuna.optimization.optimum import Optimum, make_optimum
from hypertuna.optimization.problem import Problem, over_fit
from hypertuna.optimization.sqp import MultiStart
from hypertuna.swimming.beat import DEFAULT_STEPS, check_steps

METHODS = ("pso", "cma", "gradient", "de")
SIZES = {"pso": (15, 60), "de": (15, 60), "cma": (None, 200), "gradient": (6, 60)}  # gaits per batch, batches
MIN_PARTICLES = {"pso": 2, "cma": 2, "de": 4, "gradient": 1}
MAX_SIZE = 10_000  # gaits per batch, and batches

# k of Eq. 42 [m/s per J/(kg m)]. Up to 1/(dCOT/dU) along the cheapest gaits, |U - U_e| holds the speed exactly where it
# is expected: 0.12 for HyperTuna at 0.5 m/s, more at lower speeds (docs/optimize.md). Less than half of it is safe.
WEIGHT = 0.05


def choose_objective(
    *, maximize: str | None = None, minimize: str | None = None, speed: float | None = None, weight: float | None = None
) -> Objective:
    """Return the objective that the arguments of `optimize` describe."""
    options = {"maximize": maximize, "minimize": minimize, "speed": speed}
    given = [key for key, value in options.items() if value is not None]
    if len(given) != 1:
        fix = "give --maximize speed, --speed 0.4 or --minimize cost_of_transport"
        rule = "must be one of maximize, minimize and speed"
        raise InputError(rule, key="objective", value=" and ".join(given) or "none", fix=fix)
    if speed is not None:
        return expected_speed(speed, WEIGHT if weight is None else weight)
    if weight is not None:
        raise InputError("applies only to an expected speed", key="weight", fix="leave it out, or give --speed")
    return objective(maximize or minimize or "", maximize=maximize is not None)


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
    """Find the gait that is best for an objective.

    Parameters
    ----------
    robot : Robot
    maximize, minimize : str, optional
        Quantity to maximize or minimize. Exactly one of `maximize`, `minimize` and `speed` must be given.
    speed : float, optional
        Expected speed U_e; the objective is ``|U - U_e| + k COT`` (Eq. 42) [m/s].
    weight : float, optional
        Weight k of the cost of transport [m/s per J/(kg m)].
    bounds : mapping, optional
        Bounds by name, ``{"frequency_hz": (1, 4)}``, that replace those of the robot's file [Hz or deg].
    limits : sequence of Limit
        From `gait_limits`.
    method : {"pso", "cma", "gradient", "de"}
        Particle swarm, CMA-ES, multi-start SQP with exact derivatives, or differential evolution.
    particles : int, optional
        Gaits per batch; number of starts of "gradient".
    iterations : int, optional
        Max number of batches.
    robust : {"mean", "worst5"}, optional
        Take the objective as its mean, or the mean of its worst 5 %, over robots sampled from the robot's fit. Every
        one of them must keep the limits. The swim of the result is that of the robot itself.
    samples : int
        Number of robots to sample.
    seed : int
        The same seed gives the same result.
    steps : int
        Runge-Kutta steps per beat, a multiple of 4.
    checkpoint : str or Path, optional
        File to keep the search in, and to resume it from.
    progress : callable, optional
        Called after every batch with the number of gaits evaluated and its maximum.

    Returns
    -------
    Optimum
        Its gait is None if no gait satisfies all limits; `stop` then names the limits.

    Raises
    ------
    InputError
        If an argument cannot be used.

    Examples
    --------
    >>> import hypertuna as ht
    >>> best = ht.optimize(ht.load("hypertuna"), maximize="speed", method="gradient")
    >>> round(best.speed, 3), round(best.gait.frequency, 3)
    (0.582, 6.0)
    """
    check_steps(steps)
    target = choose_objective(maximize=maximize, minimize=minimize, speed=speed, weight=weight)
    problem = Problem(robot, gait_bounds(robot, bounds), (target,), tuple(limits), steps)
    optimizer, max_evaluations = make_optimizer(problem, method, particles, iterations, seed)
    start = time.monotonic()  # of the search, not of the import of libraries
    options = _journal_options(problem, method, particles, iterations, seed)
    if robust is not None:
        problem = over_fit(problem, robust, samples=samples, seed=seed)
        options |= {"robust": robust, "samples": samples}
    with Journal(checkpoint, journal_header("optimize", robot, options)) as journal:
        while (stop := optimizer.stop) is None:
            x = optimizer.ask()
            quantities = journal.answer(x, partial(problem.swim, x, derivatives=optimizer.needs_derivatives))
            optimizer.tell(problem.judge(x, quantities))
            if progress is not None:
                count, robots = optimizer.evaluations, len(problem.robots)
                progress(count * robots, max(max_evaluations, count) * robots)
    return make_optimum(problem, optimizer, method=method, seed=seed, stop=stop, seconds=time.monotonic() - start)


def make_optimizer(
    problem: Problem, method: str, particles: int | None, iterations: int | None, seed: int
) -> tuple[Optimizer, int]:
    """Return the optimizer of a method for a problem with one objective, and its max number of evaluations."""
    if method not in METHODS:
        fix = did_you_mean(method, METHODS)
        raise InputError("must be a method", key="method", value=shown(method), fix=fix)
    default_size, default_batches = SIZES[method]
    size, batches = particles or default_size, iterations or default_batches
    for key, value, low in (("particles", particles, MIN_PARTICLES[method]), ("iterations", iterations, 1)):
        if value is not None and not low <= value <= MAX_SIZE:
            raise InputError(f"must be from {low} to {MAX_SIZE}", key=key, value=str(value), fix="or leave it out")
    if not 0 <= seed < 2**32:
        raise InputError("must be from 0 to 4294967295", key="seed", value=str(seed), fix="take 1")
    lower, upper = problem.space.lower, problem.space.upper
    if method == "cma" and len(lower) < 2:
        rule, fix = (
            "must support a search with one free gait parameter",
            "use pso, gradient or de, or free a second parameter",
        )
        raise InputError(rule, key="method", value="'cma', which varies at least two", fix=fix)
    if method == "cma":
        strategy = CMAES(lower, upper, particles=size, iterations=batches, seed=seed)
        return strategy, strategy.particles * batches
    assert size is not None  # of the others a default
    if method == "gradient":
        return _multi_start(problem, starts=size, iterations=batches, seed=seed), size * batches
    make = pso if method == "pso" else de
    return make(lower, upper, particles=size, iterations=batches, seed=seed), size * batches


def _multi_start(problem: Problem, *, starts: int, iterations: int, seed: int) -> MultiStart:
    """Return SQP from several starts, if all quantities have derivatives."""
    if problem.non_differentiable:
        rule = f"must not need derivatives, which are not available for {' and '.join(problem.non_differentiable)}"
        raise InputError(rule, key="method", value="'gradient'", fix="use pso, cma or de")
    space, target = problem.space, problem.objectives[0]
    # Differences in value are scaled to what matters: to the cost of transport beside |U - U_e|.
    scale = target.terms[0][1] if target.expected is not None and target.terms[0][1] > 0 else 1.0
    sizes = {"starts": starts, "iterations": iterations, "seed": seed}
    return MultiStart(space.lower, space.upper, target.expected, scale, **sizes)


def _journal_options(
    problem: Problem, method: str, particles: int | None, iterations: int | None, seed: int
) -> dict[str, Any]:
    """Return all that the course of a search depends on besides the robot, for the header of its journal."""
    space = problem.space
    return {
        "objectives": [asdict(each) for each in problem.objectives],
        "bounds": {name: [low, high] for name, low, high in zip(space.columns, space.low, space.high, strict=True)},
        "limits": [asdict(limit) for limit in problem.limits],
        "method": method,
        "particles": particles,
        "iterations": iterations,
        "seed": seed,
        "steps": problem.steps,
    }
