"""The command `hypertuna posture-test`."""

import math
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.twin import kelvin, robot_with
from hypertuna.description.robot import Robot
from hypertuna.io.files import Csv, rows_csv
from hypertuna.io.quantity import ZERO_CELSIUS
from hypertuna.simulation.cards import limit_sentences, posture_rows
from hypertuna.simulation.posture import EASED, MAX_ERROR, PostureTest, posture_test

ANGLE = math.radians(20)  # default peak bend [rad], the paper's
FREQUENCIES: Any = "1:6:6"  # default of --frequency [Hz], as typed


@opt.grouped
def posture_command(
    robot: opt.RobotOptions,
    frequency: Annotated[
        Sequence[float], opt.values("--frequency", "Hz", f"Beat frequencies: {opt.RANGE}.")
    ] = FREQUENCIES,
    angle: Annotated[
        Sequence[float] | None,
        opt.numbers(
            "--angle",
            "degrees",
            "Peak bend to hold, one per joint group; a single value is for all groups that bend that far. "
            "(default: 20, or 9/10 of the maximum bend where that is less)",
        ),
    ] = None,
    duration: opt.Duration = 8,
    medium: opt.Medium = "air",
    temperature: opt.Temperature = None,
    line_bore: opt.Bore = None,
    no_limits: Annotated[
        bool, opt.flag("--no-limits", "Do not search for the largest amplitude at each frequency.")
    ] = False,
    seed: opt.Seed = 0,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Test the posture control from rest to a set peak bend (Fig. 8), and find the largest that each joint holds.

    The exit code is 0 if every joint settles within half a degree, 1 if one does not, 2 for bad input.
    """
    fish = robot_with(robot, line_bore)
    with progress_bar("testing") as progress:
        result = posture_test(
            fish,
            frequencies=list(frequency),
            angle=_angles(fish, angle),
            duration=duration,
            medium=medium,
            temperature=kelvin(temperature),
            seed=seed,
            limits=not no_limits,
            progress=progress,
        )
    emit(
        result,
        record=_record,
        csv=_csv,
        **vars(files),
        failed=any(one.settling is None for one in result.held),
    )


def _angles(robot: Robot, angles: Sequence[float] | None) -> list[float]:
    """Return one angle per joint group [rad]; a single one is for all groups that reach it, 0 for the others."""
    bends = [math.inf if group.bend_max is None else group.bend_max for group in robot.joints]
    targets = [min(ANGLE, EASED * max(bends))] if angles is None else [math.radians(value) for value in angles]
    if len(targets) != 1 or len(robot.joints) == 1:
        return targets
    reach = min(targets[0], max(bends))
    return [targets[0] if bend >= reach else 0.0 for bend in bends]


def _record(result: PostureTest) -> dict[str, Any]:
    """Return the JSON record of a posture test."""
    return {
        "medium": result.medium,
        "duration_s": result.duration,
        "seed": result.seed,
        "within_deg": np.degrees(MAX_ERROR),
        "temperature_c": result.temperature - ZERO_CELSIUS,
        "tests": posture_rows(result),
        "status_text": limit_sentences(result),
    } | made_by(result.robot)


# Columns of a beat in the CSV file -> keys in a row of `posture_rows`.
BEATS = {"time_s": "beat_end_s", "peak_left_deg": "peak_left_deg", "peak_right_deg": "peak_right_deg"}
BEATS |= {"error_deg": "beat_error_deg", "error_measured_deg": "beat_error_measured_deg"}


def _csv(result: PostureTest) -> Csv:
    """Return the CSV table of a posture test, one row per beat."""
    rows = []
    for test in posture_rows(result):
        case = {"frequency_hz": f"{test['frequency_hz']:g}", "joint": test["joint"]}
        case["angle_set_deg"] = f"{test['angle_set_deg']:g}"
        for beat in zip(*(test[key] for key in BEATS.values()), strict=True):
            rows.append(case | {name: f"{value:.6g}" for name, value in zip(BEATS, beat, strict=True)})
    return rows_csv(made_by(result.robot, medium=result.medium, seed=result.seed), rows)
