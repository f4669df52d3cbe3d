"""The entries of the ledger: a number of the paper, ours beside it, and the rules of the verdict."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from hypertuna.io.files import shipped

VERDICTS = ("reproduced", "deviates", "contradicted", "undetermined", "not-computed")
MARKS = dict(zip(VERDICTS, "✓≠✗○…", strict=True))


class Finding(NamedTuple):
    """A computed number of the paper."""

    id: str
    model: str  # that computed it
    computed: float | None  # in the published unit
    note: str = ""
    interval: tuple[float, float] | None = None  # 95 %, of an identified number


@dataclass(frozen=True)
class Rule:
    """A rule for when a computed number counts as the published one."""

    ids: str  # pattern of the ids that the rule applies to
    kind: str  # pattern of the published kind
    tolerance: float  # max difference: a fraction of the published number, or absolute in its unit
    absolute: bool
    reason: str  # for the tolerance
    bound: bool = False  # whether the published number is an upper bound

    def holds(self, published: float, computed: float) -> bool:
        """Return whether a computed number agrees with the published one: within the tolerance, with the same sign."""
        excess = computed - published if self.bound else abs(computed - published)
        scale = 1.0 if self.absolute else abs(published)
        return excess <= self.tolerance * scale and computed * published > 0


CLAIM = "the accuracy that the paper claims for its own model, section III.E"
FLAT = "the optimum is flat: 8 deg off it, less than half a percent of the speed is lost"

# The first rule that fits an entry decides its verdict. What does not hold deviates; where both numbers are the
# paper's own, one derived from the others, it is contradicted.
RULES = (
    Rule("speed/model-error-max", "*", 0.0, False, "an upper bound is kept or not", bound=True),
    Rule("*/change-*", "*", 0.5, False, "the same direction, within half: a small difference of two measured numbers"),
    Rule("speed/*", "nominal", 0.10, False, "published to one digit: half a unit of it is 10 % and more"),
    Rule("speed/*", "*", 0.05, False, CLAIM),
    Rule("optimal-phase/*", "*", 0.0, True, "the same point of the grid of phases"),
    Rule("turning/best-phase", "*", 0.0, True, "the same point of the grid of phases"),
    Rule("optimum/max/phase", "*", 8.0, True, FLAT),
    Rule("optimum/max/*", "*", 0.01, False, "at its bound, as near as a swarm of 60 iterations comes to it"),
    Rule("optimum/*/phase", "*", 8.0, True, "as for the maximum"),
    Rule("optimum/*", "*", 0.10, False, "many gaits have nearly the same speed and cost"),
    Rule("cost-of-transport/model-error", "*", 0.0, False, "an upper bound is kept or not", bound=True),
    Rule("turning/radius-bl", "*", 0.10, False, "measured in snapshots of one turn"),
    Rule("lake/*", "*", 0.15, False, "published as approximate: a track by a phone on a boat, on moving water"),
    Rule("bending/*", "*", 0.01, False, "the actuator's estimated geometry was made to meet both: it must"),
    Rule("fe/bending-*", "*", 0.03, False, "hypertuna-fe's geometry was made to meet both, by a few runs"),
    Rule("control/settling-*", "*", 0.0, False, "an upper bound is kept or not", bound=True),
    Rule("power/*", "*", 0.10, False, "what the servos and converters lose is estimated, not published"),
    Rule("cost-of-transport/minimum", "*", 0.10, False, "a power of 10 % over a speed"),
    Rule("range/*", "*", 0.01, False, "arithmetic on numbers of three digits"),
    Rule("*", "*", 0.05, False, CLAIM),
)


@dataclass(frozen=True)
class Entry:
    """One number of the paper beside ours; id and model together are unique."""

    id: str
    source: str  # place in the paper
    unit: str
    published: float | None  # None where the paper claims something in words alone
    computed: float | None
    model: str  # that computed it
    relative_error: float | None  # computed / published - 1
    verdict: str  # of `VERDICTS`
    note: str
    interval: tuple[float, float] | None = None  # 95 %, of an identified number
    bound: bool = False  # whether the published number is an upper bound

    @property
    def error(self) -> str:
        """The relative error as text; empty for percentages and angles, whose difference says more, and for bounds."""
        if self.relative_error is None or self.unit in ("%", "deg") or self.verdict == "undetermined" or self.bound:
            return ""
        return f"{100 * self.relative_error:+.1f} %"

    @property
    def published_text(self) -> str:
        """The published number with its unit; a dash instead where the paper has words alone."""
        if self.published is None:
            return f"– {self.unit}"
        number = f"{'≤ ' if self.bound else ''}{self.published:g}"
        return number if self.unit == "1" else f"{number} {self.unit}"

    @property
    def computed_text(self) -> str:
        """The computed number, to three digits."""
        if self.computed is None:
            return ""
        sign = "+" if "change" in self.id else ""
        return f"{self.computed:{sign}g}" if self.computed == round(self.computed) else f"{self.computed:{sign}#.3g}"


@cache
def published(name: str = "published") -> dict[str, Any]:
    """Read a file of data/published: "published" for the paper's numbers, "others" for other fish and robots."""
    return tomllib.loads((shipped("data/published") / f"{name}.toml").read_text(encoding="utf-8"))


def published_value(key: str) -> float:
    """Return a published number by its id, in its unit."""
    return float(published()["values"][key]["value"])


def judge(paper: Mapping[str, Any], finding: Finding) -> Entry:
    """Return the entry of a computed number: beside the published one, with a verdict."""
    fact, (name, model, computed, note, interval) = paper["values"][finding.id], finding
    value = fact.get("value")
    return Entry(
        id=name,
        source=fact["source"],
        unit=fact["unit"],
        published=value,
        computed=computed,
        model=model,
        relative_error=None if computed is None or value is None else computed / value - 1,
        verdict=_verdict(finding, fact),
        note=note,
        interval=interval,
        bound=_rule(finding, fact).bound,
    )


def _verdict(finding: Finding, fact: Mapping[str, Any]) -> str:
    """Judge by the interval, else by the first rule that fits; a number that is not finite is not computed."""
    if finding.computed is None or not np.isfinite(finding.computed):
        return "not-computed"
    if "value" not in fact:
        return "undetermined"
    if finding.interval is not None:
        low, high = finding.interval
        if high - low > abs(fact["value"]):
            return "undetermined"
        return "reproduced" if low <= fact["value"] <= high else "deviates"
    if _rule(finding, fact).holds(fact["value"], finding.computed):
        return "reproduced"
    return "contradicted" if fact["kind"] == "derived" else "deviates"


def _rule(finding: Finding, fact: Mapping[str, Any]) -> Rule:
    """Return the first rule that fits."""
    return next(rule for rule in RULES if fnmatch(finding.id, rule.ids) and fnmatch(fact["kind"], rule.kind))
