"""The command `hypertuna turn`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar, table
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.gait import KINDS, gait_degrees, gait_grid, gait_text
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.io.files import rows_csv
from hypertuna.swimming.beat import DEFAULT_STEPS, STATUSES
from hypertuna.swimming.gait import Gaits, named_gait
from hypertuna.swimming.turn import Tightest, Turning, gait_at, turn

AROUND = np.linspace(0, 320, 9)  # deg of the last joint group's phase: once around, as in the paper's Fig. 14(b)
MAX_TURNS = 2000  # each is swum a whole circle
ROWS = 40  # that the terminal shows


def turn_command(
    robot: opt.RobotName,
    gait: opt.GaitName = None,
    frequency: opt.Frequencies = None,
    amplitude: Annotated[
        Sequence[tuple[float, ...]] | None,
        opt.ranges("--amplitude", "degrees", f"{opt.RANGE} per joint group in degrees."),
    ] = None,
    phase: opt.Phases = None,
    bias: opt.Biases = None,
    joints: opt.JointLaw = None,
    areas: opt.Areas = None,
    water: opt.WaterLaw = None,
    steps: opt.Steps = DEFAULT_STEPS,
    threads: opt.Threads = None,
    plot: opt.Plot = None,
    output: opt.TableOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Turn by a one-sided beat: radius against phase, bias and frequency, and a circle fitted to each path.

    Without --phase, the phase of the last joint group covers a full turn. The exit code is 0 if a gait turns, 1 if none
    does, 2 for bad input.
    """
    fish = load(robot).using(joints=joints, areas=areas, water=water)
    given = {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias}
    grid = _grid(fish, gait, given)
    with progress_bar("turning") as progress:
        turning = turn(fish, grid, threads=threads, steps=steps, progress=progress)
    straight = turning.tightest is None
    emit(
        turning,
        record=_record,
        lines=_lines,
        csv=_csv,
        dataset=lambda turning: turning.sweep,
        output=None if straight else output,
        plot=None if straight else plot,
        figure="hypertuna.swimming.plots_turn:plot_turn",
        as_json=as_json,
        failed=straight,
    )


def _grid(robot: Robot, gait: str | None, given: dict[str, Sequence[tuple[float, ...]] | None]) -> Gaits:
    """Make every combination of the options."""
    if given["phase"] is None:
        first = named_gait(robot, gait).phase[:-1] if gait is not None else (0.0,) * (len(robot.joints) - 1)
        lags = tuple(round(math.degrees(angle), 10) for angle in first)
        given = given | {"phase": [(*lags, last) for last in AROUND.tolist()]}
    count = math.prod(len(points) for points in given.values() if points is not None)
    if count > MAX_TURNS:
        fix = "give fewer values; `hypertuna sweep` gives the radii of many without fitting circles"
        raise InputError(f"must be at most {MAX_TURNS} in all", key="gaits", value=f"{count}", fix=fix)
    return gait_grid(robot, gait, given)


def _rows(turning: Turning) -> list[dict[str, Any]]:
    """Return every gait of the grid with its turn, names with units."""
    length, data, rows = turning.robot.body.length, turning.sweep, []
    for index in np.ndindex(*data.turn_radius.shape):
        row = data.isel(dict(zip(data.turn_radius.dims, index, strict=True)))
        gait = gait_at(turning.robot, row)
        turns = {
            "turn_radius_m": float(row.turn_radius),
            "turn_radius_bl": float(row.turn_radius) / length,
            "circle_radius_bl": float(row.circle_radius) / length,
            "circle_residual_m": float(row.circle_residual),
            "turn_rate_deg_s": math.degrees(float(row.turn_rate)),
            "turn_per_beat_deg": math.degrees(float(row.turn_rate)) / gait.frequency,
            "speed_m_s": float(row.speed),
            "status": STATUSES[int(row.status)],
        }
        rows.append(gait_degrees(gait) | turns)
    return rows


