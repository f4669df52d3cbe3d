"""The command `hypertuna trials import markers`, and the parts shared with films of marks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.arrays import Array
from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit, refused, save
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.io.files import version, write_atomically
from hypertuna.ranges import FRACTION, POSITIVE
from hypertuna.trials.marker_import import ChainOptions, fit_marker_run, write_marker_runs
from hypertuna.trials.marker_places import places_text
from hypertuna.trials.marker_run import MarkerRun
from hypertuna.trials.tracks import LENGTHS


@dataclass(frozen=True)
class PlaceOptions:
    """Options: where the markers are on the robot, and which of them are used."""

    places: Annotated[
        str | None,
        opt.text("--places", "CSV file of the places of markers. (default: equally spaced from nose to tail)", "FILE"),
    ] = None
    leave_out: Annotated[str, opt.text("--leave-out", "Markers to leave out, separated by commas.", "MARKER,...")] = ""
    tail_first: Annotated[
        bool, opt.flag("--tail-first", "Equally spaced markers are given from tail to nose, not from nose to tail.")
    ] = False
    merge: Annotated[
        str, opt.text("--merge", "Joint groups that are fitted as one bend, where markers are few.", "JOINT,...")
    ] = ""
    places_from_run: Annotated[
        str | None,
        opt.file("--places-from-run", "the places of the markers, taken from the first run and used in all,", ".csv"),
    ] = None

    def given(self) -> dict[str, Any]:
        """Return the value of each option, by the option's name."""
        return {f"--{field.name.replace('_', '-')}": getattr(self, field.name) for field in fields(self)}

    def chain_options(self) -> ChainOptions:
        """Return the options of the fit of the robot's chain."""
        joints = [_names(self.merge)] if self.merge else []
        return ChainOptions(
            self.places, _names(self.leave_out), self.tail_first, joints, self.places_from_run is not None
        )


