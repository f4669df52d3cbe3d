"""Figures of turns: radius against phase, bias or frequency; paths seen from above."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.arrays import Array
from hypertuna.description.pose import Points
from hypertuna.display import plots
from hypertuna.errors import InputError
from hypertuna.figures import COLORS, EDGE, FAINT, INK, SHAPES, TIGHT, WIDTH, sequence, styled
from hypertuna.swimming.plots import grid_angles, phase_label
from hypertuna.swimming.swim import Swim, swim
from hypertuna.swimming.trajectory import body_of
from hypertuna.swimming.turn import Tightest, Turning, nose_path

if TYPE_CHECKING:
    import xarray as xr

AXES = {"phase": "phase [deg]", "frequency": "frequency [Hz]", "bias": "bias [deg]"}  # label by possible x axis
MAX_LINES = 8  # lines in the figure
WIDEST = 4.0  # body lengths, largest radius of a drawn circle: larger ones would make the others small
NARROW = 6.0  # inches, width below which the legend has fewer columns


@plots.of(Turning)
@styled
def plot_turn(turning: Turning, *, published: tuple[float, float] | None = None, width: float = WIDTH) -> Figure:
    """Plot turning radii and paths of a grid; `published`: phase [deg] and radius [body lengths], `width` [inch]."""
    length = turning.robot.body.length
    dim = next((name for name in AXES if turning.sweep.sizes[name] > 1), "phase")
    lines = _lines(turning, dim)
    if not any(np.isfinite(line.turn_radius.where(line.settled)).any() for line in lines.values()):
        raise InputError("must show a gait that turns", key="plot", fix="give the joints a bias")
    is_wide = width > NARROW
    top, bottom = (0.36 if is_wide else 0.62) * width, (0.42 if is_wide else 0.5) * width
    figure = Figure(figsize=(width, top + bottom + 1.1), layout="constrained")
    upper, lower = figure.subplots(2, 1, height_ratios=[top, bottom])
    draw_radius(upper, lines, length, dim=dim, published=published if dim == "phase" else None)
    figure.legend(*upper.get_legend_handles_labels(), loc="outside upper left", ncols=4 if is_wide else 2, **TIGHT)
    _draw_paths(lower, turning)
    figure.legend(*lower.get_legend_handles_labels(), loc="outside lower left", ncols=3 if is_wide else 1, **TIGHT)
    return figure


@styled
def plot_turning(
    sweeps: Mapping[str, xr.Dataset],
    length: float,
    *,
    published: tuple[float, float] | None = None,
    width: float = WIDTH,
) -> Figure:
    """Plot the turning radius against the phase of the last joint group, a line for each sweep.

    `length`: of the body [m]; `published`: phase [deg] and radius [body lengths]; `width` [inch].
    """
    figure = Figure(figsize=(width, 0.42 * width + 0.6), layout="constrained")
    axes = figure.subplots()
    lines = {name: sweep.isel(frequency=0, amplitude=0, bias=0) for name, sweep in sweeps.items()}
    draw_radius(axes, lines, length, published=published)
    figure.legend(loc="outside upper left", ncols=2 if width < WIDTH else 4, **TIGHT)
    return figure


def draw_radius(
    axes: Axes,
    lines: Mapping[str, xr.Dataset],
    length: float,
    *,
    dim: str = "phase",
    published: tuple[float, float] | None = None,
) -> None:
    """Draw turning radii, a line for each row of gaits; filled marks swim head first, open marks tail first.

    `length`: of the body [m]; `published`: phase [deg] and radius [body lengths].
    """
    colors = COLORS if len(lines) <= len(COLORS) else sequence(len(lines))
    any_backward = False
    for k, (name, row) in enumerate(lines.items()):
        x, radius = _values(row, dim), row.turn_radius.where(row.settled).values / length
        ahead = row.speed.values > 0
        any_backward |= bool((~ahead & np.isfinite(radius)).any())
        style: dict[str, Any] = {"color": colors[k], "marker": SHAPES[k % len(SHAPES)], "ls": "none", "ms": 5.5}
        axes.plot(x, np.where(np.isfinite(radius), radius, math.nan), color=colors[k], lw=1.2, alpha=0.7)
        axes.plot(x[ahead], radius[ahead], **style, label=name)
        axes.plot(x[~ahead], radius[~ahead], **style, mfc="white", mew=1.4)
    if published is not None:
        axes.plot(*published, "*", color=INK, ms=13, mec="white", label="published")
    if any_backward:
        axes.plot([], [], "o", color=FAINT, mfc="white", mew=1.4, label="swims tail first")
    label = f"{phase_label(next(iter(lines.values())))} [deg]" if dim == "phase" else AXES[dim]
    axes.set(xlabel=label, ylabel="turning radius\n[body lengths]", ylim=(0, 1.12 * axes.get_ylim()[1]))
    if dim == "phase" and np.ptp(x) > 180:
        axes.set_xticks(np.arange(0, 361, 80))


def _lines(turning: Turning, dim: str) -> dict[str, xr.Dataset]:
    """Return up to `MAX_LINES` rows of the grid along a dimension, by a label of the other dimensions' values."""
    grid, others = turning.sweep, [name for name in turning.sweep.turn_radius.dims if name != dim]
    rows = {}
    for index in np.ndindex(*(grid.sizes[name] for name in others)):
        row = grid.isel(dict(zip(others, index, strict=True)))
        parts = [_spelled(row, str(name)) for name in others if grid.sizes[name] > 1]
        rows[", ".join(parts) or "settled turns"] = row
        if len(rows) == MAX_LINES:
            break
    return rows


