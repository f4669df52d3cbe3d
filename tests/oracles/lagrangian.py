"""A symbolic Lagrangian of a short chain with anisotropic added mass, by sympy: nothing but the kinetic energy is
written by hand.

Coordinates: nose x, y, head angle, joint angles (world frame). Kinetic energy of a link: ``1/2 m |v_c|^2 + 1/2 I w^2``
(center of mass c) and of its water ``1/2 (m_t v_t^2 + m_n v_n^2 + J w^2)`` with v at the link's middle. Euler and
Lagrange: ``d/dt dT/dqd - dT/dq = torque``, that is ``M(q) qdd + h(q, qd) = torque``, with M = d2T/dqd2 and h = (d2T/dqd
dq) qd - dT/dq.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import sympy as sp

from oracles.planar import Chain, Joints, Real, Strip

PARAMETERS = ("length", "com", "mass", "inertia", "tangential", "normal", "turning")


def kinetic_energy(q: sp.Matrix, qd: sp.Matrix, p: dict[str, tuple[sp.Symbol, ...]]) -> sp.Expr:
    """Kinetic energy of links and water; ``p`` holds one symbol per link under each name of PARAMETERS."""
    energy: sp.Expr = sp.Integer(0)
    front = sp.Matrix(q[:2])
    angle = turn = sp.Integer(0)
    for i in range(len(q) - 2):
        angle, turn = angle + q[2 + i], turn + qd[2 + i]
        t = sp.Matrix([sp.cos(angle), sp.sin(angle)])
        n = sp.Matrix([-sp.sin(angle), sp.cos(angle)])
        center = (front + p["com"][i] * t).jacobian(q) * qd
        middle = (front + p["length"][i] / 2 * t).jacobian(q) * qd
        energy += (p["mass"][i] * center.dot(center) + (p["inertia"][i] + p["turning"][i]) * turn**2) / 2
        energy += (p["tangential"][i] * t.dot(middle) ** 2 + p["normal"][i] * n.dot(middle) ** 2) / 2
        front = front + p["length"][i] * t
    return energy


@lru_cache
def equations(links: int) -> Callable[..., tuple[Real, Real]]:
    """Compiled ``f(q, qd, *parameters) -> (M, h)`` for a number of links; a second or two, once per process."""
    q = sp.Matrix(sp.symbols(f"q0:{links + 2}"))
    qd = sp.Matrix(sp.symbols(f"v0:{links + 2}"))
    p = {name: sp.symbols(f"{name}0:{links}") for name in PARAMETERS}
    energy = sp.Matrix([kinetic_energy(q, qd, p)])
    momentum = energy.jacobian(qd).T
    matrix = momentum.jacobian(qd)
    bias = momentum.jacobian(q) * qd - energy.jacobian(q).T
    return sp.lambdify([list(q), list(qd), *(list(p[name]) for name in PARAMETERS)], [matrix, bias], cse=True)


def solve(chain: Chain, water: Strip, joints: Joints, state: Real) -> tuple[Real, Real]:
    """World accelerations of nose and head angle (3,) and joint torques (n - 1,), without drag, for ``state`` (6,)."""
    q = np.concatenate([state[:3], joints.angle[1:]])
    qd = np.concatenate([state[3:], joints.rate[1:]])
    tangential, normal = water.mu_tangential * chain.length, water.mu_normal * chain.length
    matrix, bias = equations(len(chain.mass))(
        q, qd, chain.length, chain.com, chain.mass, chain.inertia, tangential, normal, water.added_inertia
    )
    matrix, bias = np.asarray(matrix, float), np.asarray(bias, float)[:, 0]
    given = joints.acceleration[1:]
    base = np.linalg.solve(matrix[:3, :3], -bias[:3] - matrix[:3, 3:] @ given)
    return base, matrix[3:, :3] @ base + matrix[3:, 3:] @ given + bias[3:]
