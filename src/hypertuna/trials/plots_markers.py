"""Figure to check imported markers: the chain over the markers, residuals, joint angles with their errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.figures import COLORS, FAINT, INK, WIDTH, line_style, styled
from hypertuna.trials.marker_run import MarkerRun

POSTURES = 3  # number of chains in the first panel; more would hide each other
BAND, MAX_BAND = 2, 60.0  # half width of the band about an angle: standard deviations, and largest value [deg]


@styled
def plot_markers(run: MarkerRun, *, width: float = WIDTH) -> Figure:
    """Plot the chain over its markers, the residual of each marker, and joint angles; width [inch]."""
    figure = Figure(figsize=(width, 1.15 * width), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, height_ratios=(1.3, 0.8, 1))
    _plot_chain(top, run)
    _plot_residuals(middle, run)
    _plot_angles(bottom, run)
    figure.suptitle(f"{run.name}: chain of the robot over {len(run.places.names)} markers")
    return figure


def _plot_chain(panel: Axes, run: MarkerRun) -> None:
    """Plot some postures with their markers."""
    shown = np.concatenate(run.stretches) if run.stretches else np.flatnonzero((run.markers.weight > 0).sum(axis=1) > 2)
    frames = shown[np.linspace(0, len(shown) - 1, min(POSTURES, len(shown))).astype(int)]
    for k, (line, frame) in enumerate(zip(run.joints(frames), frames, strict=True)):
        color, time = COLORS[k + 1], run.markers.time[frame]
        panel.plot(*line.T, color=color, linewidth=3, alpha=0.55, label=f"chain at {time:.3g} s")
        panel.plot(*line[1:-1].T, "o", color=color, mfc="white", markersize=5, label="its joints" * (k == 0))
        panel.plot(*line[0], ">", color=color, markersize=6, label="its nose" * (k == 0))
        outliers = run.fit.rejected[frame]
        panel.plot(
            *run.markers.place[frame][~outliers].T, "x", color=INK, markersize=4, mew=0.8, label="markers" * (k == 0)
        )
        panel.plot(*run.markers.place[frame][outliers].T, "x", color=COLORS[0], markersize=6, mew=2)
    if run.fit.rejected[frames].any():
        panel.plot([], [], "x", color=COLORS[0], mew=2, label="rejected")
    panel.set_aspect("equal", adjustable="datalim")
    panel.set_xlabel("x [m]")
    panel.set_ylabel("y [m]")
    panel.set_title(f"{len(frames)} of {len(run.markers.time)} frames" + " (none can be used)" * (not run.stretches))
    panel.margins(y=0.15)
    panel.legend(loc="best", ncols=2)


def _plot_residuals(panel: Axes, run: MarkerRun) -> None:
    """Plot the distance of each marker from its place on the chain, in all frames."""
    distance = 1e3 * np.linalg.norm(run.fit.residual, axis=2)
    names: Sequence[str] = run.places.names
    rng = np.random.default_rng(0)
    for m in range(len(names)):
        for chosen, color, shape in ((~run.fit.rejected[:, m], FAINT, "."), (run.fit.rejected[:, m], COLORS[0], "x")):
            values = distance[chosen, m]
            panel.plot(
                m + rng.uniform(-0.2, 0.2, len(values)),
                values,
                shape,
                color=color,
                markersize=2.5,
                alpha=0.6,
                rasterized=True,
            )
    panel.axhline(1e3 * run.fit.noise, color=COLORS[1], label=f"noise of a coordinate, {1e3 * run.fit.noise:.2g} mm")
    offset = 1e3 * np.linalg.norm(run.offsets, axis=1)
    panel.plot(
        range(len(names)),
        offset,
        "D",
        color=INK,
        mfc="none",
        markersize=5,
        label="mean place of a marker from where it should be",
    )
    panel.set_yscale("log")
    panel.set_ylim(bottom=max(panel.get_ylim()[0], run.fit.noise))  # the axis need not show distances below the noise
    panel.set_xticks(range(len(names)), names, rotation=0 if len(names) < 12 else 90)
    panel.set_ylabel("distance [mm]")
    panel.set_title(f"Markers from the chain: {int(run.fit.rejected.sum())} rejected")
    panel.legend()


def _plot_angles(panel: Axes, run: MarkerRun) -> None:
    """Plot joint angles with a band of two standard deviations."""
    for k, frames in enumerate(run.stretches or [np.arange(len(run.markers.time))]):
        time = run.markers.time[frames]
        angle, sd = np.degrees(run.fit.angle[frames]), np.degrees(run.fit.sd[frames, 3:])
        for g, group in enumerate(run.chain.groups):
            style, band = line_style(g), np.minimum(BAND * sd[:, g], MAX_BAND)
            low, high = angle[:, g] - band, angle[:, g] + band
            panel.fill_between(time, low, high, color=style["color"], alpha=0.2, linewidth=0)
            panel.plot(time, angle[:, g], **style, linewidth=1, label=f"joint {group}" * (k == 0))
    panel.set_xlabel("time [s]")
    panel.set_ylabel("joint angle [deg]")
    panel.set_title(f"Joint angles, band of {BAND} standard deviations")
    panel.set_ylim(top=1.3 * max(panel.get_ylim()[1], 1.0))  # space for the legend
    panel.legend(loc="upper left", ncols=max(1, min(6, len(run.chain.groups))))
