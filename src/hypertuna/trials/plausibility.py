"""Errors and warnings on files of unlikely runs: angles in radians, values far from the model's or from any body's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.sweep import sweep
from hypertuna.swimming.yielding import bend_name
from hypertuna.trials.head_motion import FASTEST, FLIP, OFTEN, sideways, speed_of, tail_first
from hypertuna.trials.manifest import Recording
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.tracks import Track

if TYPE_CHECKING:
    import xarray as xr

FAR = 10.0  # times the model's speed, or a part of it: more than estimated coefficients are usually wrong by
# The same, beyond which a unit must be wrong. The speed goes as the root of thrust over drag: a factor of 50 needs 2500
# between these, more than all bounds allow. So 300 is no robot either, but cm/s beside a model that is wrong by 3.
ANOTHER_UNIT = 50.0
CAUSES = (
    "likely causes are another unit of speed or frequency, amplitudes from peak to peak, phases of the wrong sign, or "
    "a wrong length, area or drag of the robot"
)
BEYOND = 1.5  # times the amplitude that a joint is described to make
FEW = 3  # ratios of a file from which their median has a sign
STILL = 0.01  # lengths a second: a beating body that goes slower all the time does not swim
SPINNING = math.radians(3000)  # rad/s, beyond a head that yaws by 30 deg at 15 Hz
RADIANS = math.radians(1.6)  # rad, amplitude: angles of beats in radians look like degrees below it


def implausible_runs(runs: Sequence[SteadyRun], robot: Robot) -> tuple[list[InputError], list[str]]:
    """Return errors on files of steady runs that must be in wrong units, and warnings on files that are unlikely."""
    errors: list[InputError] = []
    warnings: list[str] = []
    doubts: list[str] = []
    for file in dict.fromkeys(run.file for run in runs):
        file_runs = [run for run in runs if run.file == file]
        largest = max(max(run.gait.amplitude) for run in file_runs)
        if 0 < largest < RADIANS:
            radians_as_deg = math.degrees(math.degrees(largest))
            fix = f"is it in radians? Then write {radians_as_deg:.3g}"
            key, rule = "the largest amplitude", f"is {math.degrees(largest):.3g} deg"
            errors.append(InputError(rule, file=file, key=key, fix=fix))
            continue
        computed = sweep(robot, [run.gait for run in file_runs])
        for name, noun, unit, causes in (("speed", "speeds", "m/s", CAUSES), *_bends(robot)):
            ratio, key = _size(_ratios(name, file_runs, computed)), f"the measured {noun}"
            if 1 / FAR <= ratio <= FAR:
                continue
            size = float(f"{max(ratio, 1 / ratio):.2g}")
            rule = f"are {size:g} times those of the model" if ratio > 1 else f"are 1/{size:g} of those of the model"
            if size > ANOTHER_UNIT and name == "speed":
                errors.append(InputError(rule, file=file, key=key, fix=f"check the unit, {unit}"))
            else:
                warnings.append(str(InputError(rule, file=file, key=key, fix=causes)))
        doubts += (
            str(InputError(rule, file=file, key=key, fix=fix)) for key, rule, fix in _doubts(file_runs, computed)
        )
    return errors, warnings if errors else [*warnings, *doubts]


def _doubts(runs: Sequence[SteadyRun], computed: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return key, rule and fix of doubts about swims backward, and about costs of transport far from the model's."""
    doubts = []
    for name, key in (("speed", "the measured speeds"), ("cost_of_transport", "the measured costs of transport")):
        ratios = _ratios(name, runs, computed)
        if len(ratios) < FEW:
            continue
        ratio = float(np.median(ratios))
        if ratio < 0:
            doubts.append((key, "have the other sign than those of the model", "positive is ahead, head first"))
        elif name != "speed" and not 1 / FAR <= ratio <= FAR:
            fix = "check the unit, J/(kg m), or W of power_w"
            doubts.append((key, f"are {ratio:.2g} times those of the model", fix))
    return doubts


def _bends(robot: Robot) -> list[tuple[str, str, str, str]]:
    """Return name, noun, unit and likely causes of measured amplitudes of hinges far from the model's."""
    names = [bend_name(robot.hinges, "bend_amplitude", d) for d in range(len(robot.hinges))]
    causes = "likely causes are radians, values from peak to peak, or a wrong stiffness or link of the hinge"
    return [(name, f"amplitudes of hinges ({name}_deg)", "deg", causes) for name in names]


