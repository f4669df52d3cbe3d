"""The command `hypertuna replay`: one series of joint angles, or every recording of a manifest."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from hypertuna.cli.old_console import check_suffix, command_line, number, number_list, print_json, tell_written
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.description.schema.water import LAWS
from hypertuna.errors import InputError
from hypertuna.io.files import write_netcdf
from hypertuna.trials.comparison import compare_recording, replay_recording, with_fitted_clock
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import AXES, Pose, head_center, replay, rmse
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.tracks import Track, read_joints, read_tracks
from hypertuna.trials.trials import read_trials

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["replay_command"]

COMPARED = ("rmse", "mean_rmse", "repeatability")
# How lengths and angles are shown: unit, and how many of it are one SI unit.
BORDER = {"m": ("cm", 100.0), "rad": ("deg", 180 / np.pi)}
# What is shown of a comparison, and what it is called above a column.
HEADS = {
    "rmse": "",
    "mean_rmse": "of their mean",
    "repeatability": "repeatability",
    "ratio": "ratio",
    "best_offset_rmse": "moved",
    "best_offset_ratio": "ratio",
}
RATIOS = ("ratio", "best_offset_ratio")  # without unit
WITH_MANIFEST = ("angles", "robot", "step", "water", "plot", "output", "as_json")


def replay_command(
    context: typer.Context,
    angles: Annotated[
        str,
        typer.Argument(
            help="CSV file of measured joint angles; or a manifest (.toml) or folder of tracked recordings."
        ),
    ],
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    columns: Annotated[
        str, typer.Option("--columns", help="Columns of angles in a CSV file, one per joint group, with commas.")
    ] = "",
    time_column: Annotated[str, typer.Option("--time-column", help="Column of time in seconds.")] = "time_s",
    unit: Annotated[str, typer.Option("--unit", help="Unit of the angles: deg or rad.")] = "deg",
    noise: Annotated[
        str | None, typer.Option("--noise", help="Standard deviation of the angles in degrees (default: estimated)")
    ] = None,
    start: Annotated[
        str, typer.Option("--start", help="x and y of the nose in m, and the angle from nose to tail in degrees.")
    ] = "0,0,0",
    step: Annotated[
        str | None, typer.Option("--step", help="Longest step in seconds (default: half a median interval)")
    ] = None,
    current: Annotated[str, typer.Option("--current", help="Velocity of the water along x and y in m/s.")] = "0,0",
    time_offset: Annotated[
        str, typer.Option("--time-offset", help="Seconds to add to the angles' clock to make it that of the poses.")
    ] = "0",
    water: Annotated[
        str | None, typer.Option("--water", help=f"{' | '.join(LAWS)} (default: the robot's choice)")
    ] = None,
    poses: Annotated[
        list[str] | None,
        typer.Option("--poses", help="CSV file of tracked poses of the head link's center; again for more files."),
    ] = None,
    pose_columns: Annotated[
        str,
        typer.Option("--pose-columns", help="Columns of time, x, y, yaw and, where there are several, the run."),
    ] = "time_s,x_m,y_m,yaw_deg",
    pose_units: Annotated[str, typer.Option("--pose-units", help="Units of x and y, and of yaw.")] = "m,deg",
    yaw_zero: Annotated[
        str, typer.Option("--yaw-zero", help="Direction of yaw 0 in degrees, counter-clockwise from x.")
    ] = "0",
    clockwise: Annotated[bool, typer.Option("--yaw-clockwise", help="Yaw is counted clockwise, from y to x.")] = False,
    plot: Annotated[str | None, typer.Option("--plot", help="Draw the track to this .svg, .png or .pdf file.")] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write the trajectory to this .nc file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Swim measured joint angles, and compare the track of the head with tracked poses.

    A manifest tells columns, units, axes, clocks and start; only --step, --water, --plot, --output and --json go with
    it. A recording's time offset in the robot's [fit] counts. Exit code 1 means that a replay diverged.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    check_suffix(output, (".nc",), "--output")
    fish = load(robot).using(water=water)
    longest = None if step is None else number(step, "step", "seconds")
    if _is_manifest(angles):
        _refuse(context)
        _replay_recordings(fish, angles, step=longest, plot=plot, output=output, as_json=as_json)
        return
    if not columns:
        fix = "name the columns of angles, or give a manifest"
        raise InputError("must be given with a CSV file", key="--columns", fix=fix)
    series = read_joints(angles, time=time_column, columns=_names(columns), unit=unit)
    curve = smooth(series, noise=None if noise is None else _noise(noise))
    zero = np.radians(number(yaw_zero, "yaw_zero", "degrees"))
    tracks = _tracks(poses or [], pose_columns, pose_units, zero, clockwise)
    x, y, heading = _numbers(start, "start", "m, m and degrees", 3)
    result = replay(
        fish,
        curve,
        start=Pose(x, y, np.radians(heading)),
        step=longest,
        current=_numbers(current, "current", "m/s", 2),
        time_offset=number(time_offset, "time_offset", "seconds"),
    )
    sound = result.attrs["status"] == "completed"
    compared = rmse(fish, result, tracks) if tracks and sound else None
    if plot is not None:
        _plot(fish, result, tracks, plot)
    if output is not None:
        write_netcdf(result.assign_attrs(command=command_line()), output)
    if as_json:
        noise_deg = {"joint_noise_deg": np.degrees(curve.noise)}
        print_json(dict(result.attrs) | noise_deg | _end_of(fish, result) | _compared_at_border(compared))
    else:
        _print_end(fish, result)
        _print_errors(compared, COMPARED)
        tell_written(plot, output)
    if not sound:
        raise typer.Exit(1)


def _refuse(context: typer.Context) -> None:
    """Refuse options that a manifest decides."""
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if source is not None and source.name == "COMMANDLINE" and parameter.name not in WITH_MANIFEST:
            fix = "leave it out, or give a CSV file of joint angles"
            raise InputError("does not go with a manifest or a folder", key=max(parameter.opts, key=len), fix=fix)


def _names(text: str) -> list[str]:
    """Read names separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def _noise(text: str) -> float:
    """Read a standard deviation in degrees, and return it in radians."""
    degrees = number(text, "noise", "degrees")
    if degrees < 0:
        fix = "give the standard deviation of the angles"
        raise InputError("must not be negative", key="--noise", value=f"{degrees:g} degrees", fix=fix)
    return math.radians(degrees)


