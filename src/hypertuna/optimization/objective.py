"""What is wished of a gait: goals to minimize and limits to keep, evaluated for many gaits in one batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.optimization.constraints import Limit, gait_limits, gait_quantities
from hypertuna.optimization.design_space import Space
from hypertuna.swimming.beat import DEFAULT_STEPS, QUANTITIES, settle, slopes
from hypertuna.swimming.sweep import Gaits

__all__ = [
    "OBJECTIVES",
    "SLOPED",
    "UNUSABLE",
    "Evaluation",
    "Goal",
    "Limit",
    "Problem",
    "expected_speed",
    "gait_limits",
    "goal",
]

Array = NDArray[np.float64]

STILL = 1e-3  # body lengths per beat: a gait that makes less way stands still
UNUSABLE = 1e30  # value or violation of a gait that cannot be used, where a number is wanted: larger than any other

# Quantities to wish for, and whether the larger one is better.
OBJECTIVES = {
    "speed": True,
    "speed_bl": True,
    "efficiency": True,
    "stride_length": True,
    "power": False,
    "power_positive": False,
    "loss": False,
    "cost_of_transport": False,
    "cost_of_transport_positive": False,
    "strouhal": False,
    "excursion": False,
    "torque_peak": False,
    "rate_peak": False,
    "turn_radius": False,
}
SLOPED = tuple(name for name in OBJECTIVES if name not in ("efficiency", "turn_radius"))  # with exact derivatives


@dataclass(frozen=True)
class Goal:
    """A value to minimize: a sum of quantities, and the distance of the speed from an expected one.

    Attributes
    ----------
    name : str
        In the words of the user.
    terms : tuple of (str, float)
        Quantities of `hypertuna.swimming.beat.QUANTITIES` and their factors.
    expected : float or None
        Expected speed U_e [m/s]; its distance |U - U_e| is added (Eq. 42).
    """

    name: str
    terms: tuple[tuple[str, float], ...]
    expected: float | None = None


def goal(name: str, *, largest: bool | None = None, key: str = "goal") -> Goal:
    """Wish for the best of a quantity.

    Parameters
    ----------
    name : str
        One of `OBJECTIVES`.
    largest : bool, optional
        Whether large is good; left out, `OBJECTIVES` says it.
    key : str
        What an error calls it.

    Returns
    -------
    Goal

    Raises
    ------
    InputError
        If there is no such quantity to wish for.
    """
    if name not in OBJECTIVES:
        fix = did_you_mean(name, OBJECTIVES)
        raise InputError("must be a quantity to wish for", key=key, value=shown(name), fix=fix)
    large = OBJECTIVES[name] if largest is None else largest
    return Goal(name, ((name, -1.0 if large else 1.0),))


def expected_speed(speed: float, weight: float) -> Goal:
    """Wish for an expected speed at low cost of transport: |U - U_e| + k COT (Eq. 42).

    Parameters
    ----------
    speed : float
        U_e [m/s].
    weight : float
        k [m/s per J/(kg m)].

    Returns
    -------
    Goal

    Raises
    ------
    InputError
        If the speed is not positive, or the weight is negative, or one of them is not finite.
    """
    if not (np.isfinite(speed) and speed > 0):
        raise InputError("must be greater than 0", key="speed", value=f"{speed:g}", fix="give it in m/s")
    if not (np.isfinite(weight) and weight >= 0):
        raise InputError("must not be negative", key="weight", value=f"{weight:g}", fix="leave it out")
    return Goal("expected_speed", (("cost_of_transport", weight),), speed)


@dataclass(frozen=True)
class Evaluation:
    """What was found at points.

    Attributes
    ----------
    x : ndarray, shape (points, dim)
        [Hz or rad].
    value : ndarray, shape (points, goals)
        Goals, all to be minimized; infinite for a gait that does not settle, stands still or swims backwards.
    violation : ndarray, shape (points, limits)
        How far each limit is passed, relative to it; kept where <= 0 [1].
    found : dict of ndarray, shape (points,)
        Quantities in SI units, and ``status``, index into `hypertuna.swimming.beat.STATUSES`.
    value_slopes : ndarray, shape (points, goals, dim), or None
        Derivatives of the values; of |U - U_e| on either side.
    violation_slopes : ndarray, shape (points, limits, dim), or None
        Derivatives of the violations.
    speed_slopes : ndarray, shape (points, dim), or None
        Derivatives of the speed.
    """

    x: Array
    value: Array
    violation: Array
    found: dict[str, Array]
    value_slopes: Array | None = None
    violation_slopes: Array | None = None
    speed_slopes: Array | None = None

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Whether each point is usable and keeps every limit, shape (points,)."""
        return np.asarray((self.violation <= 0).all(axis=1) & np.isfinite(self.value).all(axis=1))

    @property
    def excess(self) -> Array:
        """Sum of what each point passes the limits by, shape (points,) [1]."""
        return np.asarray(np.maximum(self.violation, 0).sum(axis=1))

    def rows(self, index: Sequence[int] | NDArray[np.intp] | NDArray[np.bool_]) -> Self:
        """Return some of the points.

        Parameters
        ----------
        index : sequence of int, or ndarray
            Which ones.

        Returns
        -------
        Evaluation
        """
        return self._made_of(lambda name: _part(getattr(self, name), index))

    def followed_by(self, other: Evaluation) -> Self:
        """Return these points, then those of another evaluation of the same problem.

        Parameters
        ----------
        other : Evaluation

        Returns
        -------
        Evaluation
        """
        return self._made_of(lambda name: _joined(getattr(self, name), getattr(other, name)))

    def _made_of(self, column: Callable[[str], Any]) -> Self:
        return type(self)(**{item.name: column(item.name) for item in fields(self)})


