"""Logarithms of what runs measure, with exact derivatives by the unknown coefficients."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.design.runs import Run, Tow
from hypertuna.design.unknowns import Unknowns
from hypertuna.identification.coefficients import columns, from_scale, parameter_jacobian
from hypertuna.swimming.beat import directional_derivatives, settle
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.swimming.model import core_model

STEPS = 64  # Runge-Kutta steps per beat: their error is far below the noise of a tank
STEP = 1e-4  # of a scaled coefficient, for the drag of a tow, which is linear in the coefficients


class Row(NamedTuple):
    """One quantity of a run."""

    run: Run
    quantity: str


class Predicted(NamedTuple):
    """Predicted rows."""

    log: Array  # (rows,) of the value [SI]; NaN without a settled beat forward
    jacobian: Array  # (rows, n) by the scaled coefficients


def predict(unknowns: Unknowns, x: Array, rows: Sequence[Row]) -> Predicted:
    """Predict rows for scaled coefficients x (n,)."""
    log, jacobian = np.full(len(rows), np.nan), np.zeros((len(rows), len(x)))
    gaits = {row.run: k for k, row in enumerate(rows) if isinstance(row.run, Gait)}
    if gaits:
        place = {gait: k for k, gait in enumerate(gaits)}
        values, slopes = _gaits(unknowns, x, list(gaits), {row.quantity for row in rows} - {"drag"})
        for k, row in enumerate(rows):
            if isinstance(row.run, Gait):
                at = place[row.run]
                log[k], jacobian[k] = values[row.quantity][at], slopes[row.quantity][at]
    towed = {k: row.run.speed for k, row in enumerate(rows) if isinstance(row.run, Tow)}
    if towed:
        places, speeds = list(towed), np.array(list(towed.values()))
        log[places] = _log_drag(unknowns, x, speeds)
        for j, step in enumerate(STEP * np.eye(len(x))):
            ends = (_log_drag(unknowns, end, speeds) for end in (x + step, x - step))
            jacobian[places, j] = np.subtract(*ends) / (2 * STEP)
    return Predicted(log, jacobian)


def _gaits(
    unknowns: Unknowns, x: Array, gaits: Sequence[Gait], quantities: set[str]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return the logarithm of each quantity of settled beats (gaits,), and its derivatives (gaits, n)."""
    robot, values = unknowns.robot, from_scale(unknowns.free, x)
    model, listed = core_model(robot, columns(robot, unknowns.free, values)), Gaits.of(gaits)
    beats = settle(robot, listed, model=model, steps=STEPS)
    along = parameter_jacobian(robot, unknowns.free, values)
    slopes = directional_derivatives(robot, listed, beats, along, model=model, steps=STEPS)
    with np.errstate(invalid="ignore", divide="ignore"):
        sound = (beats["status"] == 0) & (beats["speed"] > 0)
        safe = {name: np.where(sound & (beats[name] > 0), beats[name], np.nan) for name in quantities}
        return {name: np.log(v) for name, v in safe.items()}, {n: slopes[n] / v[:, np.newaxis] for n, v in safe.items()}


def _log_drag(unknowns: Unknowns, x: Array, speeds: Array) -> Array:
    """Return the logarithm of the drag [N] of the straight robot at speeds (k,) [m/s]."""
    robot = unknowns.robot
    model = core_model(robot, columns(robot, unknowns.free, from_scale(unknowns.free, x)))
    still = np.zeros((len(speeds), len(robot.links.name), 3))
    twist = np.zeros((len(speeds), 3))
    twist[:, 0] = speeds
    return np.asarray(np.log(-_core.dynamics(model, still, twist)["wrench"][:, 0]))
