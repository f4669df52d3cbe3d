"""Tables of docs/fe.md, from what was stored; docs/figures.py takes them in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hypertuna.reproduce_fe import FE, ROBOTS, difference_table, read_elements

ELEMENTS = read_elements()
SHIPPED = next(model for model in ELEMENTS.solved if model != FE)


def rows(head: Sequence[str], body: Sequence[Sequence[str]], left: int = 1) -> str:
    """Write a Markdown table; all columns but the first `left` ones are aligned to the right."""
    rule = ["---"] * left + ["---:"] * (len(head) - left)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, rule, *body))


def bend_table(model: str) -> str:
    """Tabulate bends by finite elements and by the analytic model."""
    table = difference_table(ELEMENTS, model)
    assert table is not None, "run: python validation/fe/ledger.py"
    return rows(table.columns, [[str(cell) for cell in row] for row in table.rows], left=0)


def run_table() -> str:
    """Tabulate what the stored runs took."""
    body = []
    for model, joints in ELEMENTS.solved.items():
        for one in joints.values():
            record = one.record
            assert record is not None
            sizes = (f"{record['elements']:,}", f"{record['unknowns']:,}")
            cost = (f"{record['seconds']:.0f}", f"{record['memory_gb']:.2f}")
            line = (f"{one.r_squared:.3f}", *sizes, *cost)
            body.append([f"`{ROBOTS[model]}`", one.joint, f"{one.column('bend_deg')[-1]:.2f}", *line])
    head = ["robot", "joint", "at 250 kPa [deg]", "R², 100–250 kPa", "tetrahedra", "unknowns", "time [s]"]
    return rows([*head, "memory [GB]"], body, left=2)


TABLES: dict[str, Callable[[], str]] = {
    "fe bends": lambda: bend_table(FE),
    "fe bends, shipped": lambda: bend_table(SHIPPED),
    "fe runs": run_table,
}
PICTURES: dict[str, Any] = {}
