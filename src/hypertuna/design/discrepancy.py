"""Discrepancy: what the model misses, a smooth random function of the gait, and offsets of days."""

import math
from collections.abc import Sequence

import numpy as np

from hypertuna.arrays import Array
from hypertuna.design.prediction import Row
from hypertuna.swimming.gait import Gait, lags

SIZES = (0.0, 0.02, 0.05, 0.1, 0.2)  # standard deviations of the logarithm that a fit chooses among
DESIGNED = 0.05  # the least that a design reckons with
DAYS = (0.0, 0.01, 0.02, 0.05)  # of the offset of a day, where runs of several days are known
# Lengths over which the misfit of a model changes: a factor of two, an angle.
FACTOR, LAG, BIAS = math.log(2), math.radians(30), math.radians(10)


def correlation(first: Sequence[Row], second: Sequence[Row]) -> Array:
    """Return the correlation (first, second) of the discrepancies of rows: none between quantities."""
    a, b = _features(first), _features(second)
    distance = np.square(a[:, np.newaxis] - b[np.newaxis]).sum(axis=-1)
    same = [[one.quantity == other.quantity for other in second] for one in first]
    return np.where(np.reshape(same, distance.shape), np.exp(-0.5 * distance), 0.0)


def same_day(days: Sequence[str]) -> Array:
    """Return 1 for pairs of rows of one day, else 0."""
    return np.array([[float(one == other) for other in days] for one in days]).reshape(len(days), len(days))


def _features(rows: Sequence[Row]) -> Array:
    """Return where runs are, in the lengths of the discrepancy (rows, 5)."""
    each = [
        _of_gait(row.run.gait) if row.run.gait else [math.log(row.run.u) / FACTOR, 0.0, 0.0, 0.0, 0.0] for row in rows
    ]
    return np.array(each).reshape(-1, 5)


def _of_gait(gait: Gait) -> list[float]:
    """Return logarithms of frequency, mean amplitude and the last group's share, the mean lag of a joint, the bias."""
    bend = max(float(np.mean(gait.amplitude)), 1e-6)
    share = max(gait.amplitude[-1], 1e-6) / bend
    lag = lags(gait)[-1] / max(len(gait.phase) - 1, 1)
    return [
        math.log(gait.frequency) / FACTOR,
        math.log(bend) / FACTOR,
        math.log(share) / FACTOR,
        lag / LAG,
        float(np.mean(gait.bias)) / BIAS,
    ]
