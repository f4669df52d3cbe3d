"""Base of the binary forms: names of rows, missing places, and points from arrays of numbers."""

import numpy as np

from hypertuna.arrays import Array
from hypertuna.ranges import CELL

LARGEST = CELL.max or np.inf


def seen(place: Array) -> Array:
    """Return places (..., 2 or 3) with NaN where a coordinate is missing or too large in any unit."""
    return np.where((np.abs(place) <= LARGEST).all(axis=-1, keepdims=True), place, np.nan)
