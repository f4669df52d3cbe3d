"""Pareto fronts of gaits: the best compromises between two or three objectives, found by NSGA-II, then polished."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, shown
from hypertuna.io.checkpoint import Journal
from hypertuna.optimization.constraints import Limit, gait_limits
from hypertuna.optimization.design_space import DesignSpace, gait_bounds
from hypertuna.optimization.objective import Evaluation, objective
from hypertuna.optimization.optimize import SEEDS
from hypertuna.optimization.optimizers import hypervolume, nsga2, pareto_front
from hypertuna.optimization.polish import MAX_ROUNDS, Target, run_targets, stationarity
from hypertuna.optimization.problem import STATISTICS, Problem, over_fit
from hypertuna.ranges import NOT_NEGATIVE, Whole
from hypertuna.swimming.beat import DEFAULT_STEPS, QUANTITIES, check_steps
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.sweep import sweep

if TYPE_CHECKING:
    import xarray as xr

SLOW = 0.1  # default min speed of a front [body lengths/s]
WIDE = 1.5  # gaps wider than this many mean distances between neighbors are filled
RANGES = {"population": Whole(min=2, max=10_000), "generations": Whole(min=1, max=10_000), "seed": SEEDS}
BEYOND = 0.1  # distance of the reference point beyond the worst values of the front, over the front's range


@dataclass(frozen=True)
class Front(Plotted, Tabular, data=lambda front: front.points):
    """Nondominated gaits: none is better than another in every objective."""

    robot: Robot
    space: DesignSpace
    objectives: tuple[str, ...]  # names of `hypertuna.optimization.objective.OBJECTIVES`
    x: Array  # (points, dim), sorted by the first objective from worst to best [Hz or rad]
    values: Array  # (points, objectives); in a robust front, statistics over the sampled robots [unit of each]
    evolved: Array  # (evolved points, objectives), values of NSGA-II's front before polishing [unit of each]
    # (points,) residual of the Karush-Kuhn-Tucker conditions: 0 if no direction improves all objectives, 1 at most;
    # NaN without derivatives [1]
    stationarity: Array
    reference: Array  # (objectives,) reference point of the hypervolumes [unit of each]
    hypervolume_evolved: float  # before polishing [product of the units]
    hypervolume: float  # hypervolume of the front [product of the units]
    polished: bool
    evaluations: int  # gaits swum by all robots, those of a checkpoint included
    seconds: float  # duration of this run [s]
    stop: str  # why the search ended, as a sentence
    robust: str | None = None  # statistic of the objectives over robots sampled from the fit

    @property
    def gaits(self) -> tuple[Gait, ...]:
        """The gaits at the points."""
        return tuple(self.space.gait(x) for x in self.x)

    @property
    def designs(self) -> dict[str, Array]:
        """Values of the robot's variables at the points (points,) by name [unit of the file]."""
        columns = np.array([self.space.design(x) for x in self.x]).reshape(len(self.x), len(self.space.variables))
        return dict(zip([variable.name for variable in self.space.variables], columns.T, strict=True))

    @property
    def robots(self) -> tuple[Robot, ...]:
        """The robot at each point; without variables, all are the same robot."""
        return tuple(self.space.robot(self.robot, x, made_by="hypertuna pareto") for x in self.x)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the objectives."""
        return tuple(QUANTITIES[name].unit for name in self.objectives)

    @cached_property
    def points(self) -> xr.Dataset:
        """Data set of all quantities of the gaits, as `sweep` computes them for the robot itself, and of the front."""
        attributes = {"units": "1", "long_name": "residual of the optimality conditions"}
        variables: dict[str, Any] = {"stationarity": ("gait", self.stationarity, attributes)}
        if self.robust is not None:
            for name, unit, values in zip(self.objectives, self.units, self.values.T, strict=True):
                attributes = {"units": unit, "long_name": f"{STATISTICS[self.robust]}: {QUANTITIES[name].meaning}"}
                variables[f"{name}_{self.robust}"] = ("gait", values, attributes)
        facts = {"hypervolume": self.hypervolume, "hypervolume_evolved": self.hypervolume_evolved, "stop": self.stop}
        facts |= {f"reference_{name}": float(r) for name, r in zip(self.objectives, self.reference, strict=True)}
        facts |= {"objectives": " ".join(self.objectives), "evaluations": self.evaluations}
        for variable in self.space.variables:
            attributes = variable.attributes | {"key": variable.name}
            variables[variable.label] = ("gait", self.designs[variable.name], attributes)
        return self._swims().assign(variables).assign_attrs(facts)

    def _swims(self) -> xr.Dataset:
        """Return the sweep of all gaits, each swum by its robot."""
        if not self.space.variables or not len(self.x):
            return sweep(self.robot, self.gaits, threads=1, check_rest=True)
        import xarray as xr

        pairs = zip(self.robots, self.gaits, strict=True)
        swims = [sweep(robot, [gait], threads=1, check_rest=True) for robot, gait in pairs]
        return xr.concat(swims, "gait", combine_attrs="override").assign_attrs(provenance(self.robot))


@checked
def pareto(
    robot: Robot | str | Path,
    objectives: Sequence[str] = ("speed", "cost_of_transport"),
    *,
    population: int = 40,
    generations: int = 60,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    design: Mapping[str, tuple[float, float]] | None = None,
    limits: Sequence[Limit] = (),
    min_speed: float | None = None,
    polish: bool = True,
    robust: str | None = None,
    samples: int = 32,
    seed: int = 1,
    steps: int = DEFAULT_STEPS,
    threads: int = 1,
    executor: Executor | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Front:
    """Find the best compromises between two or three objectives.

    NSGA-II (Deb et al., 2002) swims each generation in one batch. SQP with exact derivatives then improves each point
    of the front in the last objective with the others held, extends the ends of the front, and fills wide gaps between
    two objectives.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    objectives : sequence of str
        Two or three quantities; each is minimized or maximized, whichever is better.
    population, generations : int
        Population and number of generations of NSGA-II.
    bounds, design, limits, robust, samples, executor, checkpoint
        As in `optimize` [Hz or deg].
    min_speed : float, optional
        Min speed; a tenth of a body length per second by default. Near rest the model's cost of transport goes to
        zero with the square of the speed, and a front would end in gaits that hardly move [m/s].
    polish : bool
        Whether to polish the front.
    seed, steps, threads : int
        Seed of NSGA-II and of the samples; Runge-Kutta steps per beat; threads, on which the result does not depend.
    progress : callable, optional
        Called after every batch with the number of batches and its maximum.

    Returns
    -------
    Front

    Raises
    ------
    InputError
        If an argument cannot be used, or the robot has no fit to sample.
    """
    robot = robot_of(robot)
    start = time.perf_counter()
    check_steps(steps)
    names = tuple(objectives)
    targets = tuple(objective(name, key="objectives") for name in names)
    if len(names) not in (2, 3) or len(set(names)) < len(names):
        rule, fix = "must name two or three different quantities", "take speed and cost_of_transport, for example"
        raise InputError(rule, key="objectives", value=shown(",".join(names)), fix=fix)
    sizes = {"population": population, "generations": generations, "seed": seed}
    for key, value in sizes.items():
        RANGES[key].check(value, key, "leave it out for the default")
    lowest_speed = SLOW * robot.body.length if min_speed is None else min_speed
    NOT_NEGATIVE.check(lowest_speed, "min_speed", "give it in m/s, or 0")
    speed_limit = gait_limits(robot, speed=lowest_speed) if lowest_speed > 0 else ()
    problem = Problem(
        robot, gait_bounds(robot, bounds, design), targets, (*limits, *speed_limit), steps, threads, executor=executor
    )
    if robust is not None:
        problem = over_fit(problem, robust, samples=samples, seed=seed)
    total = generations + 2 * MAX_ROUNDS

    def report(batches: int) -> None:
        if progress is not None:
            progress(batches, total)

    options = problem.options | sizes | {"polish": polish, "robust": robust, "samples": samples if robust else 0}
    with Journal(checkpoint, journal_header("pareto", robot, options)) as journal:
        recorded = _Recorded(problem, journal, report)
        search = nsga2(problem.space.lower, problem.space.upper, len(names), **sizes)
        while search.stop is None:
            search.tell(recorded.evaluate(search.ask()))
        assert search.result is not None  # at least one batch was told
        evolved = search.result
        without_derivatives = problem.non_differentiable
        polished = _polished(recorded, evolved) if polish and not without_derivatives and len(evolved.x) else evolved
        front = polished.rows(np.argsort(-polished.value[:, 0], kind="stable"))
        residual: Any = np.nan
        if len(front.x) and not without_derivatives:
            residual = stationarity(recorded, recorded.evaluate(front.x, derivatives=True), _scale(evolved))
        report(total)
    refusal = "" if len(evolved.x) else problem.refusal(recorded.last)
    sign = np.array([target.terms[0][1] for target in targets])
    reference = evolved.value.max(axis=0) + BEYOND * _scale(evolved) if len(evolved.x) else np.full(len(names), np.nan)
    return Front(
        robot=robot,
        space=problem.space,
        objectives=names,
        x=front.x,
        values=sign * front.value,
        evolved=sign * evolved.value,
        stationarity=np.broadcast_to(residual, len(front.x)),
        reference=sign * reference,
        hypervolume_evolved=hypervolume(evolved.value, reference),
        hypervolume=hypervolume(front.value, reference),
        polished=polished is not evolved,
        evaluations=recorded.evaluations,
        seconds=time.perf_counter() - start,
        stop=f"{search.stop} {_polish_sentence(evolved, front, polish, without_derivatives)} {refusal}".rstrip(),
        robust=problem.robust,
    )


class _Recorded:
    """A problem whose evaluations are kept in a journal, counted and reported as progress."""

    def __init__(self, problem: Problem, journal: Journal, report: Callable[[int], None]) -> None:
        self.problem, self.space, self.evaluations = problem, problem.space, 0
        self._journal, self._report, self._batches = journal, report, 0

    def evaluate(self, x: Array, *, derivatives: bool = False) -> Evaluation:
        """Return values and violations at points (points, dim), computed or from the journal."""
        names = ("value", "violation") + ("value_jacobian", "violation_jacobian") * derivatives

        def work() -> dict[str, Any]:
            evaluation = self.problem.evaluate(x, derivatives=derivatives)
            return {name: getattr(evaluation, name) for name in names}

        columns = self._journal.answer({"x": x, "derivatives": derivatives}, work)
        self.evaluations += len(x) * len(self.problem.robots)
        self.last = x[-1]
        self._batches += 1
        self._report(self._batches)
        return Evaluation(x, quantities={}, **{name: np.array(columns[name], dtype=np.float64) for name in names})


def _polished(problem: _Recorded, evolved: Evaluation) -> Evaluation:
    """Polish a front: extend its ends, improve its points in the last objective, and fill its gaps."""
    count = evolved.value.shape[1]
    targets = [Target(evolved.x[np.argmin(evolved.value[:, k])], k, np.full(count, np.inf)) for k in range(count)]
    targets += [_held_target(x, value) for x, value in zip(evolved.x, evolved.value, strict=True)]
    polished = problem.evaluate(run_targets(problem, targets, _scale(evolved)))
    front = pareto_front(evolved.followed_by(polished))
    if count > 2 or not (gaps := _gap_targets(front)):  # points of a surface have no order of neighbors
        return front
    return pareto_front(front.followed_by(problem.evaluate(run_targets(problem, gaps, _scale(front)))))


def _held_target(x: Array, value: Array) -> Target:
    """Return a search from x that minimizes the last objective with the others held at their values."""
    return Target(x, len(value) - 1, np.append(value[:-1], np.inf))


def _gap_targets(front: Evaluation) -> list[Target]:
    """Return searches that start in the gaps of a front: between neighbors more than WIDE mean distances apart."""
    front = front.rows(np.argsort(front.value[:, 0], kind="stable"))
    distance = np.linalg.norm(np.diff(front.value, axis=0) / _scale(front), axis=1)
    targets = []
    for k, parts in enumerate(np.ceil(distance / (WIDE * distance.mean())).astype(int)) if len(distance) else ():
        for fraction in np.arange(1, parts) / parts:
            x, value = (ends[k] + fraction * (ends[k + 1] - ends[k]) for ends in (front.x, front.value))
            targets.append(_held_target(x, value))
    return targets


def _scale(front: Evaluation) -> Array:
    """Return the range (objectives,) of a front in each objective; if all points share a value, its magnitude."""
    if not len(front.x):
        return np.ones(front.value.shape[1])
    magnitude = np.maximum(np.abs(front.value[0]), 1e-300)
    span = np.ptp(front.value, axis=0)
    return np.asarray(np.where(span > 0, span, magnitude))


def _polish_sentence(evolved: Evaluation, front: Evaluation, polish: bool, rough: Sequence[str]) -> str:
    """Return a sentence on the effect of polishing, or on the reason why it was left out."""
    if not len(evolved.x):
        return "No gait satisfied all limits."
    if not polish:
        return "Polishing was disabled."
    if rough:
        return f"The front was not polished: there are no exact derivatives of {' and '.join(rough)}."
    evolved_points = {x.tobytes() for x in evolved.x}
    new_count = sum(x.tobytes() not in evolved_points for x in front.x)
    return f"Polishing turned its {len(evolved.x)} gaits into a front of {len(front.x)}, {new_count} of them new."
