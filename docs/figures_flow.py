"""Picture of docs/model.md: plates in a flow to and fro, computed and measured; docs/figures.py takes it in."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hypertuna.figures import COLORS, SHAPES, TIGHT, WIDTH, styled

ROWS = Path(__file__).parents[1] / "validation/flow/oscillating.json"  # its oscillating.py makes it
STEPS = {"coarse": 1e-3, "medium": 7e-4, "fine": 5e-4}


@styled
def plot_plates() -> Figure:
    """Plot C_n and C_m of plates and ellipses over the Keulegan-Carpenter number, beside fits to measured plates."""
    rows = [row for row in json.loads(ROWS.read_text()) if row["reynolds"] == 1000 and not row.get("half")]
    figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
    kc = np.linspace(1.7, 8, 100)
    graham = {"drag_normal": 8 * kc ** (-1 / 3)}
    luhar = {"drag_normal": 10 * kc ** (-1 / 3), "added_mass_normal": 1 + 0.35 * kc ** (2 / 3)}
    panels = zip(figure.subplots(1, 2), ("drag_normal", "added_mass_normal"), ("$C_n$", "$C_m$"), strict=True)
    for axes, name, symbol in panels:
        axes.plot(kc, luhar[name], color=COLORS[2], label="measured plates, Luhar and Nepf")
        if name in graham:
            axes.plot(kc, graham[name], "--", color=COLORS[2], label="measured plates, Graham")
        kinds = (("plate", "coarse"), ("plate", "medium"), ("plate", "fine"), ("0.61", "coarse"))
        for (section, mesh), color, shape in zip(kinds, (1, 0, 4, 3), SHAPES, strict=False):
            alike = {"section": section, "mesh": mesh, "step": STEPS[mesh]}
            chosen = [row for row in rows if all(row[key] == alike[key] for key in alike)]
            chosen.sort(key=lambda row: row["kc"])
            cycles = np.array([row[name.replace("normal", "by_cycle")] for row in chosen])
            values = np.array([row[name] for row in chosen])
            bars = np.abs([values - cycles.min(axis=1), cycles.max(axis=1) - values])
            label = f"{'plate' if section == 'plate' else 'ellipse 0.61'}, {mesh} mesh"
            at = [row["kc"] for row in chosen]
            axes.errorbar(at, values, bars, fmt=shape, color=COLORS[color], ms=4.5, lw=1, label=label)
        axes.set(xlabel="Keulegan-Carpenter number", ylabel=symbol, ylim=(0, None))
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, **TIGHT)
    return figure


TABLES: dict[str, Callable[[], str]] = {}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/flow.svg": plot_plates}
