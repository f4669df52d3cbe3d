"""Tables of docs/fe.md, from what was stored; docs/figures.py takes them in."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from hypertuna.reproduce_fe import FE, ROBOTS, difference_table, read_elements

ROOT = Path(__file__).resolve().parents[1]
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


def case_table() -> str:
    """Tabulate what theory knows, as `hypertuna fe validate --json` was stored."""
    cases = json.loads((ROOT / "validation" / "fe" / "cases.json").read_text())["cases"]
    body, group = [], ""
    for case in cases:
        limit = f"{'over ' if case['locks'] else ''}{100 * case['tolerance']:.3g}"
        numbers = (f"{case['computed']:.5g}", f"{case['theory']:.5g}", case["unit"], f"{100 * case['difference']:+.2f}")
        body.append([case["group"] if case["group"] != group else "", case["name"], *numbers, limit])
        group = case["group"]
    head = ["case", "what", "computed", "theory", "unit", "difference [%]", "allowed [%]"]
    return rows(head, body, left=2)


TABLES: dict[str, Callable[[], str]] = {
    "fe bends": lambda: bend_table(FE),
    "fe bends, shipped": lambda: bend_table(SHIPPED),
    "fe runs": run_table,
    "fe cases": case_table,
}
PICTURES: dict[str, Any] = {}
