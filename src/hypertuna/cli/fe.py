"""The commands `hypertuna fe ...`: the soft joints by finite elements."""

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.actuation.bending import bend
from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, json_text, progress_bar, run_folder, table
from hypertuna.cli.elements import BEND_PRESSURES, Elements, rising
from hypertuna.cli.emit import emit
from hypertuna.cli.fe_map import map_command
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.fe.bend import JOURNAL, SUMMARY, FeBend, described_bend, fe_bend
from hypertuna.fe.comparison import FeComparison, compare
from hypertuna.fe.extra import need_fe, need_screenless
from hypertuna.fe.fields import write_vtu
from hypertuna.fe.geometry import DRAWINGS, JointBody, joint_body, write_geometry
from hypertuna.fe.measure import Measured
from hypertuna.fe.model import FeModel
from hypertuna.io.files import rows_csv, write_atomically, write_netcdf
from hypertuna.io.quantity import counted

fe_app = opt.group("The soft joints by finite elements; needs the extra fe.")

COMPARISON_PRESSURES: Any = "50:250:5"
SMOOTH = 50  # pressures of the fast model's curve
COMPARISON = "compare.json"  # file of the record in the folder of a comparison


def _folder(content: str) -> Any:
    """Declare the option of the folder of a run."""
    return typer.Option("-o", "--output", metavar="FOLDER", help=f"Folder of the run: {content}")


