"""How certain a fit is: intervals, correlations, the directions that the data leave open, errors and criteria."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.coefficients import Free, from_scale, to_scale
from hypertuna.predict import KINDS, Experiment, Prediction, loss_terms, weighted

__all__ = ["ERRORS", "LABELS", "Certainty", "Direction", "Errors", "certainty", "criteria", "errors", "squares"]

Array = NDArray[np.float64]

CONFIDENCE = 0.95
ON_BOUND = 1e-4  # of the allowed range: so near, a value sits on its bound
LEAST_SCALE = 0.1  # of the allowed range: a value nearer to 0 is not asked to be known to a fraction of itself
WEIGHTY = 0.35  # of the largest entry of a direction: what has less is not named
SLIGHT = 0.05  # the same of a direction that is open
WOULD_BE = 0.05  # relative noise of what could be measured as well
FLOOR = 1e-12  # of the largest singular value: what is below is zero
MEASURED = {"speed": "speed", "cost_of_transport": "cost of transport", "x": "tracks", "y": "tracks", "yaw": "tracks"}
# Errors by kind: the name that says the unit, and how people read it (name, unit, how many of it are one of these).
ERRORS = {"speed": "speed_relative", "cost_of_transport": "cost_of_transport_relative", "x": "x_m", "y": "y_m"}
ERRORS |= {"yaw": "yaw_deg"}
LABELS = {
    "speed_relative": ("speed", "%", 100.0),
    "cost_of_transport_relative": ("cost of transport", "%", 100.0),
    "x_m": ("x", "cm", 100.0),
    "y_m": ("y", "cm", 100.0),
    "yaw_deg": ("yaw", "deg", 1.0),
}


@dataclass(frozen=True)
class Direction:
    """A direction in the space of the free coefficients, uncorrelated with the others.

    Attributes
    ----------
    vector : ndarray, shape (n,)
        Unit vector; each coefficient is counted in its own scale (see `certainty`).
    singular_value : float
        Inverse of the standard deviation along it.
    determined : bool
        Whether the 95 % interval along it is shorter than 1.
    sentence : str
    """

    vector: Array
    singular_value: float
    determined: bool
    sentence: str


@dataclass(frozen=True)
class Certainty:
    """What the data say of each free coefficient.

    Attributes
    ----------
    sd : ndarray, shape (n,)
        Standard deviation, in log scale relative to the value; infinite where the data say nothing.
    low, high : ndarray, shape (n,)
        95 % interval in SI units, held within the bounds.
    covariance, correlation : ndarray, shape (n, n)
        Of the coefficients in their scales.
    unit : ndarray, shape (n,)
        What counts as 1 in `Direction`.
    determined : tuple of bool
        Whether the 95 % interval of each is shorter than its unit.
    bound : tuple of str or None
        "lower" or "upper" for a value that sits there.
    directions : tuple of Direction
        From the best to the least determined.
    factor : float
        What the standard deviations were multiplied by, because residuals exceed the stated noise or a robust loss
        makes less of them.
    freedom : int
        Degrees of freedom of the t distribution.
    """

    sd: Array
    low: Array
    high: Array
    covariance: Array
    correlation: Array
    unit: Array
    determined: tuple[bool, ...]
    bound: tuple[str | None, ...]
    directions: tuple[Direction, ...]
    factor: float
    freedom: int


@dataclass(frozen=True)
class Errors:
    """Computed minus measured, of some runs.

    Attributes
    ----------
    rms, largest : dict of float
        By quantity, the unit in its name: ``speed_relative``, ``cost_of_transport_relative``, ``x_m``, ``yaw_deg`` ...
    runs : tuple of dict
        Of each run: its name, and for every quantity what was measured and computed, or the rms over its frames.
    """

    rms: dict[str, float]
    largest: dict[str, float]
    runs: tuple[dict[str, Any], ...]


def certainty(
    data: Experiment, frees: Sequence[Free], values: Array, found: Prediction, levels: dict[str, float], loss: str
) -> Certainty:
    """Linearize the fit about its result.

    Parameters
    ----------
    data : Experiment
    frees : sequence of Free
    values : ndarray, shape (n,)
        Result, in SI units [SI].
    found : Prediction
        There, with slopes.
    levels : dict of float
        As for `hypertuna.predict.weighted` [1, m and rad].
    loss : str
        As for `hypertuna.predict.loss_terms`.

    Returns
    -------
    Certainty

    Notes
    -----
    Covariance of an M-estimate (Huber 1981, section 7.6): factor^2 (J^T J)^-1 with the Jacobian J of the weighted
    residuals and factor^2 = mean(psi^2) n / (n - p) / mean(psi')^2, though never less than 1: a stated noise that the
    residuals exceed is taken for too small (Birge 1932). All frames of a run along one axis count as one sample. By the
    inequality of Cauchy and Schwarz no correlation among them can make the variance larger than that.

    A coefficient's unit is its value, at least a tenth and at most the whole of its allowed range; in log scale 1, if
    the range is not less. Directions are those of the singular value decomposition of J in these units.
    """
    _, slope = weighted(data, found, levels)
    z = squares(data, found, levels)
    samples, n = len(z), len(frees)
    freedom = max(samples - n, 1)
    _, first, second = loss_terms(loss, z)
    bend = max(float(np.mean(first + 2 * z * second)), 1e-3)
    factor = max(1.0, math.sqrt(float(np.sum(z * first**2)) / freedom) / bend)
    lower, upper = (to_scale(frees, [getattr(f, side) for f in frees]) for side in ("lower", "upper"))
    scaled, unit = to_scale(frees, values), _units(frees, values, upper - lower)
    _, singular, vectors = np.linalg.svd(slope * unit / factor, full_matrices=False)
    if len(singular) < n:  # fewer numbers than coefficients
        singular, vectors = np.append(singular, np.zeros(n - len(singular))), np.linalg.svd(slope * unit)[2]
    held = np.maximum(singular, FLOOR * max(singular[0], 1.0))
    covariance = np.outer(unit, unit) * (vectors.T / held**2 @ vectors)
    sd = np.sqrt(np.diag(covariance))
    quantile = _quantile(freedom)
    low, high = (from_scale(frees, np.clip(scaled + side * quantile * sd, lower, upper)) for side in (-1, 1))
    near = ON_BOUND * (upper - lower)
    bound = tuple(
        "lower" if x - a < e else "upper" if b - x < e else None
        for x, a, b, e in zip(scaled, lower, upper, near, strict=True)
    )
    silent = singular <= FLOOR * max(singular[0], 1.0)
    told = [
        Direction(v, 0.0 if none else float(s), bool(2 * quantile / h < 1), "")
        for v, s, h, none in zip(vectors, singular, held, silent, strict=True)
    ]
    shown = np.where((np.abs(vectors[silent]) > WEIGHTY).any(axis=0), np.inf, sd)
    help_by = _helpful(data, found, slope * unit / factor, unit, told, quantile)
    determined = tuple((2 * quantile * sd < unit).tolist())
    directions = tuple(
        replace(d, sentence=_sentence(data, frees, d, determined, quantile, text))
        for d, text in zip(told, help_by, strict=True)
    )
    correlation = covariance / np.outer(sd, sd)
    return Certainty(shown, low, high, covariance, correlation, unit, determined, bound, directions, factor, freedom)


def squares(data: Experiment, found: Prediction, levels: dict[str, float]) -> Array:
    """Return the squared residual of every sample, in units of its variance.

    Parameters
    ----------
    data : Experiment
    found : Prediction
    levels : dict of float
        As for `hypertuna.predict.weighted` [1, m and rad].

    Returns
    -------
    ndarray, shape (samples,)
        [1].
    """
    residual, _ = weighted(data, found, levels)
    return np.bincount(data.sample, residual**2, minlength=len(data.kind)).astype(np.float64)


def criteria(data: Experiment, found: Prediction, levels: dict[str, float], loss: str, count: int) -> dict[str, Any]:
    """Compute Akaike's corrected and the Bayesian information criterion.

    Parameters
    ----------
    data : Experiment
    found : Prediction
    levels : dict of float
        As for `hypertuna.predict.weighted` [1, m and rad].
    loss : str
        Stands for -2 ln of the likelihood of a sample, but for a constant.
    count : int
        Number of free coefficients. Every unknown noise level counts as one more.

    Returns
    -------
    dict
        ``samples``, ``parameters``, ``minus_2_log_likelihood``, ``aicc`` (None where there are too few samples) and
        ``bic``; lower is better, and only differences between fits to the same runs mean anything.
    """
    z = squares(data, found, levels)
    level = np.array([levels.get(name, 1.0) for name in KINDS])[data.kind]
    variance = np.where(data.known, data.sd, data.sd * level) ** 2
    # an unknown level takes the value that makes its samples likeliest
    for k in range(len(KINDS)):
        mine = ~data.known & (data.kind == k)
        if mine.any() and (best := float(loss_terms(loss, z[mine])[0].mean())) > 0:
            variance[mine] *= best
            z[mine] /= best
    total = float(np.sum(loss_terms(loss, z)[0] + np.log(2 * math.pi * variance)))
    n, k = len(z), count + len(data.unknown_kinds)
    aicc = total + 2 * k + 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else None
    return {
        "samples": n,
        "parameters": k,
        "minus_2_log_likelihood": total,
        "aicc": aicc,
        "bic": total + k * math.log(n),
    }


def errors(data: Experiment, found: Prediction) -> Errors:
    """Compare what was computed with what was measured.

    Parameters
    ----------
    data : Experiment
    found : Prediction

    Returns
    -------
    Errors
        Relative for steady runs, except where a measured speed is 0, which is left out.
    """
    difference = found.computed - data.measured
    kinds = data.kind[data.sample]
    per_run: list[dict[str, Any]] = [{"run": name} for name in data.trials.runs]
    rms, largest = {}, {}
    for k, name in enumerate(KINDS):
        mine = np.flatnonzero((kinds == k) & ((k > 1) | (data.measured != 0)))
        if not len(mine):
            continue
        error = difference[mine] / data.measured[mine] if k < 2 else difference[mine]
        error = np.degrees(error) if name == "yaw" else error
        label = ERRORS[name]
        rms[label], largest[label] = float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())
        run = data.run[data.sample[mine]]
        for r in np.unique(run):
            here = error[run == r]
            if k < 2:
                at = mine[run == r][0]
                pair = {"measured": float(data.measured[at]), "computed": float(found.computed[at])}
                per_run[r] |= {f"{name}_{key}": value for key, value in pair.items()} | {label: float(here[0])}
            else:
                per_run[r] |= {f"{label}_rms": float(np.sqrt(np.mean(here**2)))}
    for r in np.flatnonzero(found.failed | found.unstable):
        per_run[r]["status"] = "not settled" if found.failed[r] else "unstable"
    return Errors(rms, largest, tuple(per_run))


def _quantile(freedom: int) -> float:
    """Two-sided 95 % quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + CONFIDENCE / 2))


