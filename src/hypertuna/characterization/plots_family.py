"""Figure of a family: the blocked moment over the lever, for members and for excluded designs."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.actuation.soft_joint import joint_group
from hypertuna.characterization.designs import LOCKED, NO_BEND, NO_ROOM, Design
from hypertuna.characterization.family import Family
from hypertuna.characterization.problem import blocked_moment, shortening
from hypertuna.display import plots
from hypertuna.errors import InputError
from hypertuna.figures import COLORS, FAINT, TIGHT, WIDTH, styled

FAR = 3.0  # a design is drawn as excluded if one of its residuals is larger, in standard deviations
EXCLUDED = {  # color and marker by the reason that excludes a design
    NO_ROOM: (FAINT, "x"),
    NO_BEND: (COLORS[0], "+"),
    LOCKED: (COLORS[2], "1"),
    "another measured value": (COLORS[3], "2"),
}


@plots.of(Family)
@styled
def plot_family(family: Family, *, width: float = WIDTH) -> Figure:
    """Plot the blocked moments of members and excluded designs over the lever, one panel a joint; width [inch]."""
    joints = family.space.bench.joints
    figure = Figure(figsize=(width, 0.55 * width), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(joints)))
    for axes, joint in zip(panels, joints, strict=True):
        _plot_joint(axes, family, joint)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=5, **TIGHT)
    return figure


def _plot_joint(axes: Axes, family: Family, joint: int) -> None:
    """Plot a joint's members, colored by shortening, on top of the excluded designs."""
    bench = family.space.bench
    top = float(bench.pressure[bench.joint == joint].max())

    def lever_and_moment(design: Design) -> tuple[float, float]:
        try:
            return 1e3 * joint_group(design.robot, joint)[1].lever, blocked_moment(design.robot, joint, top)
        except InputError:  # muscles that overlap
            return math.nan, math.nan

    for reason, (color, mark) in EXCLUDED.items():
        points = np.array([lever_and_moment(one) for one in family.population.drawn if _excluded(one) == reason])
        if len(points):
            axes.plot(*points.T, mark, color=color, ms=4, mew=0.7, label=reason, zorder=1)
    lever, moment = np.array([lever_and_moment(one) for one in family.members]).T
    shorter = [1e3 * float(shortening(one.robot, joint, np.array([top]))[0]) for one in family.members]
    dots = axes.scatter(lever, moment, c=shorter, s=14, cmap="viridis", label="member", zorder=3)
    axes.figure.colorbar(dots, ax=axes, label="shortening, both sides [mm]")
    axes.plot(
        lever[family.middle],
        moment[family.middle],
        "o",
        ms=9,
        mfc="none",
        mec=COLORS[1],
        mew=1.6,
        label="chosen",
        zorder=4,
    )
    axes.set_title(f"joint {family.space.robot.joints[joint].name}, {top / 1e3:g} kPa")
    axes.set(xlabel="lever [mm]", ylabel="blocked moment [N m]", yscale="log")


def _excluded(design: Design) -> str:
    """Return the reason that excludes a design drawn from the prior; empty if none does."""
    if design.excluded or design.off is None:
        return design.excluded
    return "another measured value" if np.abs(design.off).max() > FAR else ""
