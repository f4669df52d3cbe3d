"""How certain a fit is: intervals, correlations, and the directions that the data leave open."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hypertuna.identification.coefficients import Free, from_scale, to_scale
from hypertuna.identification.prediction import KINDS, Experiment, Prediction, loss_terms, weighted
from hypertuna.identification.profile import Valley, lengths
from hypertuna.identification.residuals import curvature, excess, misfit, squares

__all__ = ["Certainty", "Direction", "certainty"]

Array = NDArray[np.float64]

CONFIDENCE = 0.95
ON_BOUND = 1e-4  # of the allowed range: so near, a value sits on its bound
ABSOLUTE = {"time_offset": 0.1, "joints.phase_offset": 0.1}  # s and rad: units of what is not known relatively
LEAST_SCALE = 0.1  # of the allowed range: a value nearer to 0 is not asked to be known to a fraction of itself
WEIGHTY = 0.35  # of the largest entry of a direction: what has less is not named
SLIGHT = 0.05  # the same of a direction that is open
WOULD_BE = 0.02  # relative noise of what could be measured as well
FLOOR = 1e-12  # of the largest singular value: what is below is zero
MEASURED = {"speed": "speed", "cost_of_transport": "cost of transport", "x": "tracks", "y": "tracks", "yaw": "tracks"}


@dataclass(frozen=True)
class Direction:
    """A direction in the space of the free coefficients, uncorrelated with the others.

    Attributes
    ----------
    vector : ndarray, shape (n,)
        Unit vector; each coefficient is counted in its own scale (see `certainty`).
    singular_value : float
        Of the weighted Jacobian: inverse of the standard deviation along it that a linear problem would have.
    sd : float
        Standard deviation along it.
    determined : bool
        Whether the 95 % interval along it is shorter than 1.
    sentence : str
    """

    vector: Array
    singular_value: float
    sd: float
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
    spread : ndarray, shape (n, n)
        Covariance with the bounds as a weak prior, for draws.
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
    excess : float
        How many times larger residuals are than the stated noise, 1 at least.
    freedom : int
        Degrees of freedom of the t distribution.
    """

    sd: Array
    low: Array
    high: Array
    covariance: Array
    correlation: Array
    spread: Array
    unit: Array
    determined: tuple[bool, ...]
    bound: tuple[str | None, ...]
    directions: tuple[Direction, ...]
    factor: float
    excess: float
    freedom: int


@dataclass(frozen=True)
class _Linear:
    """The problem about its result: the weighted Jacobian in units of the coefficients, and its decomposition."""

    frees: tuple[Free, ...]
    scaled: Array
    lower: Array
    upper: Array
    unit: Array
    jacobian: Array
    left: Array
    singular: Array  # descending
    vectors: Array  # (directions, n)
    factor: float
    excess: float
    quantile: float

    @property
    def held(self) -> Array:
        """Singular values, kept from zero."""
        return np.maximum(self.singular, FLOOR * max(float(self.singular[0]), 1.0))


