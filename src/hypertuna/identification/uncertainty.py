"""Uncertainty of a fit: intervals, correlations, undetermined directions, and the effect of errors of joint angles."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification import estimator
from hypertuna.identification.coefficients import ABSOLUTE_UNITS, Free, bounds_of, from_scale, prior_rows, to_scale
from hypertuna.identification.estimator import Direction
from hypertuna.identification.experiment import Experiment
from hypertuna.identification.fixed import model_errors, whitened
from hypertuna.identification.loss import interval_factor, residual_scale
from hypertuna.identification.prediction import Prediction, predict, weighted
from hypertuna.identification.residuals import degrees_taken, lack_of_fit, squares, stretches
from hypertuna.identification.sentences import MIN_WEIGHT, direction_sentence, helpful_measurements

Z_95 = 1.96  # standard deviations to either side that contain 95 % of normal errors
MIN_UNIT = 0.1  # smallest unit of a coefficient, as a fraction of its allowed range
DRAWS = 24  # random draws of the noise of all joint angles
SEED = 0  # of the draws; it is fixed so that repeating a fit gives the same intervals


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of the free coefficients of a fit."""

    sd: Array  # (n,), standard deviations of scaled coefficients (in log scale: relative); infinite if unidentifiable
    low: Array  # (n,), 95 % interval [SI], within the bounds
    high: Array  # (n,)
    covariance: Array  # (n, n), of the scaled coefficients
    correlation: Array  # (n, n)
    bounded_covariance: Array  # (n, n), with the bounds as a weak prior, for sampling
    unit: Array  # (n,), unit of each scaled coefficient in `Direction`
    constrained: tuple[bool, ...]  # whether the 95 % interval of each is shorter than its unit
    bound: tuple[str | None, ...]  # "lower" or "upper" for a value on that bound
    directions: tuple[Direction, ...]  # from the best to the least constrained
    factor: float  # on standard deviations, due to residuals beyond the stated noise and to a robust loss
    residual_scale: float  # ratio of the residuals to the stated noise, at least 1
    freedom: float  # degrees of freedom of Student's t
    estimated: bool = True  # whether the runs give intervals; otherwise these are of the priors, or the bounds


def uncertainty(
    data: Experiment, values: Array, prediction: Prediction, levels: dict[str, float], part: Experiment | None = None
) -> Uncertainty:
    """Compute the uncertainty of fitted values (n,) [SI] from the prediction there: docs/identify.md has the theory.

    part: some of the runs, for the profile likelihood; without it the problem is taken as linear.
    """
    frees, loss = data.free, data.loss
    n, x, (lower, upper) = len(frees), to_scale(frees, values), bounds_of(frees)
    unit = _units(frees, values, upper - lower)
    z = squares(data, prediction, levels)
    element_jacobian, prior_jacobian = weighted(data, prediction, levels)[1], prior_rows(frees, x)[1]
    taken = degrees_taken(element_jacobian, prior_jacobian)
    freedom_left = max(len(z) - taken, 1.0)
    scale = max(1.0, residual_scale(z, loss, share=freedom_left / len(z)))
    factor = max(interval_factor(z, loss, scale, data.count, freedom_left), math.sqrt(lack_of_fit(data, z)))
    stretch, freedom = stretches(data, prediction, levels, factor, taken)
    noise = stretch[data.sample][:, np.newaxis]
    whitened_jacobian = whitened(element_jacobian / noise, model_errors(data, values, levels) / noise)
    jacobian = np.concatenate([whitened_jacobian, prior_jacobian]) * unit
    quantile = estimator.t_quantile(freedom)
    profile = None if part is None else _profile(part, x, unit, levels, len(data.kind), factor, taken)
    # padded with rows of zeros if there are fewer elements than coefficients, as in fits that are stored
    padded = np.concatenate([jacobian, np.zeros((max(n - len(jacobian), 0), n))])
    angles = angle_errors(data, values, prediction, levels)
    result = estimator.estimate(
        padded, x, lower, upper, unit=unit, quantile=quantile, profile=profile, extra_covariance=angles
    )
    constrained = tuple((2 * quantile * result.sd < unit).tolist())
    unidentifiable, vectors = result.unidentifiable, result.vectors
    directions = [
        replace(d, singular_value=0.0 if no_effect else d.singular_value)
        for d, no_effect in zip(result.directions(lambda s, sd: 2 * quantile * sd < 1), unidentifiable, strict=True)
    ]
    helpful = helpful_measurements(data, prediction, jacobian, unit, quantile, directions)
    # the bounds as a normal prior with the variance of a uniform one, extent^2 / 12
    spread = (upper - lower) / math.sqrt(12)
    rows = np.concatenate([jacobian * (spread / unit), np.eye(n)])
    _, singular, basis = np.linalg.svd(rows, full_matrices=False)
    fitted = Uncertainty(
        sd=np.where((np.abs(vectors[unidentifiable]) > MIN_WEIGHT).any(axis=0), np.inf, result.sd),
        low=from_scale(frees, result.low),
        high=from_scale(frees, result.high),
        covariance=result.covariance,
        correlation=result.covariance / np.outer(result.sd, result.sd),
        bounded_covariance=np.asarray(np.outer(spread, spread) * (basis.T / singular**2 @ basis)) + angles,
        unit=unit,
        constrained=constrained,
        bound=estimator.on_bound(x, lower, upper),
        directions=tuple(
            replace(d, sentence=direction_sentence(data, unit, d, constrained, quantile, text))
            for d, text in zip(directions, helpful, strict=True)
        ),
        factor=factor,
        residual_scale=scale,
        freedom=freedom,
    )
    return _with_prior_intervals(fitted, data, values) if data.without_intervals else fitted


