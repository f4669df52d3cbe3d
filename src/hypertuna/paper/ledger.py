"""The entries of the ledger: a number of the paper, ours beside it, and the rules of the verdict."""

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from hypertuna.io.files import published as published

Class: TypeAlias = Literal["prediction", "fitted", "calibrated", "in sight", "input", "at a bound", "not judged"]
CLASSES: dict[Class, str] = {  # of computed numbers: whether they could have come out otherwise
    "prediction": "nothing was fitted to the published number, or chosen with it in view",
    "fitted": "coefficients or a member of the family were identified from the published number, by us or the authors",
    "calibrated": "a described value was chosen to match the published number",
    "in sight": "a described value or a reading of the paper was chosen with the published number in view",
    "input": "the published number is an input, or the computation takes only the paper's own numbers",
    "at a bound": "a bound of the search decides the computed number",
    "not judged": "the paper prints no number, or one of data that it does not publish",
}
# Only a prediction is "reproduced"; a number of another class that is met "agrees", which proves little. A bound
# "holds" or is "violated"; a robot that is 20 % faster or slower keeps most bounds too.
VERDICTS = ("reproduced", "agrees", "holds", "deviates", "violated", "contradicted", "undetermined", "not-computed")
MARKS = dict(zip(VERDICTS, "✓≈⊂≠⊄✗○…", strict=True))  # sign of each verdict
ENOUGH = 0.9  # fraction of the seeds that must agree


class Finding(NamedTuple):
    """A computed value for a number of the paper."""

    id: str
    model: str  # model that computed the number
    class_: Class
    computed: float | None  # in the published unit; the median over seeds
    note: str = ""
    interval: tuple[float, float] | None = None  # 95 %, of an identified number
    values: tuple[float, ...] = ()  # by seed, where there is noise
    band: tuple[float, float] | None = None  # 5 and 95 % of the family, the robots that the paper allows


@dataclass(frozen=True)
class Rule:
    """A rule for when a computed number counts as the published one."""

    ids: str  # pattern of the ids that the rule applies to
    kind: str  # pattern of the published kind
    tolerance: float  # max difference: a fraction of the published number, or absolute in its unit
    absolute: bool
    reason: str  # for the tolerance
    how: Literal["within", "at most", "at least", "open"] = "within"  # "open": the published claim cannot be checked

    def holds(self, published: float, computed: float) -> bool:
        """Return whether a computed number agrees with the published one: within the tolerance, with the same sign."""
        if self.how != "within":
            return {"at most": computed <= published, "at least": computed >= published}.get(self.how, False)
        scale = 1.0 if self.absolute else abs(published)
        return abs(computed - published) <= self.tolerance * scale and computed * published > 0


# `Rule.how` -> sign of the bound.
BOUNDS = {"at most": "≤", "at least": "≥"}
CLAIM = "the accuracy that the paper claims for its own model, section III.E"  # reason for a tolerance
# A tolerance below 1/11 never admits both a robot and one that is 20 % faster: 1.2 (1 - 1/11) = 1 + 1/11.
WIDEST = 0.09
LARGE = "the largest tolerance that no robot 20 % faster or slower meets"  # reason for a tolerance

