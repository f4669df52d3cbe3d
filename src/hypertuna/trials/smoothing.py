"""Smoothing: joint angles as they were measured, made functions of time that have rates and accelerations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hypertuna.errors import InputError, shown
from hypertuna.trials.tracks import JointSeries

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

__all__ = ["SmoothSeries", "smooth"]

Array = NDArray[np.float64]

DEGREE = 5  # of the smoothing splines: accelerations are three times differentiable
NEIGHBORS = np.array([-3, -2, -1, 1, 2, 3])  # of a sample whose noise is estimated


@dataclass(frozen=True)
class SmoothSeries:
    """A joint series as functions of time that have rates and accelerations.

    Attributes
    ----------
    series : JointSeries
        What was smoothed.
    noise : ndarray, shape (groups,)
        Standard deviation that was taken for noise [rad].
    splines : tuple of scipy.interpolate.BSpline
        Angle of each joint group [rad] by time [s].
    """

    series: JointSeries
    noise: Array
    splines: tuple[BSpline, ...]

    def __call__(self, time: Array) -> Array:
        """Evaluate the joint groups: `time` (times,) [s]; returns (times, groups, 3) [rad], [rad/s], [rad/s^2]."""
        derivatives = [[spline.derivative(order)(time) for order in range(3)] for spline in self.splines]
        return np.moveaxis(np.array(derivatives), -1, 0)


def smooth(series: JointSeries, *, noise: float | None = None) -> SmoothSeries:
    """Smooth a joint series by quintic splines (FITPACK), as smooth as its noise allows.

    Each spline has the fewest knots with which the sum of squared residuals is K sigma^2 + sqrt(2 K) sigma^2 or less:
    the upper end of the range where K residuals of noise sigma lie. A replayed motion depends on angles and rates;
    accelerations, which suffer most from noise, enter only the joint torques.

    Parameters
    ----------
    series : JointSeries
    noise : float, optional
        Standard deviation sigma of the measured angles [rad]; 0 interpolates. Left out, it is estimated for each
        joint group from what polynomials through three samples on either side miss of the sample between them.

    Returns
    -------
    SmoothSeries

    Raises
    ------
    InputError
        If the noise is negative or not finite.
    """
    if noise is not None and not 0 <= noise < math.inf:
        fix = "give the standard deviation of the measured angles in radians"
        raise InputError("must not be negative", key="noise", value=shown(noise), fix=fix)
    groups = series.angle.shape[1]
    sigma = _noise(series) if noise is None else np.full(groups, float(noise))
    splines = tuple(_spline(series.time, series.angle[:, g], sigma[g]) for g in range(groups))
    return SmoothSeries(series, sigma, splines)


def _noise(series: JointSeries) -> Array:
    """Estimate the noise of each joint group from its samples and the quintics through their neighbors."""
    reach = NEIGHBORS.max()
    middle = np.arange(reach, len(series.time) - reach)
    near = middle[:, np.newaxis] + NEIGHBORS
    arm = series.time[near] - series.time[middle, np.newaxis]
    # Lagrange's weights at the sample: prod_m arm_m / (arm_m - arm_j)
    weights = np.empty_like(arm)
    for j in range(len(NEIGHBORS)):
        others = np.delete(arm, j, axis=1)
        weights[:, j] = np.prod(others / (others - arm[:, j : j + 1]), axis=1)
    missed = series.angle[middle] - np.einsum("kj,kjg->kg", weights, series.angle[near])
    sigma: Array = np.sqrt(np.mean(missed**2 / (1 + (weights**2).sum(axis=1, keepdims=True)), axis=0))
    return sigma


def _spline(time: Array, angle: Array, sigma: float) -> BSpline:
    """Fit a smoothing spline."""
    from scipy.interpolate import BSpline, splrep  # here, because it takes longer to import than a swim takes

    bound = (len(time) + math.sqrt(2 * len(time))) * sigma**2
    spline, _, trouble, _ = splrep(time, angle, k=DEGREE, s=bound, full_output=1)
    if trouble > 0:  # so little noise that FITPACK cannot reach it: there is nothing to smooth
        spline = splrep(time, angle, k=DEGREE, s=0)
    return BSpline(*spline)
