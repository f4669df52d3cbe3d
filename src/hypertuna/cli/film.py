"""The commands `hypertuna trials track | camera | record | clock`."""

import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from hypertuna.film.camera import Camera

from hypertuna.cli import options as opt
from hypertuna.cli.console import print_written, progress_bar
from hypertuna.cli.emit import emit, save
from hypertuna.cli.import_markers import PlaceOptions, show_marker_runs
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.io.files import version, write_atomically
from hypertuna.io.quantity import counted
from hypertuna.ranges import FINITE, NOT_NEGATIVE, POSITIVE


@dataclass(frozen=True)
class FilmOptions:
    """Options of a film of a fish: its camera, depth and frame rate."""

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
        str | None,
        opt.word(
            "--scale",
            ("fish", "camera"),
            "What gives the scale: the fish's own length, or the camera, as with --marks. (default: fish)",
        ),
    ] = None
    frame_rate: Annotated[
        float | None,
        opt.number("--frame-rate", "Hz", "Rate of filming, where the film has another: slow motion.", limits=POSITIVE),
    ] = None


@dataclass(frozen=True)
class MarkOptions:
    """Marks on the robot that are tracked in place of its outline."""

    marks: Annotated[
        str | None, opt.word("--marks", ("dots", "tags"), "Track colored dots, or ArUco tags, not the outline.")
    ] = None
    dot_color: Annotated[
        str | None, opt.text("--dot-color", "Color of the dots, by name or as #rrggbb. (default: the strongest)")
    ] = None
    dictionary: Annotated[str, opt.text("--dictionary", "Dictionary of the tags, by OpenCV's name.")] = "4x4_50"


@opt.grouped
def track_command(
    film: Annotated[str, typer.Argument(help="Film of the robot from above, of constant frame rate.")],
    robot: opt.RobotOptions,
    options: FilmOptions,
    marks: MarkOptions,
    places: PlaceOptions,
    output: opt.Manifest,
    overlay: Annotated[str | None, opt.file("--overlay", "the film with the outline over it", ".mp4")] = None,
    plot: opt.Plot = None,
    checkpoint: opt.Checkpoint = None,
    as_json: opt.AsJson = False,
) -> None:
    """Track a robot through a film: joint angles, head poses, and a manifest of them; needs the extra film.

    The outline of the robot's own sections is fitted to the pixels of every frame; or, with --marks, its chain to dots
    or tags. The plot shows the worst frames.
    """
    from hypertuna.film.camera import read_camera
    from hypertuna.film.pace import pace_warnings
    from hypertuna.film.record import is_live
    from hypertuna.film.run import track_film, write_film_run
    from hypertuna.io.checkpoint import Journal

    fish = robot.load()
    if is_live(film):
        raise InputError(
            "is no film", key=film, fix=f"record it: hypertuna trials record {film} --duration 20 -o run.mkv"
        )
    if options.camera is None:
        raise InputError("is missing", key="--camera", fix="make its file by `hypertuna trials camera`")
    camera = read_camera(options.camera)
    if marks.marks is not None:
        for key, value in (("--sections", options.sections), ("--checkpoint", checkpoint)):
            if value is not None:
                raise InputError("is for outlines", key=key, fix="leave it out with --marks")
        if options.scale == "fish":
            fix = "leave it out; where the two differ, check the camera's height and --depth"
            raise InputError("cannot be the fish's with --marks: the camera measures them", key="--scale", fix=fix)
        _track_marks(fish, film, camera, options, marks, places, output, overlay, plot, as_json)
        return
    for key, value in {"--dot-color": marks.dot_color, **places.given()}.items():
        if value:
            raise InputError("is used only with --marks", key=key, fix="add --marks dots or --marks tags")
    own: dict[str, Any] = {"depth": options.depth, "sections": options.sections, "scale": options.scale or "fish"}
    own["frame_rate"] = options.frame_rate
    header = {"film": Path(film).name, "robot": fish.name, "options": own | {"camera": camera.model_dump(mode="json")}}
    with ExitStack() as stack:
        journal = stack.enter_context(Journal(checkpoint, header)) if checkpoint else None
        progress = stack.enter_context(progress_bar("tracking", parts="frames", checkpoint=checkpoint))
        run = track_film(fish, film, camera, **own, journal=journal, progress=progress)
    written = write_film_run(run, fish, output, f"Made by `hypertuna trials track` {version()}")
    if overlay is not None:
        from hypertuna.film.overlay import drawn, write_overlay

        with progress_bar("drawing") as progress:
            write_overlay(run.view.film, partial(drawn, run), overlay, progress)
        written.append(overlay)
    if plot is not None:
        from hypertuna.film.plots import plot_film

        save(plot_film(run), plot)
    record = run.record()
    record["warnings"] += pace_warnings(fish, record["beat_hz"], record["frame_rate_hz"])
    emit(
        run,
        record=lambda _: provenance(fish) | {"run": record, "written": written},
        lines=lambda _: _lines(record),
        written=(plot, overlay, output),
        as_json=as_json,
    )


