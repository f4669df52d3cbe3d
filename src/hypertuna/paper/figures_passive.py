"""The figure of the passive joint: costs over speed beside those of the active one, and the best spring over speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hypertuna.figures import COLORS, FAINT, LINES, POINTS, SHAPES, TIGHT, styled
from hypertuna.paper.computed import COSTS
from hypertuna.paper.passive import KINDS, LAWS, PLACE
from hypertuna.reports.html import WIDTH


@styled
def plot_passive(record: Mapping[str, Any], width: float = WIDTH) -> Figure:
    """Plot electrical costs over speed with the range of the family, and the best stiffness over speed."""
    stacked = width == WIDTH
    figure = Figure(figsize=(width, (1.6 if stacked else 0.95) * WIDTH), layout="constrained")
    costs, springs = figure.subplots(*((2, 1) if stacked else (1, 2)))
    for k, (law, label) in enumerate(LAWS.items()):
        for j, kind in enumerate(KINDS):
            best, style = record["electrical"][law][kind], {"color": COLORS[j], "ls": LINES[k]}
            points = [(float(name), best[name]["cost"]) for name in COSTS if best[name]]
            costs.plot(*np.transpose(points), marker=SHAPES[k], **style, **POINTS, label=f"{kind}, {label}")
            for speed in COSTS:
                family = [one[kind][speed]["cost"] for one in record["family"][law].values() if one[kind][speed]]
                if family:
                    x = float(speed) + 0.012 * (j - 0.5) + 0.005 * (k - 0.5)
                    costs.vlines(x, *np.percentile(family, (5, 95)), color=COLORS[j], lw=3, alpha=0.3)
        tuned = record["mechanical"][law][PLACE]["tuned"]
        speeds = np.array([float(name) for name in tuned])
        spring, low, high = ([one[key] for one in tuned.values()] for key in ("stiffness", "low", "high"))
        springs.fill_between(speeds, low, high, color=COLORS[2 + k], alpha=0.2, lw=0)
        springs.plot(speeds, spring, color=COLORS[2 + k], ls=LINES[k], marker=SHAPES[k], **POINTS, label=label)
        springs.plot(
            speeds, spring[0] * (speeds / speeds[0]) ** 2, color=FAINT, lw=1, label="square law" if k else None
        )
    costs.set(xlabel="speed [m/s]", ylabel="electrical cost [J/(kg m)]", ylim=(0, None), xticks=[0.3, 0.4, 0.5])
    springs.set(xlabel="speed [m/s]", ylabel="best stiffness [N m/rad]", xscale="log", yscale="log")
    springs.set_xticks([0.2, 0.3, 0.4], ["0.2", "0.3", "0.4"])
    springs.minorticks_off()
    springs.legend(loc="upper left")
    figure.legend(*costs.get_legend_handles_labels(), loc="outside upper left", ncols=2, **TIGHT)
    return figure
