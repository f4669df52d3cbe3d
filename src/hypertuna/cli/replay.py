"""The command `hypertuna replay`: one series of joint angles, or every recording of a manifest."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import attended, command_line, progress_bar
from hypertuna.cli.emit import emit
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.io.door import opened
from hypertuna.io.quantity import counted
from hypertuna.ranges import NOT_NEGATIVE
from hypertuna.trials.comparison import compare_recording, replay_recording, with_fitted_clock
from hypertuna.trials.kinds import kind_of
from hypertuna.trials.manifest import Recording
from hypertuna.trials.reach import outside, swim_of_series
from hypertuna.trials.replay import AXES, BORDER, Pose, check_replay, head_center, replay, rmse
from hypertuna.trials.smoothing import SmoothSeries, smooth
from hypertuna.trials.tracks import JointSeries, Track, read_joints, read_tracks
from hypertuna.trials.trials import read_trials

if TYPE_CHECKING:
    import xarray as xr

COMPARED = ("rmse", "mean_rmse", "repeatability")  # columns printed for a CSV file of angles
# Variable of a comparison -> head of its column on the terminal.
HEADS = {
    "rmse": "",
    "mean_rmse": "of their mean",
    "repeatability": "repeatability",
    "ratio": "ratio",
    "best_offset_rmse": "moved",
    "best_offset_ratio": "ratio",
}
RATIOS = ("ratio", "best_offset_ratio")  # without unit
# Parameters that may be given together with a manifest.
WITH_MANIFEST = ("angles", "robot", "changes", "step", "water", "plot", "output", "as_json")


@dataclass(frozen=True)
class SeriesOptions:
    """Joint angles in a CSV file."""

    columns: Annotated[
        str, opt.text("--columns", "Columns of angles in a CSV file, one per joint group, separated by commas.")
    ] = ""
    time_column: Annotated[str, opt.text("--time-column", "Column of time in s.")] = "time_s"
    unit: Annotated[str, opt.text("--unit", "Unit of the angles: deg or rad.")] = "deg"
    noise: Annotated[
        float | None,
        opt.number(
            "--noise", "degrees", "Noise (sd) of the angles in degrees. (default: estimated)", limits=NOT_NEGATIVE
        ),
    ] = None

    def read(self, path: str) -> JointSeries:
        """Return the joint angles of a CSV file, read as the options say."""
        if not self.columns:
            opened(path, "csv").close()  # a wrong path is the first mistake
            fix = "name the columns of angles, or give a manifest"
            raise InputError("is required with a CSV file", key="--columns", fix=fix)
        return read_joints(path, time=self.time_column, columns=_names(self.columns), unit=self.unit)

    def smooth(self, measured: JointSeries) -> SmoothSeries:
        """Return smoothed joint angles, for the noise that the options give."""
        return smooth(measured, noise=None if self.noise is None else math.radians(self.noise))


@dataclass(frozen=True)
class PoseOptions:
    """Tracked poses in CSV files."""

    poses: Annotated[
        list[str] | None,
        opt.text("--poses", "CSV file of tracked poses of the head link's center; repeatable.", "FILE"),
    ] = None
    pose_columns: Annotated[
        str, opt.text("--pose-columns", "Columns of time, x, y, yaw and, where there are several, the run.")
    ] = "time_s,x_m,y_m,yaw_deg"
    pose_units: Annotated[str, opt.text("--pose-units", "Units of x and y, and of yaw.")] = "m,deg"
    yaw_zero: Annotated[
        float, opt.number("--yaw-zero", "degrees", "Direction of yaw 0 in degrees, counter-clockwise from x.")
    ] = 0
    clockwise: Annotated[bool, opt.flag("--yaw-clockwise", "Yaw is clockwise, from y to x.")] = False

    def read(self) -> list[Track]:
        """Return the tracked runs of every file of poses."""
        names, unit = _names(self.pose_columns), _names(self.pose_units)
        if len(names) not in (4, 5):
            fix = "name the columns of time, x, y, yaw and, if there is one, the run"
            raise InputError("must be 4 or 5 names", key="--pose-columns", value=self.pose_columns, fix=fix)
        if len(unit) != 2:
            fix = "write, for example, cm,deg"
            raise InputError("must be two units", key="--pose-units", value=self.pose_units, fix=fix)
        options: dict[str, Any] = {"time": names[0], "pose": names[1:4], "run": names[4] if len(names) == 5 else None}
        options |= {"length_unit": unit[0], "angle_unit": unit[1]}
        options |= {"yaw_zero": math.radians(self.yaw_zero), "clockwise": self.clockwise}
        return [track for file in self.poses or [] for track in read_tracks(file, **options)]


@opt.grouped
def replay_command(
    context: typer.Context,
    angles: Annotated[
        str,
        typer.Argument(
            help="CSV file of measured joint angles; or a manifest (.toml) or folder of tracked recordings."
        ),
    ],
    robot: opt.RobotOptions,
    series: SeriesOptions,
    poses: PoseOptions,
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
    plot: opt.Plot = None,
    output: Annotated[str | None, opt.file("--output", "the trajectory", ".nc")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Swim measured joint angles, and compare the head's track with tracked poses.

    A manifest holds columns, units, axes, clocks and start; only --step, --water, --plot, --output and --json go with
    it. A time offset in the robot's [fit] replaces that of the recording. Exit code 1 means that a replay diverged.
    """
    fish = robot.load().using(water=water)
    if angles.lower().endswith(".toml") or os.path.isdir(angles):
        for parameter in context.command.params:
            source = str(context.get_parameter_source(parameter.name or ""))
            if source.endswith("COMMANDLINE") and parameter.name not in WITH_MANIFEST:
                key, fix = max(parameter.opts, key=len), "leave it out, or give a CSV file of joint angles"
                raise InputError("cannot be combined with a manifest or a folder", key=key, fix=fix)
        _replay_recordings(fish, angles, step=step, plot=plot, output=output, as_json=as_json)
        return
    measured, tracks = series.read(angles), poses.read()
    check_replay(fish, measured, step)
    if measured.angle.shape[1] == len(fish.joints):
        opt.with_rigid_hinge(fish)
    x, y, heading = start
    options: dict[str, Any] = {"step": step, "current": tuple(current), "time_offset": time_offset}
    options["start"] = Pose(x, y, np.radians(heading))
    curve = attended("smoothing", lambda: series.smooth(measured))
    result = attended("replaying", lambda: replay(fish, curve, **options))
    completed = result.attrs["status"] == "completed"
    compared = rmse(fish, result, tracks) if tracks and completed else None
    noise_deg = {"joint_noise_deg": np.degrees(curve.noise)}
    warnings = [] if fish.fit is None else outside(fish, **swim_of_series(curve))
    emit(
        result,
        record=lambda data: (
            dict(data.attrs) | noise_deg | _end_of(fish, data) | _compared_at_border(compared) | {"warnings": warnings}
        ),
        lines=lambda data: [
            *_end_lines(fish, data),
            *_error_lines(compared, COMPARED),
            *((warning, "yellow") for warning in warnings),
        ],
        output=output,
        plot=plot,
        figure=lambda result: _figures().plot_replay(fish, result, tracks),
        as_json=as_json,
        failed=not completed,
    )


