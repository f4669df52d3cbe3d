"""The command `hypertuna identify`."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from pathlib import Path
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
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot, load
from hypertuna.description.schema.water import LAWS
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError, did_you_mean
from hypertuna.identification.identify import Fit, compare, identify
from hypertuna.identification.names import split_names
from hypertuna.identification.posterior import Posterior, check_posterior, posterior, with_posterior
from hypertuna.identification.residuals import LABELS
from hypertuna.trials.trials import Trials, read_trials

__all__ = ["identify_command"]

BORDER = {"rad": ("deg", 180 / math.pi)}  # units that people read and write in another


def identify_command(
    trials: Annotated[
        list[str], typer.Argument(help="CSV files of steady runs, TOML manifests of recordings, or published folders.")
    ],
    robot: Annotated[
        str, typer.Option("--robot", help="Name of a robot that comes with hypertuna, or path of its file.")
    ],
    free: Annotated[
        str, typer.Option("--free", help="Coefficients to fit, such as water.drag[0,1-6,7],joints.bandwidth.")
    ],
    water: Annotated[
        str | None, typer.Option("--water", help=f"{', '.join(LAWS)}, or several with commas to compare them.")
    ] = None,
    joints: Annotated[str | None, typer.Option("--joints", help="ideal or bandwidth (default: the robot's)")] = None,
    areas: Annotated[
        str | None, typer.Option("--areas", help="consistent or as-printed (default: the robot's choice)")
    ] = None,
    validate: Annotated[str, typer.Option("--validate", help="Part of the runs that the fit is judged on.")] = "0.2",
    seed: Annotated[str, typer.Option("--seed", help="Of that choice and of the starts.")] = "0",
    loss: Annotated[str, typer.Option("--loss", help="soft_l1, linear, huber or cauchy.")] = "soft_l1",
    starts: Annotated[str, typer.Option("--starts", help="Searches, each from another start.")] = "4",
    bounds: Annotated[
        list[str] | None, typer.Option("--bounds", help="NAME=LOW:HIGH, again for more (default: Table III's).")
    ] = None,
    log: Annotated[list[str] | None, typer.Option("--log", help="NAME to fit in log scale, again for more.")] = None,
    start: Annotated[
        list[str] | None, typer.Option("--start", help="NAME=VALUE of the first start, again for more.")
    ] = None,
    draws: Annotated[
        str | None, typer.Option("--posterior", help="Draw from the posterior with so many steps of each walker.")
    ] = None,
    threads: Annotated[str | None, typer.Option("--threads", help="Threads (default: all processors)")] = None,
    checkpoint: Annotated[
        str | None, typer.Option("--checkpoint", help="File to resume from after an interruption (JSON lines).")
    ] = None,
    output: Annotated[str | None, typer.Option("-o", "--output", help="Write the fitted robot to this .toml.")] = None,
    report: Annotated[str | None, typer.Option("--report", help="Write a page on the fit to this .html.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Fit coefficients of a robot to measured runs, and tell how certain they are.

    Exit code 1 means that the search did not converge, or that a run has no settled beat.
    """
    check_suffix(output, (".toml",), "--output")
    check_suffix(report, (".html",), "--report")
    begun, laws = time.monotonic(), _laws(water)
    steps = 0 if draws is None else whole_number(draws, "--posterior")
    if draws is not None:
        check_posterior(steps, loss)
    fish = load(robot).using(water=laws[0] if laws else None, joints=joints, areas=areas)
    runs = read_trials(trials, fish)
    options: dict[str, Any] = {
        "validate": number(validate, "--validate", "parts of 1"),
        "seed": whole_number(seed, "--seed"),
        "loss": loss,
        "starts": whole_number(starts, "--starts"),
        "bounds": _bounds(bounds or []),
        "log": [name for text in log or [] for name in split_names(text)],
        "start": _start(start or []),
        "threads": None if threads is None else whole_number(threads, "--threads"),
        "checkpoint": checkpoint,
    }
    with progress_bar("fitting") as progress:
        fits = _fits(fish, runs, split_names(free), laws, options | {"progress": progress})
    best = min(fits, key=lambda law: _rank(fits[law]))
    fit = fits[best]
    sampled = None if draws is None else _draw(fit, steps, options)
    fitted = fit.robot if sampled is None else with_posterior(fit, sampled)
    if output is not None:
        write_robot(fitted, output)
    if report is not None:
        from hypertuna.reports.fit import write_fit  # here, because drawing takes longer to import than a fit takes

        write_fit(fits, best, report, sampled=sampled, command=command_line())
    if as_json:
        record = _record(fit, fitted, output)
        if sampled is not None:
            record["posterior"] = _posterior_record(fit, sampled)
        if len(fits) > 1:
            others = {law: _record(one, one.robot, None) for law, one in fits.items() if law != best}
            record |= {"best": best, "laws": {best: dict(record)} | others}
        print_json(record)
    else:
        _print(fits, best, sampled, time.monotonic() - begun)
        tell_written(output, report)
    if not fit.converged or any("status" in run for run in fit.train.runs if run.get("status") == "not settled"):
        raise typer.Exit(1)


