"""Figures of a mission: its track from above, depth and energy over time."""

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from hypertuna.arrays import Array
from hypertuna.control.mission import Mission
from hypertuna.display import plots
from hypertuna.figures import COLORS, EDGE, FAINT, GRID, INK, TIGHT, WIDTH, styled
from hypertuna.mission.file import MissionFile
from hypertuna.mission.flight import Flight
from hypertuna.mission.record import MissionRecord

NARROW = 6.0  # inch: up to this width, legends have fewer columns
TRUE, BELIEVED, POWER = COLORS[1], COLORS[0], COLORS[2]  # colors of true and estimated motion, and of energy
DASHES = (0, (4, 2))  # line style of limits
# By mode of the pilot: its background color, light so that lines stay readable.
BANDS = {"surface": "#DDEBF3", "hold": "#EFE7D6", "home": "#E4EEDD"}
BANDS |= dict.fromkeys(("done", "ended"), "#ECECEC")
HOUR = 3600.0  # s


@plots.of(Flight)
def plot_flight(flight: Flight, *, width: float = WIDTH) -> Figure:
    """Plot the record of a flight; `width` [inch]."""
    figure: Figure = plot_mission(flight.record, width=width)
    return figure


@plots.of(MissionFile)
@styled
def plot_course(file: MissionFile, *, width: float = WIDTH) -> Figure:
    """Plot the course of a mission file; `width` [inch]."""
    mission = file.mission
    low, high = _bounds(mission)
    height = min(0.86 * width * (high[1] - low[1]) / (high[0] - low[0]), 0.8 * width)
    figure = Figure(figsize=(width, height + 1.1), layout="constrained")
    axes = figure.subplots()
    _draw_course(axes, mission, low, high)
    axes.plot(*mission.start, "o", color=INK, ms=5, mfc="white", label="start")
    axes.plot(*mission.home, "s", color=INK, ms=5, label="home")
    axes.set_title(f"Course of the mission {file.name}")
    figure.legend(loc="outside lower left", ncols=4, **TIGHT)
    return figure


@plots.of(MissionRecord)
@styled
def plot_mission(record: MissionRecord, *, width: float = WIDTH) -> Figure:
    """Plot a mission's track from above, and its depth and energy over time; `width` [inch]."""
    wide = width > NARROW
    low, high = _bounds(record.mission, record.path[:, :2])
    plan_height = min(0.86 * width * (high[1] - low[1]) / (high[0] - low[0]), (0.8 if wide else 1.2) * width)
    heights = [plan_height, *((1.5, 1.3) if wide else (1.4, 1.2))][: 3 if record.metered else 2]
    figure = Figure(figsize=(width, sum(heights) + (1.9 if wide else 2.5)), layout="constrained")
    axes = figure.subplots(len(heights), 1, height_ratios=heights)
    _draw_plan(axes[0], record, low, high)
    _draw_depth(axes[1], record)
    if record.metered:
        _draw_energy(axes[2], record)
    axes[-1].set_xlabel(_time_unit(record)[1])
    for part in axes[1:]:
        part.set_xlim(*(record.time[[0, -1]] / _time_unit(record)[0]))
    figure.suptitle(_caption(record), fontsize=8.5, color=FAINT, x=0.01, ha="left", wrap=True)
    figure.legend(*_entries(axes), loc="outside lower left", ncols=5 if wide else 2, **TIGHT)
    return figure


def _entries(panels: Array) -> tuple[list[Artist], list[str]]:
    """Return handles and texts of one legend for all panels, without repeated texts."""
    entries: dict[str, Artist] = {}
    for axes in panels:
        for handle, text in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(text, handle)
    return list(entries.values()), list(entries)


def _caption(record: MissionRecord) -> str:
    """Return the figure's caption of two lines: name and robot, distance and duration."""
    seconds, meters = record.time[-1] - record.time[0], record.distance
    distance_text = f"{meters:.0f}" if meters >= 100 else f"{meters:.2g}"
    duration = f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.2g} min"
    numbers = f"{distance_text} m over ground{'' if record.true else ', estimated'} in {duration}"
    if record.metered and record.energy[-1] > 0:
        numbers += f", {record.energy[-1] / HOUR:.2g} Wh"
    return f"{record.name}, {record.robot}\n{numbers}"