def _ratios(name: str, runs: Sequence[SteadyRun], computed: xr.Dataset) -> Array:
    """Return the ratios of measured values of a quantity to those of the model, of runs that have both."""
    measured = np.array([run.measured()[name][1] if name in run.measured() else math.nan for run in runs], dtype=float)
    with np.errstate(all="ignore"):
        ratios: Array = measured / computed[name].to_numpy()
    return ratios[np.isfinite(ratios)]


def _size(ratios: Array) -> float:
    """Return the median size of ratios other than 0; 1 without any."""
    sizes = np.abs(ratios[ratios != 0])
    return float(np.median(sizes)) if len(sizes) else 1.0


def bend_limits(robot: Robot) -> Array:
    """Return each joint group's largest angle (groups,) [rad] by the robot's description, NaN where it has none."""
    bounds = robot.gait_bounds
    by_gaits = [high for _, high in bounds.amplitude] if bounds is not None else [math.nan] * len(robot.joints)
    described = (group.bend_max or group.amplitude_max for group in robot.joints)
    return np.array([limit or high for limit, high in zip(described, by_gaits, strict=True)])


def implausible_recording(recording: Recording, robot: Robot) -> tuple[list[InputError], list[str]]:
    """Return errors on a recording that must be in wrong units, and warnings on one that is unlikely."""
    largest, file, errors, warnings = np.max(np.abs(recording.joints.angle), axis=0), recording.joints.file, [], []
    if largest.max() > math.pi:
        rule, fix = "must bend by less than half a turn", "are the angles in deg? Then write unit = 'deg'"
        value = f"{math.degrees(largest.max()):.0f} deg"
        errors.append(InputError(rule, file=file, key="the joints", value=value, fix=fix))
    elif 0 < largest.max() < RADIANS:
        rule, fix = f"bend by {math.degrees(largest.max()):.2g} deg at most", "are the angles in radians?"
        warnings.append(str(InputError(rule, file=file, key="the joints", fix=fix)))
    else:
        for group, angle, limit in zip(robot.joints, largest, bend_limits(robot), strict=False):
            if angle > BEYOND * limit:
                rule = f"bends by {math.degrees(angle):.0f} deg, and is described for {math.degrees(limit):.0f} deg"
                warnings.append(str(InputError(rule, file=file, key=f"joint {group.name}", fix="check unit and order")))
    beats = bool(largest.max() > 0)
    for name, track in zip(recording.runs, recording.tracks, strict=True):
        fault, unlikely = _implausible_track(track, robot.body.length, beats=beats)
        key = f"run {name}"
        errors += [InputError(*fault[:1], file=recording.file, key=key, fix=fault[1])] if fault else []
        warnings += [str(InputError(rule, file=recording.file, key=key, fix=fix)) for rule, fix in unlikely]
    return errors, warnings


def _implausible_track(
    track: Track, length: float, *, beats: bool
) -> tuple[tuple[str, str] | None, list[tuple[str, str]]]:
    """Return what makes a track impossible and what makes it unlikely, each with a fix."""
    if len(track.time) < 3:
        return None, []
    speed, unlikely = speed_of(track.time, track.pose) / length, []
    turn = np.abs(np.diff(track.pose[:, 2]))
    if speed > FASTEST:
        return (f"goes {speed:.3g} of the robot's lengths a second", "check length_unit and the unit of time"), []
    if np.mean(turn > FLIP) > OFTEN or np.median(turn / np.diff(track.time)) > SPINNING:
        return ("yaws faster than any head", "check angle_unit and the track"), []
    fastest = speed_of(track.time, track.pose, part=0.9) / length
    if beats and fastest < STILL:
        unlikely.append((f"hardly moves, by {fastest:.2g} of the robot's lengths a second", "check length_unit"))
    elif tail_first(track.pose, [np.arange(len(track.time))], length):
        unlikely.append(("moves tail first all the time", "check yaw, yaw_zero_deg and clockwise, if it does not"))
    elif sideways(track.pose, [np.arange(len(track.time))], length):
        unlikely.append(("moves to its side all the time", "check yaw_zero_deg, and whether x and y are interchanged"))
    return None, unlikely