def _numbers(text: str, key: str, unit: str, count: int) -> tuple[Any, ...]:
    """Read so many numbers."""
    values = number_list(text, key, unit)
    if len(values) != count:
        raise InputError(f"must be {count} numbers", key=key, value=text, fix=f"give {unit}, separated by commas")
    return values


def _tracks(files: list[str], columns: str, units: str, yaw_zero: float, clockwise: bool) -> list[Track]:
    """Read the runs of every file."""
    names, unit = _names(columns), _names(units)
    if len(names) not in (4, 5):
        fix = "name the columns of time, x, y, yaw and, if there is one, the run"
        raise InputError("must be 4 or 5 names", key="--pose-columns", value=columns, fix=fix)
    if len(unit) != 2:
        raise InputError("must be two units", key="--pose-units", value=units, fix="write, for example, cm,deg")
    return [
        track
        for file in files
        for track in read_tracks(
            file,
            time=names[0],
            pose=names[1:4],
            run=names[4] if len(names) == 5 else None,
            length_unit=unit[0],
            angle_unit=unit[1],
            yaw_zero=yaw_zero,
            clockwise=clockwise,
        )
    ]


def _plot(robot: Robot, result: xr.Dataset, tracks: list[Track], plot: str) -> None:
    """Draw a replay; what draws is imported only now."""
    from hypertuna.figures import save
    from hypertuna.trials.plots import plot_replay

    save(plot_replay(robot, result, tracks), plot)


def _is_manifest(path: str) -> bool:
    """Tell whether a path is that of a manifest, or of a folder that stands for one."""
    return path.lower().endswith(".toml") or os.path.isdir(path)


def _replay_recordings(
    robot: Robot, path: str, *, step: float | None, plot: str | None, output: str | None, as_json: bool
) -> None:
    """Replay every recording of a manifest, and compare each with its runs."""
    trials = read_trials(path, robot)
    if not trials.recordings:
        fix = "only tracked runs are replayed: add [[recordings]]"
        raise InputError("must hold a recording at least", file=path, fix=fix)
    recordings = [with_fitted_clock(robot, recording) for recording in trials.recordings]
    results, compared = _compared(robot, recordings, step)
    sound = [result.attrs["status"] == "completed" for result in results]
    if plot is not None:
        _plot_recordings(robot, recordings, results, plot)
    if output is not None:
        _write({recording.name: result for recording, result in zip(recordings, results, strict=True)}, output)
    if as_json:
        records = [_record(robot, *parts) for parts in zip(recordings, results, compared, strict=True)]
        for record, given, used in zip(records, trials.recordings, recordings, strict=True):
            record |= _own_clock(robot, given, used, step)
        print_json(provenance(robot) | {"trials": path, "recordings": records})
    else:
        for recording, given, result, found in zip(recordings, trials.recordings, results, compared, strict=True):
            _print(robot, recording, result, found, given=given)
        if trials.steady:
            typer.echo(f"Not replayed: {len(trials.steady)} steady run{'s' * (len(trials.steady) > 1)}.")
        tell_written(plot, output)
    if not all(sound):
        raise typer.Exit(1)


def _compared(
    robot: Robot, recordings: Sequence[Recording], step: float | None
) -> tuple[list[xr.Dataset], list[xr.Dataset | None]]:
    """Replay recordings, and compare with its runs each replay that is complete."""
    results = [replay_recording(robot, recording, step=step) for recording in recordings]
    return results, [
        compare_recording(robot, recording, result) if result.attrs["status"] == "completed" else None
        for recording, result in zip(recordings, results, strict=True)
    ]


