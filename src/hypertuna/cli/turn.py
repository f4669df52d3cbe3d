"""The command `hypertuna turn`."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar, table
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.gait import GaitOptions, column_rows, gait_degrees, gait_text
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.files import Csv, columns_csv, coordinate_names, variable_columns
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.swimming.gait import KINDS, Gaits, named_gait
from hypertuna.swimming.turn import Tightest, Turning, turn

AROUND = np.linspace(0, 320, 9)  # deg of the last joint group's phase: once around, as in the paper's Fig. 14(b)
MAX_TURNS = 2000  # each is swum a whole circle
ROWS = 40  # that the terminal shows


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
        lines=_lines,
        csv=_csv,
        dataset=lambda turning: turning.sweep,
        figure="hypertuna.swimming.plots_turn:plot_turn",
        **vars(opt.Files(as_json=files.as_json) if straight else files),
        failed=straight,
    )


def _grid(robot: Robot, options: GaitOptions) -> Gaits:
    """Make every combination of the options."""
    if options.phase is None:
        first = (0.0,) * (len(robot.joints) - 1) if options.gait is None else named_gait(robot, options.gait).phase[:-1]
        lags = tuple(round(math.degrees(angle), 10) for angle in first)
        options = replace(options, phase=[[(*lags, last) for last in AROUND.tolist()]])
    count = math.prod(map(len, options.given.values()))
    if count > MAX_TURNS:
        fix = "give fewer values; `hypertuna sweep` gives the radii of many without fitting circles"
        raise InputError(f"must be at most {MAX_TURNS}", key="the number of gaits", value=f"{count}", fix=fix)
    return options.grid(robot)


def _columns(turning: Turning) -> dict[str, Any]:
    """Return the turn of every gait of the grid, names with units."""
    length = turning.robot.body.length
    names = ("frequency", "turn_radius", "circle_radius", "circle_residual", "turn_rate", "speed", "status")
    columns = variable_columns(turning.sweep, names)
    rate = np.degrees(columns["turn_rate_rad_s"])
    return {
        "turn_radius_m": columns["turn_radius_m"],
        "turn_radius_bl": columns["turn_radius_m"] / length,
        "circle_radius_bl": columns["circle_radius_m"] / length,
        "circle_residual_m": columns["circle_residual_m"],
        "turn_rate_deg_s": rate,
        "turn_per_beat_deg": rate / columns["frequency_hz"],
        "speed_m_s": columns["speed_m_s"],
        "status": columns["status"],
    }


def _csv(turning: Turning) -> Csv:
    """Write the gaits of the grid with their turns as comma-separated values."""
    gaits = variable_columns(turning.sweep, coordinate_names(turning.sweep))
    facts = turning.sweep.attrs | {"command": command_line()}
    return columns_csv(facts, gaits | _columns(turning), digits=None)


def _rows(turning: Turning) -> list[dict[str, Any]]:
    """Return every gait of the grid with its turn."""
    rows = column_rows(_columns(turning))
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
    """Return the JSON record."""
    length = turning.robot.body.length
    return made_by(turning.robot) | {
        "tightest": _tightest(turning.tightest, length),
        "tightest_forward": _tightest(turning.forward, length),
        "status_text": list(_sentences(turning)),
        "turns": _rows(turning),
    }


def _sentences(turning: Turning) -> Iterator[str]:
    """Describe the tightest turns."""
    if turning.tightest is None:
        yield "No gait turns: give the joints a bias with --bias, or see the statuses with --json."
        return
    length = turning.robot.body.length
    yield _sentence("tightest turn", turning.tightest, length)
    if turning.forward is None:
        yield "No gait that turns swims head first."
    elif turning.forward.gait != turning.tightest.gait:
        yield _sentence("tightest that swims head first", turning.forward, length)


def _sentence(what: str, one: Tightest, length: float) -> str:
    """Describe a turn."""
    at = f"at {math.degrees(one.gait.phase[-1]):.4g} deg, {one.gait.frequency:g} Hz"
    speed = f"{'head' if one.speed > 0 else 'tail'} first at {abs(one.speed):.2g} m/s"
    phase = math.degrees(one.phase_between)
    between = f"; between the phases given, {one.turn_radius_between / length:.3g} BL at {phase:.3g} deg"
    same = one.phase_between == one.gait.phase[-1]
    return f"The {what}: {one.turn_radius / length:.3g} BL {at}, {speed}{'' if same else between}."


def _lines(turning: Turning) -> Iterator[Any]:
    """Lay out the turns, and describe the tightest."""
    best, rows = turning.tightest, _rows(turning)
    if best is None:
        yield from ((sentence, "bold red") for sentence in _sentences(turning))
        return
    heads = {"frequency_hz": "f\n[Hz]"} | {f"{key}_deg": f"{key}\n[deg]" for key in KINDS}
    varying = [key for key in heads if any(row[key] != rows[0][key] for row in rows)]
    cells = []
    for row in sorted(rows, key=lambda row: row["turn_radius_m"])[:ROWS] if len(rows) > ROWS else rows:
        angles = (np.atleast_1d(row[key]) for key in varying)
        gait = [", ".join(f"{angle:.4g}" for angle in values) for values in angles]
        radii = (f"{row[key]:.3f}" for key in ("turn_radius_bl", "circle_radius_bl"))
        cells.append((*gait, *radii, f"{row['turn_per_beat_deg']:+z.1f}", f"{row['speed_m_s']:+z.3f}", row["status"]))
    yield f"{turning.robot.name}, tightest: {gait_text(best.gait)}", "bold"
    yield "radius: mean distance of the nose from the center; circle: fitted to its path", "dim"
    shown = ["radius\n[BL]", "circle\n[BL]", "turn\n[deg/beat]", "speed\n[m/s]", "\nstatus"]
    yield table([*(heads[key] for key in varying), *shown], cells, left=(len(varying) + 4,))
    if len(rows) > ROWS:
        yield f"the {ROWS} tightest of {len(rows)}", "dim"
    yield from _sentences(turning)
