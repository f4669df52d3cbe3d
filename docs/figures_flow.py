"""Picture of docs/model.md: plates in a flow to and fro, computed and measured; docs/figures.py includes it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hypertuna.figures import COLORS, SHAPES, TIGHT, WIDTH, styled

ROWS = Path(__file__).parents[1] / "validation/flow/oscillating.json"  # written by oscillating.py beside it


@styled
def plot_plates() -> Figure:
    """Plot C_n and C_m of plates and ellipses over the Keulegan-Carpenter number, beside fits to measured plates."""
    rows = [row for row in json.loads(ROWS.read_text()) if row["half"]]
    figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
    kc = np.linspace(1.7, 8, 100)
    graham = {"drag_normal": 8 * kc ** (-1 / 3)}
    luhar = {"drag_normal": 10 * kc ** (-1 / 3), "added_mass_normal": 1 + 0.35 * kc ** (2 / 3)}
    panels = zip(figure.subplots(1, 2), ("drag_normal", "added_mass_normal"), ("$C_n$", "$C_m$"), strict=True)
    for axes, name, symbol in panels:
        axes.plot(kc, luhar[name], color=COLORS[2], label="measured plates, Luhar and Nepf")
        if name in graham:
            axes.plot(kc, graham[name], "--", color=COLORS[2], label="measured plates, Graham")
        kinds = [("plate", "coarse"), ("plate", "fine"), ("0.56", "coarse"), ("0.61", "coarse"), ("0.69", "coarse")]
        for (section, mesh), color, shape in zip(kinds, (1, 4, 3, 3, 3), SHAPES, strict=False):
            chosen = [row for row in rows if (row["section"], row["mesh"]) == (section, mesh)]
            cycles = [row[name.replace("normal", "by_cycle")] for row in chosen]
            values = np.array([row[name] for row in chosen])
            bars = [values - [min(each) for each in cycles], [max(each) for each in cycles] - values]
            label = f"plate, {mesh} mesh" if section == "plate" else f"ellipse, b/a = {section}"
            at = [row["kc"] for row in chosen]
            axes.errorbar(at, values, np.abs(bars), fmt=shape, color=COLORS[color], ms=4.5, lw=1, label=label)
        axes.set(xlabel="Keulegan-Carpenter number", ylabel=symbol, ylim=(0, None))
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, **TIGHT)
    return figure


TABLES: dict[str, Callable[[], str]] = {}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/flow.svg": plot_plates}
