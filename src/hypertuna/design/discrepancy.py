"""Discrepancy of the model: a smooth random function of the gait, and offsets of days."""

import math
from collections.abc import Sequence

import numpy as np

from hypertuna.arrays import Array
from hypertuna.design.prediction import Row
from hypertuna.swimming.gait import Gait, lags

SIZES = (0.0, 0.02, 0.05, 0.1, 0.2)  # possible standard deviations of the discrepancy of a logarithm
DESIGNED = 0.05  # smallest standard deviation of the discrepancy that a design assumes
DAYS = (0.0, 0.01, 0.02, 0.05)  # possible standard deviations of a day's offset, if there are several days
# Correlation lengths of the discrepancy: of the logarithm of frequency, amplitude or speed; of lag and bias [rad].
FACTOR, LAG, BIAS = math.log(2), math.radians(30), math.radians(10)


def correlation(first: Sequence[Row], second: Sequence[Row]) -> Array:
    """Return the correlations (first, second) of two lists of rows' discrepancies; 0 between different quantities."""
    a, b = _features(first), _features(second)
    distance = np.square(a[:, np.newaxis] - b[np.newaxis]).sum(axis=-1)
    same_quantity = [[row.quantity == other.quantity for other in second] for row in first]
    return np.where(np.reshape(same_quantity, distance.shape), np.exp(-0.5 * distance), 0.0)


def same_day(days: Sequence[str]) -> Array:
    """Return a matrix (rows, rows) with 1 where two rows are of the same day, else 0."""
    return np.array([[float(day == other) for other in days] for day in days]).reshape(len(days), len(days))


def _features(rows: Sequence[Row]) -> Array:
    """Return the coordinates (rows, 5) of rows' runs, in correlation lengths of the discrepancy."""
    coordinates = [
        _of_gait(row.run.gait) if row.run.gait else [math.log(row.run.u) / FACTOR, 0.0, 0.0, 0.0, 0.0] for row in rows
    ]
    return np.array(coordinates).reshape(-1, 5)


def _of_gait(gait: Gait) -> list[float]:
    """Return a gait's coordinates: logs of frequency, mean amplitude and last group's share; lag per joint; bias."""
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
