"""Sweeps of many gaits over vector lanes, threads and executors; exact derivatives of a gait's results."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from hypertuna import _core
from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.design import Variable, designed
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, shown
from hypertuna.io.checkpoint import Journal
from hypertuna.parallel.executors import Executors, map_shards, thread_count
from hypertuna.ranges import check_choice
from hypertuna.swimming.batch import CHUNK, Part, batch
from hypertuna.swimming.beat import DEFAULT_STEPS, DIFFERENTIABLE, STATUSES, directional_derivatives, settle
from hypertuna.swimming.designs import design_of
from hypertuna.swimming.gait import Gait, Gaits, check_count, gait_of
from hypertuna.swimming.model import parameter_names, parameter_values, share_values
from hypertuna.swimming.yielding import given_springs, spring_values

if TYPE_CHECKING:
    import xarray as xr


@checked
def sweep(
    robot: Robot | str | Path,
    gaits: Gaits | Sequence[Gait],
    *,
    executor: Executors | None = None,
    threads: int | None = None,
    steps: int = DEFAULT_STEPS,
    method: Literal["newton", "beats"] = "newton",
    beats: int = 50,
    check_rest: bool = False,
    design: Mapping[str, Sequence[float]] | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Swim many gaits, and return their results as a data set.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    gaits : Gaits or sequence of Gait
    executor : concurrent.futures.Executor or callable, optional
        Where to swim: any executor, such as ``ProcessPoolExecutor`` or ``get_executor()`` of a Dask client, or a
        function that makes one, which replaces a pool that lost a process. The result does not depend on it.
    threads, steps : int
        Threads, by default all processors, or one on each worker of an executor; the result does not depend on them.
        Runge-Kutta steps per beat, a multiple of 4.
    method : {"newton", "beats"}
        "newton": solve for the settled beat; "beats": swim from rest, and measure the last beat.
    beats : int
        Number of beats that "beats" swims from rest.
    check_rest : bool
        Whether to check that a start from rest leads to each settled beat, which takes three to four times as long.
    design : mapping, optional
        Values of numbers of the robot's file by key [unit of the file], ``{"hinge.stiffness": (0.1, 0.2)}``, as of
        `optimize`: every combination swims the gaits. Each key becomes the first dimensions of the result.
    checkpoint : str or Path, optional
        File of a journal, from which the same call resumes after an interruption; not with a design.
    progress : callable, optional
        Called with the number of gaits completed and their total.

    Returns
    -------
    xarray.Dataset
        Every quantity of `hypertuna.swimming.beat.QUANTITIES`, ``status`` and ``settled``, with dimensions frequency,
        amplitude, phase and bias for a grid, or gait for a list; angles of every joint group are coordinates such as
        ``amplitude_I`` [rad, or deg for `Gaits.grid_degrees`: their attribute ``units``]. Each dimension of a grid is
        indexed by the last joint group whose angles all differ along it: ``.sel(phase=40, method="nearest")``. A gait
        that diverged does not affect the others. With `check_rest` also ``reached_from_rest`` and
        ``speed_from_rest``; the attribute ``check_rest`` says whether starts from rest were checked.

    Raises
    ------
    InputError
        If the gaits do not fit the robot.
    """
    options: Any = {"steps": steps, "method": method, "beats": beats, "check_rest": check_rest}
    if design:
        found = design_robots(robot_of(robot), design, len(gaits))
        more: Any = {"executor": executor, "threads": threads, "checkpoint": checkpoint}
        return sweep_designs(robot_of(robot), gaits, design, found, progress=progress, **options | more)
    options["threads"] = thread_count(threads, executor)
    work = batch(robot, gaits, **options)
    if work.gaits.is_grid:
        check_count(len(work.gaits))
    header = journal_header("sweep", work.swimming.robot, work.options | {"chunk": CHUNK})
    count, layout = len(work.gaits), work.layout
    ranges = [(first, min(first + CHUNK, count)) for first in range(0, count, CHUNK)]
    chunks: list[dict[str, Array]] = []
    with Journal(checkpoint, header) as journal:
        pending = (Part.of(work.gaits, *ends) for ends in ranges[journal.unread :])
        with closing(map_shards(work.swimming.swim, pending, executor)) as swims:
            for first, last in ranges:
                if checkpoint is None:
                    chunks.append(next(swims))
                else:
                    rows = journal.answer([first, last], lambda: next(swims))
                    chunks.append(
                        {name: np.array(rows[name], TYPES.get(name, np.float64)) for name in layout.variables}
                    )
                if progress is not None:
                    progress(last, count)
    return layout.dataset({name: np.concatenate([chunk[name] for chunk in chunks]) for name in layout.variables})


