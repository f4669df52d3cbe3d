"""Objectives of a gait, all to be minimized; evaluations of objectives and limits at points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array, rounded
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import NOT_NEGATIVE, POSITIVE
from hypertuna.swimming.beat import QUANTITIES

UNUSABLE = 1e30  # stands for infinity where a finite value or violation is required

# Quantities that can be an objective, and whether larger is better; those come first.
OBJECTIVES = {name: large for large in (True, False) for name, q in QUANTITIES.items() if q.better == 2 - large}


@dataclass(frozen=True)
class Objective:
    """A value to minimize: a weighted sum of quantities, plus |U - U_e| where a speed is expected (Eq. 42)."""

    name: str  # name for users
    terms: tuple[tuple[str, float], ...]  # keys of `hypertuna.swimming.beat.QUANTITIES`, each with its factor
    expected: float | None = None  # expected speed U_e [m/s]


def objective(name: str, *, maximize: bool | None = None, key: str = "objective") -> Objective:
    """Return the objective to optimize a quantity of `OBJECTIVES`, by default in the direction that is better."""
    if name not in OBJECTIVES:
        fix = did_you_mean(name, OBJECTIVES)
        raise InputError("must be a quantity to optimize", key=key, value=shown(name), fix=fix)
    large = OBJECTIVES[name] if maximize is None else maximize
    return Objective(name, ((name, -1.0 if large else 1.0),))


def expected_speed(speed: float, weight: float) -> Objective:
    """Return the objective |U - U_e| + k COT (Eq. 42) for a speed U_e [m/s] and a weight k [m/s per J/(kg m)]."""
    POSITIVE.check(speed, "speed", "give it in m/s")
    NOT_NEGATIVE.check(weight, "weight", "leave it out")
    return Objective("expected_speed", (("cost_of_transport", weight),), speed)


@dataclass(frozen=True)
class Evaluation:
    """Objectives and violations at points, with their derivatives with respect to the coordinates."""

    x: Array  # (points, dim) [Hz or rad]
    value: Array  # (points, objectives), infinite where a gait does not settle, stands still or swims backwards
    violation: Array  # (points, limits) excess over each limit, relative to the limit; not violated if <= 0 [1]
    quantities: dict[str, Array]  # (points,) each, in SI units; "status" is an index into `swimming.beat.STATUSES`
    value_jacobian: Array | None = None  # (points, objectives, dim)
    violation_jacobian: Array | None = None  # (points, limits, dim)
    speed_gradient: Array | None = None  # (points, dim)

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Whether each point has finite values and keeps every limit, shape (points,)."""
        return np.asarray((self.violation <= 0).all(axis=1) & np.isfinite(self.value).all(axis=1))

    @property
    def total_violation(self) -> Array:
        """Sum of the positive violations of each point, shape (points,) [1]."""
        return np.asarray(np.maximum(self.violation, 0).sum(axis=1))

    def rows(self, index: Sequence[int] | NDArray[np.intp] | NDArray[np.bool_]) -> Self:
        """Return the evaluation at the points that an index selects."""
        return self._map(lambda column: column[index])

    def followed_by(self, other: Evaluation) -> Self:
        """Return these points followed by the points of another evaluation of the same problem."""
        return self._map(lambda *columns: np.concatenate(columns), other)

    def rounded(self) -> Self:
        """Return these points with rounded values, so that rounding errors of the kernels do not affect their order."""
        return replace(self, value=rounded(self.value), violation=rounded(self.violation))

    def _map(self, function: Callable[..., Array], *others: Evaluation) -> Self:
        """Apply a function to every column of this and other evaluations; a column that one of them lacks is None."""

        def mapped(name: str) -> Any:
            columns = [getattr(each, name) for each in (self, *others)]
            if isinstance(columns[0], dict):
                return {key: function(*(column[key] for column in columns)) for key in columns[0]}
            return None if any(column is None for column in columns) else function(*columns)

        return type(self)(**{field.name: mapped(field.name) for field in fields(self)})
