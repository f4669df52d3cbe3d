"""Import poses and joint angles of other programs: ROS 2 bags, MCAP files, tables with quaternions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.pose import coordinate_names
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.bags import IN_JSON, JOINTS, POSES, Joints, Stamped, Topic, decoded, read_bag
from hypertuna.io.files import write_atomically
from hypertuna.ranges import CELL
from hypertuna.trials.head_motion import FASTEST, repeats_of, sideways, speed_of, tail_first
from hypertuna.trials.importers import manifest_text
from hypertuna.trials.pose_table import HALF_TURN, MOST, UNIT_TOLERANCE, pose_samples, pose_table
from hypertuna.trials.replay import check_angles
from hypertuna.trials.tracks import LENGTHS, MIN_SAMPLES

DIRECTIONS = ("x", "-x", "y", "-y", "z", "-z")  # names of axes
MIN_HORIZONTAL = 0.5  # horizontal length of the head's unit vector, below which it points up or down


@dataclass(frozen=True)
class View:
    """Axes that define how another program's poses become x, y and yaw of the head link's center from above."""

    up: str = "z"  # axis of the world that points up
    forward: str = "x"  # axis of the body that points to the nose
    ahead: float = 0.0  # distance of the head link's center ahead of the tracked point [m]


ROS = View()  # the axes of ROS


@dataclass(frozen=True)
class PoseRun:
    """The poses of a run, and its joint angles if the file has them."""

    name: str
    file: str
    source: str  # topic, or the file's form
    time: Array  # (frames,) [s] from the first frame
    pose: Array  # (frames, 3): x, y [m] of the center of the head link, and the direction faced [rad]
    joint_time: Array | None = None  # (samples,) [s], on the same clock
    angle: Array | None = None  # (samples, groups) [rad]
    joint_names: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def read_pose_run(
    robot: Robot,
    path: str | Path,
    *,
    view: View = ROS,
    topic: str | None = None,
    joints: Sequence[str] = (),
    frame_rate: float | None = None,
) -> PoseRun:
    """Read the poses of a robot, and its joint angles, from a bag of ROS 2, an MCAP file or a table.

    topic: of the poses, if there are several; joints: names from head to tail, one per joint group (default: all);
    frame_rate: of a table that has no column of time [Hz].
    """
    if Path(path).suffix.lower() in (".csv", ".tsv", ".txt"):
        return _of_table(robot, path, view, joints, frame_rate)
    if frame_rate is not None:
        rule, fix = "is for tables without a column of time", "leave it out: a bag has times"
        raise InputError(rule, file=str(path), key="--frame-rate", value=f"{frame_rate:g}", fix=fix)
    topics, fault = read_bag(path)
    file = str(path)
    if fault and not topics:
        fix = "record it again, or convert it: mcap recover, rosbags-convert"
        raise InputError("must be a whole bag of ROS 2 or log (MCAP)", file=file, value=fault, fix=fix)
    streams = _streams(file, topics)
    source = _chosen(file, streams, topic, topics)
    recorded, poses = streams[source]
    if len(parents := {pose.parent for pose in poses}) > 1:
        rule, fix = "must be poses in one frame", "record poses in the frame of the tank"
        raise InputError(rule, file=file, key=source, value=f"in {', '.join(sorted(parents))}", fix=fix)
    measured, notes = _joints(robot, file, topics, joints)
    stamps = [pose.time for pose in poses]
    by_header = all(stamp > 0 for stamp in stamps + [one.time for _, one in measured])
    notes += () if by_header else ("headers without times: the times are those of the recording",)
    notes += (f"the bag is {fault}: what was before is read",) if fault else ()
    clock = np.array(stamps if by_header else recorded, dtype=np.int64)
    start = int(clock.min())
    time, keep, pose_notes = _ordered(_seconds(clock, start), f"poses of {source}")
    place, turn = (np.array([getattr(pose, key) for pose in poses])[keep] for key in ("place", "turn"))
    pose = _seen_from_above(file, source, place, turn, view)
    joint_time = angle = None
    names = measured[0][1].names if measured else ()
    if measured:
        joint_clock = np.array([one.time if by_header else then for then, one in measured], dtype=np.int64)
        joint_time, keep, joint_notes = _ordered(_seconds(joint_clock, start), "joint angles")
        angle, pose_notes = np.array([one.position for _, one in measured])[keep], pose_notes + joint_notes
    return _checked(robot, PoseRun(_stem(path), file, source, time, pose, joint_time, angle, names, notes + pose_notes))


def _seconds(clock: NDArray[np.int64], start: int) -> Array:
    """Convert a clock [ns] to times [s] from a start [ns]."""
    return (clock - start) / 1e9


def _stem(path: str | Path) -> str:
    """Return the name of the run in a file: the file's name without its suffix."""
    return Path(path).resolve().stem


