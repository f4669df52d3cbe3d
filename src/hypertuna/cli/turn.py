"""The command `hypertuna turn`."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.gait import GaitOptions, column_rows
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.files import Csv, columns_csv, coordinate_names, variable_columns
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.swimming.cards_sweep import turn_columns, turn_sentences
from hypertuna.swimming.gait import Gaits, gait_degrees, named_gait
from hypertuna.swimming.turn import Tightest, Turning, turn

PHASES = np.linspace(0, 320, 9)  # deg, phase of the last joint group, as in the paper's Fig. 14(b)
MAX_TURNS = 2000  # gaits of one call: each swims a whole circle


@opt.grouped
def turn_command(
    robot: opt.ModelOptions,
    gaits: GaitOptions,
    steps: opt.Steps = DEFAULT_STEPS,
    threads: opt.Threads = None,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Turn by a one-sided beat: radius against phase, bias and frequency, and a circle fitted to each path.

    Without --phase, the phase of the last joint group covers a full turn. The exit code is 0 if a gait turns, 1 if none
    does, 2 for bad input.
    """
    subject = robot.load()
    grid = _grid(subject, gaits)
    with progress_bar("turning") as progress:
        turning = turn(subject, grid, threads=threads, steps=steps, progress=progress)
    straight = turning.tightest is None
    emit(
        turning,
        record=_record,
        csv=_csv,
        dataset=lambda turning: turning.sweep,
        **vars(opt.Files(as_json=files.as_json) if straight else files),
        failed=straight,
    )


def _grid(robot: Robot, options: GaitOptions) -> Gaits:
    """Return the grid of the options' values; without --phase, the last joint group's phase takes PHASES."""
    if options.phase is None:
        first = (0.0,) * (len(robot.joints) - 1) if options.gait is None else named_gait(robot, options.gait).phase[:-1]
        lags = tuple(round(math.degrees(angle), 10) for angle in first)
        options = replace(options, phase=[[(*lags, last) for last in PHASES.tolist()]])
    count = math.prod(map(len, options.given.values()))
    if count > MAX_TURNS:
        fix = "give fewer values; `hypertuna sweep` gives the radii of many without fitting circles"
        raise InputError(f"must be at most {MAX_TURNS}", key="the number of gaits", value=f"{count}", fix=fix)
    return options.grid(robot)


def _csv(turning: Turning) -> Csv:
    """Return the CSV table of the grid's gaits with their turns."""
    gaits = variable_columns(turning.sweep, coordinate_names(turning.sweep))
    facts = turning.sweep.attrs | {"command": command_line()}
    return columns_csv(facts, gaits | turn_columns(turning), digits=None)


def _rows(turning: Turning) -> list[dict[str, Any]]:
    """Return a row for each gait of the grid, with its turn."""
    rows = column_rows(turn_columns(turning))
    return [gait_degrees(gait) | row for gait, row in zip(turning.gaits, rows, strict=True)]


def _tightest(one: Tightest | None, length: float) -> dict[str, Any] | None:
    """Return the JSON record of a tightest turn."""
    if one is None:
        return None
    return gait_degrees(one.gait) | {
        "turn_radius_bl": one.turn_radius / length,
        "circle_radius_bl": one.circle.radius / length,
        "circle_residual_m": one.circle.residual,
        "speed_m_s": one.speed,
        "phase_between_deg": math.degrees(one.phase_between),
        "turn_radius_between_bl": one.turn_radius_between / length,
    }


def _record(turning: Turning) -> dict[str, Any]:
    """Return the JSON record of the turns."""
    length = turning.robot.body.length
    return made_by(turning.robot) | {
        "tightest": _tightest(turning.tightest, length),
        "tightest_forward": _tightest(turning.forward, length),
        "status_text": list(turn_sentences(turning)),
        "turns": _rows(turning),
    }
