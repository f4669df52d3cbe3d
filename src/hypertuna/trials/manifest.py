"""Manifests: TOML files that list the measurements of a tank, with their files, units and axes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, ValidationError, WithJsonSchema

from hypertuna.arrays import Array
from hypertuna.description.mistakes import translate
from hypertuna.description.robot import Robot
from hypertuna.description.schema.base import Count, Degrees, Flag, NotNegative, Part, Text, entry, number, unique
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, shown
from hypertuna.io.door import read_toml
from hypertuna.ranges import CELL, Range
from hypertuna.trials.replay import Pose, check_angles
from hypertuna.trials.smoothing import SmoothSeries, smooth
from hypertuna.trials.start import Velocity, beat_of, begin_together, begins_in_motion
from hypertuna.trials.tables import TABLES, Run
from hypertuna.trials.tracks import JointSeries, Track, lag_of, read_joints, read_tracks, series_columns

# --- the schema; keys of the file carry the unit, attributes are SI and radians

Real = Annotated[float, number(CELL)]  # within the limits for numbers in tables of measurements


def _noise(value: Any) -> float | tuple[float, ...]:
    """Check noise, a number or a list of numbers [deg], and convert it to radians."""
    several = value if isinstance(value, list) else [value]
    if not several or any(isinstance(x, bool) or not isinstance(x, (int, float)) or x not in NOISE for x in several):
        raise ValueError("must not be negative: a number of degrees, or a list of one per joint group")
    radians = tuple(math.radians(x) for x in several)
    return radians if isinstance(value, list) else radians[0]


NOISE = Range(min=0, max=180, unit="deg")  # standard deviations of joint angles
# JSON schema of noise: a number or a list of numbers.
NUMBERS = {"anyOf": [{"type": "number", "minimum": 0}, {"type": "array", "items": {"type": "number"}}]}


class Joints(Part):
    """Measured joint angles, in a CSV file."""

    file: Text = entry("path of the CSV file, from the manifest")
    time: Text = entry("column of time in s (default: time_s)", default="time_s")
    columns: tuple[Text, ...] = entry(
        "columns of angles, one per joint group from head to tail, then one per hinge if measured"
    )
    unit: Literal["deg", "rad"] = entry("unit of the angles in the file")
    noise: Annotated[Any, AfterValidator(_noise), WithJsonSchema(NUMBERS)] = entry(
        "standard deviation of the angles: a number for all joint groups, or a list (default: estimated)",
        "deg",
        default=None,
    )
    noise_tau: NotNegative | None = entry(
        "memory of the noise: a time T has T / noise_tau_s independent samples (default: all are)", "s", default=None
    )
    targets: tuple[Text, ...] | None = entry("columns of the commanded angles, in the same order", default=None)
    use: Literal["measured", "targets"] = entry(
        "angles that the robot made: measured (columns) or targets (default: measured)", default="measured"
    )


class Poses(Part):
    """Tracked poses of the center of the head link, in CSV files of one run or several."""

    files: tuple[Text, ...] = entry("paths of the CSV files, from the manifest", min_length=1)
    time: Text = entry("column of time in s (default: time_s)", default="time_s")
    x: Text = entry("column of x")
    y: Text = entry("column of y")
    yaw: Text = entry("column of the direction that the head faces")
    run: Text | None = entry("column that names the run of each row (default: a file is one run)", default=None)
    length_unit: Literal["m", "cm", "mm"] = entry("unit of x and y in the files")
    angle_unit: Literal["deg", "rad"] = entry("unit of yaw in the files")
    yaw_zero: Degrees = entry("direction of yaw 0, counter-clockwise from x (default: 0)", "deg", default=0.0)
    clockwise: Flag = entry("whether yaw is counted clockwise, from y to x (default: false)", default=False)


class Start(Part):
    """The pose at the first frame of every run, if it is known better than from tracking, such as from a fixture."""

    x: Real = entry("x of the center of the head link, in the axes of the poses", "m")
    y: Real = entry("y of the center of the head link", "m")
    yaw: Degrees = entry("direction that the head faces, counted as yaw of the poses", "deg")


class VelocityTable(Part):
    """The velocity through the water at the first sample, of the center of the head link."""

    forward: Real = entry("where the head faces", "m/s", key="forward_m_s")
    left: Real = entry("to port (default: 0)", "m/s", key="left_m_s", default=0.0)
    turn: Degrees = entry("counter-clockwise (default: 0)", "deg/s", key="turn_deg_s", default=0.0)


def _name(name: str) -> str:
    """Check the characters of a recording's name, and return it."""
    if "/" in name or "\0" in name or not name.strip(". "):
        raise ValueError("must be a name without /, and not of dots alone")
    return name