def _figures() -> Any:
    """Return the module that plots replays; it is imported late because the import is slow."""
    from hypertuna.trials import plots

    return plots


def _names(text: str) -> list[str]:
    """Return the names in a text, separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


@dataclass(frozen=True)
class _Case:
    """A replayed recording."""

    given: Recording
    used: Recording  # with the time offset of the robot's [fit], if it has one
    result: xr.Dataset
    compared: xr.Dataset | None  # comparison with the tracked runs; None if the replay diverged

    @classmethod
    def make(cls, robot: Robot, given: Recording, used: Recording, step: float | None) -> Self:
        """Replay a recording, and return the replay with its comparison to the recording's runs."""
        result = replay_recording(robot, used, step=step)
        completed = result.attrs["status"] == "completed"
        return cls(given, used, result, compare_recording(robot, used, result) if completed else None)

    def record(self, robot: Robot, step: float | None) -> dict[str, Any]:
        """Return the JSON record of a recording, without the facts that all recordings share."""
        attrs = {key: value for key, value in self.result.attrs.items() if key not in (*provenance(robot), "recording")}
        record = {"name": self.used.name} | attrs | _end_of(robot, self.result) | _compared_at_border(self.compared)
        record["time_offset_s"] = self.used.time_offset
        record["warnings"] = self.outside(robot)
        if self.compared is not None:
            record["best_time_offset_s"] = self.compared.attrs["best_time_offset_s"]
        if self.used is self.given:
            return record | {"time_offset_source": "trials"}
        unshifted = _compared_at_border(_Case.make(robot, self.given, self.given, step).compared)
        without = {"time_offset_s": self.given.time_offset} | unshifted
        return record | {"time_offset_source": "fit", "without_fitted_offset": without}

    def outside(self, robot: Robot) -> list[str]:
        """Return sentences on where the recording lies outside the runs that the coefficients were fitted to."""
        return outside(robot, **kind_of(self.used).motion(self.used)) if robot.fit is not None else []

    def lines(self, robot: Robot) -> Iterator[Any]:
        """Yield the lines that the terminal prints for the replay."""
        yield self.used.name, "bold"
        yield from _end_lines(robot, self.result)
        yield f"begin: {self.result.attrs['begin']}"
        for warning in self.outside(robot):
            yield warning, "yellow"
        offset = self.used.time_offset
        if self.used is not self.given:
            yield f"time offset {offset:.3f} s from [fit], in place of {self.given.time_offset:g} s"
        yield from _error_lines(self.compared, list(HEADS))
        if self.compared is not None:
            best = round(self.compared.attrs["best_time_offset_s"], 3) + 0.0
            yield f"moved: with the best time offset, {best:g} s, in place of {offset:.3g} s"
        yield ""


