"""The commands `hypertuna swim` and `hypertuna sweep`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.console import (
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
from hypertuna.cli.options import Amplitude, Bias, Frequency, Name, Named, Phase, gait_axes, one_gait, spelled
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.errors import InputError
from hypertuna.io.files import rows_csv, write_atomically, write_netcdf
from hypertuna.swimming.beat import DEFAULT_STEPS, STATUSES
from hypertuna.swimming.sweep import Gaits, sweep
from hypertuna.swimming.swim import Swim, swim

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["sweep_command", "swim_command"]

RANGE = "A value or a range start:stop:count"
STRAIGHT = 1e3  # a turning radius of so many body lengths is not shown on the terminal
ROWS = 40  # gaits of a sweep that the terminal shows one by one

Joints = Annotated[str | None, typer.Option("--joints", help="ideal or bandwidth (default: the robot's choice)")]
Areas = Annotated[str | None, typer.Option("--areas", help="consistent or as-printed (default: the robot's choice)")]
Water = Annotated[str | None, typer.Option("--water", help="lumped or strip (default: the robot's choice)")]
Steps = Annotated[str, typer.Option("--steps", help="Runge-Kutta steps per beat.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]

# What a swim prints: name in JSON with its unit, attribute, label and unit on the terminal.
SHOWN = (
    ("speed_m_s", "speed", "speed", "m/s"),
    ("speed_bl_s", "speed_bl", "", "BL/s"),
    ("mechanical_power_w", "power", "mechanical power", "W"),
    ("cost_of_transport_j_per_kg_m", "cost_of_transport", "cost of transport", "J/(kg m)"),
    ("strouhal", "strouhal", "Strouhal number", ""),
    ("stride_length", "stride_length", "stride length", "BL per beat"),
    ("efficiency", "efficiency", "efficiency", ""),
    ("tail_excursion_m", "excursion", "tail excursion, peak to peak", "m"),
    ("turn_rate_rad_s", "turn_rate", "rate of turn, counter-clockwise", "rad/s"),
    ("turn_radius_m", "turn_radius", "turning radius", "m"),
)
# What a sweep's table shows of them.
COLUMNS = {
    "speed_m_s": "speed\n[m/s]",
    "speed_bl_s": "\n[BL/s]",
    "mechanical_power_w": "power\n[W]",
    "cost_of_transport_j_per_kg_m": "COT\n[J/(kg m)]",
    "strouhal": "St\n",
}
MORE = (
    ("mechanical_power_positive_w", "power_positive"),
    ("cost_of_transport_positive_j_per_kg_m", "cost_of_transport_positive"),
    ("power_to_water_w", "loss"),
)


def swim_command(
    robot: Name,
    gait: Named = None,
    frequency: Frequency = None,
    amplitude: Amplitude = None,
    phase: Phase = None,
    bias: Bias = None,
    joints: Joints = None,
    areas: Areas = None,
    water: Water = None,
    from_rest: Annotated[
        str | None, typer.Option("--from-rest", help="Swim from rest for so many seconds, not the settled beat.")
    ] = None,
    steps: Steps = str(DEFAULT_STEPS),
    current: Annotated[str | None, typer.Option("--current", help="Velocity of the water, X,Y in m/s.")] = None,
    plot: Annotated[str | None, typer.Option("--plot", help="Draw to this .svg, .png, .pdf or .gif file.")] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write the motion to this .nc file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Swim one gait: its settled beat, or from rest.

    The exit code is 0 for a settled gait, 1 for one that is not (its results are still printed), 2 for bad input.
    """
    kind = check_suffix(plot, (".svg", ".png", ".pdf", ".gif"), "--plot")
    check_suffix(output, (".nc",), "--output")
    fish = load(robot).using(joints=joints, areas=areas, water=water)
    done = swim(
        fish,
        one_gait(gait_axes(fish, gait, {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias})),
        from_rest=None if from_rest is None else number(from_rest, "from_rest", "seconds"),
        steps=whole_number(steps, "steps"),
        current=(0.0, 0.0) if current is None else _pair(current),
    )
    if as_json:
        print_json(_record(done))
    else:
        _print_swim(done)
    if output is not None:
        write_netcdf(done.trajectory.assign_attrs(_attributes(done)), output)
    if plot is not None:
        _plot_swim(done, plot, kind)
    if not as_json:
        tell_written(output, plot)
    if not done.settled:
        raise typer.Exit(1)


