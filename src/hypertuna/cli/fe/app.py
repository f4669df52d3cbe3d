"""The commands `hypertuna fe ...`: the soft joints by finite elements."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.actuation.bending import Bend, bend
from hypertuna.characterization.data import joint_index
from hypertuna.cli.fe.compare import compare_command
from hypertuna.cli.fe.options import (
    LAW,
    MESH,
    MIXED,
    POISSON,
    Law,
    Material,
    Mesh,
    Mixed,
    Poisson,
    elements,
    rising_pressures,
)
from hypertuna.cli.fe.reduce import reduce_command
from hypertuna.cli.old_console import (
    check_suffix,
    command_line,
    plain,
    print_json,
    progress_bar,
    run_folder,
    tell_written,
)
from hypertuna.cli.old_options import AsJson, Joint, Name, Pressure, Side
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.fe.bend import JOURNAL, FeBend, fe_bend
from hypertuna.fe.extra import need_fe, need_screenless
from hypertuna.fe.fields import write_vtu
from hypertuna.fe.geometry import JointBody, joint_body, write_geometry
from hypertuna.fe.measure import Measured
from hypertuna.fe.model import FeModel
from hypertuna.fe.record import SUMMARY, bend_csv, bend_record, oil_taken
from hypertuna.io.files import write_atomically, write_netcdf

__all__ = ["fe_app"]

fe_app = typer.Typer(no_args_is_help=True, help="The soft joints by finite elements; needs the extra fe.")

MM = 1e3  # per m
SMOOTH = 50  # pressures of the analytic curve
COLUMNS = {  # of the table: head and format
    "pressure_kpa": ("gauge\n[kPa]", ".4g"),
    "bend_deg": ("bend\n[deg]", "z.2f"),
    "tip_x_mm": ("tip x\n[mm]", "z.2f"),
    "tip_y_mm": ("tip y\n[mm]", "z.2f"),
    "oil_taken_ml": ("oil\n[ml]", "z.3f"),
    "axial_stretch_min": ("axial\nleast", ".3f"),
    "hoop_stretch_max": ("hoop\nmost", ".3f"),
    "fiber_stretch_max": ("fiber\nmost", ".3f"),
    "strain_99": ("strain\n99 %", "z.3f"),
    "strain_max": ("\nmost", "z.3f"),
    "stress_99_kpa": ("stress\n[kPa]", "z.1f"),
    "stress_max_kpa": ("\nmost", "z.1f"),
}
LEGEND = (
    "Bend, and oil since rest, of the side with the pressure; stretches of the channels' walls and of the braids; "
    "logarithmic strain and von Mises stress of the matrix: what 99 % of it stay below, and the most, which sits where "
    "hoses end and grows as meshes get finer."
)


@fe_app.command("geometry")
def geometry_command(
    robot: Name,
    joint: Joint,
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write the body to this .step, .stp or .stl file, in mm.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Draw the soft body of a joint from its description: sections, channels, plates."""
    check_suffix(output, (".step", ".stp", ".stl"), "--output")
    fish = load(robot)
    body = joint_body(fish, joint_index(joint, fish))
    if output is not None:
        write_geometry(body, output)
    if as_json:
        print_json(_geometry_record(fish, body) | {"file": output})
        return
    console = Console()
    console.print(Text(f"{fish.name}: soft body of joint {body.name}", style="bold"))
    console.print(_geometry_table(body))
    pairs = len(body.channels) // 2
    what = f"{pairs} pair{'s' * (pairs > 1)} of channels"
    lines = [
        f"{what} of {2 * MM * body.radius:.4g} mm, {MM * abs(body.channels[0].y):.4g} mm from the neutral layer",
        f"matrix {MM**2 * body.volume * MM:.4g} mm^3, plates {MM * body.plate:.3g} mm thick",
        *([f"strip {MM * body.strip:.3g} mm wide in the neutral layer"] if body.strip else []),
    ]
    console.print(Text("\n".join(lines)))
    tell_written(output)


def _geometry_record(robot: Robot, body: JointBody) -> dict[str, Any]:
    """Tell a body, for programs."""
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


