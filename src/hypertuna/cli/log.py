"""The commands `hypertuna log ...`: logs of missions and black boxes told, drawn and turned into tables and tracks."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import check_suffix, command_line, print_json, progress_bar, tell_written, whole_number
from hypertuna.cli.old_options import Name
from hypertuna.description.robot import load
from hypertuna.errors import InputError
from hypertuna.firmware.black_box import boxes_of, record_of
from hypertuna.io.files import columns_csv, write_atomically
from hypertuna.io.mcap import need_log
from hypertuna.mission.file import read_mission
from hypertuna.mission.gpx import write_gpx
from hypertuna.mission.log import write_log
from hypertuna.mission.log_fields import DEGREES, DERIVED, fields
from hypertuna.mission.read_log import Log, read_log
from hypertuna.mission.record import MissionRecord, record_facts

__all__ = ["log_app"]

log_app = typer.Typer(
    no_args_is_help=True, help="Logs of missions and black boxes: tell, draw, tables, tracks; needs the extra log."
)

File = Annotated[str, typer.Argument(metavar="FILE.mcap", help="A log that hypertuna wrote.")]
Output = Annotated[str, typer.Option("-o", "--output", help="File to write.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


@log_app.command("info")
def info_command(file: File, as_json: AsJson = False) -> None:
    """Tell what a log has: mission, times, topics, way, energy, and whether it is whole.

    The exit code is 0 for a whole log, 1 for one that is cut short or damaged (what it has is still told), 2 for bad
    input.
    """
    log = read_log(file)
    print_json(_record(log)) if as_json else _print(log)
    if not log.complete:
        raise typer.Exit(1)


@log_app.command("plot")
def plot_command(file: File, output: Output, as_json: AsJson = False) -> None:
    """Draw the track on a plan, depth and energy to a .svg, .png or .pdf file."""
    check_suffix(output, (".svg", ".png", ".pdf"), "--output")
    log = read_log(file)
    from hypertuna.figures import save
    from hypertuna.mission.plots import plot_mission

    save(plot_mission(log.record), output)
    _finish(log, output, as_json)


@log_app.command("to-csv")
def csv_command(file: File, output: Output, as_json: AsJson = False) -> None:
    """Write every number of a log to a .csv file, one row per time."""
    check_suffix(output, (".csv",), "--output")
    log = read_log(file)
    write_atomically(output, _csv(log.record, complete=log.complete).encode())
    _finish(log, output, as_json)


@log_app.command("to-gpx")
def gpx_command(file: File, output: Output, as_json: AsJson = False) -> None:
    """Write the track of a log to a .gpx file, for maps."""
    check_suffix(output, (".gpx",), "--output")
    log = read_log(file)
    try:
        write_gpx(log.record, output)
    except InputError as error:
        if error.key != "origin":
            raise
        raise InputError(error.rule, file=file, key=error.key, fix=error.fix) from None
    _finish(log, output, as_json)


@log_app.command("black-box")
def black_box_command(
    file: Annotated[str, typer.Argument(metavar="FILE.bin", help="Black box, from the robot's card.")],
    output: Output,
    robot: Name = "hypertuna",
    mission: Annotated[
        str | None, typer.Option("--mission", help="Mission that it swam, or its file: its way and origin.")
    ] = None,
    boot: Annotated[
        str | None, typer.Option("--boot", help="Which boot of several, from 1. (default: the last)")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write what the firmware took down of every tick to a .mcap log, for the other commands and Foxglove.

    What is damaged is skipped and counted; a file that was cut short is read up to its last whole record. A box tells
    what the robot read, believed and did, not where it was.
    """
    need_log()
    check_suffix(output, (".mcap",), "--output")
    fish = load(robot)
    way = None if mission is None else read_mission(mission)
    with progress_bar("bytes") as progress:
        boots = boxes_of(file, progress)
    which = len(boots) if boot is None else whole_number(boot, "--boot")
    if not 1 <= which <= len(boots):
        raise InputError(f"must be from 1 to {len(boots)}", key="--boot", value=str(which), fix="leave it out")
    box = boots[which - 1]
    facts = {"black_box": file, "boot": f"{which} of {len(boots)}", "command": command_line()}
    record = record_of(box, fish, way, facts)
    with progress_bar("ticks") as progress:
        write_log(record, output, progress)
    told = {"ticks": len(box.ticks), "missing": box.missing, "damaged": box.damaged, "skipped_bytes": box.skipped}
    told |= {"cut_bytes": box.cut, "boots": len(boots)}
    if as_json:
        print_json({"written": output, **told, **record.facts})
        return
    console = Console()
    console.print(Text(box.sentence, style="yellow" if box.gaps else "green"))
    console.print(Text(f"parameters: {record.facts['parameters']}", style="dim"))
    if len(boots) > 1:
        console.print(Text(f"boot: {facts['boot']}", style="dim"))
    tell_written(output)


