"""The command `hypertuna scoreboard`."""

from typing import Annotated

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.display import card_of
from hypertuna.scoreboard.scoreboard import score_swimmers
from hypertuna.scoreboard.scores import Scoreboard
from hypertuna.scoreboard.swimmers import swimmers


def _offered(incomplete: str) -> list[str]:
    """Return the swimmers and .toml files whose names begin with the incomplete one."""
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
    output: Annotated[str | None, opt.file("--output", "the numbers", ".csv")] = None,
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
        lines=lambda board: card_of(board).parts,
        output=output,
        columns=[str(name) for name in board.dataset().data_vars],
        plot=plot,
        as_json=as_json,
    )
