"""The command `hypertuna fe map`."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np

from hypertuna.characterization.data import joint_index
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar, table
from hypertuna.cli.elements import BEND_PRESSURES, CoarseElements, rising
from hypertuna.cli.emit import emit
from hypertuna.cli.shards import connected, write_shards
from hypertuna.fe.extra import need_fe
from hypertuna.fe.joint_map import JointMap, joint_map, joint_map_shards, map_layout
from hypertuna.ranges import Whole

POINTS = Whole(max=10_000)


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
    how: Any = {"places": places, "refused": {"--checkpoint": checkpoint}, "as_json": as_json}
    points = len(pressure) * len(moment or ())
    POINTS.check(points, "the number of points", "take fewer pressures or moments: a point takes seconds to minutes")
    need_fe()
    if write_shards(output, joint_map_shards, *subject, **how, **grid):
        return
    with progress_bar("points", slow=True) as progress, connected(places.cluster) as executor:
        found = joint_map(*subject, **grid, executor=executor, checkpoint=checkpoint, progress=progress)
    emit(
        found,
        record=lambda found: found.record() | {"command": command_line()},
        lines=_map_lines,
        columns=map_layout(found).heads,
        digits=None,
        output=output,
        as_json=as_json,
        failed=found.status != "converged",
    )


def _map_lines(found: JointMap) -> Iterator[Any]:
    """Lay out the points, a row for each: elements and fast model side by side."""
    heads = ["left\n[kPa]", "right\n[kPa]", "moment\n[N m]"]
    heads += [f"{name}\n[{unit}]" for name, unit in (("bend FE", "deg"), ("oil left", "ml"), ("right", "ml"))]
    heads += ["length\n[mm]", "model\n[deg]", "left\n[ml]", "right\n[ml]", "length\n[mm]"]
    rows = []
    for c, p in np.ndindex(found.elements.angle.shape):
        row = [f"{pressure / 1e3:.4g}" for pressure in found.pressure[p]]
        if not np.isfinite(found.elements.angle[c, p]):
            rows.append([*row, "", "not found", *[""] * 7])
            continue
        row.append(f"{found.elements.moment[c, p]:+z.3f}")
        for states in (found.elements, found.model):
            oil = (f"{1e6 * volume:.3f}" for volume in states.volume[c, p])
            row += [f"{np.degrees(states.angle[c, p]):z.2f}", *oil, f"{1e3 * states.length[c, p]:.2f}"]
        rows.append(row)
    yield f"{found.robot.name}: joint {found.joint}, mesh {found.options.mesh}", "bold"
    yield table(heads, rows, left=(), collapse_padding=True)
    moment, volume = 100 * found.moment_difference, 100 * found.volume_difference
    text = f"moments of the fast model differ by at most {moment:.1f} % of the {found.straight:.3g} N m of the straight"
    yield f"{text} joint, volumes by {volume:.1f} % of their range"
    yield found.status_text, "green" if found.status == "converged" else "bold yellow"