def sweep_command(
    robot: Name,
    gait: Named = None,
    frequency: Annotated[str | None, typer.Option("--frequency", help=f"{RANGE} in Hz.")] = None,
    amplitude: Annotated[
        list[str] | None,
        typer.Option("--amplitude", help=f"{RANGE} per joint group in degrees; once for every level."),
    ] = None,
    phase: Annotated[
        str | None, typer.Option("--phase", help=f"{RANGE} per joint group: lag behind the first group's clock.")
    ] = None,
    bias: Annotated[str | None, typer.Option("--bias", help=f"{RANGE} per joint group: mean angle in degrees.")] = None,
    joints: Joints = None,
    areas: Areas = None,
    water: Water = None,
    steps: Steps = str(DEFAULT_STEPS),
    threads: Annotated[str | None, typer.Option("--threads", help="Threads to use (default: all)")] = None,
    plot: Annotated[
        str | None, typer.Option("--plot", help="Draw speed and cost of transport to this .svg, .png or .pdf file.")
    ] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write to this .nc or .csv file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Swim every combination of frequencies, amplitudes, phases and biases.

    Every gait comes with its status; gaits that do not settle are counted on the error output.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish = load(robot).using(joints=joints, areas=areas, water=water)
    axes = gait_axes(fish, gait, {"frequency": frequency, "amplitude": amplitude, "phase": phase, "bias": bias}, ranges)
    workers = None if threads is None else whole_number(threads, "threads")
    with progress_bar("swimming") as progress:
        found = sweep(fish, _grid(axes), threads=workers, steps=whole_number(steps, "steps"), progress=progress)
    if plot is not None:
        _plot_sweep(found, plot)
    if output is not None and kind == ".nc":
        write_netcdf(found.assign_attrs(command=command_line()), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(found).encode())
    if as_json:
        print_json(provenance(fish) | {"gaits": _gaits(found)})
    else:
        _print_sweep(found)
        tell_written(plot, output)
    if missing := int((~found.settled).sum()):
        Console(stderr=True).print(f"{missing} of {found.settled.size} gaits are not settled: see their status.")


def _grid(axes: dict[str, list[tuple[float, ...]]]) -> Gaits:
    """Make every combination of the options; each value is checked in degrees first."""
    for key, values in axes.items():
        for value in values:
            one_gait(axes | {key: [value]})
    angles = {key: np.radians(axes[key]).tolist() for key in ("amplitude", "phase", "bias")}
    return Gaits.grid(frequency=[value[0] for value in axes["frequency"]], **angles)


def _pair(text: str) -> tuple[float, float]:
    """Read a velocity."""
    values = number_list(text, "current", "m/s")
    if len(values) != 2:
        raise InputError("must be two numbers", key="current", value=text, fix="give m/s along x and y, as 0.1,0")
    return values[0], values[1]


def _record(done: Swim) -> dict[str, Any]:
    """Say how a gait was swum, for programs."""
    gait = done.gait
    return (
        {name: getattr(done, attribute) for name, attribute, *_ in (*SHOWN, *MORE)}
        | {"status": done.status, "status_text": done.status_text, "settled": done.settled, "beats": done.beats}
        | {
            "spectral_radius": done.spectral_radius,
            "change_per_beat": done.change,
            "distance_to_settled": done.distance,
            "steps": done.steps,
        }
        | {"frequency_hz": gait.frequency}
        | {f"{key}_deg": np.degrees(getattr(gait, key)).round(10).tolist() for key in ("amplitude", "phase", "bias")}
        | {"from_rest_s": done.duration, "current_m_s": done.current}
        | provenance(done.robot)
    )


def _attributes(done: Swim) -> dict[str, Any]:
    """Return what NetCDF can hold of the record beside the motion."""
    record = {key: value for key, value in _record(done).items() if value is not None}
    return record | {"settled": int(done.settled), "command": command_line()}


def _print_swim(done: Swim) -> None:
    """Print a swim as a small table and a sentence."""
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(style="dim")
    table.add_column(justify="right", style="bold")
    table.add_column()
    turning = done.turn_radius < STRAIGHT * done.robot.body.length
    for _, attribute, label, unit in SHOWN:
        if turning or not attribute.startswith("turn"):
            table.add_row(label, f"{getattr(done, attribute):.4g}", Text(unit))
    model = done.robot.model
    areas = f", {model.areas} areas" if model.water == "lumped" else ""
    console = Console()
    console.print(Text(f"{done.robot.name}, {spelled(done.gait)}", style="bold"))
    console.print(Text(f"{model.water} water, {model.joints} joints{areas}", style="dim"))
    if any(done.current):
        x, y = done.current
        console.print(Text(f"current {x:g}, {y:g} m/s; speed is through the water", style="dim"))
    console.print(table)
    console.print(Text(done.status_text, style="green" if done.settled else "bold red"))


def _plot_swim(done: Swim, plot: str, kind: str | None) -> None:
    """Draw a swim; what draws is imported only now, because that takes longer than the swim."""
    from hypertuna.figures import save
    from hypertuna.swimming.animation import animate_swim
    from hypertuna.swimming.plots import plot_swim

    animate_swim(done, plot) if kind == ".gif" else save(plot_swim(done), plot)


def _plot_sweep(found: xr.Dataset, plot: str) -> None:
    """Draw a sweep."""
    from hypertuna.figures import save
    from hypertuna.swimming.plots import plot_sweep

    save(plot_sweep(found), plot)


def _columns(found: xr.Dataset) -> dict[str, Any]:
    """Return gaits and results of a sweep, one value per gait, names with units."""
    like = found["status"]

    def column(name: str) -> Any:
        return found[name].broadcast_like(like).transpose(*like.dims).values.ravel()

    angles = [str(name) for name in found.coords if name != "frequency"]
    return (
        {"frequency_hz": column("frequency")}
        | {f"{name}_deg": np.degrees(column(name)).round(10) for name in angles}
        | {name: column(attribute) for name, attribute, *_ in (*SHOWN, *MORE)}
        | {"status": np.array(STATUSES)[column("status")], "spectral_radius": column("spectral_radius")}
    )


def _gaits(found: xr.Dataset) -> list[dict[str, Any]]:
    """Return gaits and results of a sweep as rows."""
    columns = _columns(found)
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _csv(found: xr.Dataset) -> str:
    """Write a sweep as comma-separated values, below comments that say what made it."""
    made_by = {str(key): value for key, value in found.attrs.items()} | {"command": command_line()}
    return rows_csv(made_by, _gaits(found))


def _print_sweep(found: xr.Dataset) -> None:
    """Print the gaits of a sweep, or the best of many."""
    columns = _columns(found)
    settled = columns["status"] == "settled"
    ahead = settled & (columns["speed_m_s"] > 0)
    rows = dict.fromkeys(range(len(settled)), "")
    if len(settled) > ROWS and ahead.any():
        fastest = np.where(ahead, columns["speed_m_s"], -np.inf).argmax()
        frugal = np.where(ahead, columns["cost_of_transport_j_per_kg_m"], np.inf).argmin()
        rows = {int(fastest): "fastest", int(frugal): "least cost of transport"}
    varying = [name for name in columns if name.endswith(("_hz", "_deg")) and np.ptp(columns[name]) > 0]
    labels = {name: name.removesuffix("_deg").replace("_", " ") + "\n[deg]" for name in varying}
    turns = {"turn_radius_m": "radius\n[m]"} if np.isfinite(columns["turn_radius_m"]).any() else {}
    labels |= {"frequency_hz": "f\n[Hz]"} | COLUMNS | turns
    names = [*varying, *COLUMNS, *turns]
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in names:
        table.add_column(Text(labels[name], justify="right"), justify="right")
    table.add_column("\nstatus", no_wrap=True)
    table.add_column()
    for k, remark in rows.items():
        table.add_row(*(f"{columns[name][k]:.3g}" for name in names), columns["status"][k], remark)
    console = Console()
    console.print(Text(f"{len(settled)} gaits of {found.attrs['robot']}, {settled.sum()} settled", style="bold"))
    console.print(table)