def _fits(robot: Robot, trials: Trials, names: list[str], laws: list[str], options: dict[str, Any]) -> dict[str, Fit]:
    """Fit the one law, or several."""
    if len(laws) > 1:
        return compare(robot, trials, names, laws, **options)
    return {robot.model.water: identify(robot, trials, names, **options)}


def _draw(fit: Fit, steps: int, options: Mapping[str, Any]) -> Posterior:
    """Draw from the posterior, with a bar of its own."""
    checkpoint = options["checkpoint"]
    own = Path(checkpoint).with_stem(f"{Path(checkpoint).stem}-posterior") if checkpoint else None
    with progress_bar("drawing") as progress:
        return posterior(fit, steps, threads=options["threads"], checkpoint=own, progress=progress)


def _rank(fit: Fit) -> float:
    """Return what laws are compared by: Akaike's criterion, or the Bayesian one where there are too few runs for it."""
    values = (fit.criteria["aicc"], fit.criteria["bic"], 0.0)  # a loss that is no likelihood has neither
    return next(float(value) for value in values if value is not None)


def _laws(text: str | None) -> list[str]:
    """Read water laws."""
    laws = [law.strip() for law in text.split(",")] if text else []
    for law in laws:
        if law not in LAWS:
            raise InputError("must be a water law", key="--water", value=law, fix=did_you_mean(law, LAWS))
    return list(dict.fromkeys(laws))