def _record(log: Log) -> dict[str, Any]:
    """Tell a log, for programs."""
    whole = {"complete": log.complete, "status_text": log.sentence}
    file = {"chunks": log.chunks, "size_bytes": log.size, "messages": log.messages}
    return record_facts(log.record) | whole | file


def _print(log: Log) -> None:
    """Print a log as a small table."""
    told, console = record_facts(log.record), Console()
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(style="dim")
    table.add_column(justify="right", style="bold")
    table.add_column()
    table.add_row("time", f"{told['end_s'] - told['begin_s']:.4g}", "s")
    table.add_row("times", f"{told['times']}", "")
    table.add_row("way over ground", f"{told['distance_m']:.4g}", "m")
    table.add_row("mean speed over ground", f"{told['mean_speed_m_s']:.3g}", "m/s")
    table.add_row("greatest depth", f"{told['depth_max_m']:.3g}", "m")
    if "energy_wh" in told:
        table.add_row("energy", f"{told['energy_wh']:.3g}", "Wh")
    if "charge_left" in told:
        table.add_row("charge left", f"{100 * told['charge_left']:.0f}", "%")
    if "position_off_max_m" in told:
        table.add_row("farthest from where it believed to be", f"{told['position_off_max_m']:.3g}", "m")
    if "mode_at_end" in told:
        table.add_row("at the end", f"{told['mode_at_end']}", "")
    console.print(Text(f"{log.record.name}, {log.record.robot}", style="bold"))
    console.print(table)
    topics = ", ".join(f"{topic} {count}" for topic, count in log.messages.items())
    console.print(Text(f"messages: {topics}", style="dim"))
    for key, value in log.record.facts.items():
        console.print(Text(f"{key}: {value}", style="dim"))
    console.print(Text(log.sentence, style="green" if log.complete else "yellow"))


def _finish(log: Log, output: str, as_json: bool) -> None:
    """Name the file that was written; say what was missing of the log."""
    if as_json:
        print_json({"written": output, "complete": log.complete, "status_text": log.sentence})
        return
    if not log.complete:
        Console(stderr=True).print(Text(log.sentence))
    tell_written(output)


def _csv(record: MissionRecord, *, complete: bool) -> str:
    """Write a record as comma-separated values, below comments that say what made it."""
    columns = {"time_s": record.time}
    columns |= {f"{axis}_m": record.position[:, k] for k, axis in enumerate(("x", "y", "z"))}
    columns["depth_m"] = record.depth
    columns |= dict(zip(list(DERIVED)[2:], (record.angles * DEGREES).T, strict=True))
    for rows in fields(record.data, record.joints, record.circuits).values():
        for row in rows:
            values = record.data[row.name] if row.part is None else record.data[row.name][:, row.part]
            columns[row.key] = values * row.factor
    facts = {"mission": record.name, "robot": record.robot, **record.facts, "complete": str(complete).lower()}
    return columns_csv(facts, columns, digits=9)
