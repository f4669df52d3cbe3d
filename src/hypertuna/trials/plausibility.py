"""Errors and warnings on files of unlikely runs: angles in radians, speeds far from the model's or from any body's."""

import math
from collections.abc import Sequence

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

FAR = 10.0  # times the model's speed, or a part of it: more than estimated coefficients are usually wrong by
# The same, beyond which a unit must be wrong. The speed goes as the root of thrust over drag: a factor of 50 needs 2500
# between these, more than all bounds allow. So 300 is no robot either, but cm/s beside a model that is wrong by 3.
ANOTHER_UNIT = 50.0
CAUSES = (
    "likely causes are another unit of speed or frequency, amplitudes from peak to peak, phases of the wrong sign, or "
    "a wrong length, area or drag of the robot"
)
BEYOND = 1.5  # times the amplitude that a joint is described to make
STILL = 0.01  # lengths a second: a beating body that goes slower all the time does not swim
SPINNING = math.radians(3000)  # rad/s, beyond a head that yaws by 30 deg at 15 Hz
RADIANS = math.radians(1.6)  # rad, amplitude: angles of beats in radians look like degrees below it


def implausible_runs(runs: Sequence[SteadyRun], robot: Robot) -> tuple[list[InputError], list[str]]:
    """Return errors on files of steady runs that must be in wrong units, and warnings on files that are unlikely."""
    errors: list[InputError] = []
    warnings: list[str] = []
    for file in dict.fromkeys(run.file for run in runs):
        file_runs = [run for run in runs if run.file == file]
        largest = max(max(run.gait.amplitude) for run in file_runs)
        if 0 < largest < RADIANS:
            radians_as_deg = math.degrees(math.degrees(largest))
            fix = f"is it in radians? Then write {radians_as_deg:.3g}"
            key, rule = "the largest amplitude", f"is {math.degrees(largest):.3g} deg"
            errors.append(InputError(rule, file=file, key=key, fix=fix))
            continue
        for name, noun, unit, causes in (("speed", "speeds", "m/s", CAUSES), *_bends(robot)):
            ratio, key = _ratio(name, file_runs, robot), f"the measured {noun}"
            if 1 / FAR <= ratio <= FAR:
                continue
            size = float(f"{max(ratio, 1 / ratio):.2g}")
            rule = f"are {size:g} times those of the model" if ratio > 1 else f"are 1/{size:g} of those of the model"
            if size > ANOTHER_UNIT and name == "speed":
                errors.append(InputError(rule, file=file, key=key, fix=f"check the unit, {unit}"))
            else:
                warnings.append(str(InputError(rule, file=file, key=key, fix=causes)))
    return errors, warnings


def _bends(robot: Robot) -> list[tuple[str, str, str, str]]:
    """Return name, noun, unit and likely causes of measured amplitudes of hinges far from the model's."""
    names = [bend_name(robot.hinges, "bend_amplitude", d) for d in range(len(robot.hinges))]
    causes = "likely causes are radians, values from peak to peak, or a wrong stiffness or link of the hinge"
    return [(name, f"amplitudes of hinges ({name}_deg)", "deg", causes) for name in names]


def _ratio(name: str, runs: Sequence[SteadyRun], robot: Robot) -> float:
    """Return the median ratio of measured values of a quantity to those of the model; 1 where none was measured."""
    values = [(run.gait, run.measured()[name][1]) for run in runs if name in run.measured()]
    measured = [(gait, value) for gait, value in values if value]
    if not measured:
        return 1.0
    computed = sweep(robot, [gait for gait, _ in measured])[name].to_numpy()
    usable = np.isfinite(computed) & (computed != 0)
    ratios = np.array([value for _, value in measured], dtype=float)[usable] / computed[usable]
    return float(np.median(np.abs(ratios))) if len(ratios) else 1.0


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