@dataclass(frozen=True)
class MarkerOptions:
    """Files of tracked markers."""

    unit: Annotated[
        str | None,
        opt.word("--unit", (*LENGTHS, "px"), "Unit of the markers' coordinates. (default: as the file says, or m)"),
    ] = None
    scale: Annotated[
        float | None, opt.number("--scale", "m/px", "Meters per pixel, with --unit px.", limits=POSITIVE)
    ] = None
    y_axis: Annotated[
        str | None, opt.word("--y-axis", ("up", "down"), "Where y points. (default: down for px, else up)")
    ] = None
    frame_rate: Annotated[
        float | None, opt.number("--frame-rate", "Hz", "Frames per second, without a column of time.", limits=POSITIVE)
    ] = None
    min_likelihood: Annotated[
        float, opt.number("--min-likelihood", "parts of 1", "Below it a marker counts as missing.", limits=FRACTION)
    ] = 0.5
    individual: Annotated[
        str | None, opt.text("--individual", "Which animal, track or camera, if the file holds several.", "NAME")
    ] = None
    vertical: Annotated[
        str | None,
        opt.word("--vertical", ("x", "y", "z"), "Axis of points in space that points up. (default: found)"),
    ] = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `read_markers`."""
        if (self.unit == "px") != (self.scale is not None):
            fix = "give --unit px and --scale in m/px, or neither"
            key, value = "--unit px and --scale", f"--unit {self.unit or 'm'}"
            raise InputError("must be given together", key=key, value=value, fix=fix)
        others = {key: getattr(self, key) for key in ("frame_rate", "min_likelihood", "individual", "vertical")}
        others["scale"] = self.scale if self.scale is not None else LENGTHS[self.unit] if self.unit else None
        return others | {"y_down": None if self.y_axis is None else self.y_axis == "down", "pixels": self.unit == "px"}


@opt.grouped
def import_markers_command(
    files: Annotated[list[str], typer.Argument(help="CSV files of tracked markers or midlines, a run each.")],
    robot: opt.RobotOptions,
    markers: MarkerOptions,
    places: PlaceOptions,
    output: opt.Manifest,
    plot: opt.Plot = None,
    as_json: opt.AsJson = False,
) -> None:
    """Fit the chain of a robot to tracked markers: joint angles, head poses, and a manifest of them.

    Reads files of DeepLabCut, Lightning Pose, SLEAP, TRex, Anipose, DLTdv, Motive, Qualisys, Vicon, OpenSim (TRC),
    Tracker, EthoVision, and plain columns: time_s, x1, y1, x2, y2, ... Files of several runs may be given; the picture
    is that of the first one to look at.
    """
    fish, options, chain_options = robot.load(), markers.arguments(), places.chain_options()
    names = [Path(file).stem for file in files]
    for name in (name for k, name in enumerate(names) if name in names[:k]):
        raise InputError("is the name of two files", key=name, fix="rename one: files name their runs")
    runs: list[MarkerRun] = []
    with progress_bar("fitting") as progress:
        for k, file in enumerate(files):
            runs.append(fit_marker_run(fish, file, chain_options, **options))
            if places.places_from_run is not None and chain_options.from_run:
                text = places_text(runs[0].places, _comment())
                write_atomically(places.places_from_run, text.encode())
                chain_options = replace(chain_options, places=places.places_from_run, from_run=False)
            progress(k + 1, len(files))
    show_marker_runs(runs, fish, output, plot, as_json, comment=_comment(), also=(places.places_from_run,))


def show_marker_runs(
    runs: Sequence[MarkerRun],
    fish: Robot,
    output: str,
    plot: str | None,
    as_json: bool,
    *,
    comment: str,
    noises: Sequence[tuple[Array, float] | None] = (),
    also: Sequence[str | None] = (),
) -> None:
    """Draw, write and print runs; noises: see `write_marker_runs`; also: other files to report as written."""
    plot = plot or str(Path(output).with_suffix(".svg"))
    refused_run = next((run for run in runs if run.refusal()), None)
    from hypertuna.trials.plots_markers import plot_markers

    save(plot_markers(refused_run or next((run for run in runs if run.contradictions), runs[0])), plot)
    if refused_run is not None and (error := refused_run.refusal()):
        fix = f"{error.fix}; the picture is {plot}"
        with refused(as_json):
            raise InputError(error.rule, file=error.file, key=error.key, value=error.value, fix=fix)
    written = write_marker_runs(runs, fish, output, comment, noises)
    records = [run.record() | run.bends(fish) for run in runs]
    emit(
        runs,
        record=lambda _: provenance(fish) | {"runs": records, "written": [*written, plot]},
        lines=lambda runs: _marker_lines(runs, records),
        written=(plot, *also, written[-1]),
        as_json=as_json,
    )


def _names(text: str) -> list[str]:
    """Return the names in a text, separated by commas."""
    return [name for part in text.split(",") if (name := part.strip())]


def _comment() -> str:
    """Return the comment in the first line of the files that the command writes."""
    return f"Made by `hypertuna trials import` {version()}"


def _marker_lines(runs: Sequence[MarkerRun], records: Sequence[dict[str, Any]]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for imported runs."""
    heads = ["run", "frames", "used", "missing", "rejected", "noise [mm]", "head sd [mm]", "yaw sd [deg]"]
    rows = []
    for record in records:
        counts = (record[key] for key in ("frames", "frames_used", "missing", "rejected"))
        sizes = (record["noise_mm"], float(max(record["head_sd_mm"])), record["yaw_sd_deg"])
        rows.append([record["name"], *(f"{count}" for count in counts), *(f"{size:.3g}" for size in sizes)])
    yield Table(heads, rows)
    groups = [f"joint {group}" for group in runs[0].chain.groups]
    angles = [[record["name"], *(f"{sd:.2g}" for sd in record["angle_sd_deg"])] for record in records]
    yield Table(["sd of angles [deg]", *groups], angles)
    heads = ["marker", "missing", "rejected", "noise [mm]", "off along [mm]", "off across [mm]"]
    for record in records:
        columns = (record[f"marker_{key}"] for key in ("missing", "rejected", "noise_mm", "along_mm", "across_mm"))
        own = zip(record["markers"], *columns, strict=True)
        yield f"markers of {record['name']}:"
        yield Table(
            heads,
            [[m, f"{lost}", f"{bad}", *(f"{round(x, 2) + 0.0:.2f}" for x in sizes)] for m, lost, bad, *sizes in own],
        )
    for record in records:
        bends = [f"{name.removesuffix('_deg')} {record[name]:.3g} deg" for name in record if name.startswith("bend_")]
        if bends:
            yield f"hinges of {record['name']} at {record['frequency_hz']:.3g} Hz: {', '.join(bends)}"
        for warning in record["warnings"]:
            yield warning, "yellow"
