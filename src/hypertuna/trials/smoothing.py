"""Smoothing: measured joint angles as functions of time with rates and accelerations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.arrays import Array
from hypertuna.ranges import NOT_NEGATIVE
from hypertuna.trials.tracks import JointSeries

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

DEGREE = 5  # of the splines: accelerations are three times differentiable
NEIGHBORS = np.array([-3, -2, -1, 1, 2, 3])  # samples in the noise estimate of a sample


@dataclass(frozen=True)
class SmoothSeries:
    """A joint series as functions of time with rates and accelerations."""

    series: JointSeries  # as measured
    noise: Array  # (groups,) [rad], standard deviation of the noise
    splines: tuple[BSpline, ...]  # angle of each joint group [rad] over time [s]

    def __call__(self, time: Array) -> Array:
        """Evaluate the joint groups: `time` (times,) [s]; returns (times, groups, 3) [rad], [rad/s], [rad/s^2]."""
        derivatives = [[spline.derivative(order)(time) for order in range(3)] for spline in self.splines]
        return np.moveaxis(np.array(derivatives), -1, 0)


def smooth(series: JointSeries, *, noise: float | None = None) -> SmoothSeries:
    """Smooth a joint series by quintic splines (FITPACK), as smooth as its noise allows.

    Each spline has the fewest knots with which the sum of squared residuals is K sigma^2 + sqrt(2 K) sigma^2 or less:
    the upper end of the range of K residuals of noise sigma.

    Parameters
    ----------
    series : JointSeries
    noise : float, optional
        Standard deviation sigma of the measured angles [rad]; 0 interpolates. Default: estimated for each joint group
        from the residuals of polynomials through three samples on either side of a sample.

    Returns
    -------
    SmoothSeries
    """
    from scipy.interpolate import BSpline, splrep  # imported here: slow to import

    if noise is not None:
        NOT_NEGATIVE.check(noise, "noise", "give the standard deviation of the measured angles in radians")
    sigma = white_noise(series.angle, series.time) if noise is None else np.full(series.angle.shape[1], float(noise))
    time, count = series.time, len(series.time)
    splines = []
    for angle, sd in zip(series.angle.T, sigma, strict=True):
        limit = (count + math.sqrt(2 * count)) * sd**2
        spline, _, failure, _ = splrep(time, angle, k=DEGREE, s=limit, full_output=1)
        if failure > 0:  # the noise is too small for FITPACK: interpolate
            spline = splrep(time, angle, k=DEGREE, s=0)
        splines.append(BSpline(*spline))
    return SmoothSeries(series, sigma, tuple(splines))


def white_noise(values: Array, time: Array | None = None) -> Array:
    """Estimate the noise (columns,) of samples (times, columns) from the quintics through their neighbors."""
    reach = NEIGHBORS.max()
    time = np.arange(len(values), dtype=float) if time is None else time
    if len(values) <= 2 * reach:
        return np.zeros(values.shape[1])
    middle = np.arange(reach, len(time) - reach)
    near = middle[:, np.newaxis] + NEIGHBORS
    arm = time[near] - time[middle, np.newaxis]
    # Lagrange's weights at the sample: prod_m arm_m / (arm_m - arm_j)
    weights = np.empty_like(arm)
    for j in range(len(NEIGHBORS)):
        others = np.delete(arm, j, axis=1)
        weights[:, j] = np.prod(others / (others - arm[:, j : j + 1]), axis=1)
    residual = values[middle] - np.einsum("kj,kjg->kg", weights, values[near])
    return np.asarray(np.sqrt(np.mean(residual**2 / (1 + (weights**2).sum(axis=1, keepdims=True)), axis=0)))
