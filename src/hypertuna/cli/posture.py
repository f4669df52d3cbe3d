"""The command `hypertuna posture-test`."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna import _core
from hypertuna.actuation.hydraulics import ZERO_CELSIUS
from hypertuna.cli.old_console import (
    check_suffix,
    command_line,
    number,
    number_list,
    print_json,
    progress_bar,
    ranges,
    tell_written,
    whole_number,
)
from hypertuna.cli.old_options import MEDIA, Bore, Medium, Name, Seed, Temperature, celsius, choice, robot_of
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.io.files import rows_csv, write_atomically, write_netcdf
from hypertuna.simulation.posture_test import CLOSE, EASED, PostureTest, posture_test

__all__ = ["posture_command"]

CAVITATED = "the oil cavitated in a cylinder"
USUAL = math.radians(20)  # the paper's angle


def posture_command(
    robot: Name,
    frequency: Annotated[
        str, typer.Option("--frequency", help="Beat frequencies in Hz: values or ranges start:stop:count.")
    ] = "1:6:6",
    angle: Annotated[
        str | None,
        typer.Option(
            "--angle",
            help="Peak bend to hold in degrees, one value per joint group; a single one is for those that bend so far."
            " (default: 20, or 9/10 of the largest bend where that is less)",
        ),
    ] = None,
    duration: Annotated[str, typer.Option("--duration", help="Length of each run in s.")] = "8",
    medium: Medium = "air",
    temperature: Temperature = None,
    line_bore: Bore = None,
    no_limits: Annotated[
        bool, typer.Option("--no-limits", help="Do not look for the largest amplitude at each frequency.")
    ] = False,
    seed: Seed = "0",
    plot: Annotated[str | None, typer.Option("--plot", help="Draw the test to this .svg, .png or .pdf file.")] = None,
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write the beats to this .nc or .csv file.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Test the posture control: from rest to a set peak bend, and the largest that each joint holds (Fig. 8).

    The exit code is 0 if every joint settles within half a degree, 1 if one does not, 2 for bad input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish = robot_of(robot, line_bore)
    with progress_bar("testing") as progress:
        done = posture_test(
            fish,
            frequencies=_frequencies(frequency),
            angle=_angles(fish, angle),
            duration=number(duration, "--duration", "seconds"),
            fish_in=choice(medium, MEDIA, "--medium"),
            temperature=celsius(temperature),
            seed=whole_number(seed, "--seed"),
            limits=not no_limits,
            progress=progress,
        )
    if output is not None and kind == ".nc":
        write_netcdf(done.dataset().assign_attrs(command=command_line()), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(done).encode())
    if plot is not None:
        _plot(done, plot)
    if as_json:
        print_json(_record(done))
    else:
        _print(done)
        tell_written(output, plot)
    if any(one.settling is None for one in done.held):
        raise typer.Exit(1)


def _frequencies(text: str) -> list[float]:
    """Read frequencies: values and ranges one after another."""
    return [value[0] for part in text.split(",") for value in ranges(part, "--frequency", "Hz")]


def _angles(robot: Robot, text: str | None) -> list[float]:
    """Read one angle per joint group; a single one is for those that bend so far, else for the one that bends most."""
    bends = [math.inf if group.bend_max is None else group.bend_max for group in robot.joints]
    values = [min(USUAL, EASED * max(bends))]
    if text is not None:
        values = [math.radians(value) for value in number_list(text, "--angle", "degrees")]
    if len(values) != 1 or len(robot.joints) == 1:
        return values
    least = min(values[0], max(bends))
    return [values[0] if bend >= least else 0.0 for bend in bends]


def _rows(done: PostureTest) -> list[dict[str, Any]]:
    """Say how each joint group did at each frequency."""
    far = {(one.joint, one.frequency): one for one in done.reach}
    eased = {(one.joint, one.frequency): one for one in done.eased}
    rows = []
    for one in done.held:
        most = far.get((one.joint, one.frequency))
        row: dict[str, Any] = {
            "frequency_hz": one.frequency,
            "joint": one.name,
            "angle_set_deg": np.degrees(one.angle),
            "settling_s": one.settling,
            "settling_measured_s": one.measured_settling,
            "error_deg": np.degrees(one.error[-1]),
            "error_measured_deg": np.degrees(one.measured_error[-1]),
            "limits": list(one.limits),
        }
        if most is not None:
            row |= {"largest_amplitude_deg": np.degrees(most.amplitude), "stopped_by": list(most.limits)}
        if (less := eased.get((one.joint, one.frequency))) is not None:
            row |= {"reachable_angle_deg": np.degrees(less.angle), "reachable_settling_s": less.settling}
        rows.append(row)
    return rows


def _record(done: PostureTest) -> dict[str, Any]:
    """Tell a test, for programs."""
    beats = [
        {
            "beat_end_s": one.time,
            "peak_left_deg": np.degrees(one.peaks[:, 0]),
            "peak_right_deg": np.degrees(one.peaks[:, 1]),
            "beat_error_deg": np.degrees(one.error),
            "beat_error_measured_deg": np.degrees(one.measured_error),
        }
        for one in done.held
    ]
    rows = [row | more for row, more in zip(_rows(done), beats, strict=True)]
    facts = {"medium": done.fish_in, "duration_s": done.duration, "seed": done.seed, "within_deg": np.degrees(CLOSE)}
    return (
        facts
        | {"oil_temperature_c": done.temperature - ZERO_CELSIUS, "tests": rows}
        | {
            "status_text": _sentences(done),
            "command": command_line(),
        }
        | provenance(done.robot)
    )


def _csv(done: PostureTest) -> str:
    """Write one row per beat as comma-separated values, below comments that say what made it."""
    facts = provenance(done.robot) | {"medium": done.fish_in, "seed": done.seed, "command": command_line()}
    names = ("peak_left_deg", "peak_right_deg", "error_deg", "error_measured_deg")
    rows = []
    for one in done.held:
        angles = np.degrees(np.column_stack([one.peaks, one.error, one.measured_error]))
        case = {
            "frequency_hz": f"{one.frequency:g}",
            "joint": one.name,
            "angle_set_deg": f"{math.degrees(one.angle):g}",
        }
        for time, row in zip(one.time, angles, strict=True):
            beat = dict(zip(("time_s", *names), (time, *row), strict=True))
            rows.append(case | {name: f"{value:.6g}" for name, value in beat.items()})
    return rows_csv(facts, rows)


def _plot(done: PostureTest, plot: str) -> None:
    """Draw a test; what draws is imported only now, because that takes long."""
    from hypertuna.figures import save
    from hypertuna.simulation.plots import plot_posture

    save(plot_posture(done), plot)


def _first(limits: list[str]) -> str:
    """Name the limit that acted most, and how many more did."""
    more = f" +{len(limits) - 1}" if len(limits) > 1 else ""
    return f"{limits[0].replace('_', ' ')}{more}" if limits else "–"


def _sentences(done: PostureTest) -> list[str]:
    """Say what each limit that acted means."""
    texts = {name: text for name, _, text in _core.condition_table()} | {"cavitation": CAVITATED}
    limits = [one.limits for one in done.held] + [one.limits for one in done.reach]
    acted = dict.fromkeys(name for names in limits for name in names)
    return [f"{name.replace('_', ' ').capitalize()}: {texts[name]}." for name in acted]


def _print(done: PostureTest) -> None:
    """Print a test as a table, a row for each frequency and joint."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column(Text("f\n[Hz]", justify="right"), justify="right")
    table.add_column("\njoint")
    for head in ("set\n[deg]", "settles\n[s]", "error\n[deg]"):
        table.add_column(Text(head, justify="right"), justify="right")
    table.add_column("\nheld back by")
    if done.reach:
        table.add_column(Text("holds up to\n[deg]", justify="right"), justify="right")
        table.add_column("\nthen stopped by")
    for row in _rows(done):
        settles = "never" if row["settling_s"] is None else f"{row['settling_s']:.2f}"
        cells = [
            f"{row['frequency_hz']:g}",
            row["joint"],
            f"{row['angle_set_deg']:g}",
            settles,
            f"{row['error_deg']:.2f}",
        ]
        cells.append(_first(row["limits"]))
        if done.reach:
            cells += [f"{row['largest_amplitude_deg']:.1f}", _first(row["stopped_by"])]
        table.add_row(*cells)
    console = Console()
    console.print(
        Text(f"{done.robot.name}, posture control in {done.fish_in}, {done.duration:g} s from rest", style="bold")
    )
    console.print(table)
    for sentence in _sentences(done):
        console.print(Text(sentence, style="dim"))
    late = [one for one in done.held if one.settling is None]
    if late:
        told = ", ".join(f"{one.name} at {one.frequency:g} Hz" for one in late)
        console.print(Text(f"Not within {math.degrees(CLOSE):g} deg at the end: {told}.", style="bold red"))
    else:
        slowest = max(one.settling for one in done.held if one.settling is not None)
        told = f"Every peak bend is within {math.degrees(CLOSE):g} deg after {slowest:.2f} s, and stays."
        console.print(Text(told, style="green"))
