"""The command `hypertuna dive`."""

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
    number,
    print_json,
    tell_written,
    whole_number,
)
from hypertuna.cli.old_options import Amplitude, Bias, Frequency, Name, Named, Phase, Seed, gait_axes, one_gait, spelled
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.io.files import columns_csv, write_atomically, write_netcdf
from hypertuna.simulation.dive import Dive, dive

__all__ = ["dive_command"]


def dive_command(
    robot: Name,
    gait: Named = None,
    frequency: Frequency = None,
    amplitude: Amplitude = None,
    phase: Phase = None,
    bias: Bias = None,
    fins: Annotated[
        str, typer.Option("--fins", help="Angle of the pectoral fins in degrees: down by it, then up.")
    ] = "45",
    duration: Annotated[str, typer.Option("--duration", help="Length of both halves in s.")] = "30",
    depth: Annotated[str, typer.Option("--depth", help="Depth at the start in m.")] = "2",
    seed: Seed = "0",
    plot: Annotated[str | None, typer.Option("--plot", help="Draw the dive to this .svg, .png or .pdf file.")] = None,
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write the run to this .nc or .csv file.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Dive with the pectoral fins down for half of the time, then float with the fins up.

    The exit code is 0 if fins down take the robot down and fins up take it up, 1 if not, 2 for bad input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish = load(robot)
    wished = {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias}
    done = dive(
        fish,
        one_gait(gait_axes(fish, gait, wished)),
        angle=math.radians(number(fins, "--fins", "degrees")),
        duration=number(duration, "--duration", "seconds"),
        depth=number(depth, "--depth", "m"),
        seed=whole_number(seed, "--seed"),
    )
    if output is not None and kind == ".nc":
        write_netcdf(done.run.dataset().assign_attrs(command=command_line()), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(done).encode())
    if plot is not None:
        _plot(done, plot)
    if as_json:
        print_json(_record(done))
    else:
        _print(done)
        tell_written(output, plot)
    if done.run.status == "diverged" or not all(leg.right for leg in done.legs):
        raise typer.Exit(1)


def _legs(done: Dive) -> list[dict[str, Any]]:
    """Both halves, names with units."""
    return [
        {
            "fins_deg": math.degrees(leg.fins),
            "depth_rate_m_s": leg.rate,
            "pitch_deg": math.degrees(leg.pitch),
            "pitch_range_deg": math.degrees(leg.pitch_range),
            "roll_max_deg": math.degrees(leg.roll),
            "speed_m_s": leg.speed,
            "depth_from_m": leg.depth[0],
            "depth_to_m": leg.depth[1],
            "steady": leg.steady,
        }
        for leg in done.legs
    ]


def _record(done: Dive) -> dict[str, Any]:
    """Say how the robot dived, for programs."""
    run, gait = done.run, done.run.gait
    return (
        {"legs": _legs(done), "symmetry": done.symmetry, "status": run.status, "status_text": list(done.sentences)}
        | {"frequency_hz": gait.frequency}
        | {f"{key}_deg": np.degrees(getattr(gait, key)).round(10).tolist() for key in ("amplitude", "phase", "bias")}
        | {"duration_s": run.duration, "depth_m": float(run.depth[0]), "seed": run.seed}
        | {"frame": "depth down from the surface, pitch nose up, roll starboard down"}
        | {key: value for key, value in provenance(run.robot).items() if key != "joints"}  # the twin moves its own
        | {"command": command_line()}
    )


def _csv(done: Dive) -> str:
    """Write a dive as comma-separated values, one row per control period, below comments that say what made it."""
    run = done.run
    columns: dict[str, Any] = {
        "time_s": run.time,
        "depth_m": run.depth,
        "pitch_deg": np.degrees(run.pitch),
        "roll_deg": np.degrees(run.roll),
        "heading_deg": np.degrees(run.heading),
        "speed_m_s": run.speed,
        "sink_m_s": run.sink,
        "fin_port_deg": np.degrees(run.data["fin"][:, 0]),
        "fin_starboard_deg": np.degrees(run.data["fin"][:, 1]),
        "east_m": run.position[:, 0],
        "north_m": run.position[:, 1],
        "electrical_power_w": run.data["power"],
    }
    return columns_csv({key: value for key, value in _record(done).items() if key != "legs"}, columns)


def _plot(done: Dive, plot: str) -> None:
    """Draw a dive; what draws is imported only now, because that takes longer than the run."""
    from hypertuna.figures import save
    from hypertuna.simulation.plots import plot_dive

    save(plot_dive(done), plot)


def _print(done: Dive) -> None:
    """Print both halves as a table, and their sentences."""
    console, run = Console(), done.run
    console.print(Text(f"{run.robot.name}, {spelled(run.gait)}", style="bold"))
    console.print(Text(f"{run.duration:g} s from a depth of {run.depth[0]:g} m", style="dim"))
    table = Table(box=None, pad_edge=False, header_style="bold")
    for head in ("fins\n[deg]", "depth\n[m]", "down\n[cm/s]", "pitch\n[deg]", "speed\n[m/s]"):
        table.add_column(Text(head, justify="right"), justify="right", no_wrap=True)
    for leg in done.legs:
        way = f"{leg.depth[0]:.2f} to {leg.depth[1]:.2f}"
        cells = (f"{math.degrees(leg.fins):+.3g}", way, f"{100 * leg.rate:+.1f}", f"{math.degrees(leg.pitch):+.1f}")
        table.add_row(*cells, f"{leg.speed:.3f}")
    console.print(table)
    console.print()
    good = run.status == "completed" and all(leg.right for leg in done.legs)
    style = "bold red" if not good else "green" if all(leg.steady for leg in done.legs) else "yellow"
    for sentence in done.sentences:
        console.print(Text(sentence, style=style))
