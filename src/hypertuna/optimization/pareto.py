"""Pareto fronts of gaits: the best compromises between two or three objectives, found by NSGA-II and polished."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, shown
from hypertuna.io.checkpoint import Journal
from hypertuna.optimization.constraints import Limit, gait_limits
from hypertuna.optimization.design_space import Space, gait_bounds
from hypertuna.optimization.nsga2 import Evolution, hypervolume, nondominated
from hypertuna.optimization.objective import Evaluation, Goal, Problem, goal
from hypertuna.optimization.polish import MOST_ROUNDS, Descent, descend, stationarity
from hypertuna.optimization.robust import WAYS, How, RobustProblem, over_fit
from hypertuna.swimming.beat import DEFAULT_STEPS, QUANTITIES, check_steps
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.sweep import sweep

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Front", "pareto"]

Array = NDArray[np.float64]

SLOW = 0.1  # body lengths per second: the slowest gait of a front, where the user says no other
WIDE = 1.5  # of the mean distance between neighbors: wider gaps of a front are filled
MOST = 10_000  # gaits of a generation, and generations
BEYOND = 0.1  # of its range: how far the reference point lies beyond the worst of the front


@dataclass(frozen=True)
class Front:
    """Gaits of which none is better than another in every objective.

    Attributes
    ----------
    robot : Robot
    space : Space
        Where they were sought.
    objectives : tuple of str
        Their names, of `hypertuna.optimization.objective.OBJECTIVES`.
    x : ndarray, shape (points, dim)
        Points of the space, by the first objective from worst to best [Hz or rad].
    values : ndarray, shape (points, objectives)
        Of the objectives, over the draws of a robust front [unit of each].
    evolved : ndarray, shape (evolved points, objectives)
        The same as NSGA-II left them, before polishing [unit of each].
    stationarity : ndarray, shape (points,)
        Residual of the Karush-Kuhn-Tucker conditions relative to the objectives' steepest slope: 0 where no direction
        improves all objectives, at most 1; not numbers without derivatives [1].
    reference : ndarray, shape (objectives,)
        Reference point of the hypervolumes [unit of each].
    hypervolume_evolved, hypervolume : float
        Before and after polishing [product of the units].
    polished : bool
        Whether the points were polished.
    evaluations : int
        Gaits swum by the search, of a robust one by every robot drawn, those of a checkpoint included.
    seconds : float
        Time that it took [s].
    stop : str
        Why it ended, in a sentence.
    robust : {"mean", "worst5"} or None
        How the objectives are taken over draws of the robot's fit.
    """

    robot: Robot
    space: Space
    objectives: tuple[str, ...]
    x: Array
    values: Array
    evolved: Array
    stationarity: Array
    reference: Array
    hypervolume_evolved: float
    hypervolume: float
    polished: bool
    evaluations: int
    seconds: float
    stop: str
    robust: How | None = None

    @property
    def gaits(self) -> tuple[Gait, ...]:
        """The gaits at the points."""
        return tuple(self.space.gait(x) for x in self.x)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the objectives."""
        return tuple(QUANTITIES[name].unit for name in self.objectives)

    @cached_property
    def points(self) -> xr.Dataset:
        """All quantities of the gaits as `sweep` finds them for the robot itself, and the figures above."""
        found = sweep(self.robot, self.gaits, threads=1)
        told: dict[str, Any] = {"stationarity": (self.stationarity, "1", "residual of the conditions of optimality")}
        for name, unit, values in zip(self.objectives, self.units, self.values.T, strict=True):
            if self.robust is not None:
                meaning = f"{WAYS[self.robust]}, of the draws: {QUANTITIES[name].meaning}"
                told[f"{name}_{self.robust}"] = (values, unit, meaning)
        labeled = {name: ("gait", v, {"units": unit, "long_name": text}) for name, (v, unit, text) in told.items()}
        facts = {"hypervolume": self.hypervolume, "hypervolume_evolved": self.hypervolume_evolved, "stop": self.stop}
        facts |= {f"reference_{name}": float(r) for name, r in zip(self.objectives, self.reference, strict=True)}
        facts |= {"objectives": " ".join(self.objectives), "evaluations": self.evaluations}
        return found.assign(labeled).assign_attrs(facts)


