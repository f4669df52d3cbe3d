"""A policy as a C++ header of the firmware."""

from __future__ import annotations

import numpy as np

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.learning.policy import Policy
from hypertuna.learning.spans import BIAS, LAG, knobs, sensed_size, span_of, ticks_of
from hypertuna.learning.tasks import TASKS

NEURONS_MAX = 128  # limit of core control/policy.hpp


def policy_header(policy: Policy, robot: Robot, source: str, *, step: float) -> str:
    """Return the header of a policy for a robot: core control/policy.hpp runs it in single precision.

    Parameters
    ----------
    policy : Policy
        Its actions are those of the robot.
    robot : Robot
        What actions are multiplied by comes from its description.
    source : str
        File of the policy, for messages and the header's first line.
    step : float
        Length of a step of the training [s], whole control ticks.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If the layers do not fit the core, the robot and the task, a weight is beyond single precision, or the step is
        not whole control ticks.
    """
    span, ticks = span_of(robot), ticks_of(robot, step)
    sizes = [policy.weights[0].shape[1], *(len(bias) for bias in policy.biases)]
    if max(sizes) > NEURONS_MAX or min(sizes) < 1:
        rule, fix = f"must have layers of 1 to {NEURONS_MAX} neurons", "train one of that size"
        raise InputError(rule, file=source, value=", ".join(map(str, sizes)), fix=fix)
    fix = "give the robot that it was trained for"
    task, sensed = TASKS.get(policy.task or ""), sensed_size(robot)
    if sizes[0] != sensed + task.size if task else sizes[0] < sensed:
        inputs = f"{sensed + task.size} inputs for {policy.task} with" if task else f"at least {sensed} inputs for"
        raise InputError(f"must have {inputs} {robot.name}", file=source, value=str(sizes[0]), fix=fix)
    if max(abs(part).max() for part in (*policy.weights, *policy.biases)) > np.finfo(np.float32).max:
        raise InputError("must have weights in the range of single precision", file=source, fix="train it anew")
    if sizes[-1] != len(knobs(robot)):
        rule = f"must have {len(knobs(robot))} actions for {robot.name}"
        raise InputError(rule, file=source, value=str(sizes[-1]), fix=fix)

    def row(name: str, values: list[float]) -> str:
        return f"inline constexpr float {name}[] = {{{', '.join(_float_literal(value) for value in values)}}};"

    layers = list(enumerate(zip(policy.weights, policy.biases, strict=True)))
    parts = [
        row(f"{kind}_{k}", [*numbers.ravel()])
        for k, pair in layers
        for kind, numbers in zip(("weight", "bias"), pair, strict=True)
    ]
    table = ", ".join(f"{{{weight.shape[1]}, {len(bias)}, weight_{k}, bias_{k}}}" for k, (weight, bias) in layers)
    bends = ", ".join(_float_literal(bend) for bend in span.bend)
    return "\n".join(
        [
            f"/// Policy of {robot.name}: hypertuna rl export {source}",
            "#pragma once",
            "",
            '#include "hypertuna/control/policy.hpp"',
            "",
            "namespace hypertuna::policy_numbers {",
            *parts,
            f"inline constexpr Layer<float> layers[] = {{{table}}};",
            "}  // namespace hypertuna::policy_numbers",
            "",
            "namespace hypertuna {",
            "inline constexpr Policy<float> policy{",
            f"    {len(layers)}, policy_numbers::layers, {ticks}, {len(robot.joints)},",
            f"    {_float_literal(span.frequency)}, {{{bends}}}, {_float_literal(LAG)}, {_float_literal(BIAS)}}};",
            "}  // namespace hypertuna",
            "",
        ]
    )


def _float_literal(value: float) -> str:
    text = f"{value:.9g}"
    return text + ("f" if any(c in text for c in ".en") else ".0f")
