"""The command `hypertuna identify`."""

import math
import shutil
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import command_line, progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.shards import connected
from hypertuna.description.robot import Robot
from hypertuna.description.schema.water import LAWS
from hypertuna.description.writer import write_robot
from hypertuna.display import Part, Table
from hypertuna.errors import InputError
from hypertuna.identification.cards import digits_table, sampled_card
from hypertuna.identification.identify import Fit, compare, identify
from hypertuna.identification.names import ANGLES, split_names, two_lines, value_of
from hypertuna.identification.posterior import Posterior, check_posterior, posterior, with_posterior
from hypertuna.identification.tables import law_table
from hypertuna.ranges import check_name
from hypertuna.trials.kinds import rigid_in
from hypertuna.trials.trials import read_trials


@dataclass(frozen=True)
class Fits:
    """Fits of one robot, by water law."""

    by_law: Mapping[str, Fit]
    best: str  # water law
    robot: Robot  # with the coefficients of the best fit, or of its posterior
    sampled: Posterior | None
    seconds: float
    output: str | None  # file of the robot

    @property
    def fit(self) -> Fit:
        """The best fit."""
        return self.by_law[self.best]


def _unit(name: str) -> tuple[str, float]:
    """Return the unit of a coefficient on the command line, and the factor from SI to that unit."""
    return ("deg", 180 / math.pi) if value_of(name.partition("=")[0]) in ANGLES else ("its SI unit", 1.0)


def _bound(text: str, key: str) -> parsing.Bound:
    """Return name, low and high [SI] from NAME=LOW:HIGH in the units of the command line."""
    unit, factor = _unit(text)
    name, low, high = parsing.bound(text, key, unit)
    return parsing.Bound(name, low / factor, high / factor)


def _prior(text: str, key: str) -> parsing.Setting:
    """Return name and factor from NAME=FACTOR; key: the option, for errors."""
    return parsing.setting(text, key, "a factor such as 2")


def _start(text: str, key: str) -> parsing.Setting:
    """Return name and value [SI] from NAME=VALUE in the unit of the command line."""
    unit, factor = _unit(text)
    name, value = parsing.setting(text, key, unit)
    return parsing.Setting(name, value / factor)


