"""Figures of the twin: a whole run, pressures over a beat, posture tests, dives, and runs at sea."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from hypertuna.arrays import Array
from hypertuna.control.controller import soft_limit
from hypertuna.description.robot import require
from hypertuna.display import plots
from hypertuna.errors import InputError
from hypertuna.figures import COLORS, FAINT, GRID, INK, POINTS, SHAPES, TIGHT, WIDTH, sequence, styled
from hypertuna.simulation.dive import Dive
from hypertuna.simulation.posture import MAX_ERROR, Held, PostureTest
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.sea_run import SeaRun

if TYPE_CHECKING:
    from matplotlib.gridspec import GridSpec

KILO = 1e3  # pascals per kilopascal
BEAT_SAMPLES = 100  # samples per beat; coarser records fold several beats onto one
LETTERS, HANDLE = 52, 4  # letters that fit into a legend above a panel; width of an entry's line and gap [letters]
BEATS = 4  # last beats of which angles, pressures and power are shown
SIDES = ("-", (0, (4, 1.5)))  # line styles of left and right circuits


@plots.of(TwinRun)
@styled
def plot_twin(run: TwinRun, *, width: float = WIDTH) -> Figure:
    """Plot a run of the twin; `width` [inch]."""
    two_columns = width > 6
    water = run.medium == "water"
    oil = [_draw_pressures] if run.circuits else []
    kinds = [_draw_angles, *oil, _draw_power, *([_draw_speed, _draw_path] if water else [_draw_peaks])]
    rows = (len(kinds) + 1) // 2 if two_columns else len(kinds)
    figure = Figure(figsize=(width, 2.05 * rows + 0.5), layout="constrained")
    grid: GridSpec = figure.add_gridspec(rows, 2 if two_columns else 1)
    for k, draw in enumerate(kinds):
        fills_row = two_columns and k == len(kinds) - 1 and k % 2 == 0
        place: Any = grid[k // 2, slice(None) if fills_row else k % 2] if two_columns else grid[k, 0]
        draw(figure.add_subplot(place), run)
    gait = run.gait
    angles, lags = (", ".join(f"{a:.3g}" for a in np.degrees(part).round(9)) for part in (gait.amplitude, gait.phase))
    bias = f", bias {', '.join(f'{a:.3g}' for a in np.degrees(gait.bias))}°" if any(gait.bias) else ""
    conditions = f"in {run.medium}{bias}{'' if run.closed_loop else ', open loop'}"
    caption = f"{run.robot.name}: {gait.frequency:g} Hz, {angles}° set, phase {lags}°, {conditions}"
    figure.suptitle(caption, fontsize=8.5, color=FAINT, x=0.01, ha="left")
    return figure


@styled
def plot_pressures(run: TwinRun, *, width: float = WIDTH) -> Figure:
    """Plot the pressures in pumps and drive units over one beat, a panel for each joint; `width` [inch]."""
    joints = [group.name for group in run.robot.joints if group.drive.oil]
    if not joints:
        raise InputError("has no oil: servos turn its joints", key=f"robot {run.robot.name}", fix="plot the run itself")
    beats = max(1, round(BEAT_SAMPLES * (run.time[1] - run.time[0]) * run.gait.frequency)) if run.settled else 1
    rows = _last(run, beats)
    phase = (run.time[rows] - run.time[rows][0]) * run.gait.frequency
    phase = phase % 1.0 if beats > 1 else phase
    order = np.argsort(phase)
    rows, phase = rows[order], phase[order]
    figure = Figure(figsize=(width, 1.75 * len(joints) + 0.75), layout="constrained")
    panels = figure.subplots(len(joints), 1, sharex=True, squeeze=False)[:, 0]
    for j, (axes, name) in enumerate(zip(panels, joints, strict=True)):
        _draw_bounds(axes, run)
        for side, label in enumerate(("left", "right")):
            pump, unit = (run.data[f"{part}_pressure"][rows, 2 * j + side] / KILO for part in ("pump", "unit"))
            axes.plot(phase, pump, color=COLORS[side], label=f"{label}: pump")
            axes.plot(phase, unit, color=COLORS[side], lw=1.1, ls=SIDES[1], label="units")
        axes.set(title=f"joint {name}", ylabel="pressure [kPa]")
    panels[-1].set(xlabel="time [beats]", xlim=(0, 1))
    handles, texts = panels[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside upper left", ncols=4, **TIGHT)
    return figure


def _last(run: TwinRun, beats: int) -> NDArray[np.intp]:
    """Return the indices of the rows of the last `beats` beats."""
    step = run.time[1] - run.time[0]
    count = min(len(run.time), round(beats / (run.gait.frequency * step)) + 1)
    return np.arange(len(run.time) - count, len(run.time))


def _draw_angles(axes: Axes, run: TwinRun) -> None:
    """Draw the bends of the last beats and their setpoints."""
    rows = _last(run, BEATS)
    for j, group in enumerate(run.robot.joints):
        color = COLORS[j % len(COLORS)]
        axes.plot(run.time[rows], np.degrees(run.data["angle"][rows, j]), color=color, label=f"joint {group.name}")
        axes.plot(run.time[rows], np.degrees(run.data["angle_set"][rows, j]), color=color, lw=0.9, ls=SIDES[1])
    axes.plot([], [], color=FAINT, lw=0.9, ls=SIDES[1], label="set")
    _finish(axes, run.time[rows], "bend [deg]")


def _draw_pressures(axes: Axes, run: TwinRun) -> None:
    """Draw pump pressures over the last beats: lines at the ticks, bands from lowest to highest within ticks."""
    rows = _last(run, BEATS)
    _draw_bounds(axes, run)
    for c, name in enumerate(run.circuits):
        color = COLORS[run.joints.index(name.rpartition("-")[0]) % len(COLORS)]
        low, middle, high = (run.data[f"pump_pressure{end}"][rows, c] / KILO for end in ("_low", "", "_high"))
        axes.fill_between(run.time[rows], low, high, color=color, alpha=0.3, lw=0)
        axes.plot(run.time[rows], middle, color=color, ls=SIDES[c % 2], lw=1.2, label=name)
    _finish(axes, run.time[rows], "pump pressure [kPa]")


def _draw_bounds(axes: Axes, run: TwinRun) -> None:
    """Draw the soft pressure limit and the pressure of cavitation."""
    cavitation = require(run.robot.oil, "oil").cavitation
    style: Any = {"textcoords": "offset points", "ha": "right", "va": "bottom", "fontsize": 7, "color": INK}
    style["bbox"] = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.5}
    for bound, text in ((soft_limit(run.robot), "soft limit"), (cavitation, "cavitation")):
        axes.axhline(bound / KILO, color=INK, lw=0.9, ls=(0, (1, 2)))
        axes.annotate(text, (1, bound / KILO), (-2, 2), xycoords=("axes fraction", "data"), **style)


def _draw_power(axes: Axes, run: TwinRun) -> None:
    """Draw the electrical power of the last beats."""
    rows = _last(run, BEATS)
    axes.plot(run.time[rows], run.data["power"][rows], color=COLORS[2], label="servos")
    axes.axhline(run.electrical_power, color=INK, lw=0.9, ls=SIDES[1], label=f"mean {run.electrical_power:.3g} W")
    axes.set_ylim(0, None)
    _finish(axes, run.time[rows], "electrical power [W]")


def _draw_speed(axes: Axes, run: TwinRun) -> None:
    """Draw the forward speed of the whole run, and its mean over each beat."""
    step, speed = run.time[1] - run.time[0], run.data["speed"]
    axes.plot(run.time, speed, color=COLORS[1], lw=0.7, alpha=0.5)
    window = max(1, round(1 / (run.gait.frequency * step)))
    if len(speed) > window:
        mean = np.convolve(speed, np.full(window, 1 / window), mode="valid")
        axes.plot(run.time[: len(mean)] + 0.5 * window * step, mean, color=COLORS[1], lw=1.8, label="mean of a beat")
    _finish(axes, run.time, "speed [m/s]")


def _draw_peaks(axes: Axes, run: TwinRun) -> None:
    """Draw the bends of the whole run, and the peaks that the setpoints ask for."""
    for j, group in enumerate(run.robot.joints):
        color = COLORS[j % len(COLORS)]
        axes.plot(run.time, np.degrees(run.data["angle"][:, j]), color=color, lw=0.8, label=f"joint {group.name}")
        for sign in (-1, 1):
            peak = np.degrees(run.gait.bias[j] + sign * run.gait.amplitude[j])
            axes.axhline(peak, color=color, lw=0.9, ls=SIDES[1])
    _finish(axes, run.time, "bend [deg]")


def _draw_path(axes: Axes, run: TwinRun) -> None:
    """Draw the path of the nose."""
    axes.plot(run.data["x"], run.data["y"], color=COLORS[0], lw=1.2)
    axes.plot(run.data["x"][:1], run.data["y"][:1], "o", color=INK, ms=5)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="path of the nose, from the dot")
    axes.set_aspect("equal", adjustable="datalim")


def _finish(axes: Axes, time: Array, label: str) -> None:
    """Label the axes of a panel over time [s], and put the legend above it in as many rows as needed."""
    axes.set(xlabel="time [s]", ylabel=label, xlim=(time[0], time[-1]))
    longest = max((len(text) for text in axes.get_legend_handles_labels()[1]), default=1) + HANDLE
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=max(1, min(4, LETTERS // longest)), **TIGHT)


ERROR_HEADROOM = 1.3  # top of the error axis over the largest error
HEADROOM = 1.08  # top of the amplitude axis over its default
ERROR_TICKS = (0, 0.25, 0.5, 1, 2, 5, 10, 20, 40)  # deg


@plots.of(PostureTest)
@styled
def plot_posture(test: PostureTest, *, width: float = WIDTH) -> Figure:
    """Plot the paper's Fig. 8: how a joint's bend grows to its set angle, and the errors of peaks; `width` [inch]."""
    joints = list(dict.fromkeys(one.joint for one in test.held))
    frequencies = sorted({one.frequency for one in test.held})
    frequency = frequencies[min(1, len(frequencies) - 1)]
    rows = 3 if test.reach else 2
    beside = width > 6 and len(joints) > 1  # else one joint below the other
    panel_rows = rows if beside else rows * len(joints)
    figure = Figure(figsize=(width, 2.0 * panel_rows + 0.7), layout="constrained")
    panels = figure.subplots(panel_rows, len(joints) if beside else 1, squeeze=False)
    columns = panels.T if beside else panels.reshape(len(joints), rows)
    for column, joint in zip(columns, joints, strict=True):
        held = [one for one in test.held if one.joint == joint]
        _draw_bend(column[0], next(one for one in held if one.frequency == frequency))
        _draw_errors(column[1], held)
        if test.reach:
            _draw_reach(column[2], test, joint)
    handles, texts = columns[0][1].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside upper left", ncols=min(len(texts), 6 if width > 6 else 3), **TIGHT)
    return figure


@styled
def plot_limits(
    frequency: ArrayLike,
    ratio: Mapping[str, ArrayLike],
    bandwidth: float,
    *,
    width: float = WIDTH,
) -> Figure:
    """Plot the amplitude that joints reach over frequency, compared with a first-order lag.

    `frequency` (frequencies,) [Hz], `ratio` of reached to set amplitude (frequencies,) by joint, `bandwidth` [Hz].
    """
    figure = Figure(figsize=(width, 0.62 * width), layout="constrained")
    axes = figure.subplots()
    hertz = np.asarray(frequency, dtype=np.float64)
    curve_hertz = np.linspace(0, 1.05 * hertz.max(), 200)
    lag = 1 / np.sqrt(1 + (curve_hertz / bandwidth) ** 2)
    axes.plot(curve_hertz, lag, color=INK, lw=1.1, ls=(0, (4, 2)), label=f"first-order lag of {bandwidth:g} Hz")
    for k, (name, values) in enumerate(ratio.items()):
        axes.plot(hertz, values, color=COLORS[k], marker=SHAPES[k], **POINTS, label=name)
    axes.set(xlabel="frequency [Hz]", ylabel="amplitude reached over set", xlim=(0, curve_hertz[-1]), ylim=(0, None))
    figure.legend(loc="outside upper left", ncols=2, **TIGHT)
    return figure


def _draw_bend(axes: Axes, held: Held) -> None:
    """Draw a joint's bend from rest, and lines at its set angle to both sides."""
    time, angle = held.run.time, np.degrees(held.run.data["angle"][:, held.joint])
    for sign in (-1, 1):
        axes.axhline(sign * np.degrees(held.angle_set), color=INK, lw=1.0, ls=(0, (4, 2)))
    axes.plot(time, angle, color=COLORS[1], lw=1.0)
    title = f"joint {held.name} at {held.frequency:g} Hz"
    axes.set(title=title, xlabel="time [s]", ylabel="bend [deg]", xlim=(0, time[-1]))