def pareto(
    robot: Robot,
    objectives: Sequence[str] = ("speed", "cost_of_transport"),
    *,
    population: int = 40,
    generations: int = 60,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    limits: Sequence[Limit] = (),
    min_speed: float | None = None,
    polish: bool = True,
    robust: str | None = None,
    samples: int = 32,
    seed: int = 1,
    steps: int = DEFAULT_STEPS,
    threads: int = 1,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Front:
    """Find the best compromises between two or three objectives.

    NSGA-II (Deb et al., 2002) swims each generation in one batch. Each point of its front then descends in the last
    objective with the others held, by exact derivatives, the ends of the front go as far as they can, and
    wide gaps between two objectives are filled.

    Parameters
    ----------
    robot : Robot
    objectives : sequence of str
        Two or three of `hypertuna.optimization.objective.OBJECTIVES`, which says whether large or small is good.
    population, generations : int
        Of NSGA-II.
    bounds : mapping, optional
        Lowest and highest values beside those of the robot's table ``[gait_bounds]``, as for
        `hypertuna.optimization.design_space.gait_bounds` [Hz or deg].
    limits : sequence of Limit
        What every gait must keep.
    min_speed : float, optional
        The slowest speed allowed [m/s]; a tenth of a body length per second if left out. Near rest the model's cost of
        transport goes to zero with the square of the speed, and a front would end in gaits that hardly move.
    polish : bool
        Whether to polish.
    robust : {"mean", "worst5"}, optional
        Take every objective as its mean, or the mean of its worst 5 %, over robots drawn from the robot's fit, each of
        which must keep the limits.
    samples : int
        Robots to draw.
    seed : int
        Of NSGA-II and of the draws.
    steps, threads : int
        Runge-Kutta steps per beat, and threads; the result does not depend on the latter.
    checkpoint : str or Path, optional
        Journal to keep, and to resume from after any end.
    progress : callable, optional
        Called with what is done and the total, now and then.

    Returns
    -------
    Front

    Raises
    ------
    InputError
        If an argument cannot be used, or the robot has no fit to draw from.
    """
    start = time.perf_counter()
    check_steps(steps)
    names = tuple(objectives)
    goals = _goals(names)
    for key, value, least, most in (
        ("population", population, 2, MOST),
        ("generations", generations, 1, MOST),
        ("seed", seed, 0, 2**32 - 1),
    ):
        if not least <= value <= most:
            raise InputError(f"must be from {least} to {most}", key=key, value=str(value), fix="or leave it out")
    slow = SLOW * robot.body.length if min_speed is None else min_speed
    if not (np.isfinite(slow) and slow >= 0):
        raise InputError("must not be negative", key="min_speed", value=f"{slow:g}", fix="give it in m/s, or 0")
    slowest = gait_limits(robot, speed=slow) if slow > 0 else ()
    problem = Problem(robot, gait_bounds(robot, bounds), goals, (*limits, *slowest), steps, threads)
    wished = problem if robust is None else over_fit(problem, robust, samples=samples, seed=seed)
    options = {
        "objectives": names,
        "population": population,
        "generations": generations,
        "low": problem.space.low,
        "high": problem.space.high,
        "limits": [(limit.quantity, limit.limit, limit.upper) for limit in problem.limits],
        "polish": polish,
        "robust": robust,
        "samples": samples if robust else 0,
        "seed": seed,
        "steps": steps,
    }
    with Journal(checkpoint, journal_header("pareto", robot, options)) as journal:
        recorded = _Recorded(wished, journal, progress or (lambda done, total: None), generations)
        evolved, stop = _evolve(recorded, population, generations, seed)
        rough = problem.rough
        polished = _polished(recorded, evolved) if polish and not rough and len(evolved.x) else evolved
        found = polished.rows(np.argsort(-polished.value[:, 0], kind="stable"))
        rest = np.nan if rough else stationarity(recorded, recorded.evaluate(found.x, slopes=True), _scale(evolved))
        recorded.finish()
    sign = np.array([target.terms[0][1] for target in goals])
    worst = evolved.value.max(axis=0) + BEYOND * _scale(evolved) if len(evolved.x) else np.full(len(names), np.nan)
    return Front(
        robot=robot,
        space=problem.space,
        objectives=names,
        x=found.x,
        values=sign * found.value,
        evolved=sign * evolved.value,
        stationarity=np.broadcast_to(rest, len(found.x)),
        reference=sign * worst,
        hypervolume_evolved=hypervolume(evolved.value, worst),
        hypervolume=hypervolume(found.value, worst),
        polished=polished is not evolved,
        evaluations=recorded.evaluations,
        seconds=time.perf_counter() - start,
        stop=f"{stop} {_told(evolved, found, polish, rough)}",
        robust=wished.how if isinstance(wished, RobustProblem) else None,
    )


class _Recorded:
    """A problem whose evaluations a journal keeps, and that reports progress and counts."""

    def __init__(
        self, problem: Problem | RobustProblem, journal: Journal, progress: Callable[[int, int], None], batches: int
    ) -> None:
        self.problem, self.space, self.evaluations = problem, problem.space, 0
        self._journal, self._progress, self._done, self._total = journal, progress, 0, batches + 2 * MOST_ROUNDS

    def evaluate(self, x: Array, *, slopes: bool = False) -> Evaluation:
        """Evaluate, or take from the journal."""
        names = ("value", "violation") + ("value_slopes", "violation_slopes") * slopes

        def work() -> dict[str, Any]:
            found = self.problem.evaluate(x, slopes=slopes)
            return {name: getattr(found, name) for name in names}

        told = self._journal.answer({"x": x, "slopes": slopes}, work)
        self.evaluations += len(x) * len(self.problem.robots)
        self._done += 1
        self._progress(self._done, self._total)
        return Evaluation(x, found={}, **{name: np.array(told[name], dtype=np.float64) for name in names})

    def finish(self) -> None:
        """Report that all is done."""
        self._progress(self._total, self._total)


def _goals(names: Sequence[str]) -> tuple[Goal, ...]:
    """Make the goals of the objectives."""
    goals = tuple(goal(name, key="objectives") for name in names)
    if len(names) not in (2, 3) or len(set(names)) < len(names):
        fix = "give them separated by commas, such as speed,cost_of_transport"
        raise InputError("must be two or three different ones", key="objectives", value=shown(",".join(names)), fix=fix)
    return goals


def _evolve(problem: _Recorded, population: int, generations: int, seed: int) -> tuple[Evaluation, str]:
    """Run NSGA-II; return its front and why it stopped."""
    space = problem.space
    goals, limits = len(problem.problem.goals), len(problem.problem.limits)
    sizes = {"population": population, "generations": generations, "seed": seed}
    evolution = Evolution(space.lower, space.upper, goals, limits, **sizes)
    while evolution.stop is None:
        evolution.tell(problem.evaluate(evolution.ask()))
    return evolution.result, str(evolution.stop)


def _polished(problem: _Recorded, evolved: Evaluation) -> Evaluation:
    """Send the ends of a front as far as they go, let every point descend with the other objectives held, fill gaps."""
    goals = evolved.value.shape[1]
    descents = [Descent(evolved.x[np.argmin(evolved.value[:, k])], k, np.full(goals, np.inf)) for k in range(goals)]
    descents += [_held(x, value) for x, value in zip(evolved.x, evolved.value, strict=True)]
    found = _best(evolved, problem.evaluate(descend(problem, descents, _scale(evolved))))
    if goals > 2 or not (gaps := _gaps(found)):  # the points of a surface have no neighbors to look between
        return found
    return _best(found, problem.evaluate(descend(problem, gaps, _scale(found))))


def _held(x: Array, value: Array) -> Descent:
    """Descent in the last objective with the others held at what they are."""
    return Descent(x, len(value) - 1, np.append(value[:-1], np.inf))


def _gaps(found: Evaluation) -> list[Descent]:
    """Descents from between neighbors of a curve that are far apart: as many as make that distance usual."""
    found = found.rows(np.argsort(found.value[:, 0], kind="stable"))
    apart = np.linalg.norm(np.diff(found.value, axis=0) / _scale(found), axis=1)
    descents = []
    for k, parts in enumerate(np.ceil(apart / (WIDE * apart.mean())).astype(int)) if len(apart) else ():
        for part in np.arange(1, parts) / parts:
            x, value = (ends[k] + part * (ends[k + 1] - ends[k]) for ends in (found.x, found.value))
            descents.append(_held(x, value))
    return descents


def _best(one: Evaluation, other: Evaluation) -> Evaluation:
    """Keep of two fronts what keeps all limits and nothing dominates."""
    found = one.followed_by(other)
    kept = np.flatnonzero(found.feasible)
    return found.rows(kept[nondominated(found.value[kept])])


def _scale(evolved: Evaluation) -> Array:
    """Range of a front in each objective; where all points share a value, its size."""
    if not len(evolved.x):
        return np.ones(evolved.value.shape[1])
    size = np.maximum(np.abs(evolved.value[0]), 1e-300)
    span = np.ptp(evolved.value, axis=0)
    return np.asarray(np.where(span > 0, span, size))


def _told(evolved: Evaluation, found: Evaluation, polish: bool, rough: Sequence[str]) -> str:
    """Say what became of the polishing."""
    if not len(evolved.x):
        return "No gait kept all limits."
    if not polish:
        return "Its front was left unpolished, as wished."
    if rough:
        return f"Its front was left unpolished: there are no exact derivatives of {' and '.join(rough)}."
    kept = {x.tobytes() for x in evolved.x}
    moved = sum(x.tobytes() not in kept for x in found.x)
    return f"Gradients made of its {len(evolved.x)} gaits a front of {len(found.x)}, {moved} of them new."
