"""Arrays of real numbers, and numbers rounded so that every processor has the same.

BLAS, NumPy's functions and the kernels differ by rounding errors from one instruction set to the next. So the
numbers that they compute for the core (tables of a robot, pilot, image, firmware) or that steer a search are rounded to
the digits without such errors: the same file and seed give the same run everywhere. (A search by pymoo or pycma may
still end elsewhere: NumPy sorts equal values in an order that depends on the processor.)
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BITS = 33  # significant bits that rounding keeps (10 digits); errors of the computations are below 1e-13


def rounded(values: Array) -> Array:
    """Return numbers rounded to `BITS` bits each."""
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.rint(np.ldexp(mantissa, BITS)), exponent - BITS), dtype=np.float64)


def rounded_number(value: float) -> float:
    """Return a number rounded to `BITS` bits."""
    return float(rounded(np.asarray(value, dtype=np.float64)))


def rounded_parts(values: Array) -> Array:
    """Return numbers of magnitude 1 rounded to multiples of 2^-`BITS`: a sum that cancels becomes exactly 0."""
    return np.asarray(np.rint(values * 2.0**BITS) / 2.0**BITS, dtype=np.float64)


def without_last_bit(value: float) -> float:
    """Return a C library function's value, at most 1, rounded to 15 digits: processors differ in its last bit."""
    return round(value, 15)
