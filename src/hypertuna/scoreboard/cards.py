"""Card of a scoreboard, for terminals and notebooks."""

import math
from collections.abc import Sequence
from typing import Any

from hypertuna.display import Card, Facts, Part, Table, cards, number
from hypertuna.pictures import computed_svg
from hypertuna.scoreboard.scores import Score, Scoreboard


@cards.of(Scoreboard)
def scoreboard_card(board: Scoreboard) -> Card:
    """Show the speeds, then thrusts and powers, then the summary of the predictions."""
    parts: list[Part] = []
    if board.speeds:
        heading = "Speeds in m/s: predicted from length, mass, nose and beat; at the right with own sections"
        parts += [(heading, "bold"), _table(board.speeds), ""]
    if others := [score for score in board.scores if score.quantity != "speed"]:
        title = "Mean thrusts of fish held fixed, and powers beside the predicted mechanical power"
        parts += [(title, "bold"), _table(others, unit=True), ""]
    parts.append(Facts({key: fact for key, fact in board.summary().items() if _is_known(fact.value)}, digits=3))
    parts += [(f"{score.swimmer}, {score.run}: {score.note}", "yellow") for score in board.scores if score.note]
    pairs = [(score.published, score.predicted) for score in board.speeds]
    picture = (lambda: computed_svg(pairs, "speed [m/s]", "a run of a swimmer")) if pairs else None
    return Card("Published swimmers, predicted", parts, picture)


def _table(scores: Sequence[Score], *, unit: bool = False) -> Table:
    """Return a table of scores, a row each."""
    heads = ["swimmer, run", "published", "predicted", "90 % band", "ratio", "own\nratio"]
    rows = []
    for score in scores:
        name = f"{score.swimmer}, {score.run}" + f", {score.quantity}" * unit
        published = score.entry.published_text if unit else number(score.published)
        band = "" if score.band is None else " to ".join(map(number, score.band))
        style = "none" if not band else "green" if score.inside else "yellow"
        own_ratio = _ratio_text(score.own / score.published)
        rows.append([name, published, number(score.predicted), band, (_ratio_text(score.ratio), style), own_ratio])
    return Table(heads, rows, fold=0)


def _ratio_text(value: float) -> str:
    """Return the text of a ratio; empty for NaN."""
    return f"{value:.2f}" if _is_known(value) else ""


def _is_known(value: Any) -> bool:
    """Return whether a value is not NaN."""
    return not (isinstance(value, float) and math.isnan(value))