@dataclass(frozen=True)
class SearchOptions:
    """Options of a fit of coefficients."""

    validate: Annotated[
        float | None,
        opt.number(
            "--validate",
            "parts of 1",
            "Fraction of the runs held out for validation. (default: 0.2, of fewer than six runs 0)",
        ),
    ] = None
    seed: opt.Seed = 0
    loss: opt.Loss = "soft_l1"
    starts: opt.Starts = 4
    bounds: Annotated[
        list[Any] | None,
        opt.option(
            ("--bounds",),
            "Bounds of a coefficient; repeatable. (default: those of data/published/bounds.toml)",
            "NAME=LOW:HIGH",
            _bound,
        ),
    ] = None
    log_scale: Annotated[
        list[str] | None, opt.text("--log", "Coefficient to fit in log scale; repeatable.", "NAME")
    ] = None
    start: Annotated[
        list[Any] | None,
        opt.option(
            ("--start",), "Initial value of a coefficient in the first search; repeatable.", "NAME=VALUE", _start
        ),
    ] = None
    prior: Annotated[
        list[Any] | None,
        opt.option(
            ("--prior",),
            "Factor by which the robot's value of a coefficient may be off, known without the trials; repeatable. "
            "(default: without --free those of data/published/bounds.toml, else none)",
            "NAME=FACTOR",
            _prior,
        ),
    ] = None
    threads: opt.Threads = None
    checkpoint: opt.Checkpoint = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `identify`."""
        bounds = {name: (low, high) for name, low, high in self.bounds or []}
        log = [name for names in self.log_scale or [] for name in split_names(names)]
        prior = None if self.prior is None else dict(self.prior)
        given = {key: value for key, value in vars(self).items() if key != "log_scale"}
        return given | {"bounds": bounds, "log": log, "start": dict(self.start or []), "prior": prior}


@opt.grouped
def identify_command(
    trials: Annotated[
        list[str], typer.Argument(help="CSV files of steady runs, TOML manifests of recordings, or published folders.")
    ],
    robot: opt.RobotOptions,
    search: SearchOptions,
    free: Annotated[
        str | None,
        opt.text(
            "--free",
            "Coefficients to fit, such as water.drag[0,1-6,7],joints.bandwidth,hinge.stiffness; NAME=common is one "
            "factor on the present values. (default: one factor each on drags and added mass of the water law, and "
            "linear drag if the errors of the speed go with speed or frequency)",
        ),
    ] = None,
    water: Annotated[
        str | None, opt.text("--water", f"Water law: {', '.join(LAWS)}, or several with commas to compare them.")
    ] = None,
    joints: opt.JointLaw = None,
    areas: opt.Areas = None,
    samples: Annotated[
        int | None, opt.whole_number("--posterior", "Sample the posterior (MCMC) with this many steps per walker.")
    ] = None,
    cluster: opt.Cluster = None,
    output: opt.RobotOutput = None,
    report: Annotated[str | None, opt.file("--report", "a page on the fit", ".html")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Fit coefficients of a robot to measured runs, with their uncertainty.

    Exit code 1 means that the search did not converge, or that a run has no settled beat.
    """
    begin = time.monotonic()
    laws = list(dict.fromkeys(law.strip() for law in water.split(","))) if water else []
    for law in laws:
        check_name(law, LAWS, "--water", "water law")
    if samples is not None:
        check_posterior(samples, search.loss)
    elif cluster is not None:
        raise InputError("is used only with --posterior", key="--cluster", fix="add --posterior N")
    fish = robot.load(output).using(water=laws[0] if laws else None, joints=joints, areas=areas)
    runs = read_trials(trials, fish)
    if rigid := rigid_in(kind for kind, own in runs.kinds.items() if any(map(kind.leaves_rigid, own))):
        opt.with_rigid_hinge(fish, f"in {rigid}")
    with progress_bar("fitting", parts="stage", checkpoint=search.checkpoint) as progress:
        options = search.arguments() | {"progress": progress}
        names = None if free is None else split_names(free)
        by_law: dict[str, Fit] = (
            compare(fish, runs, names, laws, **options)
            if len(laws) > 1
            else {fish.model.water: identify(fish, runs, names, **options)}
        )
    best = min(by_law, key=lambda law: by_law[law].criterion)
    fit, sampled = by_law[best], None
    if samples is not None:
        file = Path(search.checkpoint) if search.checkpoint else None
        saved = file and file.with_stem(f"{file.stem}-posterior")
        sampling: Any = {"threads": search.threads, "checkpoint": saved}
        with progress_bar("sampling", parts="step", checkpoint=saved) as progress, connected(cluster) as executor:
            sampled = posterior(fit, samples, executor=executor, **sampling, progress=progress)
    fitted = fit.robot if sampled is None else with_posterior(fit, sampled)
    if output is not None:
        write_robot(fitted, output)
    if report is not None:
        from hypertuna.reports.fit import write_fit  # imported here, because the import takes longer than a fit

        write_fit(by_law, best, report, sampled=sampled, command=command_line())
    emit(
        Fits(by_law, best, fitted, sampled, time.monotonic() - begin, output),
        record=_record,
        lines=_lines,
        written=(output, report),
        as_json=as_json,
        failed=not fit.converged or any(run.get("status") == "not settled" for run in fit.train.runs),
    )


def _record(fits: Fits) -> dict[str, Any]:
    """Return the JSON record of the best fit, with the records of the other water laws if there are several."""
    record = fits.fit.record | {"fit_hash": fits.robot.hash, "output": fits.output}
    if fits.sampled is not None:
        record["posterior"] = fits.sampled.record
    if len(fits.by_law) > 1:
        others = {law: fit for law, fit in fits.by_law.items() if law != fits.best}
        laws = {law: fit.record | {"fit_hash": fit.robot.hash, "output": None} for law, fit in others.items()}
        record |= {"best": fits.best, "laws": {fits.best: dict(record)} | laws}
    return record


def _lines(fits: Fits) -> Iterator[Part]:
    """Yield the lines that the terminal prints for the best fit, and for the fits by other water laws."""
    if len(fits.by_law) > 1:
        yield digits_table(*law_table(fits.by_law))
    title, table, *rest = sampled_card(fits.fit, fits.sampled, fits.seconds).lines()
    if isinstance(table, Table) and table.width() > shutil.get_terminal_size().columns:
        table = replace(table, rows=[(two_lines(name), *cells) for name, *cells in table.rows])
    yield from (title, table, *rest)
