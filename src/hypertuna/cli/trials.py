"""The commands `hypertuna trials check | import`."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import counted, print_written
from hypertuna.cli.emit import emit, refused
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.io.files import version, write_atomically
from hypertuna.trials.comparison import repeatability
from hypertuna.trials.importers import import_folder, manifest_text
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import AXES, BORDER
from hypertuna.trials.steady import COLUMNS, SteadyRun
from hypertuna.trials.trials import Trials, read_trials

trials_app = opt.group("Tank trials: check them, import published ones.")


@trials_app.command()
def check(
    files: Annotated[
        list[str],
        typer.Argument(help="CSV files of steady runs, TOML manifests of tracked runs, folders of published ones."),
    ],
    robot: opt.RobotName,
    as_json: opt.AsJson = False,
) -> None:
    """Read trials, and summarize them: runs, ranges, repeatability of tracked runs."""
    with refused(as_json):
        fish = load(robot)
        trials = read_trials(files, fish)
    summary = _summary(trials, fish)
    emit(summary, record=lambda facts: {"valid": True} | provenance(fish) | facts, lines=_lines, as_json=as_json)


@trials_app.command("import")
def import_command(
    folder: Annotated[str, typer.Argument(help="Folder of published files; they stay where they are.")],
    output: Annotated[
        str, opt.file("-o", "--output", help="Write the manifest to this .toml file.", suffixes=(".toml",))
    ],
    format: Annotated[str, opt.text("--format", "Format of the folder: rexeel.")] = "rexeel",
) -> None:
    """Write a manifest for published files as they stand: columns, units, axes."""
    document = import_folder(folder, format, relative_to=Path(output).parent)
    write_atomically(output, manifest_text(document, f"Made by `hypertuna trials import` {version()}").encode())
    print_written(output)


def _summary(trials: Trials, robot: Robot) -> dict[str, Any]:
    """Return the content of trials, names with units."""
    files = dict.fromkeys(run.file for run in trials.steady)
    return {
        "runs": len(trials.runs),
        "steady": [_steady(file, [run for run in trials.steady if run.file == file], robot) for file in files],
        "recordings": [_recording(recording) for recording in trials.recordings],
    }


def _steady(file: str, runs: Sequence[SteadyRun], robot: Robot) -> dict[str, Any]:
    """Return the content of a file of steady runs: minimum and maximum of each column."""
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
    """Return the content of a recording."""
    time, offset, tracks = recording.joints.time, recording.time_offset, recording.tracks
    borders = [(axis, *BORDER[unit]) for axis, unit in AXES.items()]
    own = zip(borders, repeatability(tracks), strict=True)
    spread = {f"{axis}_{unit}": size * factor for (axis, unit, factor), size in own}
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
        "repeatability": spread,
    }


def _lines(summary: dict[str, Any]) -> Iterator[str]:
    """Lay out the content of trials."""
    for steady in summary["steady"]:
        yield f"{steady['file']}: {counted(steady['runs'], 'steady run')} of {counted(steady['swims'], 'swim')}"
        for name, span in steady.items():
            if isinstance(span, list):
                low, high = (f"{round(value, 12):.4g}" for value in span)
                yield f"  {name}: {low}" + f" to {high}" * (high != low)
            elif span is None:
                yield f"  {name}: not given"
    for recording in summary["recordings"]:
        runs, frames, spread = len(recording["runs"]), sum(recording["frames"]), recording["repeatability"]
        yield f"{recording['name']}: recording of {counted(runs, 'run')}, {counted(frames, 'frame')}"
        for what, count in (("joints", f"{recording['joint_samples']} samples"), ("poses", "tracked")):
            begin, end = recording[f"{what}_s"]
            yield f"  {what}: {count} from {begin:.4g} to {end:.4g} s"
        axes = ", ".join(f"{axis.split('_')[0]} {spread[axis]:.2f} {axis.split('_')[1]}" for axis in spread)
        yield f"  repeatability: {axes if runs > 1 else 'not known, one run'}"
    yield f"{counted(summary['runs'], 'run')} in all"
