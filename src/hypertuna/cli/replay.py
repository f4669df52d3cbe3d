"""The command `hypertuna replay`: one series of joint angles, or every recording of a manifest."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, counted, table
from hypertuna.cli.emit import emit
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.trials.comparison import compare_recording, replay_recording, with_fitted_clock
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import AXES, Pose, head_center, replay, rmse
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.tracks import Track, read_joints, read_tracks
from hypertuna.trials.trials import Trials, read_trials

if TYPE_CHECKING:
    import xarray as xr

COMPARED = ("rmse", "mean_rmse", "repeatability")
# Units on the terminal, and how many of them are one SI unit.
BORDER = {"m": ("cm", 100.0), "rad": ("deg", 180 / np.pi)}
# Columns of a comparison, and their heads.
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
    robot: opt.RobotName,
    columns: Annotated[
        str, opt.text("--columns", "Columns of angles in a CSV file, one per joint group, separated by commas.")
    ] = "",
    time_column: Annotated[str, opt.text("--time-column", "Column of time in s.")] = "time_s",
    unit: Annotated[str, opt.text("--unit", "Unit of the angles: deg or rad.")] = "deg",
    noise: Annotated[
        float | None,
        opt.number("--noise", "degrees", "Standard deviation of the angles in degrees. (default: estimated)"),
    ] = None,
    start: Annotated[
        Sequence[float],
        opt.numbers(
            "--start",
            "m, m and degrees",
            "x and y of the nose in m, and the angle from nose to tail in degrees.",
            count=3,
        ),
    ] = (0.0, 0.0, 0.0),
    step: Annotated[
        float | None, opt.number("--step", "seconds", "Maximum step in s. (default: half a median interval)")
    ] = None,
    current: Annotated[
        Sequence[float], opt.numbers("--current", "m/s", "Velocity of the water along x and y in m/s.", count=2)
    ] = (0.0, 0.0),
    time_offset: Annotated[
        float,
        opt.number(
            "--time-offset", "seconds", "Seconds to add to the clock of the angles to obtain that of the poses."
        ),
    ] = 0,
    water: opt.WaterLaw = None,
    poses: Annotated[
        list[str] | None,
        opt.text("--poses", "CSV file of tracked poses of the head link's center; repeatable.", "FILE"),
    ] = None,
    pose_columns: Annotated[
        str, opt.text("--pose-columns", "Columns of time, x, y, yaw and, where there are several, the run.")
    ] = "time_s,x_m,y_m,yaw_deg",
    pose_units: Annotated[str, opt.text("--pose-units", "Units of x and y, and of yaw.")] = "m,deg",
    yaw_zero: Annotated[
        float, opt.number("--yaw-zero", "degrees", "Direction of yaw 0 in degrees, counter-clockwise from x.")
    ] = 0,
    clockwise: Annotated[bool, typer.Option("--yaw-clockwise", help="Yaw is clockwise, from y to x.")] = False,
    plot: opt.Plot = None,
    output: Annotated[
        str | None, opt.file("-o", "--output", help="Write the trajectory to this .nc file.", suffixes=(".nc",))
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Swim measured joint angles, and compare the head's track with tracked poses.

    A manifest holds columns, units, axes, clocks and start; only --step, --water, --plot, --output and --json go with
    it. A time offset in the robot's [fit] replaces that of the recording. Exit code 1 means that a replay diverged.
    """
    fish = load(robot).using(water=water)
    if angles.lower().endswith(".toml") or os.path.isdir(angles):
        _check_manifest_options(context)
        _replay_recordings(fish, angles, step=step, plot=plot, output=output, as_json=as_json)
        return
    if not columns:
        fix = "name the columns of angles, or give a manifest"
        raise InputError("must be given with a CSV file", key="--columns", fix=fix)
    if noise is not None and noise < 0:
        fix = "give the standard deviation of the angles"
        raise InputError("must not be negative", key="--noise", value=f"{noise:g} degrees", fix=fix)
    series = read_joints(angles, time=time_column, columns=_names(columns), unit=unit)
    curve = smooth(series, noise=None if noise is None else math.radians(noise))
    tracks = _tracks(poses or [], pose_columns, pose_units, math.radians(yaw_zero), clockwise)
    x, y, heading = start
    result = replay(
        fish,
        curve,
        start=Pose(x, y, np.radians(heading)),
        step=step,
        current=(current[0], current[1]),
        time_offset=time_offset,
    )
    completed = result.attrs["status"] == "completed"
    compared = rmse(fish, result, tracks) if tracks and completed else None
    noise_deg = {"joint_noise_deg": np.degrees(curve.noise)}
    emit(
        result,
        record=lambda data: dict(data.attrs) | noise_deg | _end_of(fish, data) | _compared_at_border(compared),
        lines=lambda data: [*_end_lines(fish, data), *_error_lines(compared, COMPARED)],
        dataset=lambda data: data,
        output=output,
        plot=plot,
        figure="hypertuna.trials.plots:plot_replay",
        drawn=(fish, result, tracks),
        as_json=as_json,
        failed=not completed,
    )


