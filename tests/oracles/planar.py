"""A planar chain with prescribed joints in water: Newton and Euler in the world frame, in plain NumPy.

Points and vectors of the plane are complex numbers: ``e = exp(1j theta)`` is the axis of a link (nose to tail), ``1j *
e`` its left normal, ``dot(a, b) = Re(conj(a) b)`` and ``cross(a, b) = Im(conj(a) b)``. Every array may carry leading
axes (a batch); the last axis counts the links, nose to tail. SI units and radians. The fluid rests at infinity: for a
uniform steady current, pass velocities relative to it (accelerations and torques are Galilean invariants).

Nothing is eliminated or simplified by hand: the inertial wrench is evaluated at four base accelerations (zero and three
unit vectors), which gives the 3 x 3 matrix and the bias of the equations of motion because it is linear in them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Plane = NDArray[np.complex128]


@dataclass(frozen=True)
class Chain:
    """Rigid links; arrays (..., n).

    ``com`` is the distance of the center of mass from the link's front joint [m], ``inertia`` is about the center of
    mass [kg m^2].
    """

    length: Real
    com: Real
    mass: Real
    inertia: Real


@dataclass(frozen=True)
class Lumped:
    """The paper's water law (Eqs 33-35); arrays (..., n).

    Isotropic added mass ``added_mass * mass`` on the translation of each center of mass; friction along the link and
    drag across it at the center of mass, ``-1/2 rho c S v |v|``. Which column of Table II is ``friction_area`` [m^2]
    and which ``drag_area`` [m^2] is the caller's choice.
    """

    density: Real | float
    added_mass: Real
    friction: Real
    drag: Real
    friction_area: Real
    drag_area: Real


@dataclass(frozen=True)
class Strip:
    """Anisotropic added mass and drag per length; arrays (..., n), constant along each link.

    ``mu_normal``, ``mu_tangential`` [kg/m]: added mass per length. ``added_inertia`` [kg m^2]: of the whole link, about
    its middle. ``quadratic_*`` [kg/m^2]: ``f = -q v |v|`` per length. ``linear_*`` [N s/m^2]: ``f = -c v`` per length.
    With ``cross_flow`` the normal drag is ``-q v_n |v|``. ``quadratic_beating`` [kg/m^2] adds to q as far as the joints
    make the speed across (`beating`). ``blunt`` [kg/m]: ``f = -b v |v|`` of a whole link along itself.
    ``mu_edge`` [kg/m], ``tail_shedding``, ``suction`` and ``onset``: see `shed`.
    """

    mu_normal: Real
    mu_tangential: Real
    added_inertia: Real
    quadratic_normal: Real
    quadratic_tangential: Real
    linear_normal: Real | float = 0.0
    linear_tangential: Real | float = 0.0
    cross_flow: bool = False
    tail_shedding: float = 0.0
    onset: float = 1.0
    quadratic_beating: Real | float = 0.0
    blunt: Real | float = 0.0
    mu_edge: Real | float | None = None
    suction: float = 1.0


def strip_of(
    chain: Chain,
    density: float,
    lateral_area: Real,
    wetted_area: Real,
    *,
    added_mass_normal: Real,
    added_mass_tangential: Real,
    added_inertia: Real,
    drag_normal: Real,
    drag_tangential: Real,
    linear_normal: Real | float = 0.0,
    linear_tangential: Real | float = 0.0,
    cross_flow: bool = False,
    tail_shedding: float = 0.0,
    drag_beating: Real | float = 0.0,
    blunt_area: Real | float = 0.0,
    edge_height: float = 0.0,
    edge_lift: float = 1.0,
    edge_suction: float = 1.0,
) -> Strip:
    """Coefficients of a robot file (``[water.strip]``) to quantities per length; areas (..., n) in m^2."""
    height = lateral_area / chain.length
    reference = density * np.pi / 4 * height**2
    mu_normal = added_mass_normal * reference
    return Strip(
        mu_normal=mu_normal,
        mu_tangential=added_mass_tangential * reference,
        added_inertia=added_inertia * mu_normal * chain.length**3 / 12,
        quadratic_normal=density * drag_normal * height / 2,
        quadratic_tangential=density * drag_tangential * wetted_area / chain.length / 2,
        linear_normal=linear_normal,
        linear_tangential=linear_tangential,
        cross_flow=cross_flow,
        tail_shedding=tail_shedding * edge_lift,
        quadratic_beating=density * drag_beating * height / 2,
        blunt=density * blunt_area / 2,
        mu_edge=density * np.pi / 4 * edge_height**2 if edge_height > 0 else None,
        suction=edge_suction * (2 - edge_lift),
    )


def elongated_of(chain: Chain, density: float, lateral_area: Real, wetted_area: Real, **given: Real | float) -> Strip:
    """Elongated-body theory (``[water.elongated]``) as strips: none along, a slender moment, an edge that sheds."""
    edge = given.pop("added_mass_edge") / np.asarray(given["added_mass_normal"])[-1]
    along = {"added_mass_tangential": np.zeros_like(lateral_area), "added_inertia": np.ones_like(lateral_area)}
    water = strip_of(chain, density, lateral_area, wetted_area, **given, **along)
    return replace(water, tail_shedding=edge, onset=0.05)


Water = Lumped | Strip


@dataclass(frozen=True)
class Joints:
    """Joint angles [rad], rates, accelerations (..., n); entry i turns link i against link i - 1, entry 0 is zero."""

    angle: Real
    rate: Real
    acceleration: Real


@dataclass(frozen=True)
class Motion:
    """Axis, turning rate and acceleration of every link; its front joint's place, velocity, acceleration (..., n)."""

    axis: Plane
    turn: Real
    turn_rate: Real
    place: Plane
    velocity: Plane
    acceleration: Plane

    def at(self, s: Real) -> tuple[Plane, Plane, Plane]:
        """Place, velocity, acceleration of the material points at distance ``s`` (..., n) behind the front joints."""
        arm = s * self.axis
        return (
            self.place + arm,
            self.velocity + 1j * self.turn * arm,
            self.acceleration + (1j * self.turn_rate - self.turn**2) * arm,
        )


