"""The command `hypertuna identify`."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import command_line, counted, progress_bar, table
from hypertuna.cli.emit import emit
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

UNITS = {"rad": ("deg", 180 / math.pi)}  # units that people read and write in another


@dataclass(frozen=True)
class Fits:
    """Fits of one robot, by water law."""

    by_law: Mapping[str, Fit]
    best: str  # water law
    robot: Robot  # the best fit
    sampled: Posterior | None
    seconds: float
    output: str | None  # file of the robot

    @property
    def fit(self) -> Fit:
        """The best fit."""
        return self.by_law[self.best]


def _unit(name: str) -> tuple[str, float]:
    """Return the unit of a coefficient on the command line, and how many of it are one SI unit."""
    return UNITS["rad"] if name.startswith("joints.phase_offset") else ("its SI unit", 1.0)


def _bound(text: str, key: str) -> parsing.Bound:
    """Read NAME=LOW:HIGH; return SI units."""
    unit, factor = _unit(text)
    name, low, high = parsing.bound(text, key, unit)
    return parsing.Bound(name, low / factor, high / factor)


def _start(text: str, key: str) -> parsing.Setting:
    """Read NAME=VALUE; return SI units."""
    unit, factor = _unit(text)
    name, value = parsing.setting(text, key, unit)
    return parsing.Setting(name, value / factor)


def identify_command(
    trials: Annotated[
        list[str], typer.Argument(help="CSV files of steady runs, TOML manifests of recordings, or published folders.")
    ],
    robot: opt.RobotName,
    free: Annotated[str, opt.text("--free", "Coefficients to fit, such as water.drag[0,1-6,7],joints.bandwidth.")],
    water: Annotated[
        str | None, opt.text("--water", f"Water law: {', '.join(LAWS)}, or several with commas to compare them.")
    ] = None,
    joints: opt.JointLaw = None,
    areas: opt.Areas = None,
    validate: Annotated[
        float, opt.number("--validate", "parts of 1", "Fraction of the runs held out for validation.")
    ] = 0.2,
    seed: opt.Seed = 0,
    loss: opt.Loss = "soft_l1",
    starts: opt.Starts = 4,
    bounds: Annotated[
        list[Any] | None,
        opt.option(
            ("--bounds",), "Bounds of a coefficient; repeatable. (default: those of Table III)", "NAME=LOW:HIGH", _bound
        ),
    ] = None,
    log: Annotated[list[str] | None, opt.text("--log", "Coefficient to fit in log scale; repeatable.", "NAME")] = None,
    start: Annotated[
        list[Any] | None,
        opt.option(
            ("--start",), "Initial value of a coefficient in the first search; repeatable.", "NAME=VALUE", _start
        ),
    ] = None,
    samples: Annotated[
        int | None, opt.whole_number("--posterior", "Sample the posterior (MCMC) with this many steps per walker.")
    ] = None,
    threads: opt.Threads = None,
    checkpoint: opt.Checkpoint = None,
    output: opt.RobotOutput = None,
    report: Annotated[
        str | None, opt.file("--report", help="Write a page on the fit to this .html file.", suffixes=(".html",))
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Fit coefficients of a robot to measured runs, with their uncertainty.

    Exit code 1 means that the search did not converge, or that a run has no settled beat.
    """
    begin, laws = time.monotonic(), _laws(water)
    if samples is not None:
        check_posterior(samples, loss)
    fish = load(robot).using(water=laws[0] if laws else None, joints=joints, areas=areas)
    runs = read_trials(trials, fish)
    options: dict[str, Any] = {
        "validate": validate,
        "seed": seed,
        "loss": loss,
        "starts": starts,
        "bounds": {name: (low, high) for name, low, high in bounds or []},
        "log": [name for names in log or [] for name in split_names(names)],
        "start": dict(start or []),
        "threads": threads,
        "checkpoint": checkpoint,
    }
    with progress_bar("fitting") as progress:
        by_law = _fit(fish, runs, split_names(free), laws, options | {"progress": progress})
    best = min(by_law, key=lambda law: _criterion(by_law[law]))
    fit = by_law[best]
    sampled = None if samples is None else _sample(fit, samples, threads, checkpoint)
    fitted = fit.robot if sampled is None else with_posterior(fit, sampled)
    if output is not None:
        write_robot(fitted, output)
    if report is not None:
        from hypertuna.reports.fit import write_fit  # here, because its import takes longer than a fit

        write_fit(by_law, best, report, sampled=sampled, command=command_line())
    emit(
        Fits(by_law, best, fitted, sampled, time.monotonic() - begin, output),
        record=_all_records,
        lines=_lines,
        written=(output, report),
        as_json=as_json,
        failed=not fit.converged or any(run.get("status") == "not settled" for run in fit.train.runs),
    )


