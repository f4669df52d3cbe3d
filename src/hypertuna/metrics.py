"""Metrics of swimming: pure functions of numbers or arrays that broadcast, SI units."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.arrays import Array


def _numbers(values: ArrayLike) -> Array:
    return np.asarray(values, dtype=np.float64)


def mean_speed(x: ArrayLike, y: ArrayLike, turn: float, period: float) -> float:
    """Return the speed along the mean path of a beat [m/s].

    A settled beat turns the body about a point: the mean path is the circle around it at the nose's mean distance, or
    a straight line without a turn. `x` and `y` (times,) [m] are positions of the nose at equal intervals over one beat,
    both ends included; `turn` [rad] is counter-clockwise, less than half a circle.
    """
    points = (_numbers(x) - _numbers(x)[0]) + 1j * (_numbers(y) - _numbers(y)[0])
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


def body_lengths_per_second(speed: ArrayLike, length: ArrayLike) -> Array:
    """Return the speed in body lengths per second, U / L [1/s]."""
    return _numbers(speed) / _numbers(length)


def cost_of_transport(power: ArrayLike, mass: ArrayLike, speed: ArrayLike) -> Array:
    """Return the energy per mass and distance, P / (m |U|) [J/(kg m)] (Eqs 38-39 of the paper, which omit m)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return _numbers(power) / (_numbers(mass) * np.abs(_numbers(speed)))


def strouhal(frequency: ArrayLike, excursion: ArrayLike, speed: ArrayLike) -> Array:
    """Return the Strouhal number f A / |U|, A the excursion of the tail tip, peak to peak [m]; infinite at rest."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return _numbers(frequency) * _numbers(excursion) / np.abs(_numbers(speed))


def stride_length(speed: ArrayLike, frequency: ArrayLike, length: ArrayLike) -> Array:
    """Return the body lengths per beat, U / (f L)."""
    return _numbers(speed) / (_numbers(frequency) * _numbers(length))


def efficiency(towed_power: ArrayLike, power: ArrayLike) -> Array:
    """Return the quasi-propulsive efficiency: power that tows the straight body over power spent.

    A body in steady swimming has no net thrust, so that Froude's efficiency is undefined; this one is defined
    (Maertens, Triantafyllou and Yue, 2015). Powers are in W; the result is NaN where no power is spent.
    """
    power = _numbers(power)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(power > 0, _numbers(towed_power) / power, np.nan)
