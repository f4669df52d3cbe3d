"""Energies of the finite elements as NGSolve expressions: silicone, hose and braid on a wall, axis, enclosed volume.

Names as in continuum mechanics: F is the deformation gradient, J its determinant, C = F' F; on a wall, a and h are the
images of the unit vectors along the channel and around it, so that C_aa = a.a, C_hh = h.h and C_ah = a.h.
"""

import math
from dataclasses import dataclass
from typing import Any

from hypertuna.actuation.silicone import Mooney
from hypertuna.ranges import Range, check_name

LAWS = ("linear", "neo_hookean", "mooney_rivlin")
SLACK = 1e-6  # stiffness of a shortened fiber over that of a taut one; at 1e-3 fibers push ten times as hard as a hose
LOOSE = 1e-4  # stiffness of a strip against leaving the arc of the joint, over its stiffness in tension

Expression = Any  # an ngsolve.CoefficientFunction


@dataclass(frozen=True)
class Solid:
    """A nearly incompressible solid: law, constants and Poisson's ratio."""

    law: str  # name in `LAWS`
    constants: Mooney  # C1 and C2 [Pa]; all laws have the shear modulus 2 (C1 + C2) at rest
    poisson: float  # Poisson's ratio

    def __post_init__(self) -> None:
        check_name(self.law, LAWS, "law", "law", f"use one of {', '.join(LAWS)}; linear is Hooke's")
        Range(min=0, below=0.5).check(self.poisson, "poisson", "use 0.475 to 0.499 for silicone")

    @property
    def shear(self) -> float:
        """Shear modulus at rest [Pa]."""
        return 2 * (self.constants.c1 + self.constants.c2)

    @property
    def bulk(self) -> float:
        """Bulk modulus [Pa]."""
        return self.shear * 2 * (1 + self.poisson) / (3 * (1 - 2 * self.poisson))


def solid_energy(solid: Solid, F: Expression) -> Expression:
    """Return the energy of a solid per volume at rest [J/m^3].

    Linear: Saint Venant and Kirchhoff, Hooke's law between Green's strain and the second Piola-Kirchhoff stress, since
    small strains do not allow large rotations. Else C1 (I1 J^(-2/3) - 3) + C2 (I2 J^(-4/3) - 3) + kappa/2 (J - 1)^2.
    """
    from ngsolve import Det, Id, InnerProduct, Trace

    C = F.trans * F
    mu, kappa = solid.shear, solid.bulk
    if solid.law == "linear":
        E = 0.5 * (C - Id(3))
        deviator = E - Trace(E) / 3 * Id(3)
        return mu * InnerProduct(deviator, deviator) + kappa / 2 * Trace(E) ** 2
    J = Det(F)
    c1, c2 = (solid.constants.c1, solid.constants.c2) if solid.law == "mooney_rivlin" else (mu / 2, 0.0)
    shape = c1 * (J ** (-2 / 3) * Trace(C) - 3)
    if c2:
        shape = shape + c2 * (J ** (-4 / 3) * 0.5 * (Trace(C) ** 2 - InnerProduct(C, C)) - 3)
    return shape + kappa / 2 * (J - 1) ** 2


def nominal_stress(solid: Solid, F: Expression) -> Expression:
    """Return the first Piola-Kirchhoff stress [Pa], the derivative of the energy with respect to F."""
    variable = F.MakeVariable()
    return solid_energy(solid, variable).Diff(variable)


@dataclass(frozen=True)
class Wall:
    """Hose and braid on the wall of a channel, for their energies per area."""

    outer: float  # radius of hose and channel at rest [m]
    inner: float  # radius of the hose at rest [m]
    hose: Mooney  # elastic constants [Pa] of the incompressible hose
    braid_angle: float  # angle of the fibers from the axis [rad]
    braid_stiffness: float  # stiffness of each family of fibers, modulus times net thickness [N/m]
    slack: float = SLACK  # stiffness of a shortened fiber over that of a taut one


