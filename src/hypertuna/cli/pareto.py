"""The command `hypertuna pareto`."""

from __future__ import annotations

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
    progress_bar,
    tell_written,
    whole_number,
)
from hypertuna.cli.optimize import (
    Areas,
    Bounds,
    Joints,
    Rate,
    Reach,
    Robust,
    Samples,
    Seed,
    Strouhal,
    Torque,
    Water,
    bounds_of,
    gait_record,
    limits_of,
)
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.io.files import rows_csv, write_atomically, write_netcdf
from hypertuna.optimization.objective import OBJECTIVES
from hypertuna.optimization.pareto import SLOW, Front, pareto
from hypertuna.optimization.robust import STATISTICS
from hypertuna.swimming.beat import DEFAULT_STEPS

__all__ = ["pareto_command"]

ROWS = 24  # points of the front that the terminal shows

# What is printed of each gait: name in JSON and CSV with its unit, and quantity.
SHOWN = {
    "speed_m_s": "speed",
    "speed_bl_s": "speed_bl",
    "cost_of_transport_j_per_kg_m": "cost_of_transport",
    "cost_of_transport_positive_j_per_kg_m": "cost_of_transport_positive",
    "mechanical_power_w": "power",
    "mechanical_power_positive_w": "power_positive",
    "power_loss_w": "loss",
    "torque_peak_n_m": "torque_peak",
    "rate_peak_rad_s": "rate_peak",
    "strouhal": "strouhal",
    "tail_excursion_m": "excursion",
    "stride_length": "stride_length",
    "efficiency": "efficiency",
    "turn_radius_m": "turn_radius",
}
NAMES = {quantity: name for name, quantity in SHOWN.items()}


