"""Find files of unlikely steady runs: angles in radians, or speeds far from the model's."""

import math
from collections.abc import Sequence

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.sweep import sweep
from hypertuna.trials.steady import SteadyRun

FAR = 10.0  # ratio of measured to computed values (or its inverse) that estimated coefficients rarely explain
# Ratio of speeds beyond which a unit must be wrong. Speed is proportional to the root of thrust over drag, so a factor
# of 50 would need one of 2500 in these, more than all bounds allow. A ratio of 300 may be cm/s and a model wrong by 3.
WRONG_UNIT = 50.0
# Fix in a warning.
CAUSES = (
    "likely causes are another unit of speed or frequency, amplitudes from peak to peak, phases of the wrong sign, or "
    "a wrong length, area or drag of the robot"
)
MIN_AMPLITUDE = math.radians(1.6)  # rad: a smaller largest amplitude is likely in radians, read as degrees


def implausible_runs(runs: Sequence[SteadyRun], robot: Robot) -> tuple[list[InputError], list[str]]:
    """Return errors on files of steady runs in wrong units, and warnings about files with unlikely speeds."""
    errors: list[InputError] = []
    warnings: list[str] = []
    for file in dict.fromkeys(run.file for run in runs):
        file_runs = [run for run in runs if run.file == file]
        largest = max(max(run.gait.amplitude) for run in file_runs)
        if 0 < largest < MIN_AMPLITUDE:
            radians_as_deg = math.degrees(math.degrees(largest))
            fix = f"is it in radians? Then write {radians_as_deg:.3g}"
            key, rule = "the largest amplitude", f"is {math.degrees(largest):.3g} deg"
            errors.append(InputError(rule, file=file, key=key, fix=fix))
            continue
        ratio = _speed_ratio(file_runs, robot)
        if 1 / FAR <= ratio <= FAR:
            continue
        size = float(f"{max(ratio, 1 / ratio):.2g}")
        rule = f"are {size:g} times those of the model" if ratio > 1 else f"are 1/{size:g} of those of the model"
        if size > WRONG_UNIT:
            errors.append(InputError(rule, file=file, key="the measured speeds", fix="check the unit, m/s"))
        else:
            warnings.append(str(InputError(rule, file=file, key="the measured speeds", fix=CAUSES)))
    return errors, warnings


def _speed_ratio(runs: Sequence[SteadyRun], robot: Robot) -> float:
    """Return the median ratio of measured speeds to the model's; 1 if no speed was measured."""
    measured = [run for run in runs if run.speed]
    if not measured:
        return 1.0
    computed = sweep(robot, [run.gait for run in measured]).speed.to_numpy()
    usable = np.isfinite(computed) & (computed != 0)
    ratios = np.array([run.speed for run in measured], dtype=float)[usable] / computed[usable]
    return float(np.median(np.abs(ratios))) if len(ratios) else 1.0
