"""Uncertainty of the twin: its numbers over the family of robots that the paper allows (validation/twin/budget.py)."""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.io.files import shipped
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.chapters.seeds import findings
from hypertuna.paper.chapters.strips import twin_findings
from hypertuna.paper.computed import COSTS, OURS, SPEEDS, TWIN
from hypertuna.paper.ledger import UNPUBLISHED, Finding, published, published_value
from hypertuna.paper.seeds import Stored, taken_hash
from hypertuna.reports.html import Section, Table

POWERS = {"power/fastest": "unoptimised-max", "power/lake": published()["lake"]["gait"]}  # id of a power -> its gait
PERCENT = (5.0, 50.0, 95.0)  # percentiles of a band
# Id of a number of the eight gaits -> table of the stored record that holds its band, and gait.
TABLES = {f"speed/{name}": ("speed_m_s", name) for name in SPEEDS}
TABLES |= {key: ("power_w", gait) for key, gait in POWERS.items()}
TABLES |= {f"power/bound-{speed}": ("power_w", f"unoptimised-{speed}") for speed in COSTS}


@dataclass(frozen=True)
class Budget:
    """Numbers of the twin over the family of robots that the paper allows."""

    record: Mapping[str, Any] = field(default_factory=dict)  # empty where there is no valid one
    reason: str = ""  # why the record does not count; without a full stop

    def judged(self, findings: Iterable[Finding]) -> Iterator[Finding]:
        """Yield findings with the family's bands; without a number where the family's record is stale."""
        entries = self.record.get("entries", {})
        for finding in findings:
            table, name = TABLES.get(finding.id, ("", "")) if finding.model == TWIN else ("", "")
            finding_and_model = f"{finding.id} | {finding.model}"
            band = self.record.get(table, {}).get(name) or entries.get(finding_and_model)
            if self.reason and (band or table):
                yield finding._replace(computed=None, note=self.reason, values=())
            else:
                yield finding._replace(band=(band[0], band[-1])) if band else finding


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Budget:
    """Read the stored numbers of the twin over the family."""
    return read_budget(trials[OURS].robot)


def read_budget(robot: Robot) -> Budget:
    """Read the stored numbers of the twin over the family."""
    return Budget(*read_stored("budget", robot))


def read_stored(name: str, robot: Robot) -> tuple[Mapping[str, Any], str]:
    """Return a file of data/twin, and the reason why it is stale: the robot or its family has changed since."""
    folder, again = shipped("data/twin"), f"validation/twin/{name}.py computes it again"
    try:
        record = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}, f"no {name} of {robot.name}'s family is stored; {again}"
    family = folder / "family.json"
    family_hash = hashlib.sha256(family.read_bytes()).hexdigest() if family.is_file() else None
    if (record["taken_hash"], record.get("family_hash")) != (taken_hash(robot), family_hash):
        return record, f"stale: {robot.name} or its family has changed since the {name} was stored; {again}"
    return record, ""


def bands(robot: Robot, studies: Mapping[str, Mapping[str, Array]]) -> dict[str, list[float]]:
    """Return percentiles of the findings from some studies of the twin, by id and model, without those of `TABLES`.

    Each study has the numbers of `studies.STUDIES`, a value for each member of the family (members,).
    """
    stored = {name: Stored(name, robot, {"numbers": numbers}) for name, numbers in studies.items()}
    results = chain(findings(stored), twin_findings(stored["strips"]) if "strips" in stored else ())
    rows = {f"{one.id} | {one.model}": one.values for one in results if (one.model, one.id in TABLES) != (TWIN, True)}
    return {key: np.percentile(row, PERCENT, method="inverted_cdf").tolist() for key, row in rows.items()}


def sections(budget: Budget) -> list[Section]:
    """Show the intervals beside the published numbers."""
    if not budget.record:
        return []
    table, inside, width = interval_table(budget)
    low, high = budget.record["interval_percent"]
    speeds = sum(inside[f"speed/{name}"] for name in SPEEDS)
    powers = sum(inside[key] for key in POWERS)
    values = {"budget": budget.record, "stale": budget.reason, "width": width, "percent": high - low}
    values |= {"unpublished": UNPUBLISHED}
    return compose("budget", {"budget": table}, speeds=speeds, powers=powers, **values)


def interval_table(budget: Budget) -> tuple[Table, dict[str, bool], float]:
    """Tabulate the intervals; return also which published numbers are inside, and the mean half-width."""
    rows, inside, half_widths = [], {}, []
    for key in (*(f"speed/{name}" for name in SPEEDS), *POWERS):
        table, name = TABLES[key]
        low, median, high = budget.record[table][name]
        value = published_value(key)
        inside[key] = low <= value <= high
        half_widths.append((high - low) / 2 / median)
        cells = [f"{number:.3g}" for number in (value, median, low, high)]
        label, unit = (name, "m/s") if table == "speed_m_s" else (f"power, {name}", "W")
        rows.append([label, unit, *cells, f"{100 * half_widths[-1]:.0f} %", "yes" if inside[key] else "no"])
    header = ["number", "unit", "published", "median", "5 %", "95 %", "half-width", "inside"]
    return Table(header, rows), inside, sum(half_widths) / len(half_widths)


CHAPTER = Chapter("budget", sections, compute=compute)
