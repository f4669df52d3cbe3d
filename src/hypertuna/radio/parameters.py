"""Read and set a robot's parameters over the radio."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from hypertuna.errors import InputError, shown
from hypertuna.radio.client import PATIENCE, Client
from hypertuna.radio.dialect import dialect

NAME_LENGTH_MAX = 16  # characters in MAVLink
SEE = "see them by `hypertuna link params`"


def read_parameters(robot: Client, progress: Callable[[int, int], None] | None = None) -> dict[str, float]:
    """Read all parameters by name [SI]; lost ones are requested one by one. `progress(received, total)`."""
    make, received, total = dialect().MAVLink_param_request_list_message, {}, 0
    answer = robot.ask(lambda: make(robot.system, 1), lambda m: m.get_type() == "PARAM_VALUE", "parameters")
    while answer is not None:
        total = answer.param_count
        if answer.param_index < total:
            received[answer.param_index] = answer
        if progress is not None:
            progress(len(received), total)
        if len(received) == total:
            break
        answer = robot.wait(lambda m: m.get_type() == "PARAM_VALUE", PATIENCE)
    for index in sorted(set(range(total)) - set(received)):
        received[index] = _parameter(robot, index)
        if progress is not None:
            progress(len(received), total)
    return {received[k].param_id.lower(): received[k].param_value for k in sorted(received)}


def read_parameter(robot: Client, name: str) -> float:
    """Read one parameter [SI]."""
    _check(name)
    make = dialect().MAVLink_param_request_read_message
    answer = robot.ask(lambda: make(robot.system, 1, name.upper().encode(), -1), _answers(name), name)
    if answer.get_type() == "PARAM_ERROR":
        raise InputError("must be a parameter of the robot", key=name, fix=SEE)
    return float(answer.param_value)


def _parameter(robot: Client, index: int) -> Any:
    """Request one parameter by its index."""
    make = dialect().MAVLink_param_request_read_message
    return robot.ask(
        lambda: make(robot.system, 1, b"", index),
        lambda m: m.get_type() == "PARAM_VALUE" and m.param_index == index,
        f"parameter {index}",
    )


def _check(name: str) -> None:
    """Check that a name fits into a message: a truncated name could be another parameter's."""
    if not name.isascii() or not 0 < len(name) <= NAME_LENGTH_MAX:
        raise InputError("must be a parameter of the robot", key=shown(name), fix=SEE)


def _answers(name: str) -> Callable[[Any], bool]:
    """Return the predicate of an answer about a parameter."""
    return lambda m: m.get_type() in ("PARAM_VALUE", "PARAM_ERROR") and m.param_id.lower() == name.lower()


def set_parameter(robot: Client, name: str, value: float) -> float:
    """Set a parameter [SI], which the robot stores; return the value on board [SI]."""
    _check(name)
    make, texts = dialect().MAVLink_param_set_message, len(robot.texts)
    answer = robot.ask(lambda: make(robot.system, 1, name.upper().encode(), value, 9), _answers(name), name)
    if answer.get_type() == "PARAM_VALUE" and math.isclose(answer.param_value, value, rel_tol=1e-6, abs_tol=1e-30):
        return float(answer.param_value)
    robot.wait(lambda m: m.get_type() == "PARAM_ERROR", PATIENCE / 2)
    unknown = answer.get_type() == "PARAM_ERROR"
    reason = robot.texts[-1] if len(robot.texts) > texts else "no such parameter" if unknown else "not accepted"
    raise InputError("must be accepted by the robot", key=name, value=f"{value:g}", fix=reason)
