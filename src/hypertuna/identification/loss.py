"""Robust losses of squared residuals, and robust estimates of the residuals' scale."""

import math

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array

LOSSES = ("linear", "soft_l1", "huber", "cauchy")  # names, as in SciPy
MAX_ITERATIONS, SCALE_TOLERANCE = 200, 1e-6  # iterations for a scale; their relative tolerance
MIN_CURVATURE = 1e-3  # lower bound of the mean of psi', by which results are divided


def loss_terms(loss: str, square: Array) -> Array:
    """Return rho(z) and its first and second derivative (3, n), for squared residuals z (n,) over their variance.

    rho is that of SciPy's least_squares. linear: z; soft_l1: 2 (sqrt(1 + z) - 1); huber: z up to 1, then
    2 sqrt(z) - 1; cauchy: ln(1 + z).
    """
    z = square
    one, zero = np.ones_like(z), np.zeros_like(z)
    if loss == "soft_l1":
        t = 1 + z
        return np.stack([2 * (np.sqrt(t) - 1), t**-0.5, -0.5 * t**-1.5])
    if loss == "huber":
        far = np.where(z > 1, z, 1.0)
        return np.where(z > 1, np.stack([2 * np.sqrt(far) - 1, far**-0.5, -0.5 * far**-1.5]), np.stack([z, one, zero]))
    if loss == "cauchy":
        t = 1 + z
        return np.stack([np.log1p(z), 1 / t, -1 / t**2])
    return np.stack([z, one, zero])


def residual_scale(
    z: Array,
    loss: str,
    *,
    share: float = 1.0,
    start: float = 0.0,
    lower: float = 0.0,
    tolerance: float = SCALE_TOLERANCE,
) -> float:
    """Return the scale s of residuals for which the mean of (z/s^2) rho'(z/s^2) is `share` times that of normal errors.

    z: squared residuals over their variance [1]; share: degrees of freedom per sample [1]; lower: lower limit of s.
    """
    node, weight = np.polynomial.hermite_e.hermegauss(60)  # z rho'(z) of normal errors of unit variance
    expected = float(weight @ (node**2 * loss_terms(loss, node**2)[1]) / weight.sum()) * share
    square = max(start**2, lower**2) or float(np.mean(z)) or 1.0
    for _ in range(MAX_ITERATIONS):
        last, ratio = square, z / square
        square = max(square * (float(np.mean(ratio * loss_terms(loss, ratio)[1])) / expected), lower**2)
        if square == 0 or abs(square / last - 1) < tolerance:
            break
    return math.sqrt(square)


def curvature(z: Array, loss: str, count: NDArray[np.intp]) -> float:
    """Return the mean of psi', the derivative of the influence function, at squared residuals z (samples,)."""
    _, first, second = loss_terms(loss, z)
    return max(float(np.mean(np.where(count > 1, first, first + 2 * z * second))), MIN_CURVATURE)


def interval_factor(z: Array, loss: str, scale: float, count: NDArray[np.intp], freedom: float) -> float:
    """Return the factor, at least 1, on the standard deviations of an M-estimate (Huber 1981, section 7.6).

    factor^2 = s^2 mean(psi^2) n / (n - p) / mean(psi')^2 with psi of residuals over the scale s.
    """
    scaled = z / scale**2  # outliers are judged by the actual noise
    slope = loss_terms(loss, scaled)[1]
    return max(1.0, scale * math.sqrt(float(np.sum(scaled * slope**2)) / freedom) / curvature(scaled, loss, count))