def _check_manifest_options(context: typer.Context) -> None:
    """Check that no option is given that a manifest decides."""
    for parameter in context.command.params:
        source = str(context.get_parameter_source(parameter.name or ""))
        if source.endswith("COMMANDLINE") and parameter.name not in WITH_MANIFEST:
            fix = "leave it out, or give a CSV file of joint angles"
            raise InputError(
                "cannot be combined with a manifest or a folder", key=max(parameter.opts, key=len), fix=fix
            )


def _names(text: str) -> list[str]:
    """Read names separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def _tracks(files: list[str], columns: str, units: str, yaw_zero: float, clockwise: bool) -> list[Track]:
    """Read the runs of every file; `yaw_zero` [rad]."""
    names, unit = _names(columns), _names(units)
    if len(names) not in (4, 5):
        fix = "name the columns of time, x, y, yaw and, if there is one, the run"
        raise InputError("must be 4 or 5 names", key="--pose-columns", value=columns, fix=fix)
    if len(unit) != 2:
        raise InputError("must be two units", key="--pose-units", value=units, fix="write, for example, cm,deg")
    options: dict[str, Any] = {"time": names[0], "pose": names[1:4], "run": names[4] if len(names) == 5 else None}
    options |= {"length_unit": unit[0], "angle_unit": unit[1], "yaw_zero": yaw_zero, "clockwise": clockwise}
    return [track for file in files for track in read_tracks(file, **options)]


def _replay_recordings(
    robot: Robot, path: str, *, step: float | None, plot: str | None, output: str | None, as_json: bool
) -> None:
    """Replay every recording of a manifest, and compare each with its runs."""
    trials = read_trials(path, robot)
    if not trials.recordings:
        fix = "only tracked runs are replayed: add [[recordings]]"
        raise InputError("must hold at least one recording", file=path, fix=fix)
    recordings = [with_fitted_clock(robot, recording) for recording in trials.recordings]
    results, compared = _compared(robot, recordings, step)

    cases = list(zip(trials.recordings, recordings, results, compared, strict=True))

    def record(_: Sequence[xr.Dataset]) -> dict[str, Any]:
        records = [
            _record(robot, used, result, errors) | _own_clock(robot, given, used, step)
            for given, used, result, errors in cases
        ]
        return provenance(robot) | {"trials": path, "recordings": records}

    def lines(_: Sequence[xr.Dataset]) -> Iterator[Any]:
        for given, used, result, errors in cases:
            yield from _recording_lines(robot, given, used, result, errors)
        if trials.steady:
            yield f"Not replayed: {counted(len(trials.steady), 'steady run')}."

    emit(
        results,
        record=record,
        lines=lines,
        dataset=lambda results: _tree(trials, results),
        output=output,
        plot=plot,
        figure="hypertuna.trials.plots:plot_recordings",
        drawn=(robot, recordings, results),
        as_json=as_json,
        failed=any(result.attrs["status"] != "completed" for result in results),
    )


def _compared(
    robot: Robot, recordings: Sequence[Recording], step: float | None
) -> tuple[list[xr.Dataset], list[xr.Dataset | None]]:
    """Replay recordings; compare each complete replay with its runs."""
    results = [replay_recording(robot, recording, step=step) for recording in recordings]
    return results, [
        compare_recording(robot, recording, result) if result.attrs["status"] == "completed" else None
        for recording, result in zip(recordings, results, strict=True)
    ]


def _own_clock(robot: Robot, given: Recording, used: Recording, step: float | None) -> dict[str, Any]:
    """Return the source of a time offset; for a fitted one, also the errors with the recording's own."""
    if used is given:
        return {"time_offset_source": "trials"}
    _, (compared,) = _compared(robot, [given], step)
    own = {"time_offset_s": given.time_offset} | _compared_at_border(compared)
    return {"time_offset_source": "fit", "without_fitted_offset": own}