def sweep_designs(
    robot: Robot,
    gaits: Gaits | Sequence[Gait],
    design: Mapping[str, Sequence[float]],
    found: tuple[tuple[Variable, ...], list[Robot]],
    *,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Swim the gaits with every robot of a design; its variables are the first dimensions of the result.

    found: what `design_robots` returns for the design. options: further ones of `sweep`.
    """
    import xarray as xr

    if checkpoint is not None:
        fix = "leave it out, or sweep one robot at a time"
        raise InputError("cannot keep a sweep over a design", key="checkpoint", value=str(checkpoint), fix=fix)
    design_variables, robots = found
    swims = []
    for k, variant in enumerate(robots):
        swims.append(sweep(variant, gaits, **options))
        if progress is not None:
            progress((k + 1) * len(gaits), len(gaits) * len(robots))
    levels = [[float(value) for value in values] for values in design.values()]
    sizes = {v.label: len(values) for v, values in zip(design_variables, levels, strict=True)}
    variables = {}
    for name, first in swims[0].data_vars.items():
        stack = np.stack([result[name].values for result in swims])
        variables[name] = ((*sizes, *first.dims), stack.reshape(*sizes.values(), *first.shape), first.attrs)
    coordinates = {
        one.label: (one.label, values, one.attributes | {"key": one.name})
        for one, values in zip(design_variables, levels, strict=True)
    }
    result = xr.Dataset(variables, coordinates, swims[0].attrs | provenance(robot))
    return result.assign_coords(swims[0].coords)


def design_robots(
    robot: Robot, design: Mapping[str, Sequence[float]], gaits: int
) -> tuple[tuple[Variable, ...], list[Robot]]:
    """Return a design's variables and robots, among which the last key changes fastest; gaits: number per robot."""
    for key, values in design.items():
        if len({float(value) for value in values}) < max(2, len(values)):
            fix = "give two or more; --set changes a value for good"
            raise InputError("must be different values", key=f"design {key}", value=shown(values), fix=fix)
    ends = {key: (float(np.min(values)), float(np.max(values))) for key, values in design.items()}
    found = design_of(robot, ends, derivatives=False)
    places = list(itertools.product(*([float(value) for value in values] for values in design.values())))
    check_count(gaits * len(places))
    return found, [designed(robot, found, place) for place in places]


TYPES = {"status": np.int8, "settled": np.bool_, "reached_from_rest": np.bool_}  # types of results, if not float64
ANGLES = ("gait.amplitude", "gait.phase", "gait.bias", "joints.phase_offset")  # parameters in radians


@dataclass(frozen=True)
class Gradient(Plotted, Tabular, data=lambda gradient: gradient._columns()):
    """Exact derivatives of a settled gait's results with respect to every coefficient and gait parameter."""

    names: tuple[str, ...]  # names of the parameters: gait.amplitude[1], links.mass[3], water.lumped.drag[7]
    derivatives: Mapping[str, Array]  # (parameters,) by quantity [SI unit of the quantity per unit of the parameter]
    values: Array  # (parameters,) values of the parameters [SI]
    results: Mapping[str, float]  # the gait's results by quantity [SI]
    robot: Robot
    gait: Gait

    def __getattr__(self, name: str) -> Array:
        """Return the derivatives of a quantity (parameters,): ``gradient.speed``."""
        derivatives: Mapping[str, Array] = self.__dict__.get("derivatives", {})
        if name not in derivatives:
            raise AttributeError(f"{type(self).__name__} has no {name}", name=name, obj=self)
        return derivatives[name]

    def influence(self, quantity: str = "speed") -> Array:
        """Return how much each parameter changes a result.

        Parameters
        ----------
        quantity : str
            Name of a result: "speed", "cost_of_transport", ... of `hypertuna.swimming.beat.DIFFERENTIABLE`

        Returns
        -------
        ndarray, shape (parameters,)
            Change of the result [%] if the parameter grows by 1 %, or by 1 degree if it is an angle.
        """
        check_choice(quantity, DIFFERENTIABLE, "quantity")
        angle = [name.partition("[")[0] in ANGLES for name in self.names]
        finite = np.where(np.isfinite(self.values), self.values, 0.0)  # an ideal joint has an infinite bandwidth
        change: Array = self.derivatives[quantity] * np.where(angle, np.radians(1), 0.01 * finite)
        result = self.results[quantity]
        if quantity == "turn_rate" and abs(result) * _core.NEARLY_STRAIGHT < abs(self.results["speed_bl"]):
            result = np.nan  # a straight gait turns by rounding alone
        return 100 * change / result

    def _columns(self) -> dict[str, Any]:
        """Return the columns of a table, the largest influence on the speed first."""
        influence = {f"{name}_percent": self.influence(name) for name in DIFFERENTIABLE}
        columns = {"parameter": np.array(self.names), "value_si": self.values} | influence
        order = np.argsort(-np.abs(influence["speed_percent"]), kind="stable")
        return {name: values[order] for name, values in columns.items()}


@checked
def gradient(robot: Robot | str | Path, gait: Gait | str, *, steps: int = DEFAULT_STEPS) -> Gradient:
    """Return exact derivatives of a settled gait's results with respect to every coefficient and gait parameter.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    gait : Gait or str
        Gait, or the name of one of the robot's.
    steps : int
        Runge-Kutta steps per beat, a multiple of 4.

    Returns
    -------
    Gradient

    Raises
    ------
    InputError
        If the gait does not fit the robot, or has no derivatives, since it does not settle or has no speed.
    """
    robot = robot_of(robot)
    gait = gait_of(robot, gait)
    gaits = Gaits.of([gait])
    result = settle(robot, gaits, steps=steps)
    status = STATUSES[result["status"][0]]
    if not any(gait.amplitude):
        raise InputError("must move the robot to have derivatives", key="gait", fix="give it an amplitude")
    if status not in ("settled", "unstable"):
        raise InputError("must settle to have derivatives", key="gait", value=status, fix="see hypertuna.swim")
    if np.isnan(result["speed"][0]):
        rule, value = "must have a speed to have derivatives", "turning by more than half a circle a beat"
        raise InputError(rule, key="gait", value=value, fix="give it less bias")
    springs, shares = spring_values(robot), share_values(robot)
    values = springs | shares
    chosen = [*given_springs(robot), *shares]
    names = (*parameter_names(robot), *chosen)
    directions = np.array([[float(name == one) for name in names] for one in (*parameter_names(robot), *values)])
    derivatives = directional_derivatives(robot, gaits, result, directions, steps=steps)
    return Gradient(
        names,
        {name: rates[0] for name, rates in derivatives.items()},
        values=np.append(parameter_values(robot, gait), [values[name] for name in chosen]),
        results={name: float(result[name][0]) for name in DIFFERENTIABLE},
        robot=robot,
        gait=gait,
    )
