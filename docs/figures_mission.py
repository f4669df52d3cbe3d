"""Tables and picture of docs/missions.md; docs/figures.py includes them."""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from figures_reference import sections
from matplotlib.figure import Figure

from hypertuna.description.robot import load
from hypertuna.mission.file import missions, read_mission
from hypertuna.mission.flight import Flight, fly
from hypertuna.mission.log_fields import BORDER, DERIVED
from hypertuna.mission.plots import plot_mission
from hypertuna.mission.record import TOPICS
from hypertuna.mission.schema import Document
from hypertuna.paper.chapters.lake import read_lake
from hypertuna.paper.ledger import published
from hypertuna.paper.seeds import read_seeds
from hypertuna.paper.studies import LAKE_GAITS

# Unit as it ends a name -> unit as printed.
SPELLED = {
    "m_s": "m/s",
    "m_s2": "m/s²",
    "us": "µs",
    "a": "A",
    "deg_s": "deg/s",
    "kpa": "kPa",
    "wh": "Wh",
    "ah": "Ah",
    "hz": "Hz",
    "v": "V",
    "w": "W",
    "": "1",
}
ROOT = Path(__file__).resolve().parents[1]


@cache
def box() -> Flight:
    """Fly the mission `box`."""
    return fly(read_mission("box"), load("hypertuna"))


def example() -> str:
    """Quote the file of the mission `transect`."""
    return f"```toml\n{(ROOT / 'missions/transect.toml').read_text().rstrip()}\n```"


def topic_table() -> str:
    """Tabulate the topics of a log."""
    lines = ["| topic | has | unit |", "| --- | --- | --- |"]
    lines.append("| `/tf` | `foxglove.FrameTransform` of `robot` and of `estimate` in `world` | m |")
    lines.append("| `/location` | `foxglove.LocationFix`: the place on the Earth, where there is an origin | deg |")
    for topic, columns in list(TOPICS.items())[1:]:
        for name, column in columns.items():
            unit = BORDER[column.unit][0]
            lines.append(f"| `{topic}` | `{name}`: {column.meaning} | {SPELLED.get(unit, unit)} |")
        if topic == "/motion":
            units = {name: name.split("_", 1)[1] for name in DERIVED}
            lines += [
                f"| `{topic}` | `{k}`: {text} | {SPELLED.get(units[k], units[k])} |" for k, text in DERIVED.items()
            ]
    return "\n".join(lines)


def lake_table() -> str:
    """Tabulate the stored swim of the lake beside the published one."""
    told = read_lake().record
    assert told is not None, "run validation/missions/lake.py"
    values = published()["values"]
    rows = [
        (
            "distance, over ground, within 30 min [m]",
            f"{values['lake/distance']['value']:g}",
            f"{told['distance_m']:.0f}",
        ),
        ("energy of the servos [Wh]", f"{values['lake/energy']['value']:g}", f"{told['servo_energy_wh']:.2f}"),
        ("energy of the battery [Wh]", "", f"{told['battery_energy_wh']:.2f}"),
        ("time until it is home again [min]", "", f"{told['whole']['duration_s'] / 60:.1f}"),
        ("max error of the estimated position [m]", "", f"{told['whole']['estimation_error_max_m']:.1f}"),
        ("min fence margin [m]", "", f"{told['whole']['fence_margin_min_m']:.1f}"),
    ]
    lines = ["| | published | twin at sea |", "| --- | ---: | ---: |"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def straight_table() -> str:
    """Tabulate straight runs of the twin at sea beside the paper's swim."""
    stored = read_seeds("lakes", load("hypertuna"))
    assert stored.record is not None, stored.reason
    values = published()["values"]
    body = [["published", f"{values['lake/speed']['value']:g}", f"{values['power/lake']['value']:g}"]]
    for name, what in zip(LAKE_GAITS, ("the paper's gait", "the pilot's next slower gait"), strict=True):
        speed, power = (float(np.median(stored.numbers[f"{name} {key}"])) for key in ("speed", "power"))
        body.append([f"`{name}`, {what}", f"{speed:.3f}", f"{power:.1f}"])
    lines = ["| median of 32 seeds | speed over ground [m/s] | power of the servos [W] |", "| --- | ---: | ---: |"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in body)])


def flown(mission: str) -> list[dict[str, str]]:
    """Return the stored flights of a mission, with random currents and gaps of the satellite fixes."""
    text = (ROOT / "validation" / "missions" / f"{mission}-seeds.csv").read_text()
    return list(csv.DictReader(text.splitlines()))


def done(flights: list[dict[str, str]]) -> int:
    """Count the flights that are done."""
    return sum(flight["status"] == "done" for flight in flights)


def shipped_table() -> str:
    """Tabulate how many stored flights of each shipped mission are done, and how long they take."""
    lines = ["| mission | seeds | done | time [min] | energy of the battery [Wh] |"]
    lines.append("| --- | ---: | ---: | ---: | ---: |")
    for name in missions():
        flights = flown(name)
        time, energy = (np.array([float(flight[key]) for flight in flights]) for key in ("duration_s", "energy_wh"))
        spans = (f"{v.min():.3g} to {v.max():.3g}" for v in (time / 60, energy))
        lines.append(f"| `{name}` | {len(flights)} | {done(flights)} | {' | '.join(spans)} |")
    return "\n".join(lines)


def seeds_table() -> str:
    """Tabulate the stored swims of the lake with scattered currents and gaps: least, mean, largest of each number."""
    flights = flown("lake")
    lines = [f"| {len(flights)} seeds, {done(flights)} done | min | mean | max |", "| --- | ---: | ---: | ---: |"]
    for name, (meaning, scale) in OVER_SEEDS.items():
        values = np.array([float(flight[name]) for flight in flights]) / scale
        lines.append(f"| {meaning} | {values.min():.3g} | {values.mean():.3g} | {values.max():.3g} |")
    return "\n".join(lines)


# Column of a stored flight -> label, and divisor of its values.
OVER_SEEDS = {
    "duration_s": ("time [min]", 60),
    "distance_m": ("distance, over ground [m]", 1),
    "energy_wh": ("energy of the battery [Wh]", 1),
    "depth_max_m": ("max depth [m]", 1),
    "estimation_error_max_m": ("max error of the estimated position [m]", 1),
    "fence_margin_min_m": ("min fence margin [m]", 1),
    "goal_distance_m": ("goal distance, at the end [m]", 1),
}


TABLES: dict[str, Callable[[], str]] = {
    "mission example": example,
    "mission keys": lambda: sections(Document),
    "log topics": topic_table,
    "lake": lake_table,
    "lake straight": straight_table,
    "lake seeds": seeds_table,
    "shipped missions": shipped_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/mission.svg": lambda: plot_mission(box().record)}
