"""Lighthill's large-amplitude elongated-body theory (1971) on a chain, straight from its integrals.

Nothing here knows of inertia matrices, Kirchhoff's equations or a moving frame. The water's momentum is
``p = integral(mu v_n n ds)`` over the body, its moment of momentum about a fixed point ``integral(r x mu v_n n ds)``;
both are summed up by Gauss's rule with many points, and differentiated in time by finite differences along a motion
whose positions and velocities are Taylor polynomials. The trailing edge adds mu (v_t v_n n - 1/2 v_n^2 t).
Points are complex numbers as in ``planar``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from oracles.planar import Chain, Joints, Motion, Plane, Real, cross, dot, motion

POINTS = 12  # of Gauss's rule per link: exact to rounding, the integrands are cubic
STEP = 2e-5  # s


@dataclass(frozen=True)
class Slender:
    """Added mass per length across every link and at the trailing edge [kg/m], drag per length [kg/m^2]; (n,)."""

    mu: Real
    mu_edge: float
    quadratic_normal: Real
    quadratic_tangential: Real


def slender(chain: Chain, density: float, lateral_area: Real, wetted_area: Real, given: dict[str, Real]) -> Slender:
    """Coefficients of a robot file (``[water.elongated]``) to quantities per length; areas (n,) in m^2."""
    depth = lateral_area / chain.length
    circle = density * np.pi / 4 * depth**2
    return Slender(
        given["added_mass_normal"] * circle,
        float(given["added_mass_edge"] * circle[-1]),
        density * given["drag_normal"] * depth / 2,
        density * given["drag_tangential"] * wetted_area / chain.length / 2,
    )


def moved(chain: Chain, joints: Joints, state: Real, base: Real, time: float) -> Motion:
    """The chain a moment later: angles and positions to second order, rates and velocities to first."""
    later = Joints(
        joints.angle + time * joints.rate + time**2 / 2 * joints.acceleration,
        joints.rate + time * joints.acceleration,
        joints.acceleration,
    )
    place = state[:3] + time * state[3:] + time**2 / 2 * base
    return motion(chain, later, np.concatenate([place, state[3:] + time * base]), base)


def momentum(chain: Chain, water: Slender, m: Motion, about: complex, first: int) -> Real:
    """Momentum x, y and moment of momentum about a point, of the links from ``first`` on and their water (3,)."""
    place, v, _ = m.at(chain.com)
    p = chain.mass * v
    spin = cross(place - about, p) + chain.inertia * m.turn
    for node, weight in zip(*np.polynomial.legendre.leggauss(POINTS), strict=True):
        place, v, _ = m.at(chain.length * (1 + node) / 2)
        n = 1j * m.axis
        share = chain.length * weight / 2 * water.mu * dot(n, v) * n
        p = p + share
        spin = spin + cross(place - about, share)
    return np.array([p[first:].sum().real, p[first:].sum().imag, spin[first:].sum()])


def forces(chain: Chain, water: Slender, m: Motion, about: complex, first: int) -> Real:
    """Drag on the links from ``first`` on and the force at the trailing edge, with their moment about a point (3,)."""
    force, moment = 0j, 0.0

    def add(place: Plane, f: Plane) -> None:
        nonlocal force, moment
        force += f[first:].sum()
        moment += cross(place - about, f)[first:].sum()

    for node, weight in zip(*np.polynomial.legendre.leggauss(4), strict=True):  # four, as the core
        place, v, _ = m.at(chain.length * (1 + node) / 2)
        v_t, v_n = dot(m.axis, v), dot(1j * m.axis, v)
        f = -water.quadratic_tangential * v_t * abs(v_t) - 1j * water.quadratic_normal * v_n * abs(v_n)
        add(place, f * m.axis * chain.length * weight / 2)
    place, v, _ = m.at(chain.length)
    v_t, v_n = dot(m.axis, v)[-1], dot(1j * m.axis, v)[-1]
    edge = np.zeros(len(chain.mass), dtype=np.complex128)
    edge[-1] = water.mu_edge * (1j * min(v_t, 0.0) * v_n - v_n**2 / 2) * m.axis[-1]  # backward, nothing is left behind
    add(place, edge)
    return np.array([force.real, force.imag, moment])


def lacking(chain: Chain, water: Slender, joints: Joints, state: Real, base: Real, first: int = 0) -> Real:
    """What acts on the links from ``first`` on beside the water, by the theory (3,): moment about the joint ahead."""
    now = moved(chain, joints, state, base, 0.0)
    about = complex(now.place[first])

    def at(time: float) -> Real:
        return momentum(chain, water, moved(chain, joints, state, base, time), about, first)

    rate = (8 * (at(STEP) - at(-STEP)) - (at(2 * STEP) - at(-2 * STEP))) / (12 * STEP)
    return rate - forces(chain, water, now, about, first)


def without_drag(water: Slender) -> Slender:
    """Only the reactive forces left."""
    return replace(water, quadratic_normal=0 * water.mu, quadratic_tangential=0 * water.mu)
