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
GAUSS = np.polynomial.legendre.leggauss(4)


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
    ``edge``: what the last link sheds (`shed`), and where a fin of its own carries its added mass (`strips`).
    """

    mu_normal: Real
    mu_tangential: Real
    added_inertia: Real
    quadratic_normal: Real
    quadratic_tangential: Real
    linear_normal: Real | float = 0.0
    linear_tangential: Real | float = 0.0
    cross_flow: bool = False
    quadratic_beating: Real | float = 0.0
    blunt: Real | float = 0.0
    edge: Edge | Fin | Slender | None = None


@dataclass(frozen=True)
class Edge:
    """The last link as a plate of one height: ``mu`` [kg/m] added mass across, ``shed`` [kg/m] that of the wake at
    small incidence, ``front`` the fraction of the suction at the leading edge.
    """

    mu: float
    shed: float
    front: float


@dataclass(frozen=True)
class Fin:
    """A plate of its own at the end of the last link: ``mass`` [kg], ``chord`` [m], ``lift`` [kg/m] per speed along and
    across, ``inertia`` [kg m^2] about its middle, ``slope`` in units of a slender wing's, ``front`` as of an `Edge`.
    """

    mass: float
    chord: float
    lift: float
    inertia: float
    slope: float
    front: float


@dataclass(frozen=True)
class Slender:
    """Lighthill's trailing edge of the added mass ``mu`` [kg/m]."""

    mu: float


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
    edge_aspect: float = 0.0,
    edge_added_mass: float = 0.0,
    edge_suction: float = 0.0,
) -> Strip:
    """Coefficients of a robot file (``[water.strip]``) to quantities per length; areas (..., n) in m^2."""
    height = lateral_area / chain.length
    reference = density * np.pi / 4 * height**2
    mu_normal = added_mass_normal * reference
    inertia = added_inertia * mu_normal * chain.length**3 / 12
    edge: Edge | Fin
    chord = edge_height / edge_aspect if edge_aspect > 0 else np.inf
    if edge_height > 0 and chord < 1.0001 * chain.length[-1]:
        mass = min(edge_added_mass * density * np.pi / 4 * chord**2 * edge_height, mu_normal[-1] * chain.length[-1])
        shed = tail_shedding * edge_lift * density * np.pi / 4 * edge_height**2
        around = np.asarray(added_inertia)[-1] * mass * chord**2 / 32
        edge = Fin(mass, chord, shed, around, edge_lift, edge_suction)
        ahead = chain.length[-1] - chord
        rest = mu_normal[-1] * chain.length[-1] - mass
        inertia = np.append(inertia[:-1], np.asarray(added_inertia)[-1] * rest * ahead**2 / 12)
    else:
        mu_edge = density * np.pi / 4 * edge_height**2 if edge_height > 0 else mu_normal[-1]
        span = edge_height if edge_height > 0 else height[-1]
        ahead = min(1.0, (height[-2] / span) ** 2) if len(height) > 1 else 0.0
        edge = Edge(mu_normal[-1], tail_shedding * edge_lift * mu_edge, ahead + edge_suction * (1 - ahead))
    return Strip(
        mu_normal=mu_normal,
        mu_tangential=added_mass_tangential * reference,
        added_inertia=inertia,
        quadratic_normal=density * drag_normal * height / 2,
        quadratic_tangential=density * drag_tangential * wetted_area / chain.length / 2,
        linear_normal=linear_normal,
        linear_tangential=linear_tangential,
        cross_flow=cross_flow,
        quadratic_beating=density * drag_beating * height / 2,
        blunt=density * blunt_area / 2,
        edge=edge,
    )


