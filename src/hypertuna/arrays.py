"""Arrays of real numbers, and numbers rounded so that every processor has the same.

BLAS, NumPy's functions and the kernels differ by rounding errors from one instruction set to the next. What is computed
with them for the core (tables of a robot, pilot, image, firmware) is rounded to digits that are free of these errors:
then the same file and seed give the same run everywhere.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIGITS = 10  # significant: rounding errors of what is computed here are below 1e-13, what is described has fewer digits


def rounded(value: float) -> float:
    """Return a number with `DIGITS` significant digits."""
    return float(f"{value:.{DIGITS - 1}e}")


def without_last_bit(value: float) -> float:
    """Return a value of a function of the C library, at most 1, without the last bit, in which processors differ."""
    return round(value, 15)


def rounded_decimals(values: Array) -> Array:
    """Return numbers of a scale of 1, which may be sums of parts that cancel, with `DIGITS` decimals."""
    return np.asarray(np.round(values, DIGITS), dtype=np.float64)