def _tightest(turning: Turning, one: Tightest | None) -> dict[str, Any] | None:
    """Return the JSON record of a tightest turn."""
    if one is None:
        return None
    length = turning.robot.body.length
    return gait_degrees(one.gait) | {
        "turn_radius_bl": one.radius / length,
        "circle_radius_bl": one.circle.radius / length,
        "circle_residual_m": one.circle.residual,
        "speed_m_s": one.speed,
        "phase_between_deg": math.degrees(one.phase),
        "turn_radius_between_bl": one.min_radius / length,
    }


def _record(turning: Turning) -> dict[str, Any]:
    """Return the JSON record."""
    ends = {"tightest": turning.tightest, "tightest_forward": turning.forward}
    turns = {name: _tightest(turning, one) for name, one in ends.items()}
    return made_by(turning.robot) | turns | {"status_text": _sentences(turning), "turns": _rows(turning)}


def _sentences(turning: Turning) -> list[str]:
    """Describe the tightest turns."""
    if turning.tightest is None:
        return ["No gait turns: give the joints a bias with --bias, or see the statuses with --json."]
    sentences, length = [], turning.robot.body.length
    for one, what in ((turning.tightest, "tightest turn"), (turning.forward, "tightest that swims head first")):
        if one is None:
            sentences.append("No gait that turns swims head first.")
            continue
        between = ""
        if one.phase != one.gait.phase[-1]:
            between = (
                f"; between the phases given, {one.min_radius / length:.3g} BL at {math.degrees(one.phase):.3g} deg"
            )
        at = f"at {math.degrees(one.gait.phase[-1]):.4g} deg, {one.gait.frequency:g} Hz"
        speed = f"{'head' if one.speed > 0 else 'tail'} first at {abs(one.speed):.2g} m/s"
        sentences.append(f"The {what}: {one.radius / length:.3g} BL {at}, {speed}{between}.")
    same = turning.forward is not None and turning.forward.gait == turning.tightest.gait
    return sentences[:1] if same else sentences


def _csv(turning: Turning) -> str:
    """Write the turns as comma-separated values."""
    groups = [group.name for group in turning.robot.joints]
    rows = []
    for row in _rows(turning):
        flat: dict[str, Any] = {"frequency_hz": row.pop("frequency_hz")}
        for key in KINDS:
            flat |= {f"{key}_{name}_deg": a for name, a in zip(groups, row.pop(f"{key}_deg"), strict=True)}
        rows.append(flat | row)
    facts = {str(key): value for key, value in turning.sweep.attrs.items()} | {"command": command_line()}
    return rows_csv(facts, rows)


def _lines(turning: Turning) -> Iterator[Any]:
    """Lay out the turns, and describe the tightest."""
    best, rows = turning.tightest, _rows(turning)
    if best is None:
        yield _sentences(turning)[0], "bold red"
        return
    heads = {"frequency_hz": "f\n[Hz]"} | {f"{key}_deg": f"{key}\n[deg]" for key in KINDS}
    varying = [key for key in heads if any(row[key] != rows[0][key] for row in rows)]
    cells = []
    for row in sorted(rows, key=lambda row: row["turn_radius_m"])[:ROWS] if len(rows) > ROWS else rows:
        angles = (np.atleast_1d(row[key]) for key in varying)
        gait = [", ".join(f"{angle:.4g}" for angle in values) for values in angles]
        radii = (f"{row[key]:.3f}" for key in ("turn_radius_bl", "circle_radius_bl"))
        cells.append((*gait, *radii, f"{row['turn_per_beat_deg']:+.1f}", f"{row['speed_m_s']:+.3f}", row["status"]))
    yield f"{turning.robot.name}, tightest: {gait_text(best.gait)}", "bold"
    yield "radius: mean distance of the nose from the center; circle: fitted to its path", "dim"
    shown = ["radius\n[BL]", "circle\n[BL]", "turn\n[deg/beat]", "speed\n[m/s]", "\nstatus"]
    yield table([*(heads[key] for key in varying), *shown], cells, left=(len(varying) + 4,))
    if len(rows) > ROWS:
        yield f"the {ROWS} tightest of {len(rows)}", "dim"
    yield from _sentences(turning)
