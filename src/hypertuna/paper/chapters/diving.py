"""The diving and floating test of section III.G."""

import math
from collections.abc import Callable, Iterator

from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS, TWIN
from hypertuna.paper.ledger import Finding, published
from hypertuna.reports.html import WIDTH, Section
from hypertuna.simulation.dive import Dive, dive
from hypertuna.swimming.gait import named_gait


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Dive:
    """Dive as the paper's robot did."""
    robot, facts = trials[OURS].robot, published()["diving"]
    return dive(robot, named_gait(robot, facts["gait"]), angle=math.radians(facts["fins_deg"]))


def findings(result: Dive) -> Iterator[Finding]:
    """Yield the rate of diving."""
    down, up = result.legs
    steady = "steady, as the paper says"
    if not all(leg.steady for leg in result.legs):
        steady = "not steady, which the paper says it is"
    note = (
        f"down with the fins at {math.degrees(down.fins):+.3g} deg, pitch {math.degrees(down.pitch):+.1f} deg; "
        f"{-100 * up.rate:.2g} cm/s up at {math.degrees(up.fins):+.3g} deg, pitch {math.degrees(up.pitch):+.1f} deg; "
        f"the pitch is {steady}"
    )
    yield Finding("diving/depth-rate", TWIN, 100 * down.rate, note)


def sections(result: Dive) -> list[Section]:
    """Show the diving test."""
    from hypertuna.simulation.plots import plot_dive

    figures = {"diving": plot_dive(result, width=WIDTH)}
    return compose("diving", figures, dive=result, fins=math.degrees(result.angle))


CHAPTER = Chapter("diving", sections, findings, compute)
