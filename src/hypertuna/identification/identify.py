"""Identify: fit free coefficients to trials, and compute their uncertainty."""

import math
import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
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
from hypertuna.errors import InputError, InputErrors, escaped, shown
from hypertuna.identification.coefficients import Free, free, from_scale, with_fit, with_values
from hypertuna.identification.columns import is_spring
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
from hypertuna.swimming.yielding import steps_for
from hypertuna.trials.kinds import KINDS, kind_of
from hypertuna.trials.reach import reach_of
from hypertuna.trials.trials import Trials, digest, implausible, read_trials, split

Paths = str | Path | Sequence[str | Path]

FRACTION_LEFT, STARTS = Range(min=0, below=1), Whole(min=1, max=4096)  # allowed values of `validate` and `starts`
VALIDATE, MIN_RUNS = 0.2, 6  # default fraction of runs kept for validation, and number of runs below which none are
SNAP = 1e-6  # fraction of the allowed range: a value closer to a bound is set to the bound
MAX_NAMED, MAX_NAME = 50, 100  # files of trials that a fit names, and characters of a name


@dataclass(frozen=True)
class Fit(Plotted, Tabular, data=lambda fit: fit.parameters):
    """A fit of free coefficients to trials."""

    robot: Robot  # with the fitted values, and a table [fit]
    described: Robot  # the robot before the fit
    free: tuple[Free, ...]
    values: Array  # (n,) [SI]
    uncertainty: Uncertainty
    noise: dict[str, float]  # estimated noise levels of quantities without stated noise: relative, m or rad
    train: Errors
    validation: Errors | None  # errors of runs that the fit has not seen
    criteria: dict[str, Any]  # information criteria, from `hypertuna.identification.residuals.criteria`
    stop: str  # why the search ended
    converged: bool
    path: Array  # (iterations, n) [SI], values after each iteration of the best search
    costs: tuple[float, ...]  # half of the summed loss, for each start
    evaluations: int  # number of predictions of all runs, over all starts
    seconds: float
    warnings: tuple[str, ...]
    trends: tuple[Trend, ...]  # of the speed's errors with frequency, amplitude or speed
    seed: int
    loss: str
    steps: int  # Runge-Kutta steps per beat
    trials: tuple[Trials, Trials]  # training and validation runs

    @property
    def parts(self) -> dict[str, Errors]:
        """Errors of training and, if there are any, of validation."""
        return {"training": self.train} | ({} if self.validation is None else {"validation": self.validation})

    @property
    def criterion(self) -> float:
        """Criterion that compares water laws (lower is better): Akaike's, or the Bayesian one if there are few runs."""
        # 0 for a loss that is no likelihood, which has neither.
        values = (self.criteria["aicc"], self.criteria["bic"], 0.0)
        return next(float(value) for value in values if value is not None)

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities that have errors, as keys of `hypertuna.identification.residuals.LABELS`."""
        return [key for key in LABELS if any(key in part.rms for part in self.parts.values())]

    @property
    def parameters(self) -> list[dict[str, Any]]:
        """Coefficients with their uncertainty, angles in degrees."""
        rows, intervals = [], self.uncertainty
        for k, (f, value) in enumerate(zip(self.free, self.values, strict=True)):
            unit, factor = f.border
            sd = intervals.sd[k] * (value if f.scale == "log" else 1.0)
            mask = 1.0 if intervals.estimated or f.prior else math.nan
            numbers = {"value": value, "sd": sd, "low": mask * intervals.low[k], "high": mask * intervals.high[k]}
            facts = {"unit": unit, "scale": f.scale, "lower": f.lower * factor, "upper": f.upper * factor}
            prior = f.prior and {"value": f.prior[0] * factor, "factor": f.prior[1]}
            verdicts = {"prior": prior, "bound": intervals.bound[k], "constrained": intervals.constrained[k]}
            rows.append({"name": f.name} | {key: size * factor for key, size in numbers.items()} | facts | verdicts)
        return rows

    @property
    def record(self) -> dict[str, Any]:
        """Record of the fit for JSON; its provenance is of the robot before the fit."""
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
    validate = (VALIDATE if len(trials.runs) >= MIN_RUNS else 0.0) if validate is None else validate
    FRACTION_LEFT.check(validate, "validate", "give a fraction such as 0.2, or 0 for none")
    NOT_NEGATIVE.check(seed, "seed", "give 0 or more")
    check_name(loss, LOSSES, "loss", "loss")
    STARTS.check(starts, "starts", "leave it out")
    check_steps(steps)
    faults, remarks = implausible(trials, robot)
    if faults:
        raise InputErrors(faults) if len(faults) > 1 else faults[0]
    if prior is None and free is None:
        prior = default_priors(robot)
    choices = {"bounds": bounds, "log": log, "start": start, "prior": prior}
    names = default_names(robot) if free is None else _names(free)
    frees = _frees(robot, trials, names, choices)
    _check_springs(robot, trials, frees, steps)
    runs = split(trials, validate, seed)
    settings: dict[str, Any] = {"loss": loss, "steps": steps, "threads": threads or len(os.sched_getaffinity(0))}
    arguments = {"validate": validate, "seed": seed, "loss": loss, "starts": starts, "steps": steps}
    options = {"trials": digest(trials)} | _free_options(frees) | arguments
    with Journal(checkpoint, journal_header("identify", robot, options)) as journal:
        fit = _fit(robot, runs, frees, settings, starts, seed, journal, progress)
        if free is None and (drag := linear_drag(fit.trends)):
            # A search does not leave a bound.
            begin = {drag: default_bounds()["coefficient"][drag.partition("[")[0]]["start"]}
            frees = _frees(robot, trials, [*names, drag], choices | {"start": dict(start or {}) | begin})
            fit = _with_linear_drag(fit, _fit(robot, runs, frees, settings, starts, seed, journal))
    return replace(fit, seconds=time.monotonic() - begun, warnings=(*remarks, *fit.warnings))


def _free_options(frees: Sequence[Free]) -> dict[str, Any]:
    """Return names, bounds, scales, starts and priors of the free coefficients, for the header of a checkpoint."""
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
    """Fit the coefficients to training runs, and validate the fit with the others; runs: (training, validation)."""
    training, held_out = runs
    data, rough_data = (experiment(robot, t, frees, **settings) for t in (training, subset(training, len(frees))))
    result, levels = search(data, rough_data, start_points(frees, starts, seed), journal, progress)
    return _result(data, rough_data, held_out, result, levels, seed)


def _with_linear_drag(fit: Fit, with_drag: Fit) -> Fit:
    """Return the fit with linear drag, and a warning why it is free; or `fit`, without it, if the fitted drag is 0."""
    if with_drag.uncertainty.bound[-1] == "lower":
        return fit
    errors = [100 * each.train.rms["speed_relative"] for each in (fit, with_drag) if "speed_relative" in each.train.rms]
    gain = (
        "; the training error of the speed is {1:.2g} % with it and {0:.2g} % without".format(*errors) if errors else ""
    )
    quantity = next(trend.quantity for trend in fit.trends if trend.quantity != "amplitude")
    why = f"{with_drag.free[-1].name} is free, because errors of the speed go with {quantity}{gain}."
    return replace(with_drag, warnings=(why, *with_drag.warnings), evaluations=fit.evaluations + with_drag.evaluations)


def compare(
    robot: Robot, trials: Trials | Paths, free: str | Sequence[str] | None, laws: Sequence[str], **options: Any
) -> dict[str, Fit]:
    """Fit several water laws to the same runs; return the fits by law. options: those of `identify`.

    Each law uses those of the free coefficients that it has, and a checkpoint file of its own. Compare `validation` and
    `criteria`: lower is better. The loss "cauchy" is no likelihood and raises an InputError.
    """
    if options.get("loss") == "cauchy":
        rule, fix = "must follow from a likelihood to compare water laws", "choose soft_l1, huber or linear"
        raise InputError(rule, key="loss", value="'cauchy', whose integral is infinite", fix=fix)
    trials = _trials(robot, trials)
    fits: dict[str, Fit] = {}
    for law in laws:
        fish = robot.using(water=law)
        names = None if free is None else free_of(fish, [str(name) for name in _names(free)])
        if names == ():
            fix = f"name some, such as water.{law}.{LAWS[law].example}"
            raise InputError(f"must name a coefficient of the {law} law", key="free", fix=fix)
        checkpoint = options.get("checkpoint")
        file = Path(checkpoint).with_stem(f"{Path(checkpoint).stem}-{law}") if checkpoint else None
        prior = options.get("prior") or {} if free is not None else default_priors(fish) | (options.get("prior") or {})
        prior = {name: prior[name] for name in free_of(fish, list(prior))}
        fits[law] = identify(fish, trials, names, **(options | {"checkpoint": file, "prior": prior}))
    has_own = {law: any(f.column.startswith(f"water.{law}.") for f in fit.free) for law, fit in fits.items()}
    if not any(has_own.values()):
        return fits
    consequence = "it uses those of the description, and the comparison is not on equal terms"
    warnings = [
        f"The {law} law has no free water coefficient of its own: {consequence}." for law in has_own if not has_own[law]
    ]
    return {law: replace(fit, warnings=(*warnings, *fit.warnings)) for law, fit in fits.items()}


def _trials(robot: Robot, given: Trials | Paths) -> Trials:
    """Return the given trials, or read them from the given paths."""
    if not isinstance(robot, Robot):
        raise InputError("must be a robot", key="robot", value=shown(robot), fix="give what hypertuna.load returns")
    if isinstance(given, Trials):
        return given
    is_list = isinstance(given, (list, tuple)) and all(isinstance(path, (str, Path)) for path in given)
    if not is_list and not isinstance(given, (str, Path)):
        fix = "give what hypertuna.read_trials returns, a path, or a list of paths"
        raise InputError("must be trials or paths", key="trials", value=f"a {type(given).__name__}", fix=fix)
    return read_trials(given, robot)


def _names(given: str | Sequence[str] | Sequence[Free]) -> Sequence[str] | Sequence[Free]:
    """Return names of coefficients as a sequence; a text is split at commas."""
    if isinstance(given, str):
        return split_names(given)
    if not isinstance(given, (list, tuple)):
        rule, fix = "must be names of coefficients", "give a text, or a list of texts"
        raise InputError(rule, key="free", value=f"a {type(given).__name__}", fix=fix)
    return given


def _frees(
    robot: Robot, trials: Trials, names: Sequence[str] | Sequence[Free], options: Mapping[str, Any]
) -> tuple[Free, ...]:
    """Return the free coefficients that names select; names: may also be the coefficients themselves."""
    if names and all(isinstance(name, Free) for name in names):
        return tuple(name for name in names if isinstance(name, Free))
    texts = [name for name in names if isinstance(name, str)]
    if len(texts) < len(names):
        raise InputError("must be all names, or all of type Free", key="free", fix="give one kind of both")
    offsets = {recording.name: recording.time_offset for recording in trials.recordings}
    frees = free(robot, texts, recordings=offsets, **options)
    measured = any(kind_of(trial).depends_on(trial, "cost_factor") for trial in trials.members)
    if any(f.column == "cost_factor" for f in frees) and not measured:
        fix = "leave it out, or give runs with their cost of transport or power"
        raise InputError("needs measured costs of transport, and the trials have none", key="free cost_factor", fix=fix)
    return frees


def _check_springs(robot: Robot, trials: Trials, frees: Sequence[Free], steps: int) -> None:
    """Check that hinges with a free spring bend in some trials, whose beats follow the stiffest allowed springs."""
    springs = [f for f in frees if is_spring(f.column)]
    if not springs:
        return
    beats = [kind_of(trial).motion(trial)["frequency"] for trial in trials.members if kind_of(trial).hinges_bend]
    key = f"free {springs[0].name}"
    if not beats:
        kinds = ", ".join(f"{kind.label}s" for kind in KINDS if kind.hinges_bend)
        rule = "needs trials in which the spring bends the hinge; in these it is rigid or bends as measured"
        raise InputError(rule, key=key, fix=f"give trials of other kinds ({kinds}), or leave it out")
    stiffest = with_values(robot, springs, [f.upper for f in springs])
    try:
        steps_for(stiffest, np.array([min(beats)]), steps)
    except InputError as error:
        rule = f"must have bounds that the beats can follow (at the upper ones {error.key} {error.rule})"
        raise InputError(rule, key=key, value=error.value, fix="give lower --bounds") from None


def _listed(files: Iterable[str]) -> str:
    """Return the names of files as a robot's file holds them: without control characters, and not too many."""
    names = [*dict.fromkeys(escaped(Path(file).name)[:MAX_NAME] or "memory" for file in files)]
    return ", ".join([*names[:MAX_NAMED], *[f"and {len(names) - MAX_NAMED} more"] * (len(names) > MAX_NAMED)])


