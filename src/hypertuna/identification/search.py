"""The search for the coefficients that fit trials best, from several starts, with noise that the runs leave open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.identification.coefficients import Free, from_scale, to_scale
from hypertuna.identification.names import default_bounds
from hypertuna.identification.prediction import FIRST_LEVEL, KINDS, Experiment, loss_terms, predict, weighted
from hypertuna.identification.residuals import normal_mean, squares
from hypertuna.io.checkpoint import Journal
from hypertuna.trials.trials import Trials

__all__ = ["CONVERGED", "Search", "fit", "search_from", "sketch", "start_points", "stop_sentence"]

Array = NDArray[np.float64]

TOLERANCE = 1e-10  # relative change of the coefficients that ends a search
SAME_ERROR = 1e-8  # the same of the error: far less than a standard deviation of any coefficient
ROUGH = 1e-3  # the same in a rough search
NEAR = 3e-3  # of the allowed range: a shorter step has derivatives at all steps of the beat
SKETCH = 4  # steady runs for each free coefficient in a rough search
MOST_EVALUATIONS = 300  # of one search
ROUNDS = 12  # of estimating unknown noise
SAME_NOISE = 1e-2  # relative change of a noise level that is no change
SAME_COST = 0.05  # starts that come this near to each other have found the same minimum
LEAST_LEVEL = 1e-6  # no speed is known better than it is computed
STOPS = {
    0: f"The search was stopped after {MOST_EVALUATIONS} evaluations before it had converged",
    1: "The search converged: no direction makes the error smaller any more",
    2: "The search converged: the error does not change any more",
    3: "The search converged: the coefficients do not change any more",
    4: "The search converged: neither error nor coefficients change any more",
}
CONVERGED = (1, 2, 3, 4)


@dataclass(frozen=True)
class Search:
    """What is searched, and how.

    Attributes
    ----------
    data : Experiment
    sketch : Experiment
        Of part of the steady runs, for rough searches.
    frees : tuple of Free
    loss : str
        As for `hypertuna.identification.prediction.loss_terms`.
    steps, threads : int
        As for `hypertuna.identification.prediction.predict`.
    """

    data: Experiment
    sketch: Experiment
    frees: tuple[Free, ...]
    loss: str
    steps: int
    threads: int


def sketch(trials: Trials, count: int) -> Trials:
    """Choose part of the steady runs, evenly, for rough searches; of recordings keep all.

    Parameters
    ----------
    trials : Trials
    count : int
        Number of free coefficients: four times as many runs are enough.

    Returns
    -------
    Trials
    """
    every = max(1, len(trials.steady) // (SKETCH * count))
    return Trials(trials.steady[::every], trials.recordings)


def start_points(frees: Sequence[Free], count: int, seed: int) -> list[Array]:
    """Choose where searches begin.

    Parameters
    ----------
    frees : sequence of Free
    count, seed : int

    Returns
    -------
    list of ndarray, shape (n,)
        The robot's values, those of data/published/bounds.toml (Table III), then Sobol's points within the bounds, in
        the scales of the coefficients [SI or logarithm].
    """
    lower, upper = (to_scale(frees, [getattr(f, side) for f in frees]) for side in ("lower", "upper"))
    table = default_bounds()["coefficient"]
    second = [min(max(table.get(f.column, {}).get("start", f.start), f.lower), f.upper) for f in frees]
    points = [to_scale(frees, [f.start for f in frees]), to_scale(frees, second)]
    if count > 2:
        from scipy.stats import qmc

        sobol = qmc.Sobol(len(frees), scramble=True, rng=np.random.default_rng(seed))
        power = math.ceil(math.log2(max(count - 2, 2)))
        points += list(lower + (upper - lower) * sobol.random_base2(power))
    return [np.clip(point, lower, upper) for point in points[:count]]


def fit(
    search: Search, starts: Sequence[Array], journal: Journal, progress: Callable[[int, int], None] | None
) -> tuple[dict[str, Any], dict[str, float], list[float], int]:
    """Search roughly from every start; go on from the best, estimating unknown noise in turn with the coefficients.

    Parameters
    ----------
    search : Search
    starts : sequence of ndarray, shape (n,)
        In the scales of the coefficients [SI or logarithm].
    journal : Journal
        Answers the searches that it knows.
    progress : callable, optional
        Called with the searches done and their total.

    Returns
    -------
    best : dict
        As `search_from` returns it.
    levels : dict of float
        Noise of the kinds for which the runs tell none [1, m and rad].
    costs : list of float
        What each start came to [1].
    evaluations : int
    """
    unknown = search.data.unknown_kinds
    levels = {name: FIRST_LEVEL[name] for name in unknown}
    found = []
    for k, x in enumerate(starts):
        work = partial(search_from, search, x, levels, rough=True)
        found.append(journal.answer({"start": x, "noise": levels}, work))
        if progress is not None:
            progress(k + 1, len(starts) + 1)
    best = min(found, key=lambda one: float(one["cost"]))
    path, evaluations = list(best["path"]), sum(one["evaluations"] for one in found)
    for k in range(ROUNDS):
        now = _levels(search, best, levels)
        if k and all(abs(now[name] / levels[name] - 1) < SAME_NOISE for name in unknown):
            break
        levels, begin = now, np.array(best["x"])
        best = journal.answer({"start": begin, "noise": levels}, partial(search_from, search, begin, levels))
        path += best["path"]
        evaluations += best["evaluations"]
    if progress is not None:
        progress(len(starts) + 1, len(starts) + 1)
    return best | {"path": path}, levels, [float(one["cost"]) for one in found], evaluations


def search_from(search: Search, start: Array, levels: dict[str, float], *, rough: bool = False) -> dict[str, Any]:
    """Search from one start by SciPy's trust region method, with exact derivatives.

    Parameters
    ----------
    search : Search
    start : ndarray, shape (n,)
        In the scales of the coefficients [SI or logarithm].
    levels : dict of float
        As for `hypertuna.identification.prediction.weighted` [1, m and rad].

    Returns
    -------
    dict
        ``x`` where it ended, its ``path``, one point for each iteration, ``cost``, SciPy's ``status`` and the number of
        ``evaluations``.
    """
    from scipy.optimize import least_squares  # here, because it takes longer to import than a swim takes

    frees = search.frees
    bounds = tuple(to_scale(frees, [getattr(f, side) for f in frees]) for side in ("lower", "upper"))
    path: list[list[float]] = []

    data, tolerance = (search.sketch, ROUGH) if rough else (search.data, SAME_ERROR)
    extent = bounds[1] - bounds[0]

    def at(x: Array, slope_steps: int | None) -> tuple[Array, Array]:
        found = predict(
            data, frees, from_scale(frees, x), steps=search.steps, slope_steps=slope_steps, threads=search.threads
        )
        return weighted(data, found, levels)

    def slope(x: Array) -> Array:  # asked for once in an iteration
        # half the steps per beat give the way to go well enough until it is short
        far = rough or not path or np.abs((x - path[-1]) / extent).max() > NEAR
        path.append(x.tolist())
        return at(x, search.steps // 8 * 4 if far else search.steps)[1]

    def loss(square: Array) -> Array:
        # all elements of a sample share its loss; its curvature is kept where that is diagonal
        terms = loss_terms(search.loss, np.bincount(data.sample, square, minlength=len(data.kind)).astype(float))
        terms[0] /= data.count
        terms[2][data.count > 1] = 0.0
        return terms[:, data.sample]

    done = least_squares(
        lambda x: at(x, None)[0],
        start,
        jac=slope,
        bounds=bounds,
        method="trf",
        x_scale=extent,
        loss="linear" if search.loss == "linear" else loss,
        ftol=tolerance,
        gtol=TOLERANCE / 100,
        xtol=TOLERANCE,
        max_nfev=MOST_EVALUATIONS,
    )
    return {
        "x": done.x,
        "path": path,
        "cost": done.cost,
        "status": done.status,
        "evaluations": int(done.nfev + done.njev),
    }


def _levels(search: Search, best: Mapping[str, Any], levels: dict[str, float]) -> dict[str, float]:
    """Estimate the unknown noise of each kind from the residuals of a fit.

    The level at which the mean of z rho'(z) is what it is for normal errors, counted with n - p degrees of freedom.
    """
    data, frees = search.data, search.frees
    if not levels:
        return levels
    found = predict(
        data, frees, from_scale(frees, best["x"]), slope_steps=None, steps=search.steps, threads=search.threads
    )
    z = squares(data, found, levels)
    if len(z) <= len(frees):
        return levels  # every run is met exactly: the residuals tell nothing
    normal = normal_mean(search.loss)
    new = {}
    for name, level in levels.items():
        mine = z[~data.known & (data.kind == KINDS.index(name))] * level**2
        part = 1 - len(frees) / len(z)
        square = level**2
        for _ in range(200):
            last, ratio = square, mine / max(square, LEAST_LEVEL**2)
            square *= float(np.mean(ratio * loss_terms(search.loss, ratio)[1])) / (normal * part)
            square = max(square, LEAST_LEVEL**2)
            if abs(square / last - 1) < SAME_NOISE / 100:
                break
        new[name] = math.sqrt(square)
    return new


def stop_sentence(found: Mapping[str, Any], costs: Sequence[float], evaluations: int) -> str:
    """Say why a fit ended, and how many starts came to the same.

    Parameters
    ----------
    found : mapping
        As `search_from` returns it.
    costs : sequence of float
        What each start came to [1].
    evaluations : int

    Returns
    -------
    str
    """
    same = sum(cost <= min(costs) * (1 + SAME_COST) + SAME_COST**2 for cost in costs)
    starts = f"; {same} of {len(costs)} starts came to the same minimum" if len(costs) > 1 else ""
    return f"{STOPS[found['status']]} ({evaluations} evaluations{starts})."
