"""Identify: fit free coefficients to trials and compute their uncertainty."""

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arguments import checked
from hypertuna.arrays import Array
from hypertuna.description.provenance import journal_header, provenance
from hypertuna.description.robot import Robot, robot_of
from hypertuna.description.schema.water import LAWS
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, InputErrors, shown
from hypertuna.identification.coefficients import Free, free, from_scale, with_fit
from hypertuna.identification.experiment import Experiment, experiment
from hypertuna.identification.loss import LOSSES
from hypertuna.identification.names import default_bounds, default_names, default_priors, free_of, split_names
from hypertuna.identification.prediction import predict
from hypertuna.identification.residuals import LABELS, Errors, criteria, errors
from hypertuna.identification.search import CONVERGED, start_points, subset
from hypertuna.identification.search import fit as search
from hypertuna.identification.sentences import held_by_priors, large_errors, repeated_motions, unmet, warnings_of
from hypertuna.identification.trends import Trend, linear_drag, trends
from hypertuna.identification.uncertainty import Uncertainty, uncertainty
from hypertuna.io.checkpoint import Journal
from hypertuna.io.files import version
from hypertuna.ranges import NOT_NEGATIVE, Range, Whole, check_name
from hypertuna.swimming.beat import DEFAULT_STEPS, check_steps
from hypertuna.trials.kinds import KINDS, kind_of
from hypertuna.trials.reach import reach_of
from hypertuna.trials.trials import Trials, digest, implausible, read_trials, split

Paths = str | Path | Sequence[str | Path]

FRACTION_LEFT, STARTS = Range(min=0, below=1), Whole(min=1, max=4096)
VALIDATE, ENOUGH = 0.2, 6  # part of the runs kept for validation by default, and runs below which none are
SNAP = 1e-6  # of the allowed range: a value closer than this to a bound is set on it


@dataclass(frozen=True)
class Fit(Plotted, Tabular, data=lambda fit: fit.parameters):
    """A fit of free coefficients to trials."""

    robot: Robot  # with the fitted values, and a table [fit]
    described: Robot  # before the fit
    free: tuple[Free, ...]
    values: Array  # (n,) [SI]
    uncertainty: Uncertainty
    noise: dict[str, float]  # estimated, of the kinds of measurement without stated noise: relative, m or rad
    train: Errors
    validation: Errors | None  # of runs that the fit has not seen
    criteria: dict[str, Any]  # of `hypertuna.identification.residuals.criteria`
    stop: str  # why the search ended
    converged: bool
    path: Array  # (iterations, n) [SI], values after each iteration of the best search
    costs: tuple[float, ...]  # of each start: half the sum of the loss
    evaluations: int  # predictions of all runs, from all starts
    seconds: float
    warnings: tuple[str, ...]
    trends: tuple[Trend, ...]  # of the errors of the speed
    seed: int
    loss: str
    steps: int  # Runge-Kutta steps per beat
    trials: tuple[Trials, Trials]  # for training, and for validation

    @property
    def parts(self) -> dict[str, Errors]:
        """Errors of training and, if there are any, of validation."""
        return {"training": self.train} | ({} if self.validation is None else {"validation": self.validation})

    @property
    def criterion(self) -> float:
        """What water laws are compared by: Akaike's criterion, or with too few runs for it the Bayesian one."""
        values = (self.criteria["aicc"], self.criteria["bic"], 0.0)  # a loss that is no likelihood has neither
        return next(float(value) for value in values if value is not None)

    @property
    def quantities(self) -> list[str]:
        """Quantities of the errors, keys of `hypertuna.identification.residuals.LABELS`."""
        return [key for key in LABELS if any(key in part.rms for part in self.parts.values())]

    @property
    def parameters(self) -> list[dict[str, Any]]:
        """Coefficients with their uncertainty, angles in degrees."""
        rows, sure = [], self.uncertainty
        for k, (one, value) in enumerate(zip(self.free, self.values, strict=True)):
            unit, factor = one.border
            sd = sure.sd[k] * (value if one.scale == "log" else 1.0)
            told = 1.0 if sure.estimated or one.prior else math.nan
            sizes = {"value": value, "sd": sd, "low": told * sure.low[k], "high": told * sure.high[k]}
            facts = {"unit": unit, "scale": one.scale, "lower": one.lower * factor, "upper": one.upper * factor}
            known = one.prior and {"value": one.prior[0] * factor, "factor": one.prior[1]}
            judged = {"prior": known, "bound": sure.bound[k], "constrained": sure.constrained[k]}
            rows.append({"name": one.name} | {key: size * factor for key, size in sizes.items()} | facts | judged)
        return rows

    @property
    def record(self) -> dict[str, Any]:
        """Record of the fit, for JSON; its robot is the described one."""
        search = ("stop", "converged", "seconds", "evaluations", "costs", "loss", "seed")
        return {name: getattr(self, name) for name in (*search, "noise", "criteria", "warnings")} | {
            "parameters": self.parameters,
            "correlation": self.uncertainty.correlation,
            "directions": [vars(direction) for direction in self.uncertainty.directions],
            "interval_factor": self.uncertainty.factor,
            "train": vars(self.train),
            "validation": None if self.validation is None else vars(self.validation),
            **provenance(self.described),
        }


