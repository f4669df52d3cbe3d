"""Compare the finite elements with theory: McKibben tubes, hoses of solid elements, a clamped beam, cubes, a joint.

    python validation/fe/validate.py [--robot NAME] [--json]

The exit code is 0 if all cases agree, 1 if one does not. It takes a minute of one core.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import sys
import time
from collections.abc import Sequence
from typing import Literal

from fe_cases import Case, validate
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.errors import InputError

HEADS = ("computed", "theory", "unit", "difference\n[%]", "allowed\n[%]", "")  # of the table's columns


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--robot", default="hypertuna", help="robot with the hose, braid angle and silicones to use")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args(arguments)
    try:
        robot, start = load(options.robot), time.process_time()
        cases = validate(robot)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if options.json:
        facts = {
            "command": "python validation/fe/validate.py --json",
            "ngsolve_version": importlib.metadata.version("ngsolve"),
        }
        records = [vars(case) | {"difference": case.difference, "passed": case.passed} for case in cases]
        print(json.dumps(provenance(robot, water=False) | facts | {"cases": records}, indent=2))
    else:
        _print(cases, time.process_time() - start)
    return 0 if all(case.passed for case in cases) else 1


def _print(cases: Sequence[Case], seconds: float) -> None:
    """Print the cases below the headings of their groups."""
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
    failures = sum(not case.passed for case in cases)
    text = f"{failures} of {len(cases)} cases disagree" if failures else f"all {len(cases)} cases agree"
    style = "bold red" if failures else "green"
    console.print(Text(f"{text}; {seconds:.0f} s. Elements of order 1 must lock.", style=style))


if __name__ == "__main__":
    raise SystemExit(main())
