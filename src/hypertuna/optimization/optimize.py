"""Search for the best gait for an objective."""

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import NamedTuple

from hypertuna.arguments import checked
from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot, robot_of
from hypertuna.errors import InputError
from hypertuna.io.checkpoint import Journal
from hypertuna.optimization.constraints import Limit
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import Objective, expected_speed, objective
from hypertuna.optimization.optimizers import CMAES, Optimizer, de, pso
from hypertuna.optimization.optimum import Optimum, make_optimum
from hypertuna.optimization.problem import Problem, over_fit
from hypertuna.optimization.sqp import MultiStart
from hypertuna.ranges import Whole, check_choice
from hypertuna.swimming.beat import DEFAULT_STEPS, check_steps


class Method(NamedTuple):
    """Default sizes of an optimization method, and its least number of gaits per batch."""

    size: int | None  # default number of gaits per batch, or of starts; None for pycma's own default
    batches: int  # default of the largest number of batches
    min_size: int  # least number of gaits per batch


METHODS = {  # methods by name
    "gradient": Method(6, 60, 1),
    "pso": Method(15, 60, 2),
    "cma": Method(None, 200, 2),
    "de": Method(15, 60, 4),
}
MAX_SIZE = 10_000  # largest number of gaits per batch, and of batches
SEEDS = Whole(min=0, max=2**32 - 1)  # allowed seeds

# Default weight k of Eq. 42 [m/s per J/(kg m)]. Up to k = 1/(dCOT/dU) along the cheapest gaits, |U - U_e| keeps the
# speed exactly as expected: 0.12 for HyperTuna at 0.5 m/s, more at lower speeds (docs/optimize.md). Half of it is safe.
WEIGHT = 0.05


def choose_objective(
    *, maximize: str | None = None, minimize: str | None = None, speed: float | None = None, weight: float | None = None
) -> Objective:
    """Return the objective that the arguments of `optimize` describe."""
    options = {"maximize": maximize, "minimize": minimize, "speed": speed}
    chosen = [key for key, value in options.items() if value is not None]
    if len(chosen) != 1:
        fix = 'give maximize="speed", speed=0.4 or minimize="cost_of_transport"'
        rule = "must be one of maximize, minimize and speed"
        raise InputError(rule, key="objective", value=" and ".join(chosen) or "none", fix=fix)
    if speed is not None:
        return expected_speed(speed, WEIGHT if weight is None else weight)
    if weight is not None:
        raise InputError("applies only to an expected speed", key="weight", fix="leave it out, or give a speed")
    return objective(maximize or minimize or "", maximize=maximize is not None)


