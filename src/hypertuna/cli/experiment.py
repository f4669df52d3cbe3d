"""The commands `hypertuna optimize ask` and `hypertuna optimize tell`: the optimizer of a tank experiment."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli.console import print_lines
from hypertuna.cli.emit import emit
from hypertuna.cli.parsing import numbers
from hypertuna.cli.search import GaitLimits, SearchOptions
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.display import Table
from hypertuna.errors import InputError
from hypertuna.io.files import Csv, rows_csv
from hypertuna.optimization.design_space import gait_columns
from hypertuna.optimization.experiment import TankSearch
from hypertuna.swimming.gait import Gait, gait_record
from hypertuna.trials.steady import COLUMNS, MEASURED, SteadyRun, read_steady

STEADY = tuple(COLUMNS[name] for name in MEASURED)  # columns of the measurements in files of steady runs
State = Annotated[str, opt.text("--state", "File that stores the search; created by the first ask.", "FILE")]


@opt.grouped
def ask_command(
    context: typer.Context,
    state: State,
    search: SearchOptions,
    limits: GaitLimits,
    robot: opt.RobotName = "",
    output: Annotated[str | None, opt.file("--output", "the gaits, to be filled in,", ".csv")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Print the next gaits for the tank; after the last batch, why the search stopped and the best gait.

    The first call defines the search; later ones need --state alone. Asking again gives the same gaits until all of
    them are measured. The exit code is 1 if the search has stopped without a gait that satisfies all limits.
    """
    options: dict[str, Any] | None = None
    if robot:
        limit_records = [asdict(limit) for limit in limits.make(load(robot))]
        options = {"robot": robot, "limits": limit_records} | search.arguments() | {"method": search.method or "pso"}
    else:
        check_later(context, {"state", "output", "as_json"})
    with TankSearch(state, options) as experiment:
        stopped = experiment.optimizer.stop is not None
        emit(
            experiment,
            record=_record,
            lines=_lines,
            csv=lambda one: gaits_csv(one.problem.robot, one.ask()),
            output=None if stopped else output,
            as_json=as_json,
            failed=stopped and experiment.best is None,
        )


def check_later(context: typer.Context, kept: Collection[str]) -> None:
    """Check that a call without --robot has no options but those `kept`: the state file holds the others."""
    for name in set(context.params) - {*kept}:
        if str(context.get_parameter_source(name)).endswith("COMMANDLINE"):
            rule = "needs --robot: without it, the state file continues with its own options"
            fix = "leave it out, or give --robot as well"
            raise InputError(rule, key=f"--{name.replace('_', '-')}", value="given alone", fix=fix)


def check_one_source(results: str | Collection[str] | None, value: Collection[str] | None) -> None:
    """Check that results are given by files or by --value, and not by both."""
    if (results is None) == (not value):
        rule = "must be given either in a CSV file or with --value"
        raise InputError(rule, key="results", value="given in both" if value else "given in neither")


def tell_command(
    state: State,
    results: Annotated[
        str | None, typer.Argument(help="CSV file of steady runs: what `ask -o` wrote, with the measurements.")
    ] = None,
    value: Annotated[
        list[str] | None,
        opt.text(
            "--value",
            "Speed in m/s, or SPEED,COST_OF_TRANSPORT, of one gait; repeat it for each gait in the order of the batch.",
        ),
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Enter the measured speeds of the batch's gaits: all of them, or some now and the others later."""
    with TankSearch(state) as experiment:
        check_one_source(results, value)
        runs = _runs_of(value or [], experiment) if results is None else read_steady(results, experiment.problem.robot)
        remaining = experiment.tell(runs)
        if not as_json:
            print_lines([f"{len(runs)} recorded; {remaining or 'none'} of this batch remaining."])
        if as_json or remaining == 0:
            emit(experiment, record=_record, lines=_lines, as_json=as_json)


def _runs_of(texts: list[str], experiment: TankSearch) -> list[SteadyRun]:
    """Return steady runs from the texts of --value, one for each gait of the batch that is not yet measured."""
    gaits = experiment.ask()
    if not gaits:
        raise InputError("has stopped", key="the search", fix="see `hypertuna optimize ask`")
    if len(texts) > len(gaits):
        rule = f"must be given at most {len(gaits)} times, once for each gait of the batch"
        raise InputError(rule, key="--value", value=f"given {len(texts)} times", fix="see `hypertuna optimize ask`")
    runs = []
    for k, (entry, (name, gait)) in enumerate(zip(texts, gaits.items(), strict=False)):
        speed, *cost = numbers(entry, f"--value {k + 1}", "m/s")
        if len(cost) > 1:
            raise InputError("must be SPEED or SPEED,COST_OF_TRANSPORT", key=f"--value {k + 1}", value=entry)
        runs.append(SteadyRun(name, gait, speed=speed, cost_of_transport=cost[0] if cost else None))
    return runs


def _record(experiment: TankSearch) -> dict[str, Any]:
    """Return the JSON record of the next gaits, the best run so far, and how the search ended."""
    best = experiment.best
    return {
        "stop": experiment.optimizer.stop,
        "gaits": [{"run": name} | gait_record(gait) for name, gait in experiment.ask().items()],
        "best": None if best is None else {"gait": gait_record(best.gait)} | _measured(best),
        "evaluations": experiment.optimizer.evaluations,
    } | provenance(experiment.problem.robot)


def _lines(experiment: TankSearch) -> Iterator[Any]:
    """Yield the lines that the terminal shows: the next gaits, or the end of the search, and the best gait so far."""
    robot, best, stop = experiment.problem.robot, experiment.best, experiment.optimizer.stop
    rows = [gait_row(robot, name, gait, ".4g") for name, gait in experiment.ask().items()]
    if rows:
        yield Table([column.replace("_", "\n") for column in rows[0]], [list(row.values()) for row in rows])
    if stop is not None:
        yield stop, "green" if best else "bold red"
        if best is None:
            yield "No measured gait satisfies all limits and swims forward.", "bold red"
    if best is not None:
        values = zip(gait_columns(robot), _values(best.gait), strict=True)
        measured = (f"{key} {value:.4g}" for key, value in _measured(best).items() if value is not None)
        yield f"best of {experiment.optimizer.evaluations}: {', '.join(f'{name} {x:.4g}' for name, x in values if x)}"
        yield f"measured: {', '.join(measured)}"


def _measured(run: SteadyRun) -> dict[str, Any]:
    """Return the measurements of a run by their column names in files of steady runs."""
    return {COLUMNS[name]: getattr(run, name) for name in MEASURED}


def _values(gait: Gait) -> list[float]:
    """Return the values of a gait [Hz, deg] in the order of `gait_columns`."""
    return [gait.frequency, *np.degrees(gait.values[1:]).tolist()]


def gait_row(robot: Robot, name: str, gait: Gait, digits: str = ".6f") -> dict[str, str]:
    """Return the cells of a gait by their column names in files of steady runs."""
    values = (f"{x:{digits}}" for x in _values(gait))
    return {COLUMNS["name"]: name} | dict(zip(gait_columns(robot), values, strict=True))


def gaits_csv(robot: Robot, gaits: Mapping[str, Gait]) -> Csv:
    """Return the CSV table of gaits, with empty cells for the measurements to be filled in."""
    return rows_csv({}, [gait_row(robot, name, gait) | dict.fromkeys(STEADY, "") for name, gait in gaits.items()])