def _bounds(mission: Mission, *paths: Array) -> tuple[Array, Array]:
    """Return the lower left and upper right corners (2,) [m] of all that the plan shows, with a margin."""
    points = [*paths, np.array([mission.start, mission.home]), np.array(mission.fence).reshape(-1, 2)]
    points += [
        np.array([[p.x - p.radius, p.y - p.radius], [p.x + p.radius, p.y + p.radius]]) for p in mission.waypoints
    ]
    everything = np.concatenate(points)
    low, high = everything.min(axis=0), everything.max(axis=0)
    size = max(float((high - low).max()), 1.0)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2 + 0.04 * size, 0.15 * size)
    return middle - half, middle + half


def _draw_plan(axes: Axes, record: MissionRecord, low: Array, high: Array) -> None:
    """Draw course and track from above, within the corners low and high [m]."""
    _draw_course(axes, record.mission, low, high)
    if record.true:
        axes.plot(*record.path[:, :2].T, color=TRUE, lw=1.5, label="true")
    if "position_estimated" in record.data:
        axes.plot(*record.data["position_estimated"][record.every(1.0)].T, color=BELIEVED, lw=1.0, label="estimated")
    axes.plot(*record.path[0, :2], "o", color=INK, ms=5, mfc="white", label="start")
    axes.plot(*record.path[-1, :2], "s", color=INK, ms=5, label="end")


def _draw_course(axes: Axes, mission: Mission, low: Array, high: Array) -> None:
    """Draw the fence, the course and the waypoints from above."""
    if mission.fence:
        axes.add_patch(Polygon(mission.fence, fill=False, ec=COLORS[3], lw=1.2, ls=DASHES, label="fence"))
    axes.plot(*np.array(mission.course).T, color=EDGE, lw=0.8, ls=(0, (1, 2)))
    for k, point in enumerate(mission.waypoints):
        axes.add_patch(Circle((point.x, point.y), point.radius, fill=False, ec=INK, lw=0.9))
        axes.annotate(f"{k + 1}", (point.x, point.y), (5, 5), textcoords="offset points", fontsize=8)
    axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="east [m]", ylabel="north [m]")


def _draw_depth(axes: Axes, record: MissionRecord) -> None:
    """Draw depth over time, with bands that show the pilot's mode."""
    scale, mission = _time_unit(record)[0], record.mission
    _draw_modes(axes, record, scale)
    if record.true:
        axes.plot(record.time / scale, record.depth, color=TRUE, lw=1.2)
    if "depth_estimated" in record.data:
        rows = record.every(1.0)
        axes.plot(record.time[rows] / scale, record.data["depth_estimated"][rows], color=BELIEVED, lw=0.8)
    deepest = max(float(record.depth.max()), *(point.depth for point in mission.waypoints), 0.2)
    levels = ((mission.depth_max, COLORS[3], "depth limit"), (mission.bottom, INK, "ground"))
    for level, color, text in levels if mission.waypoints else ():
        if level < 2.5 * deepest:
            axes.axhline(level, color=color, lw=1.0, ls=DASHES, label=text)
            deepest = max(deepest, level)
    axes.set(ylabel="depth [m]", ylim=(1.08 * deepest, min(-0.05 * deepest, float(record.depth.min()))))


def _draw_modes(axes: Axes, record: MissionRecord, scale: float) -> None:
    """Shade the times in which the pilot is in one of the modes of `BANDS`."""
    if "mode" not in record.data:
        return
    mode = record.data["mode"].astype(int)
    edges = np.flatnonzero(np.diff(mode)) + 1
    for begin, end in zip([0, *edges], [*edges, len(mode) - 1], strict=True):
        name = record.modes[mode[begin]] if 0 <= mode[begin] < len(record.modes) else ""
        if name in BANDS:
            axes.axvspan(
                record.time[begin] / scale, record.time[end] / scale, color=BANDS[name], lw=0, label=f"mode: {name}"
            )


def _draw_energy(axes: Axes, record: MissionRecord) -> None:
    """Draw energy over time, and write the charge left at the end."""
    scale = _time_unit(record)[0]
    axes.plot(record.time / scale, record.energy / HOUR, color=POWER, lw=1.5)
    axes.set(ylabel="energy [Wh]", ylim=(0, None))
    if "charge_left" in record.data:
        axes.annotate(
            f"charge left: {100 * record.data['charge_left'][-1]:.0f} %",
            (0, 1), (4, -4), "axes fraction", "offset points", va="top", fontsize=8.5, bbox={"fc": "white", "ec": GRID},
        )  # fmt: skip


def _time_unit(record: MissionRecord) -> tuple[float, str]:
    """Return the unit of the time axis (s or min) in seconds, and the axis's label."""
    return (60.0, "time [min]") if record.time[-1] - record.time[0] > 600 else (1.0, "time [s]")
