"""The command `hypertuna fe validate`."""

from __future__ import annotations

import importlib.metadata
import time
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import command_line, print_json, progress_bar
from hypertuna.cli.old_options import AsJson
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.fe.verification.cases import Case, validate

__all__ = ["validate_command"]

HEADS = ("computed", "theory", "unit", "off by\n[%]", "may be\n[%]", "")


def validate_command(
    robot: Annotated[
        str, typer.Option("--robot", help="Name or file of the robot whose hose, braid angle and silicones are taken.")
    ] = "hypertuna",
    as_json: AsJson = False,
) -> None:
    """Compare the finite elements with what theory knows: McKibben tubes, a clamped beam, cubes.

    The exit code is 0 where all agree, 1 where one does not, 2 for bad input.
    """
    fish, start = load(robot), time.process_time()
    with progress_bar("cases") as report:
        cases = validate(fish, report)
    seconds = time.process_time() - start
    if as_json:
        facts = {"command": command_line(), "ngsolve_version": importlib.metadata.version("ngsolve")}
        print_json(provenance(fish, water=False) | facts | {"cases": [_record(case) for case in cases]})
    else:
        _print(cases, seconds)
    if not all(case.passed for case in cases):
        raise typer.Exit(1)


def _record(case: Case) -> dict[str, Any]:
    """Tell a case, for programs."""
    return vars(case) | {"difference": case.difference, "passed": case.passed}


def _print(cases: Sequence[Case], seconds: float) -> None:
    """Print the cases, below the headings of their groups."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("")
    for head in HEADS:
        justify: Literal["left", "right"] = "left" if head in ("unit", "") else "right"
        table.add_column(Text(head, justify=justify), justify=justify)
    group = ""
    for case in cases:
        if case.group != group:
            group = case.group
            table.add_row(Text(group, style="bold"))
        bound = f"{'over ' if case.locks else ''}{100 * case.tolerance:g}"
        verdict = Text("yes", style="green") if case.passed else Text(f"NO {case.text}".strip(), style="bold red")
        numbers = (f"{case.computed:.5g}", f"{case.theory:.5g}", case.unit, f"{100 * case.difference:+.3f}", bound)
        table.add_row(f"  {case.name}", *numbers, verdict)
    console = Console()
    console.print(table)
    off = sum(not case.passed for case in cases)
    text = f"{off} of {len(cases)} cases are off" if off else f"all {len(cases)} cases agree"
    console.print(
        Text(f"{text}; {seconds:.0f} s. Elements of order 1 must lock.", style="bold red" if off else "green")
    )
