"""The command `hypertuna rl export`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by
from hypertuna.errors import InputError
from hypertuna.ranges import POSITIVE


@opt.grouped
def export_command(
    policy: Annotated[str, typer.Argument(help="File of the trained policy, .npz.", metavar="POLICY")],
    robot: opt.RobotOptions,
    output: Annotated[str, opt.file("--output", "the C++ header", ".hpp")],
    step: Annotated[
        float | None, opt.number("--step", "seconds", "Step of the training, where POLICY lacks it.", limits=POSITIVE)
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Write a trained policy as a header of the firmware, which the core runs in single precision."""
    from hypertuna.io.files import write_atomically
    from hypertuna.learning.header import policy_header
    from hypertuna.learning.policy import read_policy
    from hypertuna.learning.spans import ticks_of

    subject, trained = robot.load(), read_policy(policy)
    if step is not None and trained.step not in (None, step):
        rule = f"must be {trained.step:g} s, the step of the training that {policy} has"
        raise InputError(rule, key="--step", value=f"{step:g}", fix="leave it out")
    made = trained.step if step is None else step
    if made is None:
        rule = f"must be given, for {policy} does not tell the step of its training"
        raise InputError(rule, key="--step", fix="give it in seconds")
    try:
        ticks_of(subject, made)
    except InputError as error:
        where = {"key": "--step"} if trained.step is None else {"file": policy, "key": error.key}
        raise InputError(error.rule, value=error.value, fix=error.fix, **where) from None
    write_atomically(output, policy_header(trained, subject, policy, step=made).encode())
    numbers = sum(weight.size + bias.size for weight, bias in zip(trained.weights, trained.biases, strict=True))
    result = {"file": output, "layers": len(trained.weights), "step_s": made, "numbers": numbers, "bytes": 4 * numbers}
    emit(result, record=lambda result: result | made_by(subject), lines=_lines, as_json=as_json)


def _lines(result: dict[str, Any]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a written policy."""
    yield f"written: {result['file']}, {result['layers']} layers of {result['bytes']} bytes"
