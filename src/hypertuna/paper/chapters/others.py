"""Tables V and VI: other fish and robots, and HyperTuna as computed among them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypertuna.paper.computed import OURS, Trial
from hypertuna.paper.ledger import published
from hypertuna.reports.html import WIDTH, Part, Picture, Section, Table

__all__ = ["computed_among", "sections"]

COMPUTED = "HyperTuna, computed"


def computed_among(trials: Mapping[str, Trial]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Place the computed robot among those of Tables V and VI.

    Parameters
    ----------
    trials : mapping of str to Trial

    Returns
    -------
    robots, swimmers : list of dict
        Rows of Table V, in their order; of Table VI, dearest first. Keys as in data/published/others.toml.
    """
    others, trial = published("others"), trials[OURS]
    own = next(row for row in others["hydraulic"]["robots"] if row["name"].startswith("HyperTuna"))
    fastest, turning = trial.gaits["optimised-max"], trial.gaits["turning"]
    robot = own | {
        "name": COMPUTED,
        "speed_bl_s": fastest.speed_bl,
        "turning_radius_bl": turning.turn_radius / trial.robot.body.length,
    }
    cheapest = trial.gaits["unoptimised-max"]  # where the paper measured its least cost
    swimmer = {
        "name": COMPUTED,
        "kind": "mechanical power alone",
        "cost_of_transport_j_per_kg_m": cheapest.cost_of_transport,
    }
    swimmers = sorted(
        [*others["cost"]["swimmers"], swimmer], key=lambda row: -float(row["cost_of_transport_j_per_kg_m"])
    )
    return [*others["hydraulic"]["robots"], robot], swimmers


def sections(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> list[Section]:
    """Show Tables V and VI.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    list of Section
    """
    from hypertuna.paper.figures import plot_dots

    robots, swimmers = computed_among(trials)
    fast, cost = (
        [(row["name"], row[key], _mark(row)) for row in rows if key in row]
        for rows, key in ((robots, "speed_bl_s"), (swimmers, "cost_of_transport_j_per_kg_m"))
    )
    source = "Others as the paper's {} has them (`data/published/others.toml`);"
    parts: list[Part] = [
        """The paper sets its robot beside other hydraulic fish (Table V) and beside robots and fish of all kinds
(Table VI). Here are the same numbers, with HyperTuna as computed among them. The speed can be compared. The turn of
the model is that of the published gait, which it swims tail first. The costs are not of one kind: **the robots' is
electrical input power, the fishes' metabolic, and the computed one the mechanical power of the joints alone**,
without pump, servos and losses.""",
        Picture(
            "table-v",
            plot_dots(sorted(fast, key=lambda row: -row[1]), "speed [body lengths/s]", width=WIDTH),
            "Fastest swims of hydraulic soft robotic fish: HyperTuna is twice as fast as the others, and the model "
            "with joint bandwidth agrees.",
            source.format("Table V") + " computed: `optimised-max` of Table IV, joint bandwidth.",
        ),
        Picture(
            "table-vi",
            plot_dots(cost, "cost of transport [J/(kg m)]", log=True, width=WIDTH),
            "Cost of transport, dearest first, on a logarithmic scale: filled marks are electrical input power, "
            "open ones are of another kind (metabolic for fish, mechanical for the computed robot).",
            source.format("Table VI") + " computed: joints' mechanical power of `unoptimised-max`, joint bandwidth.",
        ),
        robot_table(robots),
    ]
    return [Section("Other fish and robots, Tables V and VI", parts)]


def _mark(row: Mapping[str, Any]) -> str:
    """Say how a row is drawn."""
    if row["name"] == COMPUTED:
        return "computed"
    if row["name"].startswith("HyperTuna"):
        return "measured"
    return "fish" if row.get("kind") == "real fish" else "other"


def robot_table(robots: list[dict[str, Any]]) -> Table:
    """Write Table V."""
    rows = [
        [
            row["name"] + (f" [{row['reference']}]" if "reference" in row else ""),
            row["actuator"],
            row["length_m"],
            row["joints"],
            row["frequency_max_hz"],
            row["speed_bl_s"],
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
