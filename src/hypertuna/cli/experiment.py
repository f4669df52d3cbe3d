"""The commands `hypertuna optimize ask` and `hypertuna optimize tell`: the optimizer of a tank experiment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hypertuna.cli.old_console import check_suffix, number, number_list, print_json, tell_written, whole_number
from hypertuna.cli.optimize import (
    Bounds,
    Iterations,
    Maximize,
    Method,
    Minimize,
    Name,
    Particles,
    Rate,
    Reach,
    Seed,
    Speed,
    Weight,
    bounds_of,
    gait_record,
    limits_of,
)
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import load
from hypertuna.errors import InputError
from hypertuna.io.files import write_atomically
from hypertuna.optimization.design_space import gait_columns
from hypertuna.optimization.experiment import TankOptions, TankSearch
from hypertuna.swimming.gait import Gait
from hypertuna.trials.steady import COLUMNS, SteadyRun, read_steady

__all__ = ["ask_command", "tell_command"]

State = Annotated[str, typer.Option("--state", help="File that keeps the search; made by the first ask.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
MEASURED = (COLUMNS["speed"], COLUMNS["cost_of_transport"])


def ask_command(
    context: typer.Context,
    state: State,
    robot: Name = None,
    maximize: Maximize = None,
    minimize: Minimize = None,
    speed: Speed = None,
    weight: Weight = None,
    method: Method = "pso",
    particles: Particles = None,
    iterations: Iterations = None,
    bounds: Bounds = None,
    seed: Seed = "1",
    max_joint_rate: Rate = None,
    amplitude_by_bandwidth: Reach = False,
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write the gaits to this .csv file, to fill in what they do.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print the gaits that a tank should swim next; after the last batch, why the search stopped and the best gait.

    The first call says what to search for; later ones need --state alone. Asking again gives the same gaits until all
    of them are told. The exit code is 1 if the search has stopped without a gait that keeps all limits.
    """
    check_suffix(output, (".csv",), "--output")
    if robot is None:
        _check_later(context)
    search = None
    if robot is not None:
        search = TankOptions(
            robot=robot,
            maximize=maximize,
            minimize=minimize,
            speed=None if speed is None else number(speed, "--speed", "m/s"),
            weight=None if weight is None else number(weight, "--weight", "m/s per J/(kg m)"),
            bounds=bounds_of(bounds),
            limits=limits_of(load(robot), max_joint_rate, None, amplitude_by_bandwidth, None, None),
            method=method,
            particles=None if particles is None else whole_number(particles, "--particles"),
            iterations=None if iterations is None else whole_number(iterations, "--iterations"),
            seed=whole_number(seed, "--seed"),
        )
    with TankSearch(state, search) as experiment:
        _print_state(experiment, as_json)
        if output is not None and experiment.stop is None:
            write_atomically(output, _csv(experiment).encode())
            if not as_json:
                tell_written(output)
        if experiment.stop is not None and experiment.best is None:
            raise typer.Exit(1)


def _check_later(context: typer.Context) -> None:
    """Check that a later call says nothing of the search: it would be ignored."""
    for name in set(context.params) - {"state", "output", "as_json"}:
        source = context.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE":
            rule = "must come with --robot: without it, the search in the state file goes on as it was begun"
            fix = "leave it out, or give --robot as well"
            raise InputError(rule, key=f"--{name.replace('_', '-')}", value="given alone", fix=fix)