def _streams(file: str, topics: Mapping[str, Topic]) -> dict[str, tuple[list[int], list[Stamped]]]:
    """Return record times [ns] and poses of each stream, by TOPIC, or by TOPIC:FRAME for transforms."""
    streams: dict[str, tuple[list[int], list[Stamped]]] = {}
    for name, topic in topics.items():
        if topic.kind in (*POSES, *IN_JSON):
            for time, pose in decoded(file, name, topic):
                key = f"{name}:{pose.child}" if pose.child and "Odometry" not in topic.kind else name
                times, poses = streams.setdefault(key, ([], []))
                times.append(time)
                poses.append(pose)
    return {key: stream for key, stream in streams.items() if len(stream[0]) >= 2}


def _chosen(file: str, streams: Mapping[str, Any], topic: str | None, topics: Mapping[str, Topic]) -> str:
    """Return the name of the stream of poses to read: the given one, or the only one."""
    if not streams:
        listed = ", ".join(f"{name} ({one.kind})" for name, one in list(topics.items())[:8]) or "no messages"
        rule, fix = "must hold poses over time", f"record a topic of {', '.join(POSES)}"
        raise InputError(rule, file=file, value=shown(listed), fix=fix)
    if topic is None and len(streams) == 1:
        return next(iter(streams))
    if topic is None or topic not in streams:
        rule = f"must be one of {', '.join(list(streams)[:20])}"
        fix = "choose the poses of the robot's head" if topic is None else did_you_mean(topic, list(streams))
        raise InputError(rule, file=file, key="--topic", value=None if topic is None else shown(topic), fix=fix)
    return topic


def _joints(
    robot: Robot, file: str, topics: Mapping[str, Topic], wanted: Sequence[str]
) -> tuple[list[tuple[int, Joints]], tuple[str, ...]]:
    """Return record times [ns] and joint angles in a bag, one angle per joint group, and notes for the user."""
    sets = [joints for name, topic in topics.items() if topic.kind in JOINTS for joints in decoded(file, name, topic)]
    names = tuple(dict.fromkeys(name for _, joints in sets for name in joints.names))
    chosen = _chosen_joints(robot, file, names, wanted)
    measured = []
    for time, joints in sets:
        if chosen and set(chosen) <= set(joints.names) and len(joints.position) == len(joints.names):
            position = tuple(joints.position[joints.names.index(name)] for name in chosen)
            if not all(abs(value) < 100 for value in position):
                key, fix = f"joints at {time} ns", "record angles in rad"
                raise InputError("must be angles in rad", file=file, key=key, value=shown(position), fix=fix)
            measured.append((time, Joints(joints.time, chosen, position)))
    notes = (f"joints, from head to tail: {', '.join(chosen)}",) if chosen else ()
    return measured, notes


