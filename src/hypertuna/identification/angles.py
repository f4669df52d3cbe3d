"""How errors of measured joint angles affect the fitted coefficients: add noise, smooth and replay again."""

from dataclasses import replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.coefficients import bounds_of, prior_rows
from hypertuna.identification.experiment import Experiment
from hypertuna.identification.prediction import Prediction, predict, weighted

DRAWS = 24  # random draws of the noise of all joint angles
SEED = 0  # of the draws; it is fixed so that repeating a fit gives the same intervals


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
