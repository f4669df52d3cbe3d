"""Map of a joint: finite elements on a grid of pressures and couples, beside the fast model (docs/fe.md).

Two sides that share their oil keep the sum of their pressures: by default the right pressure is twice the fill pressure
minus the left pressure, and at least zero.
"""

import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from hypertuna.actuation.bending import check_pressure
from hypertuna.actuation.soft_joint import JointModel, drive_unit, joint_group, joint_models
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, shown
from hypertuna.fe.bend import ngsolve_version
from hypertuna.fe.measure import measure
from hypertuna.fe.model import FeOptions, equilibrium, fe_model
from hypertuna.io.checkpoint import Journal
from hypertuna.parallel.executors import Executors, map_shards

STRONGEST = 0.5  # largest couple by default, over the moment that holds the joint straight under the largest pressure
STRAIN = 0.3  # of the axis, at most

Pair = tuple[float, float]
# Solves a joint under a couple [N m] at the end of a path of pairs of pressures [Pa]: angle [rad], volume [m^3] of
# each side, length of the bent axis [m], fault (a sentence, empty without one).
Joint = Callable[[float, Sequence[Pair]], Mapping[str, Any]]


@dataclass(frozen=True)
class States:
    """A joint under couples (m,) and pairs of pressures (n,); NaN where finite elements have no equilibrium."""

    angle: Array  # (m, n) [rad]
    moment: Array  # (m, n) from outside that holds the angle of the elements [N m]
    volume: Array  # (m, n, 2) of oil in the drive units of each side [m^3]
    length: Array  # (m, n) of the bent axis [m]

    def record(self) -> dict[str, Any]:
        """Return all numbers with units in their names, a row for each couple."""
        oil = {f"volume_{side}_ml": 1e6 * self.volume[..., s] for s, side in enumerate(("left", "right"))}
        angle = {"angle_deg": np.degrees(self.angle), "moment_n_m": self.moment}
        return angle | oil | {"length_mm": 1e3 * self.length}


