"""Figures of the posture control: Fig. 8, and what limits the joints at each frequency."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from hypertuna.figures import COLORS, FAINT, GRID, INK, POINTS, SHAPES, TIGHT, WIDTH, sequence, styled
from hypertuna.posture import CLOSE, Held, PostureTest

__all__ = ["plot_limits", "plot_posture"]

Array = NDArray[np.float64]
LARGEST_ERROR = 1.3  # height of the panel of errors, in largest ones
HEADROOM = 1.08
ERRORS = (0, 0.25, 0.5, 1, 2, 5, 10, 20, 40)  # deg, that are marked


@styled
def plot_posture(test: PostureTest, *, example: float | None = None, width: float = WIDTH) -> Figure:
    """Plot the paper's Fig. 8: how a joint's bend grows to its set angle, and the error of its peaks.

    Parameters
    ----------
    test : PostureTest
    example : float, optional
        Frequency whose bend is shown [Hz]; left out, the second lowest.
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
        One column for each joint group that moves: bend at one frequency, error of the peak bend per beat at all, and
        the largest amplitude at each frequency where it was sought.
    """
    joints = list(dict.fromkeys(one.joint for one in test.held))
    frequencies = sorted({one.frequency for one in test.held})
    shown = example if example in frequencies else frequencies[min(1, len(frequencies) - 1)]
    rows = 3 if test.reach else 2
    beside = width > 6 and len(joints) > 1  # else one joint below the other
    tall = rows if beside else rows * len(joints)
    figure = Figure(figsize=(width, 2.0 * tall + 0.7), layout="constrained")
    panels = figure.subplots(tall, len(joints) if beside else 1, squeeze=False)
    columns = panels.T if beside else panels.reshape(len(joints), rows)
    for column, joint in zip(columns, joints, strict=True):
        held = [one for one in test.held if one.joint == joint]
        _draw_bend(column[0], next(one for one in held if one.frequency == shown))
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
    label: str = "amplitude reached over set",
    width: float = WIDTH,
) -> Figure:
    """Plot the amplitude that joints reach against the frequency, beside a first-order lag.

    Parameters
    ----------
    frequency : array_like, shape (frequencies,)
        [Hz].
    ratio : mapping of str to array_like, shape (frequencies,)
        Amplitude reached over the one that was set, by what to call it [1].
    bandwidth : float
        Of the lag [Hz].
    label : str
    width : float
        Of the figure [inch].

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(width, 0.62 * width), layout="constrained")
    axes = figure.subplots()
    hertz = np.asarray(frequency, dtype=np.float64)
    fine = np.linspace(0, 1.05 * hertz.max(), 200)
    lag = 1 / np.sqrt(1 + (fine / bandwidth) ** 2)
    axes.plot(fine, lag, color=INK, lw=1.1, ls=(0, (4, 2)), label=f"first-order lag of {bandwidth:g} Hz")
    for k, (name, values) in enumerate(ratio.items()):
        axes.plot(hertz, values, color=COLORS[k], marker=SHAPES[k], **POINTS, label=name)
    axes.set(xlabel="frequency [Hz]", ylabel=label, xlim=(0, fine[-1]), ylim=(0, None))
    figure.legend(loc="outside upper left", ncols=2, **TIGHT)
    return figure


def _draw_bend(axes: Axes, one: Held) -> None:
    """Draw the bend from rest, with the set angle to both sides."""
    time, angle = one.run.time, np.degrees(one.run.data["angle"][:, one.joint])
    for sign in (-1, 1):
        axes.axhline(sign * np.degrees(one.angle), color=INK, lw=1.0, ls=(0, (4, 2)))
    axes.plot(time, angle, color=COLORS[1], lw=1.0)
    axes.set_title(f"joint {one.name} at {one.frequency:g} Hz")
    axes.set(xlabel="time [s]", ylabel="bend [deg]", xlim=(0, time[-1]))


def _draw_errors(axes: Axes, held: Sequence[Held]) -> None:
    """Draw the error of the peak bend of every beat: linear where it counts as none, then by powers."""
    axes.axhspan(0, np.degrees(CLOSE), color=GRID, lw=0)
    for one, color in zip(held, sequence(len(held)), strict=True):
        axes.plot(
            one.time, np.degrees(one.error), color=color, marker="o", ms=2.5, lw=1.2, label=f"{one.frequency:g} Hz"
        )
    axes.set(xlabel="time [s]", ylabel="error of the\npeak bend [deg]", xlim=(0, max(one.time[-1] for one in held)))
    largest = max(np.degrees(held[0].angle), *(float(np.degrees(one.error).max()) for one in held))
    axes.set_yscale("symlog", linthresh=np.degrees(CLOSE), linscale=0.8)
    ticks = [tick for tick in ERRORS if tick < largest]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(0, LARGEST_ERROR * largest)


def _draw_reach(axes: Axes, test: PostureTest, joint: int) -> None:
    """Draw the largest amplitude that is held, and what its bandwidth would leave of the static one."""
    far = [one for one in test.reach if one.joint == joint]
    hertz, most = (np.array(values) for values in ([one.frequency for one in far], [one.amplitude for one in far]))
    axes.plot(hertz, np.degrees(most), color=COLORS[0], marker="o", **POINTS, label="held")
    group = test.robot.joints[joint]
    if group.bandwidth and group.bend_max:
        fine = np.linspace(0, hertz.max(), 200)
        lag = np.degrees(group.bend_max) / np.sqrt(1 + (fine / group.bandwidth) ** 2)
        axes.plot(fine, lag, color=FAINT, lw=1.1, ls=(0, (4, 2)), label=f"lag of {group.bandwidth:g} Hz")
    axes.axhline(np.degrees(test.angle[joint]), color=INK, lw=0.9, ls=(0, (1, 2)), label="set")
    axes.set(xlabel="frequency [Hz]", ylabel="largest amplitude\nheld [deg]", xlim=(0, None))
    axes.set_ylim(0, HEADROOM * axes.get_ylim()[1])  # the largest bend is a flat top
    axes.legend(loc="lower left", ncols=3, **TIGHT)
