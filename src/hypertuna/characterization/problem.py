"""Residuals of bench runs as a function of the unknowns, with the bounds as a prior."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from hypertuna.actuation.bending import bend
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import JointModel, joint_group, joint_models, joint_sections, soft_joint
from hypertuna.arrays import Array
from hypertuna.characterization.data import KINDS, Bench, Loop
from hypertuna.characterization.unknowns import Unknown, unknowns, with_unknowns
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.identification.loss import LOSSES
from hypertuna.ranges import Whole, check_name

STEP = 1e-4  # step of a logarithm for central differences
ROUGH_STEP = 1e-6  # step of a logarithm for one-sided differences
FAILED = 1e3  # largest residual, and residual of a value without a solution, in standard deviations
STRAIN_STEP = 0.03  # step of the strain in the search for a change of sign
STARTS = Whole(min=1, max=1024)  # allowed number of searches


@dataclass(frozen=True)
class Elements:
    """The measured values of a bench, sorted by kind; every array has one entry per value."""

    kind: NDArray[np.str_]
    row: NDArray[np.int64]  # row of the bench
    measured: Array  # [SI]
    sd: Array  # stated noise [SI], NaN if none is stated

    def of(self, rows: Mapping[str, Array]) -> Array:
        """Return the entries (elements,) that belong to the measured values, from arrays (rows,) by kind."""
        return np.array([rows[kind][row] for kind, row in zip(self.kind.tolist(), self.row.tolist(), strict=True)])


def elements(bench: Bench) -> Elements:
    """Return the measured values of a bench, sorted by kind."""
    pairs = [(kind, row) for kind in KINDS for row in np.flatnonzero(np.isfinite(getattr(bench, kind))).tolist()]
    kind, row = (np.array(column) for column in zip(*pairs, strict=True))
    measured, sd = (np.array([getattr(bench, k + end)[r] for k, r in pairs]) for end in ("", "_sd"))
    return Elements(kind, row, measured, sd)


@dataclass(frozen=True)
class BenchProblem:
    """Residuals and bounds of a fit: bench, unknowns and measured values.

    A point z (n,) holds, for every unknown, the logarithm of its value over the described one, in prior standard
    deviations.
    """

    robot: Robot
    bench: Bench
    free: tuple[Unknown, ...]
    loss: str
    elements: Elements

    @property
    def measured(self) -> Array:
        """Measured values (elements,) [SI]."""
        return self.elements.measured

    @property
    def prior_sd(self) -> Array:
        """Prior standard deviations (n,) of the unknowns' logarithms."""
        return np.array([unknown.prior_sd for unknown in self.free])

    @property
    def unknown_kinds(self) -> tuple[str, ...]:
        """Kinds of quantities without stated noise, whose noise must be estimated."""
        return tuple(dict.fromkeys(self.elements.kind[np.isnan(self.elements.sd)].tolist()))

    def bounds(self) -> tuple[Array, Array]:
        """Return the lower and upper bounds of a point z (n,)."""
        rows = [sorted(u.log(end) - u.log(u.described) for end in (u.lower, u.upper)) for u in self.free]
        low, high = (np.array(rows) / self.prior_sd[:, np.newaxis]).T
        return low, high

    def values(self, z: Array) -> Array:
        """Return the unknowns (n,) [SI] at a point."""
        logs = (z * self.prior_sd).tolist()
        return np.array([u.value(u.log(u.described) + x) for u, x in zip(self.free, logs, strict=True)])

    def residual(self, z: Array, levels: Mapping[str, float], joint: int | None = None) -> Array:
        """Return residuals at z: computed minus measured, over noise (elements,); then those of the prior, which are z.

        levels: noise [SI] of the kinds without stated noise. joint: the joint whose rows are computed, others are NaN.
        """
        robot = with_unknowns(self.robot, self.free, self.values(z), checked=False)
        try:
            values = self.elements.of(computed(robot, self.bench, joint))
        except InputError:  # the joint cannot be built: its hoses have no room, for example
            values = np.full(len(self.measured), np.nan)
        level = np.array([levels.get(name, np.nan) for name in self.elements.kind])
        scaled = (values - self.measured) / np.where(np.isnan(self.elements.sd), level, self.elements.sd)
        clipped = np.where(np.isfinite(scaled), np.clip(scaled, -FAILED, FAILED), FAILED)
        of_joint = self.bench.joint == (self.bench.joint if joint is None else joint)
        return np.concatenate([np.where(of_joint[self.elements.row], clipped, np.nan), z])

    def jacobian(self, z: Array, levels: Mapping[str, float], *, rough: bool = False) -> Array:
        """Return derivatives of the residuals with respect to z: central differences, or one-sided ones if rough."""
        step, columns = ROUGH_STEP if rough else STEP, []
        center = self.residual(z, levels) if rough else None
        for k, unknown in enumerate(self.free):
            change = np.zeros(len(z))
            change[k] = step / unknown.prior_sd
            up = self.residual(z + change, levels, unknown.joint)  # only rows of the unknown's joint
            down = self.residual(z - change, levels, unknown.joint) if center is None else center
            column = (up - down) / (change[k] * (1 if rough else 2))
            columns.append(np.where(np.isnan(column), 0.0, column))
        return np.stack(columns, axis=1)


