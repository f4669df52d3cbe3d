"""Tables of docs/twin.md, from results stored in validation/twin; docs/figures.py includes them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable
from functools import cache, partial
from pathlib import Path
from typing import Any

from figures_common import FISH, paper_value, rows
from matplotlib.figure import Figure

from hypertuna.description.schema.base import Spread
from hypertuna.paper.computed import SPEEDS
from hypertuna.simulation.estimates import spreads

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "validation" / "twin"
LAWS = {"lumped": "lumped", "strips": "strip"}  # name in the page, and in a robot file
POWERS = {"unoptimised-max": "power/fastest", "optimised-0.5": "power/lake"}  # gaits whose power is published
BANDWIDTH = FISH.joints[0].bandwidth or math.nan


@cache
def stored(name: str) -> dict[str, Any]:
    """Return a stored result of validation/twin, by the name of its file."""
    content: dict[str, Any] = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    return content


def pair(values: Iterable[float], digits: int = 1) -> str:
    """Write the numbers of both joints."""
    return " / ".join(f"{value:.{digits}f}" for value in values)


def run_cells(run: dict[str, Any]) -> list[str]:
    """Write pressures, speed, power and limits of a run."""
    numbers = (f"{run['lowest_kpa']:.0f}", f"{run['speed_m_s']:.3f}", f"{run['power_w']:.1f}")
    return [pair(run["pressure_kpa"], 0), *numbers, ", ".join(run["limits"])]


def amplitude_table(law: str) -> str:
    """Tabulate bends over frequency beside those of joints that lag by their bandwidth."""
    found, body = stored("study")[law], []
    for closed, opened in zip(found["closed"], found["open"], strict=True):
        f = closed["frequency_hz"]
        lag = [a / math.sqrt(1 + (f / BANDWIDTH) ** 2) for a in (16.0, 25.0)]
        bends = [pair(one) for one in (closed["harmonic_deg"], lag, opened["harmonic_deg"])]
        first, rest = bends[:2], run_cells(closed)
        body.append([f"{f:g}", *first, *rest[:-1], bends[2], f"{opened['speed_m_s']:.3f}", rest[-1]])
    heads = ["I / II [deg]", f"lag of {BANDWIDTH:g} Hz", "cylinder I / II [kPa]", "lowest [kPa]", "m/s", "W"]
    return rows(["Hz", *heads, "open loop [deg]", "m/s", "limits"], body, left=0)


def gait_table(law: str) -> str:
    """Tabulate the eight gaits."""
    body = []
    for name, run in stored("study")[law]["gaits"].items():
        pressure, lowest, speed, power, limits = run_cells(run)
        bends = pair(run["swing_deg"])
        body.append([name, f"{paper_value(f'speed/{name}'):g}", speed, bends, pressure, lowest, power, limits])
    heads = ["published [m/s]", "twin [m/s]", "I / II [deg]", "cylinder I / II [kPa]", "lowest [kPa]", "W", "limits"]
    return rows(["gait", *heads], body)


def row_cells(row: dict[str, Any]) -> list[str]:
    """Write eight speeds and the two powers."""
    powers = [f"{row['power_w'][SPEEDS.index(name)]:.1f}" for name in POWERS]
    return [*(f"{speed:.3f}" for speed in row["speed_m_s"]), *powers]


def published_cells() -> list[str]:
    """Write the published numbers of a row: eight speeds and two powers."""
    speeds = [f"{paper_value(f'speed/{name}'):g}" for name in SPEEDS]
    return [*speeds, *(f"{paper_value(name):.1f}" for name in POWERS.values())]


def row_table(law: str) -> str:
    """Tabulate speeds and powers with one change of the robot at a time."""
    found = stored("study")[law]["rows"]
    body = [[label, *row_cells(row), f"{row['rms_percent']:.1f} %"] for label, row in found.items()]
    body.append(["**published**", *published_cells(), ""])
    heads = [name.replace("optimised-", "") for name in SPEEDS]
    return rows(["one change", *heads, "fastest [W]", "lake [W]", "rms"], body)


def bore_table() -> str:
    """Tabulate the pressure needed for the angle of Fig. 8, over the bore of the lines."""
    body = []
    for row in stored("study")["bores"]:
        cells = []
        for pressure, bend in row["pressure_kpa_and_bend_deg"]:
            cells.append(f"{pressure:.0f} kPa" + ("" if bend > 19.9 else f", {bend:.1f} deg only"))
        body.append([f"{row['bore_mm']} mm", *cells])
    return rows(["bore", "1 Hz", "3 Hz", "6 Hz", "6 Hz, joint I asked for 16 deg too"], body, left=0)


def ends(spread: Spread) -> str:
    """Write the range of an estimate; for the working limit, the range of its pressure."""
    low, high = spread.low, spread.high
    if spread.along:
        work = FISH.controller.works_at or math.nan if FISH.controller else math.nan
        low, high = (work * end / 1e3 for end in (low, high))
        return f"{low:g} to {high:g} kPa"
    return f"{low:+g} to {high:+g} K" if spread.added else f"x {low:g} to {high:g}"


def index_table(law: str) -> str:
    """Tabulate Sobol's total indices."""
    found, body = stored("influence")[law], []
    for spread in spreads(FISH).values():
        row = found["indices"][spread.name]
        cells = [f"{total:.2f} ± {error:.2f}" for total, error in zip(row["total"], row["error"], strict=True)]
        body.append([spread.name, ends(spread), *cells])
    spans = [f"{mean:.3g} ± {sd:.2g}" for mean, sd in zip(found["mean"], found["deviation"], strict=True)]
    body.append(
        ["mean ± standard deviation", "", *(f"{s} {u}" for s, u in zip(spans, ("deg", "deg", "m/s"), strict=True))]
    )
    return rows(["estimate", "range", "6 Hz: I", "6 Hz: II", "6 Hz: speed"], body, left=2)


