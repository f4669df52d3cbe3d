"""Steady runs that are allowed but unlikely: speeds far from the model's, angles in radians; each in a sentence."""

import math
from collections.abc import Sequence

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.swimming.sweep import sweep
from hypertuna.trials.steady import SteadyRun

FAR = 10.0  # times the model's, or a part of it: more than any coefficient is wrong by
RADIANS = math.radians(1.6)  # rad, amplitude: angles of beats in radians look like degrees below it


def implausible_runs(runs: Sequence[SteadyRun], robot: Robot) -> list[str]:
    """Return a sentence for each file of steady runs that is far from the robot's model."""
    sentences = []
    for file in dict.fromkeys(run.file for run in runs):
        own = [run for run in runs if run.file == file]
        largest = max(max(run.gait.amplitude) for run in own)
        if 0 < largest < RADIANS:
            meant = math.degrees(math.degrees(largest))
            sentences.append(
                f"{file}: the largest amplitude is {math.degrees(largest):.3g} deg: is it in radians? Then write "
                f"{meant:.3g}."
            )
            continue
        measured = [run for run in own if run.speed]
        if not measured:
            continue
        computed = sweep(robot, [run.gait for run in measured]).speed.to_numpy()
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = float(np.nanmedian(np.abs(np.array([run.speed for run in measured], dtype=float) / computed)))
        if math.isfinite(ratio) and not 1 / FAR <= ratio <= FAR:
            times = f"{ratio:.2g} times" if ratio > 1 else f"1/{1 / ratio:.2g} of"
            sentences.append(f"{file}: the measured speeds are {times} those of the model: check the unit, m/s.")
    return sentences