def _units(frees: Sequence[Free], values: Array, extent: Array) -> Array:
    """Tell what counts as 1 of each coefficient, in its scale."""
    size = np.array([1.0 if f.scale == "log" else abs(v) for f, v in zip(frees, values, strict=True)])
    unit: Array = np.clip(size, LEAST_SCALE * extent, extent)
    return unit


def _helpful(
    data: Experiment, found: Prediction, slope: Array, unit: Array, told: Sequence[Direction], quantile: float
) -> list[str]:
    """Say of each direction which measurement of the same gaits would determine it."""
    missing = [
        name
        for k, name in enumerate(KINDS[:2])
        if name in found.others and (data.kind == k).sum() < len(data.trials.steady)
    ]
    texts = [""] * len(told)
    for name in missing:
        value, by = found.others[name]
        sound = np.isfinite(value) & (value != 0)
        more = by[sound] * unit / (WOULD_BE * np.abs(value[sound]))[:, np.newaxis]
        _, singular, vectors = np.linalg.svd(np.concatenate([slope, more]), full_matrices=False)
        held = np.maximum(singular, FLOOR * max(singular[0], 1.0))
        for k, d in enumerate(told):
            sd = math.sqrt(float(np.sum((vectors @ d.vector / held) ** 2)))
            if not d.determined and not texts[k] and 2 * quantile * sd < 1:
                texts[k] = f"the {MEASURED[name]} of the same runs, known to {100 * WOULD_BE:g} %, would determine them"
    return texts


