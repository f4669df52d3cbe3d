"""The members of the family that swim four published speeds best, stored by validation/twin/posterior.py."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hypertuna.description.robot import Robot
from hypertuna.paper.chapter import Chapter, Trials
from hypertuna.paper.chapters.budget import POWERS, read_stored
from hypertuna.paper.chapters.gaits import speed_classes
from hypertuna.paper.computed import OURS, SPEEDS, TWIN
from hypertuna.paper.ledger import Class, Finding
from hypertuna.reports.html import Section
from hypertuna.swimming.gait import named_gait

AXES = ("free axis", "any axis")  # what may lie on a joint's axis: nothing that bears load, or anything
IN = "the member that swims the four unoptimised gaits best, found by a search"


@dataclass(frozen=True)
class Posterior:
    """The stored members of the family that swim four published speeds best, or why there are none."""

    robot: Robot
    record: Mapping[str, Any] = field(default_factory=dict)  # empty where there is no valid one
    reason: str = ""  # why there is none; without a full stop


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Posterior:
    """Read the stored members."""
    return read_posterior(trials[OURS].robot)


def read_posterior(robot: Robot) -> Posterior:
    """Read the stored members."""
    record, reason = read_stored("posterior", robot)
    return Posterior(robot, {} if reason else record, reason)


def findings(posterior: Posterior) -> Iterator[Finding]:
    """Yield speeds and powers of the fitted members; no predictions, as trial runs of such members were known."""
    fitted = speed_classes({name: named_gait(posterior.robot, name) for name in SPEEDS})
    classes: dict[str, Class] = {name: "fitted" if fitted[name] == "fitted" else "in sight" for name in SPEEDS}
    for axis in AXES:
        model, member, note = f"{TWIN}, {axis}", None, posterior.reason
        if posterior.record:
            (member,) = (one for name, one in posterior.record["robots"].items() if name.endswith(axis))
            forces = " and ".join(f"{newtons:.0f}" for newtons in member["axis_n"].values())
            note = f"{IN}; its axes carry up to {forces} N"
        for k, name in enumerate(SPEEDS):
            yield Finding(f"speed/{name}", model, classes[name], member and member["speed_m_s"][k], note)
        for key, gait in POWERS.items():
            yield Finding(key, model, "in sight", member and member["power_w"][SPEEDS.index(gait)], note)


def sections(posterior: Posterior) -> list[Section]:
    """Show nothing: the fitted members have a page of their own in the docs."""
    return []


CHAPTER = Chapter("posterior", sections, findings, compute)