def _window(window: tuple[float, ...]) -> tuple[float, ...]:
    """Check that a window [s] is two increasing times, and return it."""
    if not (len(window) == 2 and window[0] < window[1]):
        raise ValueError("must be two times, the first earlier")
    return window


class Tank(Part):
    """The walls of the tank, in the axes of the poses: a run ends where the nose comes near one."""

    x: Annotated[tuple[Real, ...], AfterValidator(_window)] = entry("walls across x: smallest and largest x", "m")
    y: Annotated[tuple[Real, ...], AfterValidator(_window)] = entry("walls across y", "m")
    wall_distance: NotNegative = entry("distance of the nose from a wall at which the run ends", "m")


class RecordingTable(Part):
    """Swims with the same joint motion: joint angles, and tracked poses of one run or several."""

    name: Annotated[Text, AfterValidator(_name)] = entry("name of the recording, without /")
    joints: Joints = entry("table of the joint angles")
    poses: Poses = entry("table of the tracked poses")
    start: Start | None = entry("table of the start pose (default: the first frame of each run)", default=None)
    time_offset: Real = entry("time to add to the joints' clock to get the poses' clock (default: 0)", "s", default=0.0)
    window: Annotated[tuple[Real, ...], AfterValidator(_window)] | None = entry(
        "begin and end of the data in use, on the poses' clock (default: everything)",
        "s",
        default=None,
    )
    repeats: Count = entry("number of swims that each tracked run is the mean of (default: 1)", default=1)
    begin: Literal["rest", "moving"] | None = entry(
        "whether the robot begins at rest in the water or in motion (default: at rest if joints and head are still)",
        default=None,
    )
    align: Literal["first", "all"] | None = entry(
        "frames that a run is compared from: the first one, whose pose is exact, or all, each as inexact as the first "
        "(default: first at rest, else all)",
        default=None,
    )
    velocity: VelocityTable | None = entry(
        "table of the velocity at the first sample (default: 0 at rest, else estimated from the first beat)",
        default=None,
    )


class Manifest(Part):
    """A manifest: the files of the measurements of one robot."""

    format: Literal[1] = entry("version of this format, 1")
    robot: Text | None = entry("name that the robot must have (default: any)", default=None)
    steady: tuple[Text, ...] = entry("paths of CSV files of steady runs, from the manifest", default=())
    recordings: tuple[RecordingTable, ...] = entry("list of tracked recordings", default=())
    tows: tuple[Text, ...] = entry("the same of towed bodies", default=())
    thrusts: tuple[Text, ...] = entry("the same of held fish", default=())
    powers: tuple[Text, ...] = entry("the same of the power of gaits", default=())
    turns: tuple[Text, ...] = entry("the same of the rate of turn of gaits", default=())
    glides: tuple[Text, ...] = entry("the same of glides", default=())
    yaw_decays: tuple[Text, ...] = entry("the same of yaw decays", default=())
    tank: Tank | None = entry("table of the tank's walls (default: far away)", default=None)


# --- the measurements


