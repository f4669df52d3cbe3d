"""The command `hypertuna fe compare`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, json_text, print_json, print_lines, progress_bar, run_folder, table
from hypertuna.cli.emit import emit
from hypertuna.cli.fe.options import Law, Material, Mesh, Mixed, Poisson, rising
from hypertuna.description.robot import load
from hypertuna.fe.bend import JOURNAL, fe_bend
from hypertuna.fe.comparison import FeComparison, compare
from hypertuna.fe.model import FeOptions
from hypertuna.fe.record import bend_record
from hypertuna.io.files import write_atomically

PRESSURES: Any = "50:250:5"  # kPa, as typed
SUMMARY = "compare.json"
COLUMNS = {  # of the table: head and format
    "pressure_kpa": ("gauge\n[kPa]", ".4g"),
    "bend_fe_deg": ("bend FE\n[deg]", "z.2f"),
    "bend_analytic_deg": ("model\n[deg]", "z.2f"),
    "bend_difference_percent": ("differs\n[%]", "+z.1f"),
    "oil_fe_ml": ("oil FE\n[ml]", "z.3f"),
    "oil_analytic_ml": ("model\n[ml]", "z.3f"),
    "oil_difference_percent": ("differs\n[%]", "+z.1f"),
    "shortening_percent": ("shorter\n[%]", "z.1f"),
}
LEGEND = (
    "Bend, and oil taken in since rest, of the side under pressure: by finite elements (FE), without friction; by the "
    "analytic model, with the friction of the description, loading; and the difference of the model from FE. In FE the "
    "axis shortens; in the model it keeps its length."
)


def compare_command(
    robot: opt.RobotName,
    joint: opt.Joint,
    pressure: opt.Pressures = PRESSURES,
    side: opt.Side = "left",
    material: Material = None,
    law: Law = FeOptions.law,
    poisson: Poisson = FeOptions.poisson,
    mixed: Mixed = FeOptions.mixed,
    mesh: Mesh = FeOptions.mesh,
    reasons: Annotated[
        bool,
        typer.Option(
            "--reasons",
            help="Turn the analytic model into finite elements step by step, and print the bend after each step.",
        ),
    ] = False,
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            help=f"Folder for journal, states and {SUMMARY}; the same command resumes after the last pressure there.",
        ),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Compare the analytic model of a soft joint with finite elements, on the same geometry.

    The exit code is 0 if all pressures were reached, 1 if one was not (those before it are printed), 2 for bad input.
    """
    fish = load(robot)
    index, path = joint_index(joint, fish), rising(pressure)
    options = FeOptions(material, law, poisson, mesh, mixed)
    with run_folder(output, JOURNAL) as folder, progress_bar("pressures", patience=0, lines=True) as report:
        report(0, len(path))
        bent = fe_bend(fish, index, path, side=side, options=options, folder=folder, progress=report, work="fe compare")
    if not len(bent.pressure):  # and so nothing to compare
        if as_json:
            print_json(bend_record(bent) | {"command": command_line()})
        else:
            print_lines([(bent.status_text, "bold red")])
        raise typer.Exit(1)
    comparison = compare(bent, reasons=reasons)
    written = None if folder is None else str(folder / SUMMARY)
    if written is not None:
        write_atomically(written, f"{json_text(_record(comparison))}\n".encode())
    failed = bent.status != "converged"
    emit(comparison, record=_record, lines=_lines, written=(written,), as_json=as_json, failed=failed)


def _record(compared: FeComparison) -> dict[str, Any]:
    """Return the JSON record."""
    bent, other = compared.fe, compared.analytic
    columns = {
        "pressure_kpa": bent.pressure / 1e3,
        "bend_fe_deg": np.degrees(bent.angle),
        "bend_analytic_deg": np.degrees(other.angle),
        "bend_difference_percent": 100 * compared.difference,
        "oil_fe_ml": 1e6 * compared.oil,
        "oil_analytic_ml": 1e6 * other.volume,
        "oil_difference_percent": 100 * compared.oil_difference,
        "shortening_percent": 100 * compared.shortening,
    }
    rows = [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
    kept = {key: value for key, value in bend_record(bent).items() if key not in ("steps", "r_squared")}
    return kept | {
        "friction": other.friction,
        "r_squared_fe": bent.r_squared(),
        "r_squared_analytic": other.r_squared(),
        "steps": rows,
        "reasons": [{"text": reason.text, "bend_deg": math.degrees(reason.angle)} for reason in compared.reasons],
        "command": command_line(),
    }


def _lines(compared: FeComparison) -> Iterator[Any]:
    """Lay out a comparison."""
    bent, record = compared.fe, _record(compared)
    yield f"{bent.robot.name}: joint {bent.joint}, {bent.side} side, material set {bent.material}", "bold"
    yield f"{record['mesh']} mesh, {bent.elements} elements, {record['seconds']:.0f} s", "dim"
    rows = []
    for step in record["steps"]:
        cells = ((step[key], form) for key, (_, form) in COLUMNS.items())
        rows.append(["" if math.isnan(value) else f"{value:{form}}" for value, form in cells])
    yield table([head for head, _ in COLUMNS.values()], rows, left=(), collapse_padding=True)
    yield LEGEND, "dim"
    squares = (bent.r_squared(), compared.analytic.r_squared())
    if np.isfinite(squares).all():
        yield f"line over 100 to 250 kPa: R^2 = {squares[0]:.4f} (FE), {squares[1]:.4f} (analytic)"
    if compared.reasons:
        yield f"From the analytic model to finite elements, {bent.pressure[-1] / 1e3:g} kPa:"
        angles = [reason["bend_deg"] for reason in record["reasons"]]
        rows = []
        for reason, before, angle in zip(record["reasons"], [math.nan, *angles], angles, strict=False):
            change = "" if math.isnan(angle - before) else f"{angle - before:+.2f}"
            rows.append([reason["text"], "not found" if math.isnan(angle) else f"{angle:.2f}", change])
        yield table(["", "bend\n[deg]", "change\n[deg]"], rows, collapse_padding=True)
    yield bent.status_text, "green" if bent.status == "converged" else "bold red"