def _track_marks(
    fish: Robot,
    film: str,
    camera: "Camera",
    options: FilmOptions,
    marks: MarkOptions,
    places: PlaceOptions,
    output: str,
    overlay: str | None,
    plot: str | None,
    as_json: bool,
) -> None:
    """Track dots or tags, and fit and judge them like the markers of a file."""
    from hypertuna.film.marks import Marks, judged, points_of
    from hypertuna.film.overlay import marked, write_overlay
    from hypertuna.film.source import open_film
    from hypertuna.trials.marker_import import fit_markers
    from hypertuna.trials.marker_places import places_text
    from hypertuna.trials.markers import markers_of

    assert marks.marks is not None
    painted = Marks(marks.marks, marks.dot_color, marks.dictionary, places.places)
    with progress_bar("tracking") as progress:
        opened = open_film(film, options.frame_rate)
        points = points_of(fish, opened, camera, options.depth, painted, progress)
    run, noise = judged(fit_markers(fish, markers_of(points), places.chain_options()), fish, opened.rate)
    comment = f"Made by `hypertuna trials track` {version()}"
    if places.places_from_run is not None:
        write_atomically(places.places_from_run, places_text(run.places, comment).encode())
    if overlay is not None:
        with progress_bar("drawing") as progress:
            write_overlay(opened, marked(run, opened, camera, options.depth), overlay, progress)
    other_files = (places.places_from_run, overlay)
    show_marker_runs([run], fish, output, plot, as_json, comment=comment, noises=[noise], also=other_files)


