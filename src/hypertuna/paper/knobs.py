"""A grid of settled gaits as small data, for the knobs of a page: the fish, and how it swims."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.outline import midlines
from hypertuna.swimming.swim import Swim, swim

FRAMES = 16  # of a beat, from which its first harmonic is taken


def knob_record(robot: Robot, tank: Mapping[str, Any], start: Gait) -> dict[str, Any]:
    """Return the settled gaits of a grid (`frequency_hz`, `amplitude_deg`, `phase_deg`), for a page's script.

    A gait has its quantities, and the first harmonic of its joints' sideways motion [body lengths]; `at` has the
    indices of the gait nearest to `start`.
    """
    ladders = (list(tank["frequency_hz"]), list(tank["amplitude_deg"].values()), list(tank["phase_deg"]))
    gaits = [
        _gait_record(swim(robot, Gait.from_degrees(frequency=hertz, amplitude=level, phase=(0, phase))))
        for hertz in ladders[0]
        for level in ladders[1]
        for phase in ladders[2]
    ]
    aims = (start.frequency, np.degrees(start.amplitude[-1]), np.degrees(start.phase[-1]))
    scales = (ladders[0], [level[-1] for level in ladders[1]], ladders[2])
    at = [int(np.abs(np.subtract(scale, aim)).argmin()) for scale, aim in zip(scales, aims, strict=True)]
    axes = dict(zip(("frequency", "amplitude", "phase"), ladders, strict=True))
    return {"robot": robot.name, "length": robot.body.length, "axes": axes, "at": at, "gaits": gaits}


def _gait_record(beat: Swim) -> dict[str, Any]:
    """Return quantities and motion of a settled gait."""
    lines = midlines(beat, FRAMES) / beat.robot.body.length
    lines = lines - lines[:, :1].real.mean() - 1j * lines.imag.mean()
    turn = np.exp(-2j * np.pi * np.arange(FRAMES) / FRAMES)
    first = 2 * (lines.imag * turn[:, None]).mean(axis=0)
    motion = np.stack([lines.real.mean(axis=0), first.real, first.imag], axis=1).round(4).tolist()
    values = {
        "speed": beat.speed,
        "power": beat.mechanical_power,
        "cost": beat.cost_of_transport,
        "strouhal": beat.strouhal,
    }
    return {key: float(f"{value:.4g}") for key, value in values.items()} | {"settled": beat.settled, "line": motion}