def _draw_errors(axes: Axes, held: Sequence[Held]) -> None:
    """Draw the error of each beat's peak bend; its scale is linear where settled, logarithmic beyond."""
    axes.axhspan(0, np.degrees(MAX_ERROR), color=GRID, lw=0)
    marks: Any = {"marker": "o", "ms": 2.5, "lw": 1.2}
    for one, color in zip(held, sequence(len(held)), strict=True):
        axes.plot(one.time, np.degrees(one.error), color=color, label=f"{one.frequency:g} Hz", **marks)
    axes.set(xlabel="time [s]", ylabel="error of the\npeak bend [deg]", xlim=(0, max(one.time[-1] for one in held)))
    largest = max(np.degrees(held[0].angle_set), *(float(np.degrees(one.error).max()) for one in held))
    axes.set_yscale("symlog", linthresh=np.degrees(MAX_ERROR), linscale=0.8)
    ticks = [tick for tick in ERROR_TICKS if tick < largest]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(0, ERROR_HEADROOM * largest)


def _draw_reach(axes: Axes, test: PostureTest, joint: int) -> None:
    """Draw the largest amplitude that a joint holds over frequency, compared with a first-order lag."""
    hertz, largest = np.transpose([(far.frequency, far.amplitude_max) for far in test.reach if far.joint == joint])
    axes.plot(hertz, np.degrees(largest), color=COLORS[0], marker="o", **POINTS, label="held")
    group = test.robot.joints[joint]
    if group.bandwidth and group.bend_max:
        curve_hertz = np.linspace(0, hertz.max(), 200)
        lag = np.degrees(group.bend_max) / np.sqrt(1 + (curve_hertz / group.bandwidth) ** 2)
        axes.plot(curve_hertz, lag, color=FAINT, lw=1.1, ls=(0, (4, 2)), label=f"lag of {group.bandwidth:g} Hz")
    axes.axhline(np.degrees(test.angle[joint]), color=INK, lw=0.9, ls=(0, (1, 2)), label="set")
    axes.set(xlabel="frequency [Hz]", ylabel="largest amplitude\nheld [deg]", xlim=(0, None))
    axes.set_ylim(0, HEADROOM * axes.get_ylim()[1])  # keeps the curve's flat top off the panel's edge
    axes.legend(loc="lower left", ncols=3, **TIGHT)


