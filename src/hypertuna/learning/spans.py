"""Actions: the meaning of their numbers, and the ranges that turn them into a gait."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError
from hypertuna.ranges import POSITIVE

STEP = 0.1  # duration of an action [s]
LAG = math.pi  # largest lag of a joint behind the joint before it [rad]
BIAS = 0.5  # largest bias, for steering, as a part of a joint's largest bend


def knobs(robot: Robot) -> tuple[str, ...]:
    """Return the names of the numbers of an action, each from -1 to 1."""
    names = [group.name for group in robot.joints]
    return (
        "frequency",
        *(f"amplitude of {name}" for name in names),
        *(f"lag of {name}" for name in names[1:]),
        *(f"bias of {name}" for name in names),
    )


def sensed_size(robot: Robot) -> int:
    """Return how many numbers of an observation are not the task's: speed, turn, bends measured and set, action."""
    return 2 + 2 * len(robot.joints) + len(knobs(robot))


@dataclass(frozen=True)
class Span:
    """Ranges that turn actions into a gait."""

    frequency: float  # largest frequency [Hz]
    bend: Array  # largest bends (joints,) [rad]

    def gait(self, action: Array) -> tuple[Array, Array, Array, Array]:
        """Return frequency, amplitude, phase and bias of actions (N, 3 joints) from -1 to 1."""
        joints = len(self.bend)
        fraction = (np.clip(action, -1, 1) + 1) / 2
        lag = np.concatenate([np.zeros((len(fraction), 1)), LAG * fraction[:, 1 + joints : 2 * joints]], axis=1)
        bias = BIAS * self.bend * (2 * fraction[:, 2 * joints :] - 1)
        return self.frequency * fraction[:, 0], self.bend * fraction[:, 1 : 1 + joints], lag.cumsum(axis=1), bias


def ticks_of(robot: Robot, step: float) -> int:
    """Return the control ticks in a step [s] of an action."""
    tick = 1 / require_controller(robot).rate
    fix = f"give {STEP:g}, say"
    ticks = round(POSITIVE.check(step, "step", fix) / tick)
    if ticks < 1 or abs(ticks * tick - step) > 1e-9:
        rule = f"must be whole control ticks of {tick:g} s"
        raise InputError(rule, key="step", value=f"{step:g}", fix=fix)
    return ticks


def span_of(robot: Robot) -> Span:
    """Return the ranges of a robot's actions: its controller's largest frequency, the largest bend of each joint."""
    control = require_controller(robot)
    bends = [group.bend_max for group in robot.joints]
    if missing := [group.name for group, bend in zip(robot.joints, bends, strict=True) if bend is None]:
        fix = "give the largest bend, from a bench or `hypertuna joint bend`"
        raise InputError(
            "is needed to learn", file=robot.file or None, key=f"joints.{missing[0]}.bend_max_deg", fix=fix
        )
    return Span(control.frequency_max, np.array(bends, dtype=float))