def dot(a: Plane, b: Plane) -> Real:
    return np.real(np.conj(a) * b)


def cross(a: Plane, b: Plane) -> Real:
    return np.imag(np.conj(a) * b)


def motion(chain: Chain, joints: Joints, state: Real, base: Real) -> Motion:
    """Kinematics of the chain.

    ``state`` (..., 6): nose x, y, head angle, and their rates, in the world frame. ``base`` (..., 3): accelerations of
    these three.
    """
    angle = state[..., 2, None] + np.cumsum(joints.angle, axis=-1)
    turn = state[..., 5, None] + np.cumsum(joints.rate, axis=-1)
    turn_rate = base[..., 2, None] + np.cumsum(joints.acceleration, axis=-1)
    axis = np.exp(1j * angle)
    arm = chain.length * axis

    def along(nose: Plane, step: Plane) -> Plane:
        """Value at each front joint: that of the nose plus the steps over all links before."""
        return nose[..., None] + np.cumsum(step, axis=-1) - step

    return Motion(
        axis,
        turn,
        turn_rate,
        along(state[..., 0] + 1j * state[..., 1], arm),
        along(state[..., 3] + 1j * state[..., 4], 1j * turn * arm),
        along(base[..., 0] + 1j * base[..., 1], (1j * turn_rate - turn**2) * arm),
    )


@dataclass(frozen=True)
class Wrench:
    """Force (..., n) on each link and moment about the link's own front joint."""

    force: Plane
    moment: Real

    def __add__(self, other: Wrench) -> Wrench:
        return Wrench(self.force + other.force, self.moment + other.moment)

    def __sub__(self, other: Wrench) -> Wrench:
        return Wrench(self.force - other.force, self.moment - other.moment)


def inertial(chain: Chain, water: Water, m: Motion) -> Wrench:
    """Rate of change of each link's own and its water's momentum: what the link must be given."""
    place, _, acceleration = m.at(chain.com)
    added = chain.mass * water.added_mass if isinstance(water, Lumped) else 0.0
    force = (chain.mass + added) * acceleration
    body = Wrench(force, chain.inertia * m.turn_rate + cross(place - m.place, force))
    return body + strip_inertia(chain, water, m) if isinstance(water, Strip) else body


def strip_inertia(chain: Chain, water: Strip, m: Motion) -> Wrench:
    """Kirchhoff's equations of the water moved by one straight strip.

    Impulse ``p = mu_t l v_t t + mu_n l v_n n`` with ``v`` at the strip's middle, angular impulse ``J omega`` about it.
    Force = dp/dt; moment about the middle, which moves at v, = J d(omega)/dt + v x p (Munk's moment). The axes turn:
    dt/dt = omega n, dn/dt = -omega t.
    """
    place, v, a = m.at(chain.length / 2)
    t, n = m.axis, 1j * m.axis
    v_t, v_n = dot(t, v), dot(n, v)
    a_t = dot(t, a) + m.turn * v_n  # d(v_t)/dt
    a_n = dot(n, a) - m.turn * v_t  # d(v_n)/dt
    m_t, m_n = water.mu_tangential * chain.length, water.mu_normal * chain.length
    impulse = m_t * v_t * t + m_n * v_n * n
    force = m_t * (a_t * t + v_t * m.turn * n) + m_n * (a_n * n - v_n * m.turn * t)
    moment = water.added_inertia * m.turn_rate + cross(v, impulse)
    return Wrench(force, moment + cross(place - m.place, force))