def _result(
    data: Experiment, part: Experiment, held_out: Trials, result: Mapping[str, Any], levels: dict[str, float], seed: int
) -> Fit:
    """Build the `Fit` from a search's result; part: some of the runs, for the profile likelihood."""
    robot, frees, trials = data.robot, data.free, (data.trials, held_out)
    values = from_scale(frees, result["x"])
    lower, upper = np.array([[f.lower, f.upper] for f in frees]).T
    snap = SNAP * (upper - lower)  # the search stays inside the bounds
    values = np.where(values - lower < snap, lower, np.where(upper - values < snap, upper, values))
    prediction = predict(data, values, gradient_steps=data.steps, levels=levels)
    intervals = uncertainty(data, values, prediction, levels, part)
    validation = None
    if held_out.runs:
        unseen = experiment(robot, held_out, frees, steps=data.steps, threads=data.threads)
        validation = errors(unseen, predict(unseen, values, gradient_steps=None, levels=levels))
    fitted_trials = [trial.file for kind in KINDS for part in trials for trial in part.kinds.get(kind, ())]
    files = _listed(fitted_trials)
    text = f"identified by hypertuna {version()} from {len(data.trials.runs)} runs of {files}"
    covariance = intervals.bounded_covariance
    warnings = warnings_of(data, values, intervals.bound, intervals.directions, intervals.residual_scale, prediction)
    warnings += held_by_priors(frees, intervals.sd)
    large, rising = large_errors(data, prediction), trends(data, values, prediction, seed)
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
        warnings=(*warnings, *repeated_motions(*trials), *(trend.sentence for trend in rising), *map(unmet, large)),
        trends=rising,
        seed=seed,
        loss=data.loss,
        steps=data.steps,
        trials=trials,
    )
