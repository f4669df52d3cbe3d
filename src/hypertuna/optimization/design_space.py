"""The space of gaits that optimizers search: which values of a gait are free, and between what bounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.swimming.gait import LARGEST, Gait
from hypertuna.swimming.model import parameter_names
from hypertuna.swimming.sweep import Gaits

__all__ = ["Space", "gait_bounds", "gait_columns"]

Array = NDArray[np.float64]

KINDS = ("amplitude", "phase", "bias")


def gait_columns(robot: Robot) -> dict[str, float]:
    """Name every value of a gait as files do, with its unit.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    dict of float
        Size of the unit [Hz or rad], by names such as ``frequency_hz`` and ``amplitude_I_deg``: frequency, then
        amplitude, phase and bias of every joint group.
    """
    angles = [f"{kind}_{group.name}_deg" for kind in KINDS for group in robot.joints]
    return {"frequency_hz": 1.0} | dict.fromkeys(angles, np.pi / 180)


@dataclass(frozen=True)
class Space:
    """A box of gaits; what is free of them are the coordinates x.

    Attributes
    ----------
    columns : tuple of str
        Every value of a gait, as `gait_columns` names them.
    unit : ndarray, shape (columns,)
        Sizes of their units [Hz or rad].
    low, high : ndarray, shape (columns,)
        Bounds [Hz or rad]; a value whose two bounds are equal is fixed.
    """

    columns: tuple[str, ...]
    unit: Array
    low: Array
    high: Array

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
        """Make the gaits at points.

        Parameters
        ----------
        x : array_like, shape (gaits, dim)
            Points [Hz or rad].

        Returns
        -------
        Gaits
        """
        points = np.asarray(x, dtype=np.float64)
        values = np.tile(self.low, (len(points), 1))
        values[:, self.free] = points
        amplitude, phase, bias = (np.ascontiguousarray(part) for part in np.split(values[:, 1:], len(KINDS), axis=1))
        return Gaits(np.ascontiguousarray(values[:, 0]), amplitude, phase, bias, (len(points),))

    def gait(self, x: ArrayLike) -> Gait:
        """Make the gait at one point.

        Parameters
        ----------
        x : array_like, shape (dim,)
            Point [Hz or rad].

        Returns
        -------
        Gait
        """
        gaits = self.gaits(np.asarray(x, dtype=np.float64)[np.newaxis])
        rows = (tuple(getattr(gaits, kind)[0].tolist()) for kind in KINDS)
        return Gait(float(gaits.frequency[0]), *rows)

    def point(self, gait: Gait) -> Array:
        """Return the point of a gait; what is not free of it is left out.

        Parameters
        ----------
        gait : Gait

        Returns
        -------
        ndarray, shape (dim,)
            [Hz or rad].
        """
        return np.array([gait.frequency, *gait.amplitude, *gait.phase, *gait.bias])[self.free]

    def directions(self, robot: Robot) -> Array:
        """Return how every parameter of the model moves with the coordinates.

        Parameters
        ----------
        robot : Robot

        Returns
        -------
        ndarray, shape (parameters, dim)
            In the order of `hypertuna.swimming.model.parameter_names` [1].
        """
        names = parameter_names(robot)
        groups = range(len(robot.joints))
        full = ["gait.frequency", *(f"gait.{kind}[{g}]" for kind in KINDS for g in groups)]
        directions = np.zeros((len(names), len(self.free)))
        for k, column in enumerate(self.free):
            directions[names.index(full[column]), k] = 1.0
        return directions


def gait_bounds(robot: Robot, overrides: Mapping[str, tuple[float, float]] | None = None) -> Space:
    """Return the space of a robot's gaits: its table ``[gait_bounds]``, and what the caller says otherwise.

    Parameters
    ----------
    robot : Robot
    overrides : mapping, optional
        Lowest and highest value in Hz or degrees by the names of `gait_columns`: ``{"frequency_hz": (1, 4)}``. The
        unit may be left out of the name, and so may the joint group: ``amplitude`` is that of every group.

    Returns
    -------
    Space

    Raises
    ------
    InputError
        If a name is not known, bounds are not two finite numbers in order, a value has no bounds, or nothing is free.
    """
    units = gait_columns(robot)
    bounds = _of_table(robot)
    for name, pair in (overrides or {}).items():
        for column in _columns_of(name, robot):
            bounds[column] = _checked(name, column, pair, units[column])
    missing = [column for column in units if column not in bounds]
    if missing:
        fix = f"add the table [gait_bounds], or give --bounds {missing[0]}=LOW:HIGH"
        raise InputError("has no bounds", file=robot.file or None, key=missing[0], fix=fix)
    unit = np.array(list(units.values()))
    low, high = np.array([bounds[column] for column in units]).T
    space = Space(tuple(units), unit, low, high)
    if not len(space.free):
        raise InputError("must leave something free", key="bounds", fix="give some value a range")
    return space


def _of_table(robot: Robot) -> dict[str, tuple[float, float]]:
    """Bounds of the robot's own table [Hz or rad], by column; gaits without a table have no bias."""
    table = robot.gait_bounds
    groups = [group.name for group in robot.joints]
    if table is None:
        return {f"bias_{group}_deg": (0.0, 0.0) for group in groups}
    angles = {
        f"{kind}_{group}_deg": pair for kind in KINDS for group, pair in zip(groups, getattr(table, kind), strict=True)
    }
    return {"frequency_hz": table.frequency} | angles


def _columns_of(name: str, robot: Robot) -> list[str]:
    """Columns that a name stands for."""
    columns = list(gait_columns(robot))
    short: dict[str, list[str]] = {}
    for column in columns:
        plain = column.rpartition("_")[0]
        kind = plain.partition("_")[0]
        for known in (column, plain, kind, f"{kind}_{column.rpartition('_')[2]}"):
            if column not in short.setdefault(known, []):
                short[known].append(column)
    if name not in short:
        fix = did_you_mean(name, short)
        raise InputError("must name a value of a gait", key="bounds", value=shown(name), fix=fix)
    return short[name]


def _checked(name: str, column: str, pair: tuple[float, float], unit: float) -> tuple[float, float]:
    """Check bounds in the unit of their column; return them in Hz or rad."""
    low, high = pair
    kind = column.partition("_")[0]
    key, value = f"bounds of {name}", f"{low:g}:{high:g}"
    if not (np.isfinite(low) and np.isfinite(high)):
        raise InputError("must be finite", key=key, value=value, fix="give LOW:HIGH")
    if low > high:
        raise InputError("must be the lowest value, then the highest", key=key, value=value, fix="exchange the two")
    if kind == "frequency" and low <= 0:
        raise InputError("must be greater than 0", key=key, value=value, fix="give a lowest beat frequency in Hz")
    if kind == "amplitude" and low < 0:
        raise InputError("must not be negative", key=key, value=value, fix="begin at 0")
    if kind in LARGEST and max(abs(low), abs(high)) * unit > LARGEST[kind]:
        raise InputError(f"must stay within {LARGEST[kind] / unit:g} deg", key=key, value=value, fix="check its unit")
    return low * unit, high * unit
