"""Replay: swim measured joint angles with the model, and compare its track with the tracked one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from hypertuna import _core
from hypertuna.arguments import check_made_by, checked
from hypertuna.arrays import Array
from hypertuna.description.pose import coordinate_names, coordinate_shares
from hypertuna.description.robot import Robot, robot_of
from hypertuna.errors import InputError, shown
from hypertuna.io.files import dataset
from hypertuna.ranges import POSITIVE
from hypertuna.swimming.model import core_model, twist_from_rest
from hypertuna.swimming.trajectory import trajectory
from hypertuna.trials.smoothing import SmoothSeries, smooth
from hypertuna.trials.tracks import JointSeries, Track

if TYPE_CHECKING:
    import xarray as xr

MAX_STEPS = 1_000_000  # largest number of steps of a replay
STEPS_PER_SAMPLE = 2  # Runge-Kutta steps per median interval of the series
MAX_SPEED = 1e3  # body lengths or radians per second; faster motions have diverged
POSE = ("time", "x", "y", "heading")  # variables of a replay's data set that define the pose
AXES = {"x": "m", "y": "m", "yaw": "rad"}  # axes of a pose and their units
BORDER = {"m": ("cm", 100.0), "rad": ("deg", 180 / math.pi)}  # displayed unit, and displayed units per SI unit


class Pose(NamedTuple):
    """Pose of the nose: x, y [m], and heading [rad].

    The heading is the direction from nose to tail, counter-clockwise from x: opposite to where the head faces.
    """

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    @classmethod
    def from_head_center(cls, robot: Robot, x: float, y: float, yaw: float) -> Self:
        """Return the pose of the nose from the center of the head link, which is half a head length behind.

        Parameters
        ----------
        robot : Robot
        x, y : float
            Center of the head link [m].
        yaw : float
            Direction that the head faces [rad], counter-clockwise from x.

        Returns
        -------
        Pose
            heading = yaw - pi.
        """
        half = robot.links.length[0] / 2
        return cls(x + half * math.cos(yaw), y + half * math.sin(yaw), yaw - math.pi)


ORIGIN = Pose()  # nose at the origin, tail along x


@checked
def replay(
    robot: Robot | str | Path,
    series: JointSeries | SmoothSeries,
    *,
    start: Pose = ORIGIN,
    twist: tuple[float, float, float] | None = None,
    step: float | None = None,
    current: tuple[float, float] = (0.0, 0.0),
    time_offset: float = 0.0,
) -> xr.Dataset:
    """Swim measured joint angles with the model.

    Parameters
    ----------
    robot : Robot, str or Path
        Its joint bandwidth does not apply to measured angles.
    series : JointSeries or SmoothSeries
    start : Pose
        At the first sample, see `Pose.from_head_center`.
    twist : tuple of float, optional
        u, v [m/s] and r [rad/s] of the head through the water at the first sample; default: no momentum.
    step : float, optional
        Maximum Runge-Kutta step [s]; default: half the median interval of the series.
    current : tuple of float
        Uniform velocity of the water in the frame of the result, x and y [m/s].
    time_offset : float
        Added to the times of the series [s], to get those of the tracked poses.

    Returns
    -------
    xarray.Dataset
        As `Swim.trajectory`. Attribute ``status`` is "completed" or "diverged", ``status_text`` a sentence on it; a
        diverged replay ends with its last finite step.
    """
    robot = robot_of(robot)
    check_replay(robot, series.series if isinstance(series, SmoothSeries) else series, step)
    curve = series if isinstance(series, SmoothSeries) else smooth(series)
    inputs = {"start": start, "twist": twist or (), "current": current, "time_offset": (time_offset,)}
    for key, values in inputs.items():
        if not np.isfinite(values).all():
            raise InputError("must be finite", key=key, value=shown(values), fix="give finite numbers")
    time = curve.series.time
    joints, width = joint_grid(robot, curve, step=step)
    steps = len(joints) // 2
    # by default the momentum is zero, since an error in the first joint rates would cause one that decays slowly
    head = twist_from_rest(robot, joints[0]) if twist is None else np.array(twist, dtype=float)
    motion = _core.advance(core_model(robot), joints, step=width, twist=head, pose=np.array(start, dtype=float))
    bounds = MAX_SPEED * np.array([robot.body.length, robot.body.length, 1.0])
    valid = (np.abs(motion["twist"]) < bounds).all(axis=1) & np.isfinite(motion["torque"]).all(axis=1)
    count = len(motion["twist"]) if valid.all() else max(1, int(np.argmin(valid)))  # number of steps before it diverges
    elapsed: Array = width * np.arange(count, dtype=np.float64)
    motion = {name: values[:count] for name, values in motion.items()}
    result = trajectory(robot, elapsed, joints[::2][:count], motion, current=current)
    result = result.assign_coords(time=("time", time[0] + time_offset + elapsed, result["time"].attrs))
    if count > steps:
        status, text = "completed", f"The replay is complete: {steps} steps of {width:.3g} s."
    else:
        status = "diverged"
        text = (
            f"The replay diverged {count * width:.3g} s after its start: its speeds exceeded all bounds; "
            f"take steps shorter than {width:.3g} s, or check the coefficients."
        )
    return result.assign_attrs(joints="measured", joint_file=curve.series.file or "", status=status, status_text=text)


def joint_grid(robot: Robot, curve: SmoothSeries, *, step: float | None = None) -> tuple[Array, float]:
    """Return the joint motion (2 steps + 1, links, 3) [rad, rad/s, rad/s^2] at half steps, and the step [s].

    Hinges bend as measured, if their angles follow those of the joint groups; otherwise they are rigid.
    """
    time = curve.series.time
    steps = math.ceil((time[-1] - time[0]) / _longest(time, step) * (1 - 1e-12))
    step = float(time[-1] - time[0]) / steps
    motion = curve(np.linspace(time[0], time[-1], 2 * steps + 1))
    return np.einsum("lc,tcd->tld", coordinate_shares(robot)[:, : motion.shape[1]], motion), step


def _longest(time: Array, step: float | None) -> float:
    """Return the longest step [s] of a replay: `step` if given, or half the median interval of the samples."""
    return float(np.median(np.diff(time))) / STEPS_PER_SAMPLE if step is None else step


def replay_jacobian(
    robot: Robot,
    joints: Array,
    step: float,
    directions: Array,
    *,
    model: _core.Model | None = None,
    twist: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Swim a joint motion from rest; return track (steps + 1, 3), its rate, and derivatives (steps + 1, 3, directions).

    joints: (2 steps + 1, links, 3) [rad, rad/s, rad/s^2]; directions: (parameters, directions). With an initial `twist`
    (3,) of the head, derivatives with respect to the twist come before those along the directions.
    """
    joints, along = np.ascontiguousarray(joints), np.ascontiguousarray(directions)
    track = _core.track(model or core_model(robot), joints, along, step=step, twist=twist)
    return track["pose"], track["rate"], track["gradient"]


