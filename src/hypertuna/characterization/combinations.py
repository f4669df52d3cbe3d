"""Combinations of unknowns that a bench determines, written as products of powers."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array
from hypertuna.characterization.unknowns import Unknown
from hypertuna.identification.estimator import Direction

DETERMINED = 3.0  # narrowing of an interval by the bench, above which a combination counts as determined
SHARPNESS = (10.0, DETERMINED)  # narrowing of sharp combinations, which come first, and of the others
WIDER, ROUNDED = 1.15, 1.1  # factors on the interval of a combination with fewer unknowns, and with rounded exponents
SLIGHT = 0.01  # standard deviation of a logarithm that is always allowed
MIN_SAMPLES = 8  # for an interval
GRIDS = (1.0, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01)  # of rounded exponents, the coarsest first
# Unknowns that a combination is solved for, the preferred first: those that are hard to measure.
PREFERRED = (
    *(
        "stiffness_factor",
        "friction",
        "asymmetry",
        "axis_buckling",
        "lever",
        "hose_modulus",
        "braid_angle",
        "diameter_ratio",
    ),
    *("outer_diameter", "segment_length", "matrix_modulus"),
)


@dataclass(frozen=True)
class Combination:
    """A product of powers of the unknowns that the bench determines."""

    exponents: dict[str, float]  # rounded, by `Unknown.factor`
    unknown: str  # with exponent 1: determined as well as the combination if the others are known
    narrowing: float  # length of its interval without the bench over that with it
    value: float  # each unknown relative to its described value; low, high: 95 % interval
    low: float
    high: float
    text: str


def combinations(
    free: Sequence[Unknown], z: Array, directions: Sequence[Direction], cov: Array, samples: Array, quantile: float
) -> tuple[Combination, ...]:
    """Return as many products of powers as directions are determined, each solved for one unknown, the sharpest first.

    z: the fit (n,), logarithms from the described values in prior standard deviations; cov: their covariance (n, n);
    samples: other points (samples, n) that fit; quantile: of the 95 % interval, in standard deviations.
    """
    vectors = np.array([one.vector for one in directions])
    known = np.hypot(1, [one.singular_value for one in directions])
    precision, left = np.asarray(vectors.T * known**2 @ vectors), list(range(len(free)))
    products: list[Combination] = []
    for narrowing in SHARPNESS:
        count = int(np.sum(known >= narrowing)) - len(products)
        chosen = _solvable(free, precision, left, narrowing)[:count]
        others = [k for k in range(len(left)) if k not in chosen]
        own = np.linalg.inv(precision[np.ix_(chosen, chosen)])
        known_by = [left[i] for i in others]
        products += [_combination(free, left[k], known_by, z, cov, samples, quantile) for k in chosen]
        follow = own @ precision[np.ix_(chosen, others)]
        precision = np.asarray(precision[np.ix_(others, others)] - precision[np.ix_(others, chosen)] @ follow)
        left = known_by
    return tuple(sorted(products, key=lambda one: one.high / one.low))


def _solvable(free: Sequence[Unknown], precision: Array, left: Sequence[int], narrowing: float) -> list[int]:
    """Choose unknowns that would all be narrowed by this factor if the rest of those left were known."""
    chosen: list[int] = []
    for k in sorted(range(len(left)), key=lambda i: PREFERRED.index(free[left[i]].kind)):
        block = precision[np.ix_([*chosen, k], [*chosen, k])]
        if np.all(np.diag(np.linalg.inv(block)) < narrowing**-2):
            chosen.append(k)
    return chosen


def _combination(
    free: Sequence[Unknown], k: int, others: Sequence[int], z: Array, cov: Array, samples: Array, quantile: float
) -> Combination:
    """Return the product of unknown k and few others, with rounded exponents and the interval of that product."""
    prior_sd, n = np.array([one.prior_sd for one in free]), len(free)

    def sd_of(exponents: Array) -> float:
        along = exponents * prior_sd
        return math.sqrt(float(along @ cov @ along))

    def solved(by: Sequence[int]) -> Array:
        # the best exponents of these unknowns: regression with the covariance
        vector = np.eye(n)[k]
        vector[by] = -np.linalg.solve(cov[np.ix_(by, by)], cov[by, k])
        return np.asarray(vector * prior_sd[k] / prior_sd)

    kept = list(others)
    enough = max(WIDER * sd_of(solved(kept)), SLIGHT)
    while kept:
        fewer = min(([j for j in kept if j != i] for i in kept), key=lambda by: sd_of(solved(by)))
        if sd_of(solved(fewer)) > enough:
            break
        kept = fewer
    exact = solved(kept)
    for grid in GRIDS:
        exponents = np.asarray(grid * np.round(exact / grid))
        if sd_of(exponents) <= max(ROUNDED * sd_of(exact), SLIGHT):
            break
    along = exponents * prior_sd
    middle = float(along @ z)
    low, high = middle - quantile * sd_of(exponents), middle + quantile * sd_of(exponents)
    if len(samples) >= MIN_SAMPLES:  # a product holds near the fit; samples farther away that fit too show its error
        values = samples @ along
        about, reach = float(values.mean()), quantile * float(values.std(ddof=1)) * math.sqrt(1 + 1 / len(values))
        low, high = min(low, about - reach), max(high, about + reach)
    names = {one.factor: round(float(e), 2) for one, e in zip(free, exponents, strict=True) if e}
    return Combination(
        exponents=names,
        unknown=free[k].factor,
        narrowing=2 * quantile * float(np.linalg.norm(along)) / (high - low),
        value=math.exp(middle),
        low=math.exp(low),
        high=math.exp(high),
        text=_product(names),
    )


def _product(exponents: Mapping[str, float]) -> str:
    """Format a product of powers as a fraction."""
    parts: tuple[list[str], list[str]] = ([], [])
    for name, e in sorted(exponents.items(), key=lambda one: -abs(one[1])):
        power = "" if abs(abs(e) - 1) < 1e-9 else f"^{abs(e):.3g}"
        parts[e < 0].append(f"{name}{power}")
    over, under = (" ".join(part) for part in parts)
    if not under:
        return over
    return f"{over or '1'} / ({under})" if len(parts[1]) > 1 else f"{over or '1'} / {under}"
