"""Find the ranges of frequency, amplitude and speed that runs cover, and warn of swims outside of them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.trials.kinds import kind_of
from hypertuna.trials.smoothing import SmoothSeries
from hypertuna.trials.start import beat_of
from hypertuna.trials.trials import Trials

MARGIN = 0.1  # relative distance beyond an end of a range at which a swim is outside
QUANTITIES = {  # by name: label, unit, and units per SI unit
    "frequency": ("frequency", "Hz", 1.0),
    "amplitude": ("amplitude", "deg", 180 / np.pi),
    "speed": ("speed", "m/s", 1.0),
}


def reach_of(trials: Trials) -> dict[str, Any]:
    """Return the ranges of frequency, amplitude and speed that trials cover, by their keys in a table [fit]."""
    rows, reach = [kind_of(trial).motion(trial) for trial in trials.members], {}
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
    """Return "frequency" [Hz] and largest "amplitude" [rad] of joint angles."""
    frequency, amplitude = beat_of(curve)
    return {"frequency": frequency, "amplitude": float(amplitude.max())}
