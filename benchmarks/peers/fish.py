"""Shared by all peers: the robot's constants, the gaits, and the speed from a trajectory.

The peers share nothing with hypertuna but the robot file, so that agreement means something.

The model (lumped water, prescribed joints, body frame at the nose, SI and radians)::

    theta_i = sum_g G[i, g] alpha_g(t)          alpha_g = A_g sin(2 pi f t - Phi_g)
    P       = M(t) xi + b(t)                    momentum (p_x, p_y, h) and twist xi = (u, v, r)
    dp/dt   = -r x p + F,   dh/dt = u p_y - v p_x, negated, + N
    F_t     = -k_t v_t |v_t|,   F_n = -k_n v_n |v_n|      per link, at its center of mass
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

STEPS = 128  # RK4 steps per beat, of hypertuna and of all peers
ROBOT = Path(__file__).resolve().parents[2] / "robots" / "hypertuna.toml"


@dataclass(frozen=True)
class Fish:
    """Constants of one chain of n links moved by g joint groups."""

    length: Array  # [n] m
    com: Array  # [n] m, from the link's front joint
    mass: Array  # [n] kg, without added mass
    added: Array  # [n] kg, added mass
    inertia: Array  # [n] kg m^2, about the center of mass, not scaled by added mass
    k_t: Array  # [n] kg/m, friction: F_t = -k_t v_t|v_t|
    k_n: Array  # [n] kg/m, lateral drag: F_n = -k_n v_n|v_n|
    share: Array  # [n, g] joint angle phi_i = sum_g share[i, g] alpha_g

    @property
    def links(self) -> int:
        """Number of links n."""
        return len(self.length)

    @property
    def groups(self) -> int:
        """Number of joint groups g."""
        return int(self.share.shape[1])

    @property
    def moving_mass(self) -> Array:
        """Mass of each link with its added mass [n], kg."""
        return self.mass + self.added


@dataclass(frozen=True)
class Gaits:
    """K harmonic gaits, zero bias."""

    frequency: Array  # [K] Hz
    amplitude: Array  # [K, g] rad
    phase: Array  # [K, g] rad, lag behind the first group's clock

    def __len__(self) -> int:
        return len(self.frequency)

    def __getitem__(self, k: slice) -> Gaits:
        return Gaits(self.frequency[k], self.amplitude[k], self.phase[k])


def load(path: Path = ROBOT) -> Fish:
    """Read a robot file for the lumped law with consistent areas and ideal joints."""
    with path.open("rb") as file:
        robot = tomllib.load(file)
    links, water = robot["links"], robot["water"]
    length, mass = np.array(links["length_m"]), np.array(links["mass_kg"])
    lumped = {key: np.array(value) for key, value in water["lumped"].items()}
    half_density = 0.5 * water["density_kg_m3"]
    share = np.zeros((len(length), len(robot["joints"])))
    for group, joint in enumerate(robot["joints"]):
        members = joint["links"]
        share[members, group] = joint.get("share", [1 / len(members)] * len(members))
    return Fish(
        length=length,
        com=np.array(links["com_m"]),
        mass=mass,
        added=lumped["added_mass"] * mass,
        inertia=np.array(links.get("inertia_kg_m2", mass * length**2 / 12)),
        k_t=half_density * lumped["friction"] * np.array(links["wetted_area_m2"]),
        k_n=half_density * lumped["drag"] * np.array(links["lateral_area_m2"]),
        share=share,
    )


def gaits_from_degrees(frequency: object, amplitude: object, phase: object) -> Gaits:
    """Return gaits from Hz and degrees, of the shapes [K], [K, g], [K, g]."""
    return Gaits(
        np.atleast_1d(np.asarray(frequency, float)),
        np.radians(np.atleast_2d(np.asarray(amplitude, float))),
        np.radians(np.atleast_2d(np.asarray(phase, float))),
    )


def grid(frequencies: int = 6, phases: int = 10) -> Gaits:
    """Return the benchmark's grid: 6 frequencies x 10 phases x the paper's 3 amplitude levels = 180 gaits."""
    levels = np.array([(8.0, 15.0), (12.0, 20.0), (16.0, 25.0)])  # small, medium, large
    f, p, a = np.meshgrid(np.linspace(1, 6, frequencies), np.linspace(0, 180, phases), np.arange(3), indexing="ij")
    phase = np.stack([np.zeros(p.size), p.ravel()], axis=1)
    return gaits_from_degrees(f.ravel(), levels[a.ravel()], phase)


def clock(steps: int = STEPS) -> Array:
    """Return sine and cosine of the beat's phase at every RK4 node and half node, [2 steps, 2]."""
    angle = np.pi * np.arange(2 * steps) / steps
    return np.stack([np.sin(angle), np.cos(angle)], axis=1)


