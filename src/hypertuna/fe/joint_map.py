"""Map of a joint: finite elements on a grid of pressures and couples, beside the fast model (docs/fe.md).

The two sides share their oil, so the sum of their pressures is constant: by default the right pressure is twice the
fill pressure minus the left pressure, and at least zero.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.actuation.bending import check_pressure
from hypertuna.actuation.soft_joint import joint_group, joint_models
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Displayed
from hypertuna.errors import InputError, shown
from hypertuna.fe.bend import ngsolve_version
from hypertuna.fe.measure import measure
from hypertuna.fe.model import FeOptions, equilibrium, fe_model
from hypertuna.fe.states import STATES, States, apart, fast_states, holding_moment, state_columns, states_of
from hypertuna.io.checkpoint import Journal
from hypertuna.parallel.executors import Executors, map_shards
from hypertuna.parallel.layout import Layout
from hypertuna.parallel.shards import Cases, make_shards

if TYPE_CHECKING:
    import xarray as xr

STRONGEST = 0.5  # default of the largest couple, over the moment that holds the joint straight at full pressure

Pair = tuple[float, float]  # pressures of the left and right sides [Pa]
# A function that solves a joint under a couple [N m], at the end of a path of pairs of pressures [Pa]. It returns angle
# [rad], volume of each side [m^3], length of the bent axis [m], and fault, a sentence that is empty without a fault.
Joint = Callable[[float, Sequence[Pair]], Mapping[str, Any]]


@dataclass(frozen=True)
class Grid:
    """A joint with the pressures and couples under which it is solved."""

    robot: Robot
    joint: str
    options: FeOptions
    pressure: Array  # (n, 2) pressures of the left and right sides [Pa]
    couple: Array  # (m,) couples on the tip plate [N m]
    straight: float  # moment that holds the joint straight under the largest pressure, by the fast model [N m]

    @property
    def pairs(self) -> list[Pair]:
        """Pressures of the left and right sides [Pa], in pairs."""
        return [(left, right) for left, right in self.pressure.tolist()]

    @property
    def header(self) -> dict[str, Any]:
        """Header of the grid's journal: version, robot, options, pressures and couples."""
        facts = {"joint": self.joint, "pressure": self.pressure.tolist(), "couple": self.couple.tolist()}
        options = self.options.facts(self.robot) | facts | {"ngsolve": ngsolve_version()}
        return journal_header("fe map", self.robot, options)


@dataclass(frozen=True)
class JointMap(Displayed):
    """A joint by finite elements and by the fast model, on a grid of pressures and couples."""

    robot: Robot
    joint: str
    options: FeOptions
    pressure: Array  # (n, 2) pressures of the left and right sides [Pa]
    couple: Array  # (m,) couples on the tip plate; the moment is couple x cos(angle) [N m]
    elements: States
    model: States  # angle, volume and length under the elements' moment, and the moment at the elements' angle
    straight: float  # moment that holds the joint straight under the largest pressure, by the fast model [N m]
    status: str  # "converged", or "partial" if some points have no equilibrium
    status_text: str  # the status as a sentence
    seconds: float  # processor time of all points [s]

    def largest(self, name: str) -> float:
        """Return the largest difference of a field of `States` between the two models."""
        return apart(self.elements, self.model, name)

    @property
    def moment_difference(self) -> float:
        """Largest difference of the models' moments, over the moment that holds the joint straight [1]."""
        return self.largest("moment") / self.straight

    @property
    def volume_difference(self) -> float:
        """Largest difference of the models' volumes, over the range of the elements' volumes [1]."""
        volume = self.elements.volume[np.isfinite(self.elements.volume)]
        return self.largest("volume") / float(np.ptp(volume)) if len(volume) else math.nan

    def dataset(self) -> xr.Dataset:
        """Return the states of both models as a labeled dataset."""
        return map_layout(self).dataset(state_columns(self.elements, self.model))

    def record(self) -> dict[str, Any]:
        """Return all numbers by names with units."""
        facts = {"ngsolve_version": ngsolve_version(), "joint": self.joint} | self.options.facts(self.robot)
        grid = {f"pressure_{side}_kpa": self.pressure[:, s] / 1e3 for s, side in enumerate(("left", "right"))}
        largest = {
            "straight_moment_n_m": self.straight,
            "moment_difference_percent": 100 * self.moment_difference,
            "volume_difference_percent": 100 * self.volume_difference,
            "bend_difference_deg": math.degrees(self.largest("angle")),
            "length_difference_mm": 1e3 * self.largest("length"),
        }
        run = {"seconds": self.seconds, "status": self.status, "status_text": self.status_text}
        states = {"elements": self.elements.record(), "model": self.model.record()}
        return provenance(self.robot, water=False) | facts | grid | {"couple_n_m": self.couple} | states | largest | run


