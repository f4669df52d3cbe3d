"""The commands `hypertuna fe ...`: the soft joints by finite elements."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, json_text, progress_bar, run_folder
from hypertuna.cli.elements import BEND_PRESSURES, Elements, rising
from hypertuna.cli.emit import emit
from hypertuna.cli.fe_map import map_command
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Table
from hypertuna.fe.bend import JOURNAL, SUMMARY, FeBend, fe_bend
from hypertuna.fe.cards import outcome
from hypertuna.fe.comparison import compare
from hypertuna.fe.extra import need_fe, need_screenless
from hypertuna.fe.fields import write_vtu
from hypertuna.fe.geometry import DRAWINGS, JointBody, joint_body, write_geometry
from hypertuna.fe.measure import Measured
from hypertuna.fe.model import FeModel
from hypertuna.io.files import rows_csv, write_atomically, write_netcdf
from hypertuna.io.quantity import counted

fe_app = opt.group("The soft joints by finite elements; needs the extra fe.")

COMPARISON_PRESSURES: Any = "50:250:5"  # default of --pressure [kPa], as typed
COMPARISON = "compare.json"  # file with the JSON record, in the folder of a comparison


def _folder(content: str) -> Any:
    """Declare --output as the folder of a run; content: what the folder holds, for the help."""
    return typer.Option("-o", "--output", metavar="FOLDER", help=f"Folder of the run: {content}")


@fe_app.command("geometry")
@opt.grouped
def geometry_command(
    robot: opt.RobotOptions,
    joint: opt.Joint,
    output: Annotated[str | None, opt.file("--output", "the body, in mm,", *DRAWINGS)] = None,
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
    """Yield the lines that the terminal prints for a body: its sections [mm] and its channels."""
    sections = zip(body.stations, body.semi_major, body.semi_minor, strict=True)
    rows = [[f"{1e3 * value:.2f}" for value in section] for section in sections]
    channels = f"{counted(len(body.channels) // 2, 'pair')} of channels of {2 * 1e3 * body.radius:.4g} mm"
    yield f"{robot.name}: soft body of joint {body.name}", "bold"
    yield Table(["x\n[mm]", "half height\n[mm]", "half width\n[mm]"], rows, left=())
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
    no_pictures: Annotated[bool, opt.flag("--no-pictures", "Write no PNG pictures.")] = False,
    as_json: opt.AsJson = False,
) -> None:
    """Bend a soft joint by finite elements: bend, oil, stretches, strain and stress at every pressure.

    The exit code is 0 if all pressures were reached, 1 if one was not (those before it are printed and kept), 2 for
    bad input.
    """
    fish = robot.load()
    index, path = joint_index(joint, fish), rising(pressure)
    joint_body(fish, index)  # finds errors of the description before a missing extra
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
        plot=plot,
        written=(output,),
        as_json=as_json,
        failed=bent.status != "converged",
    )


def _write(bent: FeBend, folder: Path, *, pictures: bool) -> None:
    """Write the numbers of a run into its folder, and its pictures if wanted."""
    record = bent.record() | {"command": command_line()}
    write_atomically(folder / SUMMARY, f"{json_text(record)}\n".encode())
    rows_csv({}, record["steps"]).write(folder / "bend.csv")
    write_netcdf(bent.dataset().assign_attrs(command=command_line()), folder / "bend.nc")
    if pictures and len(bent.pressure):
        from hypertuna.fe.pictures import write_pictures

        with progress_bar("pictures") as report:
            write_pictures(folder, progress=report)


@fe_app.command("compare")
@opt.grouped
def compare_command(
    robot: opt.RobotOptions,
    joint: opt.Joint,
    elements: Elements,
    pressure: opt.Pressures = COMPARISON_PRESSURES,
    reasons: Annotated[
        bool,
        opt.flag(
            "--reasons", "Turn the fast model into finite elements step by step, and print the bend after each step."
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
    if not len(bent.pressure):  # no pressure was reached: nothing to compare
        run_record = bent.record() | {"command": command_line()}
        emit(bent, record=lambda _: run_record, lines=lambda bent: [outcome(bent)], as_json=as_json, failed=True)
    comparison = compare(bent, reasons=reasons)
    record = comparison.record() | {"command": command_line()}
    written = None if folder is None else str(folder / COMPARISON)
    if written is not None:
        write_atomically(written, f"{json_text(record)}\n".encode())
    emit(
        comparison,
        record=lambda _: record,
        written=(written,),
        as_json=as_json,
        failed=bent.status != "converged",
    )


fe_app.command("map")(map_command)
