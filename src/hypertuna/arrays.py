"""Arrays of real numbers, and rounding by which all processors get the same numbers.

BLAS, NumPy's functions and the kernels have rounding errors that depend on the instruction set. Numbers computed with
them for the core (tables of a robot, pilot, image, firmware) or for the steps of a search are rounded to digits without
such errors, so that the same file and seed give the same run everywhere. (A search by pymoo or pycma may still end
elsewhere, because NumPy sorts equal values in an order that depends on the processor.)
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BITS = 33  # significant bits that rounding keeps (10 digits); errors of the computations are below 1e-13


def rounded(values: Array) -> Array:
    """Round each number to `BITS` significant bits."""
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.rint(np.ldexp(mantissa, BITS)), exponent - BITS), dtype=np.float64)


def rounded_number(value: float) -> float:
    """Round a number to `BITS` significant bits."""
    return float(rounded(np.asarray(value, dtype=np.float64)))


def rounded_parts(values: Array) -> Array:
    """Round numbers of magnitude 1 to multiples of 2^-`BITS`, so that sums that cancel become 0."""
    return np.asarray(np.rint(values * 2.0**BITS) / 2.0**BITS, dtype=np.float64)


def without_last_bit(value: float) -> float:
    """Round a value up to 1, from a function of the C library, to 15 decimals; processors differ in its last bit."""
    return round(value, 15)
