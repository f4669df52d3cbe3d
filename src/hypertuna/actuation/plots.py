"""Figures of a bending joint, and of pump sizes."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from hypertuna.actuation.bending import Bend
from hypertuna.actuation.sizing import Size, Sizes
from hypertuna.display import plots
from hypertuna.figures import COLORS, FAINT, INK, POINTS, SHAPES, TIGHT, WIDTH, sequence, styled
from hypertuna.io.quantity import columns, suffix

DASHES = ((0, (5, 2)), (0, (1, 1.5)), (0, (5, 1.5, 1, 1.5)))  # line styles of the other material sets

NO_SETS: Mapping[str, Bend] = {}  # no other material sets


@plots.of(Bend)
@styled
def plot_bend(bend: Bend, sets: Mapping[str, Bend] = NO_SETS, *, width: float = WIDTH) -> Figure:
    """Plot a joint's bend over the pressure, with the band of all material sets and the largest bend as described."""
    figure = Figure(figsize=(width, 0.4 * width + 1.4), layout="constrained")
    axes = figure.subplots()
    pressure = bend.pressure / 1e3
    angles = np.degrees([curve.angle for curve in sets.values()])
    if len(angles) > 1:
        axes.fill_between(pressure, angles.min(axis=0), angles.max(axis=0), color=FAINT, alpha=0.15, lw=0)
    _draw_loop(axes, bend)
    others = (curve for name, curve in sets.items() if name != bend.material)
    for curve, dashes in zip(others, DASHES, strict=False):
        axes.plot(pressure, np.degrees(curve.angle), color=FAINT, lw=1.1, ls=dashes, label=f"{curve.material} set")
    group = next(group for group in bend.robot.joints if group.name == bend.joint)
    if group.bend_max is not None and group.pressure_max is not None:
        described = (group.pressure_max / 1e3, np.degrees(group.bend_max))
        axes.plot(*described, "x", color=INK, ms=7, mew=1.6, zorder=5, label="largest bend, as described")
    equations = "" if bend.law == "corrected" else ", equations as printed"
    axes.set_title(f"{bend.robot.name}, joint {bend.joint}, {bend.side} side{equations}")
    axes.set(xlabel="gauge pressure [kPa]", ylabel="bend [deg]", xlim=(0, None), ylim=(0, None))
    figure.legend(loc="outside lower left", ncols=3 if width > 6 else 2, **TIGHT)
    return figure


def _draw_loop(axes: Axes, bend: Bend) -> None:
    """Draw the curves of loading and unloading, each with an arrow in its middle."""
    for color, (text, (pressure, angle)) in zip((COLORS[1], COLORS[0]), bend.branches.items(), strict=False):
        points = np.stack([pressure / 1e3, np.degrees(angle)], axis=1)
        axes.plot(*points.T, "-", color=color, zorder=3, label=f"{bend.material} set, {text}")
        middle = len(points) // 2
        if len(bend.branches) > 1 and 0 < middle < len(points) - 1:
            style = {"arrowstyle": "-|>", "color": color, "lw": 0, "mutation_scale": 13}
            axes.annotate("", points[middle], points[middle - 1], arrowprops=style)


DASHED = (0, (4, 3))  # line style of the commanded bend
# An axis of a figure: column or key, label, and format of a value. After keys that vary, a figure tries these in order.
Axis = tuple[str, str, str]
AXES: tuple[Axis, ...] = (
    ("bore_mm", "bore of the lines [mm]", "{:.3g} mm"),
    ("frequency_hz", "beat frequency [Hz]", "{:.3g} Hz"),
    ("temperature_c", "temperature of the oil [°C]", "{:.3g} °C"),
)


KEY_UNITS = ("N m", "rad/s", "m^2/s", "kg/m^3", "m^3/Pa", "kg m^2", "m^3", "Pa", "Hz", "deg", "kg", "m", "V", "A", "C")


def _key_axis(key: str) -> Axis:
    """Return the axis for a key of the robot's file: key, label and format of its values."""
    name = key.rpartition(".")[2]
    unit = next((unit for unit in KEY_UNITS if name.endswith(suffix(unit))), "")
    words = name.removesuffix(suffix(unit)).replace("_", " ")
    return key, f"{words} [{unit}]" if unit else words, f"{words} {{:.4g}} {unit}".rstrip()


