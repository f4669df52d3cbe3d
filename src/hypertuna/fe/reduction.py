"""Reduced joint: finite elements on a grid of pressures and couples, and the twin's table that fits them best.

At an angle alpha and pressures P the body settles at its minimum of energy, which leaves one potential,

    Pi(alpha, P) = min over u of W - sum_s P_s V_s,    M = dPi/dalpha,    V_s = -dPi/dP_s

with M the external moment; potential.py fits the twin's table to it. A body in three dimensions also shortens, with the
sum of its pressures and nearly independent of its angle, which no table over the angle can represent. Two sides that
share their oil keep that sum: by default the right pressure is twice the fill pressure minus the left pressure.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.actuation.bending import check_pressure
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import joint_group, joint_tables
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot, load, parse
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError, shown
from hypertuna.fe.bend import ngsolve_version
from hypertuna.fe.measure import measure
from hypertuna.fe.model import FeOptions, equilibrium, fe_model
from hypertuna.fe.potential import Potential, Residual, Samples, best_potential, residual
from hypertuna.io.checkpoint import Journal
from hypertuna.io.files import dataset

if TYPE_CHECKING:
    import xarray as xr

ANGLES = 49  # rows of a table: a spline through them is the fitted polynomials to 1e-5
STRONGEST = 0.5  # largest couple by default, over the moment of the largest pressure on the straight joint


@dataclass(frozen=True)
class ReducedJoint:
    """A joint by finite elements, and the twin's table that fits it best."""

    robot: Robot
    joint: str
    options: FeOptions
    pressure: Array  # (n, 2) of the left and right side [Pa]
    couple: Array  # (m,) on the tip plate; the moment is couple x cos(angle) [N m]
    angle: Array  # (m, n) NaN for points without equilibrium [rad]
    moment: Array  # (m, n) the same [N m]
    volume: Array  # (m, n, 2) oil in the drive units of each side [m^3]
    length: Array  # (m, n) of the bent axis [m]; a result, no part of the fit
    # Its compliance c is the volume of a side per own pressure, its cross d per pressure of the other side. At a
    # constant sum of both, c - d is the line's ``compliance_m3_pa``; the twin has no counterpart of d.
    potential: Potential
    residual: Residual  # of the fit
    residual_new: Residual  # of couples left out of the fit
    status: str  # "converged", or "partial" without equilibrium at some points
    status_text: str  # sentence
    seconds: float  # processor time of all points [s]

    def table(self, angles: int = ANGLES) -> dict[str, list[float]]:
        """Return the table ``[joints.reduced]`` of a description."""
        half = np.linspace(math.degrees(self.potential.reach), 0, angles // 2, endpoint=False)
        degrees = np.concatenate([-half, np.zeros(angles % 2), half[::-1]]).round(6)
        angle = np.radians(degrees)
        columns = (degrees, self.potential.elastic(angle), self.potential.volume(angle))
        keys = ("angle_deg", "elastic_n_m", "volume_m3")
        return {key: [float(f"{x:.9g}") for x in column] for key, column in zip(keys, columns, strict=True)}

    def over_angle(self, angle: ArrayLike) -> tuple[Array, Array]:
        """Interpolate the points at angles (k,) [rad]: moment (k, n) [N m] and volumes (k, n, 2) [m^3]."""
        from scipy.interpolate import PchipInterpolator  # slow to import

        where = np.asarray(angle, dtype=np.float64)
        values = np.full((len(where), len(self.pressure), 3), np.nan)
        for p in range(len(self.pressure)):
            known = np.flatnonzero(np.isfinite(self.angle[:, p]))
            order = known[np.argsort(self.angle[known, p])]
            if len(order) > 1:
                points = np.column_stack([self.moment[order, p], self.volume[order, p]])
                values[:, p] = PchipInterpolator(self.angle[order, p], points, extrapolate=False)(where)
        return values[..., 0], values[..., 1:]

    def dataset(self) -> xr.Dataset:
        """Return all numbers as a labeled dataset."""
        grid, table = ("couple", "pressure"), np.linspace(-self.potential.reach, self.potential.reach, ANGLES)
        moment, volume = self.over_angle(table)
        held = self.potential.volume(table)
        variables = {
            "moment_at": (("table", "pressure"), moment, "N m", "moment at that angle"),
            "volume_at": (("table", "pressure", "side"), volume, "m3", "oil at that angle"),
            "angle": (grid, self.angle, "rad", "angle of the tip"),
            "moment": (grid, self.moment, "N m", "moment from outside"),
            "volume": ((*grid, "side"), self.volume, "m3", "oil in the drive units of a side"),
            "length": (grid, self.length, "m", "length of the bent axis"),
            "other": ("pressure", self.pressure[:, 1], "Pa", "gauge pressure, right side"),
            "elastic": ("table", self.potential.elastic(table), "N m", "moment at no pressure"),
            "held": ("table", held, "m3", "oil in the left side"),
            "pressure": ("pressure", self.pressure[:, 0], "Pa", "gauge pressure, left side"),
            "couple": ("couple", self.couple, "N m", "couple on the tip"),
            "table": ("table", table, "rad", "angle of the table"),
        }
        facts = provenance(self.robot, water=False) | {"joint": self.joint, "source": self.source}
        return dataset(variables, {"side": list(SIDES)}, facts)

    def record(self) -> dict[str, Any]:
        """Return all numbers with units in their names: over couples and pressures; the table, over its own angles."""
        fit, fitted, new = self.potential, self.table(), self.residual_new
        moment, volume = self.over_angle(np.radians(fitted["angle_deg"]))
        facts = {"ngsolve_version": ngsolve_version(), "joint": self.joint} | self.options.facts(self.robot)
        return (
            provenance(self.robot, water=False)
            | facts
            | {
                "mesh": str(self.options.mesh),
                "pressure_left_kpa": self.pressure[:, 0] / 1e3,
                "pressure_right_kpa": self.pressure[:, 1] / 1e3,
                "couple_n_m": self.couple,
                "angle_deg": np.degrees(self.angle),
                "moment_n_m": self.moment,
                "volume_left_ml": 1e6 * self.volume[..., 0],
                "volume_right_ml": 1e6 * self.volume[..., 1],
                "length_mm": 1e3 * self.length,
                "table": fitted,
                "over_angle": {"moment_n_m": moment, "volume_left_ml": 1e6 * volume[..., 0]},
                "terms": {"elastic": len(fit.elastic_terms), "volume": len(fit.volume_terms)},
                "compliance_m3_pa": fit.compliance,
                "cross_compliance_m3_pa": fit.cross,
                "moment_rms_n_m": self.residual.moment,
                "volume_rms_ml": 1e6 * self.residual.volume,
                "moment_rms_left_out_n_m": new.moment,
                "volume_rms_left_out_ml": 1e6 * new.volume,
                "seconds": self.seconds,
                "status": self.status,
                "status_text": self.status_text,
            }
        )

    @property
    def material(self) -> str:
        """Material set."""
        return self.options.material_of(self.robot)

    @property
    def source(self) -> str:
        """Source of the table, a sentence for the description."""
        options = self.options
        return (
            f"joint {self.joint}: finite elements, mesh {options.mesh}, material set {self.material}, law "
            f"{options.law}, nu = {options.poisson:g}, {np.isfinite(self.angle).sum()} points up to "
            f"{self.pressure.max() / 1e3:g} kPa; residuals of {1e3 * self.residual.moment:.2g} mN m and "
            f"{1e6 * self.residual.volume:.2g} ml rms"
        )


def reduce_joint(
    robot: Robot,
    joint: str | int,
    *,
    pressure: ArrayLike,
    couple: ArrayLike | None = None,
    fill: float | None = None,
    options: FeOptions | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    solve: Joint | None = None,
) -> ReducedJoint:
    """Solve a joint on a grid of pressures and couples, and fit the twin's table to it.

    `pressure` (n,) of the left side [Pa]; `couple` (m,) [N m] and `fill` [Pa] have defaults. The journal `checkpoint`
    resumes the work; `solve` replaces the finite elements.
    """
    group, _ = joint_group(robot, joint)
    options = options or FeOptions()
    if fill is None:
        fill = group.line.fill_pressure if group.line else 0.0
    pairs = _pairs(pressure, fill)
    torques = couples(robot, joint, pairs) if couple is None else _couples(couple)
    solve = solve or joint_by_elements(robot, joint, options)
    facts = {"joint": group.name, "pressure": pairs, "couple": torques, "ngsolve": ngsolve_version()}
    header = journal_header("fe reduce", robot, options.facts(robot) | facts)
    points: list[dict[str, Any]] = []
    with Journal(checkpoint, header) as journal:
        for c, p in itertools.product(range(len(torques)), range(len(pairs))):

            def point(c: int = c, p: int = p) -> dict[str, Any]:
                start = time.process_time()
                answer = solve(float(torques[c]), pairs[: p + 1])
                return dict(answer) | {"seconds": time.process_time() - start}

            points.append(journal.answer([c, p], point))
            if progress is not None:
                progress(len(points), len(torques) * len(pairs))
    return _reduced(robot, group.name, options, np.array(pairs), torques, points)


def couples(robot: Robot, joint: str | int, pairs: Sequence[Pair], count: int = 5) -> Array:
    """Return couples [N m] that bend a joint about as far as pairs of pressures [Pa] do."""
    name = joint_group(robot, joint)[0].name
    table = next(table for table in joint_tables(robot) if table.name == name)
    largest = STRONGEST * max(map(max, pairs)) * table.at([0.0])["slope"][0, 0]
    return np.linspace(-1, 1, count) * float(f"{largest:.2g}")


def with_reduced(robot: Robot, reduced: ReducedJoint) -> Robot:
    """Return a robot with the reduced joint in its tables ``[joints.reduced]`` and ``[sources]``."""
    joint_group(robot, reduced.joint)
    document = robot.document()
    next(group for group in document["joints"] if group["name"] == reduced.joint)["reduced"] = reduced.table()
    sources = document.setdefault("sources", {})
    parts = [part for part in sources.get("joints.reduced", "").split(" | ") if part]
    kept = [part for part in parts if not part.startswith(f"joint {reduced.joint}:")]
    sources["joints.reduced"] = " | ".join([*kept, reduced.source])
    return parse(document, file=robot.file)


def write_reduced(robot: str | Path, reduced: ReducedJoint, output: str | Path) -> Path:
    """Write the file of a robot with a reduced joint in it, comments and layout kept."""
    return write_robot(with_reduced(load(robot), reduced), output, note="reduced, see [sources]")


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


def _reduced(
    robot: Robot, joint: str, options: FeOptions, pressure: Array, couple: Array, points: Sequence[Mapping[str, Any]]
) -> ReducedJoint:
    """Arrange the points and fit the table."""
    shape = len(couple), len(pressure)
    none = {"angle": math.nan, "volume": [math.nan, math.nan], "length": math.nan}
    sound = [none if point["fault"] else point for point in points]
    angle = np.array([point["angle"] for point in sound]).reshape(shape)
    volume = np.array([point["volume"] for point in sound]).reshape(*shape, 2)
    length = np.array([point["length"] for point in sound]).reshape(shape)
    moment = couple[:, None] * np.cos(angle)
    c, p = np.nonzero(np.isfinite(angle))
    groups = c if len(couple) > 2 else p  # fits without one group still need moments that turn the joint
    samples = Samples(groups, angle[c, p], moment[c, p], pressure[p], volume[c, p]).with_mirror()
    best, residual_new = best_potential(samples)
    faults = [point["fault"].rstrip(".") for point in points if point["fault"]]
    text = f"All {angle.size} points have an equilibrium."
    if faults:
        text = f"{len(faults)} of {angle.size} points have no equilibrium; the first: {faults[0]}."
    if best.reach < (bend_max := joint_group(robot, joint)[0].bend_max or 0.0):
        reach, wanted = math.degrees(best.reach), math.degrees(bend_max)
        text += f" The table ends at {reach:.3g} deg, short of bend_max_deg = {wanted:g}: use larger couples."
    return ReducedJoint(
        robot=robot,
        joint=joint,
        options=options,
        pressure=pressure,
        couple=couple,
        angle=angle,
        moment=moment,
        volume=volume,
        length=length,
        potential=best,
        residual=residual(best, samples),
        residual_new=residual_new,
        status="partial" if faults else "converged",
        status_text=text,
        seconds=float(sum(point["seconds"] for point in points)),
    )


Pair = tuple[float, float]
# Solves a joint under a couple [N m] at the end of a path of pairs of pressures [Pa]: angle [rad], volume [m^3] of
# each side, length of the bent axis [m], fault (a sentence, empty without one).
Joint = Callable[[float, Sequence[Pair]], Mapping[str, Any]]


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
        measured = measure(model)
        told = {"angle": measured.angle, "volume": list(measured.volume), "length": measured.length}
        return told | {"fault": measured.fault}

    return solve
