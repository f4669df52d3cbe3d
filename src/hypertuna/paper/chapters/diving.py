"""The diving and floating test of section III.G."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from hypertuna.description.robot import Robot
from hypertuna.paper.ledger import Finding
from hypertuna.reports.html import WIDTH, Picture, Section
from hypertuna.simulation.dive import Dive, dive
from hypertuna.swimming.gait import named_gait

__all__ = ["dive_published", "findings", "sections"]


TWIN = "twin"  # the model, as reproduce_twin calls it


def dive_published(robot: Robot, paper: Mapping[str, Any]) -> Dive:
    """Dive as the paper's robot did.

    Parameters
    ----------
    robot : Robot
    paper : mapping
        Content of data/published/published.toml.

    Returns
    -------
    Dive
    """
    told = paper["diving"]
    return dive(robot, named_gait(robot, told["gait"]), angle=math.radians(told["fins_deg"]))


def findings(done: Dive) -> Iterator[Finding]:
    """Yield the rate of diving.

    Parameters
    ----------
    done : Dive

    Yields
    ------
    Finding
    """
    down, up = done.legs
    note = (
        f"down with the fins at {math.degrees(down.fins):+.3g} deg, pitch {math.degrees(down.pitch):+.1f} deg; "
        f"{-100 * up.rate:.2g} cm/s up at {math.degrees(up.fins):+.3g} deg, pitch {math.degrees(up.pitch):+.1f} deg; "
    )
    steady = all(leg.steady for leg in done.legs)
    note += (
        "the pitch is steady, as the paper says" if steady else "the pitch is not steady, which the paper says it is"
    )
    yield Finding("diving/depth-rate", TWIN, 100 * down.rate, note)


def sections(done: Dive) -> list[Section]:
    """Show the diving test.

    Parameters
    ----------
    done : Dive

    Returns
    -------
    list of Section
    """
    from hypertuna.simulation.plots import plot_dive

    picture = Picture(
        "diving",
        plot_dive(done, width=WIDTH),
        "Depth, pitch and speed of the twin while its pectoral fins are down, then up.",
        f"{done.run.gait.frequency:g} Hz, the fins at {math.degrees(done.angle):g} deg down, then up, as in Fig. 15.",
    )
    return [
        Section("Diving and floating", [picture, f"{' '.join(done.sentences)} The paper shows both and tells no rate."])
    ]
