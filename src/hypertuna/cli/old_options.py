"""The options that several commands share: a robot, a gait, the medium, and how they are read."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated

import numpy as np
import typer

from hypertuna.actuation.hydraulics import ZERO_CELSIUS
from hypertuna.actuation.sizing import with_bore
from hypertuna.characterization.data import MAX_PRESSURE
from hypertuna.cli.old_console import number, number_list, ranges
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError, did_you_mean
from hypertuna.simulation.run import TwinRun
from hypertuna.swimming.gait import Gait, named_gait

__all__ = [
    "BACKWARD",
    "MEDIA",
    "Amplitude",
    "AsJson",
    "Bias",
    "Bore",
    "Frequency",
    "Joint",
    "Medium",
    "Name",
    "Named",
    "Phase",
    "Pressure",
    "Seed",
    "Side",
    "Temperature",
    "celsius",
    "check_beats",
    "choice",
    "gait_axes",
    "heads_first",
    "one_gait",
    "pressures",
    "robot_of",
    "spelled",
]

MEDIA = ("water", "air")
MILLI = 1e-3
MOST_PRESSURES = 10_000  # of one call: more say nothing new, and take minutes
BORES = (1.0, 20.0)  # mm: oil hardly passes thinner lines, and wider ones swing faster than the twin steps
GROUP = "one value per joint group, separated by commas"

BEATS = 2  # that a run must have for means over whole beats
STANDS = 0.01  # 1/s: below so many body lengths a robot stands, and a cost per distance says nothing
BACKWARD = "The robot does not swim head first, or hardly moves: there is no cost of transport and no range."

Name = Annotated[str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")]
Joint = Annotated[str, typer.Option("--joint", help="Name of the joint group, or its number from the head.")]
Pressure = Annotated[
    str, typer.Option("--pressure", help="Rising gauge pressures in kPa: numbers or start:stop:count.")
]
Side = Annotated[
    str,
    typer.Option("--side", help="Side that has the pressure, left or right; bends toward it are positive."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Named = Annotated[str | None, typer.Option("--gait", help="A gait of the robot's file; the options below change it.")]
Frequency = Annotated[str | None, typer.Option("--frequency", help="Beat frequency in Hz.")]
Amplitude = Annotated[str | None, typer.Option("--amplitude", help=f"Amplitude in degrees, {GROUP}.")]
Phase = Annotated[str | None, typer.Option("--phase", help=f"Lag behind the first group's clock, {GROUP}.")]
Bias = Annotated[str | None, typer.Option("--bias", help=f"Mean angle in degrees, {GROUP}.")]
Medium = Annotated[str, typer.Option("--medium", help="water or air.")]
Temperature = Annotated[
    str | None, typer.Option("--temperature", help="Temperature of the oil in C. (default: the robot's)")
]
Bore = Annotated[
    str | None, typer.Option("--line-bore", help="Inner diameter of all oil lines in mm. (default: the robot's)")
]
Seed = Annotated[str, typer.Option("--seed", help="Seed of the sensors' noise.")]


def _one(text: str, key: str, unit: str) -> list[tuple[float, ...]]:
    """Read one value per joint group, as `ranges` reads many."""
    return [number_list(text, key, unit)]


def gait_axes(
    robot: Robot,
    name: str | None,
    given: Mapping[str, str | list[str] | None],
    read: Callable[[str, str, str], list[tuple[float, ...]]] = _one,
) -> dict[str, list[tuple[float, ...]]]:
    """Read the values of frequency, amplitude, phase and bias; what is not given comes from a named gait.

    Returns [Hz, deg].
    """
    groups = len(robot.joints)
    axes = {"bias": [(0.0,) * groups]}
    if name is not None:
        known = named_gait(robot, name)
        axes["frequency"] = [(known.frequency,)]
        axes |= {key: [tuple(np.degrees(getattr(known, key)).tolist())] for key in ("amplitude", "phase", "bias")}
    for key, texts in given.items():
        if texts:
            unit = "Hz" if key == "frequency" else "degrees"
            several = [texts] if isinstance(texts, str) else texts
            axes[key] = [value for text in several for value in read(text, key, unit)]
            _check_count(robot, key, axes[key], 1 if key == "frequency" else groups)
        elif key not in axes:
            raise InputError("is missing", key=f"--{key}", fix="give it, or a gait of the robot's file with --gait")
    return axes


def one_gait(axes: dict[str, list[tuple[float, ...]]]) -> Gait:
    """Make the one gait that the options describe."""
    amplitude, phase, bias = (axes[key][0] for key in ("amplitude", "phase", "bias"))
    return Gait.from_degrees(frequency=axes["frequency"][0][0], amplitude=amplitude, phase=phase, bias=bias)


def spelled(gait: Gait) -> str:
    """Write a gait in the words of the options."""
    angles = {key: np.degrees(getattr(gait, key)) for key in ("amplitude", "phase", "bias")}
    parts = [f"{key} {', '.join(f'{a:.4g}' for a in values)} deg" for key, values in angles.items() if key != "bias"]
    if any(gait.bias):
        parts.append(f"bias {', '.join(f'{a:.4g}' for a in angles['bias'])} deg")
    return f"{gait.frequency:g} Hz, {', '.join(parts)}"


def robot_of(name: str, line_bore: str | None) -> Robot:
    """Load a robot, with other oil lines where they are asked for: `line_bore` [mm]."""
    fish = load(name)
    if line_bore is None:
        return fish
    bore = number(line_bore, "--line-bore", "mm")
    low, high = BORES
    if not low <= bore <= high:
        fix = "give the inner diameter of the oil lines in mm"
        raise InputError(f"must be from {low:g} to {high:g} mm", key="--line-bore", value=line_bore, fix=fix)
    return with_bore(fish, MILLI * bore)


def celsius(text: str | None) -> float | None:
    """Read a temperature: `text` [degC]; returns [K]."""
    return None if text is None else number(text, "--temperature", "C") + ZERO_CELSIUS


def choice(value: str, known: tuple[str, ...], key: str) -> str:
    """Check a word of several."""
    if value not in known:
        raise InputError(f"must be {' or '.join(known)}", key=key, value=repr(value), fix=did_you_mean(value, known))
    return value


def pressures(text: str, most: int = MOST_PRESSURES) -> list[float]:
    """Read pressures: every part of the list in turn; `text` [kPa]; returns [kPa]."""
    parts, found = text.split(","), []
    for k, part in enumerate(parts):
        key = f"--pressure[{k}]" if len(parts) > 1 else "--pressure"
        values = [value for (value,) in ranges(part, key, "kPa")]
        if (largest := max(values)) > MAX_PRESSURE / 1e3:
            rule = f"must be at most {MAX_PRESSURE / 1e3:g}"
            raise InputError(rule, key=key, value=f"{largest:g}", fix="give it in kPa")
        found += values
        if len(found) > most:
            rule, fix = f"must be at most {most} pressures", f"ask for fewer; {min(most // 2, 100)} draw a smooth curve"
            raise InputError(rule, key="--pressure", value=f"{len(found)}", fix=fix)
    return found


def check_beats(gait: Gait, duration: float) -> None:
    """Check that a run has whole beats to take means over: `duration` [s]."""
    least = BEATS / gait.frequency
    if duration < least:
        rule = f"must be at least two beats, {least:.4g} s at {gait.frequency:g} Hz"
        fix = f"give at least {math.ceil(100 * least) / 100:g}; 20 beats or more let the robot settle"
        raise InputError(rule, key="duration", value=f"{duration:g} s", fix=fix)


def heads_first(run: TwinRun) -> bool:
    """Tell whether a robot swam head first, faster than a hundredth of its length per second."""
    return math.isnan(run.speed) or run.speed_bl > STANDS


def _check_count(robot: Robot, key: str, values: list[tuple[float, ...]], count: int) -> None:
    """Check that there is one frequency, and one angle per joint group."""
    for value in values:
        if len(value) != count:
            groups = ", ".join(group.name for group in robot.joints)
            rule = "must be one value" if key == "frequency" else f"must be {count} values, for joint groups {groups}"
            given = f"but has {len(value)} ({', '.join(f'{x:g}' for x in value)})"
            fix = "give one number" if count == 1 else f"give {count}, separated by commas"
            raise InputError(f"{rule}, {given}", key=f"--{key}", fix=fix)
