"""How sure the twin is: intervals with all that is estimated drawn together, stored by validation/twin/budget.py."""

import json
from collections.abc import Callable, Mapping
from typing import Any

from hypertuna.io.files import shipped
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS, SPEEDS
from hypertuna.paper.ledger import published, published_value
from hypertuna.paper.seeds import taken_hash
from hypertuna.reports.html import Section, Table

POWERS = {"power/fastest": "unoptimised-max", "power/lake": published()["lake"]["gait"]}  # gait of each


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Mapping[str, Any]:
    """Read the intervals; "stale" says whether the robot has changed since."""
    record: dict[str, Any] = json.loads((shipped("data/twin") / "budget.json").read_text(encoding="utf-8"))
    return record | {"stale": record["taken_hash"] != taken_hash(trials[OURS].robot)}


def sections(budget: Mapping[str, Any]) -> list[Section]:
    """Show the intervals beside the published numbers."""
    table, inside, width = interval_table(budget)
    low, high = budget["interval_percent"]
    return compose("budget", {"budget": table}, budget=budget, inside=inside, width=width, percent=high - low)


def interval_table(budget: Mapping[str, Any]) -> tuple[Table, dict[str, bool], float]:
    """Tabulate the intervals; return also which published numbers are inside, and the mean half-width."""
    numbers = {f"speed/{name}": (budget["speed_m_s"][name], "m/s", name) for name in SPEEDS}
    numbers |= {key: (budget["power_w"][gait], "W", f"power, {gait}") for key, gait in POWERS.items()}
    rows, inside, halves = [], {}, []
    for key, ((low, middle, high), unit, label) in numbers.items():
        value = published_value(key)
        inside[key] = low <= value <= high
        halves.append((high - low) / 2 / middle)
        cells = [f"{number:.3g}" for number in (value, middle, low, high)]
        rows.append([label, unit, *cells, f"{100 * halves[-1]:.0f} %", "yes" if inside[key] else "no"])
    heads = ["number", "unit", "published", "median", "5 %", "95 %", "half-width", "inside"]
    return Table(heads, rows), inside, sum(halves) / len(halves)


CHAPTER = Chapter("budget", sections, compute=compute)
