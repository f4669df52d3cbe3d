"""The command `hypertuna trials import poses`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit
from hypertuna.description.provenance import provenance
from hypertuna.display import Table
from hypertuna.io.files import version
from hypertuna.ranges import POSITIVE
from hypertuna.trials.pose_import import DIRECTIONS, PoseRun, View, read_pose_run, write_pose_run

MISSING_JOINTS = "joint angles: the file has none. Name a CSV file of them in the manifest, under [recordings.joints]"


@opt.grouped
def import_poses_command(
    file: Annotated[str, typer.Argument(help="Bag of ROS 2 (.mcap, .db3, or its folder), or table with quaternions.")],
    robot: opt.RobotOptions,
    output: opt.Manifest,
    topic: Annotated[str | None, opt.text("--topic", "Topic of the poses; of transforms, TOPIC:FRAME.")] = None,
    joints: Annotated[
        str, opt.text("--joints", "Names of the joints from head to tail, separated by commas.", "NAME,...")
    ] = "",
    up: Annotated[str, opt.word("--up", DIRECTIONS, "Axis of the world that points up.")] = "z",
    forward: Annotated[str, opt.word("--forward", DIRECTIONS, "Axis of the body that points to the nose.")] = "x",
    ahead: Annotated[float, opt.number("--ahead", "m", "Center of the head link, ahead of the tracked point.")] = 0.0,
    frame_rate: Annotated[
        float | None, opt.number("--frame-rate", "Hz", "Rows per second of a table without times.", limits=POSITIVE)
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Take poses of another program: head poses, joint angles where the file has them, and a manifest of both.

    Reads PoseStamped, PoseWithCovarianceStamped, TransformStamped, Odometry, tf and JointState of ROS 2, and tables of
    time_s, x, y, z, qx, qy, qz, qw, as other simulators write them.
    """
    fish = robot.load()
    names = [name for part in joints.split(",") if (name := part.strip())]
    run = read_pose_run(fish, file, view=View(up, forward, ahead), topic=topic, joints=names, frame_rate=frame_rate)
    written = write_pose_run(run, fish, output, f"Made by `hypertuna trials import` {version()}")
    missing = [] if run.joint_time is not None else [MISSING_JOINTS]
    record = {
        "name": run.name,
        "source": run.source,
        "poses": len(run.time),
        "seconds": float(run.time[-1]),
        "joint_samples": 0 if run.joint_time is None else len(run.joint_time),
        "joints": list(run.joint_names),
        "notes": list(run.notes),
        "missing": missing,
    }
    emit(
        run,
        record=lambda _: provenance(fish) | {"runs": [record], "written": written},
        lines=lambda run: _lines(run, record),
        written=(written[-1],),
        as_json=as_json,
    )


def _lines(run: PoseRun, record: dict[str, Any]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for an imported run."""
    row = [run.name, run.source, f"{record['poses']}", f"{record['seconds']:.4g}", f"{record['joint_samples']}"]
    yield Table(["run", "source", "poses", "duration [s]", "joint samples"], [row])
    for sentence in record["notes"]:
        yield f"{run.name}: {sentence}{'.' * (not sentence.endswith('?'))}"
    for sentence in record["missing"]:
        yield f"missing: {sentence}.", "yellow"