def _with_prior_intervals(fitted: Uncertainty, data: Experiment, values: Array) -> Uncertainty:
    """Replace intervals by those of the priors, or by the bounds without a prior, as the runs give none.

    The covariance keeps what the runs say about combinations of coefficients, for samples.
    """
    frees, (lower, upper) = data.free, bounds_of(data.free)
    known, n = np.array([f.prior is not None for f in frees]), len(frees)
    mean, sd = to_scale(frees, values), np.full(n, np.inf)
    for k, f in enumerate(frees):
        if f.prior is not None:
            mean[k], sd[k] = math.log(f.prior[0]), math.log(f.prior[1])
    low, high = (
        from_scale(frees, np.where(known, np.clip(mean + side * Z_95 * np.where(known, sd, 0.0), lower, upper), end))
        for side, end in ((-1, lower), (1, upper))
    )
    return replace(fitted, sd=sd, low=low, high=high, constrained=(False,) * n, directions=(), estimated=False)


def _profile(
    part: Experiment, x: Array, unit: Array, levels: dict[str, float], samples: int, factor: float, taken: float
) -> tuple[Callable[[Array], Array], Array]:
    """Return the residual function of part of the runs, scaled as if of all `samples`, and its Jacobian by x / unit."""
    prediction = predict(part, from_scale(part.free, x), gradient_steps=part.steps, levels=levels)
    stretch = stretches(part, prediction, levels, factor, taken)[0][part.sample]
    scale = math.sqrt(samples / len(part.kind)) / stretch

    def residual(point: Array) -> Array:
        moved = predict(part, from_scale(part.free, point), gradient_steps=None, levels=levels)
        return np.append(scale * weighted(part, moved, levels)[0], prior_rows(part.free, point)[0])

    jacobian = scale[:, np.newaxis] * weighted(part, prediction, levels)[1]
    return residual, np.concatenate([jacobian, prior_rows(part.free, x)[1]]) * unit


def _units(frees: Sequence[Free], values: Array, extent: Array) -> Array:
    """Return the unit (n,) of each scaled coefficient: its value, limited to a tenth to all of its allowed range."""
    units = []
    for f, value, extent_of in zip(frees, values.tolist(), extent.tolist(), strict=True):
        relative = max(1.0 if f.scale == "log" else abs(value), MIN_UNIT * extent_of)
        units.append(min(relative if f.scale == "log" else ABSOLUTE_UNITS.get(f.column, relative), extent_of))
    return np.array(units)


def angle_errors(data: Experiment, values: Array, prediction: Prediction, levels: dict[str, float]) -> Array:
    """Return the covariance (n, n) of the scaled coefficients that is due to errors of the joint angles.

    Noise of the estimated size is added to the smoothed angles, which are smoothed again. The change of the
    coefficients that would fit the same tracks follows from the linearized fit, with the bounds as a weak prior.
    """
    n = len(data.free)
    if not any(rows.uncertain for rows in data.groups):
        return np.zeros((n, n))
    lower, upper = bounds_of(data.free)
    spread = (upper - lower) / np.sqrt(12)
    residual, jacobian = weighted(data, prediction, levels)
    prior = prior_rows(data.free, np.zeros(n))[1]
    inverse = np.linalg.pinv(np.concatenate([jacobian * spread, prior * spread, np.eye(n)]))[:, : len(residual)]
    rng = np.random.default_rng(SEED)
    coefficient_changes = []
    for _ in range(DRAWS):
        noisy_groups = tuple(rows.drawn(data.robot, rng) for rows in data.groups)
        noisy_prediction = predict(replace(data, groups=noisy_groups), values, gradient_steps=None, levels=levels)
        residual_change = weighted(data, noisy_prediction, levels)[0] - residual
        if not noisy_prediction.failed.any():
            coefficient_changes.append(spread * (inverse @ residual_change))
    rows = np.array(coefficient_changes).reshape(-1, n)
    return np.asarray(rows.T @ rows / max(len(rows), 1))
