"""The commands `hypertuna robot schema | check | show`. InputError is left to the main program, which exits with 2."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import print_json, tell_written
from hypertuna.description.robot import Entry, Robot, json_schema, load
from hypertuna.errors import InputError

__all__ = ["robot_app"]

robot_app = typer.Typer(no_args_is_help=True, help="Describe robots: print the format, check a file, show a robot.")

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


@robot_app.command()
def schema() -> None:
    """Print the JSON Schema of robots/NAME.toml."""
    print_json(json_schema())


@robot_app.command()
def check(
    file: Annotated[str, typer.Argument(help="Path of a TOML file, or the name of a robot that comes with hypertuna.")],
    as_json: AsJson = False,
) -> None:
    """Check a robot description, and list what is estimated and what has no source."""
    try:
        robot = load(file)
    except InputError as error:
        if as_json:
            told = {key: getattr(error, key) for key in ("file", "key", "rule", "value", "fix")}
            print_json({"valid": False, "error": str(error)} | told)
        raise
    if as_json:
        print_json({"valid": True} | _summary(robot))
        return
    entries = robot.entries()
    console = Console()
    console.print(
        f"{robot.file}: valid; {_count(len(robot.links.name), 'link')}, {_count(len(robot.joints), 'joint group')}, "
        f"{_count(len(robot.gaits), 'gait')}",
        highlight=False,
        markup=False,
    )
    for title, keys in (
        ("estimated", [e.key for e in entries if e.estimate]),
        ("without a source", list(robot.unsourced())),
    ):
        console.print(f"{title}: {', '.join(keys) or 'nothing'}", highlight=False, markup=False)


@robot_app.command()
def show(
    name: Annotated[str, typer.Argument(help="Name of a robot that comes with hypertuna, or path of a TOML file.")],
    as_json: AsJson = False,
    plot: Annotated[str | None, typer.Option("--plot", help="Draw the robot to this .svg, .png or .pdf file.")] = None,
) -> None:
    """Show every value of a robot with its unit and source, estimates marked."""
    robot = load(name)
    if plot is not None:
        from hypertuna.figures import save
        from hypertuna.swimming.drawing import draw

        save(draw(robot), plot)
    if as_json:
        values = [entry._asdict() | {"estimate": entry.estimate} for entry in robot.entries()]
        print_json(_summary(robot) | {"values": values})
        return
    console = Console()
    console.print(Text(robot.description, style="bold"))
    console.print(f"{robot.file}, sha256 {robot.hash[:12]}; ~ marks an estimate", highlight=False, markup=False)
    sources: dict[str, int] = {}
    console.print(_value_table(robot.entries(), sources))
    console.print(_source_table(sources))
    tell_written(plot)


def _value_table(entries: tuple[Entry, ...], sources: dict[str, int]) -> Table:
    """Lay out keys, values and units; sources are numbered in the order in which they appear."""
    table = Table("key", "value", "unit", "source", box=None, pad_edge=False, header_style="bold")
    section = ""
    for entry in entries:
        if (start := entry.key.split(".", 1)[0].split("[", 1)[0]) != section:
            section = start
            table.add_row()  # a blank line between tables of the file
        number = sources.setdefault(entry.source, len(sources) + 1) if entry.source else ""
        mark = "~" if entry.estimate else ""
        cells = (entry.key, mark + _written_value(entry.value), entry.unit, f"{number}")
        table.add_row(*map(Text, cells), style="yellow" if entry.estimate else None)
    return table


def _source_table(sources: dict[str, int]) -> Table:
    """List the numbered sources."""
    table = Table("", "sources", box=None, pad_edge=False, header_style="bold")
    for source, number in sources.items():
        table.add_row(f"{number}", Text(source))
    return table


def _written_value(value: Any) -> str:
    """Write a value to six digits, a list with commas and lists in it in brackets."""
    if isinstance(value, list):
        return ", ".join(f"[{_written_value(x)}]" if isinstance(x, list) else _written_value(x) for x in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)


def _summary(robot: Robot) -> dict[str, Any]:
    """Say what a robot is, for programs."""
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


def _count(number: int, noun: str) -> str:
    """Write a number with its noun."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
