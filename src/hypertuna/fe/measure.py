"""Measurements and checks of a finite-element model in equilibrium: bend, volumes, stretches, strain, stress."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.arrays import Array
from hypertuna.fe.energies import cavity, fiber_stretches, nominal_stress
from hypertuna.fe.geometry import FACES
from hypertuna.fe.model import FeModel, surface_strain

QUANTILE = 0.99  # part of the matrix' volume (strain and stress), or of the walls' area (fibers), below a quantile
TAUT = 0.02  # largest stretch of 99 % of the fibers, which should be inextensible
CHORDS = 100  # number of chords along the axis
INSIDE = 1e-9  # mm or part of the length: distance of points from faces, where they might belong to no element
MARGIN = 0.02  # relative: how far a volume may be above the braid's limit


@dataclass(frozen=True)
class Measured:
    """Measurements of a model in equilibrium: bend, volumes, stretches, strain and stress."""

    angle: float  # angle of the tip plate, counter-clockwise [rad]
    tip: tuple[float, float]  # x and y of the center of the tip plate's far face [m]
    length: float  # length of the bent axis (y = z = 0 at rest) from connector to tip plate [m]
    volume: tuple[float, float]  # oil in the drive units, left and right [m^3]
    swelling: tuple[float, float]  # volume inside the braids over that at rest, left and right [1]
    axial_stretch: tuple[float, float]  # smallest and largest on the walls of the channels [1]
    hoop_stretch: tuple[float, float]  # smallest and largest on the walls of the channels [1]
    fiber_stretch: tuple[float, float]  # smallest and largest of the braids' fibers [1]
    fiber_99: float  # 99 % quantile of the fibers' stretch by area [1]
    # Maxima, also of fibers, occur where hoses end at a plate. They grow as meshes get finer; quantiles do not.
    strain_max: float  # largest principal logarithmic strain of the matrix [1]
    strain_99: float  # 99 % quantile of that strain by volume [1]
    stress_max: float  # largest true von Mises stress of the matrix [Pa]
    stress_99: float  # 99 % quantile of that stress by volume [Pa]
    jacobian_min: float  # smallest volume ratio of the matrix [1]
    fault: str  # why the state is invalid; empty if it is valid

    def record(self) -> dict[str, float]:
        """Return all measurements by names with units."""
        record = {f"tip_{axis}_mm": 1e3 * place for axis, place in zip("xy", self.tip, strict=True)}
        record["length_mm"] = 1e3 * self.length
        for side, volume, swelling in zip(SIDES, self.volume, self.swelling, strict=True):
            record |= {f"volume_{side}_ml": 1e6 * volume, f"swelling_{side}": swelling}
        for name in ("axial", "hoop", "fiber"):
            low, high = getattr(self, f"{name}_stretch")
            record |= {f"{name}_stretch_min": low, f"{name}_stretch_max": high}
        record |= {"fiber_stretch_99": self.fiber_99, "strain_max": self.strain_max, "strain_99": self.strain_99}
        record |= {"stress_max_kpa": self.stress_max / 1e3, "stress_99_kpa": self.stress_99 / 1e3}
        return record | {"jacobian_min": self.jacobian_min}


def measure(model: FeModel) -> Measured:
    """Return the measurements of a model in equilibrium, with a fault if its state is impossible."""
    angle, tip = _tip(model)
    moved, at_rest = _inside(model), _inside(model, moved=False)
    share = 1 - (model.wall.inner / model.wall.outer) ** 2  # part of the braids' volume that hoses fill at rest
    stretches, area = _stretches(model)
    strain, stress, volume_ratio, volumes = _matrix(model)
    measured = Measured(
        angle=angle,
        tip=tip,
        length=_length(model),
        volume=(moved[0] - share * at_rest[0], moved[1] - share * at_rest[1]),
        swelling=(moved[0] / at_rest[0], moved[1] / at_rest[1]),
        axial_stretch=_ends(stretches["axial"]),
        hoop_stretch=_ends(stretches["hoop"]),
        fiber_stretch=_ends(stretches["fiber"]),
        fiber_99=_quantile(stretches["fiber"], np.tile(area, 2)),
        strain_max=float(strain.max()),
        strain_99=_quantile(strain, volumes),
        stress_max=float(stress.max()),
        stress_99=_quantile(stress, volumes),
        jacobian_min=float(volume_ratio.min()),
        fault="",
    )
    return replace(measured, fault=_fault(model, measured))


def von_mises(stress: Array) -> Array:
    """Return the von Mises stress (n,) of stresses (n, 3, 3) [Pa]."""
    deviator = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    return np.asarray(np.sqrt(1.5 * (deviator**2).sum(axis=(1, 2))))


def _length(model: FeModel) -> float:
    """Return the length of the bent axis [m]: the known length at rest, times the ratio of its chords bent and at rest.

    The mesh is in mm, shortened along x, and ends with the tip plate. The points are slightly off z = 0 in both states.
    """
    import ngsolve as ngs

    tip_x, body = max(vertex.point[0] for vertex in model.mesh.vertices), model.body
    x = tip_x * body.length / (body.length + body.plate) * np.linspace(INSIDE, 1 - INSIDE, CHORDS + 1)
    points = model.mesh(x, 0 * x, INSIDE + 0 * x)
    at_start = np.asarray(ngs.CF((ngs.x, ngs.y, ngs.z))(points))
    bent = at_start + np.asarray(model.displacement(points))
    length_at_rest, length = (np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in (at_start, bent))
    return float(length / length_at_rest) * model.body.length


def _tip(model: FeModel) -> tuple[float, tuple[float, float]]:
    """Return angle [rad] and center [m] of the tip plate's far face; the rotation is the best fit to its points."""
    import ngsolve as ngs

    def mean(field: Any) -> float:
        return float(ngs.Integrate(field * ngs.ds("tip"), model.mesh)) / area

    area = float(ngs.Integrate(ngs.CF(1.0) * ngs.ds("tip"), model.mesh))
    x, y = ngs.x + model.displacement[0], ngs.y + model.displacement[1]
    offset = ngs.y - mean(ngs.y)
    return math.atan2(-mean(x * offset), mean(y * offset)), (mean(x), mean(y))