def _axes(sizes: Sequence[Size]) -> list[Axis]:
    """Return all axes; the first is the x axis: the key with the most values, else the first of `AXES` that varies."""
    keys = [_key_axis(key) for key in sizes[0].values]
    axes = [*keys, *AXES]
    count = {axis: len({_value(size, axis[0]) for size in sizes}) for axis in axes}
    return sorted(axes, key=lambda axis: (count[axis] < 2, -count[axis] if axis in keys else 0))


@plots.of(Sizes)
@styled
def plot_pump(sizes: Sequence[Size], *, width: float = WIDTH) -> Figure:
    """Plot the bend reached, and below it the corner frequency of the line or the power: a column for each joint.

    The x axis is the key with the most values, else bore, frequency or temperature, the first that varies. Each
    combination of the other values has a line. Open marks are at the pressure limit. The lower panels show power over
    frequency and over keys, since the corner does not depend on frequency or on most keys.
    """
    joints = list(dict.fromkeys(size.joint for size in sizes))
    (x_column, xlabel, _), *other_axes = _axes(sizes)
    lines = list(dict.fromkeys(_values(size, other_axes) for size in sizes))
    varied = [axis for axis in other_axes if len({_value(size, axis[0]) for size in sizes}) > 1]
    powers = x_column == "frequency_hz" or x_column in sizes[0].values
    figure = Figure(figsize=(width, 0.62 * width + 0.5), layout="constrained")
    panels = figure.subplots(2, len(joints), sharex=True, sharey="row", squeeze=False)
    for column, joint in enumerate(joints):
        joint_sizes = [size for size in sizes if size.joint == joint]
        for k, (line, color) in enumerate(zip(lines, sequence(len(lines)), strict=True)):
            chosen = [size for size in joint_sizes if _values(size, other_axes) == line]
            x = [_value(size, x_column) for size in chosen]
            bend = np.degrees([size.bend for size in chosen])
            label = ", ".join(axis[2].format(_value(chosen[0], axis[0])) for axis in varied)
            growth = 2.2 * (len(lines) - 1 - k) / max(1, len(lines) - 1)  # first marks are larger: others cover them
            marks = dict(POINTS) | {"color": color, "marker": SHAPES[k % len(SHAPES)], "ms": 5.5 + growth}
            panels[0, column].plot(x, bend, **marks, label=label or None)
            limited = ["pressure" in size.limits for size in chosen]
            open_marks = marks | {"ls": "none", "mfc": "white", "mec": color}
            panels[0, column].plot(np.compress(limited, x), np.compress(limited, bend), **open_marks)
            lower = [size.electrical_power["total"] if powers else size.corner for size in chosen]
            panels[1, column].plot(x, lower, **marks)
        fixed = [
            axis[2].format(_value(joint_sizes[0], axis[0]))
            for axis in other_axes
            if axis in AXES and axis not in varied
        ]
        command = float(np.degrees(joint_sizes[0].command))
        panels[0, column].axhline(command, color=INK, lw=1, ls=DASHED)
        panels[0, column].set(title=", ".join([f"Joint {joint}: {command:.3g}°", *fixed]))
        panels[1, column].set_xlabel(xlabel)
    for axes in panels[0]:
        axes.set_ylim(*np.degrees(max(size.command for size in sizes)) * np.array([-0.03, 1.08]))
    panels[0, 0].set_ylabel("bend reached [deg]")
    panels[1, 0].set_ylabel("power of both servos [W]" if powers else "corner of the line [Hz]")
    if powers:
        panels[1, 0].set_ylim(0, None)
    else:
        panels[1, 0].set_yscale("log")
        panels[1, 0].yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panels[1, 0].yaxis.set_major_formatter("{x:g}")
        panels[1, 0].yaxis.set_minor_formatter("")
    handles, texts = panels[0, 0].get_legend_handles_labels()
    handles.append(panels[0, 0].plot([], [], color=INK, lw=1, ls=DASHED)[0])
    texts.append("commanded")
    if any("pressure" in size.limits for size in sizes):
        handles.append(panels[0, 0].plot([], [], "o", color=FAINT, mfc="white")[0])
        texts.append("at the pressure limit")
    wide_texts = max(map(len, texts)) > 22 or width < WIDTH
    figure.legend(handles, texts, loc="outside upper center", ncols=4 if wide_texts else 7, **TIGHT)
    return figure


def _value(size: Size, column: str) -> float:
    """Return a case's value of a column or key, rounded so that equal values compare equal."""
    return round(float(size.values[column] if column in size.values else columns(size)[column]), 9)


def _values(size: Size, axes: Sequence[Axis]) -> tuple[float, ...]:
    """Return a case's values on several axes."""
    return tuple(_value(size, axis) for axis, *_ in axes)
