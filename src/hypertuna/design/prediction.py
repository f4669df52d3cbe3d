"""Predicted logarithms of measured quantities, with exact derivatives with respect to the unknown coefficients."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.design.kinds import RUN_KINDS, STEPS
from hypertuna.design.runs import TankRun
from hypertuna.design.unknowns import Unknowns
from hypertuna.identification.coefficients import from_scale, point_at


class Row(NamedTuple):
    """A run and one of its quantities: a row of predictions and covariances."""

    run: TankRun
    quantity: str


class Predicted(NamedTuple):
    """Logarithms of rows' quantities, and their derivatives with respect to the scaled coefficients."""

    log: Array  # (rows,) logarithms of values [SI], of magnitudes for rates of turn; NaN if the gait does not settle
    jacobian: Array  # (rows, n) derivatives of the logarithms with respect to the scaled coefficients


def predict(unknowns: Unknowns, x: Array, rows: Sequence[Row]) -> Predicted:
    """Return the predicted logarithms of rows and their derivatives, at scaled coefficients x (n,)."""
    options: Any = {"nuisances": {}, "levels": {}, "steps": STEPS, "gradient_steps": STEPS, "threads": 1}
    point = point_at(unknowns.robot, unknowns.free, from_scale(unknowns.free, x), slopes=True, **options)
    results: dict[Row, tuple[float, Array]] = {}
    for key, kind in RUN_KINDS.items():
        if asked := list(dict.fromkeys(row for row in rows if row.run.kind == key)):
            value, jacobian = kind.predict(point, [row.run.motion for row in asked], [row.quantity for row in asked])
            with np.errstate(invalid="ignore", divide="ignore"):
                log = np.log(np.where(value > 0, value, np.nan))
                results |= dict(zip(asked, zip(log, jacobian / value[:, np.newaxis], strict=True), strict=True))
    log = np.array([results[row][0] for row in rows])
    return Predicted(log, np.array([results[row][1] for row in rows]).reshape(len(rows), len(x)))
