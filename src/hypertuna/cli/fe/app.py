"""The commands `hypertuna fe ...`: the soft joints by finite elements."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.actuation.bending import bend
from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, counted, json_text, progress_bar, run_folder, table
from hypertuna.cli.emit import draw, emit
from hypertuna.cli.fe.compare import compare_command
from hypertuna.cli.fe.options import Law, Material, Mesh, Mixed, Poisson, rising
from hypertuna.cli.fe.reduce import reduce_command
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.fe.bend import JOURNAL, FeBend, fe_bend
from hypertuna.fe.extra import need_fe, need_screenless
from hypertuna.fe.fields import write_vtu
from hypertuna.fe.geometry import JointBody, joint_body, write_geometry
from hypertuna.fe.measure import Measured
from hypertuna.fe.model import FeModel, FeOptions
from hypertuna.fe.record import SUMMARY, bend_csv, bend_record, oil_taken
from hypertuna.io.files import write_atomically, write_netcdf

fe_app = opt.group("The soft joints by finite elements; needs the extra fe.")

PRESSURES: Any = "0:250:6"  # kPa, as typed
MM = 1e3  # per m
SMOOTH = 50  # pressures of the analytic curve
COLUMNS = {  # of the table: head and format
    "pressure_kpa": ("gauge\n[kPa]", ".4g"),
    "bend_deg": ("bend\n[deg]", "z.2f"),
    "tip_x_mm": ("tip x\n[mm]", "z.2f"),
    "tip_y_mm": ("tip y\n[mm]", "z.2f"),
    "oil_taken_ml": ("oil\n[ml]", "z.3f"),
    "axial_stretch_min": ("axial\nmin", ".3f"),
    "hoop_stretch_max": ("hoop\nmax", ".3f"),
    "fiber_stretch_max": ("fiber\nmax", ".3f"),
    "strain_99": ("strain\n99 %", "z.3f"),
    "strain_max": ("\nmax", "z.3f"),
    "stress_99_kpa": ("stress\n[kPa]", "z.1f"),
    "stress_max_kpa": ("\nmax", "z.1f"),
}
LEGEND = (
    "Bend, and oil since rest, of the side under pressure; stretches of the channels' walls and of the braids; "
    "logarithmic strain and von Mises stress of the matrix: the 99th percentile, and the maximum, which sits where "
    "hoses end and grows as meshes get finer."
)


@fe_app.command("geometry")
def geometry_command(
    robot: opt.RobotName,
    joint: opt.Joint,
    output: Annotated[
        str | None,
        opt.file(
            "-o",
            "--output",
            help="Write the body to this .step, .stp or .stl file, in mm.",
            suffixes=(".step", ".stp", ".stl"),
        ),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Build the soft body of a joint from its description: sections, channels, plates."""
    fish = load(robot)
    body = joint_body(fish, joint_index(joint, fish))
    if output is not None:
        write_geometry(body, output)
    emit(
        body,
        record=lambda body: _geometry_record(fish, body) | {"file": output},
        lines=lambda body: _geometry_lines(fish, body),
        written=(output,),
        as_json=as_json,
    )


def _geometry_record(robot: Robot, body: JointBody) -> dict[str, Any]:
    """Return the JSON record of a body."""
    return provenance(robot, water=False) | {
        "command": command_line(),
        "joint": body.name,
        "station_mm": MM * body.stations,
        "semi_major_mm": MM * body.semi_major,
        "semi_minor_mm": MM * body.semi_minor,
        "channel_radius_mm": MM * body.radius,
        "channels": [{"side": c.side, "y_mm": MM * c.y, "z_mm": MM * c.z} for c in body.channels],
        "plate_mm": MM * body.plate,
        "strip_width_mm": MM * body.strip,
        "matrix_volume_mm3": MM**3 * body.volume,
    }


def _geometry_lines(robot: Robot, body: JointBody) -> Iterator[Any]:
    """Lay out the sections of a body."""
    sections = zip(body.stations, body.semi_major, body.semi_minor, strict=True)
    rows = ([f"{MM * value:.2f}" for value in section] for section in sections)
    channels = f"{counted(len(body.channels) // 2, 'pair')} of channels of {2 * MM * body.radius:.4g} mm"
    yield f"{robot.name}: soft body of joint {body.name}", "bold"
    yield table(["x\n[mm]", "half height\n[mm]", "half width\n[mm]"], rows, left=())
    yield f"{channels}, {MM * abs(body.channels[0].y):.4g} mm from the neutral layer"
    yield f"matrix {MM**2 * body.volume * MM:.4g} mm^3, plates {MM * body.plate:.3g} mm thick"
    if body.strip:
        yield f"strip {MM * body.strip:.3g} mm wide in the neutral layer"