# The first rule that fits an entry decides its verdict. A number that fails it deviates; if the
# published number is derived from others of the paper, it is contradicted.
RULES = (
    Rule("*/model-error*", "*", 0.0, False, "claimed of the paper's validation set, which is not published", "open"),
    Rule("*/change-*", "*", WIDEST, False, f"small differences of two measured numbers; {LARGE}"),
    Rule("*/over-*", "*", 0.0, False, "a trend without exceptions is kept or not", "at least"),
    Rule("speed/slows", "*", 0.0, False, "a trend without exceptions is kept or not", "at least"),
    Rule("speed/*", "target", WIDEST, False, f"a target of one digit, not a measurement; {LARGE}"),
    Rule("speed/*", "*", 0.05, False, CLAIM),
    Rule("optimal-phase/*", "*", 0.0, True, "the same point of the grid of phases"),
    Rule("turning/best-phase", "*", 0.0, True, "the same point of the grid of phases"),
    Rule("optimum/max/phase", "*", WIDEST, False, f"the optimum is flat; {LARGE}"),
    Rule("optimum/max/*", "*", 0.01, False, "at its bound, as near as a swarm of 60 iterations comes to it"),
    Rule("optimum/*", "*", WIDEST, False, f"many gaits have nearly the same speed and cost; {LARGE}"),
    Rule("turning/radius-bl", "*", WIDEST, False, f"measured in snapshots of one turn; {LARGE}"),
    Rule("lake/*", "*", WIDEST, False, f"published as approximate; {LARGE}"),
    Rule("bending/linear-*", "*", WIDEST, False, f"a straight line has 1; {LARGE}"),
    Rule("bending/below-*", "*", WIDEST, False, f"a straight line through no bend without pressure has 1; {LARGE}"),
    Rule("bending/*", "*", WIDEST, False, f"the geometry was made to meet both; {LARGE}"),
    Rule("fe/bending-*", "*", 0.03, False, "the geometry was made to meet both, by a few runs"),
    Rule("start/*", "*", 0.0, False, "a lower bound is kept or not", "at least"),
    Rule("diving/pitch-*", "*", 0.0, False, "the bound within which `hypertuna dive` calls a pitch steady", "at most"),
    Rule("servo/*", "*", 0.0, False, "an upper bound is kept or not", "at most"),
    Rule("control/settling-*", "*", 0.0, False, "an upper bound is kept or not", "at most"),
    Rule("pressure/*", "*", 0.0, False, "a lower bound is kept or not", "at least"),
    Rule("power/bound-*", "*", 0.0, False, "a lower bound is kept or not", "at least"),
    Rule("power/*", "*", WIDEST, False, f"what the servos and converters lose is estimated; {LARGE}"),
    Rule("cost-of-transport/minimum", "*", WIDEST, False, f"a power over a speed; {LARGE}"),
    Rule("cost-of-transport/cheapest-hz", "*", 0.0, True, "the same point of the grid of frequencies"),
    Rule("range/*", "*", 0.01, False, "arithmetic on numbers of three digits"),
    Rule("*", "*", 0.05, False, CLAIM),
)

# Numbers of gaits at 4.75 to 6 Hz, and trends up to 6 Hz. These gaits need the joints' whole moment, which depends
# on unpublished values. At 2 and 3 Hz the default robot is judged as if everything were known.
FAST = (
    *("speed/*-0.5", "speed/*-max", "speed/optimised-0.4", "speed/over-frequency", "speed/slows", "lake/speed"),
    *("cost-of-transport/change-0.[45]", "cost-of-transport/minimum", "cost-of-transport/cheapest-*"),
    *("power/fastest", "power/lake", "power/bound-0.5", "range/battery", "optimal-phase/*", "pressure/lowest"),
)
UNPUBLISHED = "limit, levers and axis are unpublished"
FAMILY = "the family was chosen with this claim in view"


@dataclass(frozen=True)
class Seeds:
    """Median, range and agreement of a number over seeds of the noise."""

    count: int
    passed: int | None  # seeds whose number agrees with the published one; None without one
    low: float  # 5th percentile
    high: float  # 95th percentile


@dataclass(frozen=True)
class Entry:
    """A number of the paper beside ours; id and model together are unique."""

    id: str
    source: str  # place in the paper
    unit: str
    kind: str  # of the published number, as in data/published
    published: float | None  # None if the paper's claim is in words only
    computed: float | None
    model: str  # model that computed the number
    class_: Class
    relative_error: float | None  # computed / published - 1; None if the published number is 0
    verdict: str  # of `VERDICTS`
    note: str
    interval: tuple[float, float] | None = None  # 95 %, of an identified number
    seeds: Seeds | None = None  # where there is noise
    bound: str = ""  # "≤" or "≥" where the published number is a bound
    band: tuple[float, float] | None = None  # 5 and 95 % of the family

    @property
    def error(self) -> str:
        """Relative error as text; empty for percentages, angles and bounds."""
        decided = self.verdict != "undetermined" or self.why
        if self.relative_error is None or self.unit in ("%", "deg") or self.bound or not decided:
            return ""
        return f"{100 * self.relative_error:+.1f} %"

    @property
    def published_text(self) -> str:
        """Published number with its unit; a dash where the paper gives no number."""
        if self.published is None:
            return f"– {self.unit}"
        number = f"{self.bound} {self.published:g}".lstrip()
        return number if self.unit == "1" else f"{number} {self.unit}"

    @property
    def computed_text(self) -> str:
        """The computed number, to three digits."""
        if self.computed is None:
            return ""
        sign = "+" if "change" in self.id else ""
        digits = "g" if self.computed == round(self.computed) else "#.3g"
        return f"{self.computed:{sign}{digits}}".rstrip(".")

    @property
    def seeds_text(self) -> str:
        """The number of seeds that agree, out of all; empty without noise or a published number."""
        return "" if self.seeds is None or self.seeds.passed is None else f"{self.seeds.passed} of {self.seeds.count}"

    @property
    def band_text(self) -> str:
        """The range of the family, to three digits; empty without one."""
        return "" if self.band is None else "{:.3g} to {:.3g}".format(*self.band)

    @property
    def why(self) -> str:
        """Reason why the family leaves the verdict open; empty if it does not."""
        if self.band is None or self.verdict != "undetermined" or self.class_ == "not judged":
            return ""
        return UNPUBLISHED if fast(self.id) else "not all robots that the paper allows agree"


