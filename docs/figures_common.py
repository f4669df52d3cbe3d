"""What the modules of figures share: the paper, its robot, and how a Markdown table is written."""

from __future__ import annotations

from collections.abc import Sequence

from hypertuna.description.robot import load
from hypertuna.paper.ledger import published

PAPER = published()
FISH = load("hypertuna")


def told(name: str) -> float:
    """Return a number of the paper."""
    value: float = PAPER["values"][name]["value"]
    return value


def rows(head: Sequence[str], body: Sequence[Sequence[str]], left: int = 1) -> str:
    """Write a Markdown table; all columns but the first `left` ones are aligned to the right."""
    rule = ["---"] * left + ["---:"] * (len(head) - left)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, rule, *body))