def _own_clock(robot: Robot, given: Recording, used: Recording, step: float | None) -> dict[str, Any]:
    """Say where a time offset is from, for programs; with a fitted one, also the errors with the recording's own."""
    if used is given:
        return {"time_offset_source": "trials"}
    _, (compared,) = _compared(robot, [given], step)
    own = {"time_offset_s": given.time_offset} | _compared_at_border(compared)
    return {"time_offset_source": "fit", "without_fitted_offset": own}


def _end_of(robot: Robot, result: xr.Dataset) -> dict[str, float]:
    """Say when and where a replay ends, for programs."""
    x, y, yaw = head_center(robot, result)[-1]
    record = {"time_s": float(result["time"][-1]), "steps": result.sizes["time"] - 1}
    return record | {"head_x_m": x, "head_y_m": y, "head_yaw_deg": np.degrees(yaw)}


def _compared_at_border(compared: xr.Dataset | None) -> dict[str, Any]:
    """Return a comparison in cm and degrees, for programs."""
    if compared is None:
        return {}
    names = [name for name in (*HEADS, "run_rmse") if name in compared]
    axes = {
        axis: {
            name if name in RATIOS else f"{name}_{BORDER[unit][0]}": compared[name].sel(axis=axis).to_numpy()
            * (1 if name in RATIOS else BORDER[unit][1])
            for name in names
        }
        for axis, unit in AXES.items()
    }
    return {"axes": axes, "runs": compared["run"].to_numpy(), "frames": compared["frames"].to_numpy()}


def _print_end(robot: Robot, result: xr.Dataset) -> None:
    """Say on the terminal how a replay went."""
    console = Console()
    console.print(result.attrs["status_text"], highlight=False)
    x, y, yaw = head_center(robot, result)[-1]
    place = f"x {x:.4f} m, y {y:.4f} m, facing {np.degrees(yaw):.2f} deg"
    console.print(f"Center of the head at {float(result['time'][-1]):.3f} s: {place}", highlight=False)


def _print_errors(compared: xr.Dataset | None, names: Sequence[str]) -> None:
    """Say on the terminal how far a replay is from its runs."""
    if compared is None:
        return
    runs = f"rmse of {compared.sizes['run']} run{'s' * (compared.sizes['run'] > 1)}"
    table = Table("head", *(HEADS[name] or runs for name in names), box=None, pad_edge=False)
    for axis, unit in AXES.items():
        shown, factor = BORDER[unit]
        values = [float(compared[name].sel(axis=axis)) * (1 if name in RATIOS else factor) for name in names]
        cells = (f"{value:.2f}" if np.isfinite(value) else "one run" for value in values)
        table.add_row(f"{axis} {escape(f'[{shown}]')}", *cells)
    Console().print(table)


def _record(robot: Robot, recording: Recording, result: xr.Dataset, compared: xr.Dataset | None) -> dict[str, Any]:
    """Say how a recording was replayed, for programs; what made the result stands once above all recordings."""
    attrs = {key: value for key, value in result.attrs.items() if key not in (*provenance(robot), "recording")}
    record = {"name": recording.name} | attrs | _end_of(robot, result) | _compared_at_border(compared)
    offsets = {} if compared is None else {"best_time_offset_s": compared.attrs["best_time_offset_s"]}
    return record | {"time_offset_s": recording.time_offset} | offsets


def _print(
    robot: Robot, recording: Recording, result: xr.Dataset, compared: xr.Dataset | None, *, given: Recording
) -> None:
    """Say it on the terminal."""
    Console().print(recording.name, style="bold", highlight=False, markup=False)
    _print_end(robot, result)
    if recording is not given:
        text = f"time offset {recording.time_offset:.3f} s from [fit], in place of {given.time_offset:g} s"
        Console().print(text, highlight=False, markup=False)
    _print_errors(compared, list(HEADS))
    if compared is not None:
        best, used = compared.attrs["best_time_offset_s"], recording.time_offset
        text = f"moved: with a time offset of {round(best, 3) + 0.0:g} s, which fits best, in place of {used:.3g} s"
        Console().print(text, highlight=False)
    typer.echo()


def _write(results: dict[str, xr.Dataset], output: str) -> None:
    """Write trajectories to a NetCDF file, one group for each recording."""
    import xarray as xr  # here, because it takes longer to import than a swim takes

    groups = {name: result.assign_attrs(command=command_line()) for name, result in results.items()}
    write_netcdf(xr.DataTree.from_dict(groups), output)


def _plot_recordings(robot: Robot, recordings: Sequence[Recording], results: Sequence[xr.Dataset], plot: str) -> None:
    """Draw replays; what draws is imported only now."""
    from hypertuna.figures import save
    from hypertuna.trials.plots import plot_recordings

    save(plot_recordings(robot, recordings, results), plot)
