"""The command `hypertuna sweep`."""

from __future__ import annotations

import math
import shutil
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import GaitOptions, column_rows
from hypertuna.cli.search import once
from hypertuna.cli.shards import check_text, connected, write_shards
from hypertuna.cli.streams import note
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.io.files import coordinate_names, variable_columns
from hypertuna.parallel.executors import thread_count
from hypertuna.parallel.shards import shard_size
from hypertuna.swimming.batch import Part, batch, table_names
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.swimming.gait import MAX_GAITS, Gaits
from hypertuna.swimming.shards import sweep_shards
from hypertuna.swimming.sweep import design_robots, sweep, sweep_designs

if TYPE_CHECKING:
    import xarray as xr

SAMPLE = 1024  # gaits of a large grid that are swum first, to estimate its time and size
YEAR = 365 * 24 * 3600  # s
MAX_WIDE = 8  # columns that fit 80 characters; a table of more is set tight
MAX_ROWS = 40  # gaits listed on the terminal; of more it shows the fastest and the cheapest
# Column -> its head on the terminal.
HEADS = {
    "frequency_hz": "f\n[Hz]",
    "speed_m_s": "speed\n[m/s]",
    "speed_bl_s": "\n[BL/s]",
    "mechanical_power_w": "power\n[W]",
    "cost_of_transport_j_per_kg_m": "COT\n[J/(kg m)]",
    "strouhal": "St\n",
    "turn_radius_m": "radius\n[m]",
    "twin_speed_m_s": "in the twin:\n[m/s]",
    "electrical_power_w": "power\n[W]",
    "electrical_cost_of_transport_j_per_kg_m": "COT\n[J/(kg m)]",
}


def _levels(text: str, key: str) -> tuple[str, list[float]]:
    """Return name and values from NAME=VALUES."""
    name, values = parsing.pair(text, key, "NAME=UNIT,...")
    return name, parsing.values(values, f"{key} {name}", "the unit of the file")


@opt.grouped
def sweep_command(
    robot: opt.ModelOptions,
    gaits: GaitOptions,
    design: Annotated[
        list[Any] | None,
        opt.option(
            ("--design",),
            "Values of a number of the robot's file, such as hinge.stiffness=0.05:2:40, or of a factor on the caudal "
            "fin: fin.span, fin.chord, fin.area, fin.aspect_ratio; repeatable.",
            "NAME=UNIT,...",
            _levels,
        ),
    ] = None,
    steps: opt.Steps = DEFAULT_STEPS,
    check_rest: Annotated[
        bool, opt.flag("--check-rest", "Check whether a start from rest leads to each settled beat.")
    ] = False,
    electrical: Annotated[
        bool, opt.flag("--electrical", "Swim each gait in the twin, too: its speed and what its servos draw.")
    ] = False,
    threads: opt.Threads = None,
    checkpoint: opt.Checkpoint = None,
    places: opt.Places = opt.NO_PLACES,
    files: opt.ShardFiles = opt.NO_SHARD_FILES,
) -> None:
    """Swim every combination of frequencies, amplitudes, phases and biases, for every robot variant of --design.

    Every gait comes with its status; gaits that do not settle are counted on the error output, and with --check-rest
    those whose settled beat a start from rest does not lead to.
    """
    subject = robot.load()
    grid = gaits.grid(subject)
    options: dict[str, Any] = {"threads": threads, "steps": steps, "check_rest": check_rest}
    levels = once(design or [])
    if files.output is not None and files.output.endswith(opt.SHARDS):
        if len(grid) > MAX_GAITS:
            settings: Any = options | {"threads": thread_count(threads), "method": "newton", "beats": 1}
            _announce(subject, grid, files.output, places, settings)
    else:
        check_text(len(grid) * math.prod(len(values) for values in levels.values()), files.output, files.as_json)
    settings = {"places": places, "refused": {"--checkpoint": checkpoint, "--plot": files.plot}}
    settings["refused"]["--design"] = " ".join(name for name, _ in design or ()) or None
    settings["refused"]["--electrical"] = "given" if electrical else None
    if write_shards(files.output, sweep_shards, subject, grid, **settings, as_json=files.as_json, **options):
        return
    found = design_robots(subject, levels, len(grid)) if levels else ((), [subject])
    if electrical:
        from hypertuna.simulation.electrical import check_runs, with_electrical  # slow to import

        check_runs(found[1], grid)  # raises errors before a sweep that may be long
    with (
        progress_bar("swimming", parts="gait", checkpoint=checkpoint) as progress,
        connected(places.cluster) as executor,
    ):
        swim = partial(sweep_designs, design=levels, found=found) if levels else sweep
        result = swim(subject, grid, executor=executor, checkpoint=checkpoint, progress=progress, **options)
    if electrical:
        with progress_bar("swimming in the twin", parts="gait") as progress:
            result = with_electrical(result, found[1], grid, threads=thread_count(threads), progress=progress)
    emit(
        result,
        record=lambda data: provenance(subject) | {"gaits": column_rows(variable_columns(data, _names(data)))},
        lines=_lines,
        columns=_names(result),
        digits=None,
        figure=_figure,
        **vars(files),
    )
    if unsettled := int((~result.settled).sum()):
        typer.echo(f"{unsettled} of {result.settled.size} gaits are not settled: see their status.", err=True)
    if check_rest and (other := int((result.settled & ~result.reached_from_rest).sum())):
        typer.echo(f"{other} of {result.settled.size} gaits settle where a start from rest does not lead.", err=True)
    if electrical and (beyond := int(np.isnan(result.electrical_power).sum())):
        typer.echo(
            f"{beyond} of {result.settled.size} gaits are beyond the controller, or diverge in the twin.", err=True
        )


