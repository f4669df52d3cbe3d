"""The entries of the ledger: a number of the paper, ours beside it, and the rules of the verdict."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from hypertuna.io.files import shipped

__all__ = ["MARKS", "RULES", "VERDICTS", "Entry", "Finding", "Rule", "judge", "published"]

VERDICTS = ("reproduced", "deviates", "contradicted", "undetermined", "not-computed")
MARKS = dict(zip(VERDICTS, "✓≠✗○…", strict=True))


class Finding(NamedTuple):
    """What was computed for a number of the paper: its id, by which model, the number in the published unit, a note.

    An identified number has its 95 % interval, too.
    """

    id: str
    model: str
    computed: float | None
    note: str = ""
    interval: tuple[float, float] | None = None


@dataclass(frozen=True)
class Rule:
    """When a computed number counts as the published one.

    Attributes
    ----------
    ids, kind : str
        Patterns of the ledger's ids and of the published kind that it holds for.
    tolerance : float
        Largest difference: a fraction of the published number, or absolute in its unit.
    absolute : bool
    reason : str
        Why the tolerance is what it is.
    bound : bool
        Whether the published number is an upper bound.
    """

    ids: str
    kind: str
    tolerance: float
    absolute: bool
    reason: str
    bound: bool = False

    def holds(self, published: float, computed: float) -> bool:
        """Tell whether a computed number agrees with the published one: near enough, and of the same sign.

        Parameters
        ----------
        published, computed : float
            In the same unit.

        Returns
        -------
        bool
        """
        excess = computed - published if self.bound else abs(computed - published)
        scale = 1.0 if self.absolute else abs(published)
        return excess <= self.tolerance * scale and computed * published > 0


# The first rule that fits an entry decides its verdict. What does not hold deviates; where both numbers are the
# paper's own, one derived from the others, it is contradicted.
RULES = (
    Rule("speed/model-error-max", "*", 0.0, False, "an upper bound is kept or not", bound=True),
    Rule("*/change-*", "*", 0.5, False, "the same direction, within half: a small difference of two measured numbers"),
    Rule("speed/*", "nominal", 0.10, False, "published to one digit: half a unit of it is 10 % and more"),
    Rule("speed/*", "*", 0.05, False, "the accuracy that the paper claims for its own model, section III.E"),
    Rule("optimal-phase/*", "*", 0.0, True, "the same point of the grid of phases"),
    Rule("turning/best-phase", "*", 0.0, True, "the same point of the grid of phases"),
    Rule(
        "optimum/max/phase",
        "*",
        8.0,
        True,
        "the optimum is flat: 8 deg off it, less than half a percent of the speed is lost",
    ),
    Rule("optimum/max/*", "*", 0.01, False, "at its bound, as near as a swarm of 60 iterations comes to it"),
    Rule("optimum/*/phase", "*", 8.0, True, "as for the maximum"),
    Rule("optimum/*", "*", 0.10, False, "many gaits have nearly the same speed and cost"),
    Rule("cost-of-transport/model-error", "*", 0.0, False, "an upper bound is kept or not", bound=True),
    Rule("turning/radius-bl", "*", 0.10, False, "measured in snapshots of one turn"),
    Rule("lake/*", "*", 0.15, False, "told as approximate: a track by a phone on a boat, on water that moves"),
    Rule("bending/*", "*", 0.01, False, "the actuator's estimated geometry was made to meet both: it must"),
    Rule(
        "fe/bending-*",
        "*",
        0.03,
        False,
        "hypertuna-fe's geometry was made to meet both, by a few runs",
    ),
    Rule("control/settling-*", "*", 0.0, False, "an upper bound is kept or not", bound=True),
    Rule("power/*", "*", 0.10, False, "what the servos and converters lose is estimated, not published"),
    Rule("cost-of-transport/minimum", "*", 0.10, False, "a power of 10 % over a speed"),
    Rule("range/*", "*", 0.01, False, "arithmetic on numbers of three digits"),
    Rule("*", "*", 0.05, False, "the accuracy that the paper claims for its own model, section III.E"),
)


@dataclass(frozen=True)
class Entry:
    """One number of the paper beside ours; id and model together are unique.

    Attributes
    ----------
    id, source, unit : str
        What it is, where the paper has it, its unit.
    published : float or None
        None where the paper makes its claim in words.
    computed : float or None
    model : str
        What computed it.
    relative_error : float or None
        computed / published - 1.
    verdict : str
        "reproduced", "deviates", "contradicted", "undetermined" or "not-computed".
    note : str
    interval : tuple of float or None
        Of an identified number, 95 %.
    bound : bool
        Whether the published number is an upper bound.
    """

    id: str
    source: str
    unit: str
    published: float | None
    computed: float | None
    model: str
    relative_error: float | None
    verdict: str
    note: str
    interval: tuple[float, float] | None = None
    bound: bool = False

    @property
    def error(self) -> str:
        """The relative error as text; empty for percentages and angles, whose difference says more, and for bounds."""
        if self.relative_error is None or self.unit in ("%", "deg") or self.verdict == "undetermined" or self.bound:
            return ""
        return f"{100 * self.relative_error:+.1f} %"

    @property
    def told(self) -> str:
        """The published number with its unit; a dash for it where the paper has words alone."""
        if self.published is None:
            return f"– {self.unit}"
        most = "≤ " if self.bound else ""
        return f"{most}{self.published:g}" if self.unit == "1" else f"{most}{self.published:g} {self.unit}"

    @property
    def answer(self) -> str:
        """What was computed, to three digits."""
        if self.computed is None:
            return ""
        sign = "+" if "change" in self.id else ""
        return f"{self.computed:{sign}g}" if self.computed == round(self.computed) else f"{self.computed:{sign}#.3g}"


@cache
def published(name: str = "published") -> dict[str, Any]:
    """Read the paper's numbers.

    Parameters
    ----------
    name : str
        Of a file in data/published: "published" for the ledger's, "others" for other fish and robots.

    Returns
    -------
    dict
        Its content.
    """
    return tomllib.loads((shipped("data/published") / f"{name}.toml").read_text(encoding="utf-8"))


def judge(paper: Mapping[str, Any], found: Finding) -> Entry:
    """Put what was computed beside the published number, and judge it.

    Parameters
    ----------
    paper : mapping
        What `published` returns.
    found : Finding

    Returns
    -------
    Entry
    """
    fact = paper["values"][found.id]
    told = fact.get("value")
    error = None if found.computed is None or told is None else found.computed / told - 1
    return Entry(
        id=found.id,
        source=fact["source"],
        unit=fact["unit"],
        published=told,
        computed=found.computed,
        model=found.model,
        relative_error=error,
        verdict=_verdict(found, fact),
        note=found.note,
        interval=found.interval,
        bound=_rule(found, fact).bound,
    )


def _verdict(found: Finding, fact: Mapping[str, Any]) -> str:
    """Judge by the interval, else by the first rule that fits; what is not finite is not computed."""
    if found.computed is None or not np.isfinite(found.computed):
        return "not-computed"
    if "value" not in fact:
        return "undetermined"
    if found.interval is not None:
        low, high = found.interval
        if high - low > abs(fact["value"]):
            return "undetermined"
        return "reproduced" if low <= fact["value"] <= high else "deviates"
    if _rule(found, fact).holds(fact["value"], found.computed):
        return "reproduced"
    return "contradicted" if fact["kind"] == "derived" else "deviates"


def _rule(found: Finding, fact: Mapping[str, Any]) -> Rule:
    """Return the first rule that fits."""
    return next(rule for rule in RULES if fnmatch(found.id, rule.ids) and fnmatch(fact["kind"], rule.kind))
