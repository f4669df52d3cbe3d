"""Figures of a swim, a gait, a gradient and a sweep as in the paper's Fig. 10, and an animation of the body."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from PIL import Image

from hypertuna.arguments import check_made_by, checked
from hypertuna.arrays import Array
from hypertuna.description.pose import Points
from hypertuna.display import plots
from hypertuna.errors import InputError
from hypertuna.figures import (
    COLORS,
    FAINT,
    GRID,
    INK,
    POINTS,
    SEQUENCE,
    SHAPES,
    TIGHT,
    WIDTH,
    line_style,
    sequence,
    styled,
)
from hypertuna.io.files import write_atomically
from hypertuna.swimming.gait import Gait, gait_text
from hypertuna.swimming.outline import FRAME, last_beat, midlines, outlines, slowed, specks
from hypertuna.swimming.sweep import Gradient
from hypertuna.swimming.swim import Swim
from hypertuna.swimming.trajectory import body_of, nose_points

if TYPE_CHECKING:
    import xarray as xr

BEATS = 4  # beats of a straight path
MAX_BEATS = 80  # most beats of a turn
MAP = 6  # a grid with this many frequencies and phases is shown as a map: lines would cross too often
BARS = 12  # number of parameters shown


@plots.of(Swim)
@styled
def plot_swim(swim: Swim, *, width: float = WIDTH) -> Figure:
    """Plot a swim: paths, midlines, speed and power over a beat; `width` [inch]."""
    robot, gait = swim.robot, swim.gait
    lines, paths = midlines(swim), _paths(swim)
    all_points = np.concatenate(list(paths.values()))
    x, y = np.ptp(all_points.real), np.ptp(all_points.imag)
    inner = 0.8 * width
    bend = np.ptp(lines.imag) / np.ptp(lines.real)
    side_by_side = width > 6  # else speed is above power
    heights = [min(max(0.55, inner * y / x), 0.55 * width) + 0.6, max(inner * bend, 0 if side_by_side else 0.9) + 0.7]
    heights += [2.1] if side_by_side else [1.7, 1.7]
    figure = Figure(figsize=(width, sum(heights) + 0.4), layout="constrained")
    places = figure.add_gridspec(len(heights), 2, height_ratios=heights)
    shown = [name for name in ("amplitude", "phase", "bias") if name != "bias" or any(gait.bias)]
    angles = [f"{name} {', '.join(f'{a:.3g}' for a in np.degrees(getattr(gait, name)))}°" for name in shown]
    result_text = f"{robot.model.joints} joints; {swim.status}, {swim.speed:.3g} m/s along the path"
    caption = f"{robot.name}: {gait.frequency:g} Hz, {', '.join(angles)}\n{result_text}"
    figure.suptitle(caption, fontsize=8.5, color=FAINT, x=0.01, ha="left")
    _draw_paths(figure.add_subplot(places[0, :]), paths, "" if swim.from_rest is None else ", from rest")
    _draw_midlines(figure.add_subplot(places[1, :]), lines, to_scale=side_by_side or bool(inner * bend > 0.9))
    _draw_speed(figure.add_subplot(places[2, 0] if side_by_side else places[2, :]), swim)
    _draw_power(figure.add_subplot(places[2, 1] if side_by_side else places[3, :]), swim)
    return figure


@checked
@styled
def plot_sweep(grid: xr.Dataset, *, width: float = WIDTH) -> Figure:
    """Plot speed and cost of transport of a sweep, as the paper's Fig. 10.

    Parameters
    ----------
    grid : xarray.Dataset
        Of a grid with one bias, as `sweep` returns it.
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
        Shown by notebooks; ``figure.savefig("name.svg")`` writes it.

    Raises
    ------
    InputError
        If the grid has several robots or biases, or one frequency and one phase.
    """
    check_made_by("sweep", grid, "grid", ("frequency", "speed", "settled"))
    if any("." in str(dim) for dim in grid.dims):
        rule, fix = "must be of one robot, without a design", "write -o NAME.nc, or sweep one robot at a time"
        raise InputError(rule, key="plot", fix=fix)
    if "bias" not in grid.dims or grid.sizes["bias"] > 1:
        raise InputError("must be of a grid with a single bias", key="plot", fix="sweep one bias at a time")
    if grid.sizes["frequency"] == 1 and grid.sizes["phase"] == 1:
        raise InputError("must show several frequencies or phases", key="plot", fix="give a range, such as 1:6:6")
    grid = grid.isel(bias=0).where(grid.settled.isel(bias=0))
    if min(grid.sizes["frequency"], grid.sizes["phase"]) >= MAP:
        return _maps(grid, width)
    phases, phase_texts = _levels(grid, "phase")
    along_phase = grid.sizes["frequency"] == 1
    x_dim = "phase" if along_phase else "frequency"
    line_dim = "frequency" if along_phase else "phase"
    x = phases if along_phase else grid.frequency.values
    lag = phase_label(grid)
    xlabel = f"{lag} [deg]" if along_phase else "frequency [Hz]"
    names = [f"{grid.frequency.item():g} Hz"] if along_phase else phase_texts
    amplitudes = _levels(grid, "amplitude")[1]
    rows = len(amplitudes)
    figure = Figure(figsize=(width, 0.75 + (0.36 if width < WIDTH else 0.29) * width * rows), layout="constrained")
    quantities = {"speed": "speed [m/s]", "cost_of_transport": "cost of transport\n[J/(kg m)]"}
    if np.isfinite(grid.turn_radius).any():
        quantities["turn_radius"] = "turning radius [m]"
    panels = figure.subplots(rows, len(quantities), sharex=True, sharey="col", squeeze=False)
    colors = COLORS if 1 < len(names) <= len(COLORS) else sequence(len(names))
    for row, amplitude in enumerate(amplitudes):
        for axes, (quantity, label) in zip(panels[row], quantities.items(), strict=True):
            values = grid[quantity].isel(amplitude=row).transpose(x_dim, line_dim).values
            for k, name in enumerate(names):
                axes.plot(x, values[:, k], color=colors[k], marker=SHAPES[k % len(SHAPES)], **POINTS, label=name)
            axes.set_ylabel(label)
            axes.set_title(f"amplitude {amplitude}" if axes is panels[row, 0] else "")
            axes.set_xlabel(xlabel if row == rows - 1 else "")
    if not along_phase and len(x) <= 6:  # tick labels of more would run together
        panels[0, 0].set_xticks(x)
    handles, texts = panels[0, 0].get_legend_handles_labels()
    title = "" if along_phase else lag
    if len(texts) <= 12:
        figure.legend(handles, texts, title=title, loc="outside upper center", ncols=min(len(texts), 6), **TIGHT)
    else:
        bar = ScalarMappable(Normalize(phases.min(), phases.max()), SEQUENCE)
        figure.colorbar(bar, ax=panels, location="top", aspect=60, fraction=0.03, label=f"{title} [deg]")
    return figure


def _maps(grid: xr.Dataset, width: float) -> Figure:
    """Plot maps of speed and cost of transport over frequency and phase, with a row for each amplitude."""
    phases, amplitudes = _levels(grid, "phase")[0], _levels(grid, "amplitude")[1]
    rows, dims = len(amplitudes), ("amplitude", "phase", "frequency")
    figure = Figure(figsize=(width, 0.6 + 0.36 * width * rows), layout="constrained")
    panels = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False)
    for column, (quantity, label) in enumerate({"speed": "speed [m/s]", "cost_of_transport": "COT [J/(kg m)]"}.items()):
        values = grid[quantity].transpose(*dims).values
        values = np.where(np.isfinite(values) & (grid.speed.transpose(*dims).values > 0), values, np.nan)
        finite = values[np.isfinite(values)]
        level = 1.0 if quantity == "speed" else 0.95  # near rest the cost has no bound
        low, high = (finite.min(), np.quantile(finite, level)) if len(finite) else (0.0, 1.0)
        for row, amplitude in enumerate(amplitudes):
            axes = panels[row, column]
            image = axes.pcolormesh(grid.frequency.values, phases, values[row], cmap=SEQUENCE, vmin=low, vmax=high)
            axes.grid(visible=False)
            axes.set_title(f"amplitude {amplitude}" if column == 0 else "")
            axes.set_xlabel("frequency [Hz]" if row == rows - 1 else "")
            axes.set_ylabel(f"{phase_label(grid)} [deg]" if column == 0 else "")
        figure.colorbar(image, ax=panels[:, column], label=label, extend="neither" if level == 1 else "max")
    return figure


@styled
def plot_ledger(
    names: Sequence[str],
    published: ArrayLike,
    computed: Mapping[str, ArrayLike],
    *,
    label: str = "speed [m/s]",
    width: float = WIDTH,
) -> Figure:
    """Plot published and computed numbers side by side, with a row for each name.

    `published` (rows,) and each of `computed` (rows,) in one unit, that of `label`; `width` [inch].
    """
    figure = Figure(figsize=(width, 0.36 * len(names) + 1.1), layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(names))
    published_values = np.asarray(published, dtype=np.float64)
    for k, (name, values) in reversed(list(enumerate(computed.items()))):
        offset = 0.13 * (1 - 2 * k) if len(computed) == 2 else 0.0
        axes.hlines(rows - offset, published_values, values, color=COLORS[k], lw=1.4, alpha=0.55)
        axes.plot(values, rows - offset, SHAPES[k], color=COLORS[k], ms=6.5, label=name)
    axes.plot(published_values, rows, "|", color=INK, ms=17, mew=2.6, label="published")
    axes.set_yticks(rows, names)
    axes.set(xlabel=label, xlim=(0, None), ylim=(len(names) - 0.5, -0.5))
    axes.grid(axis="y", visible=False)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    handles, texts = axes.get_legend_handles_labels()
    figure.legend(handles[::-1], texts[::-1], loc="outside upper left", ncols=3, **TIGHT)
    return figure


def animate_swim(swim: Swim, path: str | Path) -> None:
    """Write the body swimming one beat as an animated GIF that repeats without a jump."""
    shapes, step = outlines(swim)
    reach = 1.15 * max(0.16, float(np.abs(shapes[..., 1]).max()))
    figure = Figure(figsize=(6.4, 6.4 * 2 * reach / 1.3), dpi=100, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-0.15, 1.15), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    dots = specks(step, reach)
    (water,) = axes.plot(*dots.T, ".", color=GRID, ms=5, zorder=1)
    (body,) = axes.fill(*shapes[0].T, color=COLORS[1], lw=0, zorder=2)
    text = f"{swim.robot.name}, {swim.gait.frequency:g} Hz: {swim.speed:.2f} m/s, {slowed(swim)}"
    axes.text(0.015, 0.03, text, transform=axes.transAxes, color=FAINT if swim.settled else INK, fontsize=9)
    frames = []
    for k, shape in enumerate(shapes):
        water.set_data(*(dots + step * (k / len(shapes))).T)
        body.set_xy(shape)
        canvas.draw()
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("P", palette=Image.Palette.ADAPTIVE))
    content = io.BytesIO()
    frames[0].save(content, "GIF", save_all=True, append_images=frames[1:], duration=FRAME, loop=0)
    write_atomically(path, content.getvalue())


def unroll(z: Points, motion: xr.Dataset, beats: int) -> Points:
    """Continue the path of a point of the body over more beats, each of which moves and turns the body equally.

    `z`: path over one beat (times,) [m]; returns (beats (times - 1) + 1,) [m].
    """
    nose, heading = nose_points(motion), motion.heading.values
    spin = np.exp(1j * (heading[-1] - heading[0]))
    parts = [z]
    for _ in range(beats - 1):
        z = nose[-1] + spin * (z - nose[0])
        parts.append(z[1:])
    return np.concatenate(parts)


def _paths(swim: Swim) -> dict[str, Points]:
    """Return paths x + i y [m] of tail tip and nose, over the run from rest, some beats or a turn; and the body."""
    motion = swim.trajectory
    nose, tail = nose_points(motion), motion.tail_x.values + 1j * motion.tail_y.values
    body = body_of(swim.robot, motion.isel(time=0 if swim.from_rest is None else -1))[0]
    paths = {"tail tip": tail, "nose": nose, "body": body}
    if swim.from_rest is None:
        beat_turn = abs(float(motion.heading[-1] - motion.heading[0]))
        is_turn = np.isfinite(swim.turn_radius)
        beats = min(MAX_BEATS, int(np.ceil(2 * np.pi / beat_turn))) if is_turn else BEATS
        direction = 1.0 if is_turn else np.exp(-1j * np.angle(nose[0] - nose[-1]))
        paths |= {name: unroll(paths[name], motion, beats) for name in ("tail tip", "nose")}
        paths = {name: direction * path for name, path in paths.items()}
    return paths


def _draw_paths(axes: Axes, paths: Mapping[str, Points], suffix: str) -> None:
    """Draw the paths of tail tip and nose, and the body."""
    styles: tuple[dict[str, Any], ...] = (
        {"color": COLORS[0], "lw": 1.2},
        {"color": COLORS[1], "lw": 1.2},
        {"color": INK, "lw": 2.5, "alpha": 0.8, "zorder": 1},
    )
    for (name, path), style in zip(paths.items(), styles, strict=True):
        axes.plot(path.real, path.imag, label=name, **style)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"Paths{suffix}")
    axes.locator_params(axis="y", nbins=2)
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, borderaxespad=0.1, handlelength=1.4)


def _draw_speed(axes: Axes, swim: Swim) -> None:
    """Draw the forward speed over the settled beat, or over time from rest."""
    motion = swim.trajectory
    settled = swim.from_rest is None
    time = motion.time.values * (swim.gait.frequency if settled else 1.0)
    axes.plot(time, motion.forward_speed, color=COLORS[1])
    axes.set(title="Forward speed", xlabel="part of the beat" if settled else "time [s]", ylabel="speed [m/s]")
    axes.set_xlim(0, time[-1])
    mean = float(last_beat(swim).forward_speed[:-1].mean())
    _mean_line(axes, mean, f"{'mean' if settled else 'last beat'} {mean:.3g} m/s")


def _draw_power(axes: Axes, swim: Swim) -> None:
    """Draw the mechanical power of each joint group, and of all together, over the last beat."""
    motion = last_beat(swim)
    part = np.linspace(0, 1, motion.sizes["time"])
    for g, group in enumerate(motion.group.values):
        axes.plot(part, motion.group_mechanical_power[:, g], **line_style(g, first=2), label=str(group))
    axes.plot(part, motion.mechanical_power, color=INK, label="all")
    axes.set(title="Power of the joints", xlabel="part of the last beat" if swim.from_rest else "part of the beat")
    axes.set(ylabel="mechanical power [W]", xlim=(0, 1))
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.22 * (high - low), high)
    axes.legend(ncols=6, loc="lower center", borderpad=0, borderaxespad=0.3, handlelength=1.0, columnspacing=0.9)
    _mean_line(axes, swim.mechanical_power, f"mean {swim.mechanical_power:.3g} W")


def _draw_midlines(axes: Axes, lines: Points, *, to_scale: bool) -> None:
    """Draw midlines of one beat, with a color bar for the time within the beat."""
    for line, color in zip(lines, sequence(len(lines)), strict=True):
        axes.plot(line.real, line.imag, color=color, lw=1.5, solid_joinstyle="round")
    axes.set(aspect="equal" if to_scale else "auto", xlabel="along the mean path [m]", ylabel="across [m]")
    axes.set_title(f"Midlines of one beat{'' if to_scale else ', stretched across'}")
    axes.locator_params(axis="y", nbins=3)
    bar = ScalarMappable(Normalize(0, 1), SEQUENCE)
    axes.figure.colorbar(bar, cax=axes.inset_axes((1.02, 0, 0.018, 1)), label="part of\nthe beat", ticks=[0, 1])


def _mean_line(axes: Axes, value: float, text: str) -> None:
    """Draw a line at a mean, and write its text above the axes."""
    axes.axhline(value, color=FAINT, lw=1, ls=(0, (4, 3)))
    axes.set_title(text, loc="right", color=FAINT, fontweight="normal", fontsize=8.5)


def _levels(grid: xr.Dataset, dim: str) -> tuple[Array, list[str]]:
    """Return the last joint group's angles [deg] along a dimension, and their texts; those of amplitudes list all."""
    columns = grid_angles(grid, dim)
    if dim == "phase":
        return columns[-1], [f"{angle:.4g}°" for angle in columns[-1]]
    return columns[-1], [", ".join(f"{angle:.4g}°" for angle in angles) for angles in zip(*columns, strict=True)]


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


def phase_label(grid: xr.Dataset) -> str:
    """Return the label of an axis of phases, which names the last joint group."""
    groups = [str(name).removeprefix("phase_") for name in grid.coords if str(name).startswith("phase_")]
    return f"phase of joint {groups[-1]}"


def grid_angles(grid: xr.Dataset, dim: str) -> list[Array]:
    """Return the angles [deg] of each joint group along a dimension of a sweep."""
    angles = [grid[name] for name in grid.coords if str(name).startswith(f"{dim}_")]
    return [np.asarray(axis if axis.attrs["units"] == "deg" else np.degrees(axis)) for axis in angles]