def certainty(
    data: Experiment,
    frees: Sequence[Free],
    values: Array,
    found: Prediction,
    levels: dict[str, float],
    loss: str,
    *,
    look: tuple[Experiment, Callable[..., Prediction]] | None = None,
) -> Certainty:
    """Tell how far the runs determine a fit.

    Parameters
    ----------
    data : Experiment
    frees : sequence of Free
    values : ndarray, shape (n,)
        Result, in SI units [SI].
    found : Prediction
        There, with slopes.
    levels : dict of float
        As for `hypertuna.identification.prediction.weighted` [1, m and rad].
    loss : str
        As for `hypertuna.identification.prediction.loss_terms`.
    look : tuple of Experiment and callable, optional
        Part of the runs, and what predicts them with other values [SI]; without it the problem is taken for linear.

    Returns
    -------
    Certainty

    Notes
    -----
    Covariance of an M-estimate (Huber 1981, section 7.6): factor^2 (J^T J)^-1 with the Jacobian J of the weighted
    residuals and factor^2 = s^2 mean(psi^2) n / (n - p) / mean(psi')^2, psi of residuals over s, though never less than
    1: a stated noise that the residuals exceed s times is taken for too small (Birge 1932). All frames of a run along
    one axis count as one sample. By the inequality of Cauchy and Schwarz no correlation among them can make the
    variance larger than that. The runs of a recording share the model's error; see `misfit`.

    A coefficient's unit is its value, at least a tenth and at most the whole of its allowed range; in log scale 1, if
    the range is not less. A time offset and a phase offset, whose 0 is no smaller than other values, have 0.1 s and
    0.1 rad. Directions are those of the singular value decomposition of J in these units.

    Along an open direction the truth may lie so far off that the valley of equally good fits bends: the better known
    directions then belong elsewhere than a linear problem has them: `lengths` allows for that.
    """
    linear = _linearize(data, frees, values, found, levels, loss)
    unit, quantile, vectors = linear.unit, linear.quantile, linear.vectors
    length = 1 / linear.held
    if look is not None:
        length = lengths(_valley(linear, levels, *look, samples=len(data.kind)))
    covariance = np.outer(unit, unit) * (vectors.T * length**2 @ vectors)
    sd = np.sqrt(np.diag(covariance))
    x, lower, upper = linear.scaled, linear.lower, linear.upper
    low, high = (from_scale(frees, np.clip(x + side * quantile * sd, lower, upper)) for side in (-1, 1))
    silent = linear.singular <= FLOOR * max(float(linear.singular[0]), 1.0)
    determined = tuple((2 * quantile * sd < unit).tolist())
    told = [
        Direction(v, 0.0 if none else float(s), float(d), bool(2 * quantile * d < 1), "")
        for v, s, d, none in zip(vectors, linear.singular, length, silent, strict=True)
    ]
    help_by = _helpful(data, found, linear, told)
    return Certainty(
        sd=np.where((np.abs(vectors[silent]) > WEIGHTY).any(axis=0), np.inf, sd),
        low=low,
        high=high,
        covariance=covariance,
        correlation=covariance / np.outer(sd, sd),
        spread=_spread(linear),
        unit=unit,
        determined=determined,
        bound=_on_bound(linear),
        directions=tuple(
            replace(d, sentence=_sentence(data, frees, unit, d, determined, quantile, text))
            for d, text in zip(told, help_by, strict=True)
        ),
        factor=linear.factor,
        excess=linear.excess,
        freedom=max(len(data.kind) - len(frees), 1),
    )


def _linearize(
    data: Experiment, frees: Sequence[Free], values: Array, found: Prediction, levels: dict[str, float], loss: str
) -> _Linear:
    """Decompose the weighted Jacobian."""
    _, slope = weighted(data, found, levels)
    z, n = squares(data, found, levels), len(frees)
    freedom = max(len(z) - n, 1)
    over = max(1.0, excess(z, loss, n))
    z_own = z / over**2  # in units of the noise that there is: a loss tells outliers by it
    _, first, _ = loss_terms(loss, z_own)
    scatter = over * math.sqrt(float(np.sum(z_own * first**2)) / freedom) / curvature(data, z_own, loss)
    factor = max(1.0, scatter, math.sqrt(misfit(data, z)))
    lower, upper = (to_scale(frees, [getattr(f, side) for f in frees]) for side in ("lower", "upper"))
    unit = _units(frees, values, upper - lower)
    # where there are fewer numbers than coefficients, rows of zeros leave directions open
    jacobian = np.concatenate([slope * unit / factor, np.zeros((max(n - len(slope), 0), n))])
    left, singular, vectors = np.linalg.svd(jacobian, full_matrices=False)
    scaled, quantile = to_scale(frees, values), _quantile(freedom)
    return _Linear(
        tuple(frees),
        scaled,
        lower,
        upper,
        unit,
        jacobian[: len(slope)],
        left,
        singular,
        vectors,
        factor,
        over,
        quantile,
    )


def _valley(
    linear: _Linear, levels: dict[str, float], sketch: Experiment, look: Callable[..., Prediction], *, samples: int
) -> Valley:
    """Describe the valley about the result of a fit by part of the runs."""
    scale = math.sqrt(samples / len(sketch.kind)) / linear.factor
    scaled, unit = linear.scaled, linear.unit

    def at(x: Array) -> Array:
        there = look(from_scale(linear.frees, np.clip(scaled + unit * x, linear.lower, linear.upper)), slope_steps=None)
        return scale * weighted(sketch, there, levels)[0]

    slope = scale * weighted(sketch, look(from_scale(linear.frees, scaled)), levels)[1] * unit
    ends = (np.minimum(linear.lower - scaled, 0.0) / unit, np.maximum(linear.upper - scaled, 0.0) / unit)
    return Valley(at, slope, *ends, linear.vectors, 1 / linear.held, linear.quantile)


