"""The command `hypertuna export fmu`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by


@opt.grouped
def fmu_command(
    robot: opt.RobotOptions,
    output: Annotated[str, opt.file("-o", "--output", help="File to write.", suffixes=(".fmu",))],
    kind: Annotated[
        str, opt.word("--kind", ("twin", "plant"), "The whole robot under a command, or without its controller.")
    ] = "twin",
    fmi: Annotated[str, opt.word("--fmi", ("2", "3"), "Version of the standard.")] = "2",
    sea: Annotated[bool, typer.Option("--sea", help="Move in space, with the fins; otherwise in the plane.")] = False,
    as_json: opt.AsJson = False,
) -> None:
    """Write a robot as an FMU for co-simulation: for Simulink, OpenModelica, FMPy and others, without Python."""
    from hypertuna.export.fmu import fmu, fmu_binaries
    from hypertuna.io.files import write_atomically

    subject = robot.load()
    content = fmu(subject, kind=kind, fmi=int(fmi), sea=sea)
    write_atomically(output, content)
    result = {
        "file": output,
        "bytes": len(content),
        "kind": kind,
        "fmi": int(fmi),
        "sea": sea,
        "platforms": list(fmu_binaries(int(fmi))),
    }
    emit(result, record=lambda result: result | made_by(subject), lines=_lines, as_json=as_json)


def _lines(result: dict[str, Any]) -> Iterator[Any]:
    """Lay out what was written, and for which platforms."""
    yield f"written: {result['file']}, {result['bytes']} bytes"
    yield f"platforms: {', '.join(result['platforms'])}"