@dataclass(frozen=True)
class Problem:
    """Goals and limits over a space of gaits.

    Attributes
    ----------
    robot : Robot
    space : Space
    goals : tuple of Goal
    limits : tuple of Limit
        Every gait must swim forward, too.
    steps : int
        Runge-Kutta steps per beat.
    threads : int
        The result does not depend on it; a small population is done sooner by one.
    """

    robot: Robot
    space: Space
    goals: tuple[Goal, ...]
    limits: tuple[Limit, ...] = ()
    steps: int = DEFAULT_STEPS
    threads: int = 1
    needs: tuple[str, ...] = field(init=False)  # quantities that goals and limits are made of

    def __post_init__(self) -> None:
        forward = Limit("stride_length", STILL, upper=False)
        object.__setattr__(self, "limits", (forward, *(limit for limit in self.limits if limit != forward)))
        names = ["speed", "cost_of_transport", "stride_length"]
        names += [name for goal in self.goals for name, _ in goal.terms] + [limit.quantity for limit in self.limits]
        object.__setattr__(self, "needs", tuple(dict.fromkeys(names)))

    def evaluate(self, x: Array, *, slopes: bool = False) -> Evaluation:
        """Swim the gaits at points in one batch, and judge them.

        Parameters
        ----------
        x : ndarray, shape (points, dim)
            [Hz or rad].
        slopes : bool
            Whether to differentiate, too.

        Returns
        -------
        Evaluation
        """
        return self.judge(x, self.swim(x, slopes=slopes))

    @property
    def robots(self) -> tuple[Robot, ...]:
        """All robots that a gait is swum by: the one."""
        return (self.robot,)

    @property
    def rough(self) -> tuple[str, ...]:
        """Quantities that goals and limits need and that have no derivatives."""
        return tuple(name for name in self.needs if name in QUANTITIES and name not in SLOPED)

    def swim(self, x: Array, *, slopes: bool = False) -> dict[str, Array]:
        """Swim the gaits at points in one batch.

        Parameters
        ----------
        x : ndarray, shape (points, dim)
            [Hz or rad].
        slopes : bool
            Whether to differentiate, too.

        Returns
        -------
        dict of ndarray
            The quantities that goals and limits need, shape (points,), and ``status``; with slopes, their derivatives
            as ``d_NAME``, shape (points, dim).

        Raises
        ------
        InputError
            If one of them has no derivatives.
        """
        if slopes and self.rough:
            fix = "choose a method without gradients"
            raise InputError("has no derivatives", key=" and ".join(self.rough), fix=fix)
        gaits = self.space.gaits(x)
        settled = settle(
            self.robot,
            gaits.frequency,
            gaits.amplitude,
            gaits.phase,
            gaits.bias,
            steps=self.steps,
            threads=self.threads,
        )
        of_gait, d_gait = gait_quantities(self.robot, gaits)
        found = {name: (of_gait | settled)[name] for name in (*self.needs, "status")}
        if not slopes:
            return found
        directions = self.space.directions(self.robot)
        derivatives = _slopes(self.robot, gaits, settled, directions, self.steps)
        derivatives |= {name: slope[:, self.space.free] for name, slope in d_gait.items()}
        return found | {f"d_{name}": derivatives[name] for name in self.needs}

    def judge(self, x: Array, found: Mapping[str, Any]) -> Evaluation:
        """Make goals and violations of quantities, simulated or measured.

        Parameters
        ----------
        x : ndarray, shape (points, dim)
            [Hz or rad].
        found : mapping of array_like
            As `swim` returns it.

        Returns
        -------
        Evaluation
        """
        known = {name: np.asarray(value, dtype=np.float64) for name, value in found.items()}
        with np.errstate(invalid="ignore"):
            violation = np.stack([_violation(limit, known[limit.quantity]) for limit in self.limits], axis=1)
            value = np.stack([_value(goal, known) for goal in self.goals], axis=1)
        usable = (known["status"] == 0) & np.isfinite(value).all(axis=1) & np.isfinite(violation).all(axis=1)
        violation[~usable] = UNUSABLE
        value[~usable | (violation[:, 0] > 0)] = np.inf
        slopes: dict[str, Any] = {}
        if "d_speed" in known:
            goals = np.stack([_value_slope(goal, known) for goal in self.goals], axis=1)
            sides = [(1 if limit.upper else -1) / limit.limit * known[f"d_{limit.quantity}"] for limit in self.limits]
            slopes = {"value_slopes": goals, "violation_slopes": np.stack(sides, axis=1)}
            slopes["speed_slopes"] = known["d_speed"]
        names = (*self.needs, "status")
        return Evaluation(np.asarray(x), value, violation, {name: known[name] for name in names}, **slopes)


