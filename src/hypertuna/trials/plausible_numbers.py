"""Warnings on numbers of runs that contradict each other: deviations, gaits, drag, sudden stops."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.trials.decay import Glide, YawDecay
from hypertuna.trials.numbers import Tow
from hypertuna.trials.plausibility import FEW, RADIANS

BOUND = 3.0  # times the largest frequency of the robot's gaits
DRAG_POWERS = (1.3, 3.0)  # of the speed: drag grows by about its square
STOP, USUAL = 0.3, 6.0  # of the first value, and usual drops, that make one drop a sudden stop
Doubts = list[tuple[str, str, str]]  # key, rule, fix


def contradictions(runs: Iterable[Any], robot: Robot) -> list[str]:
    """Return warnings on the files of runs of any kind."""
    warnings: list[str] = []
    by_file: dict[str, list[Any]] = {}
    for run in runs:
        by_file.setdefault(getattr(run, "file", ""), []).append(run)
    for file, own in by_file.items():
        doubts = [*_gaits(own, robot), *_deviations(own), *_tows(own)]
        doubts += [doubt for run in own if isinstance(run, Glide | YawDecay) for doubt in _stop(run)]
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


def _tows(runs: Sequence[Any]) -> Doubts:
    """Return a doubt about drag that does not grow by about the square of the speed."""
    tows = [run for run in runs if isinstance(run, Tow) and run.value > 0]
    if len({run.u for run in tows}) < FEW or max(run.u for run in tows) < 1.5 * min(run.u for run in tows):
        return []
    power = np.polyfit(np.log([run.u for run in tows]), np.log([run.value for run in tows]), 1)[0]
    if DRAG_POWERS[0] <= power <= DRAG_POWERS[1]:
        return []
    rule = f"grows as the power {power:.1f} of the speed, where drag grows by about its square"
    return [("the drag", rule, "was the gauge zeroed in still water, and are both columns of the same runs?")]


def _stop(run: Any) -> Doubts:
    """Return a doubt about a decay that stops at once, as at a wall or at the end of a tether."""
    drop = -np.diff(np.abs(run.value))
    k = int(np.argmax(drop))
    late = k > 0 and drop[k] > STOP * abs(float(run.value[0])) and drop[k] > USUAL * float(np.median(np.abs(drop)))
    if not late or abs(float(run.value[k + 1])) > STOP * abs(float(run.value[k])):
        return []
    fix = "did it touch a wall, or was it stopped? Leave out the rows from there on"
    return [(f"run {run.name}", f"stops at once at {run.time[k + 1]:.4g} s", fix)]
