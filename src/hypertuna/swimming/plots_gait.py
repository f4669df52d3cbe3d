"""Figures of a gait and of a gradient."""

import numpy as np
from matplotlib.figure import Figure

from hypertuna.display import plots
from hypertuna.figures import COLORS, FAINT, TIGHT, WIDTH, sequence, styled
from hypertuna.swimming.gait import Gait, gait_text
from hypertuna.swimming.sweep import Gradient

BARS = 12  # number of parameters shown


@plots.of(Gait)
@styled
def plot_gait(gait: Gait, *, width: float = WIDTH) -> Figure:
    """Plot the angle of each joint group over one beat; `width` [inch]."""
    figure = Figure(figsize=(width, 0.36 * width + 0.6), layout="constrained")
    axes = figure.subplots()
    time = np.linspace(0, 1 / gait.frequency, 201)
    colors = COLORS if len(gait.phase) <= len(COLORS) else sequence(len(gait.phase))
    for g, (amplitude, phase, bias) in enumerate(zip(gait.amplitude, gait.phase, gait.bias, strict=True)):
        angle = bias + amplitude * np.sin(2 * np.pi * gait.frequency * time - phase)
        axes.plot(time, np.degrees(angle), color=colors[g], label=f"joint group {g + 1}")
    axes.axhline(0, color=FAINT, lw=0.8)
    axes.set(xlabel="time [s]", ylabel="bend [deg]", title=gait_text(gait), xlim=(0, 1 / gait.frequency))
    figure.legend(loc="outside lower left", ncols=5, **TIGHT)
    return figure


@plots.of(Gradient)
@styled
def plot_gradient(gradient: Gradient, *, width: float = WIDTH) -> Figure:
    """Plot the largest influences on the speed, beside those on the cost of transport; `width` [inch]."""
    influences = {name: gradient.influence(name) for name in ("speed", "cost_of_transport")}
    first = np.argsort(-np.abs(influences["speed"]), kind="stable")[:BARS]
    rows = np.arange(len(first))
    figure = Figure(figsize=(width, 0.26 * len(rows) + 1.2), layout="constrained")
    axes = figure.subplots()
    for k, (name, values) in enumerate(influences.items()):
        place = rows + 0.38 * (k - 0.5)
        axes.barh(place, values[first], height=0.36, color=COLORS[1 - k], label=name.replace("_", " "))
    axes.axvline(0, color=FAINT, lw=0.8)
    axes.set_yticks(rows, [gradient.names[k] for k in first])
    axes.set(ylim=(len(rows) - 0.5, -0.5), xlabel="change for 1 % more of the parameter, or 1 deg more [%]")
    axes.grid(axis="y", visible=False)
    axes.set_title(f"Influence on {gradient.robot.name} at {gradient.gait.frequency:.3g} Hz")
    figure.legend(loc="outside lower left", ncols=2, **TIGHT)
    return figure