def _fit(robot: Robot, trials: Trials, names: list[str], laws: list[str], options: dict[str, Any]) -> dict[str, Fit]:
    """Fit the coefficients of one water law, or of several."""
    if len(laws) > 1:
        return compare(robot, trials, names, laws, **options)
    return {robot.model.water: identify(robot, trials, names, **options)}


def _sample(fit: Fit, steps: int, threads: int | None, checkpoint: str | None) -> Posterior:
    """Sample the posterior, with a checkpoint of its own."""
    own = Path(checkpoint).with_stem(f"{Path(checkpoint).stem}-posterior") if checkpoint else None
    with progress_bar("sampling") as progress:
        return posterior(fit, steps, threads=threads, checkpoint=own, progress=progress)


def _criterion(fit: Fit) -> float:
    """Return what laws are compared by: Akaike's criterion, or with too few runs for it the Bayesian one."""
    values = (fit.criteria["aicc"], fit.criteria["bic"], 0.0)  # a loss that is no likelihood has neither
    return next(float(value) for value in values if value is not None)


def _laws(text: str | None) -> list[str]:
    """Read water laws."""
    laws = [law.strip() for law in text.split(",")] if text else []
    for law in laws:
        if law not in LAWS:
            raise InputError("must be a water law", key="--water", value=law, fix=did_you_mean(law, LAWS))
    return list(dict.fromkeys(laws))


def _parameters(fit: Fit) -> list[dict[str, Any]]:
    """Return each coefficient with its uncertainty, in the units of the command line."""
    sure = fit.uncertainty
    rows = []
    for k, one in enumerate(fit.free):
        unit, factor = UNITS.get(one.unit, (one.unit, 1.0))
        sd = sure.sd[k] * (fit.values[k] if one.scale == "log" else 1.0)
        rows.append(
            {
                "name": one.name,
                "value": fit.values[k] * factor,
                "sd": sd * factor,
                "low": sure.low[k] * factor,
                "high": sure.high[k] * factor,
                "unit": unit,
                "scale": one.scale,
                "lower": one.lower * factor,
                "upper": one.upper * factor,
                "bound": sure.bound[k],
                "determined": sure.determined[k],
            }
        )
    return rows


def _all_records(fits: Fits) -> dict[str, Any]:
    """Return the JSON record: that of the best fit, and those of all water laws."""
    record = _record(fits.fit, fits.robot, fits.output)
    if fits.sampled is not None:
        record["posterior"] = _posterior_record(fits.fit, fits.sampled)
    if len(fits.by_law) > 1:
        others = {law: _record(fit, fit.robot, None) for law, fit in fits.by_law.items() if law != fits.best}
        record |= {"best": fits.best, "laws": {fits.best: dict(record)} | others}
    return record


