"""Tables and picture of docs/passive.md; docs/figures.py includes them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from figures_common import FISH, rows
from matplotlib.figure import Figure

from hypertuna.figures import WIDTH
from hypertuna.paper.chapters.passive import (
    answer_table,
    claim_table,
    fin_table,
    parts_table,
    read_passive,
    spring_table,
    stiffness_table,
)
from hypertuna.paper.figures import plot_passive
from hypertuna.reports.html import Table


@cache
def record() -> Any:
    """Return the stored results of robots with a passive joint."""
    passive = read_passive(FISH)
    assert passive.record, passive.reason
    return passive.record


def _table(make: Callable[[Any], Table], left: int) -> Callable[[], str]:
    """Return a function that writes a table of the ledger's chapter as Markdown."""

    def written() -> str:
        table = make(record())
        return rows(table.columns, [[str(cell) for cell in row] for row in table.rows], left)

    return written


TABLES: dict[str, Callable[[], str]] = {
    "passive answer": _table(answer_table, 2),
    "passive parts": _table(parts_table, 2),
    "passive one spring": _table(spring_table, 1),
    "passive stiffness": _table(stiffness_table, 2),
    "passive fins": _table(fin_table, 0),
    "passive claims": _table(claim_table, 4),
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/passive.svg": lambda: plot_passive(record(), WIDTH)}
