"""The search for the unknowns of an actuator that fit bench runs best, with noise that the runs leave open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.bending import SIDES, bend
from hypertuna.characterization.data import Bench
from hypertuna.characterization.unknowns import Unknown, unknowns, with_unknowns
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.identification.prediction import LOSSES, loss_terms
from hypertuna.identification.residuals import excess

__all__ = [
    "FIRST_LEVEL",
    "KINDS",
    "ROUGH",
    "Problem",
    "computed",
    "levels",
    "pose",
    "search",
    "start_points",
    "taken_up",
]

Array = NDArray[np.float64]

KINDS = ("angle", "volume")
FIRST_LEVEL = (math.radians(1.0), 1e-7)  # rad, m^3: before the residuals tell
LEAST_LEVEL = (math.radians(1e-4), 1e-11)  # no instrument reads more finely
STEP = 1e-4  # of a logarithm, for differences to both sides
ROUGH_STEP = 1e-6  # the same, to one side
TOLERANCE, ROUGH = 1e-6, 1e-3
MOST_EVALUATIONS = 100
FAILED = 1e3  # residual, in standard deviations, of a bend that has no answer


@dataclass(frozen=True)
class Problem:
    """Bench and unknowns: what the search needs.

    A point z counts the logarithm of every unknown from its described value, in units of its spread.

    Attributes
    ----------
    robot : Robot
    bench : Bench
    free : tuple of Unknown
    loss : str
    measured : ndarray, shape (rows,)
        Angles [rad], then the volumes that were measured [m^3].
    kind : ndarray of int, shape (rows,)
        Place in `KINDS`.
    sd : ndarray, shape (rows,)
        Stated noise, NaN where there is none.
    with_volume : ndarray of int
        Rows of the bench that have a volume.
    """

    robot: Robot
    bench: Bench
    free: tuple[Unknown, ...]
    loss: str
    measured: Array
    kind: NDArray[np.int64]
    sd: Array
    with_volume: NDArray[np.int64]

    @property
    def spread(self) -> Array:
        """What counts as 1 of each logarithm."""
        return np.array([one.spread for one in self.free])

    def ends(self) -> tuple[Array, Array]:
        """Return the bounds as points."""
        rows = [sorted(one.log(end) - one.log(one.described) for end in (one.lower, one.upper)) for one in self.free]
        low, high = (np.array(rows) / self.spread[:, np.newaxis]).T
        return low, high

    def values(self, z: Array) -> Array:
        """Return the unknowns at a point."""
        logs = (z * self.spread).tolist()
        return np.array([one.value(one.log(one.described) + x) for one, x in zip(self.free, logs, strict=True)])

    def residual(self, z: Array, level: Array, joint: int | None = None) -> Array:
        """Return computed less measured over noise, then what was known before: the point itself.

        Rows of other joints than one that is asked for are not computed, but NaN.
        """
        fish = with_unknowns(self.robot, self.free, self.values(z), checked=False)
        angle, volume = computed(fish, self.bench, joint)
        off = np.concatenate([angle, volume[self.with_volume]]) - self.measured
        scaled = off / np.where(np.isnan(self.sd), level[self.kind], self.sd)
        sound = np.where(np.isfinite(scaled), np.clip(scaled, -FAILED, FAILED), FAILED)
        return np.concatenate([sound if joint is None else np.where(self.of_joint(joint), sound, np.nan), z])

    def of_joint(self, joint: int) -> NDArray[np.bool_]:
        """Tell which of the measured numbers are of a joint."""
        mine = self.bench.joint == joint
        return np.concatenate([mine, mine[self.with_volume]])

    def slope(self, z: Array, level: Array, *, rough: bool = False) -> Array:
        """Differentiate the residual: by central differences, or to one side for the way of a search.

        An unknown of one joint moves no row of another.
        """
        step, columns = ROUGH_STEP if rough else STEP, []
        here = self.residual(z, level) if rough else None
        for k, one in enumerate(self.free):
            way = np.zeros(len(z))
            way[k] = step / one.spread
            up = self.residual(z + way, level, one.joint)
            down = self.residual(z - way, level, one.joint) if here is None else here
            change = (up - down) / (way[k] * (1 if rough else 2))
            columns.append(np.where(np.isnan(change), 0.0, change))
        return np.stack(columns, axis=1)


def computed(robot: Robot, bench: Bench, joint: int | None = None) -> tuple[Array, Array]:
    """Compute what a bench measured.

    Parameters
    ----------
    robot : Robot
    bench : Bench
    joint : int, optional
        Compute its rows alone; others are NaN.

    Returns
    -------
    angle, volume : ndarray, shape (rows,)
        Bend [rad] and oil pushed into the drive units [m^3].
    """
    angle, volume = np.full((2, len(bench.angle)), np.nan)
    for loop in bench.loops:
        if joint is not None and loop.joint != joint:
            continue
        rising, place = np.unique(np.append(bench.pressure[loop.rows], loop.top), return_inverse=True)
        back = bench.unload[loop.rows]
        found = bend(robot, loop.joint, rising, side=SIDES[loop.side], unload=bool(back.any()))
        path = found.angle if found.unload_angle is None else np.append(found.angle, found.unload_angle)
        on_path = np.where(back, len(path) - 1 - place[:-1], place[:-1])  # the way back goes from the top down
        angle[loop.rows], volume[loop.rows] = path[on_path], found.volume[on_path]
    return angle, volume


def pose(
    robot: Robot,
    bench: Bench,
    free: Sequence[str] | str | None,
    bounds: Mapping[str, tuple[float, float]] | None,
    loss: str,
    starts: int,
) -> Problem:
    """Gather what the search needs.

    Parameters
    ----------
    robot : Robot
    bench : Bench
    free, bounds, loss, starts
        As for `hypertuna.characterization.fit.fit_bench`.

    Returns
    -------
    Problem

    Raises
    ------
    InputError
        If names or options cannot be used, or tables are missing.
    """
    if loss not in LOSSES:
        raise InputError("must be a known loss", key="loss", value=shown(loss), fix=did_you_mean(loss, LOSSES))
    if not 1 <= starts <= 1024:
        raise InputError("must be from 1 to 1024", key="starts", value=str(starts), fix="leave it out")
    both = [j for j in bench.joints if len(bench.sides(j)) == 2]
    frees = unknowns(robot, bench.joints, names=free, both_sides=both, bounds=bounds)
    rows = np.flatnonzero(np.isfinite(bench.volume))
    return Problem(
        robot=robot,
        bench=bench,
        free=frees,
        loss=loss,
        measured=np.concatenate([bench.angle, bench.volume[rows]]),
        kind=np.repeat([0, 1], [len(bench.angle), len(rows)]),
        sd=np.concatenate([bench.angle_sd, np.full(len(rows), np.nan)]),
        with_volume=rows,
    )


def start_points(problem: Problem, count: int, seed: int) -> list[Array]:
    """Choose where searches begin: the description, then Sobol's points within the bounds.

    Parameters
    ----------
    problem : Problem
    count, seed : int

    Returns
    -------
    list of ndarray, shape (n,)
        Points of the problem [1].
    """
    n = len(problem.free)
    points = [np.zeros(n)]
    if count > 1:
        from scipy.stats import qmc

        low, high = problem.ends()
        sobol = qmc.Sobol(n, scramble=True, rng=np.random.default_rng(seed))
        points += list(low + (high - low) * sobol.random_base2(max(math.ceil(math.log2(count - 1)), 0)))
    return points[:count]


def search(
    problem: Problem,
    start: Array,
    level: Array,
    tolerance: float = TOLERANCE,
    tick: Callable[[], None] | None = None,
) -> Any:
    """Search from one start by SciPy's trust region method; only what was measured has a robust loss.

    Parameters
    ----------
    problem : Problem
    start : ndarray, shape (n,)
        Point [1].
    level : ndarray, shape (2,)
        Noise of angles [rad] and volumes [m^3] that is not stated.
    tolerance : float
        Relative change that ends the search [1].
    tick : callable, optional
        Called at every evaluation of residuals or slopes.

    Returns
    -------
    scipy.optimize.OptimizeResult
    """
    from scipy.optimize import least_squares  # here, because it takes longer to import than a bend takes

    rows = len(problem.measured)

    def loss(square: Array) -> Array:
        terms = loss_terms("linear", square)
        terms[:, :rows] = loss_terms(problem.loss, square[:rows])
        return terms

    def residual(z: Array) -> Array:
        if tick is not None:
            tick()
        return problem.residual(z, level)

    def slope(z: Array) -> Array:
        if tick is not None:
            tick()
        return problem.slope(z, level, rough=True)

    low, high = problem.ends()
    inside = 1e-6 * (high - low)
    return least_squares(
        residual,
        np.clip(start, low + inside, high - inside),
        jac=slope,
        bounds=(low, high),
        loss="linear" if problem.loss == "linear" else loss,
        ftol=tolerance,
        xtol=tolerance,
        gtol=tolerance,
        max_nfev=MOST_EVALUATIONS,
    )


def taken_up(slope: Array) -> float:
    """Count the rows that a fit takes up: the trace of its hat matrix.

    Parameters
    ----------
    slope : ndarray, shape (rows, n)
        Of the residuals over their noise, in units of what is known without them [1].

    Returns
    -------
    float
    """
    singular = np.linalg.svd(slope, compute_uv=False)
    return float(np.sum(singular**2 / (1 + singular**2)))


def levels(problem: Problem, found: Any, level: Array) -> Array:
    """Estimate the noise that is not stated from the residuals.

    Parameters
    ----------
    problem : Problem
    found : scipy.optimize.OptimizeResult
        Where the search ended.
    level : ndarray, shape (2,)
        Noise that it was made with [rad and m^3].

    Returns
    -------
    ndarray, shape (2,)
        [rad and m^3].
    """
    rows = len(problem.measured)
    square = problem.residual(found.x, level)[:rows] ** 2
    part = 1 - taken_up(problem.slope(found.x, level, rough=True)[:rows]) / rows
    new = level.copy()
    for k, least in enumerate(LEAST_LEVEL):
        mine = (problem.kind == k) & np.isnan(problem.sd)
        if mine.any() and part > 0:
            sigma = excess(square[mine], problem.loss) / math.sqrt(part)
            new[k] = max(level[k] * sigma, least)
    return new