def _spread(linear: _Linear) -> Array:
    """Covariance with the bounds as a prior: a normal distribution of a uniform one's variance, (upper - lower)^2 / 12.

    The prior enters as one more measurement of each coefficient, before the inversion: where the runs are silent, an
    infinite variance would take the digits of what they do tell.
    """
    root = (linear.upper - linear.lower) / math.sqrt(12)
    _, singular, vectors = np.linalg.svd(
        np.concatenate([linear.jacobian * (root / linear.unit), np.eye(len(root))]), full_matrices=False
    )
    spread: Array = np.outer(root, root) * (vectors.T / singular**2 @ vectors)
    return spread


def _on_bound(linear: _Linear) -> tuple[str | None, ...]:
    """Tell which values sit on a bound."""
    near = ON_BOUND * (linear.upper - linear.lower)
    return tuple(
        "lower" if x - a < e else "upper" if b - x < e else None
        for x, a, b, e in zip(linear.scaled, linear.lower, linear.upper, near, strict=True)
    )


def _quantile(freedom: int) -> float:
    """Two-sided 95 % quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + CONFIDENCE / 2))


def _units(frees: Sequence[Free], values: Array, extent: Array) -> Array:
    """Tell what counts as 1 of each coefficient, in its scale."""
    size = np.array([1.0 if f.scale == "log" else abs(v) for f, v in zip(frees, values, strict=True)])
    relative = np.maximum(size, LEAST_SCALE * extent)
    absolute = [u if f.scale == "log" else ABSOLUTE.get(f.column, u) for f, u in zip(frees, relative, strict=True)]
    unit: Array = np.minimum(absolute, extent)
    return unit


def _helpful(data: Experiment, found: Prediction, linear: _Linear, told: Sequence[Direction]) -> list[str]:
    """Say of each open direction which measurement of the same gaits would determine it."""
    missing = [
        name
        for k, name in enumerate(KINDS[:2])
        if name in found.others and (data.kind == k).sum() < len(data.trials.steady)
    ]
    texts = [""] * len(told)
    for name in missing:
        value, by = found.others[name]
        sound = np.isfinite(value) & (value != 0)
        more = by[sound] * linear.unit / (WOULD_BE * np.abs(value[sound]))[:, np.newaxis]
        _, singular, vectors = np.linalg.svd(np.concatenate([linear.jacobian, more]), full_matrices=False)
        held = np.maximum(singular, FLOOR * max(float(singular[0]), 1.0))
        for k, d in enumerate(told):
            sd = math.sqrt(float(np.sum((vectors @ d.vector / held) ** 2)))
            if not d.determined and not texts[k] and 2 * linear.quantile * sd < 1:
                texts[k] = f"the {MEASURED[name]} of the same runs, known to {100 * WOULD_BE:g} %, would determine them"
    return texts


def _sentence(
    data: Experiment,
    frees: Sequence[Free],
    unit: Array,
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
        if len(frees) == 1 or (len(named) == 1 and determined[named[0]]):
            what = frees[named[0]].name
        else:  # one alone would not be true: a combination is known, no coefficient of it
            what = f"a combination of {_listed([frees[i].name for i in (named if len(named) > 1 else order[:2])])}"
        verb = "determines" if source in ("speed", "cost of transport") else "determine"
        precision = quantile * direction.sd
        first = frees[named[0]]
        if what == first.name and first.column in ABSOLUTE and first.scale == "natural":
            value, name = (math.degrees(precision), "deg") if first.unit == "rad" else (precision, first.unit)
            return f"{source.capitalize()} {verb} {what} to {value * unit[named[0]]:.2g} {name}."
        return f"{source.capitalize()} {verb} {what} to {100 * precision:.2g} %."
    # those that move by their unit, or more, within the interval along the direction
    moved = 2 * quantile * size * direction.sd > 1
    named = [i for i in order if moved[i] and size[i] > SLIGHT * size[order[0]]]
    named = named or [i for i in order if size[i] > WEIGHTY * size[order[0]]]  # none moves so far, all together do
    others = "other gaits or motions may" if data.trials.steady else "other motions may"
    others = others if data.trials.recordings else "other gaits, or recordings of transients, may"
    rest = f"; {help_by or others}"
    if len(named) == 1:
        return f"{frees[named[0]].name} is not determined by {source} alone{rest.replace('them', 'it')}."
    return f"{_listed([frees[i].name for i in named])} cannot be told apart from {source} alone{rest}."


def _listed(names: Sequence[str]) -> str:
    """Write names as a list."""
    return " and ".join(", ".join(names).rsplit(", ", 1))
