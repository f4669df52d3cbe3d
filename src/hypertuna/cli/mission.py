"""The command `hypertuna mission`."""

import math
import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna import _core
from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.parsing import whole_number as read_whole_number
from hypertuna.cli.shards import connected, write_shards
from hypertuna.cli.streams import note
from hypertuna.control.guidance import gait_table
from hypertuna.description.robot import Robot
from hypertuna.display import Table
from hypertuna.errors import InputError, shown
from hypertuna.io.quantity import counted, values_of
from hypertuna.mission.cards import ending_text
from hypertuna.mission.checks import check_current, check_fit, warnings_of
from hypertuna.mission.file import MissionFile, missions, read_mission
from hypertuna.mission.flight import Flight, Outcome, fly, outcome
from hypertuna.mission.gpx import check_origin, write_gpx
from hypertuna.mission.new import spelled
from hypertuna.mission.run import expected
from hypertuna.mission.seeds import flight_table, flights_layout, fly_seed_shards, fly_seeds


def _seeds(text: str, key: str) -> range:
    """Return the range of seeds from FROM:TO, without TO."""
    first, colon, last = text.partition(":")
    fix = "write, for example, 0:100"
    if not colon:
        raise InputError("must be FROM:TO", key=key, value=shown(text), fix=fix)
    begin, end = read_whole_number(first, key), read_whole_number(last, key)
    if not 0 <= begin < end:
        raise InputError("must be FROM:TO with 0 <= FROM < TO", key=key, value=shown(text), fix=fix)
    return range(begin, end)


