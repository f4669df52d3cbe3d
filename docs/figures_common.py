"""Shared by the modules of figures: the paper's numbers, its robot and its swims, and the Markdown table."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from hypertuna.description.robot import load
from hypertuna.paper.computed import Trial, swim_published
from hypertuna.paper.ledger import published
from hypertuna.swimming.swim import Swim

PAPER = published()  # published numbers, by name
FISH = load("hypertuna")
MODELS = ("ideal joints", "joint bandwidth", "ideal joints, areas as printed", "joint bandwidth, areas as printed")
TEXT = 26  # characters of a number with its interval and unit; a longer cell is a text


@cache
def trials() -> dict[str, Trial]:
    """Return the swims of all tests in the paper, by model of `MODELS`."""
    return swim_published(FISH, PAPER, full=True)


def swum(gait: str, model: str) -> Swim:
    """Return the swim of a gait of HyperTuna's file by a model of `MODELS`."""
    return trials()[model].gaits[gait]


def change(before: float, after: float) -> float:
    """Return a relative change in percent."""
    return 100 * (after / before - 1)


def paper_value(name: str) -> float:
    """Return a published number by its id in data/published."""
    value: float = PAPER["values"][name]["value"]
    return value


def rows(head: Sequence[str], body: Sequence[Sequence[str]], left: int = 1) -> str:
    """Write a Markdown table; the first `left` columns and those with a text are aligned to the left."""
    texts = [k < left or any(len(row[k]) > TEXT for row in body) for k in range(len(head))]
    rule = ["---" if text else "---:" for text in texts]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, rule, *body))
