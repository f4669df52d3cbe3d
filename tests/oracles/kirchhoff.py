"""Closed forms of one rigid elliptic cylinder of unit height in an ideal fluid (Kirchhoff; Lamb, Hydrodynamics, 71 and
124-128).

Axes t (half length a) and n (half width b) through the center, which is also the center of mass. Velocity (u, v) along
them, turning rate r.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipeinc, ellipj

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Body:
    """Sums of body and added mass along t and n [kg], and of both moments of inertia about the center [kg m^2]."""

    tangential: float
    normal: float
    inertia: float


def ellipse(a: float, b: float, density: float) -> Body:
    """Added masses and added inertia alone: pi rho b^2, pi rho a^2, pi rho (a^2 - b^2)^2 / 8."""
    return Body(np.pi * density * b**2, np.pi * density * a**2, np.pi * density * (a**2 - b**2) ** 2 / 8)


def loads(added: Body, twist: Real, rate: Real) -> Real:
    """Force along t and n and moment (3,) of the fluid on a body with twist (u, v, r) and rates of these, all in body
    axes.

    Accelerated: -m_t du/dt. Turned: the impulse turns with the body. Towed aslant: Munk's moment (m_t - m_n) u v.
    """
    u, v, r = twist
    du, dv, dr = rate
    return np.array(
        [
            -added.tangential * du + added.normal * r * v,
            -added.normal * dv - added.tangential * r * u,
            -added.inertia * dr + (added.tangential - added.normal) * u * v,
        ]
    )


def free(total: Body, twist: Real) -> Real:
    """Rates of the twist (3,) of the body left to itself."""
    u, v, r = twist
    return np.array(
        [
            total.normal * v * r / total.tangential,
            -total.tangential * u * r / total.normal,
            (total.tangential - total.normal) * u * v / total.inertia,
        ]
    )


def swaying(total: Body, impulse: float, amplitude: float, time: Real) -> Real:
    """Center x, y, angle and their rates (..., 6) at ``time`` (...) of a body swaying about broadside; it starts
    broadside at x = 0.

    The impulse is fixed in space, along x: m_t u = P cos(angle), m_n v = -P sin(angle). With angle = pi/2 + s this
    leaves the pendulum s'' = -k sin(s) cos(s), k = P^2 (1/m_t - 1/m_n) / I (m_n > m_t). Its solution is sin(s) = A
    sn(sqrt(k) t | A^2), A = sin(amplitude); the moment of impulse I angle' - y P is constant and gives y; x' = P
    (cos^2(angle)/m_t + sin^2(angle)/m_n) with sin^2(angle) = dn^2, whose integral is E.
    """
    difference = 1 / total.tangential - 1 / total.normal
    root = impulse * np.sqrt(difference / total.inertia)
    modulus = np.sin(amplitude)
    sn, cn, _, phase = ellipj(root * time, modulus**2)
    angle = np.pi / 2 + np.arcsin(modulus * sn)
    turn = modulus * root * cn
    x = impulse * (time / total.tangential - difference * ellipeinc(phase, modulus**2) / root)
    y = total.inertia * turn / impulse
    return np.stack(
        [
            x,
            y,
            angle,
            impulse * (np.cos(angle) ** 2 / total.tangential + np.sin(angle) ** 2 / total.normal),
            impulse * difference * np.sin(angle) * np.cos(angle),
            turn,
        ],
        axis=-1,
    )
