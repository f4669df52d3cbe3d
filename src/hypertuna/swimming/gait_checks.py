"""Checks of the values of gaits and of the axes of grids: numbers, lengths, ranges."""

import contextlib
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.ranges import FINITE, NOT_NEGATIVE, POSITIVE

NEEDED = ("amplitude", "phase")  # kinds of angles that every gait must give
KINDS = (*NEEDED, "bias")  # kinds of angles of a gait
AXES = ("frequency", *KINDS)  # axes of a grid


def largest(kind: str, group: int) -> float:
    """Return the largest plausible magnitude of an angle [rad]; a larger one must be in another unit.

    It is half a turn for a joint. For a phase it is one turn, and one more for each joint group after the second.
    """
    return (math.pi if kind != "phase" else 2 * math.pi * max(1, group)) * (1 + 1e-12)


def grid_axes(given: Mapping[str, Any], unit: float) -> dict[str, Array]:
    """Check each value of a grid's axes; return arrays [Hz, rad]. unit: size of the given angles' unit [rad]."""
    if (valid_axes := _sound_axes(given, unit)) is not None:
        return valid_axes
    axes = {name: _axis(name, axis, unit) for name, axis in given.items()}
    first = {kind: axes[kind][0] for kind in NEEDED} | {"bias": ()}
    axes["bias"] = axes["bias"] or [checked_values(axes["frequency"][0], first, unit)["bias"]]
    values: dict[str, dict[int, Any]] = {name: {} for name in axes}
    for k in range(max(map(len, axes.values()))):
        point = {name: axis[min(k, len(axis) - 1)] for name, axis in axes.items()}
        for name, value in checked_values(point.pop("frequency"), point, unit).items():
            values[name][min(k, len(axes[name]) - 1)] = value
    return {name: np.array(list(numbers.values()), dtype=np.float64) for name, numbers in values.items()}


def _sound_axes(given: Mapping[str, Any], unit: float) -> dict[str, Array] | None:
    """Return the axes of a grid like `grid_axes`, with one fast check of all values; None if any value is invalid."""
    axes: dict[str, Array] = {}
    for name, axis in given.items():
        if isinstance(axis, list | tuple) and all(isinstance(value, list | tuple | float | int) for value in axis):
            flat = (x for value in axis for x in ([value] if isinstance(value, float | int) else value))
            if axis and all(type(x) in (float, int) for x in flat):
                with contextlib.suppress(ValueError, OverflowError):  # lists of different lengths, huge numbers
                    axes[name] = np.array(axis, dtype=np.float64)
        elif isinstance(axis, np.ndarray) and axis.dtype == np.float64 and axis.size:
            axes[name] = axis
    if given["bias"] is None and "amplitude" in axes:
        axes["bias"] = np.zeros((1, axes["amplitude"].shape[-1]))
    if axes.keys() != {*AXES} or not all(np.isfinite(axis).all() for axis in axes.values()):
        return None
    groups = axes["amplitude"].shape[-1]
    if any(axes[kind].ndim != 2 or axes[kind].shape[1] != groups for kind in KINDS) or axes["frequency"].ndim != 1:
        return None
    limits = {kind: [largest(kind, g) / unit for g in range(groups)] for kind in KINDS}
    within = all((np.abs(axes[kind]) <= limits[kind]).all() for kind in KINDS)
    if not within or (axes["frequency"] <= 0).any() or (axes["amplitude"] < 0).any():
        return None
    return {name: axes[name] * (1.0 if name == "frequency" else unit) for name in AXES}


def checked_values(frequency: float, angles: Mapping[str, Sequence[float]], unit: float) -> dict[str, Any]:
    """Check a gait's values; return frequency [Hz] and angles [rad]. unit: size of the given angles' unit [rad]."""
    beat = POSITIVE.check(frequency, "frequency", "give it in Hz")
    lists = {kind: _list(values, kind) for kind, values in angles.items()}
    groups = len(lists["amplitude"])
    lists["bias"] = lists["bias"] or (0.0,) * groups
    for key, values in lists.items():
        if len(values) != groups:
            rule = f"must be {groups} long, as amplitude is"
            raise InputError(rule, key=key, value=f"{len(values)} long", fix="give one value per joint group")
    for key, values in lists.items():
        for g, value in enumerate(values):
            if key == "amplitude":
                NOT_NEGATIVE.check(value, f"{key}[{g}]", "add half a turn to its phase instead")
            if abs(value) * unit > largest(key, g):
                rule = f"must be at most {largest(key, g) / unit:g} {'rad' if unit == 1 else 'deg'}"
                fix = "check its unit" if unit != 1 else "for degrees take Gait.from_degrees or Gaits.grid_degrees"
                raise InputError(rule, key=f"{key}[{g}]", value=f"{value:g}", fix=fix)
    return {"frequency": beat} | {key: tuple(value * unit for value in values) for key, values in lists.items()}


def _axis(name: str, axis: Any, unit: float) -> list[Any]:
    """Check type and length of a grid's axis; return its values, frequencies or lists of angles."""
    if axis is None and name == "bias":
        return []
    pair = "[(0.2, 0.3)]" if unit == 1 else "[(10, 20)]"
    fix = f"write {name}={pair}: one angle per joint group in each" if name != "frequency" else "write frequency=[2.0]"
    if not _listed(axis):
        raise InputError("must be a list", key=name, value=shown(axis), fix=fix)
    values = list(axis)
    if not values and name != "bias":
        raise InputError("must have at least one value", key=name, value="empty", fix="give a range or a list")
    for k, value in enumerate(values if name != "frequency" else ()):
        if not _listed(value):
            raise InputError("must be a list of angles", key=f"{name}[{k}]", value=shown(value), fix=fix)
        if len(value) != len(values[0]):
            rule = f"must be {len(values[0])} long, as {name}[0] is"
            fix = "give one angle per joint group"
            raise InputError(rule, key=f"{name}[{k}]", value=f"{len(value)} long", fix=fix)
    return values


def _listed(value: Any) -> bool:
    """Return whether a value is iterable, but not a string."""
    return hasattr(value, "__iter__") and not isinstance(value, str | bytes)


def _list(values: Sequence[float], key: str) -> tuple[float, ...]:
    """Check that the angles of joint groups are finite numbers; return them as a tuple."""
    fix = "give one angle per joint group"
    if not _listed(values):
        raise InputError("must be a list of numbers", key=key, value=shown(values), fix=fix)
    items = list(values)
    if not items and key == "amplitude":
        raise InputError("must have at least one angle", key=key, value="empty", fix=fix)
    return tuple(FINITE.check(value, f"{key}[{g}]", fix) for g, value in enumerate(items))