def pareto_command(
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    objectives: Annotated[
        str, typer.Option("--objectives", help=f"Two or three of {', '.join(OBJECTIVES)}.")
    ] = "speed,cost_of_transport",
    population: Annotated[str, typer.Option("--population", help="Gaits of a generation of NSGA-II.")] = "40",
    generations: Annotated[str, typer.Option("--generations", help="Generations of NSGA-II.")] = "60",
    bounds: Bounds = None,
    max_joint_rate: Rate = None,
    max_torque: Torque = None,
    amplitude_by_bandwidth: Reach = False,
    strouhal: Strouhal = None,
    min_speed: Annotated[
        str | None, typer.Option("--min-speed", help=f"Slowest speed in m/s. (default: {SLOW:g} body lengths/s)")
    ] = None,
    robust: Robust = None,
    samples: Samples = "32",
    seed: Seed = "1",
    no_polish: Annotated[bool, typer.Option("--no-polish", help="Leave the front as NSGA-II found it.")] = False,
    joints: Joints = None,
    areas: Areas = None,
    water: Water = None,
    steps: Annotated[str, typer.Option("--steps", help="Runge-Kutta steps per beat.")] = str(DEFAULT_STEPS),
    checkpoint: Annotated[
        str | None, typer.Option("--checkpoint", help="Keep a journal here; the same command resumes from it.")
    ] = None,
    plot: Annotated[str | None, typer.Option("--plot", help="Draw the front to this .svg, .png or .pdf file.")] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write to this .nc or .csv file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Find the gaits of which none is better in every objective: NSGA-II, then polished by exact gradients.

    The exit code is 0 for a front, 1 if no gait keeps all limits, 2 for bad input.
    """
    check_suffix(plot, (".svg", ".png", ".pdf"), "--plot")
    kind = check_suffix(output, (".nc", ".csv"), "--output")
    fish = load(robot).using(joints=joints, areas=areas, water=water)
    with progress_bar("evolving") as progress:
        front = pareto(
            fish,
            [name.strip() for name in objectives.split(",")],
            population=whole_number(population, "--population"),
            generations=whole_number(generations, "--generations"),
            bounds=bounds_of(bounds),
            limits=limits_of(fish, max_joint_rate, max_torque, amplitude_by_bandwidth, strouhal, None),
            min_speed=None if min_speed is None else number(min_speed, "--min-speed", "m/s"),
            polish=not no_polish,
            robust=robust,
            samples=whole_number(samples, "--samples"),
            seed=whole_number(seed, "--seed"),
            steps=whole_number(steps, "--steps"),
            checkpoint=checkpoint,
            progress=progress,
        )
    if not len(front.x):
        print_json(_record(front)) if as_json else Console().print(Text(front.stop, style="bold red"))
        raise typer.Exit(1)
    if plot is not None:
        _plot(front, plot)
    if output is not None and kind == ".nc":
        write_netcdf(front.points.assign_attrs(command=command_line()), output)
    if output is not None and kind == ".csv":
        write_atomically(output, _csv(front).encode())
    if as_json:
        print_json(_record(front))
    else:
        _print(front)
        tell_written(plot, output)


def _rows(front: Front) -> list[dict[str, Any]]:
    """Gaits of the front with their results, names with units."""
    found = front.points
    robust = [f"{name}_{front.robust}" for name in front.objectives] if front.robust else []
    columns = {name: found[quantity].values for name, quantity in SHOWN.items() if quantity in found}
    for name, column in zip(front.objectives, robust, strict=False):
        columns[f"{front.robust}_{NAMES[name]}"] = found[column].values
    columns["stationarity"] = front.stationarity
    rows = []
    for k, gait in enumerate(front.gaits):
        rows.append({"gait": gait_record(gait)} | {name: values[k] for name, values in columns.items()})
    return rows


def _record(front: Front) -> dict[str, Any]:
    """Tell a front, for programs."""
    objectives = [
        {"name": name, "better": "large" if OBJECTIVES[name] else "small", "unit": unit}
        for name, unit in zip(front.objectives, front.units, strict=True)
    ]
    reference = {NAMES[name]: value for name, value in zip(front.objectives, front.reference, strict=True)}
    volume = {"before_polishing": front.hypervolume_evolved, "front": front.hypervolume, "reference": reference}
    return provenance(front.robot) | {
        "objectives": objectives,
        "robust": front.robust,
        "hypervolume": volume,
        "evaluations": front.evaluations,
        "seconds": front.seconds,
        "stop": front.stop,
        "front": _rows(front) if len(front.x) else [],
    }


def _csv(front: Front) -> str:
    """Write a front as comma-separated values, below comments that say what made it."""
    facts = {str(key): value for key, value in front.points.attrs.items()} | {"command": command_line()}
    groups = [group.name for group in front.robot.joints]
    rows = []
    for row in _rows(front):
        gait = row.pop("gait")
        flat = {"frequency_hz": gait.pop("frequency_hz")}
        for name, angles in gait.items():
            kind = name.removesuffix("_deg")
            flat |= {f"{kind}_{group}_deg": angle for group, angle in zip(groups, angles, strict=True)}
        rows.append(flat | row)
    return rows_csv(facts, rows)


def _plot(front: Front, plot: str) -> None:
    """Draw a front; what draws is imported only now, because that takes long."""
    from hypertuna.figures import save
    from hypertuna.optimization.plots import plot_pareto

    save(plot_pareto(front), plot)


def _print(front: Front) -> None:
    """Print a front, or every so many of its points."""
    count = len(front.x)
    picked = np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int))
    table = Table(box=None, pad_edge=False, header_style="bold")
    heads = [f"{name.replace('_', ' ')}\n[{unit}]" for name, unit in zip(front.objectives, front.units, strict=True)]
    for head in (*heads, "f\n[Hz]", "amplitude\n[deg]", "phase\n[deg]"):
        table.add_column(Text(head, justify="right"), justify="right")
    for k in picked:
        gait = front.gaits[k]
        angles = (", ".join(f"{angle:.4g}" for angle in np.degrees(values)) for values in (gait.amplitude, gait.phase))
        table.add_row(*(f"{value:.4g}" for value in front.values[k]), f"{gait.frequency:.3g}", *angles)
    console = Console()
    how = f", {STATISTICS[front.robust]}" if front.robust else ""
    console.print(Text(f"{front.robot.name}: {count} best compromises{how}", style="bold"))
    console.print(table)
    reference = ", ".join(f"{value:.4g}" for value in front.reference)
    units = " ".join(front.units)
    console.print(Text(f"hypervolume {front.hypervolume:.5g} [{units}] from the reference point {reference}"))
    if front.polished:
        residual = np.median(front.stationarity)
        console.print(Text(f"before polishing {front.hypervolume_evolved:.5g}; median stationarity {residual:.1e}"))
    console.print(Text(front.stop, style="green"))