@dataclass(frozen=True)
class JointMap:
    """A joint by finite elements and by the fast model, under the same pressures and moments."""

    robot: Robot
    joint: str
    options: FeOptions
    pressure: Array  # (n, 2) of the left and right side [Pa]
    couple: Array  # (m,) on the tip plate; the moment is couple x cos(angle) [N m]
    elements: States
    model: States  # angle, volume and length under the elements' moment, and the moment at the elements' angle
    straight: float  # moment that holds the joint straight under the largest pressure, by the fast model [N m]
    status: str  # "converged", or "partial" without equilibrium at some points
    status_text: str  # sentence
    seconds: float  # processor time of all points [s]

    def largest(self, name: str) -> float:
        """Return the largest difference of a number of `States` between the models."""
        return apart(self.elements, self.model, name)

    @property
    def moment_difference(self) -> float:
        """Largest difference of the moments over that of the straight joint under the largest pressure [1]."""
        return self.largest("moment") / self.straight

    @property
    def volume_difference(self) -> float:
        """Largest difference of the volumes over the range of those of the elements [1]."""
        volume = self.elements.volume[np.isfinite(self.elements.volume)]
        return self.largest("volume") / float(np.ptp(volume)) if len(volume) else math.nan

    def record(self) -> dict[str, Any]:
        """Return all numbers with units in their names."""
        facts = {"ngsolve_version": ngsolve_version(), "joint": self.joint} | self.options.facts(self.robot)
        grid = {f"pressure_{side}_kpa": self.pressure[:, s] / 1e3 for s, side in enumerate(("left", "right"))}
        largest = {
            "straight_moment_n_m": self.straight,
            "moment_difference_percent": 100 * self.moment_difference,
            "volume_difference_percent": 100 * self.volume_difference,
            "bend_difference_deg": math.degrees(self.largest("angle")),
            "length_difference_mm": 1e3 * self.largest("length"),
        }
        told = {"seconds": self.seconds, "status": self.status, "status_text": self.status_text}
        both = {"elements": self.elements.record(), "model": self.model.record()}
        return provenance(self.robot, water=False) | facts | grid | {"couple_n_m": self.couple} | both | largest | told


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
    """Solve a joint on a grid of pressures and couples, and compare the fast model with it.

    `pressure` (n,) of the left side [Pa]; `couple` (m,) [N m] and `fill` [Pa] have defaults. The journal `checkpoint`
    resumes the work; `solve` replaces the finite elements. An `executor` takes all pressures under a couple as a task.
    """
    group, _ = joint_group(robot, joint)
    options = options or FeOptions()
    if fill is None:
        fill = group.line.fill_pressure if group.line else 0.0
    pairs = _pairs(pressure, fill)
    model = next(m for m in joint_models(robot, options.material) if m.name == group.name)
    straight = abs(holding_moment(model, 0.0, (max(map(max, pairs)), 0.0)))
    torques = _couples(np.linspace(-1, 1, 5) * float(f"{STRONGEST * straight:.2g}") if couple is None else couple)
    by_elements = solve or joint_by_elements(robot, joint, options)
    facts = {"joint": group.name, "pressure": pairs, "couple": torques, "ngsolve": ngsolve_version()}
    points: list[dict[str, Any]] = []
    with Journal(checkpoint, journal_header("fe map", robot, options.facts(robot) | facts)) as journal:
        whole = journal.known // len(pairs)  # couples whose points are all known
        work = partial(_of_couple, robot, joint, options, solve, pairs)
        with closing(map_shards(work, torques[whole:].tolist(), executor)) as rows:
            row: list[dict[str, Any]] = []
            for c, p in itertools.product(range(len(torques)), range(len(pairs))):

                def point(c: int = c, p: int = p) -> dict[str, Any]:
                    nonlocal row
                    if executor is None:
                        return _solved(by_elements, float(torques[c]), pairs[: p + 1])
                    row = next(rows) if p == 0 or not row else row
                    return row[p]

                points.append(journal.answer([c, p], point))
                if progress is not None:
                    progress(len(points), len(torques) * len(pairs))
    elements = _states(points, torques, len(pairs))
    faults = [one["fault"].rstrip(".") for one in points if one["fault"]]
    text = f"All {len(points)} points have an equilibrium."
    if faults:
        text = f"{len(faults)} of {len(points)} points have no equilibrium; the first: {faults[0]}."
    return JointMap(
        robot=robot,
        joint=group.name,
        options=options,
        pressure=np.array(pairs),
        couple=torques,
        elements=elements,
        model=fast_states(robot, model, np.array(pairs), elements),
        straight=straight,
        status="partial" if faults else "converged",
        status_text=text,
        seconds=float(sum(one["seconds"] for one in points)),
    )


def _of_couple(
    robot: Robot, joint: str | int, options: FeOptions, solve: Joint | None, pairs: Sequence[Pair], couple: float
) -> list[dict[str, Any]]:
    """Solve all points of a couple."""
    solve = solve or joint_by_elements(robot, joint, options)
    return [_solved(solve, couple, pairs[: p + 1]) for p in range(len(pairs))]


def _solved(solve: Joint, couple: float, path: Sequence[Pair]) -> dict[str, Any]:
    """Solve a point, and take the processor time."""
    start = time.process_time()
    return dict(solve(couple, path)) | {"seconds": time.process_time() - start}


def apart(elements: States, model: States, name: str) -> float:
    """Return the largest difference of a number of two sets of states; NaN without any."""
    difference = np.abs(getattr(model, name) - getattr(elements, name))
    return float(np.nanmax(difference)) if np.isfinite(difference).any() else math.nan


def _states(points: Sequence[Mapping[str, Any]], couple: Array, pairs: int) -> States:
    """Arrange the points of finite elements."""
    none = {"angle": math.nan, "volume": [math.nan, math.nan], "length": math.nan}
    sound = [none if one["fault"] else one for one in points]
    angle, length = (np.array([one[key] for one in sound]).reshape(-1, pairs) for key in ("angle", "length"))
    volume = np.array([one["volume"] for one in sound]).reshape(-1, pairs, 2)
    return States(angle, couple[:, None] * np.cos(angle), volume, length)


