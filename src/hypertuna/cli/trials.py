"""The commands `hypertuna trials check | import`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

from hypertuna.cli.old_console import check_suffix, print_json, tell_written
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.io.files import version, write_atomically
from hypertuna.trials.comparison import repeatability
from hypertuna.trials.importers import import_folder, manifest_text
from hypertuna.trials.manifest import Recording
from hypertuna.trials.steady import COLUMNS, SteadyRun
from hypertuna.trials.trials import Trials, read_trials

__all__ = ["trials_app"]

trials_app = typer.Typer(no_args_is_help=True, help="What a tank measured: check trials, import published ones.")

AXES = {"x_cm": 100.0, "y_cm": 100.0, "yaw_deg": 180 / np.pi}  # of repeatability, per SI unit


@trials_app.command()
def check(
    files: Annotated[
        list[str],
        typer.Argument(help="CSV files of steady runs, TOML manifests of tracked runs, folders of published ones."),
    ],
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Read trials, and tell what is in them: runs, spans, how well tracked runs repeat."""
    try:
        fish = load(robot)
        trials = read_trials(files, fish)
    except InputError as error:
        if as_json:
            told = {key: getattr(error, key) for key in ("file", "key", "rule", "value", "fix")}
            print_json({"valid": False, "error": str(error)} | told)
        raise
    if as_json:
        print_json({"valid": True} | provenance(fish) | _summary(trials, fish))
    else:
        _print(_summary(trials, fish))


@trials_app.command("import")
def import_command(
    folder: Annotated[str, typer.Argument(help="Folder of published files; they stay where they are.")],
    output: Annotated[str, typer.Option("-o", "--output", help="Write the manifest to this .toml file.")],
    format: Annotated[str, typer.Option("--format", help="What the folder holds: rexeel.")] = "rexeel",
) -> None:
    """Write a manifest for published files as they stand: columns, units, axes."""
    check_suffix(output, (".toml",), "--output")
    document = import_folder(folder, format, relative_to=Path(output).parent)
    write_atomically(output, manifest_text(document, f"Made by `hypertuna trials import` {version()}").encode())
    tell_written(output)


def _summary(trials: Trials, robot: Robot) -> dict[str, Any]:
    """Say what trials hold, with units in the names."""
    files = dict.fromkeys(run.file for run in trials.steady)
    return {
        "runs": len(trials.runs),
        "steady": [_steady(file, [run for run in trials.steady if run.file == file], robot) for file in files],
        "recordings": [_recording(recording) for recording in trials.recordings],
    }


def _steady(file: str, runs: Sequence[SteadyRun], robot: Robot) -> dict[str, Any]:
    """Say what a file of steady runs holds: the least and the largest value of each column."""
    columns: dict[str, list[float | None]] = {"frequency_hz": [run.gait.frequency for run in runs]}
    for g, group in enumerate(robot.joints):
        for kind in ("amplitude", "phase", "bias"):
            columns[f"{kind}_{group.name}_deg"] = [np.degrees(getattr(run.gait, kind)[g]) for run in runs]
    for key in ("speed", "speed_sd", "cost_of_transport", "cost_of_transport_sd"):
        columns[COLUMNS[key]] = [getattr(run, key) for run in runs]
    given = {name: [value for value in column if value is not None] for name, column in columns.items()}
    spans = {name: [min(values), max(values)] if values else None for name, values in given.items()}
    return {"file": file, "runs": len(runs), "swims": sum(run.repeats for run in runs)} | spans


def _recording(recording: Recording) -> dict[str, Any]:
    """Say what a recording holds."""
    time, offset, tracks = recording.joints.time, recording.time_offset, recording.tracks
    own = repeatability(tracks)
    return {
        "name": recording.name,
        "file": recording.file,
        "joint_file": recording.joints.file,
        "joint_samples": len(time),
        "joints_s": [time[0] + offset, time[-1] + offset],
        "time_offset_s": offset,
        "runs": [track.run for track in tracks],
        "frames": [len(track.time) for track in tracks],
        "poses_s": [min(track.time[0] for track in tracks), max(track.time[-1] for track in tracks)],
        "repeatability": {name: own[k] * factor for k, (name, factor) in enumerate(AXES.items())},
    }


def _print(summary: dict[str, Any]) -> None:
    """Say it on the terminal."""
    console = Console(highlight=False, markup=False)
    for steady in summary["steady"]:
        console.print(f"{steady['file']}: {_count(steady['runs'], 'steady run')} of {_count(steady['swims'], 'swim')}")
        for name, span in steady.items():
            if isinstance(span, list):
                low, high = (f"{round(value, 12):.4g}" for value in span)
                console.print(f"  {name}: {low}" + f" to {high}" * (high != low))
            elif span is None:
                console.print(f"  {name}: not given")
    for recording in summary["recordings"]:
        runs, frames = recording["runs"], recording["frames"]
        console.print(f"{recording['name']}: recording of {_count(len(runs), 'run')}, {_count(sum(frames), 'frame')}")
        for what, count in (("joints", f"{recording['joint_samples']} samples"), ("poses", "tracked")):
            begin, end = recording[f"{what}_s"]
            console.print(f"  {what}: {count} from {begin:.4g} to {end:.4g} s")
        own = recording["repeatability"]
        told = ", ".join(f"{axis.split('_')[0]} {own[axis]:.2f} {axis.split('_')[1]}" for axis in own)
        console.print(f"  repeatability: {told if len(runs) > 1 else 'not known, one run'}")
    console.print(f"{_count(summary['runs'], 'run')} in all")


def _count(number: int, noun: str) -> str:
    """Count things in words."""
    return f"{number} {noun}{'s' * (number != 1)}"
