"""Errors of measured joint angles in the fitted coefficients: angles drawn anew, smoothed and replayed."""

from dataclasses import replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.coefficients import bounds_of, prior_rows
from hypertuna.identification.experiment import Experiment, Replayed
from hypertuna.identification.prediction import Prediction, predict, weighted
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import joint_grid
from hypertuna.trials.smoothing import SmoothSeries, smooth

DRAWS = 24  # of all joint angles
SEED = 0  # of the draws: the same fit has the same intervals


def angle_errors(data: Experiment, values: Array, prediction: Prediction, levels: dict[str, float]) -> Array:
    """Return the mean square (n, n) of the errors of the coefficients, scaled, that errors of joint angles make.

    The smoothed angles get white noise of the estimated size, and are smoothed again. What the coefficients would
    change to meet the same tracks follows from the linearized fit, with the bounds as a weak prior.
    """
    n = len(data.free)
    curves = [smooth(recording.joints, noise=recording.noise) for recording in data.trials.recordings]
    if not data.recordings or not any(curve.noise.any() for curve in curves):
        return np.zeros((n, n))
    lower, upper = bounds_of(data.free)
    root = (upper - lower) / np.sqrt(12)
    residual, jacobian = weighted(data, prediction, levels)
    known = prior_rows(data.free, np.zeros(n))[1]
    solve = np.linalg.pinv(np.concatenate([jacobian * root, known * root, np.eye(n)]))[:, : len(residual)]
    rng = np.random.default_rng(SEED)
    changes = []
    for _ in range(DRAWS):
        drawn = [
            _drawn(data, *parts, rng) for parts in zip(data.recordings, data.trials.recordings, curves, strict=True)
        ]
        moved = predict(replace(data, recordings=tuple(drawn)), values, gradient_steps=None, levels=levels)
        change = weighted(data, moved, levels)[0] - residual
        if not moved.failed.any():
            changes.append(root * (solve @ change))
    rows = np.array(changes).reshape(-1, n)
    return np.asarray(rows.T @ rows / max(len(rows), 1))


def _drawn(
    data: Experiment, replayed: Replayed, recording: Recording, curve: SmoothSeries, rng: np.random.Generator
) -> Replayed:
    """Return a recording with the noise of its joint angles drawn anew."""
    angle = curve(recording.joints.time)[:, :, 0]
    series = replace(recording.joints, angle=angle + curve.noise * rng.standard_normal(angle.shape))
    return replace(replayed, joints=joint_grid(data.robot, smooth(series, noise=recording.noise))[0])
