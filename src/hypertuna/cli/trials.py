"""The commands `hypertuna trials check | import`, and those of films."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.command import App, Group
from hypertuna.cli.console import print_written
from hypertuna.cli.emit import emit, refused
from hypertuna.cli.film import camera_command, clock_command, record_command, track_command
from hypertuna.cli.import_markers import import_markers_command
from hypertuna.cli.import_poses import import_poses_command
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.io.files import version, write_atomically
from hypertuna.io.quantity import counted
from hypertuna.trials.importers import import_folder, manifest_text
from hypertuna.trials.kinds import KINDS
from hypertuna.trials.trials import Trials, implausible, read_trials

trials_app = opt.group("Tank trials: check them, import published ones, track films.")


@trials_app.command()
@opt.grouped
def check(
    files: Annotated[
        list[str],
        typer.Argument(help="CSV files of steady runs, TOML manifests of tracked runs, folders of published ones."),
    ],
    robot: opt.RobotOptions,
    as_json: opt.AsJson = False,
) -> None:
    """Read trials, and summarize them: runs, ranges, repeatability of tracked runs."""
    with refused(as_json):
        fish = robot.load()
        trials = read_trials(files, fish)
    summary = _summary(trials, fish)
    emit(
        summary,
        record=lambda facts: {"valid": True} | provenance(fish) | facts,
        lines=lambda facts: _lines(facts, fish.name),
        as_json=as_json,
    )


class _Import(Group):
    """The group `import`: a first word that names no format is taken as the folder of `import folder`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if args and args[0] not in {*self.commands, "-h", "--help"}:
            args = ["folder", *args]
        return super().parse_args(ctx, args)


import_app = App(
    cls=_Import,
    no_args_is_help=True,
    help="Make manifests of other files: tracked markers, poses, or folders of published runs.",
)
trials_app.add_typer(import_app, name="import")
import_app.command("poses")(import_poses_command)
import_app.command("markers")(import_markers_command)
trials_app.command("track")(track_command)
trials_app.command("record")(record_command)
trials_app.command("camera")(camera_command)
trials_app.command("clock")(clock_command)


@import_app.command("folder")
def import_folder_command(
    folder: Annotated[str, typer.Argument(help="Folder of published files; they stay where they are.")],
    output: opt.Manifest,
    format: Annotated[str, opt.text("--format", "Format of the folder: rexeel.")] = "rexeel",
) -> None:
    """Write a manifest for a published data set, whose files stay unchanged: columns, units and axes."""
    document = import_folder(folder, format, relative_to=Path(output).parent)
    comment = f"Made by `hypertuna trials import` {version()}"
    write_atomically(output, manifest_text(document, comment).encode())
    print_written(output)


def _summary(trials: Trials, robot: Robot) -> dict[str, Any]:
    """Return the JSON record of trials: the summaries of each kind, units in the names, and warnings."""
    errors, warnings = implausible(trials, robot)
    content = {kind.key: kind.summaries(trials.kinds.get(kind, ()), robot) for kind in KINDS}
    return {"runs": len(trials.runs)} | content | {"warnings": [*map(str, errors), *warnings]}


def _lines(summary: dict[str, Any], robot: str) -> Iterator[Any]:
    """Yield the lines that the terminal prints for trials' summaries."""
    for kind in KINDS:
        for entry in summary[kind.key]:
            yield from kind.lines(entry)
    for sentence in summary["warnings"]:
        yield f"unlikely: {sentence}", "yellow"
    yield f"{counted(summary['runs'], 'run')} in all, checked against the model of {robot}"
