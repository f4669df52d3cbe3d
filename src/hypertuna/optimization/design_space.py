"""The design space: the free values of a gait and of a robot, and their bounds."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna.arrays import Array
from hypertuna.description.design import Variable, designed
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.swimming.designs import design_of, model_features
from hypertuna.swimming.gait import KINDS, Gait, Gaits
from hypertuna.swimming.gait_checks import largest

WIDE = 100.0  # ratio of a variable's ends from which on a search takes its logarithm


def gait_columns(robot: Robot) -> dict[str, float]:
    """Return the size of the unit [Hz or rad] of every value of a gait, by the value's name in files.

    Frequency comes first, then amplitude, phase and bias of every group: ``frequency_hz``, ``amplitude_I_deg``, ...
    """
    angles = [f"{kind}_{group.name}_deg" for kind in KINDS for group in robot.joints]
    return {"frequency_hz": 1.0} | dict.fromkeys(angles, np.pi / 180)


@dataclass(frozen=True)
class DesignSpace:
    """Bounds of a gait's values and of the robot's variables; the free ones are coordinates x [Hz, rad, file unit].

    The coordinate of a variable v with a wide range is log(v + shift) instead, so that a search knows all of the range.
    """

    columns: tuple[str, ...]  # names of a gait's values, as in `gait_columns`, then names of the variables
    unit: Array  # (columns,) size of the unit [Hz or rad]; 1 for a variable
    low: Array  # (columns,) lower bound [Hz or rad], of the coordinate
    high: Array  # (columns,) upper bound; equal to `low` if the value is fixed [Hz or rad]
    variables: tuple[Variable, ...] = ()  # numbers of the robot's file, the last columns

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Indices of the free columns, shape (dim,)."""
        return np.flatnonzero(self.low < self.high)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates, with units."""
        return tuple(self.columns[k] for k in self.free)

    @property
    def lower(self) -> Array:
        """Lower bounds of the coordinates, shape (dim,) [Hz or rad]."""
        return self.low[self.free]

    @property
    def upper(self) -> Array:
        """Upper bounds of the coordinates, shape (dim,) [Hz or rad]."""
        return self.high[self.free]

    def gaits(self, x: ArrayLike) -> Gaits:
        """Return the gaits at points, shape (gaits, dim) [Hz or rad]."""
        points = np.asarray(x, dtype=np.float64)
        values = np.tile(self.low, (len(points), 1))
        values[:, self.free] = points
        values = values[:, : len(self.columns) - len(self.variables)]
        return Gaits(values[:, 0], *np.split(values[:, 1:], len(KINDS), axis=1), shape=(len(points),))

    def gait(self, x: ArrayLike) -> Gait:
        """Return the gait at one point, shape (dim,) [Hz or rad]."""
        return self.gaits(np.asarray(x, dtype=np.float64)[np.newaxis])[0]

    def point(self, gait: Gait) -> Array:
        """Return the coordinates of a gait and the described robot, shape (dim,) [Hz, rad, file unit]."""
        return np.append(gait.values, [_coordinate(one, one.value) for one in self.variables])[self.free]

    def design(self, x: ArrayLike) -> Array:
        """Return the values of the robot's variables at a point x (dim,) [unit of the file]."""
        found = np.asarray(x, dtype=np.float64)
        pairs = zip(self.variables, found[len(found) - len(self.variables) :], strict=True)
        return np.array([_value(variable, coordinate) for variable, coordinate in pairs])

    def slopes(self, x: ArrayLike) -> Array:
        """Return the derivatives of the variables' values with respect to their coordinates at a point x (dim,)."""
        pairs = zip(self.variables, self.design(x), strict=True)
        return np.array([1.0 if (shift := _shift(one)) is None else value + shift for one, value in pairs])

    @property
    def logarithms(self) -> NDArray[np.bool_]:
        """Whether each coordinate (dim,) is a logarithm."""
        gait = len(self.free) - len(self.variables)
        return np.array([False] * gait + [_shift(variable) is not None for variable in self.variables])

    def shown(self, x: ArrayLike) -> Array:
        """Return the coordinates x (dim,) in the units of their names, variables by value instead of logarithm."""
        gait = np.asarray(x)[: len(self.free) - len(self.variables)]
        return np.append(gait / self.unit[self.free[: len(gait)]], self.design(x))

    def robot(self, robot: Robot, x: ArrayLike, *, made_by: str = "") -> Robot:
        """Return the robot with the values of its variables at one point; made_by: their source, see `designed`."""
        return designed(robot, self.variables, self.design(x).tolist(), made_by=made_by) if self.variables else robot

    def directions(self, robot: Robot) -> Array:
        """Return derivatives (parameters, dim) of the model's parameters with respect to the gait's coordinates [1]."""
        free_gait = self.free[: len(self.free) - len(self.variables)]
        return np.eye(len(model_features(robot)))[:, free_gait]  # gait parameters come first, ordered as the columns


