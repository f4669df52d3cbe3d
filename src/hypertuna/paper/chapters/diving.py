"""The diving and floating test of section III.G."""

import math
from collections.abc import Callable

from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS
from hypertuna.paper.ledger import published
from hypertuna.reports.html import WIDTH, Section
from hypertuna.simulation.dive import Dive, dive
from hypertuna.swimming.gait import named_gait


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Dive:
    """Return a dive as the paper's robot made it."""
    robot, facts = trials[OURS].robot, published()["diving"]
    return dive(robot, named_gait(robot, facts["gait"]), angle=math.radians(facts["fins_deg"]))


def sections(result: Dive) -> list[Section]:
    """Show the diving test."""
    from hypertuna.simulation.plots import plot_dive

    figures = {"diving": plot_dive(result, width=WIDTH)}
    return compose("diving", figures, dive=result, fins=math.degrees(result.angle))


CHAPTER = Chapter("diving", sections, compute=compute)
