"""The commands `hypertuna mission new | import`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import print_lines
from hypertuna.cli.emit import emit
from hypertuna.description.robot import Robot
from hypertuna.io.files import write_atomically
from hypertuna.io.quantity import counted
from hypertuna.mission.file import MissionFile, read_mission
from hypertuna.ranges import NOT_NEGATIVE, POSITIVE


@opt.grouped
def new_command(
    file: Annotated[str, typer.Argument(metavar="FILE.toml", help="Mission file to write.", show_default=False)],
    robot: opt.RobotOptions,
    force: opt.Force = False,
) -> None:
    """Write a mission that a robot can swim: a square scaled to its speed, its turns and its depths."""
    from hypertuna.mission.new import new_mission

    path, fish = parsing.new_file(parsing.output_file(file, (".toml",), "FILE"), force), robot.load()
    write_atomically(path, new_mission(fish, Path(path).stem).encode())
    mission = read_mission(path).mission
    side = max(point.y for point in mission.waypoints)
    print_lines(
        [
            f"written: {path}, a square of {side:g} m for {fish.name}",
            "next:",
            f"  hypertuna mission {path}",
        ]
    )


@opt.grouped
def import_command(
    plan: Annotated[
        str,
        typer.Argument(
            metavar="PLAN", help=".plan of QGroundControl, .waypoints, .gpx or .kml file.", show_default=False
        ),
    ],
    output: Annotated[str, opt.file("--output", "the mission", ".toml")],
    robot: Annotated[
        str | None, opt.text("--robot", "Robot that swims the mission: its speed where the plan has none.", "ROBOT")
    ] = None,
    speed: Annotated[
        float | None, opt.number("--speed", "m/s", "Speed through the water, of all legs.", limits=POSITIVE)
    ] = None,
    depth: Annotated[
        float | None,
        opt.number("--depth", "m", "Depth of all waypoints, in place of their altitudes.", limits=NOT_NEGATIVE),
    ] = None,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
) -> None:
    """Write the mission of a .plan, .waypoints, GPX or KML file, and name what changes.

    Waypoints, times to stay, acceptance radii, speeds, home and a fence of one polygon are kept. A depth is a negative
    altitude. What would change the course is refused: other commands, other frames, altitudes above the water.
    """
    from hypertuna.description.robot import load
    from hypertuna.mission.import_plan import check_plan, plan_document, plan_text, read_plan

    parsing.new_file(output, force)
    fish: Robot | None = None if robot is None else load(robot)
    read = read_plan(plan, depth=depth)
    document = plan_document(read, Path(output).stem, fish, speed)
    file = check_plan(document, read, plan, fish)
    write_atomically(output, plan_text(document, read, plan).encode())
    emit(
        file,
        record=lambda file: {
            "written": output,
            "waypoints": len(file.mission.waypoints),
            "depth_max_m": max(point.depth for point in file.mission.waypoints),
            "goes_home": read.goes_home,
            "notes": read.notes,
        },
        lines=lambda file: _import_lines(file, read.goes_home, read.notes),
        written=(output,),
        as_json=as_json,
    )


def _import_lines(file: MissionFile, goes_home: bool, notes: list[str]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for an imported plan, with notes on parts that were changed."""
    points = file.mission.waypoints
    depths = sorted({f"{point.depth:g}" for point in points}, key=float)
    span = depths[0] if len(depths) == 1 else f"{depths[0]} to {depths[-1]}"
    yield f"{counted(len(points), 'waypoint')}, depth {span} m"
    if not goes_home:
        yield "After the last waypoint the robot goes home; with `stay = true` it surfaces there.", "dim"
    for note in notes:
        yield f"note: {note}", "yellow"