@dataclass(frozen=True)
class Recording(
    Plotted,
    Tabular,
    data=lambda recording: series_columns(recording.joints.time, angle=recording.joints.angle),
):
    """One measured joint motion, and the tracks of the runs that used it."""

    name: str  # without /
    joints: JointSeries  # within the window, on its own clock
    noise: float | tuple[float, ...] | None  # standard deviation of the joint angles [rad]; None to estimate it
    tracks: tuple[Track, ...]  # tracks of the runs, within the window; a given start pose is each track's first pose
    time_offset: float = 0.0  # added to the joints' clock to get the tracks' clock [s]
    window: tuple[float, float] | None = None  # begin and end of the data in use, on the tracks' clock [s]
    start: Pose | None = None  # pose of the nose at the first frame, if the manifest gives it
    repeats: int = 1  # number of swims that each track is the mean of
    file: str = ""  # manifest or folder
    moving: bool = False  # whether the runs begin in motion: the first frame is at the first sample of the joints
    velocity: Velocity | None = None  # at the first sample; None: 0 at rest, or estimated from the first beat if moving
    lag: tuple[float, ...] | None = None  # lag of measured joint angles behind their targets [s], if both are known
    ended: tuple[str, ...] = ()  # names of the runs that were cut near a wall of the tank
    align: bool = False  # whether first poses are as inexact as all frames, as they are in runs in motion
    noise_tau: float | None = None  # correlation time of the joint angles' noise [s]
    hinges: int = 0  # number of the last angles that are of hinges, which bend as measured

    def begin(self, robot: Robot) -> tuple[Array | None, bool]:
        """Return the initial twist (3,) [m/s, rad/s] of the runs, and whether their first poses have errors.

        Parameters
        ----------
        robot : Robot

        Returns
        -------
        twist : ndarray, shape (3,), or None
            u, v [m/s] and r [rad/s] of the head at the start; None at rest, NaN where it is unknown.
        inexact : bool
            Whether the first poses are as inexact as all frames.
        """
        twist = None if self.velocity is None else self.velocity.twist(robot)
        twist = np.full(3, np.nan) if self.moving and twist is None else twist
        return twist, self.start is None and (self.moving or self.align)

    def smoothed(self) -> SmoothSeries:
        """Return the joint angles as smooth functions of time, with the noise that the manifest states.

        Returns
        -------
        SmoothSeries
        """
        return smooth(self.joints, noise=self.noise, noise_tau=self.noise_tau)

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of the recording's runs: RECORDING/RUN."""
        return tuple(f"{self.name}/{track.run}" for track in self.tracks)


def read_manifest(path: str | Path, robot: Robot) -> tuple[Run | Recording, ...]:
    """Read a TOML manifest and the files that it names."""
    return parse_manifest(read_toml(path), robot, folder=Path(path).parent, file=str(path))


def parse_manifest(
    document: Mapping[str, Any], robot: Robot, *, folder: Path, file: str
) -> tuple[Run | Recording, ...]:
    """Check a manifest's document, read the files that it names, and return the trials."""
    try:
        manifest = Manifest.model_validate(document)
        _check(manifest, robot)
    except ValidationError as error:
        raise translate(error, document, Manifest, file) from None
    except InputError as error:
        raise InputError(error.rule, file=file, key=error.key, value=error.value, fix=error.fix) from None
    runs = (
        run
        for key, (_, read) in TABLES.items()
        for name in getattr(manifest, key)
        for run in read(folder / name, robot)
    )
    tables = enumerate(manifest.recordings)
    recordings = (_recording(table, f"recordings[{i}]", robot, folder, file, manifest.tank) for i, table in tables)
    return (*runs, *recordings)


