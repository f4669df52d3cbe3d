"""The commands `hypertuna log ...`: logs of missions and black boxes: summary, plot, table, track."""

import json
from collections.abc import Callable, Iterator
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar
from hypertuna.cli.emit import emit, save
from hypertuna.display import card_of
from hypertuna.firmware.black_box import mission_record, read_black_box
from hypertuna.io.files import Csv, columns_csv, write_atomically
from hypertuna.io.mcap import is_radio_log, need_log
from hypertuna.io.quantity import values_of
from hypertuna.mission.file import read_mission
from hypertuna.mission.foxglove import layout
from hypertuna.mission.gpx import check_origin, write_gpx
from hypertuna.mission.log import write_log
from hypertuna.mission.log_fields import record_columns
from hypertuna.mission.read_log import Log, read_log
from hypertuna.radio.log import RadioLog, read_radio_log
from hypertuna.ranges import Whole

log_app = opt.group("Logs of missions and black boxes: summary, plot, table, track; needs the extra log.")

LogFile = Annotated[str, typer.Argument(metavar="FILE.mcap", help="A log that hypertuna wrote.")]


@log_app.command("info")
def info_command(log: LogFile, as_json: opt.AsJson = False) -> None:
    """Summarize a log: mission, times, topics, distance, energy, completeness; for a log of the radio, its messages.

    The exit code is 0 for a complete log, 1 for one that is cut short or damaged (the rest is still summarized), 2 for
    bad input.
    """
    if is_radio_log(log):
        radio_log = read_radio_log(log)
        return emit(radio_log, record=_radio, lines=_radio_lines, as_json=as_json, failed=not radio_log.complete)
    content = read_log(log)
    emit(content, record=_record, lines=_lines, as_json=as_json, failed=not content.complete)


@log_app.command("plot")
def plot_command(
    log: LogFile, output: Annotated[str, opt.file("--output", "the plot", *opt.FIGURES)], as_json: opt.AsJson = False
) -> None:
    """Plot the track on a plan, depth and energy."""
    _convert(log, output, as_json, lambda content: save(content.record.plot(), output))


@log_app.command("to-csv")
def csv_command(
    log: LogFile, output: Annotated[str, opt.file("--output", "the table", ".csv")], as_json: opt.AsJson = False
) -> None:
    """Write every number of a log to a table, one row per time."""
    _convert(log, output, as_json, lambda content: _csv(content).write(output))


@log_app.command("to-gpx")
def gpx_command(
    log: LogFile, output: Annotated[str, opt.file("--output", "the track", ".gpx")], as_json: opt.AsJson = False
) -> None:
    """Write the track of a log for maps."""

    def write(content: Log) -> None:
        check_origin(content.record.origin, log)
        write_gpx(content.record, output)

    _convert(log, output, as_json, write)


@log_app.command("to-layout")
def layout_command(
    log: LogFile, output: Annotated[str, opt.file("--output", "the layout", ".json")], as_json: opt.AsJson = False
) -> None:
    """Write a layout for Foxglove that shows a log: map, robot, depth, heading, pressures, power, modes and faults."""

    def write(content: Log) -> None:
        write_atomically(output, f"{json.dumps(layout(content.record), indent=2)}\n".encode())

    _convert(log, output, as_json, write)


@log_app.command("black-box")
@opt.grouped
def black_box_command(
    box: Annotated[str, typer.Argument(metavar="FILE.bin", help="Black box, from the robot's card.")],
    output: Annotated[str, opt.file("--output", "the log", ".mcap")],
    robot: opt.RobotOptions,
    mission: Annotated[
        str | None, opt.text("--mission", "Mission that the robot swam, by name or file, for its waypoints and origin.")
    ] = None,
    boot: Annotated[
        int | None, opt.whole_number("--boot", "Number of the boot, counted from 1. (default: the last)")
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Convert what the firmware recorded in every tick to a .mcap log, for the other commands and Foxglove.

    Damaged records are skipped and counted; a file that was cut short is read up to its last whole record. A black box
    records readings, estimates and commands, but not the true position.
    """
    need_log()
    fish = robot.load()
    route = None if mission is None else read_mission(mission)
    with progress_bar("bytes") as progress:
        boots = read_black_box(box, progress)
    number = Whole(min=1, max=len(boots)).check(len(boots) if boot is None else boot, "--boot", "leave it out")
    content = boots[number - 1]
    facts = {"black_box": box, "boot": f"{number} of {len(boots)}", "command": command_line()}
    record = mission_record(content, fish, route, facts)
    with progress_bar("ticks") as progress:
        write_log(record, output, progress)
    counts = {"ticks": len(content.ticks), "missing": content.missing, "damaged": content.damaged}
    counts |= {"skipped_bytes": content.skipped, "cut_bytes": content.cut, "boots": len(boots)}
    shown = ["parameters", "boot"][: 1 + (len(boots) > 1)]
    emit(
        content,
        record=lambda _: {"written": output, **counts, **record.facts},
        lines=lambda box: [
            (box.sentence, "yellow" if box.gaps else "green"),
            *((f"{key}: {record.facts[key]}", "dim") for key in shown),
        ],
        written=(output,),
        as_json=as_json,
    )


def _convert(log: str, output: str, as_json: bool, write: Callable[[Log], Any]) -> None:
    """Read a log, write it in another format by `write`, and report whether the log is complete."""
    content = read_log(log)
    write(content)
    if not content.complete and not as_json:
        typer.echo(content.sentence, err=True)
    emit(
        content,
        record=lambda log: {"written": output, "complete": log.complete, "status_text": log.sentence},
        lines=lambda _: (),
        written=(output,),
        as_json=as_json,
    )


def _record(log: Log) -> dict[str, Any]:
    """Return the JSON record of a mission's log."""
    state = {"complete": log.complete, "status_text": log.sentence}
    state |= {"chunks": log.chunks, "size_bytes": log.size, "messages": log.messages}
    return values_of(log.record.summary()) | {"facts": dict(log.record.facts)} | state


def _radio(log: RadioLog) -> dict[str, Any]:
    """Return the JSON record of a radio log: its duration [s], and the number of each message."""
    counts = {name: len(times) for name, times in sorted(log.time.items())}
    seconds = max((float(times[-1]) for times in log.time.values()), default=0.0)
    return {"messages": counts, "seconds": seconds, "complete": log.complete}


def _radio_lines(log: RadioLog) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a radio log."""
    record = _radio(log)
    yield f"log of the radio, {record['seconds']:.4g} s", "bold"
    yield f"messages: {', '.join(f'{count} {name}' for name, count in record['messages'].items())}"
    yield "`hypertuna identify` and `joint fit` read it.", "dim"
    yield ("The log is whole.", "green") if log.complete else ("The log is cut short or damaged.", "yellow")


def _lines(log: Log) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a mission's log."""
    yield from card_of(log.record).lines()
    yield f"messages: {', '.join(f'{topic} {count}' for topic, count in log.messages.items())}", "dim"
    for key, value in log.record.facts.items():
        if value:
            yield f"{key}: {value}", "dim"
    yield log.sentence, "green" if log.complete else "yellow"


def _csv(log: Log) -> Csv:
    """Return the CSV table of a log's record."""
    record = log.record
    facts = {"mission": record.name, "robot": record.robot, **record.facts, "complete": str(log.complete).lower()}
    return columns_csv(facts, record_columns(record), digits=9)
