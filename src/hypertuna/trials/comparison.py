"""Recordings beside the model: replayed, errors of each axis beside repeatability, clocks as given and at best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.robot import Robot
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import Pose, head_center, replay, rmse, seen_from_start
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.tracks import Track

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["best_time_offset", "compare_recording", "repeatability", "replay_recording", "with_fitted_clock"]

Array = NDArray[np.float64]

REACH = 0.25  # s, to either side, within which the best time offset is looked for
GRID = 51  # offsets of the first look
TINY = 1e-20  # m^2 or rad^2: no error at all


def replay_recording(robot: Robot, recording: Recording, *, step: float | None = None) -> xr.Dataset:
    """Swim the joint angles of a recording, from rest.

    Parameters
    ----------
    robot : Robot
    recording : Recording
    step : float, optional
        Longest Runge-Kutta step [s]; left out, as for `replay`.

    Returns
    -------
    xarray.Dataset
        As `replay` returns it, on the clock and in the axes of the tracks; it starts where the first of them does.

    Raises
    ------
    InputError
        If the series does not fit the robot, or the step is out of range.
    """
    start = Pose.from_head_center(robot, *recording.tracks[0].pose[0])
    curve = smooth(recording.joints, noise=recording.noise)
    result = replay(robot, curve, start=start, step=step, time_offset=recording.time_offset)
    return result.assign_attrs(recording=recording.name, joint_noise_deg=np.degrees(curve.noise))


def with_fitted_clock(robot: Robot, recording: Recording) -> Recording:
    """Move the clock of a recording to where the robot's fit has it: returns [fit]."""
    name = f"time_offset[{recording.name}]"
    if robot.fit is None or name not in robot.fit.names:
        return recording
    return replace(recording, time_offset=robot.fit.value[robot.fit.names.index(name)])


def compare_recording(robot: Robot, recording: Recording, result: xr.Dataset) -> xr.Dataset:
    """Compare a replay with every run of its recording.

    Parameters
    ----------
    robot : Robot
    recording : Recording
    result : xarray.Dataset
        As `replay_recording` returns it, complete.

    Returns
    -------
    xarray.Dataset
        As `rmse`, with ``ratio`` = rmse / repeatability, which is 1 at best; and ``best_offset_rmse`` and
        ``best_offset_ratio``, the same with the clock of the joints moved by what fits best. Attributes:
        ``time_offset_s`` as given, and ``best_time_offset_s``.

    Raises
    ------
    InputError
        If a run does not overlap the replay.
    """
    found = rmse(robot, result, recording.tracks)
    shift = best_time_offset(robot, result, recording.tracks)
    best = rmse(robot, _shifted(result, shift), recording.tracks)
    unit = np.where(found.repeatability > 0, found.repeatability, np.nan)
    compared = found.assign(ratio=found.rmse / unit, best_offset_rmse=best.rmse, best_offset_ratio=best.rmse / unit)
    offset = recording.time_offset
    return compared.assign_attrs(time_offset_s=offset, best_time_offset_s=offset + shift)


def best_time_offset(robot: Robot, result: xr.Dataset, tracks: Sequence[Track]) -> float:
    """Find what to add to the clock of a replay so that it follows tracked runs best.

    The product of the three axes' rmse becomes least: the likelihood is largest where the scatter of each axis is not
    known. Compared are the frames that the replay spans wherever its clock is moved to; before its start, the robot
    rests.

    Returns [s].
    """
    from scipy.optimize import minimize_scalar  # here, because it takes longer to import than a replay takes

    time, direction = result["time"].to_numpy(), tracks[0].pose[0, 2]
    reach = min(REACH, float(np.ptp(time)) / 4)
    made = seen_from_start(head_center(robot, result), direction)
    seen = [seen_from_start(track.pose, direction)[track.time <= time[-1] - reach] for track in tracks]
    clock = np.concatenate([track.time[track.time <= time[-1] - reach] for track in tracks])
    target = np.concatenate(seen)
    if not len(target):
        return 0.0

    def cost(shift: float) -> float:
        at_frames = np.column_stack([np.interp(clock, time + shift, made[:, axis]) for axis in range(3)])
        return float(np.log(((at_frames - target) ** 2).mean(axis=0) + TINY).sum())

    grid = np.linspace(-reach, reach, GRID)
    k = int(np.argmin([cost(shift) for shift in grid]))
    between = (grid[max(k - 1, 0)], grid[min(k + 1, GRID - 1)])
    return float(minimize_scalar(cost, bounds=between, method="bounded", options={"xatol": 1e-5}).x)


def repeatability(tracks: Sequence[Track]) -> Array:
    """Return the root mean square of tracked runs about their mean, each seen from its first frame.

    Returns (3,) [m], [rad].
    """
    direction, clock = tracks[0].pose[0, 2], tracks[0].time
    begin, end = (edge(track.time[at] for track in tracks) for edge, at in ((max, 0), (min, -1)))
    time = clock[(clock >= begin) & (clock <= end)]
    if len(tracks) < 2 or not len(time):
        return np.full(3, np.nan)
    seen = [(track.time, seen_from_start(track.pose, direction)) for track in tracks]
    placed = np.array([[np.interp(time, at, pose[:, axis]) for axis in range(3)] for at, pose in seen])
    about: Array = np.sqrt(((placed - placed.mean(axis=0)) ** 2).mean(axis=(0, 2)))
    return about


def _shifted(result: xr.Dataset, shift: float) -> xr.Dataset:
    """Move the clock of a replay."""
    time = result["time"]
    return result.assign_coords(time=("time", time.to_numpy() + shift, time.attrs))
