"""The command `hypertuna export mjcf`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by


@opt.grouped
def mjcf_command(
    robot: opt.ModelOptions,
    output: Annotated[str, opt.file("-o", "--output", help="File to write.", suffixes=(".xml",))],
    plugin: Annotated[
        bool,
        typer.Option(
            "--plugin", help="Leave the water to the engine plugin of `make mujoco-plugin`: the whole water law."
        ),
    ] = False,
    free: Annotated[
        bool,
        typer.Option("--free", help="Move in space, with weight, buoyancy and fins; with --plugin only."),
    ] = False,
    as_json: opt.AsJson = False,
) -> None:
    """Write a robot as a MuJoCo model: it swims there by MuJoCo's own fluid forces, or by the engine plugin."""
    from hypertuna.export.mjcf import losses, mjcf
    from hypertuna.io.files import write_atomically

    subject = robot.load()
    text = mjcf(subject, plugin=plugin, free=free)
    write_atomically(output, text.encode())
    lost = losses(subject, plugin=plugin, free=free)
    result = {"file": output, "bytes": len(text.encode()), "plugin": plugin, "free": free, "lost": lost}
    emit(result, record=lambda result: result | made_by(subject), lines=export_lines, as_json=as_json)


def export_lines(result: dict[str, Any]) -> Iterator[Any]:
    """Lay out what was written, and what of the model is lost."""
    yield f"written: {result['file']}, {result['bytes']} bytes"
    yield "not in it:"
    yield from (f"  - {line}" for line in result["lost"])
