"""Identify: fit free coefficients to trials, and say how far the trials determine them."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot, parse
from hypertuna.description.validation import written
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.identification.coefficients import Free, column_key, column_of, free, from_scale, with_values
from hypertuna.identification.names import NUISANCES, free_of, split_names
from hypertuna.identification.prediction import LOSSES, experiment, predict
from hypertuna.identification.residuals import Errors, criteria, errors
from hypertuna.identification.search import CONVERGED, Search, fit, sketch, start_points, stop_sentence
from hypertuna.identification.uncertainty import Certainty, certainty
from hypertuna.identification.warnings import repeated, warnings_of
from hypertuna.io.checkpoint import Journal
from hypertuna.io.files import version
from hypertuna.swimming.beat import DEFAULT_STEPS, check_steps
from hypertuna.trials.trials import Trials, digest, read_trials, split

__all__ = ["Fit", "compare", "identify", "with_fit"]

Array = NDArray[np.float64]

MOST_STARTS = 4096
STARTS = 4
SNAP = 1e-6  # of the allowed range


@dataclass(frozen=True)
class Fit:
    """A fit of free coefficients to trials.

    Attributes
    ----------
    robot : Robot
        With the fitted values, and a table ``[fit]``.
    described : Robot
        As it was before.
    free : tuple of Free
    values : ndarray, shape (n,)
        In SI units.
    certainty : Certainty
    noise : dict of float
        Estimated noise of the kinds of measurement for which the trials tell none: relative, m or rad.
    train, validation : Errors
        The latter of runs that the fit has not seen; None without any.
    criteria : dict
        From `hypertuna.identification.uncertainty.criteria`.
    stop : str
        Why the search ended.
    converged : bool
        Whether it ended by itself.
    path : ndarray, shape (iterations, n)
        Values after each iteration of the best search, in SI units.
    costs : tuple of float
        What each start came to: half the sum of the loss.
    evaluations : int
        Predictions of all runs, of all starts together.
    seconds : float
    warnings : tuple of str
    seed : int
    loss : str
    steps : int
        Runge-Kutta steps per beat.
    trials : tuple of Trials
        For training, and for validation.
    """

    robot: Robot
    described: Robot
    free: tuple[Free, ...]
    values: Array
    certainty: Certainty
    noise: dict[str, float]
    train: Errors
    validation: Errors | None
    criteria: dict[str, Any]
    stop: str
    converged: bool
    path: Array
    costs: tuple[float, ...]
    evaluations: int
    seconds: float
    warnings: tuple[str, ...]
    seed: int
    loss: str
    steps: int
    trials: tuple[Trials, Trials]


def identify(
    robot: Robot,
    trials: Trials | str | Path | Sequence[str | Path],
    free: str | Sequence[str] | Sequence[Free],
    *,
    validate: float = 0.2,
    seed: int = 0,
    loss: str = "soft_l1",
    starts: int = STARTS,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    log: Sequence[str] = (),
    start: Mapping[str, float] | None = None,
    steps: int = DEFAULT_STEPS,
    threads: int | None = None,
    checkpoint: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Fit:
    """Fit free coefficients to trials (section III.E of the paper, with exact derivatives).

    Parameters
    ----------
    robot : Robot
    trials : Trials, str, Path or sequence of paths
        From `hypertuna.read_trials`, or what that reads.
    free : str, sequence of str, or of Free
        Names as `hypertuna.identification.coefficients.free` reads them; in one text, with commas between them.
    validate : float
        Part of the runs, drawn at random, that the fit does not see and is then judged on [1].
    seed : int
        Of that draw, and of the starts.
    loss : {"soft_l1", "linear", "huber", "cauchy"}
        What becomes of a residual beyond its standard deviation.
    starts : int
        Searches: from the robot's values, from Table III's (for other coefficients what data/published/bounds.toml
        says), then from Sobol's points within the bounds. The best one counts.
    bounds, log, start : optional
        As for `hypertuna.identification.coefficients.free`, in SI units [SI].
    steps : int
        Runge-Kutta steps per beat.
    threads : int, optional
        All processors if left out; the result does not depend on it.
    checkpoint : str or Path, optional
        File of finished searches: started again after any end, the fit takes them from there.
    progress : callable, optional
        Called with the searches done and their total.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        If names, bounds or options cannot be used, or the runs for training leave nothing to fit.

    Notes
    -----
    Residuals are in units of their standard deviation: that of the file over sqrt(repeats); for tracked runs that of
    the recording's runs about their mean; else an unknown level, common to a kind of measurement and relative to steady
    ones, which is estimated from the residuals in turn with the fit.
    """
    begun = time.monotonic()
    _check(validate, seed, loss, starts)
    check_steps(steps)
    trials = _trials(robot, trials)
    frees = _frees(robot, trials, _names(free), bounds, log, start)
    training, held_out = split(trials, validate, seed)
    search = Search(
        experiment(robot, training, frees),
        experiment(robot, sketch(training, len(frees)), frees),
        frees,
        loss,
        steps,
        threads or len(os.sched_getaffinity(0)),
    )
    options = {
        "trials": digest(trials),
        "free": [f.name for f in frees],
        "bounds": [[f.lower, f.upper] for f in frees],
        "scale": [f.scale for f in frees],
        "start": [f.start for f in frees],
        "validate": validate,
        "seed": seed,
        "loss": loss,
        "starts": starts,
        "steps": steps,
    }
    with Journal(checkpoint, journal_header("identify", robot, options)) as journal:
        found, levels, costs, evaluations = fit(search, start_points(frees, starts, seed), journal, progress)
    return _result(search, (training, held_out), found, levels, costs, evaluations, seed, time.monotonic() - begun)


def compare(
    robot: Robot,
    trials: Trials | str | Path | Sequence[str | Path],
    free: str | Sequence[str],
    laws: Sequence[str],
    **options: Any,
) -> dict[str, Fit]:
    """Fit several water laws to the same runs.

    Parameters
    ----------
    robot : Robot
    trials : Trials, str, Path or sequence of paths
        As for `identify`.
    free : str or sequence of str
        Each law takes those that it has: ``water.lumped.drag`` belongs to one, ``joints.bandwidth`` to all.
    laws : sequence of str
        "lumped", "strip".
    **options
        As for `identify`; a checkpoint is a file for each law, its name before the ending.

    Returns
    -------
    dict of Fit
        By law. Compare ``validation`` and ``criteria``: lower is better.

    Raises
    ------
    InputError
        As `identify` does, or if a law has none of the coefficients, or the loss is "cauchy", which is no likelihood.
    """
    if options.get("loss") == "cauchy":
        rule, fix = "must be a likelihood to compare laws by", "take soft_l1, huber or linear"
        raise InputError(rule, key="loss", value="'cauchy', whose integral is infinite", fix=fix)
    trials, fits = _trials(robot, trials), {}
    for law in laws:
        mine = robot.using(water=law)
        names = free_of(mine, [str(name) for name in _names(free)])
        if not names:
            fix = f"name some, such as water.{law}.{'drag' if law == 'lumped' else 'drag_normal'}"
            raise InputError(f"must name a coefficient of the {law} law", key="free", fix=fix)
        checkpoint = options.get("checkpoint")
        own = Path(checkpoint).with_stem(f"{Path(checkpoint).stem}-{law}") if checkpoint else None
        fits[law] = identify(mine, trials, names, **(options | {"checkpoint": own}))
    return _on_equal_terms(fits)


def _on_equal_terms(fits: Mapping[str, Fit]) -> dict[str, Fit]:
    """Warn where one law has free coefficients of its own, and another has not."""
    own = {law: any(f.column.startswith(f"water.{law}.") for f in fit.free) for law, fit in fits.items()}
    told = [
        f"The {law} law has no free water coefficient of its own: it was fitted with those of the description, and is "
        "not compared on equal terms."
        for law, some in own.items()
        if not some and any(own.values())
    ]
    return {law: replace(fit, warnings=(*told, *fit.warnings)) for law, fit in fits.items()}


def _trials(robot: Robot, given: Trials | str | Path | Sequence[str | Path]) -> Trials:
    """Read trials, unless they are already."""
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
    """Read names of coefficients, unless they are Free already."""
    if isinstance(given, str):
        return split_names(given)
    if not isinstance(given, (list, tuple)):
        rule, fix = "must be names of coefficients", "give a text, or a list of texts"
        raise InputError(rule, key="free", value=f"a {type(given).__name__}", fix=fix)
    return given


def _frees(
    robot: Robot,
    trials: Trials,
    names: Sequence[str] | Sequence[Free],
    bounds: Mapping[str, tuple[float, float]] | None,
    log: Sequence[str],
    start: Mapping[str, float] | None,
) -> tuple[Free, ...]:
    """Make coefficients free, unless they are already."""
    if names and all(isinstance(name, Free) for name in names):
        return tuple(name for name in names if isinstance(name, Free))
    texts = [name for name in names if isinstance(name, str)]
    if len(texts) < len(names):
        raise InputError("must be names, or all of them of type Free", key="free", fix="give one kind of both")
    offsets = {recording.name: recording.time_offset for recording in trials.recordings}
    frees = free(robot, texts, bounds=bounds, log=log, start=start, recordings=offsets)
    if any(f.column == "cost_factor" for f in frees) and all(r.cost_of_transport is None for r in trials.steady):
        fix = "leave it out, or give runs with their cost of transport"
        raise InputError("is of measured costs of transport, and the trials have none", key="free cost_factor", fix=fix)
    return frees


def _check(validate: float, seed: int, loss: str, starts: int) -> None:
    """Check the options."""
    if not 0 <= validate < 1:
        fix = "give a part such as 0.2, or 0 for none"
        raise InputError("must be 0 or more and less than 1", key="validate", value=shown(validate), fix=fix)
    if seed < 0:
        raise InputError("must not be negative", key="seed", value=str(seed), fix="give 0 or more")
    if loss not in LOSSES:
        raise InputError("must be a known loss", key="loss", value=shown(loss), fix=did_you_mean(loss, LOSSES))
    if not 1 <= starts <= MOST_STARTS:
        raise InputError(f"must be from 1 to {MOST_STARTS}", key="starts", value=str(starts), fix="leave it out")


def _result(
    search: Search,
    trials: tuple[Trials, Trials],
    found: Mapping[str, Any],
    levels: dict[str, float],
    costs: Sequence[float],
    evaluations: int,
    seed: int,
    seconds: float,
) -> Fit:
    """Say what came out of a fit."""
    data, frees, robot = search.data, search.frees, search.data.robot
    values = _snapped(frees, from_scale(frees, found["x"]))
    how: dict[str, Any] = {"steps": search.steps, "slope_steps": search.steps, "threads": search.threads}
    at_end = predict(data, frees, values, **how)
    look = partial(predict, search.sketch, frees, **how)
    sure = certainty(data, frees, values, at_end, levels, search.loss, look=(search.sketch, look))
    judged = None
    if trials[1].runs:
        unseen = experiment(robot, trials[1], frees)
        judged = errors(unseen, predict(unseen, frees, values, **how))
    named = [run.file for t in trials for run in t.steady] + [part.file for t in trials for part in t.recordings]
    files = list(dict.fromkeys(Path(file).name or "memory" for file in named))
    text = f"identified by hypertuna {version()} from {len(trials[0].runs)} runs of {', '.join(files)}"
    fitted = with_fit(robot, frees, values, covariance=sure.spread, trials=", ".join(files), seed=seed, text=text)
    return Fit(
        robot=fitted,
        described=robot,
        free=frees,
        values=values,
        certainty=sure,
        noise=levels,
        train=errors(data, at_end),
        validation=judged,
        criteria=criteria(data, at_end, levels, search.loss, len(frees)),
        stop=stop_sentence(found, costs, evaluations),
        converged=found["status"] in CONVERGED,
        path=np.array([from_scale(frees, np.array(x)) for x in found["path"]]),
        costs=tuple(costs),
        evaluations=evaluations,
        seconds=seconds,
        warnings=(*warnings_of(data, frees, values, sure, at_end.failed, at_end.unstable), *repeated(*trials)),
        seed=seed,
        loss=search.loss,
        steps=search.steps,
        trials=trials,
    )


def _snapped(frees: Sequence[Free], values: Array) -> Array:
    """Put values on their bounds that differ from them by what the search, which stays inside, leaves."""
    lower, upper = (np.array([getattr(f, side) for f in frees]) for side in ("lower", "upper"))
    near = SNAP * (upper - lower)
    return np.where(values - lower < near, lower, np.where(upper - values < near, upper, values))


def with_fit(
    robot: Robot,
    frees: Sequence[Free],
    values: Sequence[float] | Array,
    *,
    covariance: Array,
    trials: str,
    seed: int,
    text: str,
) -> Robot:
    """Return the robot with fitted values, their origin, and the table ``[fit]`` that tells how certain they are.

    Parameters
    ----------
    robot : Robot
    frees : sequence of Free
    values : array_like, shape (n,)
        In SI units [SI].
    covariance : ndarray, shape (n, n)
        Of the values in their scales [SI^2 or logarithms].
    trials : str
        Files of the runs.
    seed : int
    text : str
        Sentence that says what was fitted to what.

    Returns
    -------
    Robot

    Raises
    ------
    InputError
        If the description does not take the values.
    """
    document = with_values(robot, frees, values).document()
    sources = document.setdefault("sources", {})
    origin = f"identified from {trials}, see [fit]"
    for column in dict.fromkeys(f.column for f in frees if f.column not in NUISANCES):
        key = written(column_key(column)[0])
        which = [f for f in frees if f.column == column]
        fitted = {i for f in which for i in f.indices}
        others = robot.source(key)
        if len(fitted) < len(column_of(robot, column)) and others is not None:
            sources[key] = f"{', '.join(f'[{f.index}]' for f in which)} {origin}; others: {others}"
        else:
            sources[key] = origin
    sources["fit"] = text
    document["fit"] = {
        "text": text,
        "trials": trials,
        "seed": seed,
        "names": [f.name for f in frees],
        "units": [f.unit for f in frees],
        "scale": [f.scale for f in frees],
        "value": [float(value) for value in values],
        "lower": [f.lower for f in frees],
        "upper": [f.upper for f in frees],
        "covariance": np.asarray(covariance, dtype=float).tolist(),
    }
    return parse(document, file=robot.file)