def gait_bounds(
    robot: Robot,
    overrides: Mapping[str, tuple[float, float]] | None = None,
    design: Mapping[str, tuple[float, float]] | None = None,
) -> DesignSpace:
    """Return a robot's design space: the bounds of its table ``[gait_bounds]``, replaced by `overrides` where given.

    Bounds are in Hz or degrees, by the names of `gait_columns`. The unit may be left out of a name, and so may the
    joint group: ``amplitude`` stands for every group. `design` has the bounds of numbers of the robot's file by key.
    """
    units, table = gait_columns(robot), robot.gait_bounds
    bounds = {f"bias_{group.name}_deg": (0.0, 0.0) for group in robot.joints}
    if table is not None:
        bounds = dict(zip(units, [table.frequency, *table.amplitude, *table.phase, *table.bias], strict=True))
    for name, pair in (overrides or {}).items():
        for column in _columns_of(name, robot):
            group = (list(units).index(column) - 1) % len(robot.joints)
            bounds[column] = _si_bounds(name, column, pair, units[column], group)
    missing = [column for column in units if column not in bounds]
    if missing:
        fix = f"add the table [gait_bounds], or give bounds of {missing[0]}"
        raise InputError("has no bounds", file=robot.file or None, key=missing[0], fix=fix)
    low, high = np.array([bounds[column] for column in units]).T
    variables = design_of(robot, design or {})
    low = np.append(low, [_coordinate(one, one.low) for one in variables])
    high = np.append(high, [_coordinate(one, one.high) for one in variables])
    columns, sizes = (*units, *(v.name for v in variables)), [*units.values(), *(1.0 for _ in variables)]
    space = DesignSpace(columns, np.array(sizes), low, high, variables)
    if not len(space.free):
        fix = "give one parameter two different bounds"
        raise InputError("must leave at least one gait parameter free", key="bounds", fix=fix)
    return space


def _shift(variable: Variable) -> float | None:
    """Return what is added to a variable before its logarithm: 0, or its own value if it may be 0; None without one."""
    shift = 0.0 if variable.low > 0 else variable.value
    wide = variable.low >= 0 < shift + variable.low and variable.high + shift >= WIDE * (variable.low + shift)
    return shift if wide else None


def _coordinate(variable: Variable, value: float) -> float:
    """Return the coordinate of a variable's value [unit of the file]."""
    return value if (shift := _shift(variable)) is None else math.log(value + shift)


def _value(variable: Variable, coordinate: float) -> float:
    """Return a variable's value [unit of the file] at a coordinate; at its ends, to the last bit."""
    if (shift := _shift(variable)) is None:
        return coordinate
    if coordinate <= _coordinate(variable, variable.low):
        return variable.low
    return min(max(math.exp(coordinate) - shift, variable.low), variable.high)


def _columns_of(name: str, robot: Robot) -> list[str]:
    """Return the columns that a full or short name stands for."""
    columns: dict[str, list[str]] = {}
    for column in gait_columns(robot):
        without_unit, _, unit = column.rpartition("_")
        kind = without_unit.partition("_")[0]
        for alias in dict.fromkeys((column, without_unit, kind, f"{kind}_{unit}")):
            columns.setdefault(alias, []).append(column)
    if name not in columns:
        fix = did_you_mean(name, columns)
        raise InputError("must name a value of a gait", key="bounds", value=shown(name), fix=fix)
    return columns[name]


def _si_bounds(name: str, column: str, pair: tuple[float, float], unit: float, group: int) -> tuple[float, float]:
    """Check bounds in the unit of their column; return them in Hz or rad."""
    low, high = pair
    kind = column.partition("_")[0]
    maximum = np.inf if kind == "frequency" else largest(kind, group)
    for valid, rule, fix in (
        (np.isfinite(low) and np.isfinite(high), "must be finite", "give LOW:HIGH"),
        (low <= high, "must have the lower value first", "exchange the two"),
        (kind != "frequency" or low > 0, "must be greater than 0", "give a lowest beat frequency in Hz"),
        (kind != "amplitude" or low >= 0, "must not be negative", "begin at 0"),
        (max(abs(low), abs(high)) * unit <= maximum, f"must stay within {maximum / unit:g} deg", "check the unit"),
    ):
        if not valid:
            raise InputError(rule, key=f"bounds of {name}", value=f"{low:g}:{high:g}", fix=fix)
    return low * unit, high * unit