def fast_states(robot: Robot, model: JointModel, pressure: Array, elements: States) -> States:
    """Return the fast model under the elements' moments and pairs of pressures (n, 2) [Pa]."""
    group, actuator = joint_group(robot, model.name)
    shape, known = elements.angle.shape, np.isfinite(elements.angle)
    both = np.broadcast_to(pressure, (*shape, 2))[known]
    found = model.balance(both, elements.moment[known])
    held = [holding_moment(model, a, pair) for a, pair in zip(elements.angle[known], both, strict=True)]
    # The ends are stiff: their channels keep their volume, and the axis its length.
    lumen = math.pi / 4 * drive_unit(robot).inner_diameter ** 2
    ends = cast(int, group.drive_units) * lumen * (actuator.length - model["length"])
    length = actuator.length + model["length"] * (model["rest"] + found["strain"])
    states = States(*(np.full(size, math.nan) for size in (shape, shape, (*shape, 2), shape)))
    values = (found["angle"], np.array(held), found["volume"] + ends, length)
    for whole, part in zip((states.angle, states.moment, states.volume, states.length), values, strict=True):
        whole[known] = part
    return states


def holding_moment(model: JointModel, angle: float, pressure: ArrayLike) -> float:
    """Return the moment from outside [N m] that holds an angle [rad] under a pair of pressures [Pa]."""
    both = np.asarray(pressure, dtype=np.float64)

    def pulled(strain: float) -> float:
        at = model.at(angle, strain, both)
        return float(at["axial"][0] + at["gain"][0] @ both)

    at = model.at(angle, brentq(pulled, -STRAIN, STRAIN, xtol=1e-12), both)
    return -float(at["elastic"][0] + at["slope"][0] @ both)


def _pairs(pressure: ArrayLike, fill: float) -> list[Pair]:
    """Check the pressures and return them with those of the right side."""
    rising = check_pressure(pressure)
    if not rising[-1] > 0:
        raise InputError("must end above 0", key="pressure", value=shown(rising.tolist()), fix="add a higher one")
    if not 0 <= fill < math.inf:
        fix = "give the pressure that both sides have at rest, or 0"
        raise InputError("must not be negative", key="fill", value=f"{fill / 1e3:g} kPa", fix=fix)
    return [(p, max(0.0, 2 * fill - p)) for p in rising.tolist()]


def _couples(values: ArrayLike) -> Array:
    """Check couples [N m]."""
    try:
        array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        array = np.array([math.nan])
    if array.ndim != 1 or not len(array) or not np.isfinite(array).all():
        rule, fix = "must be a list of finite numbers", "give them as a list, in N m"
        raise InputError(rule, key="couple", value=shown(values), fix=fix)
    return array


def joint_by_elements(robot: Robot, joint: str | int, options: FeOptions | None = None) -> Joint:
    """Return the finite elements of a joint; they continue a path that only grows, and restart any other at rest."""
    model: Any = None
    place: tuple[float, tuple[Pair, ...]] | None = None

    def solve(couple: float, path: Sequence[Pair]) -> Mapping[str, Any]:
        nonlocal model, place
        model = model or fe_model(robot, joint, options)
        steps = list(path)
        if place == (couple, tuple(path[:-1])):
            steps = steps[-1:]
        else:  # from rest
            for load in model.problem.loads:
                load.Set(0.0)
            model.displacement.vec[:] = 0.0
        place = None
        for pair in steps:
            result = equilibrium(model, pressure=pair, couple=couple)
            if not result.converged:
                return {"fault": result.text}
        place = couple, tuple(path)
        found = measure(model)
        told = {"angle": found.angle, "volume": list(found.volume), "length": found.length}
        return told | {"fault": found.fault}

    return solve
