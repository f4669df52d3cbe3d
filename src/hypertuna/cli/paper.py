"""The command `hypertuna paper`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.options import AsJson
from hypertuna.display import Table
from hypertuna.errors import InputError, shown
from hypertuna.paper.ledger import CLASSES, MARKS, UNPUBLISHED, Entry
from hypertuna.paper.reproduce import Ledger, ledger_record, reproduce

if TYPE_CHECKING:
    from rich.text import Text

# Verdict -> rich's style on the terminal.
STYLES = (
    {"reproduced": "green", "contradicted": "bold red"}
    | dict.fromkeys(("deviates", "violated"), "yellow")
    | dict.fromkeys(("undetermined", "not-computed"), "dim")
    | dict.fromkeys(("agrees", "holds"), "none")
)


def paper_command(
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FOLDER",
            help="Write index.html, ledger.json and the plots to this folder, and print a summary only.",
        ),
    ] = None,
    full: Annotated[
        bool,
        typer.Option(
            "--full",
            help="Add the areas as Table II prints them, fits from more starts and the twin with other oil lines; "
            "recompute the finite elements, the lake and the 32 seeds, whose results are stored.",
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Compute the paper's numbers beside the published ones."""
    if output is not None and Path(output).suffix in (".html", ".json"):
        raise InputError("must be a folder", key="--output", value=shown(output), fix=f"write {Path(output).stem}")
    with progress_bar("computing") as progress:
        ledger = reproduce(full=full, progress=progress)
    if output is None:
        emit(ledger, record=ledger_record, lines=_lines, as_json=as_json)
    else:
        from hypertuna.paper.page import write_ledger

        page = write_ledger(ledger, output).resolve().as_uri()
        emit(ledger, record=ledger_record, lines=_brief, as_json=as_json)
        if not as_json:
            typer.echo(f"The page: {page}")  # on one line, so that terminals make it a link


def _brief(ledger: Ledger) -> Iterator[str]:
    """Yield two sentences that summarize the ledger."""
    summary = ledger.summary
    reproduced = f"{summary['reproduced']} of {summary['predictions']} predicted numbers are reproduced by a model"
    yield f"The paper's numbers, computed: {len(ledger.entries)} comparisons; {reproduced}."
    errors = (f"{model} {100 * error['rms_relative_error']:.1f} %" for model, error in summary["speeds"].items())
    yield f"Eight speeds, rms error: {'; '.join(errors)}."


def _lines(ledger: Ledger) -> Iterator[Any]:
    """Yield the lines that the terminal prints for the ledger: counts by class, each number, and the models' errors."""
    from rich.text import Text

    summary = ledger.summary
    measured = f"measured numbers among these: {summary['reproduced_measured']}"
    yield f"{summary['predictions']} numbers are predicted, {summary['reproduced']} reproduced by a model; {measured}."
    verdicts = summary["verdicts"].items()
    yield Text(", ").join(Text(f"{MARKS[verdict]} {count} {verdict}", STYLES[verdict]) for verdict, count in verdicts)
    yield ""
    rows = [
        (name, *(str(counts[verdict] or "") for verdict in MARKS), CLASSES[name])
        for name, counts in summary["classes"].items()
    ]
    yield Table(["class", *MARKS.values(), "because"], rows, left=(0, len(MARKS) + 1), fold=len(MARKS) + 1)
    yield ""
    models = list(ledger.summary["speeds"])
    by_id: dict[str, dict[str, Entry]] = {}
    for entry in ledger.entries:
        by_id.setdefault(entry.id, {})[entry.model] = entry
    cells: list[tuple[Any, ...]] = []
    for key, row in by_id.items():
        chosen = [row[model] for model in models if model in row]
        cells += [(Text(key, "bold"), f"  {entry.published_text}", "", "") for entry in chosen[:1]]
        for e in chosen:
            computed = Text(f"{MARKS[e.verdict]} {e.computed_text}", STYLES[e.verdict])
            cells.append((f"  {e.model}", computed, e.error, e.seeds_text))
            if e.band is not None:
                cells.append(("    90 % of the family", f"  {e.band_text}", "", ""))
    heads = ["number\n  model", "  published\n  computed", "\nerror", "seeds\nagree"]
    yield Table(heads, cells, left=(0, 1))
    yield f"{MARKS['undetermined']} above a range of the family: {UNPUBLISHED}."
    yield ""
    for e in ledger.entries:
        if e.model not in models:
            published = f", {e.published_text} published: "
            yield Text.assemble(
                (e.id, "bold"), published, _answer(e), f" ({e.model}; {e.class_}): ", (f"{e.note}.", "dim")
            )
    yield ""
    for model, errors in ledger.summary["speeds"].items():
        rms, largest = (100 * errors[f"{key}_relative_error"] for key in ("rms", "largest"))
        yield f"Eight speeds, {model}: rms error {rms:.1f} %, largest {largest:.1f} %."


def _answer(entry: Entry) -> Text:
    """Return a computed number as text, with its verdict's mark, its error, and how many seeds agree."""
    from rich.text import Text

    error = f" ({entry.error})" if entry.error else ""
    seeds = f", {entry.seeds_text} seeds" if entry.seeds_text else ""
    return Text(f"{MARKS[entry.verdict]} {entry.computed_text}{error}{seeds}".rstrip(), style=STYLES[entry.verdict])