def elongated_of(chain: Chain, density: float, lateral_area: Real, wetted_area: Real, **given: Real | float) -> Strip:
    """Elongated-body theory (``[water.elongated]``) as strips: none along, a slender moment, an edge that sheds."""
    edge = given.pop("added_mass_edge") * density * np.pi / 4 * (lateral_area / chain.length)[-1] ** 2
    along = {"added_mass_tangential": np.zeros_like(lateral_area), "added_inertia": np.ones_like(lateral_area)}
    water = strip_of(chain, density, lateral_area, wetted_area, **given, **along)
    return replace(water, edge=Slender(float(edge)))


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

    Impulse ``p = m_t v_t t + m_n v_n n`` with ``v`` at the strip's middle, angular impulse ``J omega`` about it.
    Force = dp/dt; moment about the middle, which moves at v, = J d(omega)/dt + v x p (Munk's moment). The axes turn:
    dt/dt = omega n, dn/dt = -omega t.
    """
    total = Wrench(np.zeros_like(m.axis), np.zeros(m.axis.shape))
    for s, m_t, m_n, inertia in strips(chain, water):
        place, v, a = m.at(s)
        t, n = m.axis, 1j * m.axis
        v_t, v_n = dot(t, v), dot(n, v)
        a_t = dot(t, a) + m.turn * v_n  # d(v_t)/dt
        a_n = dot(n, a) - m.turn * v_t  # d(v_n)/dt
        impulse = m_t * v_t * t + m_n * v_n * n
        force = m_t * (a_t * t + v_t * m.turn * n) + m_n * (a_n * n - v_n * m.turn * t)
        moment = inertia * m.turn_rate + cross(v, impulse)
        total = total + Wrench(force, moment + cross(place - m.place, force))
    return total


def strips(chain: Chain, water: Strip) -> list[tuple[Real, Real, Real, Real]]:
    """Middle of every strip behind the link's front joint, its added masses along and across, and its inertia (n,)."""
    zero = np.zeros_like(chain.length)
    middle, along, across = chain.length / 2, water.mu_tangential * chain.length, water.mu_normal * chain.length
    if not isinstance(fin := water.edge, Fin):
        return [(middle, along, across, water.added_inertia)]
    last = np.arange(len(zero)) == len(zero) - 1
    return [
        (middle - last * fin.chord / 2, along, across - last * fin.mass, water.added_inertia),
        (chain.length - fin.chord / 2, zero, last * fin.mass, last * fin.inertia),
    ]


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
    for node, weight in zip(*GAUSS, strict=True):
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
    """Force at the edges of the last link beside the change of the water's momentum.

    With t along the link from nose to tail, n its left normal, mu the added mass per length and v the velocity, the
    water's momentum is mu v_n n per length. Planes across the link move with it, so momentum leaves through them at
    -v_t and pressure acts on them with mu v_n^2 / 2 (Bernoulli in the planes' axes, over the plane): per length

        f = -d(mu v_n n)/dt + dQ/ds,    Q = mu v_t v_n n - mu v_n^2 / 2 t.

    Along t nothing is left where mu is constant: -mu v_n dn/dt . t = mu v_n omega, and dQ/ds . t = -mu v_n dv_n/ds
    with dv_n/ds = omega. A straight plate bears no force along itself. Kirchhoff's equations hold the first part for
    the whole link, (mu/2)(v_TE^2 - v_LE^2): so its negative stands here, beside Q's normal part at the trailing edge.
    What the leading edge adds is suction, -mu v_LE^2 / 2, by the fraction of it that acts.

    Energy of an `Edge` moving forward at V = -v_t: V (mu - s) v_LE^2 / 2 + V v_TE^2 (mu/2 + (shed - mu/2) H) is left in
    the wake, never less than nothing as mu <= 2 shed. H = |v_t| / |v| is ours. A `Slender` edge is Lighthill's.
    A `Fin` has the lift of thin plates, by the speed at 3/4 chord; with Munk's moment its center is at 1/4 chord.
    These and its suction fade with H, and so does the wake's power.
    """
    edge, zero = water.edge, np.zeros_like(m.axis)
    if edge is None:
        return Wrench(zero, np.zeros(m.axis.shape))
    last = np.arange(m.axis.shape[-1]) == m.axis.shape[-1] - 1
    length = chain.length

    def across(s: Real) -> Real:
        return dot(1j * m.axis, m.at(s)[1])

    v_t, turn, couple = dot(m.axis, m.velocity), m.turn, np.zeros(m.axis.shape)
    forward = v_t < 0
    if isinstance(edge, Slender):
        at, v = length, across(length)
        f_t, f_n = -edge.mu / 2 * v**2, edge.mu * np.minimum(v_t, 0) * v
    elif isinstance(edge, Edge):
        mu = min(edge.mu, 2 * edge.shed)
        at = np.where(forward, length, 0 * length)
        v = across(at)
        size = np.hypot(v_t, v)
        fade = np.divide(abs(v_t), size, out=np.zeros_like(size), where=size > 0)
        f_n = -abs(v_t) * v * (mu / 2 + (edge.shed - mu / 2) * fade)
        f_t = -mu / 2 * (across(length) ** 2 - across(0 * length) ** 2) - edge.front * mu / 2 * across(0 * length) ** 2
    else:
        middle, side = length - edge.chord / 2, np.where(forward, 1.0, -1.0)
        mass = min(edge.mass, edge.chord * edge.lift)
        share = mass / (edge.chord * edge.lift) if edge.lift > 0 else 0.0
        at = middle + side * abs(share - 0.25) * edge.chord
        v = across(middle + side * edge.chord / 4)
        size = np.hypot(v_t, v)
        fade = np.divide(abs(v_t), size, out=np.zeros_like(size), where=size > 0)
        f_n = -edge.lift * abs(v_t) * v * fade
        couple = (1 - fade) * v_t * mass * across(middle)
        suction = min(edge.front * (1 - edge.slope / 2), 4 * share)
        f_t = -turn * mass * across(middle) - suction * fade * edge.lift * across(middle) ** 2
    force = np.where(last, f_t + 1j * f_n, 0.0) * m.axis
    return Wrench(force, cross(at * m.axis, force) + np.where(last, couple, 0.0))


def about_nose(m: Motion, w: Wrench) -> Real:
    """Sum of all links' wrenches (..., 3): force x, y, moment about the nose."""
    force = w.force.sum(axis=-1)
    moment = (w.moment + cross(m.place - m.place[..., :1], w.force)).sum(axis=-1)
    return np.stack([force.real, force.imag, moment], axis=-1)


def acceleration(chain: Chain, water: Water, joints: Joints, state: Real) -> Real:
    """World accelerations of nose x, y and of the head angle (..., 3) for ``state`` (..., 6)."""

    bases = np.concatenate([np.zeros((1, 3)), np.eye(3)]).reshape(4, *(1 for _ in state.shape[:-1]), 3)
    moved = motion(chain, joints, state, bases)
    bias, *units = about_nose(moved, inertial(chain, water, moved))  # the four at once
    matrix = np.stack([unit - bias for unit in units], axis=-1)
    load = about_nose(moved, drag(chain, water, moved))  # of velocities alone
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
        for s, m_t, m_n, inertia in strips(chain, water):
            _, v, _ = m.at(s)
            energy = energy + m_t * dot(m.axis, v) ** 2 + m_n * dot(1j * m.axis, v) ** 2 + inertia * m.turn**2
    return energy.sum(axis=-1) / 2


def head_acceleration(chain: Chain, water: Water, joints: Joints, twist: Real) -> Real:
    """Rates of the head's twist (u, v, r) in its own axes (..., 3), from the twist (..., 3)."""
    state = np.concatenate([np.zeros_like(twist), twist], axis=-1)
    world = acceleration(chain, water, joints, state)
    u, v, r = np.moveaxis(twist, -1, 0)
    return world + np.stack([r * v, -r * u, np.zeros_like(r)], axis=-1)
