"""Optimization by experiment: the optimizer asks for gaits, a tank measures them, and a file keeps the state."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.optimization.constraints import Limit, gait_quantities
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.optimize import choose_objective, make_optimizer
from hypertuna.optimization.problem import Problem
from hypertuna.optimization.state import TankState
from hypertuna.swimming.gait import Gait
from hypertuna.trials.steady import MEASURED, SteadyRun

SAME = 1e-4  # gaits count as the same if no value differs by more than this part of its range
# Options of a search in its first call: the robot's name or file, limits as fields of `Limit`, arguments of `optimize`.
GOALS = ("maximize", "minimize", "speed", "weight")
OPTIONS = ("robot", *GOALS, "bounds", "limits", "method", "particles", "iterations", "seed")


class TankSearch(TankState):
    """A search for the best gait whose points a tank evaluates."""

    kind, names = "experiment", frozenset(OPTIONS)
    command, example = "optimize ask", "--robot fish.toml --maximize speed"

    def _begin(self, path: str | Path | None, options: Mapping[str, Any]) -> Robot:
        """Set up problem and optimizer from the options; return the robot."""
        self.problem = _problem(options)
        sizes = (options[name] for name in ("particles", "iterations", "seed"))
        self.optimizer = make_optimizer(self.problem, options["method"], *sizes)
        self._measured: dict[int, dict[str, float]] = {}  # measured points of the batch, by their index in it
        self._batch = self.optimizer.ask()
        return self.problem.robot

    @property
    def best(self) -> SteadyRun | None:
        """Best gait of the complete batches, with its measurements; None if no gait is feasible."""
        best = self.optimizer.result
        if best is None or not best.feasible[0]:
            return None
        measured = {name: float(best.quantities[name][0]) for name in MEASURED}
        numbers: dict[str, Any] = {name: value for name, value in measured.items() if not np.isnan(value)}
        return SteadyRun("best", self.problem.space.gait(best.x[0]), **numbers)

    def ask(self) -> dict[str, Gait]:
        """Return the gaits of the batch that are not measured yet, by name such as ``batch-3-gait-07``."""
        return {self._name(k): self.problem.space.gait(self._batch[k]) for k in self._open_points()}

    def tell(self, runs: Sequence[SteadyRun]) -> int:
        """Take runs of gaits that `ask` returned; return the number of gaits of this batch that are still to measure.

        If a run is of another gait, or lacks a quantity of the objective, none of the runs is kept.
        """
        open_points = self._open_points()
        measured: dict[int, dict[str, float]] = {}
        for run in runs:
            k = self._index(run, [k for k in open_points if k not in measured])
            measured[k] = self._measurements(run)
        if not measured:
            raise InputError("must have at least one run", key="tell", value="none", fix="give the measured values")
        points = [self._batch[k].tolist() for k in measured]
        self._measured.update(measured)
        self._journal.append({"asked": points, "told": list(measured.values())})
        return self._advance()

    def _open_points(self) -> list[int]:
        """Return the indices of the points of the batch that are not measured yet."""
        return [k for k in range(len(self._batch)) if k not in self._measured] if self.optimizer.stop is None else []

    def _name(self, k: int) -> str:
        """Return the name of gait k in this batch."""
        return f"batch-{len(self.optimizer.batches) + 1}-gait-{k + 1:02d}"

    def _index(self, run: SteadyRun, indices: Sequence[int]) -> int:
        """Return the index of a run's gait in the batch; among equal gaits, that of the run's name or the first."""
        space = self.problem.space
        width = np.where(space.high > space.low, space.high - space.low, 1.0)  # 1 Hz or rad for fixed values
        distances = {k: np.abs(space.gait(self._batch[k]).values - run.gait.values) / width for k in indices}
        matches = [k for k, distance in distances.items() if distance.max() < SAME]
        if not matches:
            rule = "must be a gait of the current batch that is not measured yet"
            fix = "see `hypertuna optimize ask`" if indices else "ask for the next batch"
            raise InputError(rule, **_place(run), fix=fix)
        return next((k for k in matches if self._name(k) == run.name), matches[0])

    def _measurements(self, run: SteadyRun) -> dict[str, float]:
        """Return a run's measurements, which must have all quantities of the objective; others may be NaN."""
        target = self.problem.objectives[0]
        required = {name for name, factor in target.terms if factor}
        required |= set() if target.expected is None else {"speed"}
        values = {name: getattr(run, name) for name in MEASURED}
        for name in sorted(required):
            if values[name] is None:
                rule = f"must have a {name.replace('_', ' ')}, which the objective needs"
                raise InputError(rule, **_place(run), fix="give the measured values")
        return {name: np.nan if value is None else float(value) for name, value in values.items()}

    def _advance(self) -> int:
        """Pass a complete batch to the optimizer; return the number of gaits that are not measured yet."""
        if count := len(self._open_points()):
            return count
        self.optimizer.tell(self.problem.judge(self._batch, self._quantities()))
        self._measured = {}
        if self.optimizer.stop is None:
            self._batch = self.optimizer.ask()
        return 0

    def _quantities(self) -> dict[str, Array]:
        """Return the measured quantities of the whole batch, in the form of a simulation's results."""
        gaits = self.problem.space.gaits(self._batch)
        rows = [self._measured[k] for k in range(len(self._batch))]
        values = {name: np.array([row[name] for row in rows]) for name in MEASURED}
        # An objective may need no speed; without a measured one, the robot is assumed to swim forward.
        speed = np.where(np.isnan(values["speed"]), np.inf, values["speed"])
        values["stride_length"] = np.minimum(speed / (gaits.frequency * self.problem.robot.body.length), 1e6)
        gait_values, _ = gait_quantities(self.problem.robot, gaits)
        return values | gait_values | {"status": np.zeros(len(rows))}

    def _replay(self, record: Mapping[str, Any], place: str) -> None:
        """Take the measurements in a record of the journal as if they were made now."""
        batch = [point.tolist() for point in self._batch]
        points, rows = record.get("asked"), record.get("told")
        pairs: list[Any] = [(None, None)]  # matches no gait
        if isinstance(points, list) and isinstance(rows, list) and len(points) == len(rows):
            pairs = list(zip(points, rows, strict=True))
        for point, row in pairs:
            k = next((k for k in self._open_points() if batch[k] == point), None)
            if k is None or not (isinstance(row, dict) and set(MEASURED) <= row.keys()):
                rule = "holds gaits that are not in this search"
                raise InputError(rule, file=place, fix="use the version of hypertuna that started the search")
            self._measured[k] = row
        self._advance()


def _problem(options: Mapping[str, Any]) -> Problem:
    """Return the optimization problem of the options; refuse quantities that a tank does not measure."""
    robot = load(options["robot"])
    target = choose_objective(**{name: options[name] for name in GOALS})
    limits = tuple(Limit(**limit) for limit in options["limits"])
    problem = Problem(robot, gait_bounds(robot, options["bounds"]), (target,), limits)
    if options["method"] == "gradient":
        rule = "must work without derivatives, which a tank cannot measure"
        raise InputError(rule, key="method", value="'gradient'", fix="use pso, cma or de")
    measurable = {*MEASURED, "stride_length", *gait_quantities(robot, problem.space.gaits([problem.space.lower]))[0]}
    for name in problem.needs:
        if name not in measurable:
            fix = "optimize speed or cost_of_transport, and limit rates or amplitudes"
            raise InputError("must be measured in the tank", key=name, fix=fix)
    return problem


def _place(run: SteadyRun) -> dict[str, str | None]:
    """Return file and line of a run, or its name, as arguments of an error."""
    return {"file": run.file or None, "key": f"line {run.line}" if run.line else run.name}