def _record(fit: Fit, fitted: Robot, output: str | None) -> dict[str, Any]:
    """Return the JSON record of a fit; the robot is the described one, `fit_hash` that of the fitted one."""
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
    """Return the JSON record of the posterior."""
    factors = [UNITS.get(f.unit, (f.unit, 1.0))[1] for f in fit.free]
    ends = zip(fit.free, sampled.low * factors, sampled.high * factors, strict=True)
    return {
        "parameters": [{"name": f.name, "low": low, "high": high} for f, low, high in ends],
        "acceptance": sampled.acceptance,
        "autocorrelation_steps": sampled.autocorrelation,
        "steps": sampled.steps,
        "walkers": sampled.walkers,
        "sentence": sampled.sentence,
    }


def _lines(fits: Fits) -> Iterator[Any]:
    """Lay out a fit."""
    fit, best = fits.fit, fits.best
    if len(fits.by_law) > 1:
        yield _comparison(fits.by_law)
    fitted, kept = (len(trials.runs) for trials in fit.trials)
    yield f"{fit.robot.name}, {best} water: {counted(fitted, 'run')} fitted, {kept} kept for validation", "bold"
    yield _parameter_table(fits)
    yield _error_table(fit)
    for direction in fit.uncertainty.directions:
        if not direction.determined:
            yield direction.sentence, "yellow"
    for warning in fit.warnings:
        yield warning, "yellow"
    if fits.sampled is not None:
        yield f"{fits.sampled.sentence} {100 * fits.sampled.acceptance:.0f} % of the steps were accepted."
    yield f"{fit.stop} {fits.seconds:.1f} s in all.", "green" if fit.converged else "bold red"


def _parameter_table(fits: Fits) -> Any:
    """Lay out the coefficients."""
    fit, sampled = fits.fit, fits.sampled
    samples = _posterior_record(fit, sampled)["parameters"] if sampled else []
    rows = []
    for k, row in enumerate(_parameters(fit)):
        remark = f"{row['bound']} bound" if row["bound"] else "" if row["determined"] else "open"
        intervals = [row, *([samples[k]] if sampled else [])]
        cells = (f"{part['low']:.4g} .. {part['high']:.4g}" for part in intervals)
        name = row["name"].replace(f"water.{fits.best}.", "water.")  # as in --free; the law stands above
        rows.append([name, f"{row['value']:.5g}", *cells, row["unit"].removeprefix("1"), (remark, "yellow")])
    heads = ["coefficient", "value", "95 % interval", *(["posterior"] if sampled else []), "unit", ""]
    count = len(heads)
    return table(heads, rows, left=(0, count - 2, count - 1), fold=0)  # where it is narrow, names give way


def _error_table(fit: Fit) -> Any:
    """Lay out the errors of training and validation."""
    parts = {"training": fit.train, "validation": fit.validation}
    known = {name: part for name, part in parts.items() if part is not None}
    rows = []
    for key, (label, unit, factor) in LABELS.items():
        if key in fit.train.rms:
            errors = (error.get(key, np.nan) for part in known.values() for error in (part.rms, part.max))
            rows.append([label, *(f"{factor * error:.3g} {unit}" for error in errors)])
    return table(["error", *(head for name in known for head in (f"{name} rms", "max"))], rows)


def _comparison(fits: Mapping[str, Fit]) -> Any:
    """Lay out the criteria of several water laws."""
    keys = [key for key in LABELS if any(key in fit.train.rms for fit in fits.values())]
    rows = []
    for law, fit in fits.items():
        errors = (fit.validation or fit.train).rms
        criteria = ("-" if fit.criteria[name] is None else f"{fit.criteria[name]:.1f}" for name in ("aicc", "bic"))
        cells = (f"{LABELS[key][2] * errors.get(key, np.nan):.3g} {LABELS[key][1]}" for key in keys)
        rows.append([law, str(len(fit.free)), *criteria, *cells])
    heads = ["water law", "coefficients", "AICc", "BIC", *(f"{LABELS[key][0]}, validation rms" for key in keys)]
    return table(heads, rows)
