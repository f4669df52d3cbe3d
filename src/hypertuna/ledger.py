"""The entries of the ledger: a number of the paper, ours beside it, and the rules of the verdict."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["MARKS", "RULES", "VERDICTS", "Entry", "Rule", "judge", "published"]

VERDICTS = ("reproduced", "deviates", "contradicted", "not-computed")
MARKS = {"reproduced": "✓", "deviates": "≠", "contradicted": "✗", "not-computed": "…"}


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
    Rule("*phase*", "*", 0.0, True, "the same point of the grid of phases"),
    Rule("turning/radius", "*", 0.10, False, "measured in snapshots of one turn"),
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
    published : float
    computed : float or None
    model : str
        What computed it.
    relative_error : float or None
        computed / published - 1.
    verdict : str
        "reproduced", "deviates", "contradicted" or "not-computed".
    note : str
    """

    id: str
    source: str
    unit: str
    published: float
    computed: float | None
    model: str
    relative_error: float | None
    verdict: str
    note: str

    @property
    def error(self) -> str:
        """The relative error as text; empty for percentages and angles, whose difference says more."""
        return "" if self.relative_error is None or self.unit in ("%", "deg") else f"{100 * self.relative_error:+.1f} %"

    @property
    def answer(self) -> str:
        """What was computed, to three digits."""
        if self.computed is None:
            return ""
        sign = "+" if "change" in self.id else ""
        return f"{self.computed:{sign}g}" if self.computed == round(self.computed) else f"{self.computed:{sign}#.3g}"


@cache
def published() -> dict[str, Any]:
    """Read the paper's numbers.

    Returns
    -------
    dict
        Content of data/published/published.toml.
    """
    here = Path(__file__).resolve().parent
    folders = (here / "data" / "published", here.parents[1] / "data" / "published")
    path = next(folder / "published.toml" for folder in folders if (folder / "published.toml").is_file())
    return tomllib.loads(path.read_text(encoding="utf-8"))


def judge(paper: Mapping[str, Any], key: str, model: str, computed: float | None, note: str) -> Entry:
    """Put what was computed beside the published number, and judge it.

    Parameters
    ----------
    paper : mapping
        What `published` returns.
    key, model : str
        Id of the entry, and what computed it.
    computed : float or None
        In the unit of the published number.
    note : str

    Returns
    -------
    Entry
    """
    fact = paper["values"][key]
    number = fact["value"]
    error = None if computed is None else computed / number - 1
    return Entry(key, fact["source"], fact["unit"], number, computed, model, error, _verdict(key, fact, computed), note)


def _verdict(key: str, fact: Mapping[str, Any], computed: float | None) -> str:
    """Judge by the first rule that fits; what is not finite is not computed."""
    if computed is None or not np.isfinite(computed):
        return "not-computed"
    rule = next(rule for rule in RULES if fnmatch(key, rule.ids) and fnmatch(fact["kind"], rule.kind))
    if rule.holds(fact["value"], computed):
        return "reproduced"
    return "contradicted" if fact["kind"] == "derived" else "deviates"