def hose_energy(wall: Wall, Caa: Expression, Chh: Expression, Cah: Expression) -> Expression:
    """Return the energy of the hose per outer area at rest [J/m^2]: the thick wall of core muscle.hpp, applied locally.

    Since the wall is incompressible, the hoop stretch at the radius R follows from the hoop stretch at the outer face:
    r^2 = (R^2 + B) / lambda with B = R_o^2 (lambda lambda_h^2 - 1). This is exact for uniform stretch and swelling;
    shear along the wall is assumed uniform through its thickness.
    """
    from ngsolve import log, sqrt

    inner, outer = wall.inner**2, wall.outer**2
    section = outer - inner
    hoop2 = (Caa * Chh - Cah * Cah) / Caa  # across the stretched axis
    stretch = sqrt(Caa)
    B = outer * (stretch * hoop2 - 1)
    logarithm = log(outer * (inner + B) / (inner * (outer + B)))
    c1, c2 = wall.hose.c1, wall.hose.c2
    axial = c1 * (Caa + 2 / stretch - 3) + c2 * (1 / Caa + 2 * stretch - 3)
    swelling = B * logarithm * (c1 / stretch + c2 * stretch)
    shear = section * (c1 + c2) * Cah * Cah / Caa
    return (section * axial + swelling + shear) / (2 * wall.outer)


def fiber_stretches(wall: Wall, Caa: Expression, Chh: Expression, Cah: Expression) -> tuple[Expression, Expression]:
    """Return the stretches of the two families of fibers, wound in opposite directions."""
    from ngsolve import sqrt

    c, s = math.cos(wall.braid_angle), math.sin(wall.braid_angle)
    along = c * c * Caa + s * s * Chh
    return sqrt(along + 2 * s * c * Cah), sqrt(along - 2 * s * c * Cah)


def braid_energy(wall: Wall, Caa: Expression, Chh: Expression, Cah: Expression) -> Expression:
    """Return the energy of the braid per area at rest [J/m^2]: nearly inextensible fibers, slack when shortened."""
    from ngsolve import IfPos

    stretches = fiber_stretches(wall, Caa, Chh, Cah)
    return sum(wall.braid_stiffness / 2 * IfPos(lam - 1, 1.0, wall.slack) * (lam - 1) ** 2 for lam in stretches)


@dataclass(frozen=True)
class Axis:
    """The member that holds a joint's axis, modeled as a strip of the neutral layer."""

    stiffness: float  # tensile stiffness E A [N]
    buckling: float  # largest compression [N]; infinite if it never buckles
    width: float  # width of the strip [m]; 0 for none


def axis_energy(axis: Axis, pulled: Expression, pushed: Expression) -> Expression:
    """Return the energy of the strip per area at rest [J/m^2] from its strains.

    pulled: strain that counts in tension. pushed: strain that counts in compression.
    """
    from ngsolve import IfPos

    limited, limit = pushed, axis.buckling / axis.stiffness
    if math.isfinite(limit):
        limited = IfPos(pushed + limit, pushed, -limit)
    energy = IfPos(pulled, pulled * pulled / 2, 0) + IfPos(-pushed, limited * (pushed - limited / 2), 0)
    return axis.stiffness / axis.width * energy


def aligned_axis_energy(axis: Axis, along: Expression, turn: Expression) -> Expression:
    """Return the energy of the strip per area at rest [J/m^2] from `along`, the image of the unit vector along it.

    A strip without bending stiffness would wrinkle in compression as finely as the mesh allows. Here the compression
    acts along the arc of the joint, whose angle is `turn`, and does not bend the strip out of the arc.
    """
    from ngsolve import CF, InnerProduct, Norm, cos, sin

    across = InnerProduct(along, CF((-sin(turn), cos(turn), 0)))
    pushed = InnerProduct(along, CF((cos(turn), sin(turn), 0))) - 1
    guide = LOOSE / 2 * axis.stiffness / axis.width * across * across
    return axis_energy(axis, Norm(along) - 1, pushed) + guide


def cavity(place: Expression, F: Expression, normal: Expression) -> Expression:
    """Return the enclosed volume per area at rest, -x . cof(F) N / 3 (Gauss), to integrate over a closed surface [m].

    With the potential minus pressure times volume, a pressure follows the surface and has a symmetric tangent. Plane
    faces through the origin that stay in their plane contribute nothing and may be omitted.
    """
    from ngsolve import Cof, InnerProduct

    return -InnerProduct(place, Cof(F) * normal) / 3
