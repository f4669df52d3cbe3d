"""Reach of runs: the range of their frequency, amplitude and speed, and sentences where a swim lies outside of it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import seen_from_start
from hypertuna.trials.smoothing import SmoothSeries, smooth
from hypertuna.trials.start import beat_of
from hypertuna.trials.trials import Trials

MARGIN = 0.1  # of the ends of a range: a swim is outside beyond it
QUANTITIES = {  # label, unit and units per SI unit
    "frequency": ("frequency", "Hz", 1.0),
    "amplitude": ("amplitude", "deg", 180 / np.pi),
    "speed": ("speed", "m/s", 1.0),
}


def motion_of(recording: Recording) -> dict[str, float]:
    """Return frequency [Hz], largest amplitude [rad] and speed [m/s] of a recording."""
    speeds = [mean_speed(track.time, track.pose) for track in recording.tracks]
    curve = smooth(recording.joints, noise=recording.noise)
    return swim_of_series(curve) | {"speed": float(np.mean(speeds))}


def mean_speed(time: Array, pose: Array) -> float:
    """Return the distance from the first to the last frame over the time between them [m/s]."""
    return float(np.linalg.norm(seen_from_start(pose, 0.0)[-1, :2]) / (time[-1] - time[0]))


def motions_of(trials: Trials) -> list[dict[str, float]]:
    """Return frequency [Hz], largest amplitude [rad] and speed [m/s], if measured, of every run and recording."""
    steady = [
        {"frequency": run.gait.frequency, "amplitude": max(run.gait.amplitude)}
        | ({} if run.speed is None else {"speed": run.speed})
        for run in trials.steady
    ]
    return [*steady, *(motion_of(recording) for recording in trials.recordings)]


def reach_of(trials: Trials) -> dict[str, Any]:
    """Return the range of the runs as the keys of a table [fit]."""
    rows, reach = motions_of(trials), {}
    for name, (_, unit, factor) in QUANTITIES.items():
        values = [row[name] * factor for row in rows if name in row]
        key = f"{name}_{unit.replace('/', '_').lower()}"
        if values and (name == "speed" or min(values) > 0):
            reach[key] = [float(f"{value:.4g}") for value in (min(values), max(values))]
    return reach


def outside(
    robot: Robot, *, frequency: float, amplitude: float | Sequence[float], speed: float | None = None
) -> list[str]:
    """Return a sentence for each quantity of a swim that lies outside the runs of the robot's table [fit]."""
    fit, sentences = robot.fit, []
    swim = {"frequency": frequency, "amplitude": float(np.max(amplitude)), "speed": speed}
    for name, (label, unit, factor) in QUANTITIES.items():
        reach, value = getattr(fit, name, None), swim[name]
        if not reach or value is None:
            continue
        low, high = min(reach), max(reach)
        if not low - MARGIN * abs(low) <= value <= high + MARGIN * abs(high):
            runs = f"the runs that the coefficients were fitted to, {factor * low:.3g} to {factor * high:.3g} {unit}"
            text = f"The {label} {factor * value:.3g} {unit} is outside {runs}: the result is an extrapolation."
            sentences.append(text)
    return sentences


def swim_of_series(curve: SmoothSeries) -> dict[str, float]:
    """Return frequency [Hz] and largest amplitude [rad] of joint angles."""
    frequency, amplitude = beat_of(curve)
    return {"frequency": frequency, "amplitude": float(amplitude.max())}
