"""Figures of replays (the head's pose over time, with the tracked runs) and of trials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hypertuna.description.robot import Robot
from hypertuna.display import plots
from hypertuna.errors import InputError
from hypertuna.figures import COLORS, FAINT, WIDTH, styled
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import AXES, BORDER, head_center, seen_from_start
from hypertuna.trials.tracks import Track
from hypertuna.trials.trials import Trials

if TYPE_CHECKING:
    import xarray as xr

COLUMN = 2.6  # inch, minimum width of the panels of a recording


@plots.of(Trials)
@styled
def plot_trials(trials: Trials, *, width: float = WIDTH) -> Figure:
    """Plot the trials of the first kind that has any; `width` [inch]."""
    for kind, members in trials.kinds.items():
        return kind.plot(members, width=width)
    raise InputError("must hold a run", key="plot", fix="read a file with measured runs")


@styled
def plot_replay(robot: Robot, result: xr.Dataset, tracks: Sequence[Track], *, width: float = WIDTH) -> Figure:
    """Plot the pose of the head link's center over time, from its start, with the tracked runs; width [inch]."""
    return _figure(robot, [("", result, tracks)], width, width)


@styled
def plot_recordings(
    robot: Robot, recordings: Sequence[Recording], results: Sequence[xr.Dataset], *, width: float = WIDTH
) -> Figure:
    """Plot replays of recordings side by side with a common scale; width: smallest width of the figure [inch]."""
    cases = [(recording.name, result, recording.tracks) for recording, result in zip(recordings, results, strict=True)]
    return _figure(robot, cases, max(width, COLUMN * len(cases)), WIDTH)


def _figure(
    robot: Robot, cases: Sequence[tuple[str, xr.Dataset, Sequence[Track]]], width: float, height: float
) -> Figure:
    """Plot replays side by side; cases: title, replay and tracked runs."""
    figure = Figure(figsize=(width, height), layout="constrained")
    panels = figure.subplots(3, len(cases), sharex="col", sharey="row", squeeze=False)
    for column, (title, result, tracks) in zip(panels.T, cases, strict=True):
        _plot(column, robot, result, tracks)
        column[0].set_title(title)
        column[-1].set_xlabel("time [s]")
    for panel, (axis, unit) in zip(panels[:, 0], AXES.items(), strict=True):
        panel.set_ylabel(f"head {axis} [{BORDER[unit][0]}]")
    lines, names = panels[0, 0].get_legend_handles_labels()
    panels[0, 0].legend(dict(zip(names, lines, strict=True)).values(), dict.fromkeys(names), frameon=False)
    figure.suptitle("Center of the head link, from its start")
    return figure


def _plot(panels: Sequence[Axes], robot: Robot, result: xr.Dataset, tracks: Sequence[Track]) -> None:
    """Plot tracked runs and a replay, one panel per axis."""
    center = head_center(robot, result)
    direction = tracks[0].pose[0, 2] if tracks else center[0, 2]
    curves: list[Any] = [("tracked", FAINT, 0.6, track.time, track.pose) for track in tracks]
    curves.append((f"replayed, {robot.name}", COLORS[0], 1.8, result["time"].to_numpy(), center))
    for name, color, line, time, pose in curves:
        seen = seen_from_start(pose, direction)
        for k, (panel, unit) in enumerate(zip(panels, AXES.values(), strict=True)):
            panel.plot(time, BORDER[unit][1] * seen[:, k], color=color, linewidth=line, label=name)