@fe_app.command("bend")
def bend_command(
    robot: opt.RobotName,
    joint: opt.Joint,
    pressure: opt.Pressures = PRESSURES,
    side: opt.Side = "left",
    material: Material = None,
    law: Law = FeOptions.law,
    poisson: Poisson = FeOptions.poisson,
    mixed: Mixed = FeOptions.mixed,
    mesh: Mesh = FeOptions.mesh,
    plot: opt.Plot = None,
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            help="Folder of the run: journal, fields (VTU) and pictures (PNG) of every pressure, bend.json, .csv and "
            ".nc. The same command resumes after the last pressure that is there.",
        ),
    ] = None,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Write no PNG pictures.")] = False,
    as_json: opt.AsJson = False,
) -> None:
    """Bend a soft joint by finite elements: bend, oil, stretches, strain and stress at every pressure.

    The exit code is 0 if all pressures were reached, 1 if one was not (those before it are printed and kept), 2 for
    bad input.
    """
    fish = load(robot)
    index, path = joint_index(joint, fish), rising(pressure)
    joint_body(fish, index)  # checks the description before the machine
    need_fe()
    if output is not None and not no_pictures:
        need_screenless()
    options = FeOptions(material, law, poisson, mesh, mixed)
    with run_folder(output, JOURNAL) as folder, progress_bar("pressures", patience=0, lines=True) as report:
        report(0, len(path))

        def keep(model: FeModel, k: int, _: Measured) -> None:
            if folder is not None:
                write_vtu(model, folder, k)

        bent = fe_bend(fish, index, path, side=side, options=options, folder=folder, progress=report, each=keep)
    if folder is not None:
        _write(bent, folder, pictures=not no_pictures)
    if plot is not None and len(bent.pressure):
        _plot(bent, plot)
    emit(
        bent,
        record=_record,
        lines=_lines,
        written=(plot if len(bent.pressure) else None, output),
        as_json=as_json,
        failed=bent.status != "converged",
    )


def _record(bent: FeBend) -> dict[str, Any]:
    """Return the JSON record."""
    return bend_record(bent) | {"command": command_line()}


def _write(bent: FeBend, folder: Path, *, pictures: bool) -> None:
    """Write the numbers of a run into its folder, and its pictures."""
    write_atomically(folder / SUMMARY, f"{json_text(_record(bent))}\n".encode())
    write_atomically(folder / "bend.csv", bend_csv(bent, command_line()).encode())
    write_netcdf(bent.dataset().assign_attrs(command=command_line()), folder / "bend.nc")
    if not pictures or not len(bent.pressure):
        return
    from hypertuna.fe.pictures import QUANTITIES, draw_step, read_film, write_filmstrip, write_png

    film, steps = read_film(folder), range(len(bent.pressure))
    with progress_bar("pictures") as report:
        for count, (k, quantity) in enumerate((k, quantity) for k in steps for quantity in QUANTITIES):
            write_png(draw_step(film, k, quantity), folder / f"{quantity}-{k:03d}.png")
            report(count + 1, len(steps) * len(QUANTITIES))
        if bent.pressure[-1] > 0:
            write_filmstrip(folder, folder / "filmstrip.png")


def _plot(bent: FeBend, plot: str) -> None:
    """Plot a bend beside that of the analytic model as described: with friction, loading."""
    path = np.linspace(0, max(float(bent.pressure[-1]), 1.0), SMOOTH)
    other = bend(bent.robot, bent.joint, path, side=bent.side, material=bent.material)
    group = next(group for group in bent.robot.joints if group.name == bent.joint)
    known = group.pressure_max is not None and group.bend_max is not None
    draw(
        "hypertuna.fe.plots:plot_fe_bend",
        plot,
        bent.pressure,
        bent.angle,
        oil_taken(bent),
        title=f"{bent.robot.name}, joint {bent.joint}, {bent.side} side, material set {bent.material}",
        analytic=(other.pressure, other.angle, other.volume),
        published=(group.pressure_max, group.bend_max) if known else None,
    )


def _lines(bent: FeBend) -> Iterator[Any]:
    """Lay out a bend, a row for each pressure."""
    options, record = bent.options, _record(bent)
    joint = f"{bent.robot.name}: joint {bent.joint}, {bent.side} side"
    size = f"{record['mesh']} mesh, {bent.elements} elements, {bent.unknowns} unknowns, {record['seconds']:.0f} s"
    rows = ([f"{step[key]:{form}}" for key, (_, form) in COLUMNS.items()] for step in record["steps"])
    yield f"{joint}, material set {bent.material}, {options.law}", "bold"
    yield f"{size}, Poisson's ratio {options.poisson:g}{', mixed' if options.mixed else ''}", "dim"
    yield table([head for head, _ in COLUMNS.values()], rows, left=(), collapse_padding=True)
    yield LEGEND, "dim"
    if np.isfinite(squared := bent.r_squared()):
        yield f"line over 100 to 250 kPa: R^2 = {squared:.4f}"
    yield bent.status_text, "green" if bent.status == "converged" else "bold red"


fe_app.command("compare")(compare_command)
fe_app.command("reduce")(reduce_command)
