"""The commands `hypertuna robot schema | check | show`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import counted, print_json, table
from hypertuna.cli.emit import emit, refused
from hypertuna.description.reference import json_schema
from hypertuna.description.robot import Entry, Robot, load

robot_app = opt.group("Robot descriptions: print the format, check a file, show a robot.")

RobotFile = Annotated[
    str, typer.Argument(help="Name of a robot that comes with hypertuna, or path of a TOML file.", show_default=False)
]


@robot_app.command()
def schema() -> None:
    """Print the JSON Schema of robots/NAME.toml."""
    print_json(json_schema())


@robot_app.command()
def check(robot: RobotFile, as_json: opt.AsJson = False) -> None:
    """Check a robot description, and list what is estimated and what has no source."""
    with refused(as_json):
        fish = load(robot)
    emit(fish, record=lambda fish: {"valid": True} | _summary(fish), lines=_check_lines, as_json=as_json)


@robot_app.command()
def show(robot: RobotFile, as_json: opt.AsJson = False, plot: opt.Plot = None) -> None:
    """Show every value of a robot with its unit and source, estimates marked."""
    emit(
        load(robot),
        record=lambda fish: (
            _summary(fish) | {"values": [entry._asdict() | {"estimate": entry.estimate} for entry in fish.entries()]}
        ),
        lines=_lines,
        plot=plot,
        figure="hypertuna.swimming.drawing:plot_robot",
        as_json=as_json,
    )


def _check_lines(robot: Robot) -> Iterator[str]:
    """Summarize a valid description."""
    parts = (len(robot.links.name), "link"), (len(robot.joints), "joint group"), (len(robot.gaits), "gait")
    yield f"{robot.file}: valid; {', '.join(counted(number, noun) for number, noun in parts)}"
    yield f"estimated: {', '.join(entry.key for entry in robot.entries() if entry.estimate) or 'nothing'}"
    yield f"without a source: {', '.join(robot.unsourced()) or 'nothing'}"


def _lines(robot: Robot) -> Iterator[Any]:
    """Lay out all values, and their sources."""
    sources: dict[str, int] = {}
    yield robot.description, "bold"
    yield f"{robot.file}, sha256 {robot.hash[:12]}; ~ marks an estimate"
    yield table(["key", "value", "unit", "source"], _rows(robot.entries(), sources), left=range(4))
    yield table(["", "sources"], ((f"{number}", source) for source, number in sources.items()), left=(0, 1))


def _rows(entries: tuple[Entry, ...], sources: dict[str, int]) -> Iterator[list[Any]]:
    """Lay out keys, values and units; number the sources in the order in which they appear."""
    from rich.text import Text

    section = ""
    for entry in entries:
        if (start := entry.key.split(".", 1)[0].split("[", 1)[0]) != section:
            section = start
            yield []  # a blank line between tables of the file
        number = sources.setdefault(entry.source, len(sources) + 1) if entry.source else ""
        value = "~" * entry.estimate + _written_value(entry.value)
        yield [Text(cell, "yellow" * entry.estimate) for cell in (entry.key, value, entry.unit, f"{number}")]


def _written_value(value: Any) -> str:
    """Write a value to six digits, a list with commas and lists in it in brackets."""
    if isinstance(value, list):
        return ", ".join(f"[{_written_value(x)}]" if isinstance(x, list) else _written_value(x) for x in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)


def _summary(robot: Robot) -> dict[str, Any]:
    """Return what a robot is."""
    return {
        "name": robot.name,
        "description": robot.description,
        "file": robot.file,
        "hash": robot.hash,
        "links": len(robot.links.name),
        "joint_groups": [group.name for group in robot.joints],
        "gaits": list(robot.gaits),
        "estimates": [entry.key for entry in robot.entries() if entry.estimate],
        "unsourced": list(robot.unsourced()),
    }
