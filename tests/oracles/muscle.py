"""A muscle by Cauchy stresses summed through its walls, as Eqs 4-17 corrected have it."""

from __future__ import annotations

import math

import numpy as np

OUTER, INNER, BRAID = 8e-3, 5.6e-3, math.radians(37)
HOSE, SLEEVE = (40e3, 7e3), (20e3, 3e3)


def stresses(
    solid: tuple[float, float], x1: float, x2: float, stretch: float, swelling: float
) -> tuple[float, float, float, float]:
    """Sum Cauchy stresses through a wall by Gauss's rule: hoop, axial force, inner and outer radius now.

    Hoop: the pressure that the wall carries, int (sigma_theta - sigma_r) dr / r. Axial force: of sigma_z, with
    sigma_r = 0 at the outer face, so that a pressure there adds its share of the section.
    """
    nodes, weights = np.polynomial.legendre.leggauss(40)
    c1, c2 = solid
    r1, r2 = (math.sqrt((x + swelling) / stretch) for x in (x1, x2))

    def deviators(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        reference = np.sqrt(stretch * r**2 - swelling)
        l2, l3 = r / reference, reference / (r * stretch)
        hoop = 2 * c1 * (l2**2 - l3**2) - 2 * c2 * (l2**-2 - l3**-2)  # sigma_theta - sigma_r, Eq. 9
        axial = 2 * c1 * (stretch**2 - l3**2) - 2 * c2 * (stretch**-2 - l3**-2)  # sigma_z - sigma_r, Eq. 8
        return hoop, axial

    def between(a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
        return 0.5 * (b - a) * nodes + 0.5 * (a + b), 0.5 * (b - a) * weights

    r, dr = between(r1, r2)
    hoop, axial = deviators(r)
    carried = float((hoop / r) @ dr)
    radial = []
    for radius in r:  # equilibrium d sigma_r / dr = (sigma_theta - sigma_r) / r from the outer face inward
        s, ds = between(radius, r2)
        radial.append(-float((deviators(s)[0] / s) @ ds))
    force = float((2 * math.pi * r * (np.array(radial) + axial)) @ dr)
    return carried, force, r1, r2


def pull_by_stresses(
    stretch: float, pressure: float, sleeve: float = 0.0, matrix: tuple[float, float] = SLEEVE
) -> tuple[float, float]:
    """Pull [N] and the pressure that the walls carry [Pa], by Eqs 4-17 corrected."""
    c, n = 1 / math.cos(BRAID), math.tan(BRAID) / (math.pi * OUTER)  # strand and turns, both per length at rest
    theta = math.acos(stretch / c)
    diameter = c * math.sin(theta) / (math.pi * n)
    swelling = stretch * diameter**2 / 4 - OUTER**2 / 4
    radius = OUTER / 2
    hose, axial, r1, r2 = stresses(HOSE, INNER**2 / 4, radius**2, stretch, swelling)
    outside = pressure - hose  # P_t, the pressure on the outside of the hose
    from_sleeve, axial_sleeve = 0.0, 0.0
    if sleeve:
        from_sleeve, axial_sleeve, _, _ = stresses(matrix, radius**2, (radius + sleeve) ** 2, stretch, swelling)
    braid = outside - from_sleeve  # P_b = P_t - P_s
    binding = braid * math.pi * diameter**2 / (2 * math.tan(theta) ** 2)  # Eqs 14-15
    wall = axial - outside * math.pi * (r2**2 - r1**2)  # Eq. 17 with the stress of the outer face added
    x = radius**2, (radius + sleeve) ** 2
    bar = math.pi * (x[1] - x[0]) * 2 * (matrix[0] * (stretch - stretch**-2) + matrix[1] * (1 - stretch**-3))
    swelling_force = axial_sleeve - bar if sleeve else 0.0  # its stretch is the joint's
    return binding - pressure * math.pi * r1**2 + wall + swelling_force, hose + from_sleeve