def _end_of(robot: Robot, result: xr.Dataset) -> dict[str, float]:
    """Return when and where a replay ends."""
    x, y, yaw = head_center(robot, result)[-1]
    record = {"time_s": float(result["time"][-1]), "steps": result.sizes["time"] - 1}
    return record | {"head_x_m": x, "head_y_m": y, "head_yaw_deg": np.degrees(yaw)}


def _compared_at_border(compared: xr.Dataset | None) -> dict[str, Any]:
    """Return the errors of a comparison in cm and degrees."""
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


def _end_lines(robot: Robot, result: xr.Dataset) -> Iterator[Any]:
    """Describe the end of a replay."""
    x, y, yaw = head_center(robot, result)[-1]
    yield result.attrs["status_text"]
    place = f"x {x:.4f} m, y {y:.4f} m, facing {np.degrees(yaw):.2f} deg"
    yield f"Center of the head at {float(result['time'][-1]):.3f} s: {place}"


def _error_lines(compared: xr.Dataset | None, names: Sequence[str]) -> Iterator[Any]:
    """Lay out the errors of a replay against its runs."""
    if compared is None:
        return
    rms = f"rmse of {counted(compared.sizes['run'], 'run')}"
    rows = []
    for axis, unit in AXES.items():
        shown, factor = BORDER[unit]
        errors = [float(compared[name].sel(axis=axis)) * (1 if name in RATIOS else factor) for name in names]
        cells = (f"{error:.2f}" if np.isfinite(error) else "one run" for error in errors)
        rows.append([f"{axis} [{shown}]", *cells])
    heads = ["head", *(HEADS[name] or rms for name in names)]
    yield table(heads, rows, left=range(len(heads)))


def _record(robot: Robot, recording: Recording, result: xr.Dataset, compared: xr.Dataset | None) -> dict[str, Any]:
    """Return the JSON record of a replayed recording, without what all recordings share."""
    attrs = {key: value for key, value in result.attrs.items() if key not in (*provenance(robot), "recording")}
    record = {"name": recording.name} | attrs | _end_of(robot, result) | _compared_at_border(compared)
    offsets = {} if compared is None else {"best_time_offset_s": compared.attrs["best_time_offset_s"]}
    return record | {"time_offset_s": recording.time_offset} | offsets


def _recording_lines(
    robot: Robot, given: Recording, recording: Recording, result: xr.Dataset, compared: xr.Dataset | None
) -> Iterator[Any]:
    """Lay out a replayed recording."""
    yield recording.name, "bold"
    yield from _end_lines(robot, result)
    if recording is not given:
        yield f"time offset {recording.time_offset:.3f} s from [fit], in place of {given.time_offset:g} s"
    yield from _error_lines(compared, list(HEADS))
    if compared is not None:
        best = round(compared.attrs["best_time_offset_s"], 3) + 0.0
        yield f"moved: with the best time offset, {best:g} s, in place of {recording.time_offset:.3g} s"
    yield ""


def _tree(trials: Trials, results: Sequence[xr.Dataset]) -> Any:
    """Return trajectories as a tree, one group for each recording."""
    import xarray as xr  # here, because its import takes longer than a swim

    names = (recording.name for recording in trials.recordings)
    groups = {name: result.assign_attrs(command=command_line()) for name, result in zip(names, results, strict=True)}
    return xr.DataTree.from_dict(groups)
