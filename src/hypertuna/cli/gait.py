"""A gait on the command line: its options, its text, its JSON."""

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.streams import note
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.quantity import listed
from hypertuna.swimming.gait import KINDS, Gait, Gaits, grid_axes, named_gait

LIKELY_RADIANS = 1.6  # deg: amplitudes that are all smaller were probably typed in radians
SLACK = 1e-9  # Hz or deg: rounding of bounds that were converted from radians
MIN_BEATS = 2  # shortest run: its means are over whole beats
Points = Sequence[tuple[float, ...]]  # values of an option [Hz, deg]


@dataclass(frozen=True)
class GaitOptions:
    """Every combination of frequencies, amplitudes, phases and biases; absent values are those of the named gait."""

    gait: opt.GaitName = None
    frequency: opt.Frequency = None
    amplitude: opt.Amplitude = None
    phase: opt.Phase = None
    bias: opt.Bias = None

    @property
    def given(self) -> dict[str, Points]:
        """Values [Hz, deg] of each option that is given, by its key."""
        angles = {key: [point for level in getattr(self, key) or () for point in level] for key in KINDS}
        return {key: points for key, points in {"frequency": self.frequency, **angles}.items() if points}

    def make(self, robot: Robot) -> Gait:
        """Return the gait of the options; refuse options that give several."""
        for key, points in self.given.items():
            if len(points) != 1:
                value = " and ".join(",".join(f"{x:g}" for x in point) for point in points[:2])
                value += f" and {len(points) - 2} more" * (len(points) > 2)
                point = ", with a decimal point" if key == "frequency" else ""
                fix = f"give one{point}; `hypertuna sweep` swims several"
                rule = "must be a single value" if key == "frequency" else "must be a single set of angles"
                raise InputError(rule, key=f"--{key}", value=value, fix=fix)
        gait = _gait({key: points[0] for key, points in _axes(robot, self.gait, self.given).items()})
        _note_bounds(robot, self.given)
        return gait

    def grid(self, robot: Robot) -> Gaits:
        """Return the grid of all combinations of the options' values."""
        axes = _axes(robot, self.gait, self.given)
        typed = {"frequency": [value for (value,) in axes["frequency"]]} | {key: axes[key] for key in KINDS}
        with _as_options():
            grid_axes(typed, math.pi / 180)  # checks them in degrees, as typed
        _note_bounds(robot, self.given)
        return Gaits.grid(**typed | {key: np.radians(axes[key]).tolist() for key in KINDS})


def _gait(values: Mapping[str, tuple[float, ...]]) -> Gait:
    """Return the gait with the values [Hz, deg] given by key."""
    with _as_options():
        return Gait.from_degrees(frequency=values["frequency"][0], **{key: values[key] for key in KINDS})


@contextlib.contextmanager
def _as_options() -> Iterator[None]:
    """Turn errors of gaits raised inside into errors that name the options."""
    try:
        yield
    except InputError as error:
        raise InputError(error.rule, key=f"--{error.key}", value=error.value, fix=error.fix) from None


def _axes(robot: Robot, name: str | None, given: Mapping[str, Points]) -> dict[str, Points]:
    """Return the values [Hz, deg] of each option, else of the named gait; a set has an angle per joint group."""
    groups = len(robot.joints)
    axes: dict[str, Points] = {"bias": [(0.0,) * groups]}
    if name is None and len(robot.gaits) == 1 and not given.keys() >= {"frequency", "amplitude", "phase"}:
        (name,) = robot.gaits  # the robot has no other gait
    if name is not None:
        named = named_gait(robot, name)
        axes["frequency"] = [(named.frequency,)]
        axes |= {key: [tuple(np.degrees(getattr(named, key)).tolist())] for key in KINDS}
    for key, points in given.items():
        _check_count(robot, key, points, 1 if key == "frequency" else groups)
    if 0 < max((abs(angle) for point in given.get("amplitude", ()) for angle in point), default=0) < LIKELY_RADIANS:
        note("amplitudes are in degrees, and these are small; multiply radians by 57.3.")
    if missing := [f"--{key}" for key in ("frequency", *KINDS) if key not in given and key not in axes]:
        choice = f", or --gait with one of {', '.join(robot.gaits)}" if robot.gaits else ""
        rule, pronoun = ("is missing", "it") if len(missing) == 1 else ("are missing", "them")
        raise InputError(rule, key=listed(missing), fix=f"give {pronoun}{choice}")
    return axes | dict(given)


def _note_bounds(robot: Robot, given: Mapping[str, Points]) -> None:
    """Print a note on the given frequencies and amplitudes that lie beyond the gait bounds of the robot's file."""
    if (bounds := robot.gait_bounds) is None:
        return
    for key, unit in {"frequency": "Hz", "amplitude": "deg"}.items():
        pairs = [bounds.frequency] if key == "frequency" else np.degrees(bounds.amplitude).tolist()
        names = [""] if key == "frequency" else [f" of joint group {group.name}" for group in robot.joints]
        typed = [triple for point in given.get(key, ()) for triple in zip(point, pairs, names, strict=True)]
        if outside := [(x, *pair, suffix) for x, pair, suffix in typed if not pair[0] - SLACK <= x <= pair[1] + SLACK]:
            value, low, high, suffix = outside[-1]
            bound = f"gait_bounds.{key}_{unit.lower()} of {robot.name}"
            note(f"--{key} {value:g} {unit}{suffix} is outside {bound}, {low:g} to {high:g} {unit}.")


def _check_count(robot: Robot, key: str, points: Points, count: int) -> None:
    """Check that there is one frequency, and one angle per joint group."""
    for point in points:
        if len(point) != count:
            groups = ", ".join(group.name for group in robot.joints)
            rule = "must be one value" if key == "frequency" else f"must be {count} values, for joint groups {groups}"
            has = f"but has {len(point)} ({', '.join(f'{x:g}' for x in point)})"
            fix = "give one number" if count == 1 else f"give {count}, separated by commas"
            fix += ", such as " + "0," * (count - 1) + "0:90:10" if min(count, len(points)) > 1 else ""
            raise InputError(f"{rule}, {has}", key=f"--{key}", fix=fix)


def check_duration(gait: Gait, duration: float) -> None:
    """Check that a run is long enough for means over two whole beats."""
    shortest = MIN_BEATS / gait.frequency
    if duration < shortest:
        rule = f"must be at least two beats, {shortest:.4g} s at {gait.frequency:g} Hz"
        fix = f"give at least {math.ceil(100 * shortest) / 100:g}; 20 beats or more let the robot settle"
        raise InputError(rule, key="--duration", value=f"{duration:g} s", fix=fix)


def column_rows(columns: Mapping[str, Iterable[Any]]) -> list[dict[str, Any]]:
    """Return the rows of columns, each a dictionary by the columns' names."""
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
