"""The command `hypertuna mission`."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import (
    check_suffix,
    command_line,
    number,
    print_json,
    progress_bar,
    tell_written,
    whole_number,
)
from hypertuna.control.guidance import gait_table
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError, shown
from hypertuna.io.files import rows_csv, write_atomically
from hypertuna.io.mcap import need_log
from hypertuna.mission.file import MissionFile, missions, read_mission
from hypertuna.mission.flight import Flight, Outcome, expected, fly, fly_seeds, outcome
from hypertuna.mission.gpx import check_origin, write_gpx
from hypertuna.mission.record import record_facts

__all__ = ["mission_command"]

HOUR = 3600.0
GOOD = ("done",)
# What is told of a flight: name with its unit, attribute, factor, label and unit on the terminal.
SHOWN: tuple[tuple[str, str, float, str, str], ...] = (
    ("waypoints_reached", "reached", 1, "waypoints reached", ""),
    ("duration_s", "duration", 1.0, "time", "s"),
    ("distance_m", "distance", 1.0, "way over ground", "m"),
    ("energy_wh", "energy", 1 / HOUR, "energy from the battery", "Wh"),
    ("charge_left", "charge_left", 1.0, "part of the charge left", ""),
    ("depth_max_m", "depth_max", 1.0, "greatest depth", "m"),
    ("fence_margin_min_m", "margin_min", 1.0, "least distance to the fence", "m"),
    ("position_off_max_m", "off_max", 1.0, "farthest from where it believed to be", "m"),
    ("goal_distance_m", "home_distance", 1.0, "from home at the end", "m"),
)


def mission_command(
    file: Annotated[
        str, typer.Argument(metavar="FILE.toml", help=f"A mission, or one that comes along: {', '.join(missions())}.")
    ],
    robot: Annotated[str | None, typer.Option("--robot", help="Robot to send. (default: the file's)")] = None,
    seed: Annotated[
        str | None,
        typer.Option("--seed", help="Seed of noise, and of what the file scatters; 0 scatters nothing. (default: 0)"),
    ] = None,
    seeds: Annotated[
        str | None, typer.Option("--seeds", help="Fly many seeds, FROM:TO without the last, such as 0:100.")
    ] = None,
    threads: Annotated[str | None, typer.Option("--threads", help="Threads for --seeds (default: all)")] = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            help="Fault of a sensor or of a fin's servo, such as depth:nan@100 or fin-port:stuck@100; may be given "
            "several times.",
        ),
    ] = None,
    duration: Annotated[
        str | None,
        typer.Option("--duration", help="Give it up after so many s. (default: 10 min after it should be home)"),
    ] = None,
    checkpoint: Annotated[
        str | None, typer.Option("--checkpoint", help="Keep a journal here; the same command resumes from it.")
    ] = None,
    plot: Annotated[str | None, typer.Option("--plot", help="Draw it to this .svg, .png or .pdf file.")] = None,
    gpx: Annotated[str | None, typer.Option("--gpx", help="Write the track to this .gpx file.")] = None,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", help="Write the log to this .mcap file, or with --seeds a table to .csv."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Fly a mission on the twin in three dimensions, under its pilot.

    The exit code is 0 if it is done: all waypoints reached and home again; 1 if it ends otherwise (with --seeds: if one
    of them does), 2 for bad input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    check_suffix(gpx, (".gpx",), "--gpx")
    check_suffix(output, (".csv",) if seeds is not None else (".mcap",), "--output")
    given = read_mission(file)
    fish = _robot(given, robot)
    most = None if duration is None else number(duration, "--duration", "seconds")
    if seeds is not None:
        single = next((key for key, value in {"--plot": plot, "--gpx": gpx, "--seed": seed}.items() if value), None)
        if single is not None:
            raise InputError("is of one flight", key=single, fix="leave it out with --seeds, or leave --seeds out")
        workers = None if threads is None else whole_number(threads, "--threads")
        _many(given, fish, _seeds(seeds), workers, fault or [], most, checkpoint, output, as_json)
        return
    if gpx is not None:
        check_origin(given.origin, given.file)
    if output is not None:
        need_log()
    with progress_bar("flying [s]") as progress:
        flight = fly(
            given,
            fish,
            seed=whole_number(seed or "0", "--seed"),
            faults=fault or [],
            duration=most,
            checkpoint=checkpoint,
            log=None if output is None else Path(output),
            report=progress,
        )
    if gpx is not None:
        write_gpx(flight.record, gpx)
    if plot is not None:
        _plot(flight, plot)
    if as_json:
        print_json(_record(flight))
    else:
        _print(flight)
        tell_written(plot, gpx, output)
    if flight.status not in GOOD:
        raise typer.Exit(1)


def _robot(file: MissionFile, name: str | None) -> Robot:
    """Load the robot of the option, or of the file."""
    if name is None and file.robot is None:
        fix = "add robot to the file, or give --robot"
        raise InputError("is missing", file=file.file, key="robot", fix=fix)
    return load(name if name is not None else file.robot or "")


def _seeds(text: str) -> list[int]:
    """Read FROM:TO."""
    first, colon, last = text.partition(":")
    if not colon:
        raise InputError("must be FROM:TO", key="--seeds", value=shown(text), fix="write, for example, 0:100")
    begin, end = whole_number(first, "--seeds"), whole_number(last, "--seeds")
    if not 0 <= begin < end:
        rule = "must be two numbers, the first less than the second and not negative"
        raise InputError(rule, key="--seeds", value=shown(text), fix="write, for example, 0:100")
    return list(range(begin, end))


def _told(one: Outcome) -> dict[str, Any]:
    """Say what a flight amounts to, for programs."""
    numbers = {name: getattr(one, attribute) * factor for name, attribute, factor, *_ in SHOWN}
    return {"seed": one.seed, "status": one.status} | numbers | {"reasons_s": one.reasons}


def _record(flight: Flight) -> dict[str, Any]:
    """Say how a mission was flown, for programs."""
    return (
        _told(outcome(flight))
        | record_facts(flight.record)
        | {"expected_s": expected(flight.record.mission, _fastest(flight)), "status_text": _sentence(flight)}
        | {"command": command_line()}
    )


def _fastest(flight: Flight) -> float:
    """Return the speed of the robot's fastest gait [m/s]."""
    return gait_table(flight.robot).speed[-1]