@plots.of(Dive)
@styled
def plot_dive(dive: Dive, *, width: float = WIDTH) -> Figure:
    """Plot a dive; `width` [inch]."""
    run = dive.run
    figure = Figure(figsize=(width, 0.85 * width + 1.2 if width > 6 else 1.6 * width), layout="constrained")
    depth, pitch, speed, fins = figure.subplots(4, 1, sharex=True, height_ratios=[1.5, 1, 1, 0.8])
    depth.plot(run.time, run.depth, color=COLORS[0])
    depth.invert_yaxis()
    middles = (0.5 * dive.switch, 0.5 * (dive.switch + run.duration))
    for middle, leg in zip(middles, dive.legs, strict=False):
        place = run.depth[np.searchsorted(run.time, middle)]
        text = f"{100 * abs(leg.depth_rate):.2g} cm/s {'down' if leg.depth_rate > 0 else 'up'}"
        side = 8 if leg.depth_rate > 0 else -8  # keeps the text above the falling or rising line
        look = {"color": FAINT, "fontsize": 8.5, "ha": "left" if side > 0 else "right"}
        depth.annotate(text, (middle, place), (side, 8), textcoords="offset points", **look)
    swings = ((pitch, np.degrees(run.pitch), "pitch, nose up\n[deg]"), (speed, run.speed, "speed ahead\n[m/s]"))
    half_beat = 0.5 / run.gait.frequency  # at the ends there is no whole beat to average over
    averaged = (run.time >= half_beat) & (run.time <= run.duration - half_beat)
    for axes, values, name in swings:
        axes.plot(run.time, values, color=COLORS[0], lw=0.5, alpha=0.35, label="within the beat")
        axes.plot(run.time[averaged], run.averaged(values)[averaged], color=COLORS[0], label="mean of the beat")
        axes.set(ylabel=name)
    for side, (name, style) in enumerate((("port", "-"), ("starboard", (0, (4, 2))))):
        angle = np.degrees(run.data["fin"][:, side])
        fins.plot(run.time, angle, color=COLORS[1 + side], ls=style, label=f"{name} fin")
    fins.set(ylabel="fins, leading\nedge up [deg]", xlabel="time [s]")
    depth.set(ylabel="depth [m]", xlim=(0, run.duration))
    for axes in (depth, pitch, speed, fins):
        axes.axvline(dive.switch, color=INK, lw=0.6, alpha=0.5)
    (lines, labels), (more, names) = pitch.get_legend_handles_labels(), fins.get_legend_handles_labels()
    figure.legend(lines + more, labels + names, loc="outside upper left", ncols=4 if width > 6 else 2, **TIGHT)
    return figure


@plots.of(SeaRun)
@styled
def plot_sea(run: SeaRun, *, width: float = WIDTH) -> Figure:
    """Plot a run at sea; `width` [inch]."""
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
