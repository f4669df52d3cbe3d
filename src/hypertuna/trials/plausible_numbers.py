"""Warnings on numbers that runs of any kind have: gaits in other units, deviations larger than their values."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.trials.plausibility import FEW, RADIANS

BOUND = 3.0  # times the largest frequency of the robot's gaits
Doubts = list[tuple[str, str, str]]  # key, rule, fix


def contradictions(runs: Iterable[Any], robot: Robot) -> list[str]:
    """Return warnings on the files of runs of any kind."""
    warnings: list[str] = []
    by_file: dict[str, list[Any]] = {}
    for run in runs:
        by_file.setdefault(getattr(run, "file", ""), []).append(run)
    for file, own in by_file.items():
        doubts = [*_gaits(own, robot), *_deviations(own)]
        warnings += [str(InputError(rule, file=file, key=key, fix=fix)) for key, rule, fix in doubts]
    return warnings


def _gaits(runs: Sequence[Any], robot: Robot) -> Doubts:
    """Return doubts about frequencies beyond the robot's, and about a joint group or lags in radians."""
    gaits, bounds = [run.gait for run in runs if getattr(run, "gait", None)], robot.gait_bounds
    doubts: Doubts = []
    if not gaits:
        return []
    fastest = max(gait.frequency for gait in gaits)
    if bounds is not None and fastest > BOUND * bounds.frequency[1]:
        rule = f"is {fastest:.3g} Hz, and the robot's gaits go to {bounds.frequency[1]:.3g} Hz"
        doubts.append(("the largest frequency", rule, "is it in rpm, or an angular frequency in rad/s?"))
    for name, values in (("amplitude", [g.amplitude for g in gaits]), ("phase", [g.phase for g in gaits])):
        largest = np.abs(np.array(values, dtype=float)).max(axis=0)
        for j, group in enumerate(robot.joints):
            others = name == "phase" or largest.max() >= RADIANS  # all amplitudes in radians are an error elsewhere
            if 0 < largest[j] < RADIANS and others:
                rule = f"are {math.degrees(largest[j]):.2g} deg at most"
                doubts.append((f"the values of {name}_{group.name}_deg", rule, "are they in radians?"))
    return doubts


def _deviations(runs: Sequence[Any]) -> Doubts:
    """Return doubts about standard deviations that exceed their values."""
    for name in ("speed", "cost_of_transport", "value"):
        pairs = [
            (getattr(run, name, None), getattr(run, f"{name}_sd" if name != "value" else "sd", None)) for run in runs
        ]
        sizes = [abs(sd) / abs(value) for value, sd in pairs if isinstance(value, float) and value and sd]
        if len(sizes) >= FEW and min(sizes) > 1:
            rule, fix = "exceed the values in all rows", "are they in percent?"
            return [("the standard deviations", rule, fix)]
    return []
