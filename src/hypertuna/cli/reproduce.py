"""The command `hypertuna reproduce`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import print_json, progress_bar
from hypertuna.paper.ledger import MARKS, Entry
from hypertuna.paper.reproduce import Ledger, ledger_record, reproduce

__all__ = ["reproduce_command"]

STYLES = {"reproduced": "green", "deviates": "yellow", "contradicted": "bold red"} | dict.fromkeys(
    ("undetermined", "not-computed"), "dim"
)


def reproduce_command(
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write index.html, ledger.json and the plots to this folder.")
    ] = None,
    full: Annotated[
        bool,
        typer.Option(
            "--full",
            help="Also under the areas as Table II prints them, fits from more starts, the twin with other oil lines, "
            "finite elements anew.",
        ),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Compute the paper's numbers beside the published ones."""
    with progress_bar("computing") as progress:
        ledger = reproduce(full=full, progress=progress)
    page = None if output is None else _write(ledger, output)
    if as_json:
        print_json(ledger_record(ledger))
        return
    _print(ledger)
    if page is not None:
        Console().print(Text(f"The page: {page}", style="bold"))


def _write(ledger: Ledger, output: str) -> Path:
    """Write the page; what draws it is imported only now."""
    from hypertuna.paper.page import write_ledger

    return write_ledger(ledger, output)


def _print(ledger: Ledger) -> None:
    """Print the ledger: a row for each number, a column for each model; then what no model computes, and the sums."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("number", no_wrap=True)
    table.add_column("published", justify="right", no_wrap=True)
    models = list(ledger.summary["speeds"])
    for model in models:
        table.add_column(model, no_wrap=len(models) < 4)
    rows: dict[str, dict[str, Entry]] = {}
    for entry in ledger.entries:
        rows.setdefault(entry.id, {})[entry.model] = entry
    for key, row in rows.items():
        any_entry = next(iter(row.values()))
        cells = [_answer(row[model]) if model in row else Text() for model in models]
        if any(cells):
            table.add_row(key, any_entry.told, *cells)
    console = Console()
    console.print(table)
    console.print()
    for entry in ledger.entries:
        if entry.model not in models:
            told = f" {entry.id}, {entry.told}; {entry.model}: "
            console.print(Text.assemble(_answer(entry), told, (f"{entry.note}.", "dim")))
    console.print()
    for model, errors in ledger.summary["speeds"].items():
        console.print(
            f"Eight speeds, {model}: rms error {100 * errors['rms_relative_error']:.1f} %, "
            f"largest {100 * errors['largest_relative_error']:.1f} %.",
            highlight=False,
        )
    console.print(
        Text(", ").join(
            Text(f"{MARKS[verdict]} {count} {verdict}", style=STYLES[verdict])
            for verdict, count in ledger.summary["verdicts"].items()
        )
    )


def _answer(entry: Entry) -> Text:
    """Write what was computed, with its error and the mark of its verdict."""
    error = f" ({entry.error})" if entry.error else ""
    return Text(f"{MARKS[entry.verdict]} {entry.answer}{error}".rstrip(), style=STYLES[entry.verdict])
