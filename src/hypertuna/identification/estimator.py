"""Least-squares estimator for tank and bench data: fit with priors, noise levels, covariance, and directions."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.identification.loss import loss_terms
from hypertuna.identification.profile import ProfileProblem, profile_sd

CONFIDENCE = 0.95  # probability of all intervals
ROUNDS = 12  # largest number of rounds that estimate noise levels and then coefficients
NOISE_TOLERANCE = 1e-2  # relative change of noise levels below which these rounds end
ON_BOUND = 1e-3  # fraction of the range: a closer value is on the bound, since searches end up to 2e-4 before it
MIN_SINGULAR = 1e-12  # singular values below this fraction of the largest count as zero


@dataclass(frozen=True)
class LeastSquares:
    """A bounded nonlinear least-squares problem with a robust loss, in n scaled coefficients x.

    Residuals: of the measured elements, each over its noise; then of the priors, whose loss is always linear.
    """

    residual: Callable[[Array], Array]  # x (n,) to residuals (elements + priors,)
    jacobian: Callable[[Array], Array]  # x (n,) to (elements + priors, n)
    lower: Array  # (n,)
    upper: Array  # (n,)
    loss: str  # name of the loss, see `loss_terms`
    sample: NDArray[np.intp]  # (elements,), index of the independent sample to which each element belongs
    count: NDArray[np.intp]  # (samples,), number of elements of each sample


@dataclass(frozen=True)
class Direction:
    """A direction in the space of the coefficients, each in its unit, that is uncorrelated with other directions."""

    vector: Array  # (n,), unit vector
    singular_value: float  # of the Jacobian over the noise: inverse of the linear standard deviation without priors
    sd: float  # standard deviation along it, including priors and the profile likelihood's curvature
    constrained: bool  # whether its 95 % interval is short, on the assumption that the model is right
    sentence: str = ""


@dataclass(frozen=True)
class Estimate:
    """Covariance and directions of a fit, in the scaled coefficients x."""

    singular: Array  # (n,), descending singular values of the Jacobian over the noise, for coefficients in their units
    vectors: Array  # (n, n), directions in units of the coefficients
    direction_sd: Array  # (n,), standard deviations along the directions
    covariance: Array  # (n, n), covariance of x
    sd: Array  # (n,), standard deviations of x
    low: Array  # (n,), 95 % interval of x, within the bounds
    high: Array  # (n,)

    @property
    def unidentifiable(self) -> NDArray[np.bool_]:
        """Whether residuals do not change along each direction (n,)."""
        return np.asarray(self.singular <= MIN_SINGULAR * max(float(self.singular[0]), 1.0))

    def directions(self, constrained: Callable[[float, float], bool]) -> list[Direction]:
        """Return the directions; constrained: decides from a singular value and a standard deviation."""
        columns = (self.vectors, self.singular.tolist(), self.direction_sd.tolist())
        return [Direction(vector, s, sd, bool(constrained(s, sd))) for vector, s, sd in zip(*columns, strict=True)]


def start_points(first: Sequence[Array], lower: Array, upper: Array, count: int, seed: int) -> list[Array]:
    """Return `count` start points: the given ones (n,), then Sobol points within the bounds."""
    points = list(first[:count])
    if (missing := count - len(points)) > 0:
        from scipy.stats import qmc

        sobol = qmc.Sobol(len(lower), scramble=True, rng=np.random.default_rng(seed))
        points += list(lower + (upper - lower) * sobol.random_base2(math.ceil(math.log2(missing))))[:missing]
    return points


def minimize(
    problem: LeastSquares,
    start: Array,
    *,
    scale: float | Array = 1.0,
    ftol: float,
    xtol: float,
    gtol: float,
    max_evaluations: int,
) -> dict[str, Any]:
    """Search from one start with SciPy's trust-region method; return `x`, `cost` and other parts of its result."""
    from scipy.optimize import least_squares  # imported here: slow to import

    total, count = len(problem.sample), problem.count

    def loss(square: Array) -> Array:
        # all elements of a sample share its loss; the second derivative is used only for samples of one element
        rho = loss_terms(problem.loss, np.bincount(problem.sample, square[:total], minlength=len(count)).astype(float))
        rho[0] /= count
        rho[2][count > 1] = 0.0
        terms = loss_terms("linear", square)
        terms[:, :total] = rho[:, problem.sample]
        return terms

    result = least_squares(
        problem.residual,
        start,
        jac=problem.jacobian,
        bounds=(problem.lower, problem.upper),
        method="trf",
        x_scale=scale,
        loss="linear" if problem.loss == "linear" else loss,
        ftol=ftol,
        gtol=gtol,
        xtol=xtol,
        max_nfev=max_evaluations,
    )
    return {key: result[key] for key in ("x", "cost", "status", "message", "nfev", "njev")}