def joint_map(
    robot: Robot,
    joint: str | int,
    *,
    pressure: ArrayLike,
    couple: ArrayLike | None = None,
    fill: float | None = None,
    options: FeOptions | None = None,
    executor: Executors | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    solve: Joint | None = None,
) -> JointMap:
    """Solve a joint on a grid of pressures and couples by finite elements and by the fast model.

    `pressure` (n,) is of the left side [Pa]; `couple` (m,) [N m] and `fill` [Pa] have defaults. The work resumes from
    the journal `checkpoint`; `solve` replaces the finite elements. A task of the `executor` is one couple with all
    pressures.
    """
    grid = _grid(robot, joint, pressure, couple, fill, options)
    pairs = grid.pairs
    by_elements = solve or joint_by_elements(robot, grid.joint, grid.options)
    points: list[dict[str, Any]] = []
    with Journal(checkpoint, grid.header) as journal:
        complete = journal.unread // len(pairs)  # couples whose points are all known
        with closing(map_shards(partial(_of_couple, grid, solve), grid.couple[complete:].tolist(), executor)) as rows:
            row: list[dict[str, Any]] = []
            for c, p in itertools.product(range(len(grid.couple)), range(len(pairs))):

                def point(c: int = c, p: int = p) -> dict[str, Any]:
                    nonlocal row
                    if executor is None:
                        return _solved(by_elements, float(grid.couple[c]), pairs[: p + 1])
                    row = next(rows) if p == 0 or not row else row
                    return row[p]

                points.append(journal.answer([c, p], point))
                if progress is not None:
                    progress(len(points), len(grid.couple) * len(pairs))
    faults = [point_record["fault"].rstrip(".") for point_record in points if point_record["fault"]]
    text = f"All {len(points)} points have an equilibrium."
    if faults:
        text = f"{len(faults)} of {len(points)} points have no equilibrium; the first: {faults[0]}."
    elements, model = _both(grid, grid.couple, points)
    return JointMap(
        robot=robot,
        joint=grid.joint,
        options=grid.options,
        pressure=grid.pressure,
        couple=grid.couple,
        elements=elements,
        model=model,
        straight=grid.straight,
        status="partial" if faults else "converged",
        status_text=text,
        seconds=float(sum(point_record["seconds"] for point_record in points)),
    )


def joint_map_shards(
    robot: Robot,
    joint: str | int,
    folder: str | Path,
    *,
    pressure: ArrayLike,
    couple: ArrayLike | None = None,
    fill: float | None = None,
    options: FeOptions | None = None,
    size: int | None = None,
    part: tuple[int, int] = (1, 1),
    executor: Executors | None = None,
    command: str = "hypertuna.fe.joint_map.joint_map_shards with the same arguments",
    progress: Callable[[int, int], None] | None = None,
    solve: Joint | None = None,
) -> int:
    """Solve a joint on a grid and write a folder of shards, each of `size` couples; return the number of shards.

    The arguments are those of `joint_map` and of `hypertuna.sweep_shards`; the default size is one couple.
    """
    grid = _grid(robot, joint, pressure, couple, fill, options)
    cases = Cases(grid.header, len(grid.couple), map_layout(grid), partial(_range, grid, solve))
    return make_shards(cases, folder, executor, size=size or 1, part=part, command=command, progress=progress)


def map_layout(grid: Grid | JointMap) -> Layout:
    """Return the layout of a map's files: dimensions, names, units and meanings of both models' states."""
    variables = {
        f"{prefix}{name}": {"units": unit, "long_name": f"{meaning}, by {model}"}
        for prefix, model in (("", "finite elements"), ("model_", "the fast model"))
        for name, (unit, meaning) in STATES.items()
    }
    left, right = grid.pressure.T
    coordinates = {
        "couple": ("couple", grid.couple, {"units": "N m", "long_name": "couple on the tip plate"}),
        "pressure": ("pressure", left, {"units": "Pa", "long_name": "gauge pressure of the left side"}),
        "pressure_right": ("pressure", right, {"units": "Pa", "long_name": "gauge pressure of the right side"}),
    }
    facts = provenance(grid.robot, water=False) | {"ngsolve_version": ngsolve_version(), "joint": grid.joint}
    facts |= grid.options.facts(grid.robot) | {"mesh": f"{grid.options.mesh}", "straight_moment_n_m": grid.straight}
    sizes = {"couple": len(grid.couple), "pressure": len(grid.pressure)}
    return Layout(sizes, variables, coordinates, facts, {name: name for name in variables})


