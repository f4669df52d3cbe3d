"""Tables V and VI: other fish and robots, and HyperTuna as computed among them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypertuna.paper.chapter import Chapter, Trials, prose
from hypertuna.paper.computed import OURS
from hypertuna.paper.ledger import published
from hypertuna.reports.html import WIDTH, Picture, Section, Table

COMPUTED = "HyperTuna, computed"


def computed_among(trials: Trials) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return rows of Table V in their order and of Table VI from the largest cost on, with the computed robot."""
    others, trial = published("others"), trials[OURS]
    own = next(row for row in others["hydraulic"]["robots"] if row["name"].startswith("HyperTuna"))
    fastest, turning = trial.gaits["optimised-max"], trial.gaits["turning"]
    robot = own | {
        "name": COMPUTED,
        "speed_bl_s": fastest.speed_bl,
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
    source = "Others as in the paper's {} (`data/published/others.toml`);"
    speeds = Picture(
        "table-v",
        plot_dots(sorted(fast, key=lambda row: -row[1]), "speed [body lengths/s]", width=WIDTH),
        "Fastest swims of hydraulic soft robotic fish: HyperTuna is twice as fast as the others, and the model "
        "with joint bandwidth agrees.",
        source.format("Table V") + " computed: `optimised-max` of Table IV, joint bandwidth.",
    )
    costs = Picture(
        "table-vi",
        plot_dots(cost, "cost of transport [J/(kg m)]", log=True, width=WIDTH),
        "Cost of transport, largest first, on a logarithmic scale: filled marks are electrical input power, "
        "open ones are of another kind (metabolic for fish, mechanical for the computed robot).",
        source.format("Table VI") + " computed: joints' mechanical power of `unoptimised-max`, joint bandwidth.",
    )
    return [Section("Other fish and robots, Tables V and VI", [prose("others"), speeds, costs, robot_table(robots)])]


def robot_table(robots: list[dict[str, Any]]) -> Table:
    """Return Table V."""
    keys = ("actuator", "length_m", "joints", "frequency_max_hz", "speed_bl_s")
    rows = [
        [
            row["name"] + (f" [{row['reference']}]" if "reference" in row else ""),
            *(row[key] for key in keys),
            row.get("turning_radius_bl", "–"),
        ]
        for row in robots
    ]
    return Table(
        ["robot", "actuator", "length [m]", "joints", "up to [Hz]", "speed [BL/s]", "turn [BL]"],
        rows,
        "Table V; the numbers in brackets are those of the paper's list of references.",
        "The last row is computed with joint bandwidth: `optimised-max` and `turning`.",
    )


def _mark(row: Mapping[str, Any]) -> str:
    """Return the kind of a row in a plot."""
    if row["name"] == COMPUTED:
        return "computed"
    if row["name"].startswith("HyperTuna"):
        return "measured"
    return "fish" if row.get("kind") == "real fish" else "other"


CHAPTER = Chapter("others", sections)