def shape(fish: Fish, gaits: Gaits, sin_cos: Array) -> tuple[Array, Array]:
    """Tabulate the quantities of the moving shape that the equations of motion need.

    Parameters
    ----------
    sin_cos : Array [Q, 2]
        Sine and cosine of the beat's phase.

    Returns
    -------
    link : Array [Q, K, n, 6]
        Per link c, s (cosine and sine of its axis), h_t, h_n (velocity of its center of mass along and
        across it per rad/s of the head, m), a_t, a_n (the same from the shape's own motion, m/s).
    body : Array [Q, K, 6]
        g_x, g_y (the body's center, m), 1 / inertia about it (1/(kg m^2)), b_x, b_y, b_h (momentum of the
        shape's own motion, kg m/s and kg m^2/s).
    """
    omega = 2 * np.pi * gaits.frequency[:, None]
    sin, cos = sin_cos[:, None, None, 0], sin_cos[:, None, None, 1]
    sin_phase, cos_phase = np.sin(gaits.phase), np.cos(gaits.phase)
    alpha = gaits.amplitude * (sin * cos_phase - cos * sin_phase)
    rate = gaits.amplitude * omega * (cos * cos_phase + sin * sin_phase)
    angles = np.cumsum(fish.share, axis=0).T
    theta, turn = alpha @ angles, rate @ angles
    c, s = np.cos(theta), np.sin(theta)

    def to_com(front: Array, along: Array) -> Array:
        """Return the sum over the links before, plus the part to this link's center of mass."""
        before = np.cumsum(front, axis=-1) - front
        return before + along

    rx, ry = to_com(fish.length * c, fish.com * c), to_com(fish.length * s, fish.com * s)
    wx = to_com(-fish.length * s * turn, -fish.com * s * turn)
    wy = to_com(fish.length * c * turn, fish.com * c * turn)
    link = np.stack([c, s, s * rx - c * ry, c * rx + s * ry, c * wx + s * wy, c * wy - s * wx], axis=-1)
    m, total = fish.moving_mass, fish.moving_mass.sum()
    gx, gy = rx @ m / total, ry @ m / total
    inertia = (rx**2 + ry**2) @ m + fish.inertia.sum() - total * (gx**2 + gy**2)
    spin = (rx * wy - ry * wx) @ m + turn @ fish.inertia
    return link, np.stack([gx, gy, 1 / inertia, wx @ m, wy @ m, spin], axis=-1)


def twist(fish: Fish, momentum: Array, body: Array) -> Array:
    """Return the head's twist (u, v, r), from M xi = P - b, for momentum (p_x, p_y, h) [..., 3] and body [..., 6]."""
    gx, gy, mobility = body[..., 0], body[..., 1], body[..., 2]
    px, py, h = np.moveaxis(momentum - body[..., 3:], -1, 0)
    r = mobility * (h - gx * py + gy * px)
    total = fish.moving_mass.sum()
    return np.stack([px / total + gy * r, py / total - gx * r, r], axis=-1)


def beat_speed(twists: Array, frequency: Array) -> Array:
    """Return the mean speed [K] over one beat, m/s, from the head's twists [S + 1, 3, K] at equal time steps.

    Heading and path are integrated with cubic splines: fourth order, as RK4.
    """
    beat = np.linspace(0, 1, len(twists))

    def integral(rate: Array) -> Array:
        return np.asarray(CubicSpline(beat, rate).antiderivative()(beat))

    u, v, r = twists[:, 0], twists[:, 1], twists[:, 2]
    psi = integral(r / frequency)
    east = integral(u * np.cos(psi) - v * np.sin(psi))[-1]
    north = integral(u * np.sin(psi) + v * np.cos(psi))[-1]
    return np.asarray(np.hypot(east, north))
