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


def mean_speed(chord: ArrayLike, turn: ArrayLike, period: ArrayLike) -> Array:
    """Return the speed along the mean path of a beat.

    The mean path of a settled beat is a circle (a straight line when the body does not turn): over a beat it runs
    through an arc of which `chord` is the chord.

    Parameters
    ----------
    chord : array_like
        Distance between the nose's positions at the start and the end of a beat [m].
    turn : array_like
        Change of heading over the beat [rad].
    period : array_like
        Duration of the beat [s].

    Returns
    -------
    ndarray
        chord / T (turn / 2) / sin(turn / 2) [m/s].
    """
    half = _numbers(turn) / 2
    bend = np.divide(half, np.sin(half), out=np.ones_like(half), where=half != 0)
    return _numbers(_numbers(chord) * bend / _numbers(period))


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
