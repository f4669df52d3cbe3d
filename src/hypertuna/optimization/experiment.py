"""Optimize by experiment: the optimizer asks for gaits, a tank tells how they swam, and a file keeps the state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.io.checkpoint import Journal, read_header
from hypertuna.optimization.constraints import Limit, gait_quantities
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import Problem
from hypertuna.optimization.optimize import make_optimizer, wish
from hypertuna.swimming.gait import Gait
from hypertuna.trials.steady import SteadyRun

__all__ = ["TankSearch", "TankWish"]

Array = NDArray[np.float64]

SAME = 1e-4  # of the range of a coordinate: a gait so near one that was asked for is that one
MEASURED = ("speed", "cost_of_transport")


@dataclass(frozen=True)
class TankWish:
    """What a search by experiment is for: everything that its first call says.

    Attributes
    ----------
    robot : str
        Name, or path of its file.
    maximize, minimize : str or None
    speed, weight : float or None
        As for `hypertuna.optimization.optimize` [m/s; m/s per J/(kg m)].
    bounds : mapping
        As for `hypertuna.optimization.design_space.gait_bounds` [Hz or deg].
    limits : tuple of Limit
        Of the gait alone: rates and reach.
    method : str
    particles, iterations : int or None
    seed : int
    """

    robot: str
    maximize: str | None
    minimize: str | None
    speed: float | None
    weight: float | None
    bounds: Mapping[str, tuple[float, float]]
    limits: tuple[Limit, ...]
    method: str
    particles: int | None
    iterations: int | None
    seed: int

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> Self:
        """Read back what `asdict` and JSON made of a search.

        Parameters
        ----------
        options : mapping

        Returns
        -------
        TankWish
        """
        bounds = {name: (low, high) for name, (low, high) in options["bounds"].items()}
        limits = tuple(Limit(**limit) for limit in options["limits"])
        return cls(**{**options, "bounds": bounds, "limits": limits})

    def problem(self) -> Problem:
        """Pose it to the tank.

        Returns
        -------
        Problem

        Raises
        ------
        InputError
            If something of it cannot be used, or asks for what a tank does not measure.
        """
        robot = load(self.robot)
        target = wish(maximize=self.maximize, minimize=self.minimize, speed=self.speed, weight=self.weight)
        problem = Problem(robot, gait_bounds(robot, self.bounds), (target,), self.limits)
        if self.method == "gradient":
            rule = "must do without derivatives, which a tank does not give"
            raise InputError(rule, key="method", value="'gradient'", fix="take pso, cma or de")
        told = {*MEASURED, "stride_length", *gait_quantities(robot, problem.space.gaits([problem.space.lower]))[0]}
        for name in problem.needs:
            if name not in told:
                fix = "wish for speed or cost_of_transport, and limit rates or amplitudes"
                raise InputError("must be measured in the tank", key=name, fix=fix)
        return problem


class TankSearch:
    """A search whose points a tank evaluates. The journal is its whole state: opened again, it goes on.

    Parameters
    ----------
    path : str or Path
        The journal.
    search : TankWish, optional
        What a new journal is for. Left out, the journal says it.

    Raises
    ------
    InputError
        If something of the search cannot be used, or the journal is of another search.
    """

    def __init__(self, path: str | Path, search: TankWish | None = None) -> None:
        if search is None:
            search = _search_of(path)
        self.search = search
        self.problem = search.problem()
        self._optimizer, _ = make_optimizer(
            self.problem, search.method, search.particles, search.iterations, search.seed
        )
        self._told: dict[int, dict[str, float]] = {}  # points of the batch that have been told, by their place in it
        self._batch = self._optimizer.ask()
        header = journal_header("experiment", self.problem.robot, asdict(search))
        del header["isa"]  # nothing is computed that depends on it
        self._journal = Journal(path, header)
        try:
            for k, record in enumerate(self._journal.records):
                self._replay(record, f"{path}:{k + 2}")
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the journal."""
        self._journal.close()

    @property
    def robot(self) -> Robot:
        """The robot that swims."""
        return self.problem.robot

    @property
    def stop(self) -> str | None:
        """Why there is nothing more to ask, None while there is."""
        return self._optimizer.stop

    @property
    def evaluations(self) -> int:
        """Gaits told in whole batches."""
        return self._optimizer.evaluations

    @property
    def best(self) -> tuple[Gait, dict[str, float]] | None:
        """The best gait of the batches told, with what was measured; None before there is one that can be used."""
        best = self._optimizer.result
        if best is None or not best.feasible[0]:
            return None
        return self.problem.space.gait(best.x[0]), {name: float(best.found[name][0]) for name in MEASURED}

    def ask(self) -> dict[str, Gait]:
        """Return the gaits to swim next, the same until all of the batch are told.

        Returns
        -------
        dict of Gait
            By names such as ``batch-3-gait-07``.
        """
        return {self._name(k): self.problem.space.gait(self._batch[k]) for k in self._open()}

    def tell(self, runs: Sequence[SteadyRun]) -> int:
        """Take how gaits of the batch swam.

        Parameters
        ----------
        runs : sequence of SteadyRun
            Of gaits that were asked for and are not told yet: all of the batch, or some.

        Returns
        -------
        int
            How many gaits of the batch are still to be told; none of them before the next batch.

        Raises
        ------
        InputError
            If a run is of another gait, or lacks what the goal is made of: nothing is kept then.
        """
        open_points = self._open()
        told: dict[int, dict[str, float]] = {}
        for run in runs:
            k = self._place(run, [k for k in open_points if k not in told])
            told[k] = self._measured(run)
        if not told:
            raise InputError("must have one run at least", key="tell", value="none", fix="give what was measured")
        self._take(told)
        self._journal.append({"asked": self._asked(told), "told": list(told.values())})
        return self._advance()

    def _open(self) -> list[int]:
        """Places in the batch that are still to be told."""
        return [k for k in range(len(self._batch)) if k not in self._told] if self.stop is None else []

    def _name(self, k: int) -> str:
        """Name of a gait of this batch."""
        return f"batch-{len(self._optimizer.batches) + 1}-gait-{k + 1:02d}"

    def _asked(self, told: Mapping[int, Any]) -> list[list[float]]:
        """Points of the batch as the journal keeps them."""
        return [self._batch[k].tolist() for k in told]

    def _place(self, run: SteadyRun, places: Sequence[int]) -> int:
        """Find the point of the batch that a run is of; of equal points that of its name, or the first."""
        space = self.problem.space
        gaits = {k: space.gait(self._batch[k]) for k in places}
        near = [k for k, gait in gaits.items() if _distance(run.gait, gait, self.problem) < SAME]
        if not near:
            rule = "must be a gait that was asked for and is not told yet"
            fix = "see `hypertuna optimize ask`" if places else "ask for the next batch"
            raise InputError(rule, file=run.file or None, key=_at(run), fix=fix)
        return next((k for k in near if self._name(k) == run.name), near[0])

    def _measured(self, run: SteadyRun) -> dict[str, float]:
        """Return what was measured of a run, with all that the goal is made of."""
        target = self.problem.goals[0]
        needed = {name for name, factor in target.terms if factor} | (
            {"speed"} if target.expected is not None else set()
        )
        told = {name: getattr(run, name) for name in MEASURED}
        for name in sorted(needed):
            if told[name] is None:
                rule = f"must have a {name.replace('_', ' ')}, which the goal is made of"
                raise InputError(rule, file=run.file or None, key=_at(run), fix="give what was measured")
        return {name: np.nan if value is None else float(value) for name, value in told.items()}

    def _take(self, told: Mapping[int, dict[str, float]]) -> None:
        """Keep what was told of the batch."""
        self._told.update(told)

    def _advance(self) -> int:
        """Pass a batch that is told whole to the optimizer; return how many gaits of it are still to be told."""
        if left := len(self._open()):
            return left
        self._optimizer.tell(self.problem.judge(self._batch, self._found()))
        self._told = {}
        if self.stop is None:
            self._batch = self._optimizer.ask()
        return 0

    def _found(self) -> dict[str, Array]:
        """Quantities of the whole batch, as a simulation returns them."""
        gaits = self.problem.space.gaits(self._batch)
        rows = [self._told[k] for k in range(len(self._batch))]
        found = {name: np.array([row[name] for row in rows]) for name in MEASURED}
        # A goal without a speed does not need it: the robot has swum forward.
        speed = np.where(np.isnan(found["speed"]), np.inf, found["speed"])
        found["stride_length"] = np.minimum(speed / (gaits.frequency * self.robot.body.length), 1e6)
        of_gait, _ = gait_quantities(self.robot, gaits)
        return found | of_gait | {"status": np.zeros(len(rows))}

    def _replay(self, record: Mapping[str, Any], place: str) -> None:
        """Take a record of the journal, as if it were told now."""
        asked = [point.tolist() for point in self._batch]
        told: dict[int, dict[str, float]] = {}
        points, rows = record.get("asked"), record.get("told")
        pairs: list[Any] = [(None, None)]  # answers no question
        if isinstance(points, list) and isinstance(rows, list) and len(points) == len(rows):
            pairs = list(zip(points, rows, strict=True))
        for point, row in pairs:
            k = next((k for k in self._open() if k not in told and asked[k] == point), None)
            if k is None or not (isinstance(row, dict) and set(MEASURED) <= row.keys()):
                rule = "tells of gaits that this search does not ask for"
                raise InputError(rule, file=place, fix="use the version of hypertuna that began it")
            told[k] = row
        self._take(told)
        self._advance()