def tell_command(
    state: State,
    results: Annotated[
        str | None, typer.Argument(help="CSV file of steady runs: what `ask -o` wrote, with what was measured.")
    ] = None,
    value: Annotated[
        list[str] | None,
        typer.Option("--value", help="Speed in m/s, or SPEED,COST_OF_TRANSPORT, of one gait after the other as asked."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Tell how gaits of the batch swam: all of them, or some now and the others later."""
    with TankSearch(state) as experiment:
        if (results is None) == (not value):
            rule = "must be told either in a CSV file or with --value"
            raise InputError(rule, key="results", value="told in both" if value else "told in neither")
        runs = _runs_of(value or [], experiment) if results is None else read_steady(results, experiment.robot)
        left = experiment.tell(runs)
        if as_json:
            _print_state(experiment, as_json=True)
            return
        console = Console()
        console.print(Text(f"{len(runs)} told; {left or 'none'} of this batch to come."))
        if left == 0:
            _print_state(experiment, as_json=False)


def _runs_of(values: list[str], experiment: TankSearch) -> list[SteadyRun]:
    """Make runs of the values of the option, for the gaits that are still to be told."""
    asked = experiment.ask()
    if not asked:
        raise InputError("has stopped", key="the search", fix="see `hypertuna optimize ask`")
    if len(values) > len(asked):
        rule = f"must be given {len(asked)} times at most, once for each gait that is asked for"
        raise InputError(rule, key="--value", value=f"given {len(values)} times", fix="see `hypertuna optimize ask`")
    runs = []
    for k, (text, (name, gait)) in enumerate(zip(values, asked.items(), strict=False)):
        numbers = number_list(text, f"--value {k + 1}", "m/s")
        if len(numbers) > 2:
            raise InputError("must be SPEED or SPEED,COST_OF_TRANSPORT", key=f"--value {k + 1}", value=text)
        runs.append(SteadyRun(name, gait, speed=numbers[0], cost_of_transport=numbers[1] if numbers[1:] else None))
    return runs


def _print_state(experiment: TankSearch, as_json: bool) -> None:
    """Print what to swim next, or how the search ended."""
    asked, best = experiment.ask(), experiment.best
    if as_json:
        found = None if best is None else {"gait": gait_record(best[0])} | _found_record(best[1])
        gaits = [{"run": name} | gait_record(gait) for name, gait in asked.items()]
        facts = {"stop": experiment.stop, "gaits": gaits, "best": found, "evaluations": experiment.evaluations}
        print_json(facts | provenance(experiment.robot))
        return
    console = Console()
    if asked:
        head = list(gait_columns(experiment.robot))
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column("run", no_wrap=True)
        for column in head:
            table.add_column(column.replace("_", "\n"), justify="right")
        for name, gait in asked.items():
            table.add_row(name, *(f"{x:.4g}" for x in _row(gait)))
        console.print(table)
    if experiment.stop is not None:
        console.print(Text(experiment.stop, style="green" if best else "bold red"))
        if best is None:
            console.print(Text("No gait was told that keeps all limits and swims forward.", style="bold red"))
    if best is not None:
        told = ", ".join(f"{key} {value:.4g}" for key, value in _found_record(best[1]).items() if np.isfinite(value))
        row = zip(gait_columns(experiment.robot), _row(best[0]), strict=True)
        console.print(Text(f"best of {experiment.evaluations}: {', '.join(f'{name} {x:.4g}' for name, x in row if x)}"))
        console.print(Text(f"it swam: {told}"))


def _found_record(found: Mapping[str, float]) -> dict[str, Any]:
    """Name what was measured as files do."""
    return {COLUMNS[name]: value for name, value in found.items()}


def _row(gait: Gait) -> list[float]:
    """Values of a gait in Hz and degrees, in the order of `gait_columns`."""
    return [gait.frequency, *np.degrees([*gait.amplitude, *gait.phase, *gait.bias]).tolist()]


def _csv(experiment: TankSearch) -> str:
    """Write the gaits as steady runs with empty cells for what will be measured."""
    lines = [",".join([COLUMNS["name"], *gait_columns(experiment.robot), *MEASURED])]
    for name, gait in experiment.ask().items():
        lines.append(",".join([name, *(f"{x:.6f}" for x in _row(gait)), *("",) * len(MEASURED)]))
    return "\n".join(lines) + "\n"
