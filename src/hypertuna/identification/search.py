"""Fit free coefficients to trials: run the estimator's search on predicted runs, and estimate noise levels."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification import estimator
from hypertuna.identification.coefficients import Free, bounds_of, from_scale, prior_rows, to_scale
from hypertuna.identification.experiment import NAMES, Experiment
from hypertuna.identification.loss import residual_scale
from hypertuna.identification.names import default_bounds
from hypertuna.identification.prediction import predict, weighted
from hypertuna.identification.residuals import squares
from hypertuna.io.checkpoint import Journal
from hypertuna.trials.kinds import QUANTITIES
from hypertuna.trials.trials import Trials

TOLERANCE = 1e-10  # relative change of the coefficients below which a search ends
ERROR_TOLERANCE = 1e-8  # relative change of the cost below which a search ends
ROUGH_TOLERANCE = 1e-3  # relative change of the cost below which a rough search ends
LONG_STEP = 3e-3  # fraction of the allowed range: after a shorter step, derivatives use all steps of the beat
RUNS_PER_COEFFICIENT = 4  # steady runs per free coefficient in a rough search
MAX_EVALUATIONS = 300  # largest number of evaluations of one search
LEVEL_TOLERANCE = 1e-4  # relative tolerance of a noise level
COST_TOLERANCE = 0.05  # relative difference of costs below which two starts have reached the same minimum
MIN_LEVEL = 1e-6  # smallest noise level: the numerical error of a computed speed
STOPS = {  # by status of SciPy's least_squares
    0: f"The search was stopped after {MAX_EVALUATIONS} evaluations before it had converged",
    1: "The search converged: the gradient is zero",
    2: "The search converged: the error does not change any more",
    3: "The search converged: the coefficients do not change any more",
    4: "The search converged: neither error nor coefficients change any more",
}
CONVERGED = (1, 2, 3, 4)  # statuses of a converged search


def subset(trials: Trials, count: int) -> Trials:
    """Return evenly spaced steady runs, four for each of `count` free coefficients, and all recordings."""
    parts = (kind.part(members, RUNS_PER_COEFFICIENT * count) for kind, members in trials.kinds.items())
    return Trials(tuple(trial for part in parts for trial in part))


def start_points(frees: Sequence[Free], count: int, seed: int) -> list[Array]:
    """Return scaled start points (n,): the robot's values, those of Table III, then Sobol points within the bounds."""
    lower, upper = bounds_of(frees)
    table = default_bounds()["coefficient"]
    table_starts = [f.start if f.common else table.get(f.column, {}).get("start", f.start) for f in frees]
    published = [min(max(start, f.lower), f.upper) for start, f in zip(table_starts, frees, strict=True)]
    first = [to_scale(frees, [f.start for f in frees])]
    if published != [f.start for f in frees]:
        first.append(to_scale(frees, published))
    return [np.clip(point, lower, upper) for point in estimator.start_points(first, lower, upper, count, seed)]