def head_center(robot: Robot, result: xr.Dataset) -> Array:
    """Return the track (times, 3) [m, m, rad] of the head link's center: the inverse of `Pose.from_head_center`."""
    half, heading = robot.links.length[0] / 2, result["heading"].to_numpy()
    x, y = result["x"].to_numpy() + half * np.cos(heading), result["y"].to_numpy() + half * np.sin(heading)
    return np.column_stack([x, y, heading + math.pi])


def seen_from_start(pose: Array, direction: float) -> Array:
    """Move and rotate a track (frames, 3) [m, m, rad] so that it starts at the origin, facing `direction` [rad]."""
    turn = direction - pose[0, 2]
    x, y = (pose[:, :2] - pose[0, :2]).T
    c, s = math.cos(turn), math.sin(turn)
    return np.column_stack([c * x - s * y, s * x + c * y, pose[:, 2] - pose[0, 2]])


@checked
def residuals(robot: Robot | str | Path, result: xr.Dataset, track: Track) -> Array:
    """Return poses of a replay minus those of a tracked run, both relative to their first pose.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    result : xarray.Dataset
        As of `replay`; it spans the track at least in part.
    track : Track

    Returns
    -------
    ndarray, shape (frames, 3)
        x, y [m] and yaw [rad] in the axes of the track, at its frames that the replay spans.
    """
    robot = robot_of(robot)
    check_made_by("replay", result, "result", POSE)
    time = result["time"].to_numpy()
    inside = (track.time >= time[0]) & (track.time <= time[-1])
    if not inside.any():
        value = f"{track.time[0]:g} to {track.time[-1]:g} s"
        rule = f"must overlap the replay, {time[0]:g} to {time[-1]:g} s"
        raise InputError(rule, key=f"run {track.run}", value=value, fix="put both on the same clock")
    direction = track.pose[0, 2]
    computed = seen_from_start(head_center(robot, result), direction)
    difference: Array = at_times(track.time[inside], time, computed) - seen_from_start(track.pose, direction)[inside]
    return difference


