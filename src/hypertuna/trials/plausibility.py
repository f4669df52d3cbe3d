"""Steady runs that are allowed but unlikely: speeds far from the model's, angles in radians; each in a sentence."""

import math
from collections.abc import Sequence

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.sweep import sweep
from hypertuna.trials.steady import SteadyRun

FAR = 10.0  # times the model's, or a part of it: more than any coefficient is wrong by
RADIANS = math.radians(1.6)  # rad, amplitude: angles of beats in radians look like degrees below it


def implausible_runs(runs: Sequence[SteadyRun], robot: Robot) -> list[InputError]:
    """Return a doubt about each file of steady runs that is far from the robot's model."""
    doubts = []
    for file in dict.fromkeys(run.file for run in runs):
        own = [run for run in runs if run.file == file]
        largest = max(max(run.gait.amplitude) for run in own)
        if 0 < largest < RADIANS:
            meant = math.degrees(math.degrees(largest))
            fix = f"is it in radians? Then write {meant:.3g}"
            key, rule = "the largest amplitude", f"is {math.degrees(largest):.3g} deg"
            doubts.append(InputError(rule, file=file, key=key, fix=fix))
            continue
        measured = [run for run in own if run.speed]
        if not measured:
            continue
        computed = sweep(robot, [run.gait for run in measured]).speed.to_numpy()
        swims = np.isfinite(computed) & (computed != 0)
        ratios = np.array([run.speed for run in measured], dtype=float)[swims] / computed[swims]
        ratio = float(np.median(np.abs(ratios))) if len(ratios) else 1.0
        if not 1 / FAR <= ratio <= FAR:
            size = float(f"{max(ratio, 1 / ratio):.2g}")
            rule = f"are {size:g} times those of the model" if ratio > 1 else f"are 1/{size:g} of those of the model"
            doubts.append(InputError(rule, file=file, key="the measured speeds", fix="check the unit, m/s"))
    return doubts