def _sentence(flight: Flight) -> str:
    """Say how a flight ended, and whether more was asked of the robot than its gaits can."""
    one, mission, fastest = outcome(flight), flight.record.mission, _fastest(flight)
    asked = max([point.speed for point in mission.waypoints] + [mission.home_speed] * (not mission.stay))
    beyond = f" It asked for {asked:.3g} m/s; the fastest gait swims {fastest:.3g}." if fastest < asked else ""
    ends = {
        "done": "The mission is done",
        "home": f"The robot came home early (waypoints reached: {one.reached})",
        "hold": "The robot holds: it cannot go home",
        "given up": "The mission was given up",
        "diverged": "The run diverged: the twin's state is no longer a robot's",
    }
    why = f"; it told {', '.join(one.reasons).replace('_', ' ')}" if one.reasons else ""
    return f"{ends.get(one.status, one.status)} after {one.duration:.4g} s{why}.{beyond}"


def _print(flight: Flight) -> None:
    """Print a flight as a small table and a sentence."""
    one, console = outcome(flight), Console()
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(style="dim")
    table.add_column(justify="right", style="bold")
    table.add_column()
    for _, attribute, factor, label, unit in SHOWN:
        value = getattr(one, attribute) * factor
        if math.isfinite(value):
            table.add_row(label, f"{value:.4g}", unit)
        if attribute == "distance" and one.duration:
            table.add_row("mean speed over ground", f"{value / one.duration:.3g}", "m/s")
    console.print(Text(f"{flight.file.name}, {flight.robot.name}, seed {flight.seed}", style="bold"))
    console.print(table)
    for reason, time in one.reasons.items():
        console.print(Text(f"{time:8.1f} s  {reason.replace('_', ' ')}", style="dim"))
    console.print(Text(_sentence(flight), style="green" if flight.status in GOOD else "yellow"))


def _many(
    file: MissionFile,
    robot: Robot,
    seeds: Sequence[int],
    threads: int | None,
    faults: Sequence[str],
    duration: float | None,
    checkpoint: str | None,
    output: str | None,
    as_json: bool,
) -> None:
    """Fly many seeds and tell them together."""
    with progress_bar("flying") as progress:
        done = fly_seeds(
            file,
            robot,
            seeds,
            threads=threads,
            faults=faults,
            duration=duration,
            checkpoint=checkpoint,
            report=progress,
        )
    if output is not None:
        write_atomically(output, _csv(file, robot, done).encode())
    if as_json:
        facts = provenance(robot) | {"mission": file.name, "mission_hash": file.hash, "command": command_line()}
        print_json(facts | {"summary": _summary(done), "flights": [_told(one) for one in done]})
    else:
        _print_many(file, robot, done)
        tell_written(output)
    if any(one.status not in GOOD for one in done):
        raise typer.Exit(1)


def _summary(done: Sequence[Outcome]) -> dict[str, Any]:
    """Add many flights up: how they ended, and least, mean and largest of each number."""
    spans = {}
    for name, attribute, factor, *_ in SHOWN:
        values = np.array([getattr(one, attribute) * factor for one in done])
        spans[name] = {"least": values.min(), "mean": values.mean(), "largest": values.max()}
    reasons = Counter(reason for one in done for reason in one.reasons)
    return {"status": dict(Counter(one.status for one in done)), "reasons": dict(reasons), **spans}


def _print_many(file: MissionFile, robot: Robot, done: Sequence[Outcome]) -> None:
    """Print many flights as a table of least, mean and largest."""
    summary, console = _summary(done), Console()
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("")
    for head in ("least", "mean", "largest"):
        table.add_column(head, justify="right")
    table.add_column("")
    for name, _, _, label, unit in SHOWN:
        cells = [f"{summary[name][key]:.4g}" for key in ("least", "mean", "largest")]
        table.add_row(label, *cells, unit)
    console.print(Text(f"{file.name}, {robot.name}: {len(done)} flights", style="bold"))
    console.print(table)
    ends = ", ".join(f"{count} {status}" for status, count in summary["status"].items())
    others = [str(one.seed) for one in done if one.status not in GOOD]
    console.print(Text(ends + (f"; not done: seeds {', '.join(others)}" if others else "")))
    told = ", ".join(f"{reason.replace('_', ' ')} {count}" for reason, count in summary["reasons"].items())
    console.print(Text(f"what the pilot told, in flights: {told or 'nothing'}", style="dim"))


def _csv(file: MissionFile, robot: Robot, done: Sequence[Outcome]) -> str:
    """Write many flights as comma-separated values, below comments that say what made them."""
    facts = provenance(robot) | {"mission": file.name, "mission_hash": file.hash, "command": command_line()}
    rows = []
    for one in done:
        when = " ".join(f"{name}@{time:g}" for name, time in one.reasons.items())
        rows.append(_told(one) | {"reasons_s": when})
    return rows_csv(facts, rows)


def _plot(flight: Flight, plot: str) -> None:
    """Draw a flight; what draws is imported only now, because that takes long."""
    from hypertuna.figures import save
    from hypertuna.mission.plots import plot_mission

    save(plot_mission(flight.record), plot)
