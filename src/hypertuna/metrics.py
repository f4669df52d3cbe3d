"""Metrics of swimming: pure functions of plain numbers or arrays, SI units.

Arguments broadcast against each other; every function returns what NumPy's arithmetic gives for them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "body_lengths_per_second",
    "cost_of_transport",
    "efficiency",
    "mean_speed",
    "stride_length",
    "strouhal",
]

Array = NDArray[np.float64]


def _numbers(values: ArrayLike) -> Array:
    """Take anything that NumPy takes."""
    return np.asarray(values, dtype=np.float64)


def mean_speed(x: ArrayLike, y: ArrayLike, turn: float, period: float) -> float:
    """Return the speed along the mean path of a beat.

    A settled beat turns the body about a point: the mean path is the circle around it at the nose's mean distance, or
    a straight line when the body does not turn.

    Parameters
    ----------
    x, y : array_like, shape (times,)
        Positions of the nose at equal intervals over one beat, its start and its end included [m].
    turn : float
        Change of heading over the beat [rad], counter-clockwise, less than half a circle.
    period : float
        Duration of the beat [s].

    Returns
    -------
    float
        Length of the mean path over the period [m/s].
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
    """Return U / L.

    Parameters
    ----------
    speed : array_like
        U [m/s].
    length : array_like
        Body length L [m].

    Returns
    -------
    ndarray
        Speed [1/s].
    """
    return _numbers(speed) / _numbers(length)


def cost_of_transport(power: ArrayLike, mass: ArrayLike, speed: ArrayLike) -> Array:
    """Return the energy per mass and distance, P / (m |U|) (Eqs 38-39 of the paper, which leave m out).

    Parameters
    ----------
    power : array_like
        Mean power P [W].
    mass : array_like
        Mass m of the whole robot [kg].
    speed : array_like
        U [m/s].

    Returns
    -------
    ndarray
        Cost of transport [J/(kg m)]; infinite at rest.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return _numbers(power) / (_numbers(mass) * np.abs(_numbers(speed)))


def strouhal(frequency: ArrayLike, excursion: ArrayLike, speed: ArrayLike) -> Array:
    """Return the Strouhal number St = f A / |U|.

    Parameters
    ----------
    frequency : array_like
        Beat frequency f [Hz].
    excursion : array_like
        Excursion A of the tail tip across the mean path, peak to peak [m].
    speed : array_like
        U [m/s].

    Returns
    -------
    ndarray
        Strouhal number; infinite at rest.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return _numbers(frequency) * _numbers(excursion) / np.abs(_numbers(speed))


def stride_length(speed: ArrayLike, frequency: ArrayLike, length: ArrayLike) -> Array:
    """Return the body lengths swum per beat, U / (f L).

    Parameters
    ----------
    speed : array_like
        U [m/s].
    frequency : array_like
        Beat frequency f [Hz].
    length : array_like
        Body length L [m].

    Returns
    -------
    ndarray
        Stride length.
    """
    return _numbers(speed) / (_numbers(frequency) * _numbers(length))


def efficiency(towed_power: ArrayLike, power: ArrayLike) -> Array:
    """Return the quasi-propulsive efficiency: power to tow the straight body at that speed over power spent.

    A body that swims steadily has no net thrust, so Froude's efficiency is not defined for it; this one is
    (Maertens, Triantafyllou and Yue, 2015).

    Parameters
    ----------
    towed_power : array_like
        Drag of the straight body at speed U, times U [W].
    power : array_like
        Mean mechanical power of the joints [W].

    Returns
    -------
    ndarray
        Efficiency; not a number where no power is spent.
    """
    power = _numbers(power)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(power > 0, _numbers(towed_power) / power, np.nan)