def _part(column: Any, index: Any) -> Any:
    """Rows of a column of an evaluation."""
    if isinstance(column, dict):
        return {name: values[index] for name, values in column.items()}
    return None if column is None else column[index]


def _joined(first: Any, second: Any) -> Any:
    """Rows of two columns."""
    if isinstance(first, dict):
        return {name: np.concatenate([values, second[name]]) for name, values in first.items()}
    return None if first is None or second is None else np.concatenate([first, second])


def _violation(limit: Limit, value: Array) -> Array:
    """How far a value passes a limit, relative to the limit."""
    over = value / limit.limit - 1
    return np.asarray(over if limit.upper else -over)


def _value(goal: Goal, known: Mapping[str, Array]) -> Array:
    """Value of a goal."""
    value = np.sum([factor * known[name] for name, factor in goal.terms], axis=0)
    return np.asarray(value if goal.expected is None else value + np.abs(known["speed"] - goal.expected))


def _value_slope(goal: Goal, known: Mapping[str, Array]) -> Array:
    """Differentiate the value of a goal."""
    slope = np.sum([factor * known[f"d_{name}"] for name, factor in goal.terms], axis=0)
    if goal.expected is not None:
        slope = slope + np.sign(known["speed"] - goal.expected)[:, np.newaxis] * known["d_speed"]
    return np.asarray(slope)


def _slopes(robot: Robot, gaits: Gaits, found: Mapping[str, Any], directions: Array, steps: int) -> dict[str, Array]:
    """Differentiate the quantities of gaits along directions; not numbers for gaits that do not settle."""
    columns = (gaits.frequency, gaits.amplitude, gaits.phase, gaits.bias)
    rows = slopes(robot, *columns, found, directions, steps=steps)
    # d(U / (f L)) = (dU - U df / f) / (f L); the frequency is the first parameter.
    d_frequency = found["speed"][:, np.newaxis] * directions[0] / gaits.frequency[:, np.newaxis]
    stride = (rows["speed"] - d_frequency) / (robot.body.length * gaits.frequency[:, np.newaxis])
    return rows | {"stride_length": stride, "speed_bl": rows["speed"] / robot.body.length}