def fit(
    starts: Sequence[Array],
    levels: dict[str, float],
    search: Callable[[Array, dict[str, float], int], dict[str, Any]],
    estimate_levels: Callable[[Array, dict[str, float]], dict[str, float]],
) -> tuple[list[dict[str, Any]], list[dict[str, Any]], dict[str, float]]:
    """Search roughly from every start; refine the best result, estimating noise levels and coefficients in turns.

    search: takes a start, noise levels by kind, and the stage (index of the start, or number of starts when refining).
    Return the rough results, with `x` and `cost`, the refined results (the last one is the fit), and the noise levels.
    """
    rough_results = [search(start, levels, k) for k, start in enumerate(starts)]
    refined_results = [min(rough_results, key=lambda result: float(result["cost"]))]
    for k in range(ROUNDS):
        new_levels = estimate_levels(np.array(refined_results[-1]["x"]), levels)
        if k and all(abs(new_levels[kind] / level - 1) < NOISE_TOLERANCE for kind, level in levels.items()):
            break
        levels = new_levels
        refined_results.append(search(np.array(refined_results[-1]["x"]), levels, len(starts)))
    return rough_results, refined_results[1:], levels


def estimate(
    jacobian: Array,
    x: Array,
    lower: Array,
    upper: Array,
    *,
    unit: Array,
    quantile: float,
    prior: float = 0.0,
    profile: tuple[Callable[[Array], Array], Array] | None = None,
    extra_covariance: Array | None = None,
) -> Estimate:
    """Compute covariance, directions and 95 % intervals of a fit x (n,).

    jacobian: (elements, n), with respect to x / unit. prior: inverse variance of each coefficient that is known without
    the residuals, in its unit. profile: residuals as a function of x, and their Jacobian with respect to x / unit, to
    widen intervals by the profile likelihood. extra_covariance: (n, n), of errors of x from other sources.
    """
    # With fewer residuals than unknowns, the SVD must add the undetermined directions, with singular values of 0.
    short = len(jacobian) < len(x)
    _, singular, vectors = np.linalg.svd(jacobian, full_matrices=short)
    singular = np.append(singular, np.zeros(len(x) - len(singular)))
    floor = MIN_SINGULAR * max(float(singular[0]), 1.0)
    direction_sd = 1 / np.sqrt(np.maximum(prior + singular**2, floor**2))
    if profile is not None:
        residual, profile_jacobian = profile
        box = (np.minimum(lower - x, 0.0) / unit, np.maximum(upper - x, 0.0) / unit)

        def residuals(u: Array) -> Array:
            return residual(np.clip(x + unit * u, lower, upper))

        direction_sd = profile_sd(ProfileProblem(residuals, profile_jacobian, *box, vectors, direction_sd, quantile))
    covariance = np.outer(unit, unit) * (vectors.T * direction_sd**2 @ vectors)
    if extra_covariance is not None:
        covariance = covariance + extra_covariance
        direction_sd = np.sqrt(
            direction_sd**2 + np.einsum("di,ij,dj->d", vectors / unit, extra_covariance, vectors / unit)
        )
    sd = np.sqrt(np.diag(covariance))
    low, high = (np.clip(x + side * quantile * sd, lower, upper) for side in (-1, 1))
    return Estimate(singular, vectors, direction_sd, covariance, sd, low, high)


def t_quantile(freedom: float) -> float:
    """Return the two-sided 95 % quantile of Student's t; freedom: degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + CONFIDENCE / 2))


def on_bound(x: Array, lower: Array, upper: Array) -> tuple[str | None, ...]:
    """Return for each value "lower" or "upper" if it is on that bound, else None."""
    tolerance = ON_BOUND * (upper - lower)
    return tuple(
        "lower" if value - low < margin else "upper" if high - value < margin else None
        for value, low, high, margin in zip(x, lower, upper, tolerance, strict=True)
    )