def _pair(text: str, key: str, form: str) -> tuple[str, str]:
    """Split NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not value.strip():
        raise InputError(f"must be {form}", key=key, value=text, fix=f"write it as {form}")
    return name.strip(), value.strip()


def _factor(name: str) -> tuple[str, float]:
    """Return the unit that a coefficient has on the command line, and how many of it are one SI unit."""
    return BORDER["rad"] if name.startswith("joints.phase_offset") else ("its SI unit", 1.0)


def _bounds(texts: list[str]) -> dict[str, tuple[float, float]]:
    """Read bounds."""
    found = {}
    for text in texts:
        name, value = _pair(text, "--bounds", "NAME=LOW:HIGH")
        unit, factor = _factor(name)
        ends = value.split(":")
        if len(ends) != 2:
            raise InputError("must be LOW:HIGH", key=f"--bounds {name}", value=value, fix="write it as 0:30")
        low, high = (number(end, f"--bounds {name}", unit) / factor for end in ends)
        found[name] = (low, high)
    return found


def _start(texts: list[str]) -> dict[str, float]:
    """Read starts."""
    found = {}
    for text in texts:
        name, value = _pair(text, "--start", "NAME=VALUE")
        unit, factor = _factor(name)
        found[name] = number(value, f"--start {name}", unit) / factor
    return found


def _parameters(fit: Fit) -> list[dict[str, Any]]:
    """Say what became of each coefficient, in the units that people read."""
    sure = fit.uncertainty
    rows = []
    for k, f in enumerate(fit.free):
        unit, factor = BORDER.get(f.unit, (f.unit, 1.0))
        sd = sure.sd[k] * (fit.values[k] if f.scale == "log" else 1.0)
        rows.append(
            {
                "name": f.name,
                "value": fit.values[k] * factor,
                "sd": sd * factor,
                "low": sure.low[k] * factor,
                "high": sure.high[k] * factor,
                "unit": unit,
                "scale": f.scale,
                "lower": f.lower * factor,
                "upper": f.upper * factor,
                "bound": sure.bound[k],
                "determined": sure.determined[k],
            }
        )
    return rows


def _record(fit: Fit, fitted: Robot, output: str | None) -> dict[str, Any]:
    """Say what a fit found, for programs; the robot is the one described, the fitted one is told by its hash."""
    sure = fit.uncertainty
    judged = fit.validation
    return (
        {
            "stop": fit.stop,
            "converged": fit.converged,
            "seconds": fit.seconds,
            "evaluations": fit.evaluations,
            "costs": fit.costs,
            "parameters": _parameters(fit),
            "correlation": sure.correlation,
            "directions": [
                {
                    "singular_value": d.singular_value,
                    "sd": d.sd,
                    "determined": d.determined,
                    "sentence": d.sentence,
                    "vector": d.vector,
                }
                for d in sure.directions
            ],
            "noise": fit.noise,
            "interval_factor": sure.factor,
            "train": {"rms": fit.train.rms, "max": fit.train.max, "runs": fit.train.runs},
            "validation": None if judged is None else {"rms": judged.rms, "max": judged.max, "runs": judged.runs},
            "criteria": fit.criteria,
            "warnings": fit.warnings,
            "loss": fit.loss,
            "seed": fit.seed,
        }
        | provenance(fit.described)
        | {"fit_hash": fitted.hash, "output": output}
    )


def _posterior_record(fit: Fit, sampled: Posterior) -> dict[str, Any]:
    """Say what the posterior is like, for programs."""
    factors = [BORDER.get(f.unit, (f.unit, 1.0))[1] for f in fit.free]
    ends = zip(fit.free, sampled.low * factors, sampled.high * factors, strict=True)
    return {
        "parameters": [{"name": f.name, "low": low, "high": high} for f, low, high in ends],
        "acceptance": sampled.acceptance,
        "autocorrelation_steps": sampled.autocorrelation,
        "steps": sampled.steps,
        "walkers": sampled.walkers,
        "sentence": sampled.sentence,
    }


def _print(fits: Mapping[str, Fit], best: str, sampled: Posterior | None, seconds: float) -> None:
    """Print a fit as tables and sentences."""
    console = Console()
    fit = fits[best]
    if len(fits) > 1:
        console.print(_comparison(fits))
    runs = [len(trials.runs) for trials in fit.trials]
    fitted = f"{runs[0]} run{'s' * (runs[0] != 1)} fitted"
    head = f"{fit.robot.name}, {best} water: {fitted}, {runs[1]} kept for validation"
    console.print(Text(head, style="bold"))
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("coefficient", overflow="fold")  # where it is narrow, names give way and not what is said of them
    for name in ("value", "95 % interval", *(["posterior"] if sampled else [])):
        table.add_column(name, justify="right", no_wrap=True)
    for name in ("unit", ""):
        table.add_column(name, no_wrap=True)
    drawn = _posterior_record(fit, sampled)["parameters"] if sampled else []
    for k, row in enumerate(_parameters(fit)):
        remark = f"{row['bound']} bound" if row["bound"] else "" if row["determined"] else "open"
        interval = f"{row['low']:.4g} .. {row['high']:.4g}"
        beside = [f"{drawn[k]['low']:.4g} .. {drawn[k]['high']:.4g}"] if sampled else []
        cells = (f"{row['value']:.5g}", interval, *beside, row["unit"].removeprefix("1"))
        name = row["name"].replace(f"water.{best}.", "water.")  # as --free takes it; the law stands above
        table.add_row(Text(name), *cells, Text(remark, style="yellow"))
    console.print(table)
    console.print(_errors(fit))
    for direction in fit.uncertainty.directions:
        if not direction.determined:
            console.print(Text(direction.sentence, style="yellow"))
    for warning in fit.warnings:
        console.print(Text(warning, style="yellow"))
    if sampled is not None:
        console.print(Text(f"{sampled.sentence} {100 * sampled.acceptance:.0f} % of the steps were taken."))
    console.print(Text(f"{fit.stop} {seconds:.1f} s in all.", style="green" if fit.converged else "bold red"))


def _errors(fit: Fit) -> Table:
    """Lay out the errors of training and validation."""
    table = Table("error", box=None, pad_edge=False, header_style="bold")
    parts = {"training": fit.train, "validation": fit.validation}
    for name, part in parts.items():
        if part is not None:
            table.add_column(f"{name} rms", justify="right")
            table.add_column("largest", justify="right")
    for key, (label, unit, factor) in LABELS.items():
        if key in fit.train.rms:
            cells = [
                f"{factor * table.get(key, np.nan):.3g} {unit}"
                for part in parts.values()
                if part is not None
                for table in (part.rms, part.max)
            ]
            table.add_row(label, *cells)
    return table


def _comparison(fits: Mapping[str, Fit]) -> Table:
    """Lay out what laws are compared by."""
    table = Table("water law", box=None, pad_edge=False, header_style="bold")
    for name in ("coefficients", "AICc", "BIC"):
        table.add_column(name, justify="right")
    keys = [key for key in LABELS if any(key in fit.train.rms for fit in fits.values())]
    for key in keys:
        table.add_column(f"{LABELS[key][0]}, validation rms", justify="right")
    for law, fit in fits.items():
        judged = (fit.validation or fit.train).rms
        told = ("-" if fit.criteria[name] is None else f"{fit.criteria[name]:.1f}" for name in ("aicc", "bic"))
        cells = [f"{LABELS[key][2] * judged.get(key, np.nan):.3g} {LABELS[key][1]}" for key in keys]
        table.add_row(law, str(len(fit.free)), *told, *cells)
    return table
