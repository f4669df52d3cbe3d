"""Read and set a robot's parameters over the radio."""

import math
from collections.abc import Callable
from typing import Any

from hypertuna.errors import InputError, shown
from hypertuna.radio.client import PATIENCE, Client, of_kind

NAME_LENGTH_MAX = 16  # characters in MAVLink
UNKNOWN = 1  # MAV_PARAM_ERROR_DOES_NOT_EXIST
SEE = "see them by `hypertuna radio params`"  # fix in errors


def read_parameters(robot: Client, progress: Callable[[int, int], None] | None = None) -> dict[str, float]:
    """Read all parameters by name [SI], requesting lost ones singly; progress: called with numbers received, total."""
    received: dict[int, Any] = {}

    def take(answer: Any) -> None:
        if answer.param_index < answer.param_count:
            received[answer.param_index] = answer
        if progress is not None:
            progress(len(received), answer.param_count)

    answer = robot.ask(robot.message("param_request_list"), of_kind("PARAM_VALUE"), "parameters")
    total = answer.param_count
    while answer is not None:
        take(answer)
        answer = robot.wait(of_kind("PARAM_VALUE"), PATIENCE) if len(received) < total else None
    for index in sorted(set(range(total)) - set(received)):
        request = robot.message("param_request_read", b"", index)
        take(robot.ask(request, of_kind("PARAM_VALUE", param_index=index), f"parameter {index}"))
    return {received[k].param_id.lower(): received[k].param_value for k in sorted(received)}


def read_parameter(robot: Client, name: str) -> float:
    """Read one parameter [SI]."""
    answer = _ask(robot, name, "param_request_read", -1)
    if answer.get_type() == "PARAM_ERROR":
        raise InputError("must be a parameter of the robot", key=name, fix=SEE)
    return float(answer.param_value)


def set_parameter(robot: Client, name: str, value: float) -> float:
    """Set a parameter [SI] on board, where it is stored; return its new value as the robot reports it [SI]."""
    text_count = len(robot.texts)
    answer = _ask(robot, name, "param_set", value, 9)
    if answer.get_type() == "PARAM_ERROR":  # not the robot's text, which may still be that of an earlier refusal
        fix = f"no such parameter: {SEE}"
        raise InputError("must be a parameter of the robot", key=name, value=f"{value:g}", fix=fix)
    if math.isclose(answer.param_value, value, rel_tol=1e-6, abs_tol=1e-30):
        return float(answer.param_value)
    robot.wait(of_kind("PARAM_ERROR"), PATIENCE / 2)
    reason = robot.texts[-1] if len(robot.texts) > text_count else "not accepted"
    raise InputError("must be accepted by the robot", key=name, value=f"{value:g}", fix=reason)


def _ask(robot: Client, name: str, request: str, *values: float) -> Any:
    """Request a parameter and return the answer; its name must fit a message, as a cut one could be another's."""
    if not name.isascii() or not 0 < len(name) <= NAME_LENGTH_MAX:
        raise InputError("must be a parameter of the robot", key=shown(name), fix=SEE)
    is_value, is_unknown = of_kind("PARAM_VALUE"), of_kind("PARAM_ERROR", error=UNKNOWN)
    message = robot.message(request, name.upper().encode(), *values)
    return robot.ask(message, lambda m: (is_value(m) or is_unknown(m)) and m.param_id.lower() == name.lower(), name)
