"""Robust objectives: taken over robots sampled from a fit, not for the most probable robot alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.optimization.objective import Evaluation

Statistic = Literal["mean", "worst5"]

WORST = 0.05  # part of the robots that "worst5" is the mean of
STATISTICS = {"mean": "mean over all robots", "worst5": "mean of the worst 5 % of the robots"}


def check_statistic(name: str) -> Statistic:
    """Check the name of a statistic over robots."""
    if name not in STATISTICS:
        raise InputError("must be mean or worst5", key="robust", value=shown(name), fix="choose one of them")
    return cast(Statistic, name)


def aggregate(samples: Sequence[Evaluation], statistic: Statistic) -> Evaluation:
    """Combine the evaluations of the same points by several robots.

    Each objective is its mean over the robots, or over its worst ceil(0.05 n) values (conditional value at risk;
    Rockafellar and Uryasev, 2000). Violations and the status are the worst, other quantities are means.
    """
    tail = len(samples) if statistic == "mean" else math.ceil(WORST * len(samples))
    value, violation = (np.stack([getattr(each, name) for each in samples]) for name in ("value", "violation"))
    worst = np.argsort(-value, axis=0, kind="stable")[:tail]  # (tail, points, objectives)
    hardest = violation.argmax(axis=0)[np.newaxis]  # (1, points, limits)
    derivatives = {}
    if samples[0].value_jacobian is not None:
        derivatives = {
            "value_jacobian": _selected(samples, "value_jacobian", worst).mean(axis=0),
            "violation_jacobian": _selected(samples, "violation_jacobian", hardest)[0],
            "speed_gradient": np.mean([np.asarray(each.speed_gradient) for each in samples], axis=0),
        }
    quantities = {name: np.stack([each.quantities[name] for each in samples]) for name in samples[0].quantities}
    return Evaluation(
        samples[0].x,
        np.take_along_axis(value, worst, axis=0).mean(axis=0),
        np.take_along_axis(violation, hardest, axis=0)[0],
        {name: q.max(axis=0) if name == "status" else q.mean(axis=0) for name, q in quantities.items()},
        **derivatives,
    )


def _selected(samples: Sequence[Evaluation], name: str, index: NDArray[np.intp]) -> Array:
    """Rows of a Jacobian that an index selects among the robots, for each point and objective or limit."""
    jacobians = np.stack([getattr(each, name) for each in samples])  # (robots, points, objectives or limits, dim)
    return np.take_along_axis(jacobians, index[..., np.newaxis], axis=0)
