"""A gait on the command line: its options, its text, its JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.gait import Gait, Gaits, named_gait

KINDS = ("amplitude", "phase", "bias")
MIN_BEATS = 2  # of a run: for means over whole beats
Axes = dict[str, list[tuple[float, ...]]]  # values of each option [Hz, deg]


def one_gait(
    robot: Robot,
    name: str | None,
    frequency: float | None,
    amplitude: Sequence[float] | None,
    phase: Sequence[float] | None,
    bias: Sequence[float] | None,
) -> Gait:
    """Make the gait of the options [Hz, deg]; what is not given is that of the named gait."""
    angles = {"amplitude": amplitude, "phase": phase, "bias": bias}
    given = {"frequency": None if frequency is None else [(frequency,)]}
    axes = _axes(robot, name, given | {key: None if value is None else [tuple(value)] for key, value in angles.items()})
    return _gait({key: points[0] for key, points in axes.items()})


def gait_grid(robot: Robot, name: str | None, given: Mapping[str, Sequence[tuple[float, ...]] | None]) -> Gaits:
    """Make every combination of the options [Hz, deg]; what is not given is that of the named gait."""
    axes = _axes(robot, name, given)
    first = {key: points[0] for key, points in axes.items()}
    for key, points in axes.items():
        for point in points:
            _gait(first | {key: point})  # checks it in degrees, as typed
    angles = {key: np.radians(axes[key]).tolist() for key in KINDS}
    return Gaits.grid(frequency=[value for (value,) in axes["frequency"]], **angles)


def _gait(values: Mapping[str, tuple[float, ...]]) -> Gait:
    """Make a gait of its values [Hz, deg]."""
    amplitude, phase, bias = (values[key] for key in KINDS)
    return Gait.from_degrees(frequency=values["frequency"][0], amplitude=amplitude, phase=phase, bias=bias)


def _axes(robot: Robot, name: str | None, given: Mapping[str, Sequence[tuple[float, ...]] | None]) -> Axes:
    """Return the values of each option, checked for their number per joint group."""
    groups = len(robot.joints)
    axes: Axes = {"bias": [(0.0,) * groups]}
    if name is not None:
        known = named_gait(robot, name)
        axes["frequency"] = [(known.frequency,)]
        axes |= {key: [tuple(np.degrees(getattr(known, key)).tolist())] for key in KINDS}
    for key, points in given.items():
        if points:
            axes[key] = list(points)
            _check_count(robot, key, axes[key], 1 if key == "frequency" else groups)
        elif key not in axes:
            raise InputError("is missing", key=f"--{key}", fix="give it, or a gait of the robot's file with --gait")
    return axes


def _check_count(robot: Robot, key: str, points: Sequence[tuple[float, ...]], count: int) -> None:
    """Check that there is one frequency, and one angle per joint group."""
    for point in points:
        if len(point) != count:
            groups = ", ".join(group.name for group in robot.joints)
            rule = "must be one value" if key == "frequency" else f"must be {count} values, for joint groups {groups}"
            given = f"but has {len(point)} ({', '.join(f'{x:g}' for x in point)})"
            fix = "give one number" if count == 1 else f"give {count}, separated by commas"
            raise InputError(f"{rule}, {given}", key=f"--{key}", fix=fix)


def check_duration(gait: Gait, duration: float) -> None:
    """Check that a run has whole beats to take means over."""
    shortest = MIN_BEATS / gait.frequency
    if duration < shortest:
        rule = f"must be at least two beats, {shortest:.4g} s at {gait.frequency:g} Hz"
        fix = f"give at least {math.ceil(100 * shortest) / 100:g}; 20 beats or more let the robot settle"
        raise InputError(rule, key="duration", value=f"{duration:g} s", fix=fix)


def gait_text(gait: Gait) -> str:
    """Write a gait in the words of the options."""
    kinds = KINDS if any(gait.bias) else KINDS[:2]
    angles = (f"{key} {', '.join(f'{a:.4g}' for a in np.degrees(getattr(gait, key)))} deg" for key in kinds)
    return f"{gait.frequency:g} Hz, {', '.join(angles)}"


def gait_degrees(gait: Gait, kinds: Sequence[str] = KINDS) -> dict[str, Any]:
    """Return frequency [Hz] and angles [deg] of a gait, as JSON has them."""
    angles = {f"{key}_deg": np.degrees(getattr(gait, key)).round(10).tolist() for key in kinds}
    return {"frequency_hz": gait.frequency} | angles


def gait_record(gait: Gait) -> dict[str, Any]:
    """Return a gait as robot files have it: a bias only if there is one."""
    return gait_degrees(gait, KINDS if any(gait.bias) else KINDS[:2])
