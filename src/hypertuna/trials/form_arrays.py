"""Base of the binary forms: mark missing places in arrays."""

import numpy as np

from hypertuna.arrays import Array
from hypertuna.ranges import CELL

MAX_COORDINATE = CELL.max or np.inf  # in any unit


def seen(place: Array) -> Array:
    """Return places (..., 2 or 3) with NaN where a coordinate is missing or too large in any unit."""
    return np.where((np.abs(place) <= MAX_COORDINATE).all(axis=-1, keepdims=True), place, np.nan)