def drag(chain: Chain, water: Water, m: Motion) -> Wrench:
    """Force of the water's resistance on each link."""
    if isinstance(water, Lumped):
        place, v, _ = m.at(chain.com)
        v_t, v_n = dot(m.axis, v), dot(1j * m.axis, v)
        f_t = -0.5 * water.density * water.friction * water.friction_area * v_t * abs(v_t)
        f_n = -0.5 * water.density * water.drag * water.drag_area * v_n * abs(v_n)
        force = (f_t + 1j * f_n) * m.axis
        return Wrench(force, cross(place - m.place, force))
    total = shed(chain, water, m)
    v_t = dot(m.axis, m.velocity)  # alike all along a link
    total = total + Wrench(-water.blunt * v_t * abs(v_t) * m.axis, np.zeros_like(v_t))  # no arm about the link's joint
    across = water.quadratic_normal + water.quadratic_beating * beating(chain, m)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    for node, weight in zip(nodes, weights, strict=True):
        place, v, _ = m.at(chain.length * (1 + node) / 2)
        v_t, v_n = dot(m.axis, v), dot(1j * m.axis, v)
        speed = abs(v) if water.cross_flow else abs(v_n)
        f_t = -water.quadratic_tangential * v_t * abs(v_t) - water.linear_tangential * v_t
        f_n = -across * v_n * speed - water.linear_normal * v_n
        force = (f_t + 1j * f_n) * m.axis * chain.length * weight / 2
        total = total + Wrench(force, cross(place - m.place, force))
    return total


def beating(chain: Chain, m: Motion) -> Real:
    """Share of the squares of the two parts of the speed across each link's middle that the joints' motion makes.

    The other part is that of a body as rigid as the head.
    """
    place, v, _ = m.at(chain.length / 2)
    rigid = m.velocity[..., :1] + 1j * m.turn[..., :1] * (place - m.place[..., :1])
    joints, whole = dot(1j * m.axis, v - rigid), dot(1j * m.axis, rigid)
    total = joints**2 + whole**2
    return np.divide(joints**2, total, out=np.zeros_like(total), where=total > 0)


def shed(chain: Chain, water: Strip, m: Motion) -> Wrench:
    """Reactive force of the water left behind the trailing edge (Lighthill 1971), of strength k = ``tail_shedding``.

    With t along the last link from nose to tail, n its left normal, v_t and v_n the trailing edge's velocity and mu the
    added mass per length there:

        f_t = -1/2 k mu v_n^2 H,    f_n = k mu v_t v_n H,    H = max(0, -v_t) / |v|.

    Derivation. Enclose the body's water by a plane through the trailing edge, across the last link. Its momentum is
    ``p = integral(mu v_n n ds)``, and

        dp/dt = (force of the body on it) - (momentum carried out) + (pressure on the plane).

    The plane leaves water behind at the speed U = -v_t, which carries out U mu v_n n. The pressure of the cross-flow
    (Bernoulli in axes moving with the section) sums up to v_n (mu v_n) - 1/2 mu v_n^2 = 1/2 mu v_n^2 and pushes the
    enclosed water toward the nose: -1/2 mu v_n^2 t. Hence the force on the body is

        -dp/dt - U mu v_n n - 1/2 mu v_n^2 t.

    The first term is in the mass matrix, the others are f_n (for -U = v_t) and f_t with k = H = 1. Lighthill writes
    them as w m (z_t, -x_t) - 1/2 m w^2 (x_a, z_a), with (x_a, z_a) toward the nose: the same vectors.

    Energy. The power on the body is f_t v_t + f_n v_n = (-1/2 + 1) mu v_n^2 v_t = -1/2 mu v_n^2 U: just the kinetic
    energy 1/2 mu v_n^2 per length of wake, left behind at the rate U. With k and H it is 1/2 k mu v_n^2 v_t H <= 0.

    Small amplitude. With y = h(x, t): v_n = h_t + U h_x, and the thrust -f_t + f_n h_x comes to
    1/2 mu (h_t^2 - U^2 h_x^2), the classic result.

    H is ours: Lighthill has 1 and assumes v_n << U, where H is 1 too; it fades to 0 as the edge stops moving forward.
    With an ``onset`` e below 1, |v| in it is sqrt(v_t^2 + (e v_n)^2): it fades later.

    A fin of span b, ``mu_edge`` = rho pi/4 b^2, and of the lift slope C = lift pi AR/2 has the normal force lift mu v_t
    v_n; its suction, less induced drag, is 2 - lift times Lighthill's part along, which ``suction`` multiplies.
    """
    place, v, _ = m.at(chain.length)
    v_t, v_n = dot(m.axis, v), dot(1j * m.axis, v)
    size = np.hypot(v_t, water.onset * v_n)
    speed = np.where(size > 0, size, 1.0)
    mu = water.mu_normal if water.mu_edge is None else water.mu_edge
    last = np.arange(m.axis.shape[-1]) == m.axis.shape[-1] - 1
    strength = np.where(last, water.tail_shedding * mu, 0.0) * np.maximum(0.0, -v_t) / speed
    force = strength * (-0.5 * water.suction * v_n**2 + 1j * v_t * v_n) * m.axis
    return Wrench(force, cross(place - m.place, force))


