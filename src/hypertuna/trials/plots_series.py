"""Figures of measured joint angles and tracked paths."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.display import plots
from hypertuna.errors import InputError
from hypertuna.figures import COLORS, FAINT, INK, TIGHT, WIDTH, sequence, styled
from hypertuna.trials.manifest import Recording
from hypertuna.trials.smoothing import SmoothSeries
from hypertuna.trials.tracks import JointSeries, Track

POINTS_PER_SAMPLE = 10  # plotted points of a smoothed curve per measured sample


@plots.of(JointSeries)
@styled
def plot_series(series: JointSeries, *, width: float = WIDTH) -> Figure:
    """Plot measured joint angles over time; `width` [inch]."""
    figure = Figure(figsize=(width, 0.36 * width + 0.6), layout="constrained")
    _draw_angles(figure.subplots(), series, "-")
    figure.legend(loc="outside lower left", ncols=5, **TIGHT)
    return figure


@plots.of(SmoothSeries)
@styled
def plot_smooth(smoothed: SmoothSeries, *, width: float = WIDTH) -> Figure:
    """Plot measured joint angles as dots, and their smooth curves; `width` [inch]."""
    figure = Figure(figsize=(width, 0.36 * width + 0.6), layout="constrained")
    axes, series = figure.subplots(), smoothed.series
    _draw_angles(axes, series, ".")
    time = np.linspace(series.time[0], series.time[-1], POINTS_PER_SAMPLE * len(series.time))
    for g, angle in enumerate(np.degrees(smoothed(time)[..., 0]).T):
        axes.plot(time, angle, color=INK, lw=0.9, label="smoothed" if g == 0 else None)
    figure.legend(loc="outside lower left", ncols=5, **TIGHT)
    return figure


@plots.of(Track)
def plot_track(track: Track, *, width: float = WIDTH) -> Figure:
    """Plot the path of a tracked run from above; `width` [inch]."""
    return _plot_tracks([track], width=width)


def plot_paths(recordings: Sequence[Recording], *, width: float = WIDTH) -> Figure:
    """Plot the paths of tracked runs from above; `width` [inch]."""
    return _plot_tracks([track for recording in recordings for track in recording.tracks], width=width)


@styled
def _plot_tracks(tracks: Sequence[Track], *, width: float) -> Figure:
    """Plot paths from above."""
    figure = Figure(figsize=(width, 0.5 * width + 0.6), layout="constrained")
    _draw_tracks(figure.subplots(), tracks)
    figure.legend(loc="outside lower left", ncols=4, **TIGHT)
    return figure


@plots.of(Recording)
@styled
def plot_recording(recording: Recording, *, width: float = WIDTH) -> Figure:
    """Plot the joint angles of a recording, and the paths of its runs; `width` [inch]."""
    figure = Figure(figsize=(width, 0.8 * width + 0.8), layout="constrained")
    upper, lower = figure.subplots(2, 1, height_ratios=(1, 1.3))
    _draw_angles(upper, recording.joints, "-")
    upper.set_title(f"{recording.name}: measured joint angles")
    _draw_tracks(lower, recording.tracks)
    (lines, texts), (lower_lines, lower_texts) = upper.get_legend_handles_labels(), lower.get_legend_handles_labels()
    figure.legend([*lines, *lower_lines], [*texts, *lower_texts], loc="outside lower left", ncols=4, **TIGHT)
    return figure


def _draw_angles(axes: Axes, series: JointSeries, look: str) -> None:
    """Draw the angle of each joint group over time."""
    groups = series.angle.shape[1]
    colors = COLORS if groups <= len(COLORS) else sequence(groups)
    for g, angle in enumerate(np.degrees(series.angle).T):
        axes.plot(series.time, angle, look, color=colors[g], lw=1.2, ms=3, label=f"joint group {g + 1}")
    axes.set(xlabel="time [s]", ylabel="bend [deg]", title="Measured joint angles")


def _draw_tracks(axes: Axes, tracks: Sequence[Track]) -> None:
    """Draw paths from above."""
    if not tracks:
        raise InputError("must hold a tracked run", key="plot", fix="read a manifest with tracks")
    few = len(tracks) <= len(COLORS) - 2  # the first two colors are those of joint groups
    for k, track in enumerate(tracks):
        name = track.run if few else "tracked runs" if k == 0 else None
        axes.plot(
            *track.pose[:, :2].T, color=COLORS[k + 2] if few else FAINT, lw=1.2, label=f"run {name}" if few else name
        )
        axes.plot(*track.pose[0, :2], "o", color=INK, ms=5, mfc="white", label="start" if k == 0 else None)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Tracked head, from above")
    axes.set_adjustable("datalim")