def computed(robot: Robot, bench: Bench, joint: int | None = None) -> dict[str, Array]:
    """Return all kinds of quantities [SI] for the rows of a bench, (rows,) each; with `joint` only for its rows.

    Other entries are NaN. Rows of a held joint have a moment only, other rows have none. Oil volumes are those of
    drive units.
    """
    result = {kind: np.full(len(bench.joint), np.nan) for kind in KINDS}
    for loop in bench.loops:
        if joint is not None and loop.joint != joint:
            continue
        rising, index = np.unique(np.append(bench.pressure[loop.rows], loop.top), return_inverse=True)
        unload = bench.unload[loop.rows]
        path = _path(robot, loop, rising, unload=bool(unload.any()))
        on_path = np.where(unload, len(path["shortening"]) - 1 - index[:-1], index[:-1])  # unloading starts at the top
        for kind, values in path.items():
            result[kind][loop.rows] = values[on_path]
    for k in np.flatnonzero(np.isfinite(bench.moment)).tolist():
        if joint is None or bench.joint[k] == joint:
            pressure, side = float(bench.pressure[k]), int(bench.side[k])
            result["moment"][k] = blocked_moment(robot, int(bench.joint[k]), pressure, side, arm=float(bench.arm[k]))
    return result


def _path(robot: Robot, loop: Loop, rising: Array, *, unload: bool) -> dict[str, Array]:
    """Return the quantities along a loop from rest, for rising pressures [Pa] and, with unload, the same falling."""
    if loop.side == len(SIDES):
        return {
            "shortening": shortening(robot, loop.joint, np.concatenate([rising, rising[::-1]]) if unload else rising)
        }
    curve = bend(robot, loop.joint, rising, side=SIDES[loop.side], unload=unload)
    angle = curve.angle if curve.unload_angle is None else np.append(curve.angle, curve.unload_angle)
    length = joint_group(robot, loop.joint)[1].length
    return {"angle": angle, "volume": curve.volume, "shortening": curve.shortening * length}


def shortening(robot: Robot, joint: int, pressure: Array) -> Array:
    """Return the shortening of a joint's axis (n,) [m] under pressures of both sides (n,) [Pa]."""
    states = np.asarray(soft_joint(robot, joint).bend(np.column_stack([pressure, pressure])))
    return np.asarray(-states[..., 1] @ joint_sections(robot, joint)[:, 0])


def blocked_moment(robot: Robot, joint: int, pressure: float, side: int = 0, *, arm: float = math.inf) -> float:
    """Return the moment [N m] that holds a joint straight under the rising pressure [Pa] of one side.

    Friction reduces the moment. arm: distance [m] of the holding force from the joint's middle, as in `held_at`.
    """
    model = joint_models(robot)[joint]
    pressures = np.zeros((1, 2))
    pressures[0, side] = pressure
    strain = _strain(model, pressures)
    load = model.at(0.0, strain, pressures)
    moment = float(load["elastic"][0] + load["slope"][0] @ pressures[0]) * (1 - 2 * side)
    friction = float(load["friction"][0] @ np.maximum(0.0, pressures[0] - load["carried"][0]))
    return held_at(moment - friction, joint_group(robot, joint)[1].length, arm)


def held_at(moment: float, length: float, arm: float) -> float:
    """Return the moment [N m] of a force, `arm` [m] from a joint's middle, that replaces a couple `moment` [N m].

    A beam of the joint's length L does not move where the force acts: the couple is divided by 1 + (L / arm)^2 / 12.
    """
    return moment / (1 + (length / arm) ** 2 / 12)


def _strain(model: JointModel, pressures: Array) -> float:
    """Return the axial strain at which the axial force of a straight joint is zero; the force falls with the strain."""

    def thrust(strain: float) -> float:
        load = model.at(0.0, strain, pressures)
        return float(load["axial"][0] + load["gain"][0] @ pressures[0])

    end, step = 0.0, math.copysign(STRAIN_STEP, thrust(0.0))
    while thrust(end) * step > 0 and abs(end) < 1:
        end += step
    if not thrust(end) * step <= 0:
        rule, fix = "must have a length under this pressure", "give a lower pressure"
        raise InputError(rule, key=f"joint {model.name}", fix=fix)
    return float(brentq(thrust, end - step, end, xtol=1e-9)) if end else 0.0


def bench_problem(
    robot: Robot,
    bench: Bench,
    free: Sequence[str] | str | None,
    bounds: Mapping[str, tuple[float, float]] | None,
    loss: str,
    starts: int,
) -> BenchProblem:
    """Return the residuals of a bench; arguments as for `hypertuna.characterization.fit.fit_bench`."""
    check_name(loss, LOSSES, "loss", "loss")
    STARTS.check(starts, "starts", "leave it out")
    both_sides = [j for j in bench.joints if len(bench.sides(j)) == 2]
    frees = unknowns(robot, bench.joints, names=free, both_sides=both_sides, bounds=bounds)
    return BenchProblem(
        robot=robot,
        bench=bench,
        free=frees,
        loss=loss,
        elements=elements(bench),
    )


def effective_parameters(jacobian: Array) -> float:
    """Return the trace of a fit's hat matrix [1]; jacobian: residuals over noise, unknowns in prior deviations."""
    singular = np.linalg.svd(jacobian, compute_uv=False)
    return float(np.sum(singular**2 / (1 + singular**2)))
