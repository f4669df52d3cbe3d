"""The command `hypertuna replay`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from hypertuna.console import check_suffix, command_line, number, number_list, print_json, tell_written
from hypertuna.description import Robot, load
from hypertuna.errors import InputError
from hypertuna.measured import Track, read_joints, read_tracks
from hypertuna.replay import AXES, Pose, SmoothSeries, head_center, replay, rmse, smooth
from hypertuna.results import write_netcdf

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["replay_command"]

COMPARED = ("rmse", "mean_rmse", "repeatability")
# How lengths and angles are shown: unit, and how many of it are one SI unit.
BORDER = {"m": ("cm", 100.0), "rad": ("deg", 180 / np.pi)}


def replay_command(
    angles: Annotated[str, typer.Argument(help="CSV file of measured joint angles.")],
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    columns: Annotated[str, typer.Option("--columns", help="Columns of angles, one per joint group, with commas.")],
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
    water: Annotated[str | None, typer.Option("--water", help="lumped or strip (default: the robot's choice)")] = None,
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

    Exit code 1 means that the replay diverged.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    check_suffix(output, (".nc",), "--output")
    fish = load(robot).using(water=water)
    series = read_joints(angles, time=time_column, columns=_names(columns), unit=unit)
    curve = smooth(series, noise=None if noise is None else _noise(noise))
    zero = np.radians(number(yaw_zero, "yaw_zero", "degrees"))
    tracks = _tracks(poses or [], pose_columns, pose_units, zero, clockwise)
    x, y, heading = _numbers(start, "start", "m, m and degrees", 3)
    result = replay(
        fish,
        curve,
        start=Pose(x, y, np.radians(heading)),
        step=None if step is None else number(step, "step", "seconds"),
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
        print_json(_record(fish, result, curve, compared))
    else:
        _print(fish, result, compared)
        tell_written(plot, output)
    if not sound:
        raise typer.Exit(1)


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


def _record(robot: Robot, result: xr.Dataset, curve: SmoothSeries, compared: xr.Dataset | None) -> dict[str, Any]:
    """Say how a series was replayed, for programs."""
    x, y, yaw = head_center(robot, result)[-1]
    record = dict(result.attrs) | {"joint_noise_deg": np.degrees(curve.noise)}
    record |= {"time_s": float(result["time"][-1]), "steps": result.sizes["time"] - 1}
    record |= {"head_x_m": x, "head_y_m": y, "head_yaw_deg": np.degrees(yaw)}
    if compared is None:
        return record
    axes = {
        axis: {
            f"{name}_{BORDER[unit][0]}": compared[name].sel(axis=axis).to_numpy() * BORDER[unit][1]
            for name in (*COMPARED, "run_rmse")
        }
        for axis, unit in AXES.items()
    }
    return record | {"axes": axes, "runs": compared["run"].to_numpy(), "frames": compared["frames"].to_numpy()}


def _print(robot: Robot, result: xr.Dataset, compared: xr.Dataset | None) -> None:
    """Say it on the terminal."""
    console = Console()
    console.print(result.attrs["status_text"], highlight=False)
    x, y, yaw = head_center(robot, result)[-1]
    place = f"x {x:.4f} m, y {y:.4f} m, facing {np.degrees(yaw):.2f} deg"
    console.print(f"Center of the head at {float(result['time'][-1]):.3f} s: {place}", highlight=False)
    if compared is None:
        return
    runs = f"rmse of {compared.sizes['run']} run{'s' * (compared.sizes['run'] > 1)}"
    table = Table("head", runs, "of their mean", "repeatability", "unit", box=None, pad_edge=False)
    for axis, unit in AXES.items():
        shown, factor = BORDER[unit]
        values = [float(compared[name].sel(axis=axis)) * factor for name in COMPARED]
        table.add_row(axis, *(f"{value:.2f}" if np.isfinite(value) else "one run" for value in values), shown)
    console.print(table)


def _plot(robot: Robot, result: xr.Dataset, tracks: list[Track], plot: str) -> None:
    """Draw a replay; what draws is imported only now."""
    from hypertuna.drawing import save
    from hypertuna.plots import plot_replay

    save(plot_replay(robot, result, tracks), plot)
