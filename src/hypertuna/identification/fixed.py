"""Coefficients of the water law and numbers of springs that are not free, and the effect of their errors."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.identification.coefficients import Free
from hypertuna.identification.columns import column_of, is_spring
from hypertuna.identification.experiment import Experiment
from hypertuna.identification.names import NUISANCES, Names, common_place, default_bounds, factor_table, prior_factor
from hypertuna.identification.prediction import predict, weighted


def fixed_coefficients(robot: Robot, free: Sequence[Free]) -> list[Free]:
    """Return a coefficient for the fixed values of each column: a common factor, or a value if all are 0.

    Columns are those of the water law, and of estimated springs other than 0.
    """
    law, free_places = robot.model.water, {(f.column, i) for f in free for i in f.indices}
    frees = []
    for column, count in Names(robot).known.items():
        used = column.startswith(f"water.{law}.") or (column == "joints.bandwidth" and robot.model.joints != "ideal")
        fixed = [i for i in range(max(count, 1)) if (column, i) not in free_places]
        if is_spring(column) and prior_factor(robot, column) and any(column_of(robot, column)[i] for i in fixed):
            bounds = factor_table(column)
            frees.append(Free(common_place(column, fixed, count), bounds["lower"], bounds["upper"], 1.0))
            continue
        if not used or not fixed or column in NUISANCES or column not in default_bounds()["coefficient"]:
            continue
        largest, table = (
            max(float(column_of(robot, column)[i]) for i in fixed),
            default_bounds()["coefficient"][column],
        )
        if largest:
            frees.append(Free(common_place(column, fixed, count), 0.0, table["upper"] / largest, 1.0))
        else:
            frees.append(Free(common_place(column, fixed, count, common=False), table["lower"], table["upper"], 0.0))
    return frees


def model_errors(data: Experiment, values: Array, levels: dict[str, float]) -> Array:
    """Return the changes (elements, k) of residuals if each of k fixed coefficients is off by one standard deviation.

    These are coefficients with values from handbooks; their standard deviations are in data/published/bounds.toml.
    """
    fixed = fixed_coefficients(data.robot, data.free)
    factors = [(f, prior_factor(data.robot, f.column)) for f in fixed if f.common]
    uncertain = [(f, math.log(factor)) for f, factor in factors if factor]
    if not uncertain:
        return np.zeros((len(data.measured), 0))
    extended = replace(data, free=(*data.free, *(f for f, _ in uncertain)))
    extended_values = [*values, *(f.start for f, _ in uncertain)]
    prediction = predict(extended, extended_values, gradient_steps=data.steps, levels=levels)
    return np.asarray(weighted(data, prediction, levels)[1][:, len(data.free) :] * [sd for _, sd in uncertain])


def whitened(jacobian: Array, errors: Array) -> Array:
    """Return (1 + E E^T)^(-1/2) J, for a Jacobian J (elements, n) and model errors E (elements, k) over the noise.

    With it, coefficients are as uncertain as if the k fixed coefficients were free, with their priors.
    """
    left, singular, _ = np.linalg.svd(errors, full_matrices=False)
    return np.asarray(jacobian + left * (1 / np.sqrt(1 + singular**2) - 1) @ (left.T @ jacobian))
