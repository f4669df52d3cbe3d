"""The command `hypertuna pareto`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import command_line, progress_bar, table
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import gait_record
from hypertuna.cli.search import RobustOptions, SwimLimits, bounds_of
from hypertuna.description.provenance import provenance
from hypertuna.io.files import rows_csv
from hypertuna.optimization.objective import OBJECTIVES
from hypertuna.optimization.pareto import SLOW, Front, pareto
from hypertuna.optimization.problem import STATISTICS
from hypertuna.swimming.beat import DEFAULT_STEPS

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


@opt.grouped
def pareto_command(
    robot: opt.RobotOptions,
    limits: SwimLimits,
    robust: RobustOptions,
    objectives: Annotated[
        str, opt.text("--objectives", f"Two or three of {', '.join(OBJECTIVES)}.")
    ] = "speed,cost_of_transport",
    population: Annotated[int, opt.whole_number("--population", "Gaits in a generation of NSGA-II.")] = 40,
    generations: Annotated[int, opt.whole_number("--generations", "Generations of NSGA-II.")] = 60,
    bounds: opt.Bounds = None,
    min_speed: Annotated[
        float | None,
        opt.number("--min-speed", "m/s", f"Minimum speed in m/s. (default: {SLOW:g} body lengths/s)"),
    ] = None,
    seed: opt.Seed = 1,
    no_polish: Annotated[bool, typer.Option("--no-polish", help="Do not polish the front of NSGA-II.")] = False,
    steps: opt.Steps = DEFAULT_STEPS,
    checkpoint: opt.Checkpoint = None,
    plot: opt.Plot = None,
    output: opt.TableOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Find the Pareto front of gaits: NSGA-II, polished by exact gradients.

    The exit code is 0 for a front, 1 if no gait satisfies all limits, 2 for bad input.
    """
    subject = robot.load()
    with progress_bar("evolving") as progress:
        front = pareto(
            subject,
            [name.strip() for name in objectives.split(",")],
            population=population,
            generations=generations,
            bounds=bounds_of(bounds),
            limits=limits.make(subject),
            min_speed=min_speed,
            polish=not no_polish,
            seed=seed,
            steps=steps,
            checkpoint=checkpoint,
            progress=progress,
            **vars(robust),
        )
    empty = not len(front.x)
    emit(
        front,
        record=_record,
        lines=_lines,
        csv=_csv,
        dataset=lambda front: front.points,
        output=None if empty else output,
        plot=None if empty else plot,
        figure="hypertuna.optimization.plots:plot_pareto",
        as_json=as_json,
        failed=empty,
    )


def _rows(front: Front) -> list[dict[str, Any]]:
    """Return the gaits of the front with their results, names with units."""
    points = front.points
    robust = [f"{name}_{front.robust}" for name in front.objectives] if front.robust else []
    columns = {name: points[quantity].values for name, quantity in SHOWN.items() if quantity in points}
    for name, column in zip(front.objectives, robust, strict=False):
        columns[f"{front.robust}_{NAMES[name]}"] = points[column].values
    columns["stationarity"] = front.stationarity
    rows = []
    for k, gait in enumerate(front.gaits):
        rows.append({"gait": gait_record(gait)} | {name: values[k] for name, values in columns.items()})
    return rows


def _record(front: Front) -> dict[str, Any]:
    """Return the JSON record."""
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
    """Write a front as comma-separated values, below comments on their origin."""
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


def _lines(front: Front) -> Iterator[Any]:
    """Lay out a front, or a sample of its points."""
    count = len(front.x)
    if not count:
        yield front.stop, "bold red"
        return
    heads = [f"{name.replace('_', ' ')}\n[{unit}]" for name, unit in zip(front.objectives, front.units, strict=True)]
    rows = []
    for k in np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int)):
        gait = front.gaits[k]
        angles = (", ".join(f"{angle:.4g}" for angle in np.degrees(values)) for values in (gait.amplitude, gait.phase))
        rows.append((*(f"{value:.4g}" for value in front.values[k]), f"{gait.frequency:.3g}", *angles))
    robust = f", {STATISTICS[front.robust]}" if front.robust else ""
    yield f"{front.robot.name}: {count} best compromises{robust}", "bold"
    yield table([*heads, "f\n[Hz]", "amplitude\n[deg]", "phase\n[deg]"], rows, left=())
    reference = ", ".join(f"{value:.4g}" for value in front.reference)
    yield f"hypervolume {front.hypervolume:.5g} [{' '.join(front.units)}] from the reference point {reference}"
    if front.polished:
        residual = np.median(front.stationarity)
        yield f"before polishing {front.hypervolume_evolved:.5g}; median stationarity {residual:.1e}"
    yield front.stop, "green"
