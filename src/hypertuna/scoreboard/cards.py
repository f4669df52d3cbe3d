"""What notebooks and shells show of a scoreboard."""

from hypertuna.display import Card, facts_of, number
from hypertuna.scoreboard.scores import Scoreboard


def scoreboard_card(board: Scoreboard) -> Card:
    """Show what the scores say, and a row for each."""
    rows = [
        (
            f"{score.swimmer}, {score.run}",
            score.entry.published_text,
            score.entry.computed_text,
            number(score.ratio),
            number(score.own / score.published),
        )
        for score in board.scores
    ]
    columns = ("swimmer, run", "published", "predicted", "ratio", "own sections")
    return Card("Published swimmers, predicted", facts_of(board.summary()), "", columns, rows)
