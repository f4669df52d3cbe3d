"""The command `hypertuna rl export`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by


@opt.grouped
def export_command(
    policy: Annotated[str, typer.Argument(help="File of the trained policy, .npz.", metavar="POLICY")],
    robot: opt.RobotOptions,
    output: Annotated[str, opt.file("-o", "--output", help="C++ header to write.", suffixes=(".hpp",))],
    step: Annotated[float, opt.number("--step", "seconds", "Step of the training, whole control ticks.")] = 0.1,
    as_json: opt.AsJson = False,
) -> None:
    """Write a trained policy as a header of the firmware, which the core runs in single precision."""
    from hypertuna.io.files import write_atomically
    from hypertuna.learning.header import policy_header
    from hypertuna.learning.policy import read_policy

    subject, trained = robot.load(), read_policy(policy)
    write_atomically(output, policy_header(trained, subject, policy, step=step).encode())
    numbers = sum(weight.size + bias.size for weight, bias in zip(trained.weights, trained.biases, strict=True))
    result = {"file": output, "layers": len(trained.weights), "step_s": step, "numbers": numbers, "bytes": 4 * numbers}
    emit(result, record=lambda result: result | made_by(subject), lines=_lines, as_json=as_json)


def _lines(result: dict[str, Any]) -> Iterator[Any]:
    """Lay out what was written."""
    yield f"written: {result['file']}, {result['layers']} layers of {result['bytes']} bytes"