def _search_of(path: str | Path) -> TankWish:
    """Return what a journal is for."""
    if not Path(path).exists():
        rule, fix = "has not been begun", "say what to search for: --robot and --maximize speed, for example"
        raise InputError(rule, file=str(path), fix=fix)
    header = read_header(path)
    if header.get("kind") != "experiment":
        fix = "give the state of `hypertuna optimize ask`"
        raise InputError("must be the state of an experiment", file=str(path), value=str(header.get("kind")), fix=fix)
    try:
        return TankWish.of(header["options"])
    except (KeyError, TypeError, ValueError, AttributeError):
        rule, fix = "does not say what is searched for", "use the version of hypertuna that began it"
        raise InputError(rule, file=f"{path}:1", fix=fix) from None


def _at(run: SteadyRun) -> str:
    """Where a run stands."""
    return f"line {run.line}" if run.line else run.name


def _distance(one: Gait, other: Gait, problem: Problem) -> float:
    """Largest difference of two gaits, in ranges of the coordinates; of what is fixed, in Hz or rad."""
    space = problem.space
    rows = [np.array([gait.frequency, *gait.amplitude, *gait.phase, *gait.bias]) for gait in (one, other)]
    width = np.where(space.high > space.low, space.high - space.low, 1.0)
    return float(np.max(np.abs(rows[0] - rows[1]) / width))
