"""Score predictions: every published swimmer by its first robot, and again with its own sections."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from hypertuna.arguments import checked
from hypertuna.errors import InputError
from hypertuna.scoreboard.fits import Other, other_speeds
from hypertuna.scoreboard.laws import random_shoal
from hypertuna.scoreboard.prediction import Predicted, first_robot, own_robot, predict_runs
from hypertuna.scoreboard.scores import Score, Scoreboard
from hypertuna.scoreboard.swimmers import Run, Swimmer, read_swimmer, swimmers

OUT_OF_REACH = "no amplitude of the default wave reaches the excursion"  # reason why a swimmer has no score


@checked
def score_swimmers(
    names: Sequence[str | Path] = (), *, progress: Callable[[int, int], None] | None = None
) -> Scoreboard:
    """Predict published swimmers from a few numbers that their builders knew, and compare.

    Parameters
    ----------
    names : sequence of str or Path, optional
        Swimmers that come with hypertuna, or paths of TOML files; by default all that come with it.
    progress : callable, optional
        Called with the number of swimmers completed and their total.

    Returns
    -------
    Scoreboard

    Raises
    ------
    InputError
        If a swimmer does not exist, or its file is invalid.

    Examples
    --------
    >>> score_swimmers(["tunabot"]).scores[0].published
    1.02
    """
    chosen = [read_swimmer(name) for name in names or swimmers()]
    scores: list[Score] = []
    others: dict[str, list[Other]] = {}
    for k, swimmer in enumerate(chosen):
        swimmer_scores, other_speeds_found = _score(swimmer)
        scores += swimmer_scores
        others |= {swimmer.name: other_speeds_found} if other_speeds_found else {}
        if progress is not None:
            progress(k + 1, len(chosen))
    return Scoreboard(tuple(scores), others, random_shoal())


def _score(swimmer: Swimmer) -> tuple[list[Score], list[Other]]:
    """Return the scores of a swimmer's runs, and its speeds predicted from one another; a note says why one lacks."""
    runs, note, cross_predictions = swimmer.runs, "", list[Other]()
    by_first = by_own = [Predicted(None)] * len(runs)
    try:
        first, own = first_robot(swimmer), own_robot(swimmer)
        by_first = predict_runs(first, runs)
        by_own = by_own if own is None else predict_runs(own, runs)
        cross_predictions = other_speeds(own or first, runs)
    except InputError as error:
        note = str(error)
    scores: list[Score] = []
    for run, by_robot, by_sections in zip(runs, by_first, by_own, strict=True):
        scores += _scores_of_run(swimmer, run, by_robot, by_sections, note or OUT_OF_REACH * (by_robot.gait is None))
    return scores, cross_predictions


def _scores_of_run(swimmer: Swimmer, run: Run, first: Predicted, own: Predicted, note: str) -> Iterator[Score]:
    """Yield the scores of a run: its speed, or the thrust of a fish held fixed; and its power if it is published."""
    published_values = {"thrust": run.thrust} if run.thrust is not None else {"speed": run.speed}
    published_values |= {f"{run.power_kind} power": run.power} if run.power is not None else {}
    for quantity, published in published_values.items():
        kind = quantity.split()[-1]
        low, high = first.band if kind == "speed" else (math.nan, math.nan)
        yield Score(
            swimmer.name,
            run.name,
            quantity,
            published,
            run.speed_error if kind == "speed" else None,
            getattr(first, kind),
            low,
            high,
            own=getattr(own, kind),
            length=swimmer.body.length,
            frequency=run.frequency,
            excursion=first.excursion,
            assumed=swimmer.assumes_excursion(run),
            reference=swimmer.reference,
            note=note,
        )
