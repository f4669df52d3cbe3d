"""The commands `hypertuna firmware params | faults`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna import _core
from hypertuna.cli.old_console import check_suffix, command_line, print_json, tell_written
from hypertuna.cli.old_options import AsJson, Name
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.firmware.parameters import FirmwareTable, firmware_table, header
from hypertuna.io.files import write_atomically

__all__ = ["firmware_app"]

firmware_app = typer.Typer(
    no_args_is_help=True, help="Firmware: its parameters from a robot's description, its faults."
)


@firmware_app.command()
def params(
    robot: Name,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", help="Write the C++ header for the firmware to this .hpp file."),
    ] = None,
    check: Annotated[
        str | None, typer.Option("--check", help="Compare this .hpp file with what would be written; 1 if it differs.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List what the radio may set on a robot, and write all that its firmware is made with.

    firmware/robots/NAME.hpp is the place that `make firmware ROBOT=NAME` looks in.
    """
    check_suffix(output, (".hpp",), "--output")
    table = firmware_table(load(robot))
    if output is not None:
        write_atomically(output, header(table).encode())
    if as_json:
        print_json(_record(table))
    elif output is None and check is None:
        _print(table)
    else:
        tell_written(output)
    if check is None:
        return
    if Path(check).read_text() != header(table):
        typer.echo(
            f"{check} differs: write it anew with hypertuna firmware params --robot {robot} -o {check}", err=True
        )
        raise typer.Exit(1)
    if not as_json:
        print(f"{check} is what the description makes")


@firmware_app.command()
def faults(as_json: AsJson = False) -> None:
    """List the faults that the supervisor on board knows, and how the robot answers to each."""
    keys = ("name", "sentence", "answer", "latched", "forbids_arming")
    rows: list[dict[str, Any]] = [dict(zip(keys, row, strict=True)) for row in _core.fault_table()]
    if as_json:
        print_json({"faults": rows})
        return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for head in ("fault", "what it means", "answer", "remembered", "forbids arming"):
        table.add_column(head)
    for row in rows:
        yes = ["yes" if row[key] else "" for key in ("latched", "forbids_arming")]
        table.add_row(row["name"], row["sentence"], row["answer"], *yes)
    Console().print(table)


def _record(table: FirmwareTable) -> dict[str, Any]:
    """Tell a robot's table, for programs."""
    return {
        "numbers": len(table.values),
        "layout": f"{table.layout:08x}",
        "parameters": [
            {"name": p.name, "low": p.low, "high": p.high, "value": p.standard, "whole": p.whole}
            | dict(zip(("part", "column", "index"), table.fields[p.field], strict=True))
            for p in table.parameters
        ],
        "command": command_line(),
    } | provenance(table.robot)


def _print(table: FirmwareTable) -> None:
    """Print the parameters as a table."""
    rows = Table(box=None, pad_edge=False, header_style="bold")
    rows.add_column("parameter")
    for head in ("value", "low", "high"):
        rows.add_column(head, justify="right")
    rows.add_column("of")
    for p in table.parameters:
        part, column, index = table.fields[p.field]
        rows.add_row(p.name, f"{p.standard:.6g}", f"{p.low:.6g}", f"{p.high:.6g}", f"{part} {column}[{index}]")
    console = Console()
    told = f"{table.robot.name}: {len(table.values)} numbers on board, {len(table.parameters)} of them parameters (SI)"
    console.print(Text(told, style="bold"))
    console.print(rows)