def about_nose(m: Motion, w: Wrench) -> Real:
    """Sum of all links' wrenches (..., 3): force x, y, moment about the nose."""
    force = w.force.sum(axis=-1)
    moment = (w.moment + cross(m.place - m.place[..., :1], w.force)).sum(axis=-1)
    return np.stack([force.real, force.imag, moment], axis=-1)


def acceleration(chain: Chain, water: Water, joints: Joints, state: Real) -> Real:
    """World accelerations of nose x, y and of the head angle (..., 3) for ``state`` (..., 6)."""

    def needed(base: Real) -> Real:
        m = motion(chain, joints, state, np.broadcast_to(base, (*state.shape[:-1], 3)))
        return about_nose(m, inertial(chain, water, m))

    bias = needed(np.zeros(3))
    matrix = np.stack([needed(unit) - bias for unit in np.eye(3)], axis=-1)
    still = motion(chain, joints, state, np.zeros((*state.shape[:-1], 3)))
    load = about_nose(still, drag(chain, water, still))
    return np.linalg.solve(matrix, (load - bias)[..., None])[..., 0]


def torques(chain: Chain, water: Water, joints: Joints, state: Real) -> Real:
    """Torque [N m] of the drives on the links behind each joint (..., n); entry 0, the nose's, must vanish."""
    m = motion(chain, joints, state, acceleration(chain, water, joints, state))
    given = inertial(chain, water, m) - drag(chain, water, m)
    n = m.axis.shape[-1]
    rows = [
        (given.moment + cross(m.place - m.place[..., i, None], given.force))[..., i:].sum(axis=-1) for i in range(n)
    ]
    return np.stack(rows, axis=-1)


def power(chain: Chain, water: Water, joints: Joints, state: Real) -> Real:
    """Mechanical power of the joints [W] (...)."""
    return (torques(chain, water, joints, state) * joints.rate).sum(axis=-1)


def drag_power(chain: Chain, water: Water, joints: Joints, state: Real) -> Real:
    """Power that the water takes [W] (...), positive when it dissipates."""
    m = motion(chain, joints, state, np.zeros((*state.shape[:-1], 3)))
    w = drag(chain, water, m)
    return -(dot(w.force, m.velocity) + w.moment * m.turn).sum(axis=-1)


def kinetic_energy(chain: Chain, water: Water, joints: Joints, state: Real) -> Real:
    """Kinetic energy of links and water [J] (...)."""
    m = motion(chain, joints, state, np.zeros((*state.shape[:-1], 3)))
    _, v, _ = m.at(chain.com)
    added = chain.mass * water.added_mass if isinstance(water, Lumped) else 0.0
    energy = (chain.mass + added) * abs(v) ** 2 + chain.inertia * m.turn**2
    if isinstance(water, Strip):
        _, v, _ = m.at(chain.length / 2)
        v_t, v_n = dot(m.axis, v), dot(1j * m.axis, v)
        energy = (
            energy
            + chain.length * (water.mu_tangential * v_t**2 + water.mu_normal * v_n**2)
            + water.added_inertia * m.turn**2
        )
    return energy.sum(axis=-1) / 2


def head_acceleration(chain: Chain, water: Water, joints: Joints, twist: Real) -> Real:
    """Rates of the head's twist (u, v, r) in its own axes (..., 3), from the twist (..., 3)."""
    state = np.concatenate([np.zeros_like(twist), twist], axis=-1)
    world = acceleration(chain, water, joints, state)
    u, v, r = np.moveaxis(twist, -1, 0)
    return world + np.stack([r * v, -r * u, np.zeros_like(r)], axis=-1)