def _chosen_joints(robot: Robot, file: str, names: Sequence[str], wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the names of joints from head to tail, wanted ones or all; check that there is one per joint group."""
    for name in wanted:
        if name not in names:
            fix = did_you_mean(name, names) if names else "the file has no joints"
            raise InputError("must be a joint of the file", file=file, key="--joints", value=shown(name), fix=fix)
    chosen = tuple(wanted) or tuple(names)
    if chosen:
        check_angles(robot, len(chosen), "the number of --joints", f"name them of {', '.join(names)}", file)
    return chosen


def _ordered(time: Array, what: str) -> tuple[Array, Array, tuple[str, ...]]:
    """Return sorted, distinct times, the index of each one's sample, and a note if samples were left out."""
    order = np.argsort(time, kind="stable")
    keep = order[np.append(True, np.diff(time[order]) > 0)]
    dropped = len(time) - len(keep)
    return time[keep], keep, (f"{dropped} {what} at the time of another are left out",) if dropped else ()


def _seen_from_above(file: str, source: str, place: Array, turn: Array, view: View) -> Array:
    """Return x, y [m] and yaw [rad] (frames, 3) from places (frames, 3) and quaternions x, y, z, w (frames, 4)."""
    with np.errstate(over="ignore", invalid="ignore"):
        size = np.linalg.norm(turn, axis=1)
    for k in np.flatnonzero(
        ~((abs(size - 1) < UNIT_TOLERANCE) & np.array([all(x in CELL for x in row) for row in place]))
    )[:1]:
        key, fix = f"pose {k + 1} of {source}", "leave out poses without a direction"
        value = shown([*place[k].tolist(), *turn[k].tolist()])
        raise InputError("must be a place and a unit quaternion", file=file, key=key, value=value, fix=fix)
    forward = _turned(turn / size[:, np.newaxis], _axis(view.forward))
    across, along = _plane(_axis(view.up))
    center = place + view.ahead * forward
    facing = np.column_stack([forward @ across, forward @ along])
    if np.median(np.linalg.norm(facing, axis=1)) < MIN_HORIZONTAL:
        rule, fix = "must lie flat", "choose the axis of the body that points to the nose, or the one that points up"
        value = f"{view.forward} of the body, which points up or down most of the time"
        raise InputError(rule, file=file, key="--forward or --up", value=value, fix=fix)
    yaw = np.unwrap(np.arctan2(facing[:, 1], facing[:, 0]))
    return np.column_stack([center @ across, center @ along, yaw])


def _axis(name: str) -> Array:
    """Return the unit vector (3,) of an axis by its name, such as "-x"."""
    sign = -1.0 if name.startswith("-") else 1.0
    return np.asarray(sign * np.eye(3)["xyz".index(name[-1])])


def _plane(up: Array) -> tuple[Array, Array]:
    """Return two axes of the horizontal plane: the first of x and y that lies in it, and the axis to its left."""
    first = np.eye(3)[0] if up[0] == 0 else np.eye(3)[1]
    return first, np.cross(up, first)


def _turned(turn: Array, axis: Array) -> Array:
    """Rotate an axis (3,) by unit quaternions x, y, z, w (frames, 4); return (frames, 3)."""
    vector, scalar = turn[:, :3], turn[:, 3:]
    twice = 2 * np.cross(vector, axis)
    return np.asarray(axis + scalar * twice + np.cross(vector, twice))


def _of_table(robot: Robot, path: str | Path, view: View, wanted: Sequence[str], frame_rate: float | None) -> PoseRun:
    """Read a table of time, place and quaternion, and optionally joint angles, as other simulators write it."""
    samples, comments = pose_samples(path)
    joints = _chosen_joints(robot, samples.file, samples.head, wanted) if wanted else ()
    table = pose_table(samples, joints, frame_rate, comments)
    pose = _seen_from_above(samples.file, "the table", table.place, table.turn, view)
    run = PoseRun(_stem(path), samples.file, "the table", table.time, pose, notes=table.notes)
    return _checked(
        robot, replace(run, joint_time=table.time, angle=table.angle, joint_names=joints) if joints else run
    )


def _checked(robot: Robot, run: PoseRun) -> PoseRun:
    """Return a run after checks of its poses and joint angles, with sentences on unlikely ones."""
    if len(run.time) < MIN_SAMPLES:
        rule, value = f"must hold at least {MIN_SAMPLES} poses", f"{len(run.time)} of {run.source}"
        raise InputError(rule, file=run.file, value=value, fix="record a longer run")
    speed, length = speed_of(run.time, run.pose), robot.body.length
    if speed > FASTEST * length:
        likely = " or ".join(unit for unit in ("mm", "cm") if LENGTHS[unit] * speed < FASTEST * length)
        rule, value = (
            f"must go less than {FASTEST:g} lengths a second, of {length:.3g} m",
            f"{speed / length:.3g} lengths",
        )
        fix = f"give x, y, z in m: are they in {likely}?" if likely else "check places and clock"
        raise InputError(rule, file=run.file, key=f"the poses of {run.source}", value=value, fix=fix)
    if run.joint_time is not None and not (run.joint_time[0] < run.time[-1] and run.joint_time[-1] > run.time[0]):
        spans = [f"{one[0]:.6g} to {one[-1]:.6g} s" for one in (run.joint_time, run.time)]
        rule = "must be measured while the poses are"
        fix = "record both by one clock"
        raise InputError(rule, file=run.file, key="the joints", value=f"at {spans[0]}, poses at {spans[1]}", fix=fix)
    largest = np.zeros(0) if run.angle is None else np.quantile(np.abs(run.angle), MOST, axis=0)
    for j in np.flatnonzero(largest > HALF_TURN)[:1]:
        rule, fix = "must bend by less than half a turn", "record angles in rad: are they in deg?"
        raise InputError(rule, file=run.file, key=run.joint_names[j], value=f"{largest[j]:.3g} rad", fix=fix)
    notes = run.notes
    if repeats := repeats_of(run.pose[:, np.newaxis, :2]):
        notes += (f"{repeats} poses repeat the one before: are lost ones filled in? Leave them out",)
    for moves, how in ((tail_first, "tail first"), (sideways, "to its side")):
        if moves(run.pose, [np.arange(len(run.time))], length):
            notes += (f"the robot moves {how} all the time: does --forward name the axis to the nose?",)
    return replace(run, notes=notes)


def write_pose_run(run: PoseRun, robot: Robot, output: str | Path, comment: str) -> list[str]:
    """Write the poses and joint angles of a run and a manifest of them; return the names of the files."""
    folder, groups = Path(output).parent, [f"joint_{name}_deg" for name in coordinate_names(robot)]
    pose_rows = np.column_stack([run.time, run.pose[:, :2], np.degrees(run.pose[:, 2])])
    files = [_write(folder / f"{run.name}-poses.csv", comment, ["time_s", "x_m", "y_m", "yaw_deg"], pose_rows)]
    entry: dict[str, Any] = {"name": run.name}
    if run.joint_time is not None and run.angle is not None:
        groups = groups[: run.angle.shape[1]]
        rows = np.column_stack([run.joint_time, np.degrees(run.angle)])
        files.append(_write(folder / f"{run.name}-joints.csv", comment, ["time_s", *groups], rows))
        entry["joints"] = {"file": files[1].name, "columns": groups, "unit": "deg"}
    columns = {"x": "x_m", "y": "y_m", "yaw": "yaw_deg", "length_unit": "m", "angle_unit": "deg"}
    entry |= {"poses": {"files": [files[0].name]} | columns, "align": "all"}
    document = {"format": 1, "robot": robot.name, "recordings": [entry]}
    write_atomically(output, manifest_text(document, comment).encode())
    return [*map(str, files), str(output)]


def _write(path: Path, comment: str, heads: Sequence[str], rows: Array) -> Path:
    """Write a CSV file with a comment, a line of names and rows of numbers; return its path."""
    lines = [f"# {comment}", ",".join(heads), *(",".join(f"{x:.9g}" for x in row) for row in rows.tolist())]
    write_atomically(path, ("\n".join(lines) + "\n").encode())
    return path