def _announce(robot: Robot, grid: Gaits, folder: str, places: opt.Places, options: dict[str, Any]) -> None:
    """Print the time, disk and memory of a large grid, measured on a few gaits; refuse one that takes too much."""
    count, (part, parts) = len(grid), places.shard or (1, 1)
    size = shard_size(count, places.shard_size)
    sample = batch(robot, [grid[int(k)] for k in np.linspace(0, count - 1, SAMPLE)], **options)
    start = time.monotonic()
    columns = sample.swimming.swim(Part.of(sample.gaits, 0, SAMPLE))
    rate = SAMPLE / (time.monotonic() - start)
    each, n = sum(column.nbytes for column in columns.values()) / SAMPLE, -(-count // parts)
    years, disk = n / rate / YEAR, shutil.disk_usage(Path(folder).parent).free
    extent = f"{n:,} gaits, part {part} of {parts}," if parts > 1 else f"{count:,} gaits"
    speed = f"{rate:.0f} gaits/s, the rate of this machine on {SAMPLE} of them"
    if years > 1 and places.cluster is None:
        rule, fix = "must end within a year", "take fewer values, or more machines by --shard I/N or --cluster"
        raise InputError(rule, key="the sweep", value=f"{years:.3g} years: {extent} at {speed}", fix=fix)
    if each * n > disk:
        rule, value = f"must fit on the disk of {folder}, with {disk / 1e9:.3g} GB free", f"{each * n / 1e9:.3g} GB"
        raise InputError(rule, key="the sweep", value=value, fix="take fewer values, or another disk")
    hours = f"about {_duration_text(n / rate)} at {speed}"
    note(
        f"{extent} in shards of {size} take {hours}, {each * n / 1e9:.3g} GB of disk, and "
        f"{each * size / 1e6:.0f} MB of memory a worker."
    )


def _duration_text(seconds: float) -> str:
    """Return a duration [s] as text, in days, h, min or s."""
    units = (86400, "days"), (3600, "h"), (60, "min"), (1, "s")
    size, unit = next((row for row in units if seconds > 2 * row[0]), units[-1])
    return f"{seconds / size:.3g} {unit}"


def _names(result: xr.Dataset) -> list[str]:
    """Return the names of the columns of gaits and results in CSV and JSON."""
    of_twin = (str(name) for name in result.data_vars if str(name).startswith(("twin_", "electrical_")))
    return [*coordinate_names(result), *table_names(result), *of_twin]


def _figure(result: xr.Dataset) -> Any:
    """Return the figure of a sweep."""
    from hypertuna.swimming.plots import plot_sweep  # slow to import

    return plot_sweep(result)


def _lines(result: xr.Dataset) -> Iterator[Any]:
    """Yield the table that the terminal shows: all gaits, or the fastest and the cheapest of many."""
    columns = variable_columns(result, _names(result))
    settled = columns["status"] == "settled"
    remarks = _remarks(columns, settled)
    varying = [name for name in variable_columns(result, coordinate_names(result)) if np.ptp(columns[name]) > 0]
    turns = np.isfinite(columns["turn_radius_m"]).any()
    left_out = {"frequency_hz"} if turns else {"frequency_hz", "turn_radius_m"}
    names = [*varying, *(name for name in HEADS if name in columns and name not in left_out)]
    skipped = 0 if any(remarks.values()) else 1
    tight = len(names) + 1 - skipped > MAX_WIDE
    heads = [_head(name, tight) for name in names]
    rows = [
        (remark, *(f"{columns[name][k]:.3g}" for name in names), columns["status"][k]) for k, remark in remarks.items()
    ]
    yield f"{len(settled)} gaits of {result.attrs['robot']}, {settled.sum()} settled", "bold"
    heads, shown = ["", *heads, "\nstatus"][skipped:], [row[skipped:] for row in rows]
    yield Table(heads, shown, left=(0, len(heads) - 1) if not skipped else (len(heads) - 1,), tight=tight)


def _head(name: str, tight: bool) -> str:
    """Return the head of a column, a line each for quantity, joint group if any, and unit."""
    if name in HEADS:
        return HEADS[name].replace("[J/(", "[J/\n(") if tight else HEADS[name]
    if "." in name:  # a number of --design
        return name.replace(".", "\n", 1)
    quantity, group = name.removesuffix("_deg").split("_", 1)
    return f"{'ampl.' if tight and quantity == 'amplitude' else quantity}\n{group}\n[deg]"


def _remarks(columns: dict[str, Any], settled: Any) -> dict[int, str]:
    """Return the rows to show -> their remarks: all rows, or the fastest and the cheapest of many."""
    forward = settled & (columns["speed_m_s"] > 0)
    if len(settled) <= MAX_ROWS or not forward.any():
        return dict.fromkeys(range(len(settled)), "")
    fastest = np.where(forward, columns["speed_m_s"], -np.inf).argmax()
    cheapest = np.where(forward, columns["cost_of_transport_j_per_kg_m"], np.inf).argmin()
    return {int(fastest): "fastest", int(cheapest): "lowest COT"}
