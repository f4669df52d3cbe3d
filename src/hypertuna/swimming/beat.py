"""Settled beats of many gaits: the rows that core host/rows.hpp computes, as named quantities with a status."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model, link_shares
from hypertuna.swimming.yielding import swing_of, yield_derivatives, yield_rows

DEFAULT_STEPS = _core.BEAT_STEPS  # Runge-Kutta steps per beat: errors of 8e-7 of the speed, 2e-6 of the power
MAX_BEATS = _core.NEWTON_BEATS  # most beats in each stage of Newton's method
APPROACH = _core.APPROACH_BEATS  # most beats in which a start from rest is followed toward a settled beat
AFTER = 200  # beats from rest before the search for the settled beat that it leads to; slow transients have decayed
NEUTRAL = _core.NEUTRAL  # largest stable multiplier, 1 with a margin: a body that stands still has 1 but for rounding

STATUSES = tuple(_core.beat_statuses())


class About(NamedTuple):
    """A row of the table of quantities in core swimming/quantities.hpp: unit, label and meaning."""

    shown_unit: str  # unit for people: BL/s for 1/s, and empty for 1
    label: str  # label on the terminal, with a note after a comma
    meaning: str
    shown: int  # 0: in data sets only, 1: in JSON records too, 2: on the terminal too
    better: int  # as an objective: 1 large is better, 2 small is better; 0: no objective
    differentiable: bool

    @property
    def unit(self) -> str:
        """SI unit of the quantity in data sets, in which body lengths (BL) have no unit."""
        return {"BL/s": "1/s", "BL per beat": "1", "": "1"}.get(self.shown_unit, self.shown_unit)


QUANTITIES = {row[0]: About(*row[1:]) for row in _core.quantities()}
DIFFERENTIABLE = tuple(name for name, about in QUANTITIES.items() if about.differentiable)


def check_steps(steps: int) -> None:
    """Check the number of Runge-Kutta steps per beat."""
    if not 8 <= steps <= 8192 or steps % 4:
        raise InputError("must be a multiple of 4 from 8 to 8192", key="steps", value=str(steps), fix="take 128")


_COLUMNS = _core.settle_columns()  # names of the columns of a row
_SIZE = _core.STATE_SIZE  # size of the state without hinges
_NAMED = _COLUMNS.index("p_x")  # number of named columns; state and monodromy matrix follow
_PERIODIC = [STATUSES.index(status) for status in ("settled", "unstable")]  # statuses of beats that repeat


def settle(
    robot: Robot,
    gaits: Gaits,
    *,
    model: _core.Model | None = None,
    steps: int = DEFAULT_STEPS,
    wait: int = -1,
    from_rest: int = -1,
    approach: int = 0,
    threads: int = 1,
) -> dict[str, Any]:
    """Find the settled beats of gaits; return columns (gaits, ...) of quantities, status, twist, state, multipliers.

    wait: beats to swim from rest before the beat that is measured; -1 solves for the settled beat, from a brisk speed
    or from the motion after `from_rest` beats from rest. approach: follow a start from rest toward each settled beat
    for at most this many beats ("arrived", "approach_beats"). With hinges, "momentum" is the core's whole state, and
    columns on their swing are added (`BEND` of `yielding`). "steps": Runge-Kutta steps per beat that were taken.
    """
    check_steps(steps)
    model = model or core_model(robot)
    options: dict[str, Any] = {"wait": wait, "max_beats": MAX_BEATS, "from_rest": from_rest, "approach": approach}
    options |= {"mass": robot.body.mass, "threads": threads}
    if robot.hinges:
        rows, size, steps_taken = yield_rows(robot, gaits, model, steps, options)
    else:
        rows, size = _core.settle(model, *gaits.columns, steps=steps, **options), _SIZE
        steps_taken = np.full(len(rows), steps)
    row = dict(zip(_COLUMNS[:_NAMED], rows.T, strict=False))
    _, momentum, monodromy, swings = np.split(rows, _NAMED + np.cumsum([0, size, size**2]), axis=1)
    swing = swing_of(robot, gaits, swings, model) if robot.hinges else {}
    multipliers = _multipliers(monodromy.reshape(-1, size, size))
    radius = np.abs(multipliers).max(axis=1)
    unstable = (row["status"] == 0) & (radius > NEUTRAL)
    return row | {
        "spectral_radius": radius,
        "arrived": row["arrived"] == 1,
        "status": np.where(unstable, STATUSES.index("unstable"), row["status"]).astype(np.int8),  # index in `STATUSES`
        "twist": np.stack([row[name] for name in ("u", "v", "r")], axis=1),
        "momentum": momentum,
        "multipliers": multipliers,
        "steps": steps_taken,
        **swing,
    }


def settle_from_rest(robot: Robot, gaits: Gaits, *, steps: int = DEFAULT_STEPS, threads: int = 1) -> dict[str, Any]:
    """Return the settled beats to which starts from rest lead, as in `settle`; gaits without one are unsettled."""
    result = settle(robot, gaits, steps=steps, from_rest=AFTER, approach=APPROACH, threads=threads)
    not_arrived = (result["status"] == 0) & ~result["arrived"]
    return result | {"status": np.where(not_arrived, np.int8(1), result["status"])}


def directional_derivatives(
    robot: Robot,
    gaits: Gaits,
    beats: Mapping[str, Any],
    directions: Array,
    *,
    model: _core.Model | None = None,
    steps: int = DEFAULT_STEPS,
    threads: int = 1,
) -> dict[str, Array]:
    """Return exact derivatives (gaits, directions) of settled beats, by quantity of `DIFFERENTIABLE`.

    directions (parameters, directions): in the space of the model's parameters; rows of springs (`spring_values`) or
    of joint shares (`share_values`) may follow. Derivatives are NaN where a gait does not repeat itself or spins.
    """
    check_steps(steps)
    momentum, along = np.ascontiguousarray(beats["momentum"]), np.ascontiguousarray(directions)
    settings: Any = {"steps": steps, "mass": robot.body.mass, "threads": threads}
    model = model or core_model(robot)
    if robot.hinges:
        settings.pop("steps")
        rows = yield_derivatives(robot, gaits, momentum, along, model, steps, settings)
    else:
        rows = _core.gradient(model, *gaits.columns, momentum, _with_shares(robot, model, along), **settings)
    rows[~(np.isin(beats["status"], _PERIODIC) & np.isfinite(beats["speed"]))] = np.nan
    return dict(zip(DIFFERENTIABLE, np.moveaxis(rows, 1, 0), strict=True))


def _with_shares(robot: Robot, model: _core.Model, along: Array) -> Array:
    """Return directions with a row added for the share of every link's front joint, after the parameters' rows."""
    parameters = len(model.parameter_names())
    rows = np.zeros((parameters + len(robot.links.name), along.shape[1]))
    rows[:parameters] = along[:parameters]
    if len(along) > parameters:
        rows[np.add(parameters, [*link_shares(robot)])] = along[parameters:]
    return rows


def _multipliers(monodromy: Array) -> NDArray[np.complex128]:
    """Return the eigenvalues (gaits, n) of monodromy matrices (gaits, n, n); NaN where a matrix is not finite."""
    try:
        return np.linalg.eigvals(monodromy).astype(np.complex128)
    except np.linalg.LinAlgError:  # some are not finite
        finite = np.isfinite(monodromy).all(axis=(1, 2))
        multipliers = np.full(monodromy.shape[:2], np.nan, dtype=np.complex128)
        multipliers[finite] = np.linalg.eigvals(monodromy[finite])
        return multipliers
