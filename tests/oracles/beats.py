"""A gait, swum beat after beat with the oracle `planar`: joints, Runge-Kutta, the settled beat by brute force."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oracles.planar import Chain, Joints, Real, Water, acceleration, power


@dataclass(frozen=True)
class Gait:
    """``alpha_g(t) = bias_g + amplitude_g sin(2 pi frequency t - lag_g)``, spread over joints by ``share`` (groups, n).

    ``frequency`` (...) in Hz; ``amplitude``, ``lag``, ``bias`` (..., groups) in rad. ``bandwidth`` in Hz: first-order
    loss and lag of every harmonic.
    """

    frequency: Real
    amplitude: Real
    lag: Real
    bias: Real
    share: Real
    bandwidth: float = np.inf

    def joints(self, phase: Real | float) -> Joints:
        """Joint motion at ``phase`` = frequency * time (a number of beats), or at several, along axes before all."""
        omega = 2 * np.pi * self.frequency[..., None]
        ratio = self.frequency[..., None] / self.bandwidth
        amplitude = self.amplitude / np.sqrt(1 + ratio**2)
        angle = 2 * np.pi * phase - self.lag - np.arctan(ratio)
        return Joints(
            (self.bias + amplitude * np.sin(angle)) @ self.share,
            (omega * amplitude * np.cos(angle)) @ self.share,
            (-(omega**2) * amplitude * np.sin(angle)) @ self.share,
        )


def runge_kutta(
    rate: Callable[[float, Real], Real], start: float, stop: float, state: Real, step: Real | float
) -> Real:
    """One classic fourth-order step of d(state)/dt = rate(phase, state), lasting ``step`` [s] (...,1)."""
    middle = (start + stop) / 2
    k1 = rate(start, state)
    k2 = rate(middle, state + step / 2 * k1)
    k3 = rate(middle, state + step / 2 * k2)
    k4 = rate(stop, state + step * k3)
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def beat(chain: Chain, water: Water, gait: Gait, state: Real, steps: int = 128) -> Real:
    """States over one beat (steps + 1, ..., 6) from ``state`` (..., 6) at phase 0."""

    def rate(phase: float, y: Real) -> Real:
        return np.concatenate([y[..., 3:], acceleration(chain, water, gait.joints(phase), y)], axis=-1)

    step = (1 / gait.frequency / steps)[..., None]
    states = [state]
    for k in range(steps):
        states.append(runge_kutta(rate, k / steps, (k + 1) / steps, states[-1], step))
    return np.stack(states)


def settle(
    chain: Chain, water: Water, gait: Gait, *, steps: int = 128, beats: int = 400, tolerance: float = 1e-9
) -> Real:
    """Swim from rest, beat after beat, until the head's twist at phase 0 repeats to ``tolerance``; the last beat."""
    state = np.zeros((*gait.frequency.shape, 6))
    for _ in range(beats):
        states = beat(chain, water, gait, state, steps)
        last = twist(states[-1])
        if np.all(abs(last - twist(state)) < tolerance * abs(last).max(axis=-1, keepdims=True)):
            return states
        state = states[-1]
    raise RuntimeError(f"not settled after {beats} beats")


def twist(state: Real) -> Real:
    """Velocity and turning rate of the head in its own axes (..., 3)."""
    v = (state[..., 3] + 1j * state[..., 4]) * np.exp(-1j * state[..., 2])
    return np.stack([v.real, v.imag, state[..., 5]], axis=-1)


def speed(gait: Gait, states: Real) -> Real:
    """Mean speed [m/s] over a beat: the nose's displacement over the period; for a straight course."""
    return np.hypot(*np.moveaxis(states[-1] - states[0], -1, 0)[:2]) * gait.frequency


def mean_power(chain: Chain, water: Water, gait: Gait, states: Real) -> Real:
    """Mean mechanical power over a beat [W]: the sum over equal steps, exact to rounding for a periodic function."""
    steps = len(states) - 1
    phases = (np.arange(steps) / steps).reshape(-1, *(1 for _ in gait.lag.shape))
    return power(chain, water, gait.joints(phases), states[:-1]).mean(axis=0)


def mean_speed(x: Real, y: Real, turn: float, period: float) -> float:
    """Return the speed along the mean path of a beat [m/s].

    A settled beat turns the body about a point: the mean path is the circle around it at the nose's mean distance, or
    a straight line without a turn. `x` and `y` (times,) [m] are positions of the nose at equal intervals over one beat,
    both ends included; `turn` [rad] is counter-clockwise, less than half a circle.
    """
    points = (x - x[0]) + 1j * (y - y[0])
    chord, half = abs(points[-1]), turn / 2
    if chord == 0:
        return 0.0
    # The chord subtends the turn at the center, which lies to the left for a counter-clockwise turn: the circle
    # through the first point has curvature 2 sin(half) / chord and leaves it along the chord turned back by half.
    curvature = 2 * np.sin(half) / chord
    left = points / (points[-1] / chord * np.exp(-1j * half))
    gap = 2 * left.imag - curvature * np.abs(points) ** 2
    offset = gap / (1 + np.sqrt(1 - curvature * gap))
    arc = chord * (half / np.sin(half) if half else 1.0) * (1 - curvature * offset[:-1].mean())
    return float(arc / period)
