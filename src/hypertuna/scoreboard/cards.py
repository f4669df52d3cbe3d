"""What notebooks and shells show of a scoreboard."""

from hypertuna.display import Card, facts_of, number
from hypertuna.pictures import computed_svg
from hypertuna.scoreboard.scores import UNITS, Scoreboard


def scoreboard_card(board: Scoreboard) -> Card:
    """Show what the scores say, and a row for each."""
    rows = [
        (
            f"{score.swimmer}, {score.run}",
            score.entry.published_text,
            number(score.predicted, UNITS[score.quantity]),
            number(score.ratio),
            number(score.own / score.published),
        )
        for score in board.scores
    ]
    columns = ("swimmer, run", "published", "predicted", "ratio", "own sections")
    pairs = [(score.published, score.predicted) for score in board.speeds]
    return Card(
        "Published swimmers, predicted",
        facts_of(board.summary()),
        "",
        columns,
        rows,
        lambda: computed_svg(pairs, "speed [m/s]", "a run of a swimmer"),
    )