def _inside(model: FeModel, *, moved: bool = True) -> tuple[float, float]:
    """Return the volumes inside the channels of the left and right sides [m^3], in both halves of the body."""
    import ngsolve as ngs

    place, F = ngs.CF((ngs.x, ngs.y, ngs.z)), ngs.Id(3)
    if moved:
        place, F = place + model.displacement, F + ngs.Grad(model.displacement)
    volume = cavity(place, F, ngs.specialcf.normal(3))
    left, right = (2 * float(ngs.Integrate(volume * ngs.ds(FACES[side]), model.mesh)) for side in SIDES)
    return left, right


def _stretches(model: FeModel) -> tuple[dict[str, Array], Array]:
    """Return stretches at points of the walls, and the points' areas [m^2]; "fiber": one family after the other."""
    import ngsolve as ngs

    rule = ngs.IntegrationRule(ngs.TRIG, 2 * model.options.size.order)
    points = model.mesh.MapToAllElements(rule, model.mesh.Boundaries(FACES["walls"]))
    C = surface_strain(ngs.Grad(model.displacement))
    expressions = (ngs.sqrt(C.Caa), ngs.sqrt(C.Chh), *fiber_stretches(model.wall, *C))
    axial, hoop, *fibers = (np.asarray(expression(points)).ravel() for expression in expressions)
    J = np.asarray(ngs.specialcf.JacobianMatrix(3, 2)(points)).reshape(-1, 3, 2)
    area = np.sqrt(np.linalg.det(J.transpose(0, 2, 1) @ J))
    stretches = {"axial": axial, "hoop": hoop, "fiber": np.concatenate(fibers)}
    return stretches, area * np.tile(np.array(rule.weights), len(area) // len(rule.weights))


def _matrix(model: FeModel) -> tuple[Array, Array, Array, Array]:
    """Return at points of the matrix: largest logarithmic strain, von Mises stress [Pa], volume ratio, volume [m^3]."""
    import ngsolve as ngs

    rule = ngs.IntegrationRule(ngs.TET, 4)
    points = model.mesh.MapToAllElements(rule, model.mesh.Materials("matrix"))
    F = ngs.Id(3) + ngs.Grad(model.displacement)
    gradient = np.asarray(F(points)).reshape(-1, 3, 3)
    ratio = np.linalg.det(gradient)
    piola = np.asarray(nominal_stress(model.matrix, F)(points)).reshape(-1, 3, 3)
    cauchy = piola @ gradient.transpose(0, 2, 1) / ratio[:, None, None]
    strain = np.log(np.linalg.svd(gradient, compute_uv=False)[:, 0])
    volumes = np.asarray(ngs.Det(ngs.specialcf.JacobianMatrix(3))(points)).ravel()
    volumes = volumes * np.tile(np.array(rule.weights), len(volumes) // len(rule.weights))
    return strain, von_mises(cauchy), ratio, volumes


def _quantile(values: Array, weight: Array) -> float:
    """Return the value below which 99 % of the weight lies."""
    order = np.argsort(values)
    cumulated = np.cumsum(weight[order]) / weight.sum()
    return float(values[order][np.searchsorted(cumulated, QUANTILE)])


def _ends(values: Array) -> tuple[float, float]:
    """Return the minimum and the maximum of values."""
    return float(values.min()), float(values.max())


def _fault(model: FeModel, state: Measured) -> str:
    """Return why a state is impossible (inverted elements, too much volume, stretched fibers); empty if it is not."""
    angle = model.wall.braid_angle
    limit = 2 / (3 * math.sqrt(3)) / (math.sin(angle) ** 2 * math.cos(angle))
    if state.jacobian_min <= 0:
        return "an element of the matrix is inverted"
    if max(state.swelling) > limit * (1 + MARGIN):
        return f"the braids hold {max(state.swelling):.3g} times their volume at rest; the limit is {limit:.3g}"
    if state.fiber_99 > 1 + TAUT:
        stretch = 100 * (state.fiber_99 - 1)
        return f"the braid's fibers are stretched by {stretch:.2g} %: braid_stiffness_n_per_m is too low"
    return ""
