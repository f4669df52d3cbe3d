"""The model in SciPy: `solve_ivp` with a NumPy right-hand side, one gait, the plane's vectors as complex numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from peers.fish import STEPS, Array, Fish, Gaits, beat_speed

METHODS = ("RK45", "DOP853", "LSODA")
Complex = NDArray[np.complex128]


def make_rate(fish: Fish, gait: Gaits) -> tuple[Callable[[float, Array], Array], Callable[[float, Array], Array]]:
    """Return the right-hand side `rate(t, P)` and `twist(t, P)` of one gait; P = (p_x, p_y, h)."""
    n, m, total = fish.links, fish.moving_mass, fish.moving_mass.sum()
    angles = np.cumsum(fish.share, axis=0)
    reach = np.tril(np.tile(fish.length, (n, 1)), -1) + np.diag(fish.com)  # link axes -> centers of mass
    omega, amplitude, phase = 2 * np.pi * gait.frequency[0], gait.amplitude[0], gait.phase[0]
    swing, swing_rate = angles * amplitude, angles * (amplitude * omega)
    inertia = fish.inertia.sum()

    def kinematics(t: float, P: Array) -> tuple[Complex, Complex, Complex, complex, float]:
        clock = omega * t - phase
        axis = np.exp(1j * (swing @ np.sin(clock)))
        turn = swing_rate @ np.cos(clock)
        com, flow = reach @ axis, reach @ (1j * turn * axis)
        center = m @ com / total
        mobility = 1 / (m @ (com.real**2 + com.imag**2) + inertia - total * abs(center) ** 2)
        spin = m @ (com.conj() * flow).imag + fish.inertia @ turn
        p = complex(P[0], P[1]) - m @ flow
        r = mobility * (P[2] - spin - (center.conjugate() * p).imag)
        return axis, com, flow, p / total - 1j * center * r, r

    def rate(t: float, P: Array) -> Array:
        axis, com, flow, velocity, r = kinematics(t, P)
        along = (velocity + 1j * r * com + flow) * axis.conj()
        drag = (fish.k_t * along.real * abs(along.real) + 1j * (fish.k_n * along.imag * abs(along.imag))) * axis
        p = complex(P[0], P[1])
        force = -1j * r * p - drag.sum()
        return np.array([force.real, force.imag, -(velocity.conjugate() * p).imag - (com.conj() * drag).imag.sum()])

    def twist(t: float, P: Array) -> Array:
        velocity, r = kinematics(t, P)[3:]
        return np.array([velocity.real, velocity.imag, r])

    return rate, twist


def swim(fish: Fish, gait: Gaits, beats: int, *, method: str, rtol: float) -> float:
    """Return the speed over the last of `beats` beats from rest, m/s."""
    rate, twist = make_rate(fish, gait)
    last = (beats - 1 + np.arange(STEPS + 1) / STEPS) / gait.frequency[0]
    found = solve_ivp(rate, (0, last[-1]), np.zeros(3), method=method, rtol=rtol, atol=1e-2 * rtol, t_eval=last)
    twists = np.stack([twist(t, P) for t, P in zip(last, found.y.T, strict=True)])
    return float(beat_speed(twists[:, :, None], gait.frequency)[0])


def matched_rtol(fish: Fish, gait: Gaits, beats: int, *, method: str, error: float) -> float:
    """Return the largest relative tolerance, in half decades, that keeps the speed's relative error below `error`."""
    exact = swim(fish, gait, beats, method="DOP853", rtol=1e-12)
    best = 1e-11
    for rtol in 10.0 ** np.arange(-10.5, -2, 0.5):
        if abs(swim(fish, gait, beats, method=method, rtol=float(rtol)) / exact - 1) > error:
            break
        best = float(rtol)
    return best