@opt.grouped
def mission_command(
    mission: Annotated[
        str,
        typer.Argument(
            metavar="FILE.toml",
            help=f"Mission file, or name of a mission that comes with hypertuna: {', '.join(missions())}.",
            autocompletion=lambda incomplete: opt.starting((*missions(), "import", "new"), incomplete),
        ),
    ],
    robot: opt.MissionRobot,
    seed: Annotated[
        int | None,
        opt.whole_number(
            "--seed",
            "Seed of the sensors' noise and of the randomized conditions; 0 turns the latter off. (default: 0)",
        ),
    ] = None,
    seeds: Annotated[
        Sequence[int] | None,
        opt.option(
            ("--seeds",), "Fly one mission for each seed from FROM to TO - 1, such as 0:100.", "FROM:TO", _seeds
        ),
    ] = None,
    threads: opt.Threads = None,
    places: opt.Places = opt.NO_PLACES,
    fault: Annotated[
        list[str] | None,
        opt.text(
            "--fault", "Fault of a sensor or a fin's servo, such as depth:nan@100 or fin-port:stuck@100; repeatable."
        ),
    ] = None,
    duration: Annotated[
        float | None,
        opt.number(
            "--duration",
            "seconds",
            "Time in s after which to give up. (default: 10 min after the time limit, or after twice the course)",
        ),
    ] = None,
    checkpoint: opt.Checkpoint = None,
    plot: opt.Plot = None,
    gpx: Annotated[str | None, opt.file("--gpx", "the track", ".gpx")] = None,
    output: Annotated[
        str | None,
        opt.file_or_shards(
            "Write the log to this .mcap file; with --seeds a table to a .nc or .csv file, or to shards in a "
            ".shards folder, which resumes.",
            *(".mcap", ".nc", ".csv"),
        ),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Fly a mission on the twin at sea, under its pilot.

    `hypertuna mission new` writes a mission for a robot, `hypertuna mission import` one from a plan of another program.

    The exit code is 0 if it is done: all waypoints reached and home again, with a position that is known well enough to
    say so; 1 if it ends otherwise (with --seeds: if one of them does, but 0 for shards), 2 for bad input.
    """
    file = read_mission(mission)
    fish = _robot(file, robot)
    for key, given in vars(places).items():
        if given is not None and seeds is None:
            rule, fix = "applies to many flights", "add --seeds, such as --seeds 0:100"
            raise InputError(rule, key=f"--{key.replace('_', '-')}", fix=fix)
    suffixes = (".mcap",) if seeds is None else (".nc", ".csv", opt.SHARDS)
    if output is not None and not output.lower().endswith(suffixes):
        endings = " or ".join(", ".join(suffixes).rsplit(", ", 1))
        raise InputError(f"must end in {endings}", key="--output", value=shown(output), fix="rename the file")
    if seeds is not None:
        for key, value in {"--plot": plot, "--gpx": gpx, "--seed": seed}.items():
            if value:
                fix = "remove it, or remove --seeds"
                raise InputError("applies to a single flight", key=key, fix=fix)
        options: Any = {"threads": threads, "faults": fault or [], "duration": duration}
        how: Any = {"places": places, "refused": {"--checkpoint": checkpoint}, "as_json": as_json}
        _print_warnings(fish, file)
        if not write_shards(output, fly_seed_shards, file, fish, seeds, **how, **options):
            options |= {"checkpoint": checkpoint}
            _fly_many(file, fish, seeds, options, places.cluster, output, as_json)
        return
    if gpx is not None:
        check_origin(file.origin, file.file)
    _print_warnings(fish, file)
    log = None if output is None else Path(output)
    with progress_bar("flying [s]", parts="second", checkpoint=checkpoint) as progress:
        flight = fly(
            file,
            fish,
            seed=seed or 0,
            faults=fault or [],
            duration=duration,
            checkpoint=checkpoint,
            log=log,
            report=progress,
        )
    if gpx is not None:
        write_gpx(flight.record, gpx)
    emit(
        flight,
        record=_record,
        plot=plot,
        written=(gpx, output),
        as_json=as_json,
        failed=flight.status != "done",
    )


def _robot(file: MissionFile, options: opt.MissionRobot) -> Robot:
    """Return the robot of --robot, or of the mission file."""
    chosen = options.robot or file.robot
    if not chosen:
        fix = "add robot to the file, or give --robot"
        raise InputError("is missing", file=file.file, key="robot", fix=fix)
    return replace(options, robot=chosen).load()


def _print_warnings(robot: Robot, file: MissionFile) -> None:
    """Print notes, before the flight, on what will slow the mission down or end it early."""
    check_current(robot, file.mission)
    check_fit(robot, file.mission)
    for sentence in (sentences := warnings_of(robot, file.mission)):
        note(sentence)
    if sentences and spelled(robot) != file.robot:
        command = f"hypertuna mission new FILE.toml --robot {shlex.quote(spelled(robot))}"
        note(f"`{command}` writes a mission that this robot can swim")


def _outcome(result: Outcome) -> dict[str, Any]:
    """Return the JSON record of a flight's outcome, units in the names."""
    ending = {"seed": result.seed, "status": result.status}
    return ending | values_of(result.summary()) | {"reasons_s": result.reasons, "waypoints": result.waypoints}


def _record(flight: Flight) -> dict[str, Any]:
    """Return the JSON record of a flight."""
    record, result, fastest = flight.record, outcome(flight), gait_table(flight.robot).speed[-1]
    return (
        _outcome(result)
        | values_of(record.summary())
        | {"facts": dict(record.facts), "expected_s": expected(record.mission, fastest)}
        | {"status_text": ending_text(flight, result), "command": command_line()}
    )


def _fly_many(
    file: MissionFile,
    robot: Robot,
    seeds: Sequence[int],
    options: dict[str, Any],
    cluster: str | None,
    output: str | None,
    as_json: bool,
) -> None:
    """Fly a mission with many seeds, and print or write a summary."""
    bar = progress_bar("flying", parts="flight", checkpoint=options["checkpoint"])
    with bar as progress, connected(cluster) as executor:
        outcomes = fly_seeds(file, robot, seeds, executor=executor, **options, report=progress)
    facts, layout = made_by(robot, mission=file.name, mission_hash=file.hash), flights_layout(file, robot, seeds)
    emit(
        outcomes,
        record=lambda all_: facts | {"summary": _statistics(all_), "flights": [_outcome(one) for one in all_]},
        lines=lambda all_: _many_lines(f"{file.name}, {robot.name}", all_),
        columns=layout.heads,
        digits=None,
        dataset=lambda all_: layout.dataset(flight_table(all_)),
        output=output,
        as_json=as_json,
        failed=any(one.status != "done" for one in outcomes),
    )


def _statistics(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return the counts of flights by status and reason, and minimum, mean and maximum of each number."""
    rows = [values_of(result.summary()) for result in outcomes]
    columns = {key: np.array([row[key] for row in rows]) for key in rows[0]}
    spans = {key: {"min": column.min(), "mean": column.mean(), "max": column.max()} for key, column in columns.items()}
    reasons = Counter(reason for result in outcomes for reason in result.reasons)
    return {"status": dict(Counter(result.status for result in outcomes)), "reasons": dict(reasons), **spans}


def _many_lines(title: str, outcomes: Sequence[Outcome]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for many flights: minimum, mean and maximum of each number."""
    statistics = _statistics(outcomes)
    yield f"{title}: {counted(len(outcomes), 'flight')}", "bold"
    rows = [
        (quantity.label, *(f"{value:.4g}" for value in statistics[key].values()), quantity.unit)
        for key, quantity in outcomes[0].summary().items()
        if math.isfinite(quantity.value)  # without a fence, the distance to it is NaN
    ]
    yield Table(["", "min", "mean", "max", ""], rows, left=(0, 4))
    yield ", ".join(f"{count} {status}" for status, count in statistics["status"].items())
    yield from _not_done(outcomes)
    reasons = ", ".join(f"{reason.replace('_', ' ')} {count}" for reason, count in statistics["reasons"].items())
    yield f"reasons that the pilot reported, in flights: {reasons or 'none'}", "dim"


def _not_done(outcomes: Sequence[Outcome]) -> Iterator[tuple[str, str]]:
    """Yield a line for the flights that failed in the same way, with their seeds, the most frequent first."""
    failed: dict[str, list[int]] = {}
    for result in outcomes:
        if result.status != "done":
            failed.setdefault(_failure_text(result), []).append(result.seed)
    for why, seeds in sorted(failed.items(), key=lambda item: -len(item[1])):
        yield f"not done: {why}: {'seeds' if len(seeds) > 1 else 'seed'} {', '.join(map(str, seeds))}", "yellow"


def _failure_text(result: Outcome) -> str:
    """Return how a failed flight ended: its status, the first waypoint it missed, and the reasons."""
    missed = [point for point in result.waypoints if point["outcome"] != "reached"]
    where = "all waypoints reached"
    if missed:
        where = f"waypoint {missed[0]['waypoint']} of {len(result.waypoints)} {missed[0]['outcome']}"
    names = [name for name, _ in _core.reason_table()]
    end_reasons = [name.replace("_", " ") for name in result.reasons if name in names[: names.index("all_reached")]]
    return ", ".join([result.status, where, *end_reasons])
