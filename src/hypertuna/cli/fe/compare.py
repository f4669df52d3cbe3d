"""The command `hypertuna fe compare`."""

from __future__ import annotations

import json
import math
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.characterization.data import joint_index
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
from hypertuna.cli.old_console import command_line, plain, print_json, progress_bar, run_folder, tell_written
from hypertuna.cli.old_options import AsJson, Joint, Name, Pressure, Side
from hypertuna.description.robot import load
from hypertuna.fe.bend import JOURNAL, fe_bend
from hypertuna.fe.comparison import FeComparison, compare
from hypertuna.fe.record import bend_record
from hypertuna.io.files import write_atomically

__all__ = ["compare_command"]

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
    "Bend, and oil taken in since rest, of the side with the pressure: by finite elements (FE), without friction, and "
    "by the analytic model, with the description's, on the way up; it differs from FE by so much. In FE the axis gets "
    "shorter, along which the model keeps its length."
)


def compare_command(
    robot: Name,
    joint: Joint,
    pressure: Pressure = "50:250:5",
    side: Side = "left",
    material: Material = None,
    law: Law = LAW,
    poisson: Poisson = POISSON,
    mixed: Mixed = MIXED,
    mesh: Mesh = MESH,
    reasons: Annotated[
        bool, typer.Option("--reasons", help="Take the analytic model toward finite elements step by step.")
    ] = False,
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            help=f"Folder for journal, states and {SUMMARY}; the same command goes on after the last pressure there.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compare the analytic model of a soft joint with finite elements, on one and the same geometry.

    The exit code is 0 if all pressures were reached, 1 if one was not (those before it are told), 2 for bad input.
    """
    fish = load(robot)
    index, rising = joint_index(joint, fish), rising_pressures(pressure)
    options = elements(material, law, poisson, mesh, mixed=mixed)
    with run_folder(output, JOURNAL) as folder, progress_bar("pressures", patience=0, lines=True) as report:
        report(0, len(rising))
        found = fe_bend(
            fish, index, rising, side=side, options=options, folder=folder, progress=report, work="fe compare"
        )
    if not len(found.pressure):  # and so nothing to compare
        if as_json:
            print_json(bend_record(found) | {"command": command_line()})
        else:
            Console().print(Text(found.status_text, style="bold red"))
        raise typer.Exit(1)
    compared = compare(found, reasons=reasons)
    record = _record(compared) | {"command": command_line()}
    written = None
    if folder is not None:
        written = str(folder / SUMMARY)
        text = json.dumps(plain(record), indent=2, ensure_ascii=False, allow_nan=False)
        write_atomically(written, f"{text}\n".encode())
    if as_json:
        print_json(record)
    else:
        _print(compared, record)
        tell_written(written)
    if found.status != "converged":
        raise typer.Exit(1)


def _record(compared: FeComparison) -> dict[str, Any]:
    """Tell a comparison, for programs."""
    found, other = compared.fe, compared.analytic
    columns = {
        "pressure_kpa": found.pressure / 1e3,
        "bend_fe_deg": np.degrees(found.angle),
        "bend_analytic_deg": np.degrees(other.angle),
        "bend_difference_percent": 100 * compared.difference,
        "oil_fe_ml": 1e6 * compared.oil,
        "oil_analytic_ml": 1e6 * other.volume,
        "oil_difference_percent": 100 * compared.oil_difference,
        "shortening_percent": 100 * compared.shortening,
    }
    rows = [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
    kept = {key: value for key, value in bend_record(found).items() if key not in ("steps", "r_squared")}
    return kept | {
        "friction": other.friction,
        "r_squared_fe": found.r_squared(),
        "r_squared_analytic": other.r_squared(),
        "steps": rows,
        "reasons": [{"text": reason.text, "bend_deg": math.degrees(reason.angle)} for reason in compared.reasons],
    }


def _print(compared: FeComparison, record: dict[str, Any]) -> None:
    """Print a comparison as tables."""
    console, found = Console(), compared.fe
    head = f"{found.robot.name}: joint {found.joint}, {found.side} side, material set {found.material}"
    console.print(Text(head, style="bold"))
    console.print(Text(f"{record['mesh']} mesh, {found.elements} elements, {record['seconds']:.0f} s", style="dim"))
    table = _table([title for title, _ in COLUMNS.values()])
    for step in record["steps"]:
        cells = ((step[key], form) for key, (_, form) in COLUMNS.items())
        table.add_row(*("" if math.isnan(value) else f"{value:{form}}" for value, form in cells))
    console.print(table)
    console.print(Text(LEGEND, style="dim"))
    squares = (found.r_squared(), compared.analytic.r_squared())
    if np.isfinite(squares).all():
        text = f"line over 100 to 250 kPa: R^2 = {squares[0]:.4f} (FE), {squares[1]:.4f} (analytic)"
        console.print(Text(text))
    if compared.reasons:
        console.print(Text(f"From the analytic model to finite elements, {found.pressure[-1] / 1e3:g} kPa:"))
        steps, before = _table(["", "bend\n[deg]", "change\n[deg]"], left=1), math.nan
        for reason in record["reasons"]:
            angle = reason["bend_deg"]
            change = "" if math.isnan(angle - before) else f"{angle - before:+.2f}"
            steps.add_row(reason["text"], "not found" if math.isnan(angle) else f"{angle:.2f}", change)
            before = angle
        console.print(steps)
    console.print(Text(found.status_text, style="green" if found.status == "converged" else "bold red"))


def _table(titles: list[str], left: int = 0) -> Table:
    """Make an empty table; its first columns are set left."""
    table = Table(box=None, pad_edge=False, collapse_padding=True, header_style="bold")
    for k, title in enumerate(titles):
        table.add_column(Text(title, justify="left" if k < left else "right"), justify="left" if k < left else "right")
    return table
