"""Metrics of swimming, for numbers or arrays in SI units, with broadcasting."""

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.arrays import Array


def _numbers(values: ArrayLike) -> Array:
    return np.asarray(values, dtype=np.float64)


def cost_of_transport(power: ArrayLike, mass: ArrayLike, speed: ArrayLike) -> Array:
    """Return the energy per mass and distance, P / (m |U|) [J/(kg m)] (Eqs 38-39 of the paper, which omit m)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return _numbers(power) / (_numbers(mass) * np.abs(_numbers(speed)))


def strouhal(frequency: ArrayLike, excursion: ArrayLike, speed: ArrayLike) -> Array:
    """Return the Strouhal number f A / |U|, infinite at rest; A: peak-to-peak excursion of the tail tip [m]."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return _numbers(frequency) * _numbers(excursion) / np.abs(_numbers(speed))


def stride_length(speed: ArrayLike, frequency: ArrayLike, length: ArrayLike) -> Array:
    """Return the stride length in body lengths per beat, U / (f L) [1]."""
    return _numbers(speed) / (_numbers(frequency) * _numbers(length))
