"""Figure of a dive: depth, pitch, speed and the fins over time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hypertuna.dive import Dive
from hypertuna.figures import COLORS, FAINT, INK, TIGHT, WIDTH, styled

__all__ = ["plot_dive"]


@styled
def plot_dive(done: Dive, *, width: float = WIDTH) -> Figure:
    """Plot a dive.

    Parameters
    ----------
    done : Dive
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
        Depth downward, pitch, speed and fin angle over time; the beat's mean over what it swings about.
    """
    run = done.run
    figure = Figure(figsize=(width, 0.85 * width + 1.2 if width > 6 else 1.6 * width), layout="constrained")
    depth, pitch, speed, fins = figure.subplots(4, 1, sharex=True, height_ratios=[1.5, 1, 1, 0.8])
    depth.plot(run.time, run.depth, color=COLORS[0])
    depth.invert_yaxis()
    for k, leg in enumerate(done.legs):
        start = 0.0 if k == 0 else done.switch
        middle = start + 0.5 * (done.switch if k == 0 else run.duration - done.switch)
        place = run.depth[np.searchsorted(run.time, middle)]
        text = f"{100 * abs(leg.rate):.2g} cm/s {'down' if leg.rate > 0 else 'up'}"
        side = 8 if leg.rate > 0 else -8  # above the line, which falls or rises
        look = {"color": FAINT, "fontsize": 8.5, "ha": "left" if side > 0 else "right"}
        depth.annotate(text, (middle, place), (side, 8), textcoords="offset points", **look)
    swings = ((pitch, np.degrees(run.pitch), "pitch, nose up\n[deg]"), (speed, run.speed, "speed ahead\n[m/s]"))
    half = 0.5 / run.gait.frequency  # at the ends there is no whole beat to average over
    whole = (run.time >= half) & (run.time <= run.duration - half)
    for axes, values, name in swings:
        axes.plot(run.time, values, color=COLORS[0], lw=0.5, alpha=0.35, label="within the beat")
        axes.plot(run.time[whole], run.averaged(values)[whole], color=COLORS[0], label="mean of the beat")
        axes.set(ylabel=name)
    for side, (name, style) in enumerate((("port", "-"), ("starboard", (0, (4, 2))))):
        angle = np.degrees(run.data["fin"][:, side])
        fins.plot(run.time, angle, color=COLORS[1 + side], ls=style, label=f"{name} fin")
    fins.set(ylabel="fins, leading\nedge up [deg]", xlabel="time [s]")
    depth.set(ylabel="depth [m]", xlim=(0, run.duration))
    for axes in (depth, pitch, speed, fins):
        axes.axvline(done.switch, color=INK, lw=0.6, alpha=0.5)
    handles = [*zip(*pitch.get_legend_handles_labels(), strict=True)]
    handles += [*zip(*fins.get_legend_handles_labels(), strict=True)]
    lines, labels = zip(*handles, strict=True)
    figure.legend(lines, labels, loc="outside upper left", ncols=4 if width > 6 else 2, **TIGHT)
    return figure