def _replay_recordings(
    robot: Robot, path: str, *, step: float | None, plot: str | None, output: str | None, as_json: bool
) -> None:
    """Replay every recording of a manifest, and compare each with its runs."""
    trials = read_trials(path, robot)
    if not trials.recordings:
        fix = "only tracked runs are replayed: add [[recordings]]"
        raise InputError("must hold at least one recording", file=path, fix=fix)
    if not all(recording.hinges for recording in trials.recordings):
        opt.with_rigid_hinge(robot)
    cases = []
    with progress_bar("replaying") as progress:
        for given in trials.recordings:
            cases.append(_Case.make(robot, given, with_fitted_clock(robot, given), step))
            progress(len(cases), len(trials.recordings))
    others = {kind.label: len(members) for kind, members in trials.kinds.items() if kind.trial is not Recording}
    notes = [f"Not replayed: {counted(count, label)}." for label, count in others.items()]
    emit(
        cases,
        record=lambda cases: (
            provenance(robot) | {"trials": path, "recordings": [case.record(robot, step) for case in cases]}
        ),
        lines=lambda cases: [*(line for case in cases for line in case.lines(robot)), *notes],
        dataset=_tree,
        output=output,
        plot=plot,
        figure=lambda cases: _figures().plot_recordings(
            robot, [case.used for case in cases], [case.result for case in cases]
        ),
        as_json=as_json,
        failed=any(case.compared is None for case in cases),
    )


def _end_of(robot: Robot, result: xr.Dataset) -> dict[str, float]:
    """Return the JSON record of a replay's end: its time [s], and the head's place [m] and yaw [deg]."""
    x, y, yaw = head_center(robot, result)[-1]
    record = {"time_s": float(result["time"][-1]), "steps": result.sizes["time"] - 1}
    return record | {"head_x_m": x, "head_y_m": y, "head_yaw_deg": np.degrees(yaw)}


def _compared_at_border(compared: xr.Dataset | None) -> dict[str, Any]:
    """Return the JSON record of a comparison: the errors of each axis in cm or degrees, and the ratios."""
    if compared is None:
        return {}
    axes: dict[str, dict[str, Any]] = {}
    for axis, unit in AXES.items():
        displayed, factor = BORDER[unit]
        for name in (name for name in (*HEADS, "run_rmse") if name in compared):
            errors = compared[name].sel(axis=axis).to_numpy()
            ratio = name in RATIOS
            axes.setdefault(axis, {})[name if ratio else f"{name}_{displayed}"] = errors if ratio else errors * factor
    return {"axes": axes, "runs": compared["run"].to_numpy(), "frames": compared["frames"].to_numpy()}


def _end_lines(robot: Robot, result: xr.Dataset) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a replay's end."""
    end = _end_of(robot, result)
    yield result.attrs["status_text"]
    place = f"x {end['head_x_m']:.4f} m, y {end['head_y_m']:.4f} m, facing {end['head_yaw_deg']:.2f} deg"
    yield f"Center of the head at {end['time_s']:.3f} s: {place}"


def _error_lines(compared: xr.Dataset | None, names: Sequence[str]) -> Iterator[Any]:
    """Yield the table of errors of a replay, compared with its runs."""
    if compared is None:
        return
    rows = []
    for axis, errors in _compared_at_border(compared)["axes"].items():
        unit = BORDER[AXES[axis]][0]
        values = (float(errors[name if name in RATIOS else f"{name}_{unit}"]) for name in names)
        rows.append([f"{axis} [{unit}]", *(f"{number:.2f}" if np.isfinite(number) else "one run" for number in values)])
    heads = ["head", *(HEADS[name] or f"rmse of {counted(compared.sizes['run'], 'run')}" for name in names)]
    yield Table(heads, rows, left=range(len(heads)))


def _tree(cases: Sequence[_Case]) -> Any:
    """Return the trajectories of replays as a DataTree, one group for each recording."""
    import xarray as xr  # imported here, because the import takes longer than a swim

    return xr.DataTree.from_dict({case.given.name: case.result.assign_attrs(command=command_line()) for case in cases})