@checked
def rmse(robot: Robot | str | Path, result: xr.Dataset, tracks: Sequence[Track]) -> xr.Dataset:
    """Return root mean square differences between a replay and tracked runs of the same joint motion.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    result : xarray.Dataset
        As of `replay`.
    tracks : sequence of Track
        One at least; all overlap the replay.

    Returns
    -------
    xarray.Dataset
        By axis (x, y [m], yaw [rad]; coordinate ``unit``): ``rmse`` over all frames of all runs, ``run_rmse`` of each,
        ``mean_rmse`` against the mean of the runs, and ``repeatability``, the root mean square of the runs about their
        mean, NaN for a single run: rmse^2 = mean_rmse^2 + repeatability^2. The mean is taken at the frames of the first
        run that all runs and the replay span.
    """
    robot = robot_of(robot)
    if not tracks:
        raise InputError("must hold at least one run", key="tracks", value="empty", fix="give the tracked poses")
    differences = [residuals(robot, result, track) for track in tracks]
    clock = result["time"].to_numpy()
    time, poses = together(tracks, clock[0], clock[-1])
    mean = poses.mean(axis=0)
    computed = seen_from_start(head_center(robot, result), tracks[0].pose[0, 2])
    repeatability = _rms((poses - mean).reshape(-1, 3)) if len(tracks) > 1 else np.full(3, np.nan)
    return dataset(
        {
            "rmse": ("axis", _rms(np.concatenate(differences))),
            "mean_rmse": ("axis", _rms(at_times(time, clock, computed) - mean)),
            "repeatability": ("axis", repeatability),
            "run_rmse": (("run", "axis"), np.array([_rms(difference) for difference in differences])),
            "frames": ("run", [len(difference) for difference in differences]),
        },
        {"axis": list(AXES), "unit": ("axis", list(AXES.values())), "run": [track.run for track in tracks]},
        result.attrs,
    )


def check_replay(robot: Robot, series: JointSeries, step: float | None) -> None:
    """Check, before smoothing, that a joint series has the robot's groups and that its replay is not too long."""
    check_angles(
        robot, series.angle.shape[1], "the number of angles", "name one column of angles per joint group", series.file
    )
    if step is not None:
        POSITIVE.check(step, "step", "give it in seconds")
    seconds, longest = float(np.ptp(series.time)), _longest(series.time, step)
    if seconds / longest > MAX_STEPS:
        value = f"{seconds / longest:.0f}: {seconds:.6g} s in steps of {longest:.3g} s"
        fix = f"take steps of at least {seconds / MAX_STEPS:.3g} s (--step), or replay the series in parts"
        rule = f"must take at most {MAX_STEPS} steps"
        raise InputError(rule, file=series.file, key="a replay", value=value, fix=fix)


def check_angles(robot: Robot, count: int, key: str, fix: str, file: str | None = None) -> None:
    """Check a number of angles: one per joint group, from head to tail, and maybe one per hinge after them."""
    groups, names = len(robot.joints), coordinate_names(robot)
    if count not in (groups, len(names)):
        rule = f"must be {groups}, one per joint group of {robot.name} ({', '.join(names[:groups])})"
        rule += f", or {len(names)}, with the hinges ({', '.join(names[groups:])})" * bool(robot.hinges)
        raise InputError(rule, file=file, key=key, value=str(count), fix=f"{fix}, from head to tail")


def together(tracks: Sequence[Track], begin: float = -math.inf, end: float = math.inf) -> tuple[Array, Array]:
    """Return times (frames,) [s] and poses (runs, frames, 3) at frames of the first run that all runs span."""
    direction, clock = tracks[0].pose[0, 2], tracks[0].time
    begin, end = max(begin, *(track.time[0] for track in tracks)), min(end, *(track.time[-1] for track in tracks))
    time = clock[(clock >= begin) & (clock <= end)]
    poses = [at_times(time, track.time, seen_from_start(track.pose, direction)) for track in tracks]
    return time, np.array(poses)


def at_times(time: Array, clock: Array, pose: Array) -> Array:
    """Return poses (frames, 3) on a clock (frames,) [s] interpolated at other times [s]."""
    return np.column_stack([np.interp(time, clock, pose[:, axis]) for axis in range(3)])


def _rms(values: Array) -> Array:
    """Return the root mean square of values over their first axis."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