def hinge_table(law: str) -> str:
    """Tabulate speeds and powers over the stiffness of the fin's root."""
    body = []
    for row in stored("influence")[law]["hinges"]:
        errors = [f"{error:.1f} %" for error in row["rms_percent"]]
        body.append([row["stiffness"], *row_cells(row), *errors])
    body.append(["**published**", *published_cells(), "", ""])
    heads = [name.replace("optimised-", "") for name in SPEEDS]
    return rows(["fin [N m/rad]", *heads, "fastest [W]", "lake [W]", "rms, first four", "rms, others"], body)


def interval_table(law: str) -> str:
    """Tabulate bends and pressures over the family."""
    record: dict[str, Any] = json.loads((ROOT / "data/twin/budget.json").read_text(encoding="utf-8"))
    found = record if law == "lumped" else record["strips"]
    keys = ("speed_m_s", "power_w", "bend_deg_I", "bend_deg_II", "cylinder_kpa_I", "cylinder_kpa_II", "lowest_kpa")
    body = []
    for name in SPEEDS:
        ends = [found[key][name] for key in keys]
        cells = ["{1} ({0} to {2})".format(*(f"{end:.3g}" for end in row)) for row in ends]
        body.append([name, *(cells[2:] if law == "lumped" else cells)])
    heads = ["speed [m/s]", "power [W]", "I [deg]", "II [deg]", "cylinder I [kPa]", "cylinder II [kPa]", "lowest [kPa]"]
    return rows(["gait", *(heads[2:] if law == "lumped" else heads)], body)


# Tables that exist for each water law.
OF_A_LAW = {
    "twin reach": amplitude_table,
    "twin gaits": gait_table,
    "twin rows": row_table,
    "twin indices": index_table,
    "twin intervals": interval_table,
    "twin hinges": hinge_table,
}
TABLES: dict[str, Callable[[], str]] = {
    f"{name}, {law}": partial(table, key) for name, table in OF_A_LAW.items() for law, key in LAWS.items()
} | {"twin lines": bore_table}
PICTURES: dict[str, Callable[[], Figure]] = {}