# Columns of the tables: head and format.
BEND_COLUMNS = {
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
BEND_LEGEND = (
    "Bend, and oil since rest, of the side under pressure; stretches of the channels' walls and of the braids; "
    "logarithmic strain and von Mises stress of the matrix: the 99th percentile, and the maximum, which sits where "
    "hoses end and grows as meshes get finer."
)
COMPARISON_COLUMNS = {
    "pressure_kpa": ("gauge\n[kPa]", ".4g"),
    "bend_fe_deg": ("bend FE\n[deg]", "z.2f"),
    "bend_analytic_deg": ("model\n[deg]", "z.2f"),
    "bend_difference_percent": ("differs\n[%]", "+z.1f"),
    "oil_fe_ml": ("oil FE\n[ml]", "z.3f"),
    "oil_analytic_ml": ("model\n[ml]", "z.3f"),
    "oil_difference_percent": ("differs\n[%]", "+z.1f"),
    "shortening_percent": ("shorter FE\n[%]", "z.1f"),
    "shortening_analytic_percent": ("model\n[%]", "z.1f"),
}
COMPARISON_LEGEND = (
    "Bend, and oil taken in since rest, of the side under pressure, and shortening of the axis: by finite elements "
    "(FE), without friction; by the fast model, with the friction of the description, loading; and the difference of "
    "the model from FE."
)


@fe_app.command("geometry")
@opt.grouped
def geometry_command(
    robot: opt.RobotOptions,
    joint: opt.Joint,
    output: Annotated[
        str | None,
        opt.file("-o", "--output", help="Write the body to this .step, .stp or .stl file, in mm.", suffixes=DRAWINGS),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Build the soft body of a joint from its description: sections, channels, plates."""
    fish = robot.load()
    body = joint_body(fish, joint_index(joint, fish))
    if output is not None:
        write_geometry(body, output)
    emit(
        body,
        record=lambda body: provenance(fish, water=False) | body.record() | {"command": command_line(), "file": output},
        lines=lambda body: _geometry_lines(fish, body),
        written=(output,),
        as_json=as_json,
    )


def _geometry_lines(robot: Robot, body: JointBody) -> Iterator[Any]:
    """Lay out the sections of a body."""
    sections = zip(body.stations, body.semi_major, body.semi_minor, strict=True)
    rows = ([f"{1e3 * value:.2f}" for value in section] for section in sections)
    channels = f"{counted(len(body.channels) // 2, 'pair')} of channels of {2 * 1e3 * body.radius:.4g} mm"
    yield f"{robot.name}: soft body of joint {body.name}", "bold"
    yield table(["x\n[mm]", "half height\n[mm]", "half width\n[mm]"], rows, left=())
    yield f"{channels}, {1e3 * abs(body.channels[0].y):.4g} mm from the middle"
    yield f"matrix {1e9 * body.volume:.4g} mm^3, plates {1e3 * body.plate:.3g} mm thick"
    if body.axis:
        yield f"a strip {1e3 * body.axis:.3g} mm wide holds the axis"


@fe_app.command("bend")
@opt.grouped
def bend_command(
    robot: opt.RobotOptions,
    joint: opt.Joint,
    elements: Elements,
    pressure: opt.Pressures = BEND_PRESSURES,
    side: opt.Side = "left",
    plot: opt.Plot = None,
    output: Annotated[
        str | None,
        _folder(
            "journal, fields (VTU) and pictures (PNG) of every pressure, bend.json, .csv and .nc. The same command "
            "resumes after the last pressure that is there."
        ),
    ] = None,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Write no PNG pictures.")] = False,
    as_json: opt.AsJson = False,
) -> None:
    """Bend a soft joint by finite elements: bend, oil, stretches, strain and stress at every pressure.

    The exit code is 0 if all pressures were reached, 1 if one was not (those before it are printed and kept), 2 for
    bad input.
    """
    fish = robot.load()
    index, path = joint_index(joint, fish), rising(pressure)
    joint_body(fish, index)  # checks the description before the machine
    need_fe()
    if output is not None and not no_pictures:
        need_screenless()
    with run_folder(output, JOURNAL) as folder, progress_bar("pressures", slow=True) as report:
        report(0, len(path))

        def keep(model: FeModel, k: int, _: Measured) -> None:
            if folder is not None:
                write_vtu(model, folder, k)

        bent = fe_bend(fish, index, path, side=side, options=elements, folder=folder, progress=report, each=keep)
    if folder is not None:
        _write(bent, folder, pictures=not no_pictures)
    plot = plot if len(bent.pressure) else None
    emit(
        bent,
        record=lambda bent: bent.record() | {"command": command_line()},
        lines=_bend_lines,
        plot=plot,
        figure=_figure,
        written=(output,),
        as_json=as_json,
        failed=bent.status != "converged",
    )


def _write(bent: FeBend, folder: Path, *, pictures: bool) -> None:
    """Write the numbers of a run into its folder, and its pictures."""
    record = bent.record() | {"command": command_line()}
    write_atomically(folder / SUMMARY, f"{json_text(record)}\n".encode())
    rows_csv({}, record["steps"]).write(folder / "bend.csv")
    write_netcdf(bent.dataset().assign_attrs(command=command_line()), folder / "bend.nc")
    if pictures and len(bent.pressure):
        from hypertuna.fe.pictures import write_pictures

        with progress_bar("pictures") as report:
            write_pictures(folder, progress=report)


def _figure(bent: FeBend) -> Any:
    """Plot a bend beside that of the fast model, both without friction."""
    from hypertuna.fe.plots import plot_fe_bend  # slow to import

    path = np.linspace(0, max(float(bent.pressure[-1]), 1.0), SMOOTH)
    other = bend(bent.robot, bent.joint, path, side=bent.side, material=bent.material, friction=False)
    title = f"{bent.robot.name}, joint {bent.joint}, {bent.side} side, material set {bent.material}"
    analytic = (other.pressure, other.angle, other.volume)
    described = described_bend(bent.robot, bent.joint)
    return plot_fe_bend(bent.pressure, bent.angle, bent.oil, analytic, described, title)


def _bend_lines(bent: FeBend) -> Iterator[Any]:
    """Lay out a bend, a row for each pressure."""
    options, record = bent.options, bent.record()
    joint = f"{bent.robot.name}: joint {bent.joint}, {bent.side} side"
    size = f"{record['mesh']} mesh, {bent.elements} elements, {bent.unknowns} unknowns, {record['seconds']:.0f} s"
    yield f"{joint}, material set {bent.material}, {options.law}", "bold"
    yield f"{size}, Poisson's ratio {options.poisson:g}", "dim"
    yield _step_table(BEND_COLUMNS, record["steps"])
    yield BEND_LEGEND, "dim"
    if np.isfinite(squared := bent.r_squared()):
        yield f"line over 100 to 250 kPa: R^2 = {squared:.4f}"
    yield _outcome(bent)


def _step_table(columns: Mapping[str, tuple[str, str]], steps: Iterable[Mapping[str, float]]) -> Any:
    """Lay out steps of a record, a row for each; NaN leaves its cell empty."""
    forms = {key: form for key, (_, form) in columns.items()}
    rows = (["" if math.isnan(step[key]) else f"{step[key]:{form}}" for key, form in forms.items()] for step in steps)
    return table([head for head, _ in columns.values()], rows, left=(), collapse_padding=True)


def _outcome(bent: FeBend) -> tuple[str, str]:
    """Return the sentence on a run with its style."""
    return bent.status_text, "green" if bent.status == "converged" else "bold red"


@fe_app.command("compare")
@opt.grouped
def compare_command(
    robot: opt.RobotOptions,
    joint: opt.Joint,
    elements: Elements,
    pressure: opt.Pressures = COMPARISON_PRESSURES,
    reasons: Annotated[
        bool,
        typer.Option(
            "--reasons",
            help="Turn the fast model into finite elements step by step, and print the bend after each step.",
        ),
    ] = False,
    side: opt.Side = "left",
    output: Annotated[
        str | None,
        _folder(f"journal, states and {COMPARISON}. The same command resumes after the last pressure that is there."),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Compare the fast model of a soft joint with finite elements, on the same geometry.

    The exit code is 0 if all pressures were reached, 1 if one was not (those before it are printed), 2 for bad input.
    """
    fish = robot.load()
    index, path = joint_index(joint, fish), rising(pressure)
    with run_folder(output, JOURNAL) as folder, progress_bar("pressures", slow=True) as report:
        report(0, len(path))
        bent = fe_bend(
            fish, index, path, side=side, options=elements, folder=folder, progress=report, work="fe compare"
        )
    if not len(bent.pressure):  # and so nothing to compare
        whole = bent.record() | {"command": command_line()}
        emit(bent, record=lambda _: whole, lines=lambda bent: [_outcome(bent)], as_json=as_json, failed=True)
    comparison = compare(bent, reasons=reasons)
    record = comparison.record() | {"command": command_line()}
    written = None if folder is None else str(folder / COMPARISON)
    if written is not None:
        write_atomically(written, f"{json_text(record)}\n".encode())
    emit(
        comparison,
        record=lambda _: record,
        lines=lambda comparison: _comparison_lines(comparison, record),
        written=(written,),
        as_json=as_json,
        failed=bent.status != "converged",
    )


def _comparison_lines(compared: FeComparison, record: Mapping[str, Any]) -> Iterator[Any]:
    """Lay out a comparison."""
    bent = compared.fe
    yield f"{bent.robot.name}: joint {bent.joint}, {bent.side} side, material set {bent.material}", "bold"
    yield f"{record['mesh']} mesh, {bent.elements} elements, {record['seconds']:.0f} s", "dim"
    yield _step_table(COMPARISON_COLUMNS, record["steps"])
    yield COMPARISON_LEGEND, "dim"
    squares = (bent.r_squared(), compared.analytic.r_squared())
    if np.isfinite(squares).all():
        yield f"line over 100 to 250 kPa: R^2 = {squares[0]:.4f} (FE), {squares[1]:.4f} (fast model)"
    if compared.reasons:
        yield f"From the fast model to finite elements, {bent.pressure[-1] / 1e3:g} kPa:"
        angles = [reason["bend_deg"] for reason in record["reasons"]]
        changes = ["" if math.isnan(change) else f"{change:+.2f}" for change in np.diff([math.nan, *angles])]
        bends = ["not found" if math.isnan(angle) else f"{angle:.2f}" for angle in angles]
        rows = zip((reason.text for reason in compared.reasons), bends, changes, strict=True)
        yield table(["", "bend\n[deg]", "change\n[deg]"], rows, collapse_padding=True)
    yield _outcome(bent)


fe_app.command("map")(map_command)
