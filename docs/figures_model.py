"""Tables of docs/model.md; docs/figures.py includes them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from figures_common import FISH, paper_value, rows

from hypertuna.description.schema.water import LAWS
from hypertuna.paper.computed import SPEEDS
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.swim import swim

STUDY = Path(__file__).parents[1] / "validation/hydrodynamics/results.json"  # written by study.py beside it


def law_table() -> str:
    """Tabulate the eight speeds by water law [m/s]."""
    body = [
        [f"`{name}`", f"{paper_value(f'speed/{name}'):g}"]
        + [f"{swim(FISH.using(water=law), named_gait(FISH, name)).speed:.3f}" for law in LAWS]
        for name in SPEEDS
    ]
    return rows(["gait", "published", *LAWS], body)


def strip_table() -> str:
    """Tabulate the errors of the eight speeds with other coefficients of the strip law."""
    truth, body = np.array([paper_value(f"speed/{name}") for name in SPEEDS]), []
    for name, result in json.loads(STUDY.read_text())["results"].items():
        errors = 100 * (np.array(result["speeds"]) / truth - 1)
        sizes = [f"{np.sqrt(np.mean(part**2)):.1f}" for part in (errors[:4], errors[4:], errors)]
        lag = "" if result["bandwidth"] is None else f"{result['bandwidth']:.2f}"
        costs = ", ".join(f"{cost:+.0f}" for cost in result["costs"])
        body.append([name, f"{1e4 * result['blunt_area']:.0f}", lag, *sizes, costs])
    head = ["strips", "$C_D A$ [cm²]", "lag [Hz]", "four [%]", "other four [%]", "eight [%]", "costs [%]"]
    return rows(head, body)


TABLES: dict[str, Callable[[], str]] = {"law speeds": law_table, "strip variants": strip_table}
PICTURES: dict[str, Callable[[], object]] = {}
