"""Figure of a run at sea: its path from above; depth, pitch and speed over time."""

import numpy as np
from matplotlib.figure import Figure

from hypertuna.figures import COLORS, INK, TIGHT, WIDTH, styled
from hypertuna.simulation.sea_run import SeaRun


@styled
def plot_sea(run: SeaRun, *, width: float = WIDTH) -> Figure:
    """Plot a run at sea: `width` [inch]."""
    figure = Figure(figsize=(width, 0.9 * width), layout="constrained")
    plan, depth, pitch, speed = figure.subplots(4, 1, height_ratios=[2.2, 1, 1, 1])
    east, north = run.position[:, 0], run.position[:, 1]
    plan.plot(east, north, color=COLORS[1], label="nose")
    plan.plot(east[0], north[0], "o", color=INK, ms=5, mfc="white", label="start")
    plan.set(aspect="equal", xlabel="east [m]", ylabel="north [m]", title=f"{run.robot.name} at sea, from above")
    plan.set_adjustable("datalim")
    curves = {"depth [m]": (depth, run.depth), "speed\nahead [m/s]": (speed, run.speed)}
    curves["pitch, nose\nup [deg]"] = (pitch, np.degrees(run.pitch))
    for label, (axes, values) in curves.items():
        axes.plot(run.time, values, color=COLORS[0], lw=0.9)
        axes.set(ylabel=label, xlim=(0, run.duration))
    depth.invert_yaxis()
    for axes in (depth, pitch):
        axes.tick_params(labelbottom=False)
    speed.set_xlabel("time [s]")
    figure.legend(loc="outside lower left", ncols=2, **TIGHT)
    return figure
