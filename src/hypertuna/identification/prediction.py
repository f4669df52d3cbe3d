"""Predict all runs of the trials with the model, with exact derivatives with respect to the free coefficients."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.coefficients import bounds_of, from_scale, point_at, to_scale
from hypertuna.identification.experiment import Experiment
from hypertuna.identification.names import NUISANCES
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.trials.kind import Point
from hypertuna.trials.kind import Prediction as Prediction

BESIDE = 1e-5  # part of a coefficient's bounds by which points for differences lie beside it


def predict(
    data: Experiment,
    values: Sequence[float] | Array,
    *,
    gradient_steps: int | None = DEFAULT_STEPS,
    levels: Mapping[str, float] | None = None,
) -> Prediction:
    """Compute every run of the trials for values (n,) of the free coefficients [SI].

    A run without a settled beat gets values that are far off and a zero Jacobian, so that a search turns back.
    gradient_steps: Runge-Kutta steps per beat for derivatives of steady runs; None: all Jacobians are zero. levels:
    noise of frames by quantity, for runs whose initial motion is not known.
    """
    options: dict[str, Any] = {
        "nuisances": {
            f.name: (k, float(value), float(value) if f.scale == "log" else 1.0)
            for k, (f, value) in enumerate(zip(data.free, values, strict=True))
            if f.column in NUISANCES
        },
        "levels": levels or {},
        "steps": data.steps,
        "gradient_steps": gradient_steps or data.steps,
        "threads": data.threads,
    }

    def beside(k: int) -> tuple[Point, Point, float]:
        """Return the points on both sides along a scaled coefficient, and their distance."""
        low, high = bounds_of(data.free)
        step, x = BESIDE * (high - low) * (np.arange(len(data.free)) == k), to_scale(data.free, values)
        left, right = (
            point_at(data.robot, data.free, from_scale(data.free, x + side * step), slopes=False, **options)
            for side in (-1, 1)
        )
        return left, right, float(step[k])

    slopes = gradient_steps is not None
    point = point_at(data.robot, data.free, values, slopes=slopes, beside=beside if slopes else None, **options)
    groups = [rows.predict(point) for rows in data.groups]
    return Prediction(
        np.concatenate([group.computed for group in groups]),
        np.concatenate([group.jacobian for group in groups]),
        np.concatenate([group.failed for group in groups]),
        np.concatenate([group.unstable for group in groups]),
        {name: derivatives for group in groups for name, derivatives in group.measurable.items()},
    )


def weighted(data: Experiment, prediction: Prediction, levels: dict[str, float]) -> tuple[Array, Array]:
    """Return residuals (elements,), computed minus measured, and their Jacobian, in units of their standard deviation.

    levels: of quantities whose noise is unknown: relative for single numbers [1], [m] and [rad] for poses.
    """
    scale = (data.noise(levels) * np.sqrt(data.count))[data.sample]
    return (prediction.computed - data.measured) / scale, prediction.jacobian / scale[:, np.newaxis]
