"""The commands `hypertuna export mjcf | sdf | fmu`: robots for other simulators."""

from collections.abc import Sequence
from typing import Annotated, Any

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by
from hypertuna.description.robot import Robot


def export_file(
    robot: Robot, output: str, content: bytes, *, as_json: bool, lines: Sequence[str] = (), **facts: Any
) -> None:
    """Write the file of a robot for another program, and print its name and size, with more `facts` in JSON."""
    from hypertuna.io.files import write_atomically

    write_atomically(output, content)
    emit(
        {"file": output, "bytes": len(content), **facts},
        record=lambda result: result | made_by(robot),
        lines=lambda _: [f"written: {output}, {len(content)} bytes", *lines],
        as_json=as_json,
    )


@opt.grouped
def mjcf_command(
    robot: opt.ModelOptions,
    output: Annotated[str, opt.file("--output", "the model", ".xml")],
    plugin: Annotated[
        bool,
        opt.flag("--plugin", "Leave the water to the engine plugin of `make mujoco-plugin`: the whole water law."),
    ] = False,
    free: Annotated[
        bool, opt.flag("--free", "Move in space, with weight, buoyancy and fins; with --plugin only.")
    ] = False,
    as_json: opt.AsJson = False,
) -> None:
    """Write a robot as a MuJoCo model: it swims there by MuJoCo's own fluid forces, or by the engine plugin."""
    from hypertuna.export.mjcf import losses, mjcf

    subject = robot.load()
    content = mjcf(subject, plugin=plugin, free=free).encode()
    omits = losses(subject, plugin=plugin, free=free)
    export_file(subject, output, content, as_json=as_json, lines=_not_in(omits), plugin=plugin, free=free, lost=omits)


@opt.grouped
def sdf_command(
    robot: opt.ModelOptions,
    output: Annotated[str, opt.file("--output", "the model", ".sdf")],
    as_json: opt.AsJson = False,
) -> None:
    """Write a robot as an SDF model for Gazebo, with the added mass of its water law."""
    from hypertuna.export.sdf import sdf, sdf_losses

    subject = opt.with_rigid_hinge(robot.load())
    content, omits = sdf(subject).encode(), sdf_losses(subject)
    export_file(subject, output, content, as_json=as_json, lines=_not_in(omits), lost=omits)


def _not_in(omits: Sequence[str]) -> list[str]:
    """Return the lines that list the parts of a robot which a model leaves out."""
    return ["not in it:", *(f"  - {line}" for line in omits)]


@opt.grouped
def fmu_command(
    robot: opt.RobotOptions,
    output: Annotated[str, opt.file("--output", "the FMU", ".fmu")],
    kind: Annotated[
        str, opt.word("--kind", ("twin", "plant"), "The whole robot under a command, or without its controller.")
    ] = "twin",
    fmi: Annotated[str, opt.word("--fmi", ("2", "3"), "Version of the standard.")] = "2",
    sea: Annotated[bool, opt.flag("--sea", "Move in space, with the fins; otherwise in the plane.")] = False,
    as_json: opt.AsJson = False,
) -> None:
    """Write a robot as an FMU for co-simulation: for Simulink, OpenModelica, FMPy and others, without Python."""
    from hypertuna.export.fmu import fmu, fmu_binaries

    subject, version = robot.load(), int(fmi)
    content, platforms = fmu(subject, kind=kind, fmi=version, sea=sea), list(fmu_binaries(version))
    lines = [f"platforms: {', '.join(platforms)}"]
    facts = {"kind": kind, "fmi": version, "sea": sea, "platforms": platforms}
    export_file(subject, output, content, as_json=as_json, lines=lines, **facts)
