"""The commands `hypertuna trials track | camera`."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import print_written, progress_bar
from hypertuna.cli.emit import emit, save
from hypertuna.description.provenance import provenance
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.io.files import version
from hypertuna.ranges import FINITE, NOT_NEGATIVE, POSITIVE


@dataclass(frozen=True)
class FilmOptions:
    """How a fish is filmed."""

    camera: Annotated[str | None, opt.text("--camera", "Camera, a file of `hypertuna trials camera`.", "FILE")] = None
    depth: Annotated[
        float,
        opt.number("--depth", "m", "Depth of the fish's axis under the surface. (default: 0)", limits=NOT_NEGATIVE),
    ] = 0.0
    sections: Annotated[
        str | None,
        opt.text("--sections", "CSV file of the robot's widths and heights. (default: estimated)", "FILE"),
    ] = None
    scale: Annotated[
        str, opt.word("--scale", ("fish", "camera"), "What gives the scale: the fish's own length, or the camera.")
    ] = "fish"


@opt.grouped
def track_command(
    film: Annotated[str, typer.Argument(help="Film of the robot from above, of constant frame rate.")],
    robot: opt.RobotOptions,
    options: FilmOptions,
    output: opt.Manifest,
    overlay: Annotated[str | None, opt.file("--overlay", "the film with the outline over it", ".mp4")] = None,
    plot: opt.Plot = None,
    checkpoint: opt.Checkpoint = None,
    as_json: opt.AsJson = False,
) -> None:
    """Track a robot through a film: joint angles, head poses, and a manifest of them; needs the extra film.

    The outline of the robot's own sections is fitted to the pixels of every frame. The plot shows the worst frames.
    """
    from hypertuna.film.camera import read_camera
    from hypertuna.film.run import track_film, write_film_run
    from hypertuna.io.checkpoint import Journal

    fish = robot.load()
    if options.camera is None:
        raise InputError("is missing", key="--camera", fix="make its file by `hypertuna trials camera`")
    camera = read_camera(options.camera)
    own: dict[str, Any] = {"depth": options.depth, "sections": options.sections, "scale": options.scale}
    header = {"film": Path(film).name, "robot": fish.name, "options": own | {"camera": camera.model_dump(mode="json")}}
    with ExitStack() as stack:
        journal = stack.enter_context(Journal(checkpoint, header)) if checkpoint else None
        progress = stack.enter_context(progress_bar("tracking", parts="frames", checkpoint=checkpoint))
        run = track_film(fish, film, camera, **own, journal=journal, progress=progress)
    written = write_film_run(run, fish, output, f"Made by `hypertuna trials track` {version()}")
    if overlay is not None:
        from hypertuna.film.overlay import write_overlay

        with progress_bar("drawing") as progress:
            write_overlay(run, overlay, progress)
        written.append(overlay)
    if plot is not None:
        from hypertuna.film.plots import plot_film

        save(plot_film(run), plot)
    record = run.record()
    emit(
        run,
        record=lambda _: provenance(fish) | {"run": record, "written": written},
        lines=lambda _: _lines(record),
        written=(plot, overlay, output),
        as_json=as_json,
    )


def _lines(record: dict[str, Any]) -> Iterator[Any]:
    """Lay out a tracked film."""
    sizes = (record["fish_px"], record["contrast_gray"], record["edge_offset_px"], record["length_ratio"])
    heads = ["run", "frames", "used", "fish [px]", "contrast", "edges off [px]", "length ratio"]
    counts = (f"{record[key]}" for key in ("frames", "frames_used"))
    yield Table(heads, [[record["name"], *counts, *(f"{size:.3g}" for size in sizes)]])
    rows = []
    amplitude = record["amplitude_deg"]
    for k, (group, seen) in enumerate(record["seen"].items()):
        swing = "-" if amplitude is None else f"{amplitude[k]:.1f}"
        rows.append([f"joint {group}", f"{100 * seen:.0f}", swing, f"{record['noise_deg'][k]:.2g}"])
    yield Table(["", "seen [%]", "amplitude [deg]", "noise [deg]"], rows)
    beat = "none" if record["beat_hz"] is None else f"{record['beat_hz']:.4g} Hz, {record['beats']:.1f} beats"
    yield (
        f"beat: {beat}; memory of the noise {record['noise_tau_s']:.2g} s; head within "
        f"{max(record['head_sd_mm']):.2g} mm, yaw within {record['yaw_sd_deg']:.2g} deg"
    )
    for warning in record["warnings"]:
        yield warning, "yellow"


@dataclass(frozen=True)
class LensOptions:
    """What a camera is found from."""

    board: Annotated[str | None, opt.text("--board", "Film of a checkerboard in air, moved about.", "FILM")] = None
    squares: Annotated[
        tuple[float, ...] | None,
        opt.numbers("--squares", "1", "Inner corners of the board, along and across. (default: 9,6)", count=2),
    ] = None
    corners: Annotated[
        str | None, opt.text("--corners", "CSV file of points of the tank: u_px, v_px, x_m, y_m.", "FILE")
    ] = None
    corner_depth: Annotated[
        float, opt.number("--corner-depth", "m", "Depth of these points under the surface.", limits=NOT_NEGATIVE)
    ] = 0.0
    size: Annotated[
        tuple[float, ...] | None,
        opt.numbers("--size", "1", "Width and height of the film's frames, without a board.", count=2),
    ] = None
    focal: Annotated[float | None, opt.number("--focal", "1", "Focal length in pixels, if known.", limits=POSITIVE)] = (
        None
    )
    lens_k1: Annotated[float, opt.number("--lens-k1", "1", "Radial distortion, without a board.", limits=FINITE)] = 0.0


@opt.grouped
def camera_command(
    height: Annotated[float, opt.number("--height", "m", "Height of the camera over the water.", limits=POSITIVE)],
    lens: LensOptions,
    output: Annotated[str, opt.file("--output", "the camera", ".toml")],
    as_json: opt.AsJson = False,
) -> None:
    """Find the camera of films: its lens from a checkerboard, its place from its height and points of the tank."""
    from hypertuna.film.calibrate import calibrate
    from hypertuna.film.camera import write_camera

    size, squares = (None if pair is None else (int(pair[0]), int(pair[1])) for pair in (lens.size, lens.squares))
    camera, about = calibrate(
        size=size,
        board=lens.board,
        squares=squares or (9, 6),
        corners=lens.corners,
        corner_depth=lens.corner_depth,
        height=height,
        focal=lens.focal,
        lens_k1=lens.lens_k1,
    )
    write_camera(camera, output, f"Made by `hypertuna trials camera` {version()}")
    facts = camera.model_dump(mode="json", by_alias=True) | about
    emit(facts, record=dict, lines=_facts, as_json=as_json)
    if not as_json:
        print_written(output)


def _facts(facts: dict[str, Any]) -> Iterator[Any]:
    """Lay out a camera."""
    yield Table(["camera", ""], [[key, f"{value}"] for key, value in facts.items()], left=(0,))