def _check(manifest: Manifest, robot: Robot) -> None:
    """Check a manifest for the rules that its schema cannot state, such as one column per joint group."""
    if manifest.robot not in (None, robot.name):
        fix = "choose the robot that swam"
        raise InputError(f"must be the robot's name, {robot.name}", key="robot", value=shown(manifest.robot), fix=fix)
    if not manifest.recordings and not any(getattr(manifest, key) for key in TABLES):
        fix = f"name the files of measurements; lists are {', '.join(TABLES)}"
        raise InputError("or recordings must be given", key="steady", fix=fix)
    for check in unique(tuple(table.name for table in manifest.recordings), "recordings[{}].name"):
        if not check.holds:
            raise InputError(check.text, key=check.where, value=check.value, fix=check.fix)
    for i, table in enumerate(manifest.recordings):
        if table.begin == "rest" and table.velocity is not None:
            fix = "leave out one of the two"
            raise InputError('cannot be given with begin = "rest"', key=f"recordings[{i}].velocity", fix=fix)
        columns = len(table.joints.columns)
        check_angles(robot, columns, f"the number of recordings[{i}].joints.columns", "name the columns")
        if isinstance(table.joints.noise, tuple) and (count := len(table.joints.noise)) != columns:
            rule, key = f"must be one number, or {columns} like columns", f"recordings[{i}].joints.noise_deg"
            raise InputError(rule, key=key, value=f"{count} long", fix="give as many numbers")


def _recording(table: RecordingTable, key: str, robot: Robot, folder: Path, file: str, tank: Tank | None) -> Recording:
    """Read the files of a recording, cut them to the window and the tank, and set how it begins."""
    poses, window, start = table.poses, None, None
    joints, lag = _joints(table.joints, key, folder, file)
    tracks = _tracks(poses, key, folder, file)
    if table.window is not None:
        window = begin, end = table.window[0], table.window[1]
        joints = _cut_joints(joints, begin - table.time_offset, end - table.time_offset)
        tracks = [_frames(track, (track.time >= begin) & (track.time <= end)) for track in tracks]
    frame_counts = [len(track.time) for track in tracks]
    if tank is not None:
        tracks = [_before_walls(track, robot, tank) for track in tracks]
    ended = tuple(t.run for t, count in zip(tracks, frame_counts, strict=True) if len(t.time) < count)
    span = joints.time[[0, -1]] + table.time_offset
    for track in tracks:
        if not ((track.time[1:] >= span[0]) & (track.time[1:] <= span[1])).any():
            rule = f"must have at least two frames, the second within the joint angles, {span[0]:g} to {span[1]:g} s"
            spans = [f", {track.time[0]:g} to {track.time[-1]:g} s"] if len(track.time) else []
            value = "".join([f"{len(track.time)} frames", *spans])
            fix = "put both on the same clock, by time_offset_s, and a window that spans them"
            fix = "lower wall_distance_m, or correct the walls" if track.run in ended else fix
            raise InputError(rule, file=file, key=f"{key}: run {track.run}", value=value, fix=fix)
    velocity = None if table.velocity is None else Velocity(**dict(table.velocity))
    moving = table.begin == "moving" or velocity is not None
    noise: dict[str, Any] = {"noise": table.joints.noise, "noise_tau": table.joints.noise_tau}
    if table.begin is None and not moving:
        moving = begins_in_motion(smooth(joints, **noise), tracks)
    if moving:
        period = 1 / beat_of(smooth(joints, **noise))[0]
        joints, tracks = _begin_together(joints, tracks, table.time_offset, period, f"{file}: {key}")
    if table.start is not None:
        yaw = poses.yaw_zero + (-table.start.yaw if poses.clockwise else table.start.yaw)
        first_pose = table.start.x, table.start.y, yaw
        tracks = [_from_start(track, np.array(first_pose)) for track in tracks]
        start = Pose.from_head_center(robot, *first_pose)
    hinges = len(table.joints.columns) - len(robot.joints)
    rest = (table.time_offset, window, start, table.repeats, file, moving, velocity, lag, ended, table.align == "all")
    return Recording(table.name, joints, table.joints.noise, tuple(tracks), *rest, table.joints.noise_tau, hinges)


