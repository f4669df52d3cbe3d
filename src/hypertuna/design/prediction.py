"""Logarithms of what runs measure, with exact derivatives by the unknown coefficients."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.design.runs import TankRun
from hypertuna.design.unknowns import Unknowns
from hypertuna.identification.coefficients import columns, from_scale, parameter_jacobian
from hypertuna.swimming.beat import directional_derivatives, settle
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.swimming.model import core_model
from hypertuna.trials.kind import Point
from hypertuna.trials.kind_numbers import HeldRows

STEPS = 64  # Runge-Kutta steps per beat or glide: their error is far below the noise of a tank
COASTS = 2.0  # body lengths at the first speed: how long a glide is followed
BEATS = {"power": "mechanical_power"}  # names of the quantities of a settled beat that are others than of runs


class Row(NamedTuple):
    """One quantity of a run."""

    run: TankRun
    quantity: str


class Predicted(NamedTuple):
    """Predicted rows."""

    log: Array  # (rows,) of the value [SI], of a rate of turn to either side; NaN without a settled beat forward
    jacobian: Array  # (rows, n) by the scaled coefficients


def predict(unknowns: Unknowns, x: Array, rows: Sequence[Row]) -> Predicted:
    """Predict rows for scaled coefficients x (n,)."""
    values, robot = from_scale(unknowns.free, x), unknowns.robot
    changed = columns(robot, unknowns.free, values)
    along = np.ascontiguousarray(parameter_jacobian(robot, unknowns.free, values))
    at = Point(robot, core_model(robot, changed), changed, along, len(x), {}, {}, STEPS, STEPS, 1)
    kinds = {"steady": _beats, "tows": _held, "thrusts": _held, "glides": _coasting}
    found: dict[Row, tuple[float, Array]] = {}
    for kind, made in kinds.items():
        if own := list(dict.fromkeys(row for row in rows if row.run.kind == kind)):
            value, jacobian = made(at, own)
            with np.errstate(invalid="ignore", divide="ignore"):
                log = np.log(np.where(value > 0, value, np.nan))
                found |= dict(zip(own, zip(log, jacobian / value[:, np.newaxis], strict=True), strict=True))
    log = np.array([found[row][0] for row in rows])
    return Predicted(log, np.array([found[row][1] for row in rows]).reshape(len(rows), len(x)))


def _beats(at: Point, rows: Sequence[Row]) -> tuple[Array, Array]:
    """Return quantities (rows,) of settled beats, those of a turn to either side, and their derivatives (rows, n)."""
    place = {gait: k for k, gait in enumerate(dict.fromkeys(row.run.gait for row in rows if row.run.gait))}
    gaits = Gaits.of(list(place))
    beats = settle(at.robot, gaits, model=at.model, steps=STEPS)
    slopes = directional_derivatives(at.robot, gaits, beats, np.asarray(at.along), model=at.model, steps=STEPS)
    sound = (beats["status"] == 0) & (beats["speed"] > 0)

    def each(table: Mapping[str, Array]) -> Array:
        return np.array([table[BEATS.get(row.quantity, row.quantity)][place[_gait(row)]] for row in rows])

    value, good = each(beats), np.array([sound[place[_gait(row)]] for row in rows])
    sign = np.where([row.quantity == "turn_rate" for row in rows], np.sign(value), 1.0)
    return np.where(good, sign * value, np.nan), sign[:, np.newaxis] * each(slopes)


def _gait(row: Row) -> Gait:
    """Return the gait of a row that has one."""
    assert row.run.gait is not None
    return row.run.gait


def _held(at: Point, rows: Sequence[Row]) -> tuple[Array, Array]:
    """Return the drag of tows, or the thrust of a held fish, as their kinds of trial predict them."""
    rest = (0.0,) * len(at.robot.joints)
    gaits = tuple(row.run.gait or Gait(1.0, rest, rest) for row in rows)
    u, none = np.array([row.run.u for row in rows]), np.zeros(len(rows))
    sign = -1.0 if rows[0].run.gait is None else 1.0
    made = HeldRows(none, none.astype(int), (), len(rows), gaits, u, sign).predict(at)
    return made.computed, made.jacobian


def _coasting(at: Point, rows: Sequence[Row]) -> tuple[Array, Array]:
    """Return the lengths over which the speed of a straight body falls by a factor of e, from two speeds of a glide.

    Of a drag by the square of the speed, 1/u grows by 1/length a second; else it is the mean over the glide.
    """
    still, along, found = np.zeros((2 * STEPS + 1, len(at.robot.links.name), 3)), np.asarray(at.along), []
    for row in rows:
        u, time = row.run.u, COASTS * at.robot.body.length / row.run.u
        begin = np.array([-u, 0.0, 0.0])
        track = _core.track(at.model, still, along, step=time / STEPS, twist=begin, rates=True)
        end, by = -track["rate"][-1, 0], -track["rate_gradient"][-1, 0, len(begin) :]
        length = time / (1 / end - 1 / u)
        found.append((length, by * length**2 / (time * end**2)))
    return np.array([one[0] for one in found]), np.array([one[1] for one in found])