def published_value(key: str) -> float:
    """Return a published number by its id, in its unit."""
    return float(published()["values"][key]["value"])


def judge(paper: Mapping[str, Any], finding: Finding) -> Entry:
    """Return the entry of a finding: beside the published number, with a verdict."""
    fact = paper["values"][finding.id]
    value, rule, computed = fact.get("value"), _rule(finding, fact), finding.computed
    return Entry(
        id=finding.id,
        source=fact["source"],
        unit=fact["unit"],
        kind=fact["kind"],
        published=value,
        computed=computed,
        model=finding.model,
        class_=finding.class_,
        relative_error=computed / value - 1 if value and computed is not None else None,
        verdict=_verdict(finding, fact, rule),
        note=finding.note,
        interval=finding.interval,
        seeds=_seeds(finding.values, value, rule),
        bound=BOUNDS.get(rule.how, ""),
        band=finding.band,
    )


def _verdict(finding: Finding, fact: Mapping[str, Any], rule: Rule) -> str:
    """Return the verdict by interval, seeds and family, or number; a number that is not finite is "not computed"."""
    if finding.computed is None or not np.isfinite(finding.computed):
        return "not-computed"
    if "value" not in fact or rule.how == "open":
        return "undetermined"
    value = fact["value"]
    if finding.interval is not None:
        low, high = finding.interval
        if high - low > abs(value):
            return "undetermined"
        holds = low <= value <= high
    else:
        values = finding.values or (finding.computed,)
        holds = sum(rule.holds(value, one) for one in values) >= ENOUGH * len(values)
    if finding.band is not None and _is_open(finding, value, rule, holds):
        return "undetermined"
    if rule.how != "within":
        return "holds" if holds else "violated"
    if holds:
        return "reproduced" if finding.class_ == "prediction" else "agrees"
    return "contradicted" if fact["kind"] == "derived" else "deviates"


def _is_open(finding: Finding, published: float, rule: Rule, holds: bool) -> bool:
    """Return whether the family leaves the verdict open: some member disagrees, or may agree where the robot fails.

    A robot that fails at 2 or 3 Hz deviates, however wide the family is.
    """
    assert finding.band is not None
    if holds:
        return not all(rule.holds(published, end) for end in finding.band)
    low, high = finding.band
    return low <= published <= high and fast(finding.id)


def fast(key: str) -> bool:
    """Return whether a number, by its id, belongs to gaits at 4.75 to 6 Hz."""
    return any(fnmatch(key, ids) for ids in FAST)


def _seeds(values: tuple[float, ...], published: float | None, rule: Rule) -> Seeds | None:
    """Return median, range and number of agreeing values of a number over seeds; None without seeds."""
    if not values:
        return None
    low, high = np.percentile(values, (5, 95)).tolist()
    passed = None if published is None else sum(rule.holds(published, one) for one in values)
    return Seeds(len(values), passed, low, high)


def _rule(finding: Finding, fact: Mapping[str, Any]) -> Rule:
    """Return the first rule that fits the id and the kind of a finding."""
    return next(rule for rule in RULES if fnmatch(finding.id, rule.ids) and fnmatch(fact["kind"], rule.kind))
