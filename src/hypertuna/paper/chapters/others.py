"""Tables V and VI: other fish and robots, and HyperTuna as computed among them."""

from collections.abc import Mapping
from typing import Any

from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS
from hypertuna.paper.ledger import published
from hypertuna.reports.html import Section, Table

COMPUTED = "HyperTuna, computed"


def computed_among(trials: Trials) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the rows of Tables V and VI with the computed robot among them; VI is sorted by falling cost."""
    others, trial = published("others"), trials[OURS]
    published_row = next(row for row in others["hydraulic"]["robots"] if row["name"].startswith("HyperTuna"))
    fastest_swim, turning = trial.gaits["optimised-max"], trial.gaits["turning"]
    robot = published_row | {
        "name": COMPUTED,
        "speed_bl_s": fastest_swim.speed_bl,
        "turning_radius_bl": turning.turn_radius / trial.robot.body.length,
    }
    cheapest = trial.gaits["unoptimised-max"]  # with which the paper measured its least cost
    swimmer = {
        "name": COMPUTED,
        "kind": "mechanical power alone",
        "cost_of_transport_j_per_kg_m": cheapest.cost_of_transport,
    }
    swimmers = [*others["cost"]["swimmers"], swimmer]
    swimmers.sort(key=lambda row: -float(row["cost_of_transport_j_per_kg_m"]))
    return [*others["hydraulic"]["robots"], robot], swimmers


def sections(trials: Trials) -> list[Section]:
    """Show Tables V and VI."""
    from hypertuna.paper.figures import plot_dots

    robots, swimmers = computed_among(trials)
    fast, cost = (
        [(row["name"], row[key], _mark(row)) for row in rows if key in row]
        for rows, key in ((robots, "speed_bl_s"), (swimmers, "cost_of_transport_j_per_kg_m"))
    )
    figures = {
        "table-v": plot_dots(sorted(fast, key=lambda row: -row[1]), "speed [body lengths/s]"),
        "table-vi": plot_dots(cost, "cost of transport [J/(kg m)]", log=True),
    }
    return compose("others", figures | {"robots": robot_table(robots)})


def robot_table(robots: list[dict[str, Any]]) -> Table:
    """Return Table V."""
    keys = ("actuator", "length_m", "joints", "frequency_max_hz", "speed_bl_s")
    rows = []
    for row in robots:
        name = row["name"] + (f" [{row['reference']}]" if "reference" in row else "")
        rows.append([name, *(row[key] for key in keys), row.get("turning_radius_bl", "–")])
    return Table(["robot", "actuator", "length [m]", "joints", "up to [Hz]", "speed [BL/s]", "turn [BL]"], rows)


def _mark(row: Mapping[str, Any]) -> str:
    """Return the kind of a row, by which its dot in a plot is drawn."""
    if row["name"] == COMPUTED:
        return "computed"
    if row["name"].startswith("HyperTuna"):
        return "measured"
    return "fish" if row.get("kind") == "real fish" else "other"


CHAPTER = Chapter("others", sections)
