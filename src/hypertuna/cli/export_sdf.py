"""The command `hypertuna export sdf`."""

from typing import Annotated

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.export_mjcf import export_lines


@opt.grouped
def sdf_command(
    robot: opt.ModelOptions,
    output: Annotated[str, opt.file("-o", "--output", help="File to write.", suffixes=(".sdf",))],
    as_json: opt.AsJson = False,
) -> None:
    """Write a robot as an SDF model for Gazebo, with the added mass of its water law."""
    from hypertuna.export.sdf import sdf, sdf_losses
    from hypertuna.io.files import write_atomically

    subject = robot.load()
    text = sdf(subject)
    write_atomically(output, text.encode())
    result = {"file": output, "bytes": len(text.encode()), "lost": sdf_losses(subject)}
    emit(result, record=lambda result: result | made_by(subject), lines=export_lines, as_json=as_json)
