"""Series of a run of the twin: values between its ticks, and their trend."""

import math

import numpy as np

from hypertuna.arrays import Array


def between(time: Array, value: Array, rate: Array, at: Array) -> Array:
    """Return values at times `at`, from cubics through the values and rates at the ticks."""
    step = time[1] - time[0]
    k = np.clip(((at - time[0]) / step).astype(int), 0, len(time) - 2)
    t = (at - time[k]) / step
    rise = value[k + 1] - value[k]
    square = (rate[k] + rate[k + 1]) * step - 2 * rise
    result: Array = value[k] + t * (rate[k] * step + t * (rise - rate[k] * step - square + t * square))
    return result


def trend(series: Array) -> float:
    """Return the relative slope per item of a fitted line, its magnitude reduced by twice its standard error."""
    n = len(series)
    mean = float(series.mean())
    if n < 2 or not math.isfinite(mean) or mean == 0:
        return math.nan
    position = np.arange(n) - (n - 1) / 2
    sum_of_squares = float(position @ position)
    slope = float(position @ series) / sum_of_squares
    scatter = series - mean - slope * position
    error = math.sqrt(float(scatter @ scatter) / (max(1, n - 2) * sum_of_squares))
    return math.copysign(max(0.0, abs(slope) - 2 * error), slope) / abs(mean)