def _lines(record: dict[str, Any]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a tracked film."""
    sizes = (record["fish_px"], record["contrast_gray"], record["edge_offset_px"], record["length_ratio"])
    column_names = ["run", "frames", "used", "fish [px]", "contrast", "edges off [px]", "length ratio"]
    counts = (f"{record[key]}" for key in ("frames", "frames_used"))
    yield Table(column_names, [[record["name"], *counts, *(f"{size:.3g}" for size in sizes)]])
    rows = []
    amplitude = record["amplitude_deg"]
    for k, (group, seen) in enumerate(record["seen"].items()):
        swing = "-" if amplitude is None else f"{amplitude[k]:.1f}"
        rows.append([f"joint {group}", f"{100 * seen:.0f}", swing, f"{record['noise_deg'][k]:.2g}"])
    yield Table(["", "seen [%]", "amplitude [deg]", "noise [deg]"], rows)
    beat = "none" if record["beat_hz"] is None else f"{record['beat_hz']:.4g} Hz, {record['beats']:.1f} beats"
    yield f"camera: {record['camera_off_vertical_deg']:.2g} deg off straight down"
    yield (
        f"beat: {beat}; memory of the noise {record['noise_tau_s']:.2g} s; head within "
        f"{max(record['head_sd_mm']):.2g} mm, yaw within {record['yaw_sd_deg']:.2g} deg"
    )
    for warning in record["warnings"]:
        yield warning, "yellow"


@dataclass(frozen=True)
class LensOptions:
    """Options of a camera's calibration: board, corners of the tank, and lens."""

    board: Annotated[str | None, opt.text("--board", "Film of a checkerboard in air, moved about.", "FILM")] = None
    squares: Annotated[
        Sequence[float] | None,
        opt.numbers("--squares", "1", "Inner corners of the board, along and across. (default: 9,6)", count=2),
    ] = None
    corners: Annotated[
        str | None, opt.text("--corners", "CSV file of points of the tank: u_px, v_px, x_m, y_m.", "FILE")
    ] = None
    corner_depth: Annotated[
        float, opt.number("--corner-depth", "m", "Depth of these points under the surface.", limits=NOT_NEGATIVE)
    ] = 0.0
    size: Annotated[
        Sequence[float] | None,
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
    camera, report = calibrate(
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
    facts = camera.model_dump(mode="json", by_alias=True) | {"off_vertical_deg": math.degrees(camera.off_vertical)}
    facts |= report
    emit(facts, record=dict, lines=_facts, as_json=as_json)
    if not as_json:
        print_written(output)


def _facts(facts: dict[str, Any]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a calibrated camera."""
    rows = [[key, f"{value}"] for key, value in facts.items() if key != "warnings"]
    yield Table(["camera", ""], rows, left=(0,))
    if "corners" in facts:
        yield f"The camera looks {facts['off_vertical_deg']:.2g} deg off straight down."
        yield from ((sentence, "yellow") for sentence in facts.get("warnings", ()))
    else:
        yield "The camera is taken to look straight down, for no points of the tank were given by --corners.", "yellow"


@opt.grouped
def record_command(
    source: Annotated[str, typer.Argument(help="camera:0, an address (rtsp://..., http://...), or - for a pipe.")],
    duration: Annotated[float, opt.number("--duration", "s", "Time to record.", limits=POSITIVE)],
    output: Annotated[str, opt.file("--output", "the film", ".mkv")],
    size: Annotated[
        Sequence[float] | None, opt.numbers("--size", "1", "Width and height, if the camera has several.", count=2)
    ] = None,
    frame_rate: Annotated[
        float | None, opt.number("--frame-rate", "Hz", "Frames per second, if the camera has several.", limits=POSITIVE)
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Record a live camera with the times of its frames, to be tracked as any film; needs the extra film."""
    from hypertuna.film.record import record
    from hypertuna.film.source import open_film

    pixels = None if size is None else (int(size[0]), int(size[1]))
    with progress_bar("recording", parts="ms") as progress:
        record(source, output, duration=duration, size=pixels, rate=frame_rate, progress=progress)
    film = open_film(output)
    facts = {"file": output, "frames": len(film.time), "frame_rate_hz": film.rate, "size_px": [film.width, film.height]}
    emit(facts, record=dict, lines=_recorded_lines, written=(output,), as_json=as_json)


def _recorded_lines(facts: dict[str, Any]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a recorded film."""
    width, height = facts["size_px"]
    yield f"{facts['frames']} frames of {width} x {height} pixels at {facts['frame_rate_hz']:.4g} Hz"


@opt.grouped
def clock_command(
    film: Annotated[str, typer.Argument(help="Film in which a lamp blinks.")],
    led: Annotated[
        Sequence[float] | None,
        opt.numbers("--led", "1", "Pixel of the lamp, to the right and down. (default: found)", count=2),
    ] = None,
    log: Annotated[str | None, opt.text("--log", "CSV file of a log: time_s, and 1 while the lamp is on.", "FILE")] = (
        None
    ),
    column: Annotated[str, opt.text("--column", "Column of the lamp in the log.")] = "blink",
    output: Annotated[str | None, opt.file("--output", "the times of the blinks", ".csv")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Find when a lamp in a film goes on, and the offset and drift of a log's clock."""
    from hypertuna.film.blinks import blinks_of, clock_between, lamp_of, read_blinks
    from hypertuna.film.source import open_film

    opened = open_film(film)
    lamp = lamp_of(opened) if led is None else (round(led[0]), round(led[1]))
    blinks = blinks_of(opened, lamp)
    facts: dict[str, Any] = {"file": film, "led_px": list(lamp), "frame_rate_hz": opened.rate}
    facts |= {"blinks_s": blinks.tolist(), "blink_sd_s": 1 / (opened.rate * 12**0.5)}
    if log is not None:
        clock = clock_between(blinks, read_blinks(log, column), opened.rate, film)
        facts |= {"log": log, "matched": clock.blinks, "time_offset_s": clock.offset, "time_offset_sd_s": clock.sd}
        facts |= {"middle_s": clock.middle, "drift": clock.drift, "drift_sd": clock.drift_sd, "left_s": clock.left}
    if output is not None:
        rows = "".join(f"{time:.6f}\n" for time in blinks)
        write_atomically(output, f"# Made by `hypertuna trials clock` {version()}\ntime_s\n{rows}".encode())
    emit(facts, record=dict, lines=_clock_lines, written=(output,), as_json=as_json)


def _clock_lines(facts: dict[str, Any]) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a film's blinks, and of a log's clock if there is one."""
    yield Table(["blink", "time [s]"], [[f"{k + 1}", f"{time:.3f}"] for k, time in enumerate(facts["blinks_s"])])
    frame = 1e3 / facts["frame_rate_hz"]
    yield f"lamp at pixel {facts['led_px'][0]}, {facts['led_px'][1]}; a blink begins within one frame, {frame:.2g} ms"
    if "log" not in facts:
        return
    yield (
        f"time_offset_s = {facts['time_offset_s']:.4f}, within {1e3 * facts['time_offset_sd_s']:.2g} ms (1 sd), by "
        f"{counted(facts['matched'], 'blink')} in both: add it to the times of {facts['log']}"
    )
    drift, sd = (f"{1e6 * facts[key]:.0f} ppm" for key in ("drift", "drift_sd"))
    residual = f"{1e3 * facts['left_s']:.2g} ms off the line (rms)"
    yield f"drift: {drift}, within {sd}, from {facts['middle_s']:.1f} s of the log on; the blinks are {residual}"