def _joints(table: Joints, key: str, folder: Path, file: str) -> tuple[JointSeries, tuple[float, ...] | None]:
    """Read the joint angles to use, and the lag [s] of measured angles behind their targets (None without targets)."""
    options: dict[str, Any] = {"time": table.time, "unit": table.unit}
    if table.use == "targets" and table.targets is None:
        fix = "name their columns, or leave out use"
        raise InputError('must be given with use = "targets"', file=file, key=f"{key}.joints.targets", fix=fix)
    if table.targets is None:
        return read_joints(folder / table.file, columns=table.columns, **options), None
    if len(table.targets) != len(table.columns):
        rule, value = f"must be {len(table.columns)} long, like columns", f"{len(table.targets)} long"
        raise InputError(rule, file=file, key=f"{key}.joints.targets", value=value, fix="name one per joint group")
    measured = read_joints(folder / table.file, columns=table.columns, **options)
    targets = read_joints(folder / table.file, columns=table.targets, **options)
    return (targets if table.use == "targets" else measured), lag_of(measured, targets)


def _tracks(poses: Poses, key: str, folder: Path, file: str) -> list[Track]:
    """Read the tracked runs of a recording."""
    options: dict[str, Any] = {name: value for name, value in poses if name not in ("files", "x", "y", "yaw")}
    pose = (poses.x, poses.y, poses.yaw)
    tracks = [track for name in poses.files for track in read_tracks(folder / name, pose=pose, **options)]
    names = [track.run for track in tracks]
    for name in (name for k, name in enumerate(names) if name in names[:k]):
        fix = "name each run differently, or each file where a file is one run"
        raise InputError("must be unique", file=file, key=f"{key}: run {name}", value="in two files", fix=fix)
    return tracks


def _begin_together(
    joints: JointSeries, tracks: Sequence[Track], offset: float, period: float, place: str
) -> tuple[JointSeries, list[Track]]:
    """Call `begin_together`, and add file and key to its errors."""
    try:
        return begin_together(joints, tracks, offset, period)
    except InputError as error:
        raise InputError(error.rule, file=place, key=error.key, value=error.value, fix=error.fix) from None


def _frames(track: Track, kept: Any) -> Track:
    """Return a track with only some of its frames; kept: slice, indices or mask."""
    return replace(track, time=track.time[kept], pose=track.pose[kept])


def _before_walls(track: Track, robot: Robot, tank: Tank) -> Track:
    """Return a track cut before the frame in which the nose first comes near a wall."""
    half, yaw = robot.links.length[0] / 2, track.pose[:, 2]
    near = np.zeros(len(yaw), dtype=bool)
    for nose, (low, high) in (
        (track.pose[:, 0] + half * np.cos(yaw), tank.x),
        (track.pose[:, 1] + half * np.sin(yaw), tank.y),
    ):
        near |= (nose - low < tank.wall_distance) | (high - nose < tank.wall_distance)
    return _frames(track, slice(0, int(np.argmax(near)) if near.any() else len(near)))


def _cut_joints(joints: JointSeries, begin: float, end: float) -> JointSeries:
    """Cut joint angles to times from `begin` to `end` [s] on their own clock."""
    kept = np.flatnonzero((joints.time >= begin) & (joints.time <= end))
    if not len(kept):
        value = f"{joints.time[0]:g} to {joints.time[-1]:g} s"
        rule = f"must overlap the window, {begin:g} to {end:g} s of the joints' clock"
        raise InputError(rule, file=joints.file, key="the series", value=value, fix="correct window_s")
    lines = None if joints.lines is None else [joints.lines[k] for k in kept.tolist()]
    return replace(joints, time=joints.time[kept], angle=joints.angle[kept], lines=lines)


def _from_start(track: Track, start: Array) -> Track:
    """Replace a track's first pose by the start pose (3,), whose yaw gets the same number of whole turns."""
    turns = 2 * np.pi * np.round((track.pose[0, 2] - start[2]) / (2 * np.pi))
    first = start + np.array([0, 0, turns])
    return replace(track, pose=np.concatenate([first[np.newaxis], track.pose[1:]]))
