"""The body in space from its energy: Lagrange's equations in quasi-coordinates, by finite differences.

Written from the description, point by point in the head's axes, with none of the core's spatial algebra: a link is a
rigid body at its center of mass, a plate of water in its plane at the height of its center of buoyancy, and a row of
strips across it. For a twist V = (v, w) of the head and coordinates q, with the energy T(q, q', V),

    p' + w x p = f,   l' + w x l + v x p = m,   d/dt dT/dq' - dT/dq = Q.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oracles.planar import Chain, Lumped, Real, Water

GRAVITY = 9.81


@dataclass(frozen=True)
class Space:
    """What links have in space (n,), fins and sea; names as in the core."""

    links: dict[str, Real]
    fin: dict[str, float]
    sea: dict[str, float]
    shedding: float = 0.0

    def body_columns(self) -> dict[str, Real | float]:
        """As the core takes a body beyond the plane."""
        links = {f"link.{name}": values for name, values in self.links.items()}
        fin = {f"fin.{name}": value for name, value in self.fin.items()}
        return {**links, **fin, "shedding": self.shedding, "antenna": 0.0}

    def sea_columns(self) -> dict[str, float]:
        """As the core takes the world."""
        return {f"sea.{name}": value for name, value in self.sea.items()}


def axes(psi: float) -> Real:
    """Columns are the axes t, n, z of a link in the head's."""
    c, s = np.cos(psi), np.sin(psi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Link:
    """One link of a bent chain in the head's axes: front joint and its rate, columns t, n, z, rate against the head."""

    front: Real
    front_rate: Real
    axes: Real
    turn: float

    def point(self, along: float, height: float = 0.0) -> Real:
        return self.front + along * self.axes[:, 0] + np.array([0, 0, height])

    def velocity(self, twist: Real, along: float, height: float = 0.0) -> Real:
        """In the head's axes, of a point of the link."""
        by_joints = self.front_rate + self.turn * along * self.axes[:, 1]
        return twist[:3] + np.cross(twist[3:], self.point(along, height)) + by_joints

    def rate(self, twist: Real) -> Real:
        """Rate of turn in the link's axes."""
        return self.axes.T @ twist[3:] + np.array([0, 0, self.turn])


def links(chain: Chain, angle: Real, rate: Real) -> list[Link]:
    """The links of a chain whose joints (n,) stand at angles and turn at rates."""
    found, front, front_rate = [], np.zeros(3), np.zeros(3)
    for psi, turn, length in zip(np.cumsum(angle), np.cumsum(rate), chain.length, strict=True):
        found.append(Link(front, front_rate, axes(psi), float(turn)))
        front = front + length * found[-1].axes[:, 0]
        front_rate = front_rate + turn * length * found[-1].axes[:, 1]
    return found


def kinetic_energy(chain: Chain, water: Water, space: Space, angle: Real, rate: Real, twist: Real) -> float:
    """Energy of links and water, relative to the water [J]."""
    twice = 0.0
    b = {name: np.asarray(value) for name, value in space.links.items()}
    for i, link in enumerate(links(chain, angle, rate)):
        length, turn = chain.length[i], link.rate(twist)
        rigid = link.velocity(twist, chain.com[i], b["com_height"][i])
        inertia = np.array([b["roll"][i], b["pitch"][i], chain.inertia[i]])
        twice += chain.mass[i] * rigid @ rigid + inertia @ turn**2
        if isinstance(water, Lumped):
            v = link.axes.T @ link.velocity(twist, chain.com[i], b["center_height"][i])
            twice += chain.mass[i] * water.added_mass[i] * (v[0] ** 2 + v[1] ** 2)
        else:
            v = link.axes.T @ link.velocity(twist, length / 2, b["center_height"][i])
            twice += length * (water.mu_tangential[i] * v[0] ** 2 + water.mu_normal[i] * v[1] ** 2)
            twice += water.added_inertia[i] * turn[2] ** 2
        density, half = space.sea["density"], (b["height"][i] / 2, b["width"][i] / 2)
        twice += density * np.pi / 8 * (half[0] ** 2 - half[1] ** 2) ** 2 * length * turn[0] ** 2
        ends = [link.velocity(twist, along)[2] for along in (0.0, length)]
        across = (ends[0] ** 2 + ends[0] * ends[1] + ends[1] ** 2) / 3  # mean square of what is linear between the ends
        twice += b["added_vertical"][i] * density * np.pi * half[1] ** 2 * length * across
    return float(twice / 2)


def momentum(chain: Chain, water: Water, space: Space, share: Real, q: Real, rate: Real, twist: Real) -> Real:
    """Slopes (6 + d,) of the kinetic energy by twist and rates: it is a quadratic form, so differences are exact."""
    d = len(q)

    def energy(z: Real) -> float:
        return kinetic_energy(chain, water, space, share @ q, share @ z[6:], z[:6])

    z = np.concatenate([twist, rate])
    return np.array([(energy(z + e) - energy(z - e)) / 2 for e in np.eye(6 + d)])


def attitude(quaternion: Real) -> Real:
    """Rotation from body to world of a unit quaternion w, x, y, z."""
    w, x, y, z = quaternion
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    result: Real = np.eye(3) + 2 * w * k + 2 * k @ k
    return result


def potential_energy(chain: Chain, space: Space, share: Real, q: Real, position: Real, rotation: Real) -> float:
    """Of weight and buoyancy, all under water [J]."""
    total = 0.0
    for i, link in enumerate(links(chain, share @ q, 0 * share[:, 0])):
        b = {name: value[i] for name, value in space.links.items()}
        weight = chain.mass[i] * (position + rotation @ link.point(chain.com[i], b["com_height"]))[2]
        lift = (
            space.sea["density"] * b["volume"] * (position + rotation @ link.point(b["center"], b["center_height"]))[2]
        )
        total += GRAVITY * (weight - lift)
    return total


def drag(chain: Chain, water: Water, space: Space, share: Real, q: Real, rate: Real, twist: Real) -> Real:
    """Generalized force (6 + d,) of the lumped law's drag and of what acts across the plane; fins are `fins`."""
    assert isinstance(water, Lumped)
    total = np.zeros(6 + len(q))
    node, weight = np.polynomial.legendre.leggauss(4)
    unit = np.eye(6 + len(q))

    def push(i: int, along: float, height: float, force: Real) -> None:
        """Put in a force in the link's axes: its power at every unit velocity."""
        for k, e in enumerate(unit):
            at = links(chain, share @ q, share @ e[6:])[i]
            total[k] += (at.axes @ force) @ at.velocity(e[:6], along, height)

    for i, link in enumerate(links(chain, share @ q, share @ rate)):
        b = {name: value[i] for name, value in space.links.items()}
        v = link.axes.T @ link.velocity(twist, chain.com[i], b["center_height"])
        friction = -water.density / 2 * water.friction[i] * water.friction_area[i] * v[0] * abs(v[0])
        sideways = -water.density / 2 * water.drag[i] * water.drag_area[i] * v[1] * abs(v[1])
        push(i, chain.com[i], b["center_height"], np.array([friction, sideways, 0.0]))
        length, ends = chain.length[i], [link.velocity(twist, x)[2] for x in (0.0, chain.length[i])]
        still = length * np.clip(ends[0] / (ends[0] - ends[1]), 0.0, 1.0)  # where the link does not rise, or an end
        for first, last in ((0.0, still), (still, length)):  # on either side a square, for Gauss's points exact
            for x, part in zip(first + (last - first) * (1 + node) / 2, (last - first) * weight / 2, strict=True):
                rise = link.velocity(twist, x)[2]
                lift = -water.density / 2 * b["drag_vertical"] * b["width"] * part * rise * abs(rise)
                push(i, x, 0.0, np.array([0, 0, lift]))
        if i == len(chain.length) - 1:
            densest = max(space.links["added_vertical"] * np.pi / 4 * space.links["width"] ** 2)
            wake = space.shedding * water.density * densest
            v = link.axes.T @ link.velocity(twist, length)
            fade = max(0.0, -v[0]) / np.hypot(v[0], v[2])
            push(i, length, 0.0, wake * fade * np.array([-(v[2] ** 2) / 2, 0.0, v[0] * v[2]]))
        roll, half = link.rate(twist)[0], b["height"] / 2
        moment = -water.density / 2 * b["drag_roll"] * length * half**4 / 2 * roll * abs(roll)
        total[3:6] += moment * link.axes[:, 0]
    return total


def fins(space: Space, twist: Real, angle: Real) -> Real:
    """Force and moment about the nose (6,) of both fins, in the head's axes, by angles instead of their sines."""
    f, total = space.fin, np.zeros(6)
    aspect = 2 * f["span"] / f["chord"]  # with the mirror image in the hull
    slope = 2 * np.pi * aspect / (2 + np.sqrt(4 + aspect**2))
    for side, deflection in zip((-1, 1), angle, strict=True):
        place = np.array([f["x"], side * f["y"], f["z"]])
        v = twist[:3] + np.cross(twist[3:], place)
        speed, climb = np.hypot(v[0], v[2]), np.arctan2(v[2], -v[0])  # of the way that the fin goes
        a = deflection - climb
        stalled = 1 / (1 + (np.sin(f["stall"]) / max(abs(np.sin(a)), 1e-12)) ** 16)
        vortices = slope * abs(np.sin(2 * a)) / 2 + np.pi / (1 + aspect / 2) * np.sin(a) ** 2
        wake = 1.98 * abs(np.sin(a)) * (1 / (0.56 + 0.44 * abs(np.sin(a))) - 0.41 * (1 - np.exp(-17 / aspect)))
        normal = np.sign(np.sin(a)) * ((1 - stalled) * vortices + stalled * wake)
        lift, drag = normal * np.cos(a), f["drag_zero"] + normal * np.sin(a)
        pressure = space.sea["density"] / 2 * f["span"] * f["chord"] * speed**2
        ahead, up = np.array([-np.cos(climb), 0, np.sin(climb)]), np.array([np.sin(climb), 0, np.cos(climb)])
        force = pressure * (lift * up - drag * ahead)
        total += np.concatenate([force, np.cross(place, force)])
    return total
