"""Learning: the curve of the trained policy, and its success beside a plain pilot's; stored by examples/learning."""

import csv
import json
from pathlib import Path

from figures_common import rows
from matplotlib.figure import Figure

from hypertuna.figures import COLORS, WIDTH, styled

LEARNING = Path(__file__).parents[1] / "examples" / "learning"


@styled
def plot_curve() -> Figure:
    """Plot the share of reached points while the policy is trained."""
    with (LEARNING / "goto.csv").open() as file:
        curve = [(int(row["steps"]), float(row["reached"])) for row in csv.DictReader(file)]
    figure = Figure(figsize=(WIDTH, 2.4), layout="constrained")
    axes = figure.subplots()
    axes.plot([steps / 1000 for steps, _ in curve], [100 * reached for _, reached in curve], color=COLORS[1])
    axes.set_xlabel("thousand steps of 0.5 s")
    axes.set_ylabel("reached [%]")
    axes.set_ylim(0, 100)
    axes.set_xlim(0)
    return figure


def goto_table() -> str:
    """Tabulate success, time and energy of policy and pilot."""
    results = json.loads((LEARNING / "goto.json").read_text())
    body = [
        [name, str(one["episodes"]), f"{100 * one['success']:.1f} %", f"{one['seconds']:.1f}", f"{one['joules']:.0f}"]
        for name, one in results.items()
    ]
    return rows(["who, in the body of", "episodes", "reached", "mean time [s]", "mean energy [J]"], body)


PICTURES = {"docs/goto.svg": plot_curve}
TABLES = {"goto": goto_table}
