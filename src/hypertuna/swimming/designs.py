"""Designs of a robot: the numbers that its settled beats depend on, and their derivatives with respect to variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.design import Variable, designed, variables
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.model import parameter_values, share_values
from hypertuna.swimming.yielding import spring_values

STENCIL = np.arange(-2.0, 3.0)  # points [steps]; exact for polynomials of degree four, such as those of lengths, masses
STEP = 1e-4  # step over the value, or over a hundredth of its range if that is more


def design_of(
    robot: Robot, ends: Mapping[str, tuple[float, float]], *, derivatives: bool = True
) -> tuple[Variable, ...]:
    """Return a robot's numbers as variables, from low and high by key; refuse one that changes no settled beat.

    With `derivatives`, refuse also one that settled beats have no derivative by.
    """
    design = variables(robot, ends)
    for variable in design:
        low, high = (designed(robot, (variable,), (end,)) for end in (variable.low, variable.high))
        if not np.array_equal(beat_features(low), beat_features(high)):
            continue
        if np.array_equal(_shares(low), _shares(high)):
            rule = "must change how the robot swims, but its derivative is zero everywhere"
            fix = f"leave it out: {_why_idle(robot, variable)}"
            raise InputError(rule, key=f"design {variable.name}", file=robot.file or None, fix=fix)
        if derivatives:
            rule, fix = "has no derivative beside passive hinges", "try its values one by one, by `sweep --design`"
            raise InputError(rule, key=f"design {variable.name}", file=robot.file or None, fix=fix)
    return design


def _shares(robot: Robot) -> list[float]:
    """Return the shares of all joints in their groups' bends, which settled beats beside hinges depend on too."""
    return [share for group in robot.joints for share in group.share]


def model_features(robot: Robot) -> Array:
    """Return the parameters of a robot's model, springs and tendons (parameters,) [SI], in the order of derivatives."""
    gait = Gait(1.0, (0.0,) * len(robot.joints), (0.0,) * len(robot.joints))
    extra = spring_values(robot) | share_values(robot)
    values = np.append(parameter_values(robot, gait), [*extra.values()])
    return np.where(np.isfinite(values), values, 0.0)  # an ideal joint has an infinite bandwidth


def beat_features(robot: Robot) -> Array:
    """Return all numbers of a robot that its settled beats depend on (features,) [SI]."""
    return np.append(model_features(robot), [robot.body.mass, robot.body.length])


def rates(robot: Robot, design: Sequence[Variable], values: Array, features: Callable[[Robot], Array]) -> Array:
    """Return the derivatives (features, variables) of a robot's features with respect to variables, at given values.

    The features are sums of powers of the file's numbers. Five points within the range, a ten thousandth of the value
    apart, give the derivative to about 1e-11 of the feature over the value. At a kink in the table of a fin's added
    mass the derivative is less exact.
    """
    columns = []
    for k, variable in enumerate(design):
        width = variable.high - variable.low
        step = STEP * min(width, max(abs(values[k]), 0.01 * width))
        center = np.clip(values[k], variable.low + 2 * step, variable.high - 2 * step)
        nodes = center + step * STENCIL
        weights = _derivative_weights((values[k] - center) / step) / step
        rows = []
        for node in nodes:
            changed = values.copy()
            changed[k] = node
            rows.append(features(designed(robot, design, changed.tolist())))
        middle = rows[2]
        columns.append(weights @ (np.stack(rows) - middle))
    return np.stack(columns, axis=1)


def _derivative_weights(position: float) -> Array:
    """Return weights (5,) of values at the stencil that give the derivative of their polynomial at a place [steps]."""
    powers = np.arange(5.0)
    slopes = np.where(powers > 0, powers * position ** np.maximum(powers - 1, 0), 0.0)
    return np.linalg.solve(STENCIL ** powers[:, np.newaxis], slopes)


def _why_idle(robot: Robot, one: Variable) -> str:
    """Return the reason why a variable changes no settled beat, as text."""
    table, _, rest = one.name.partition(".")
    law = rest.partition(".")[0]
    if table == "water" and law in ("lumped", "strip", "elongated") and law != robot.model.water:
        return f"the robot swims in {robot.model.water} water (model.water, or --water)"
    if "bandwidth" in one.name and robot.model.joints == "ideal":
        return "the robot's joints are ideal (model.joints, or --joints)"
    return "a settled beat does not know it"
