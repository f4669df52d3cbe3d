"""Tables and picture of docs/missions.md; docs/figures.py takes them in."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

from matplotlib.figure import Figure

from hypertuna.description import load
from hypertuna.flight import Flight, fly
from hypertuna.log_fields import BORDER, DERIVED, SCALARS
from hypertuna.mission_file import read_mission, reference
from hypertuna.mission_record import COLUMNS
from hypertuna.plots_mission import plot_mission

SPELLED = {
    "m_s": "m/s",
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
    """Fly the box."""
    return fly(read_mission("box"), load("hypertuna"))


def example() -> str:
    """Quote the transect."""
    return f"```toml\n{(ROOT / 'missions/transect.toml').read_text().rstrip()}\n```"


def topic_table() -> str:
    """Tabulate the topics of a log."""
    lines = ["| topic | has | unit |", "| --- | --- | --- |"]
    lines.append("| `/tf` | `foxglove.FrameTransform` of `robot` and of `estimate` in `world` | m |")
    lines.append("| `/location` | `foxglove.LocationFix`: the place on the Earth, where there is an origin | deg |")
    for topic, names in SCALARS.items():
        for name in names:
            unit = BORDER[COLUMNS[name].unit][0]
            lines.append(f"| `{topic}` | `{name}`: {COLUMNS[name].meaning} | {SPELLED.get(unit, unit)} |")
        if topic == "/motion":
            units = {name: name.split("_", 1)[1] for name in DERIVED}
            lines += [
                f"| `{topic}` | `{k}`: {text} | {SPELLED.get(units[k], units[k])} |" for k, text in DERIVED.items()
            ]
    return "\n".join(lines)


TABLES: dict[str, Callable[[], str]] = {
    "mission example": example,
    "mission keys": reference,
    "log topics": topic_table,
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/mission.svg": lambda: plot_mission(box().record)}
