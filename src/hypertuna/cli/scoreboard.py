"""The command `hypertuna scoreboard`."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar, summary_table, table
from hypertuna.cli.emit import emit
from hypertuna.display import number
from hypertuna.scoreboard.scoreboard import score_swimmers
from hypertuna.scoreboard.scores import Score, Scoreboard
from hypertuna.scoreboard.swimmers import swimmers


def _offered(incomplete: str) -> list[str]:
    """Return the swimmers that a name may become, and files."""
    return [*opt.starting(swimmers(), incomplete), *opt.offered_files(incomplete, (".toml",))]


def scoreboard_command(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SWIMMER",
            help="Swimmers that come with hypertuna, or paths of .toml files. (default: all that come with it)",
            autocompletion=_offered,
        ),
    ] = None,
    plot: opt.Plot = None,
    output: Annotated[
        str | None,
        opt.file("-o", "--output", help="Write the numbers to this .csv file.", suffixes=(".csv",)),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Predict published swimmers as `hypertuna robot new` describes them, and compare with what they did.

    The exit code is 0, or 2 for bad input.
    """
    with progress_bar("predicting swimmers") as progress:
        board = score_swimmers(names or (), progress=progress)
    emit(
        board,
        record=Scoreboard.record,
        lines=_lines,
        output=output,
        columns=[str(name) for name in board.dataset().data_vars],
        plot=plot,
        figure="hypertuna.scoreboard.plots:plot_scoreboard",
        as_json=as_json,
    )


def _lines(board: Scoreboard) -> Iterator[Any]:
    """Lay out the speeds, then thrusts and powers, then what they say."""
    if board.speeds:
        yield "Speeds in m/s: predicted from length, mass, nose and beat; at the right with own sections", "bold"
        yield _table(board.speeds)
        yield ""
    others = [score for score in board.scores if score.quantity != "speed"]
    if others:
        yield "Mean thrusts of fish held fixed, and powers beside the predicted mechanical power", "bold"
        yield _table(others, unit=True)
        yield ""
    yield summary_table({key: one for key, one in board.summary().items() if _known(one.value)}, digits=3)
    for score in board.scores:
        if score.note:
            yield f"{score.swimmer}, {score.run}: {score.note}", "yellow"


def _table(scores: Sequence[Score], *, unit: bool = False) -> Any:
    """Lay out scores, a line each."""
    heads = ["swimmer, run", "published", "predicted", "90 % band", "ratio", "own\nratio"]
    rows = []
    for score in scores:
        name = f"{score.swimmer}, {score.run}" + f", {score.quantity}" * unit
        published = score.entry.published_text if unit else number(score.published)
        band = "" if score.band is None else " to ".join(map(number, score.band))
        style = "none" if not band else "green" if score.inside else "yellow"
        own = _ratio(score.own / score.published)
        rows.append([name, published, number(score.predicted), band, (_ratio(score.ratio), style), own])
    return table(heads, rows, fold=0)


def _ratio(value: float) -> str:
    """Write a ratio; nothing for NaN."""
    return f"{value:.2f}" if _known(value) else ""


def _known(value: Any) -> bool:
    """Whether a value is no NaN."""
    return not (isinstance(value, float) and math.isnan(value))
