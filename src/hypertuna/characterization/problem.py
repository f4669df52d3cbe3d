"""Residuals of bench runs as a function of the unknowns, with the bounds as a prior."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.bending import bend
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.arrays import Array
from hypertuna.characterization.data import Bench
from hypertuna.characterization.unknowns import Unknown, unknowns, with_unknowns
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.identification.loss import LOSSES
from hypertuna.ranges import Whole, check_name

KINDS = ("angle", "volume")
STEP = 1e-4  # of a logarithm, for central differences
ROUGH_STEP = 1e-6  # the same, for one-sided differences
FAILED = 1e3  # residual, in standard deviations, of a bend without a solution
STARTS = Whole(min=1, max=1024)


@dataclass(frozen=True)
class BenchProblem:
    """Bench and unknowns, laid out for a fit.

    A point z (n,) is the logarithm of every unknown from its described value, in units of its prior standard deviation.
    """

    robot: Robot
    bench: Bench
    free: tuple[Unknown, ...]
    loss: str
    measured: Array  # (elements,), angles of all rows [rad], then the volumes that were measured [m^3]
    kind: NDArray[np.int64]  # (elements,), index into KINDS
    sd: Array  # (elements,), stated noise, NaN for none
    with_volume: NDArray[np.int64]  # rows of the bench that have a volume

    @property
    def prior_sd(self) -> Array:
        """Prior standard deviation (n,) of each logarithm."""
        return np.array([one.prior_sd for one in self.free])

    @property
    def unknown_kinds(self) -> tuple[str, ...]:
        """Kinds whose noise has to be estimated."""
        return tuple(KINDS[k] for k in np.unique(self.kind[np.isnan(self.sd)]))

    def bounds(self) -> tuple[Array, Array]:
        """Return the bounds as points (n,)."""
        rows = [sorted(one.log(end) - one.log(one.described) for end in (one.lower, one.upper)) for one in self.free]
        low, high = (np.array(rows) / self.prior_sd[:, np.newaxis]).T
        return low, high

    def values(self, z: Array) -> Array:
        """Return the unknowns (n,) at a point."""
        logs = (z * self.prior_sd).tolist()
        return np.array([one.value(one.log(one.described) + x) for one, x in zip(self.free, logs, strict=True)])

    def residual(self, z: Array, levels: Mapping[str, float], joint: int | None = None) -> Array:
        """Return computed minus measured over noise (elements,), then the residuals of the prior: z itself.

        levels: noise [rad and m^3] of the kinds whose noise is unknown. joint: compute its rows only, others are NaN.
        """
        robot = with_unknowns(self.robot, self.free, self.values(z), checked=False)
        try:
            angle, volume = computed(robot, self.bench, joint)
        except InputError:  # no such joint can be built, such as one without room for its hoses
            angle, volume = np.full((2, len(self.bench.angle)), np.nan)
        level = np.array([levels.get(name, np.nan) for name in KINDS])
        difference = np.concatenate([angle, volume[self.with_volume]]) - self.measured
        scaled = difference / np.where(np.isnan(self.sd), level[self.kind], self.sd)
        sound = np.where(np.isfinite(scaled), np.clip(scaled, -FAILED, FAILED), FAILED)
        own = self.bench.joint == (self.bench.joint if joint is None else joint)
        return np.concatenate([np.where(np.append(own, own[self.with_volume]), sound, np.nan), z])

    def jacobian(self, z: Array, levels: Mapping[str, float], *, rough: bool = False) -> Array:
        """Differentiate the residual: by central differences, or one-sided ones for a search."""
        step, columns = ROUGH_STEP if rough else STEP, []
        center = self.residual(z, levels) if rough else None
        for k, one in enumerate(self.free):
            change = np.zeros(len(z))
            change[k] = step / one.prior_sd
            up = self.residual(z + change, levels, one.joint)  # an unknown of one joint moves no row of another
            down = self.residual(z - change, levels, one.joint) if center is None else center
            column = (up - down) / (change[k] * (1 if rough else 2))
            columns.append(np.where(np.isnan(column), 0.0, column))
        return np.stack(columns, axis=1)


def computed(robot: Robot, bench: Bench, joint: int | None = None) -> tuple[Array, Array]:
    """Compute bends [rad] and oil volumes of drive units [m^3] of a bench, (rows,) each, NaN but for a joint's rows."""
    angle, volume = np.full((2, len(bench.angle)), np.nan)
    for loop in bench.loops:
        if joint is not None and loop.joint != joint:
            continue
        rising, place = np.unique(np.append(bench.pressure[loop.rows], loop.top), return_inverse=True)
        unload = bench.unload[loop.rows]
        curve = bend(robot, loop.joint, rising, side=SIDES[loop.side], unload=bool(unload.any()))
        path = curve.angle if curve.unload_angle is None else np.append(curve.angle, curve.unload_angle)
        on_path = np.where(unload, len(path) - 1 - place[:-1], place[:-1])  # unloading starts at the top
        angle[loop.rows], volume[loop.rows] = path[on_path], curve.volume[on_path]
    return angle, volume


def bench_problem(
    robot: Robot,
    bench: Bench,
    free: Sequence[str] | str | None,
    bounds: Mapping[str, tuple[float, float]] | None,
    loss: str,
    starts: int,
) -> BenchProblem:
    """Lay out a bench for a fit; arguments as for `hypertuna.characterization.fit.fit_bench`."""
    check_name(loss, LOSSES, "loss", "loss")
    STARTS.check(starts, "starts", "leave it out")
    both = [j for j in bench.joints if len(bench.sides(j)) == 2]
    frees = unknowns(robot, bench.joints, names=free, both_sides=both, bounds=bounds)
    rows = np.flatnonzero(np.isfinite(bench.volume))
    return BenchProblem(
        robot=robot,
        bench=bench,
        free=frees,
        loss=loss,
        measured=np.concatenate([bench.angle, bench.volume[rows]]),
        kind=np.repeat([0, 1], [len(bench.angle), len(rows)]),
        sd=np.concatenate([bench.angle_sd, np.full(len(rows), np.nan)]),
        with_volume=rows,
    )


def effective_parameters(jacobian: Array) -> float:
    """Return the trace of the hat matrix of a fit, from the Jacobian over noise, in prior standard deviations."""
    singular = np.linalg.svd(jacobian, compute_uv=False)
    return float(np.sum(singular**2 / (1 + singular**2)))