def _grid(
    robot: Robot,
    joint: str | int,
    pressure: ArrayLike,
    couple: ArrayLike | None,
    fill: float | None,
    options: FeOptions | None,
) -> Grid:
    """Check pressures and couples, and return the grid of a joint, with the defaults filled in."""
    group, _ = joint_group(robot, joint)
    options = options or FeOptions()
    if fill is None:
        fill = group.line.fill_pressure if group.line else 0.0
    pairs = _pairs(pressure, fill)
    model = next(m for m in joint_models(robot, options.material) if m.name == group.name)
    straight = abs(holding_moment(model, 0.0, (max(map(max, pairs)), 0.0)))
    torques = _couples(np.linspace(-1, 1, 5) * float(f"{STRONGEST * straight:.2g}") if couple is None else couple)
    return Grid(robot, group.name, options, np.array(pairs), torques, straight)


def _both(grid: Grid, couple: Array, points: Sequence[Mapping[str, Any]]) -> tuple[States, States]:
    """Return the states of finite elements, from their points under some couples, and those of the fast model."""
    elements = states_of(points, couple, len(grid.pressure))
    model = next(m for m in joint_models(grid.robot, grid.options.material) if m.name == grid.joint)
    return elements, fast_states(grid.robot, model, grid.pressure, elements)


def _range(grid: Grid, solve: Joint | None, first: int, last: int) -> dict[str, Array]:
    """Return the states of both models, by column, under the couples from index `first` to before `last`."""
    couple = grid.couple[first:last]
    return state_columns(
        *_both(grid, couple, [point for torque in couple.tolist() for point in _of_couple(grid, solve, torque)])
    )


def _of_couple(grid: Grid, solve: Joint | None, couple: float) -> list[dict[str, Any]]:
    """Return the records of all pressures under one couple."""
    solve = solve or joint_by_elements(grid.robot, grid.joint, grid.options)
    return [_solved(solve, couple, grid.pairs[: p + 1]) for p in range(len(grid.pairs))]


def _solved(solve: Joint, couple: float, path: Sequence[Pair]) -> dict[str, Any]:
    """Solve the point at the end of a path of pressures; return its record, with its processor time."""
    start = time.process_time()
    return dict(solve(couple, path)) | {"seconds": time.process_time() - start}


def _pairs(pressure: ArrayLike, fill: float) -> list[Pair]:
    """Return pairs of left and right pressures [Pa]; the right one is twice the fill minus the left, at least 0."""
    rising = check_pressure(pressure)
    if not rising[-1] > 0:
        raise InputError("must end above 0", key="pressure", value=shown(rising.tolist()), fix="add a higher one")
    if not 0 <= fill < math.inf:
        fix = "give the pressure that both sides have at rest, or 0"
        raise InputError("must not be negative", key="fill", value=f"{fill / 1e3:g} kPa", fix=fix)
    return [(p, max(0.0, 2 * fill - p)) for p in rising.tolist()]


def _couples(values: ArrayLike) -> Array:
    """Return couples [N m] as an array (m,); they must be finite."""
    try:
        array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        array = np.array([math.nan])
    if array.ndim != 1 or not len(array) or not np.isfinite(array).all():
        rule, fix = "must be a list of finite numbers", "give them as a list, in N m"
        raise InputError(rule, key="couple", value=shown(values), fix=fix)
    return array


def joint_by_elements(robot: Robot, joint: str | int, options: FeOptions | None = None) -> Joint:
    """Return a function that solves a joint; a path one pair longer continues from the last state, others from rest."""
    model: Any = None
    solved_path: tuple[float, tuple[Pair, ...]] | None = None

    def solve(couple: float, path: Sequence[Pair]) -> Mapping[str, Any]:
        nonlocal model, solved_path
        model = model or fe_model(robot, joint, options)
        pairs_left = list(path)
        if solved_path == (couple, tuple(path[:-1])):
            pairs_left = pairs_left[-1:]
        else:  # start from rest
            for load in model.problem.loads:
                load.Set(0.0)
            model.problem.state.vec[:] = 0.0
        solved_path = None
        for pair in pairs_left:
            result = equilibrium(model, pressure=pair, couple=couple)
            if not result.converged:
                return {"fault": result.text}
        solved_path = couple, tuple(path)
        measured = measure(model)
        numbers = {"angle": measured.angle, "volume": list(measured.volume), "length": measured.length}
        return numbers | {"fault": measured.fault}

    return solve