@checked
def identify(
    robot: Robot | str | Path,
    trials: Trials | Paths,
    free: str | Sequence[str] | Sequence[Free] | None = None,
    *,
    validate: float | None = None,
    seed: int = 0,
    loss: str = "soft_l1",
    starts: int = 4,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    log: Sequence[str] = (),
    start: Mapping[str, float] | None = None,
    prior: Mapping[str, float] | None = None,
    steps: int = DEFAULT_STEPS,
    threads: int | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Fit:
    """Fit free coefficients to trials (section III.E of the paper, with exact derivatives): see docs/identify.md.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file.
    trials : Trials, str, Path or sequence of paths
        As `hypertuna.read_trials` returns them, or its argument.
    free : str, sequence of str, or of Free
        Names for `hypertuna.identification.coefficients.free`; in one text, separated by commas. Default: one common
        factor each on drag along the body, drag across it, added mass and blunt areas of the water law; and linear drag
        along the body, if the errors of the speed go with speed or frequency without it.
    validate : float, optional
        Fraction of the runs, chosen at random, that is kept for validation [1]. Default: 0.2, of fewer than six runs 0.
    seed : int
        Of that choice, and of the starts.
    loss : {"soft_l1", "linear", "huber", "cauchy"}
        Robust loss of residuals beyond their standard deviation.
    starts : int
        Searches: from the robot's values, from those of Table III (data/published/bounds.toml), then from Sobol points
        within the bounds. The best one counts.
    bounds, log, start : optional
        As for `hypertuna.identification.coefficients.free` [SI].
    prior : mapping of str to float, optional
        Factors by which the robot's values may be off [1], known without the trials: one standard deviation of the
        logarithm. Default: without `free` those of data/published/bounds.toml, else none.
    steps : int
        Runge-Kutta steps per beat.
    threads : int, optional
        Default: all processors. The result does not depend on it.
    checkpoint : str or Path, optional
        File of finished searches, to resume an interrupted fit.
    progress : callable, optional
        Called with the finished searches and their total.

    Returns
    -------
    Fit
    """
    robot = robot_of(robot)
    begun = time.monotonic()
    trials = _trials(robot, trials)
    validate = (VALIDATE if len(trials.runs) >= ENOUGH else 0.0) if validate is None else validate
    FRACTION_LEFT.check(validate, "validate", "give a fraction such as 0.2, or 0 for none")
    NOT_NEGATIVE.check(seed, "seed", "give 0 or more")
    check_name(loss, LOSSES, "loss", "loss")
    STARTS.check(starts, "starts", "leave it out")
    check_steps(steps)
    wrong, far = implausible(trials, robot)
    if wrong:
        raise InputErrors(wrong) if len(wrong) > 1 else wrong[0]
    if prior is None and free is None:
        prior = default_priors(robot)
    chosen = {"bounds": bounds, "log": log, "start": start, "prior": prior}
    names = default_names(robot) if free is None else _names(free)
    frees = _frees(robot, trials, names, chosen)
    runs = split(trials, validate, seed)
    settings: dict[str, Any] = {"loss": loss, "steps": steps, "threads": threads or len(os.sched_getaffinity(0))}
    asked = {"validate": validate, "seed": seed, "loss": loss, "starts": starts, "steps": steps}
    options = {"trials": digest(trials)} | _options(frees) | asked
    with Journal(checkpoint, journal_header("identify", robot, options)) as journal:
        fit = _fit(robot, runs, frees, settings, starts, seed, journal, progress)
        if free is None and (more := linear_drag(fit.trends)):
            begin = {more: default_bounds()["coefficient"][more.partition("[")[0]]["start"]}  # a search leaves no bound
            frees = _frees(robot, trials, [*names, more], chosen | {"start": dict(start or {}) | begin})
            fit = _with_linear_drag(fit, _fit(robot, runs, frees, settings, starts, seed, journal))
    return replace(fit, seconds=time.monotonic() - begun, warnings=(*far, *fit.warnings))


def _options(frees: Sequence[Free]) -> dict[str, Any]:
    """Return what a checkpoint holds of the free coefficients."""
    return {
        "free": [f.name for f in frees],
        "bounds": [[f.lower, f.upper] for f in frees],
        "scale": [f.scale for f in frees],
        "start": [f.start for f in frees],
        "prior": [f.prior for f in frees],
    }


def _fit(
    robot: Robot,
    runs: tuple[Trials, Trials],
    frees: tuple[Free, ...],
    settings: Mapping[str, Any],
    starts: int,
    seed: int,
    journal: Journal,
    progress: Callable[[int, int], None] | None = None,
) -> Fit:
    """Return the fit to the first of two parts of the runs; the second validates it."""
    training, held_out = runs
    data, part = (experiment(robot, t, frees, **settings) for t in (training, subset(training, len(frees))))
    result, levels = search(data, part, start_points(frees, starts, seed), journal, progress)
    return _result(data, part, held_out, result, levels, seed)


def _with_linear_drag(fit: Fit, more: Fit) -> Fit:
    """Return the fit with linear drag, which says why it is free; or the first one if that drag comes out as 0."""
    if more.uncertainty.bound[-1] == "lower":
        return fit
    errors = [100 * one.train.rms["speed_relative"] for one in (fit, more) if "speed_relative" in one.train.rms]
    gain = (
        "; the training error of the speed is {1:.2g} % with it and {0:.2g} % without".format(*errors) if errors else ""
    )
    quantity = next(trend.quantity for trend in fit.trends if trend.quantity != "amplitude")
    why = f"{more.free[-1].name} is free, because errors of the speed go with {quantity}{gain}."
    return replace(more, warnings=(why, *more.warnings), evaluations=fit.evaluations + more.evaluations)


def compare(
    robot: Robot, trials: Trials | Paths, free: str | Sequence[str] | None, laws: Sequence[str], **options: Any
) -> dict[str, Fit]:
    """Fit several water laws to the same runs, by law; options are those of `identify`.

    Each law takes the free coefficients that it has, and a checkpoint is a file for each law. Compare `validation` and
    `criteria`: lower is better. The loss "cauchy" is no likelihood and raises an InputError.
    """
    if options.get("loss") == "cauchy":
        rule, fix = "must follow from a likelihood to compare water laws", "choose soft_l1, huber or linear"
        raise InputError(rule, key="loss", value="'cauchy', whose integral is infinite", fix=fix)
    trials = _trials(robot, trials)
    fits: dict[str, Fit] = {}
    for law in laws:
        own = robot.using(water=law)
        names = None if free is None else free_of(own, [str(name) for name in _names(free)])
        if names == ():
            fix = f"name some, such as water.{law}.{LAWS[law].example}"
            raise InputError(f"must name a coefficient of the {law} law", key="free", fix=fix)
        checkpoint = options.get("checkpoint")
        file = Path(checkpoint).with_stem(f"{Path(checkpoint).stem}-{law}") if checkpoint else None
        prior = options.get("prior") or {} if free is not None else default_priors(own) | (options.get("prior") or {})
        prior = {name: prior[name] for name in free_of(own, list(prior))}
        fits[law] = identify(own, trials, names, **(options | {"checkpoint": file, "prior": prior}))
    has_own = {law: any(f.column.startswith(f"water.{law}.") for f in fit.free) for law, fit in fits.items()}
    if not any(has_own.values()):
        return fits
    rest = "it uses those of the description, and the comparison is not on equal terms"
    warnings = [
        f"The {law} law has no free water coefficient of its own: {rest}." for law in has_own if not has_own[law]
    ]
    return {law: replace(fit, warnings=(*warnings, *fit.warnings)) for law, fit in fits.items()}


def _trials(robot: Robot, given: Trials | Paths) -> Trials:
    """Read trials, unless they are read already."""
    if not isinstance(robot, Robot):
        raise InputError("must be a robot", key="robot", value=shown(robot), fix="give what hypertuna.load returns")
    if isinstance(given, Trials):
        return given
    several = isinstance(given, (list, tuple)) and all(isinstance(path, (str, Path)) for path in given)
    if not several and not isinstance(given, (str, Path)):
        fix = "give what hypertuna.read_trials returns, a path, or a list of paths"
        raise InputError("must be trials or paths", key="trials", value=f"a {type(given).__name__}", fix=fix)
    return read_trials(given, robot)


def _names(given: str | Sequence[str] | Sequence[Free]) -> Sequence[str] | Sequence[Free]:
    """Return names of coefficients as a sequence."""
    if isinstance(given, str):
        return split_names(given)
    if not isinstance(given, (list, tuple)):
        rule, fix = "must be names of coefficients", "give a text, or a list of texts"
        raise InputError(rule, key="free", value=f"a {type(given).__name__}", fix=fix)
    return given


def _frees(
    robot: Robot, trials: Trials, names: Sequence[str] | Sequence[Free], options: Mapping[str, Any]
) -> tuple[Free, ...]:
    """Return the free coefficients of names, or those given."""
    if names and all(isinstance(name, Free) for name in names):
        return tuple(name for name in names if isinstance(name, Free))
    texts = [name for name in names if isinstance(name, str)]
    if len(texts) < len(names):
        raise InputError("must be all names, or all of type Free", key="free", fix="give one kind of both")
    offsets = {recording.name: recording.time_offset for recording in trials.recordings}
    frees = free(robot, texts, recordings=offsets, **options)
    told = any(kind_of(trial).tells(trial, "cost_factor") for trial in trials.members)
    if any(f.column == "cost_factor" for f in frees) and not told:
        fix = "leave it out, or give runs with their cost of transport or power"
        raise InputError("needs measured costs of transport, and the trials have none", key="free cost_factor", fix=fix)
    return frees


def _result(
    data: Experiment, part: Experiment, held_out: Trials, result: Mapping[str, Any], levels: dict[str, float], seed: int
) -> Fit:
    """Return the fit of a search result; part: some of the runs, for the profile likelihood."""
    robot, frees, trials = data.robot, data.free, (data.trials, held_out)
    values = from_scale(frees, result["x"])
    lower, upper = np.array([[f.lower, f.upper] for f in frees]).T
    near = SNAP * (upper - lower)  # the search stays inside
    values = np.where(values - lower < near, lower, np.where(upper - values < near, upper, values))
    prediction = predict(data, values, gradient_steps=data.steps, levels=levels)
    intervals = uncertainty(data, values, prediction, levels, part)
    validation = None
    if held_out.runs:
        unseen = experiment(robot, held_out, frees, steps=data.steps, threads=data.threads)
        validation = errors(unseen, predict(unseen, values, gradient_steps=None, levels=levels))
    named = [trial.file for kind in KINDS for part in trials for trial in part.kinds.get(kind, ())]
    files = ", ".join(dict.fromkeys(Path(file).name or "memory" for file in named))
    text = f"identified by hypertuna {version()} from {len(data.trials.runs)} runs of {files}"
    covariance = intervals.bounded_covariance
    warnings = warnings_of(data, values, intervals.bound, intervals.directions, intervals.residual_scale, prediction)
    warnings += held_by_priors(frees, intervals.sd)
    large, found = large_errors(data, prediction), trends(data, values, prediction, seed)
    stop = result["stop"].removesuffix(".") + "".join(f", but to a training error of {text}" for text in large) + "."
    return Fit(
        robot=with_fit(
            robot, frees, values, covariance=covariance, trials=files, seed=seed, text=text, reach=reach_of(data.trials)
        ),
        described=robot,
        free=frees,
        values=values,
        uncertainty=intervals,
        noise=levels,
        train=errors(data, prediction),
        validation=validation,
        criteria=criteria(data, prediction, levels),
        stop=stop,
        converged=result["status"] in CONVERGED,
        path=np.array([from_scale(frees, np.array(x)) for x in result["path"]]),
        costs=tuple(result["costs"]),
        evaluations=result["evaluations"],
        seconds=0.0,
        warnings=(*warnings, *repeated_motions(*trials), *(trend.sentence for trend in found), *map(unmet, large)),
        trends=found,
        seed=seed,
        loss=data.loss,
        steps=data.steps,
        trials=trials,
    )