@checked
def optimize(
    robot: Robot | str | Path,
    *,
    maximize: str | None = None,
    minimize: str | None = None,
    speed: float | None = None,
    weight: float | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    design: Mapping[str, tuple[float, float]] | None = None,
    limits: Sequence[Limit] = (),
    method: str | None = None,
    particles: int | None = None,
    iterations: int | None = None,
    robust: str | None = None,
    samples: int = 32,
    seed: int = 1,
    steps: int = DEFAULT_STEPS,
    executor: Executor | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Optimum:
    """Find the best gait for an objective, and the best robot if numbers of its file are variables.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    maximize, minimize : str, optional
        Quantity to maximize or minimize. Exactly one of `maximize`, `minimize` and `speed` must be given.
    speed, weight : float, optional
        Expected speed U_e [m/s] and weight k [m/s per J/(kg m)] of the objective ``|U - U_e| + k COT`` (Eq. 42).
    bounds : mapping, optional
        Bounds by name, ``{"frequency_hz": (1, 4)}``, that replace those of the robot's file [Hz or deg].
    design : mapping, optional
        Bounds of numbers of the robot's file by key [unit of the file], ``{"hinge.stiffness": (0.05, 2)}``. Values
        that depend on a link's length or mass follow it. ``fin.span`` and ``fin.chord``, or ``fin.area`` and
        ``fin.aspect_ratio``, are factors on the caudal fin. `robot` of the result is the best robot.
    limits : sequence of Limit
        From `gait_limits`.
    method : {"gradient", "pso", "cma", "de"}, optional
        Multi-start SQP with exact derivatives, particle swarm, CMA-ES, or differential evolution. By default
        "gradient", or "pso" for quantities without derivatives: efficiency, the largest bend of a hinge.
    particles, iterations : int, optional
        Gaits per batch (number of starts of "gradient"), and max number of batches.
    robust : {"mean", "worst5"}, optional
        Minimize the mean of the objective, or the mean of its worst 5 %, over robots sampled from the robot's fit. All
        of these robots must keep the limits. The swim of the result is that of the robot itself.
    samples, seed, steps : int
        Number of robots to sample; seed of all random numbers; Runge-Kutta steps per beat, a multiple of 4.
    executor : concurrent.futures.Executor, optional
        Where to swim the gaits of a batch, 16 per task. A gait takes 30 us and a task of Dask 2 to 4 ms, so an executor
        pays off for the many robots of `robust`, or for thousands of particles.
    checkpoint : str or Path, optional
        File that keeps the search, and from which the search resumes.
    progress : callable, optional
        Called after every batch with the number of gaits evaluated and its maximum.

    Returns
    -------
    Optimum
        Its gait is None if no gait satisfies all limits; `stop` then names the limits.

    Examples
    --------
    >>> import hypertuna as ht
    >>> best = ht.optimize(ht.load("hypertuna"), maximize="speed")
    >>> round(best.speed, 3), round(best.gait.frequency, 3)
    (0.582, 6.0)
    """
    robot = robot_of(robot)
    check_steps(steps)
    target = choose_objective(maximize=maximize, minimize=minimize, speed=speed, weight=weight)
    problem = Problem(robot, gait_bounds(robot, bounds, design), (target,), tuple(limits), steps, executor=executor)
    method = method or ("pso" if problem.non_differentiable else "gradient")
    optimizer = make_optimizer(problem, method, particles, iterations, seed)
    start = time.monotonic()  # after libraries are imported
    options = problem.options | {"method": method, "particles": particles, "iterations": iterations, "seed": seed}
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
                total = count if optimizer.stop else max(optimizer.max_evaluations, count)
                progress(count * robots, total * robots)
    return make_optimum(problem, optimizer, method=method, seed=seed, stop=stop, seconds=time.monotonic() - start)


def make_optimizer(
    problem: Problem, method: str, particles: int | None, iterations: int | None, seed: int
) -> Optimizer:
    """Return the optimizer of a method for a problem with one objective."""
    default = METHODS[check_choice(method, METHODS, "method")]
    for key, value, low in (("particles", particles, default.min_size), ("iterations", iterations, 1)):
        if value is not None:
            Whole(min=low, max=MAX_SIZE).check(value, key, "leave it out for the default")
    SEEDS.check(seed, "seed", "take 1")
    size, batches = particles or default.size, iterations or default.batches
    lower, upper = problem.space.lower, problem.space.upper
    if method == "cma":
        if len(lower) < 2:
            rule, fix = "must support a search with one free gait parameter", "use pso, gradient or de, or free another"
            raise InputError(rule, key="method", value="'cma', which varies at least two", fix=fix)
        return CMAES(lower, upper, particles=size, iterations=batches, seed=seed)
    assert size is not None  # the other methods have a default
    if method != "gradient":
        make = pso if method == "pso" else de
        return make(lower, upper, particles=size, iterations=batches, seed=seed)
    if problem.non_differentiable:
        rule = f"must work without derivatives, which are not available for {' and '.join(problem.non_differentiable)}"
        raise InputError(rule, key="method", value="'gradient'", fix="use pso, cma or de")
    target = problem.objectives[0]
    # Values are scaled by the weight of the cost of transport, since |U - U_e| is zero at the optimum.
    scale = target.terms[0][1] if target.expected is not None and target.terms[0][1] > 0 else 1.0
    return MultiStart(lower, upper, target.expected, scale, starts=size, iterations=batches, seed=seed)