def _sentence(
    data: Experiment,
    frees: Sequence[Free],
    direction: Direction,
    determined: Sequence[bool],
    quantile: float,
    help_by: str,
) -> str:
    """Say in words what the data know along a direction."""
    size = np.abs(direction.vector)
    order = [int(i) for i in np.argsort(-size, kind="stable")]
    kinds = dict.fromkeys(MEASURED[KINDS[k]] for k in np.unique(data.kind))
    source = " and ".join(kinds)
    if direction.determined:
        named = [i for i in order if size[i] > WEIGHTY * size[order[0]]]
        if len(named) == 1 and determined[named[0]]:
            what = frees[named[0]].name
        else:  # one alone would not be true: a combination is known, no coefficient of it
            what = f"a combination of {_listed([frees[i].name for i in (named if len(named) > 1 else order[:2])])}"
        verb = "determines" if source in ("speed", "cost of transport") else "determine"
        return f"{source.capitalize()} {verb} {what} to {100 * quantile / direction.singular_value:.2g} %."
    # those that move by their unit, or more, within the interval along the direction
    moved = 2 * quantile * size > direction.singular_value
    named = [i for i in order if moved[i] and size[i] > SLIGHT * size[order[0]]]
    rest = f"; {help_by}" if help_by else "; other gaits, or recordings of transients, may"
    if len(named) == 1:
        return f"{frees[named[0]].name} is not determined by {source} alone{rest.replace('them', 'it')}."
    return f"{_listed([frees[i].name for i in named])} cannot be told apart from {source} alone{rest}."


def _listed(names: Sequence[str]) -> str:
    """Write names as a list."""
    return " and ".join(", ".join(names).rsplit(", ", 1))
