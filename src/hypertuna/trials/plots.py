"""Figures of replays: the pose of the head over time, with the tracked runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.description.robot import Robot
from hypertuna.figures import COLORS, FAINT, WIDTH, styled
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import AXES, head_center, seen_from_start
from hypertuna.trials.tracks import Track

if TYPE_CHECKING:
    import xarray as xr

SCALES = {"m": ("cm", 100.0), "rad": ("deg", 180 / np.pi)}
COLUMN = 2.6  # inch, minimum width of the panels of a recording
TITLE = "Center of the head link, from its start"


@styled
def plot_replay(robot: Robot, result: xr.Dataset, tracks: Sequence[Track], *, width: float = WIDTH) -> Figure:
    """Plot the pose of the head link's center over time, from its start, with the tracked runs; width [inch]."""
    figure = Figure(figsize=(width, width), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    _plot(panels, robot, result, tracks)
    _label(panels)
    figure.suptitle(TITLE)
    return figure


@styled
def plot_recordings(
    robot: Robot, recordings: Sequence[Recording], results: Sequence[xr.Dataset], *, width: float = WIDTH
) -> Figure:
    """Plot replays of recordings side by side, as `plot_replay`, on one scale; width, at least [inch]."""
    figure = Figure(figsize=(max(width, COLUMN * len(recordings)), WIDTH), layout="constrained")
    panels = figure.subplots(3, len(recordings), sharex="col", sharey="row", squeeze=False)
    for column, recording, result in zip(panels.T, recordings, results, strict=True):
        _plot(column, robot, result, recording.tracks)
        column[0].set_title(recording.name)
    _label(list(panels[:, 0]))
    for panel in panels[-1]:
        panel.set_xlabel("time [s]")
    figure.suptitle(TITLE)
    return figure


def _plot(panels: Sequence[Axes], robot: Robot, result: xr.Dataset, tracks: Sequence[Track]) -> None:
    """Plot tracked runs and a replay, one panel per axis."""
    center = head_center(robot, result)
    direction = tracks[0].pose[0, 2] if tracks else center[0, 2]
    curves: list[tuple[str, Any, float, Any, Any]] = [
        ("tracked", FAINT, 0.6, track.time, track.pose) for track in tracks
    ]
    curves.append((f"replayed, {robot.name}", COLORS[0], 1.8, result["time"].to_numpy(), center))
    for name, color, line, time, pose in curves:
        seen = seen_from_start(pose, direction)
        for k, (panel, unit) in enumerate(zip(panels, AXES.values(), strict=True)):
            panel.plot(time, SCALES[unit][1] * seen[:, k], color=color, linewidth=line, label=name)


def _label(panels: Sequence[Axes]) -> None:
    """Set labels and legend."""
    for panel, (axis, unit) in zip(panels, AXES.items(), strict=True):
        panel.set_ylabel(f"head {axis} [{SCALES[unit][0]}]")
    panels[-1].set_xlabel("time [s]")
    lines, names = panels[0].get_legend_handles_labels()
    panels[0].legend(dict(zip(names, lines, strict=True)).values(), dict.fromkeys(names), frameon=False)
