"""Coefficients of the water law that are not free, and what their errors make of the residuals."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.identification.coefficients import Free, column_of
from hypertuna.identification.experiment import Experiment
from hypertuna.identification.names import NUISANCES, Names, common_place, default_bounds, prior_factor
from hypertuna.identification.prediction import predict, weighted


def fixed_coefficients(robot: Robot, free: Sequence[Free]) -> list[Free]:
    """Return what is not free in each column of the water law: one factor, or one value where all are 0."""
    law, own = robot.model.water, {(f.column, i) for f in free for i in f.indices}
    found = []
    for column, count in Names(robot).known.items():
        used = column.startswith(f"water.{law}.") or (column == "joints.bandwidth" and robot.model.joints != "ideal")
        fixed = [i for i in range(max(count, 1)) if (column, i) not in own]
        if not used or not fixed or column in NUISANCES or column not in default_bounds()["coefficient"]:
            continue
        largest, table = (
            max(float(column_of(robot, column)[i]) for i in fixed),
            default_bounds()["coefficient"][column],
        )
        if largest:
            found.append(Free(common_place(column, fixed, count), 0.0, table["upper"] / largest, 1.0))
        else:
            found.append(Free(common_place(column, fixed, count, common=False), table["lower"], table["upper"], 0.0))
    return found


def model_errors(data: Experiment, values: Array, levels: dict[str, float]) -> Array:
    """Return what residuals (elements, k) change by if fixed coefficients are off by one standard deviation each.

    These are the k columns that handbooks give, each off by its factor in data/published/bounds.toml.
    """
    fixed = fixed_coefficients(data.robot, data.free)
    known = [(one, prior_factor(data.robot, one.column)) for one in fixed if one.common]
    held = [(one, math.log(factor)) for one, factor in known if factor]
    if not held:
        return np.zeros((len(data.measured), 0))
    more = replace(data, free=(*data.free, *(one for one, _ in held)))
    there = predict(more, [*values, *(one.start for one, _ in held)], gradient_steps=data.steps, levels=levels)
    by: Array = weighted(data, there, levels)[1][:, len(data.free) :]
    return by * [size for _, size in held]


def whitened(jacobian: Array, errors: Array) -> Array:
    """Return (1 + E E^T)^(-1/2) J of a Jacobian J (elements, n) over the noise and errors E (elements, k) over it.

    Its coefficients are as uncertain as if what makes the errors were free, each with its standard deviation.
    """
    left, singular, _ = np.linalg.svd(errors, full_matrices=False)
    return np.asarray(jacobian + left * (1 / np.sqrt(1 + singular**2) - 1) @ (left.T @ jacobian))
