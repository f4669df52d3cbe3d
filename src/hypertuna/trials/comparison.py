"""Compare recordings with the model: errors of a replay, repeatability, best time offset."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.arguments import check_made_by, checked
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, robot_of
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import (
    POSE,
    Pose,
    at_times,
    head_center,
    joint_grid,
    replay,
    rmse,
    seen_from_start,
    together,
)
from hypertuna.trials.smoothing import SmoothSeries
from hypertuna.trials.start import beat_of, begin_of, with_first_poses
from hypertuna.trials.tracks import Track

if TYPE_CHECKING:
    import xarray as xr

MAX_SHIFT = 0.25  # s: largest shift to either side in the search for the best time offset
GRID_POINTS = 51  # time offsets tried first
TINY = 1e-20  # m^2 or rad^2: keeps the logarithm finite for replays without error


@checked
def replay_recording(robot: Robot | str | Path, recording: Recording, *, step: float | None = None) -> xr.Dataset:
    """Swim the joint angles of a recording with the model, from rest or from the recording's initial motion.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    recording : Recording
    step : float, optional
        Maximum Runge-Kutta step [s]; default: that of `replay`.

    Returns
    -------
    xarray.Dataset
        As of `replay`, on the clock and in the axes of the tracks, from the start of the first one. Attribute ``begin``
        says whether the twist at the start is that of rest, given, or estimated from the first beat.
    """
    robot = robot_of(robot)
    curve = recording.smoothed()
    twist, tracks, begin = how_begun(robot, recording, curve)
    start = Pose.from_head_center(robot, *tracks[0].pose[0])
    options: dict[str, Any] = {"step": step, "time_offset": recording.time_offset}
    result = replay(robot, curve, start=start, twist=None if twist is None else tuple(twist.tolist()), **options)
    return result.assign_attrs(recording=recording.name, joint_noise_deg=np.degrees(curve.noise), begin=begin)


def how_begun(robot: Robot, recording: Recording, curve: SmoothSeries) -> tuple[Array | None, list[Track], str]:
    """Return the initial twist (3,), None at rest; tracks with corrected first poses; a text on how the runs begin."""
    stated, inexact = recording.begin(robot)
    joints, step = joint_grid(robot, curve)
    arguments = robot, joints, step, recording.tracks, stated, inexact
    twist, error = begin_of(*arguments, until=1 / beat_of(curve)[0])
    text = "in motion, velocity given" if recording.velocity is not None else "at rest"
    if recording.moving and recording.velocity is None:
        text = "in motion, velocity estimated from the first beat"
    return twist, with_first_poses(recording.tracks, error), text


def with_fitted_clock(robot: Robot, recording: Recording) -> Recording:
    """Return the recording with the time offset in the robot's table [fit], if that has one."""
    name = f"time_offset[{recording.name}]"
    if robot.fit is None or name not in robot.fit.names:
        return recording
    return replace(recording, time_offset=robot.fit.value[robot.fit.names.index(name)])


@checked
def compare_recording(robot: Robot | str | Path, recording: Recording, result: xr.Dataset) -> xr.Dataset:
    """Compare a replay with every run of its recording, also at the best time offset.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    recording : Recording
        All its runs overlap the replay.
    result : xarray.Dataset
        As of `replay_recording`, complete.

    Returns
    -------
    xarray.Dataset
        As of `rmse`, with ``ratio`` = rmse / repeatability, which is 1 at best; ``best_offset_rmse`` and
        ``best_offset_ratio`` are the same with the best time offset. Attributes: ``time_offset_s`` as given, and
        ``best_time_offset_s``.
    """
    robot = robot_of(robot)
    check_made_by("replay_recording", result, "result", POSE)
    tracks = how_begun(robot, recording, recording.smoothed())[1]
    errors = rmse(robot, result, tracks)
    shift = best_time_offset(robot, result, tracks)
    time = result["time"]
    shifted = result.assign_coords(time=("time", time.to_numpy() + shift, time.attrs))
    best = rmse(robot, shifted, tracks)
    rms = np.where(errors.repeatability > 0, errors.repeatability, np.nan)
    compared = errors.assign(ratio=errors.rmse / rms, best_offset_rmse=best.rmse, best_offset_ratio=best.rmse / rms)
    offset = recording.time_offset
    return compared.assign_attrs(time_offset_s=offset, best_time_offset_s=offset + shift)


def best_time_offset(robot: Robot, result: xr.Dataset, tracks: Sequence[Track]) -> float:
    """Return the shift of a replay's clock [s] that fits the tracked runs best, by maximum likelihood.

    It minimizes the product of the three axes' rmse, at frames that the replay spans for all shifts.
    """
    from scipy.optimize import minimize_scalar  # imported here: slow to import

    time, direction = result["time"].to_numpy(), tracks[0].pose[0, 2]
    limit = min(MAX_SHIFT, float(np.ptp(time)) / 4)
    computed = seen_from_start(head_center(robot, result), direction)
    used = [track.time <= time[-1] - limit for track in tracks]
    clock = np.concatenate([track.time[frames] for track, frames in zip(tracks, used, strict=True)])
    tracked = [seen_from_start(track.pose, direction)[frames] for track, frames in zip(tracks, used, strict=True)]
    target = np.concatenate(tracked)
    if not len(target):
        return 0.0

    def cost(shift: float) -> float:
        return float(np.log(((at_times(clock, time + shift, computed) - target) ** 2).mean(axis=0) + TINY).sum())

    grid = np.linspace(-limit, limit, GRID_POINTS)
    k = int(np.argmin([cost(shift) for shift in grid]))
    interval = (grid[max(k - 1, 0)], grid[min(k + 1, GRID_POINTS - 1)])
    return float(minimize_scalar(cost, bounds=interval, method="bounded", options={"xatol": 1e-5}).x)


def repeatability(tracks: Sequence[Track]) -> Array:
    """Return the root mean square deviation (3,) [m, m, rad] of tracked runs from their mean; NaN for a single run."""
    time, poses = together(tracks)
    if len(tracks) < 2 or not len(time):
        return np.full(3, np.nan)
    along = np.ascontiguousarray(poses.transpose(0, 2, 1))
    return np.asarray(np.sqrt(((along - along.mean(axis=0)) ** 2).mean(axis=(0, 2))))
