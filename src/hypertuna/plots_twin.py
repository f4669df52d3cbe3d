"""Figures of the twin: a whole run, and the pressures over a beat."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hypertuna.figures import COLORS, FAINT, INK, TIGHT, WIDTH, styled
from hypertuna.twin_run import TwinRun

if TYPE_CHECKING:
    from matplotlib.gridspec import GridSpec

__all__ = ["plot_pressures", "plot_twin"]

KILO = 1e3
FINE = 100  # samples of a beat
LETTERS, HANDLE = 52, 4  # that a legend above a panel has room for; as many of them take the line and gap of an entry
BEATS = 4  # that are shown of angles, pressures and power
SIDES = ("-", (0, (4, 1.5)))  # lines of left and right circuits


@styled
def plot_twin(run: TwinRun, *, width: float = WIDTH) -> Figure:
    """Plot a run of the twin.

    Parameters
    ----------
    run : TwinRun
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
        The last beats: bend of each joint beside what was set, pressures of the circuits, electrical power. The whole
        run: speed and path of the nose in water, peak bends in air.
    """
    beside = width > 6
    water = run.fish_in == "water"
    kinds = [_draw_angles, _draw_pressures, _draw_power, _draw_speed if water else _draw_peaks]
    kinds += [_draw_path] if water else []
    rows = (len(kinds) + 1) // 2 if beside else len(kinds)
    figure = Figure(figsize=(width, 2.05 * rows + 0.5), layout="constrained")
    grid: GridSpec = figure.add_gridspec(rows, 2 if beside else 1)
    for k, draw in enumerate(kinds):
        alone = beside and k == len(kinds) - 1 and k % 2 == 0
        place: Any = grid[k // 2, slice(None) if alone else k % 2] if beside else grid[k, 0]
        draw(figure.add_subplot(place), run)
    figure.suptitle(_caption(run), fontsize=8.5, color=FAINT, x=0.01, ha="left")
    return figure


@styled
def plot_pressures(run: TwinRun, *, width: float = WIDTH) -> Figure:
    """Plot the pressures of one beat, in the pumps and in the drive units: a panel for each joint.

    Parameters
    ----------
    run : TwinRun
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
        The last beat; of a settled run the last ones laid over each other, so that they show what lies between the
        samples of one. What lies between the two lines of a circuit is lost in its oil line.
    """
    joints = [group.name for group in run.robot.joints]
    laid = max(1, round(FINE * (run.time[1] - run.time[0]) * run.gait.frequency)) if run.settled else 1
    last = _last(run, laid)
    phase = (run.time[last] - run.time[last][0]) * run.gait.frequency
    phase = phase % 1.0 if laid > 1 else phase
    order = np.argsort(phase)
    last, phase = last[order], phase[order]
    figure = Figure(figsize=(width, 1.75 * len(joints) + 0.75), layout="constrained")
    panels = figure.subplots(len(joints), 1, sharex=True, squeeze=False)[:, 0]
    for j, (axes, name) in enumerate(zip(panels, joints, strict=True)):
        _draw_bounds(axes, run)
        for side, label in enumerate(("left", "right")):
            c, color = 2 * j + side, COLORS[side]
            axes.plot(phase, run.data["pump_pressure"][last, c] / KILO, color=color, label=f"{label}: pump")
            axes.plot(phase, run.data["unit_pressure"][last, c] / KILO, color=color, lw=1.1, ls=SIDES[1], label="units")
        axes.set_title(f"joint {name}")
        axes.set_ylabel("pressure [kPa]")
    panels[-1].set(xlabel="time [beats]", xlim=(0, 1))
    handles, texts = panels[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside upper left", ncols=4, **TIGHT)
    return figure


def _caption(run: TwinRun) -> str:
    """Say what was run."""
    gait = run.gait
    angles, lags = (", ".join(f"{a:.3g}" for a in np.degrees(part).round(9)) for part in (gait.amplitude, gait.phase))
    told = f"{run.robot.name}: {gait.frequency:g} Hz, {angles}° set, phase {lags}°, in {run.fish_in}"
    if any(gait.bias):
        told += f", bias {', '.join(f'{a:.3g}' for a in np.degrees(gait.bias))}°"
    return told if run.closed_loop else f"{told}, open loop"


def _last(run: TwinRun, beats: int) -> NDArray[np.intp]:
    """Return the indices of the last so many beats."""
    step = run.time[1] - run.time[0]
    count = min(len(run.time), round(beats / (run.gait.frequency * step)) + 1)
    return np.arange(len(run.time) - count, len(run.time))


def _draw_angles(axes: Axes, run: TwinRun) -> None:
    """Draw the bends of the last beats, and what was set."""
    last = _last(run, BEATS)
    for j, group in enumerate(run.robot.joints):
        color = COLORS[j % len(COLORS)]
        axes.plot(run.time[last], np.degrees(run.data["angle"][last, j]), color=color, label=f"joint {group.name}")
        axes.plot(run.time[last], np.degrees(run.data["angle_set"][last, j]), color=color, lw=0.9, ls=SIDES[1])
    axes.plot([], [], color=FAINT, lw=0.9, ls=SIDES[1], label="set")
    axes.set(xlabel="time [s]", ylabel="bend [deg]", xlim=(run.time[last[0]], run.time[last[-1]]))
    _above(axes)


def _draw_pressures(axes: Axes, run: TwinRun) -> None:
    """Draw the pressures in the pumps over the last beats: a line, and a band of what lies within the ticks."""
    last = _last(run, BEATS)
    _draw_bounds(axes, run)
    for c, name in enumerate(run.circuits):
        color = COLORS[c // 2 % len(COLORS)]
        low, at, high = (run.data[f"pump_pressure{end}"][last, c] / KILO for end in ("_low", "", "_high"))
        axes.fill_between(run.time[last], low, high, color=color, alpha=0.3, lw=0)
        axes.plot(run.time[last], at, color=color, ls=SIDES[c % 2], lw=1.2, label=name)
    axes.set(xlabel="time [s]", ylabel="pump pressure [kPa]", xlim=(run.time[last[0]], run.time[last[-1]]))
    _above(axes)


def _draw_bounds(axes: Axes, run: TwinRun) -> None:
    """Mark the pressures between which the circuits may work."""
    controller, oil = run.robot.controller, run.robot.oil
    assert controller is not None
    assert oil is not None  # the twin has run
    for bound, text in ((controller.pressure_soft, "soft limit"), (oil.cavitation, "cavitation")):
        axes.axhline(bound / KILO, color=INK, lw=0.9, ls=(0, (1, 2)))
        place: Any = {"xy": (1, bound / KILO), "xycoords": ("axes fraction", "data"), "xytext": (-2, 2)}
        place |= {"textcoords": "offset points", "ha": "right", "va": "bottom"}
        axes.annotate(
            text, **place, fontsize=7, color=INK, bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.5}
        )


def _draw_power(axes: Axes, run: TwinRun) -> None:
    """Draw the electrical power of the last beats."""
    last = _last(run, BEATS)
    power = run.data["power"]
    axes.plot(run.time[last], power[last], color=COLORS[2], label="servos")
    axes.axhline(run.power, color=INK, lw=0.9, ls=SIDES[1], label=f"mean {run.power:.3g} W")
    axes.set(
        xlabel="time [s]", ylabel="electrical power [W]", xlim=(run.time[last[0]], run.time[last[-1]]), ylim=(0, None)
    )
    _above(axes)


def _draw_speed(axes: Axes, run: TwinRun) -> None:
    """Draw the forward speed of the whole run, and its mean over each beat."""
    step, speed = run.time[1] - run.time[0], run.data["speed"]
    axes.plot(run.time, speed, color=COLORS[1], lw=0.7, alpha=0.5)
    window = max(1, round(1 / (run.gait.frequency * step)))
    if len(speed) > window:
        mean = np.convolve(speed, np.full(window, 1 / window), mode="valid")
        axes.plot(run.time[: len(mean)] + 0.5 * window * step, mean, color=COLORS[1], lw=1.8, label="mean of a beat")
    axes.set(xlabel="time [s]", ylabel="speed [m/s]", xlim=(run.time[0], run.time[-1]))
    _above(axes)


def _draw_peaks(axes: Axes, run: TwinRun) -> None:
    """Draw the bends of the whole run, and the peaks that were set."""
    for j, group in enumerate(run.robot.joints):
        color = COLORS[j % len(COLORS)]
        axes.plot(run.time, np.degrees(run.data["angle"][:, j]), color=color, lw=0.8, label=f"joint {group.name}")
        for sign in (-1, 1):
            peak = np.degrees(run.gait.bias[j] + sign * run.gait.amplitude[j])
            axes.axhline(peak, color=color, lw=0.9, ls=SIDES[1])
    axes.set(xlabel="time [s]", ylabel="bend [deg]", xlim=(run.time[0], run.time[-1]))
    _above(axes)


def _draw_path(axes: Axes, run: TwinRun) -> None:
    """Draw the path of the nose."""
    axes.plot(run.data["x"], run.data["y"], color=COLORS[0], lw=1.2)
    axes.plot(run.data["x"][:1], run.data["y"][:1], "o", color=INK, ms=5)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="path of the nose, from the dot")
    axes.set_aspect("equal", adjustable="datalim")


def _above(axes: Axes) -> None:
    """Put the legend above the panel, in as many rows as its texts need."""
    texts = axes.get_legend_handles_labels()[1]
    most = max((len(text) for text in texts), default=1) + HANDLE
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=max(1, min(4, LETTERS // most)), **TIGHT)
