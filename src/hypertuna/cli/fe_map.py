"""The command `hypertuna fe map`."""

from collections.abc import Sequence
from typing import Annotated, Any

from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar
from hypertuna.cli.elements import BEND_PRESSURES, CoarseElements, rising
from hypertuna.cli.emit import emit
from hypertuna.cli.shards import connected, write_shards
from hypertuna.fe.extra import need_fe
from hypertuna.fe.joint_map import joint_map, joint_map_shards, map_layout
from hypertuna.ranges import Whole

POINTS = Whole(max=10_000)  # number of points of a map


@opt.grouped
def map_command(
    robot: opt.RobotOptions,
    joint: opt.Joint,
    elements: CoarseElements,
    pressure: opt.Pressures = BEND_PRESSURES,
    moment: Annotated[
        Sequence[float] | None,
        opt.values(
            "--moment",
            "N m",
            "Couples on the tip in N m. (default: five, up to half of the moment that the pressure makes)",
        ),
    ] = None,
    fill: Annotated[
        float | None,
        opt.number(
            "--fill",
            "kPa",
            "Fill pressure in kPa: the right side has twice this pressure minus the left one, but not less than 0; 0 "
            "leaves the right side without pressure. (default: that of the robot's line)",
        ),
    ] = None,
    checkpoint: opt.Checkpoint = None,
    places: opt.Places = opt.NO_PLACES,
    output: opt.ShardsOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Map bend, oil and length of a joint over pressures and moments, by finite elements and by the fast model.

    Pressures are those of the left side; angles are positive to the left. Every couple takes about as long as
    `fe bend`, so the mesh is coarse unless asked otherwise: half an hour per joint. The exit code is 1 if some points
    were not reached (NaN in files; for shards it is 0), 2 for bad input.
    """
    fish = robot.load()
    start = None if fill is None else 1e3 * fill
    subject = fish, joint_index(joint, fish)
    grid: Any = {"pressure": rising(pressure), "couple": moment, "fill": start, "options": elements}
    shard_options: Any = {"places": places, "refused": {"--checkpoint": checkpoint}, "as_json": as_json}
    points = len(pressure) * len(moment or ())
    POINTS.check(points, "the number of points", "take fewer pressures or moments: a point takes seconds to minutes")
    need_fe()
    if write_shards(output, joint_map_shards, *subject, **shard_options, **grid):
        return
    with progress_bar("points", slow=True) as progress, connected(places.cluster) as executor:
        found = joint_map(*subject, **grid, executor=executor, checkpoint=checkpoint, progress=progress)
    emit(
        found,
        record=lambda found: found.record() | {"command": command_line()},
        columns=map_layout(found).heads,
        digits=None,
        output=output,
        as_json=as_json,
        failed=found.status != "converged",
    )