def _geometry_table(body: JointBody) -> Table:
    """Tabulate the sections."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for head in ("x\n[mm]", "half height\n[mm]", "half width\n[mm]"):
        table.add_column(Text(head, justify="right"), justify="right")
    for row in zip(body.stations, body.semi_major, body.semi_minor, strict=True):
        table.add_row(*(f"{MM * value:.2f}" for value in row))
    return table


@fe_app.command("bend")
def bend_command(
    robot: Name,
    joint: Joint,
    pressure: Pressure = "0:250:6",
    side: Side = "left",
    material: Material = None,
    law: Law = LAW,
    poisson: Poisson = POISSON,
    mixed: Mixed = MIXED,
    mesh: Mesh = MESH,
    plot: Annotated[
        str | None, typer.Option("--plot", help="Draw bend and oil over pressure to this .svg, .png or .pdf file.")
    ] = None,
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            help="Folder of the run: journal, fields (VTU) and pictures (PNG) of every pressure, bend.json, .csv and "
            ".nc. The same command goes on after the last pressure that is there.",
        ),
    ] = None,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Draw no PNG into the folder.")] = False,
    as_json: AsJson = False,
) -> None:
    """Bend a soft joint by finite elements: bend, oil, stretches, strain and stress at every pressure.

    The exit code is 0 if all pressures were reached, 1 if one was not (those before it are told and kept), 2 for bad
    input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    fish = load(robot)
    index, rising = joint_index(joint, fish), rising_pressures(pressure)
    options = elements(material, law, poisson, mesh, mixed=mixed)
    joint_body(fish, index)  # what the description lacks is told before what the machine lacks
    need_fe()
    if output is not None and not no_pictures:
        need_screenless()
    with run_folder(output, JOURNAL) as folder, progress_bar("pressures", patience=0, lines=True) as report:
        report(0, len(rising))

        def keep(model: FeModel, k: int, _: Measured) -> None:
            if folder is not None:
                write_vtu(model, folder, k)

        found = fe_bend(fish, index, rising, side=side, options=options, folder=folder, progress=report, each=keep)
    record = bend_record(found) | {"command": command_line()}
    if output is not None:
        _write(found, record, Path(output), pictures=not no_pictures)
    drawn = plot if len(found.pressure) else None
    if drawn is not None:
        _plot(found, drawn)
    if as_json:
        print_json(record)
    else:
        _print(found, record)
        tell_written(drawn, output)
    if found.status != "converged":
        raise typer.Exit(1)


def _write(found: FeBend, record: dict[str, Any], folder: Path, *, pictures: bool) -> None:
    """Write the numbers of a run into its folder, and its pictures."""
    import json

    text = json.dumps(plain(record), indent=2, ensure_ascii=False, allow_nan=False)
    write_atomically(folder / SUMMARY, f"{text}\n".encode())
    write_atomically(folder / "bend.csv", bend_csv(found, record["command"]).encode())
    write_netcdf(found.dataset().assign_attrs(command=record["command"]), folder / "bend.nc")
    if not pictures or not len(found.pressure):
        return
    from hypertuna.fe.pictures import QUANTITIES, draw_step, read_film, write_filmstrip, write_png

    film = read_film(folder)
    total = len(found.pressure) * len(QUANTITIES)
    with progress_bar("pictures") as report:
        for done, (k, quantity) in enumerate((k, q) for k in range(len(found.pressure)) for q in QUANTITIES):
            write_png(draw_step(film, k, quantity), folder / f"{quantity}-{k:03d}.png")
            report(done + 1, total)
        if found.pressure[-1] > 0:
            write_filmstrip(folder, folder / "filmstrip.png")


def _analytic(found: FeBend) -> Bend:
    """Bend the same joint by the analytic model as described: with friction, on the way up, as `fe compare` does."""
    path = np.linspace(0, max(float(found.pressure[-1]), 1.0), SMOOTH)
    return bend(found.robot, found.joint, path, side=found.side, material=found.material)


def _plot(found: FeBend, plot: str) -> None:
    """Draw a bend beside the analytic model's; what draws is imported only now, because that takes long."""
    from hypertuna.fe.plots import plot_fe_bend
    from hypertuna.figures import save

    other = _analytic(found)
    group = next(group for group in found.robot.joints if group.name == found.joint)
    most, farthest = group.pressure_max, group.bend_max
    figure = plot_fe_bend(
        found.pressure,
        found.angle,
        oil_taken(found),
        title=f"{found.robot.name}, joint {found.joint}, {found.side} side, material set {found.material}",
        analytic=(other.pressure, other.angle, other.volume),
        published=None if most is None or farthest is None else (most, farthest),
    )
    save(figure, plot)


def _print(found: FeBend, record: dict[str, Any]) -> None:
    """Print a bend as a table, a row for each pressure."""
    console, options = Console(), found.options
    head = f"{found.robot.name}: joint {found.joint}, {found.side} side, material set {found.material}, {options.law}"
    console.print(Text(head, style="bold"))
    size = f"{record['mesh']} mesh, {found.elements} elements, {found.unknowns} unknowns, {record['seconds']:.0f} s"
    console.print(Text(f"{size}, Poisson's ratio {options.poisson:g}{', mixed' if options.mixed else ''}", style="dim"))
    table = Table(box=None, pad_edge=False, collapse_padding=True, header_style="bold")
    for title, _ in COLUMNS.values():
        table.add_column(Text(title, justify="right"), justify="right")
    for step in record["steps"]:
        table.add_row(*(f"{step[key]:{form}}" for key, (_, form) in COLUMNS.items()))
    console.print(table)
    console.print(Text(LEGEND, style="dim"))
    squared = found.r_squared()
    if np.isfinite(squared):
        console.print(Text(f"line over 100 to 250 kPa: R^2 = {squared:.4f}"))
    console.print(Text(found.status_text, style="green" if found.status == "converged" else "bold red"))


fe_app.command("compare")(compare_command)
fe_app.command("reduce")(reduce_command)
