"""A policy as a C++ header of the firmware."""

from __future__ import annotations

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.learning.policy import Policy
from hypertuna.learning.spans import BIAS, LAG, STEP, knobs, span_of, ticks_of

NEURONS_MAX = 128  # core control/policy.hpp


def policy_header(policy: Policy, robot: Robot, source: str, *, step: float = STEP) -> str:
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
        If the layers are too wide for the core or do not fit the robot, or the step is not whole control ticks.
    """
    span, ticks = span_of(robot), ticks_of(robot, step)
    sizes = [policy.weights[0].shape[1], *(len(bias) for bias in policy.biases)]
    if max(sizes) > NEURONS_MAX:
        rule, fix = f"must have layers of at most {NEURONS_MAX} neurons", "train a smaller one"
        raise InputError(rule, file=source, value=str(max(sizes)), fix=fix)
    if sizes[-1] != len(knobs(robot)):
        rule, fix = f"must have {len(knobs(robot))} actions for {robot.name}", "give the robot that it was trained for"
        raise InputError(rule, file=source, value=str(sizes[-1]), fix=fix)

    def row(name: str, values: list[float]) -> str:
        return f"inline constexpr float {name}[] = {{{', '.join(_float(value) for value in values)}}};"

    layers = list(enumerate(zip(policy.weights, policy.biases, strict=True)))
    parts = [
        row(f"{what}_{k}", [*numbers.ravel()])
        for k, pair in layers
        for what, numbers in zip(("weight", "bias"), pair, strict=True)
    ]
    table = ", ".join(f"{{{weight.shape[1]}, {len(bias)}, weight_{k}, bias_{k}}}" for k, (weight, bias) in layers)
    bends = ", ".join(_float(bend) for bend in span.bend)
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
            f"    {_float(span.frequency)}, {{{bends}}}, {_float(LAG)}, {_float(BIAS)}}};",
            "}  // namespace hypertuna",
            "",
        ]
    )


def _float(value: float) -> str:
    text = f"{value:.9g}"
    return text + ("f" if any(c in text for c in ".en") else ".0f")
