"""Figures of a fit to bench runs (loops, singular values, intervals), of a spring and of a family of designs."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.actuation.bending import bend
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import joint_group
from hypertuna.characterization.combinations import DETERMINED
from hypertuna.characterization.designs import LOCKED, NO_BEND, NO_ROOM, Design
from hypertuna.characterization.family import Family
from hypertuna.characterization.fit import BenchFit
from hypertuna.characterization.problem import blocked_moment, shortening
from hypertuna.characterization.spring import SpringFit, moments
from hypertuna.display import plots
from hypertuna.errors import InputError
from hypertuna.figures import COLORS, FAINT, INK, TIGHT, WIDTH, styled

POINTS = 24  # points of a fitted curve
FAR = 5.0  # a row whose angle is more standard deviations from the fit was likely misread
MIN_SINGULAR = 1e-3  # smaller singular values are drawn as zero, at the lower end of the axis
FAR_FROM_BENCH = 3.0  # a design is drawn as excluded if one of its residuals is larger, in standard deviations
EXCLUDED = {  # color and marker by the reason that excludes a design
    NO_ROOM: (FAINT, "x"),
    NO_BEND: (COLORS[0], "+"),
    LOCKED: (COLORS[2], "1"),
    "another measured value": (COLORS[3], "2"),
}


@plots.of(BenchFit)
@styled
def plot_bench(fit: BenchFit, *, width: float = WIDTH) -> Figure:
    """Plot a fit to bench runs: loops of each joint, singular values, and intervals; width [inch]."""
    joints = fit.bench.joints
    figure = Figure(figsize=(width, 0.42 * width + 0.36 * width), layout="constrained")
    grid = figure.add_gridspec(2, len(joints), height_ratios=(1.15, 1))
    for column, joint in enumerate(joints):
        _plot_joint(figure.add_subplot(grid[0, column]), fit, joint)
    lower_row = grid[1, :].subgridspec(1, 2, width_ratios=(1, 1.15))
    _plot_spectrum(figure.add_subplot(lower_row[0]), fit)
    _plot_unknowns(figure.add_subplot(lower_row[1]), fit)
    legend: dict[str, Any] = {}
    for axes in figure.axes[: len(joints)]:
        legend |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(list(legend.values()), list(legend), loc="outside upper right", ncols=5, **TIGHT)
    return figure


def _plot_joint(axes: Axes, fit: BenchFit, joint: int) -> None:
    """Plot the loops of a joint: left bends upwards, right bends downwards."""
    bench = fit.bench
    for loop in bench.loops:
        if loop.joint != joint or not np.isfinite(bench.angle[loop.rows]).any():
            continue
        sign, color = 1 - 2 * loop.side, COLORS[1 - loop.side]
        pressure, unloads = np.linspace(0, loop.top, POINTS), bool(bench.unload[loop.rows].any())
        curve = bend(fit.robot, joint, pressure, side=SIDES[loop.side], unload=unloads)
        for dashes, (pressures, bend_angle) in zip(("-", (0, (4, 2))), curve.branches.values(), strict=False):
            axes.plot(pressures / 1e3, sign * np.degrees(bend_angle), color=color, lw=1.2, ls=dashes)
        for unload, face in ((False, color), (True, "white")):
            rows = loop.rows[bench.unload[loop.rows] == unload]
            if len(rows):
                label = f"{SIDES[loop.side]}, {'unloading' if unload else 'loading'}"
                angles = sign * np.degrees(bench.angle[rows])
                style: Any = {"ms": 4.2, "mec": color, "mfc": face, "mew": 0.9, "color": color}
                axes.plot(bench.pressure[rows] / 1e3, angles, "o", label=label, **style)
    # rows that were likely misread
    noise = np.where(np.isnan(bench.angle_sd), fit.noise.get("angle", np.nan), bench.angle_sd)
    misread = np.abs(fit.angle - bench.angle) > FAR * fit.residual_scale * noise
    misread_rows = np.flatnonzero((bench.joint == joint) & misread)
    if len(misread_rows):
        signs = 1 - 2 * bench.side[misread_rows]
        place = (bench.pressure[misread_rows] / 1e3, signs * np.degrees(bench.angle[misread_rows]))
        axes.plot(*place, "x", color=INK, ms=10, mew=1.3, zorder=5, label="far from the fit")
    axes.axhline(0, color=FAINT, lw=0.8)
    axes.set_title(f"joint {fit.robot.joints[joint].name}")
    axes.set(xlabel="gauge pressure [kPa]", ylabel="bend [deg]", xlim=(0, None))


def _plot_spectrum(axes: Axes, fit: BenchFit) -> None:
    """Plot the singular values: information from the bench relative to that in the prior."""
    values = np.array([direction.singular_value for direction in fit.directions])
    rank = np.arange(1, len(values) + 1)
    determined = np.array([direction.constrained for direction in fit.directions])
    threshold = math.sqrt(DETERMINED**2 - 1)  # a singular value s narrows an interval by sqrt(1 + s^2)
    axes.axhspan(MIN_SINGULAR / 2, threshold, color=FAINT, alpha=0.12, lw=0)
    zero = values < MIN_SINGULAR
    if zero.any():
        at_zero = np.full(zero.sum(), MIN_SINGULAR)
        axes.plot(rank[zero], at_zero, "v", mec=FAINT, mfc="white", ms=5, label="unidentifiable", zorder=3)
    for shown, color, label in ((determined, COLORS[1], "determined"), (~determined & ~zero, FAINT, "not determined")):
        if shown.any():
            axes.vlines(rank[shown], MIN_SINGULAR / 2, values[shown], color=color, lw=1.0)
            axes.plot(rank[shown], values[shown], "o", color=color, ms=5, label=label)
    axes.set_yscale("log")
    axes.set(xlabel="combination of the unknowns", ylabel="singular value")
    axes.set_ylim(MIN_SINGULAR / 2, 100 * max(values.max(), MIN_SINGULAR))  # room for the legend
    axes.set_xticks(rank)
    axes.tick_params(axis="x", labelsize=7.5)
    axes.set_title("spectrum")
    axes.legend(loc="upper right")


def _plot_unknowns(axes: Axes, fit: BenchFit) -> None:
    """Plot the 95 % interval of each unknown between its bounds."""
    for row, unknown in enumerate(fit.parameters):
        color = COLORS[1] if unknown["determined"] else FAINT
        extent = math.log(unknown["upper"] / unknown["lower"])
        low, value, high = (math.log(unknown[key] / unknown["lower"]) / extent for key in ("low", "value", "high"))
        axes.plot([0, 1], [-row, -row], color=FAINT, lw=0.6, alpha=0.5)
        axes.plot([low, high], [-row, -row], color=color, lw=3, solid_capstyle="butt")
        axes.plot(value, -row, "o", color=color, mec="white", ms=4.5)
    axes.set_yticks(-np.arange(len(fit.free)), [unknown.name for unknown in fit.free], fontsize=7.5, color=INK)
    axes.set_xticks([0, 1], ["lower", "upper"])
    axes.set_xlabel("bounds, logarithmic")
    axes.set_title("95 % intervals")
    axes.grid(axis="y", visible=False)


@plots.of(SpringFit)
@styled
def plot_spring(fit: SpringFit, *, width: float = WIDTH) -> Figure:
    """Plot a spring: moments over measured angles, and the fitted curve; width [inch]."""
    figure = Figure(figsize=(width, 0.5 * width), layout="constrained")
    axes, angle = figure.add_subplot(), fit.test.angle
    axes.plot(np.degrees(angle), moments(fit.test, fit.tilt), "o", color=COLORS[1], ms=4.5, label="measured")
    ends = np.linspace(min(angle.min(), fit.zero), max(angle.max(), fit.zero), POINTS)
    x = ends - fit.zero
    label = f"{fit.stiffness:.3g} N m/rad"
    axes.plot(np.degrees(ends), fit.stiffness * x + fit.cubic * x**3, color=COLORS[0], lw=1.2, label=label)
    axes.set(xlabel="angle [deg]", ylabel="moment [N m]")
    axes.legend(loc="upper left")
    return figure


@plots.of(Family)
@styled
def plot_family(family: Family, *, width: float = WIDTH) -> Figure:
    """Plot the blocked moments of members and excluded designs over the lever, one panel a joint; width [inch]."""
    joints = family.space.bench.joints
    figure = Figure(figsize=(width, 0.55 * width), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(joints)))
    for axes, joint in zip(panels, joints, strict=True):
        _plot_designs(axes, family, joint)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=5, **TIGHT)
    return figure


def _plot_designs(axes: Axes, family: Family, joint: int) -> None:
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
    return "another measured value" if np.abs(design.off).max() > FAR_FROM_BENCH else ""
