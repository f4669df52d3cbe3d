"""The command `hypertuna turn`."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import (
    check_suffix,
    command_line,
    print_json,
    progress_bar,
    ranges,
    tell_written,
    whole_number,
)
from hypertuna.cli.old_options import Name, Named, gait_axes, one_gait, spelled
from hypertuna.cli.optimize import Areas, Joints, Water
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.errors import InputError
from hypertuna.io.files import rows_csv, write_atomically, write_netcdf
from hypertuna.swimming.beat import DEFAULT_STEPS, STATUSES
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.sweep import Gaits
from hypertuna.swimming.turn import KINDS, Tightest, Turning, gait_at, turn

__all__ = ["turn_command"]

RANGE = "A value or a range start:stop:count"
AROUND = "0:320:9"  # of the last joint group's phase: once around, as in the paper's Fig. 14(b)
MOST_TURNS = 2000  # each is swum a whole circle
ROWS = 40  # that the terminal shows


def turn_command(
    robot: Name,
    gait: Named = None,
    frequency: Annotated[str | None, typer.Option("--frequency", help=f"{RANGE} in Hz.")] = None,
    amplitude: Annotated[
        str | None, typer.Option("--amplitude", help=f"{RANGE} per joint group in degrees. (default: the gait's)")
    ] = None,
    phase: Annotated[
        str | None,
        typer.Option("--phase", help=f"{RANGE} per joint group in degrees. (default: the last group {AROUND})"),
    ] = None,
    bias: Annotated[
        str | None, typer.Option("--bias", help=f"{RANGE} per joint group in degrees. (default: the gait's)")
    ] = None,
    joints: Joints = None,
    areas: Areas = None,
    water: Water = None,
    steps: Annotated[str, typer.Option("--steps", help="Runge-Kutta steps per beat.")] = str(DEFAULT_STEPS),
    threads: Annotated[str | None, typer.Option("--threads", help="Threads to use (default: all)")] = None,
    plot: Annotated[
        str | None, typer.Option("--plot", help="Draw radius and paths to this .svg, .png or .pdf file.")
    ] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write to this .nc or .csv file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Turn by a one-sided beat: radius against phase, bias and frequency, and a circle fitted to each path.

    The exit code is 0 if a gait turns, 1 if none does, 2 for bad input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish = load(robot).using(joints=joints, areas=areas, water=water)
    grid = _grid(fish, gait, {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias})
    workers = None if threads is None else whole_number(threads, "threads")
    with progress_bar("turning") as progress:
        turning = turn(fish, grid, threads=workers, steps=whole_number(steps, "steps"), progress=progress)
    if turning.tightest is None:
        print_json(_record(turning)) if as_json else Console().print(Text(_sentences(turning)[0], style="bold red"))
        raise typer.Exit(1)
    if plot is not None:
        _plot(turning, plot)
    if output is not None and kind == ".nc":
        write_netcdf(turning.found.assign_attrs(command=command_line()), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(turning).encode())
    if as_json:
        print_json(_record(turning))
    else:
        _print(turning)
        tell_written(plot, output)


def _grid(robot: Robot, gait: str | None, given: dict[str, str | None]) -> Gaits:
    """Make every combination of the options; each value is checked in degrees first."""
    if given["phase"] is None:
        first = named_gait(robot, gait).phase[:-1] if gait is not None else (0.0,) * (len(robot.joints) - 1)
        given = given | {"phase": ",".join([*(f"{math.degrees(angle):.12g}" for angle in first), AROUND])}
    axes = gait_axes(robot, gait, given, ranges)
    for key, values in axes.items():
        for value in values:
            one_gait(axes | {key: [value]})
    count = math.prod(len(values) for values in axes.values())
    if count > MOST_TURNS:
        fix = "take fewer values; `hypertuna sweep` tells the radii of many without fitting circles"
        raise InputError(f"must be at most {MOST_TURNS} in all", key="gaits", value=f"{count}", fix=fix)
    angles = {key: np.radians(axes[key]).tolist() for key in KINDS}
    return Gaits.grid(frequency=[value[0] for value in axes["frequency"]], **angles)


def _rows(turning: Turning) -> list[dict[str, Any]]:
    """Every gait of the grid with its turn, names with units."""
    length, found, rows = turning.robot.body.length, turning.found, []
    for index in np.ndindex(*found.turn_radius.shape):
        row = found.isel(dict(zip(found.turn_radius.dims, index, strict=True)))
        gait = gait_at(turning.robot, row)
        rows.append(
            {"frequency_hz": gait.frequency}
            | {f"{key}_deg": np.degrees(getattr(gait, key)).round(10).tolist() for key in KINDS}
            | {
                "turn_radius_m": float(row.turn_radius),
                "turn_radius_bl": float(row.turn_radius) / length,
                "circle_radius_bl": float(row.circle_radius) / length,
                "circle_residual_m": float(row.circle_residual),
                "turn_rate_deg_s": math.degrees(float(row.turn_rate)),
                "turn_per_beat_deg": math.degrees(float(row.turn_rate)) / gait.frequency,
                "speed_m_s": float(row.speed),
                "status": STATUSES[int(row.status)],
            }
        )
    return rows


def _tightest(turning: Turning, one: Tightest | None) -> dict[str, Any] | None:
    """Say a tightest turn."""
    if one is None:
        return None
    length = turning.robot.body.length
    return {
        "frequency_hz": one.gait.frequency,
        **{f"{key}_deg": np.degrees(getattr(one.gait, key)).round(10).tolist() for key in KINDS},
        "turn_radius_bl": one.radius / length,
        "circle_radius_bl": one.circle.radius / length,
        "circle_residual_m": one.circle.residual,
        "speed_m_s": one.speed,
        "phase_between_deg": math.degrees(one.phase),
        "turn_radius_between_bl": one.least / length,
    }


def _record(turning: Turning) -> dict[str, Any]:
    """Tell the turns, for programs."""
    ends = {"tightest": turning.tightest, "tightest_forward": turning.forward}
    made_by = provenance(turning.robot) | {"command": command_line()}
    told = {name: _tightest(turning, one) for name, one in ends.items()}
    return made_by | told | {"status_text": _sentences(turning), "turns": _rows(turning)}


def _sentences(turning: Turning) -> list[str]:
    """Say the tightest turns."""
    if turning.tightest is None:
        return ["No gait turns: give the joints a bias with --bias, or see the statuses with --json."]
    texts = []
    for one, what in ((turning.tightest, "tightest turn"), (turning.forward, "tightest that swims head first")):
        if one is None:
            texts.append("No gait that turns swims head first.")
            continue
        length, way = turning.robot.body.length, "head first" if one.speed > 0 else "tail first"
        between = ""
        if one.phase != one.gait.phase[-1]:
            between = f"; between the phases given, {one.least / length:.3g} BL at {math.degrees(one.phase):.3g} deg"
        at = f"at {math.degrees(one.gait.phase[-1]):.4g} deg, {one.gait.frequency:g} Hz"
        texts.append(f"The {what}: {one.radius / length:.3g} BL {at}, {way} at {abs(one.speed):.2g} m/s{between}.")
    same = turning.forward is not None and turning.forward.gait == turning.tightest.gait
    return texts[:1] if same else texts


def _csv(turning: Turning) -> str:
    """Write the turns as comma-separated values, below comments that say what made them."""
    groups = [group.name for group in turning.robot.joints]
    rows = []
    for row in _rows(turning):
        flat: dict[str, Any] = {"frequency_hz": row.pop("frequency_hz")}
        for key in KINDS:
            flat |= {f"{key}_{name}_deg": a for name, a in zip(groups, row.pop(f"{key}_deg"), strict=True)}
        rows.append(flat | row)
    facts = {str(key): value for key, value in turning.found.attrs.items()} | {"command": command_line()}
    return rows_csv(facts, rows)


def _plot(turning: Turning, plot: str) -> None:
    """Draw the turns; what draws is imported only now, because that takes longer than the turns."""
    from hypertuna.figures import save
    from hypertuna.swimming.plots_turn import plot_turn

    save(plot_turn(turning), plot)


def _print(turning: Turning) -> None:
    """Print the turns as a table, and what stands out of them."""
    console, rows = Console(), _rows(turning)
    best = turning.tightest
    assert best is not None  # or there was nothing to print
    varying = [
        key for key in ("frequency_hz", *(f"{k}_deg" for k in KINDS)) if any(r[key] != rows[0][key] for r in rows)
    ]
    table = Table(box=None, pad_edge=False, header_style="bold")
    heads = {"frequency_hz": "f\n[Hz]"} | {f"{key}_deg": f"{key}\n[deg]" for key in KINDS}
    shown = ["radius\n[BL]", "circle\n[BL]", "turn\n[deg/beat]", "speed\n[m/s]"]
    for head in (*(heads[key] for key in varying), *shown):
        table.add_column(Text(head, justify="right"), justify="right")
    table.add_column("\nstatus", no_wrap=True)
    for row in sorted(rows, key=lambda r: r["turn_radius_m"])[:ROWS] if len(rows) > ROWS else rows:
        angles = (row[key] if isinstance(row[key], list) else [row[key]] for key in varying)
        cells = [", ".join(f"{angle:.4g}" for angle in values) for values in angles]
        radii = (f"{row[key]:.3f}" for key in ("turn_radius_bl", "circle_radius_bl"))
        table.add_row(*cells, *radii, f"{row['turn_per_beat_deg']:+.1f}", f"{row['speed_m_s']:+.3f}", row["status"])
    console.print(Text(f"{turning.robot.name}, tightest: {spelled(best.gait)}", style="bold"))
    console.print(Text("radius: mean distance of the nose from the center; circle: fitted to its path", style="dim"))
    console.print(table)
    if len(rows) > ROWS:
        console.print(Text(f"the {ROWS} tightest of {len(rows)}", style="dim"))
    for sentence in _sentences(turning):
        console.print(Text(sentence))