def fit(
    data: Experiment,
    part: Experiment,
    starts: Sequence[Array],
    journal: Journal,
    progress: Callable[[int, int], None] | None,
) -> tuple[dict[str, Any], dict[str, float]]:
    """Search roughly from every start on part of the runs, and refine the best; the journal has finished searches.

    Unknown noise levels are estimated without priors: these would hold the coefficients, which raises the levels, which
    gives priors ever more weight. Return the best result of `_search_from`, with `path` and `evaluations` of all
    searches, the `costs` of the starts and a sentence `stop`; and the noise levels [1, m, rad] by kind.
    """
    total = len(starts) + 1
    first_levels = {name: QUANTITIES[name].level for name in data.unknown_kinds}
    has_priors = bool(first_levels) and any(f.prior for f in data.free)
    without_priors = replace(data, free=tuple(replace(f, prior=None) for f in data.free)) if has_priors else data

    def search_once(start: Array, levels: dict[str, float], stage: int, last: bool = False) -> dict[str, Any]:
        rough = stage < len(starts)
        question = {"start": start, "noise": levels} | ({"last": True} if last else {})
        searched = part if rough else data if last else without_priors
        work = partial(_search_from, searched, start, levels, rough=rough or searched is not data)
        result: dict[str, Any] = journal.answer(question, work)
        if rough and progress is not None:
            progress(stage + 1, total)
        return result

    rough, refined, levels = estimator.fit(starts, first_levels, search_once, lambda x, now: _levels(data, x, now))
    if has_priors:
        refined.append(search_once(np.array(refined[-1]["x"]), levels, len(starts), last=True))
    if progress is not None:
        progress(total, total)
    best = min(rough, key=lambda result: float(result["cost"]))
    path = [x for result in (best, *refined) for x in result["path"]]
    evaluations = sum(result["evaluations"] for result in (*rough, *refined))
    costs = [float(result["cost"]) for result in rough]
    same_count = sum(cost <= min(costs) * (1 + COST_TOLERANCE) + COST_TOLERANCE**2 for cost in costs)
    agreement = f"; {same_count} of {len(costs)} starts reached the same minimum" if len(costs) > 1 else ""
    stop = f"{STOPS[refined[-1]['status']]} ({evaluations} evaluations{agreement})."
    return refined[-1] | {"path": path, "evaluations": evaluations, "costs": costs, "stop": stop}, levels


def _search_from(data: Experiment, start: Array, levels: dict[str, float], *, rough: bool = False) -> dict[str, Any]:
    """Search from a scaled start (n,); return `x`, `path` (a point per iteration), `cost`, `status`, `evaluations`."""
    lower, upper = bounds_of(data.free)
    path: list[list[float]] = []

    def evaluate(x: Array, gradient_steps: int | None) -> tuple[Array, Array]:
        prediction = predict(data, from_scale(data.free, x), gradient_steps=gradient_steps, levels=levels)
        pairs = zip(weighted(data, prediction, levels), prior_rows(data.free, x), strict=True)
        residual, jacobian = (np.concatenate(parts) for parts in pairs)
        return residual, jacobian

    def jacobian(x: Array) -> Array:  # called once in an iteration
        # half the steps per beat are accurate enough for long steps
        long_step = rough or not path or np.abs((x - path[-1]) / (upper - lower)).max() > LONG_STEP
        path.append(x.tolist())
        return evaluate(x, data.steps // 8 * 4 if long_step else data.steps)[1]

    samples = (data.loss, data.sample, data.count)
    problem = estimator.LeastSquares(lambda x: evaluate(x, None)[0], jacobian, lower, upper, *samples)
    result = estimator.minimize(
        problem,
        start,
        scale=upper - lower,
        ftol=ROUGH_TOLERANCE if rough else ERROR_TOLERANCE,
        xtol=TOLERANCE,
        gtol=TOLERANCE / 100,
        max_evaluations=MAX_EVALUATIONS,
    )
    evaluations = int(result["nfev"] + result["njev"])
    return {key: result[key] for key in ("x", "cost", "status")} | {"path": path, "evaluations": evaluations}


def _levels(data: Experiment, x: Array, levels: dict[str, float]) -> dict[str, float]:
    """Estimate the unknown noise level of each kind from the residuals at x (n,), up to `level_caps`."""
    if not levels:
        return levels
    prediction = predict(data, from_scale(data.free, x), gradient_steps=None, levels=levels)
    z = squares(data, prediction, levels)
    share = 1 - len(data.free) / len(z)
    if share <= 0:
        return levels  # all runs can be fitted exactly, so residuals do not show the noise
    new_levels, caps = {}, data.level_caps
    for name, level in levels.items():
        kind_squares = z[~data.known & (data.kind == NAMES.index(name))] * level**2
        options: dict[str, Any] = {"share": share, "start": level, "lower": MIN_LEVEL, "tolerance": LEVEL_TOLERANCE}
        new_levels[name] = min(residual_scale(kind_squares, data.loss, **options), caps[name])
    return new_levels