def _spelled(row: xr.Dataset, name: str) -> str:
    """Return the value of a row in a dimension as text: "2 Hz", "phase 0, 40°"."""
    if name == "frequency":
        return f"{row.frequency.item():g} Hz"
    return f"{name} {', '.join(f'{angle:.3g}' for angle in grid_angles(row, name))}°"


def _values(row: xr.Dataset, dim: str) -> Array:
    """Return a row's values [Hz, deg] along an axis; phases are of the last group, biases of the first that varies."""
    if dim == "frequency":
        return np.asarray(row.frequency.values)
    columns = grid_angles(row, dim)
    if dim == "phase":
        return np.asarray(columns[-1])
    return np.asarray(next((column for column in columns if np.ptp(column) > 0), columns[0]))


def _draw_paths(axes: Axes, turning: Turning) -> None:
    """Draw the paths of the tightest turns, each from the origin upward, and the circles of all gaits."""
    length = turning.robot.body.length
    unit = np.exp(1j * np.linspace(0, 2 * np.pi, 181))
    columns = (turning.sweep[name].values.ravel() for name in ("circle_radius", "turn_rate", "settled"))
    for radius, rate, settled in zip(*columns, strict=True):
        if settled and radius < WIDEST * length:  # the center is to the left if the rate is positive
            loop = radius / length * (unit - 1) * (1 if rate > 0 else -1)
            axes.plot(loop.real, loop.imag, color=EDGE, lw=0.7, zorder=1)
    axes.plot([], [], color=EDGE, lw=0.7, label="circles of all gaits")
    ends = {"tail first": turning.tightest, "head first": turning.forward}
    if turning.forward is not None and turning.tightest is not None and turning.tightest.speed > 0:
        del ends["tail first"]
    for (label, turn), color in zip(ends.items(), (COLORS[0], COLORS[1]), strict=False):
        if turn is None:
            continue
        path, body, center = (part / length for part in _upright(swim(turning.robot, turn.gait), turn))
        name = f"tightest {label}, {math.degrees(turn.gait.phase[-1]):.4g}°, {turn.gait.frequency:g} Hz"
        axes.plot(path.real, path.imag, color=color, lw=0.9, label=name)
        loop = center[0] + turn.circle.radius / length * unit
        axes.plot(loop.real, loop.imag, color=color, lw=0.9, ls=(0, (4, 2)))
        axes.plot(body.real, body.imag, color=color, lw=3.2, zorder=3)
        axes.plot(body.real[:1], body.imag[:1], "o", color=color, ms=6, mec="white", zorder=4)
    axes.set(aspect="equal", xlabel="across [body lengths]", ylabel="onward [body lengths]")
    axes.set_title("from above: nose, body")


def _upright(beat: Swim, one: Tightest) -> tuple[Points, Points, Points]:
    """Return nose path, body and circle's center [m], moved so that the nose starts at the origin and goes upward."""
    path = nose_path(beat)
    body = body_of(beat.robot, beat.trajectory.isel(time=0))[0]
    radius_vector = path[0] - one.circle.center
    direction = (1j if beat.turn_rate > 0 else -1j) * radius_vector / abs(radius_vector)
    center = np.array([one.circle.center])
    return (path - path[0]) * 1j / direction, (body - path[0]) * 1j / direction, (center - path[0]) * 1j / direction
