"""Combinations of unknowns that a bench determines, written as products of powers."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array
from hypertuna.characterization.unknowns import Unknown
from hypertuna.identification.estimator import Direction

DETERMINED = 3.0  # a combination is determined if the bench narrows its interval by at least this factor
SHARPNESS = (10.0, DETERMINED)  # factors of narrowing: combinations above the first are found before the others
WIDER, ROUNDED = 1.15, 1.1  # allowed widening of an interval by leaving out unknowns, and by rounding exponents
SLIGHT = 0.01  # standard deviation of the logarithm of a combination that is always small enough
MIN_SAMPLES = 8  # fewest randomized fits from which an interval is computed
GRIDS = (1.0, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01)  # steps to which exponents are rounded, the coarsest first
# Unknowns for which a combination is solved, in order of preference: the hardest to measure come first.
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
    """A product of powers of unknowns that the bench determines, with its interval."""

    exponents: dict[str, float]  # rounded exponents, by `Unknown.factor`
    unknown: str  # the unknown with exponent 1; once the others are known, it is known as well as the product
    narrowing: float  # length of the interval without the bench over the length with the bench
    value: float  # the product, with each unknown relative to its described value
    low: float  # lower end of the 95 % interval
    high: float  # upper end of the 95 % interval
    text: str  # the product as a fraction


def combinations(
    free: Sequence[Unknown], z: Array, directions: Sequence[Direction], cov: Array, samples: Array, quantile: float
) -> tuple[Combination, ...]:
    """Return a product of powers for each determined direction, each solved for one unknown, the narrowest first.

    z: the fit (n,), logarithms from the described values in prior standard deviations. cov: their covariance (n, n).
    samples: other fits (samples, n). quantile: half width of a 95 % interval in standard deviations.
    """
    vectors = np.array([direction.vector for direction in directions])
    narrowings = np.hypot(1, [direction.singular_value for direction in directions])
    precision, remaining = np.asarray(vectors.T * narrowings**2 @ vectors), list(range(len(free)))
    products: list[Combination] = []
    for narrowing in SHARPNESS:
        count = int(np.sum(narrowings >= narrowing)) - len(products)
        chosen = _solvable(free, precision, remaining, narrowing)[:count]
        others = [k for k in range(len(remaining)) if k not in chosen]
        inverse = np.linalg.inv(precision[np.ix_(chosen, chosen)])
        unsolved = [remaining[i] for i in others]
        products += [_combination(free, remaining[k], unsolved, z, cov, samples, quantile) for k in chosen]
        regression = inverse @ precision[np.ix_(chosen, others)]
        precision = np.asarray(precision[np.ix_(others, others)] - precision[np.ix_(others, chosen)] @ regression)
        remaining = unsolved
    return tuple(sorted(products, key=lambda direction: direction.high / direction.low))


def _solvable(free: Sequence[Unknown], precision: Array, left: Sequence[int], narrowing: float) -> list[int]:
    """Return indices of unknowns that the bench narrows by a factor, once the unknowns not chosen are known."""
    chosen: list[int] = []
    for k in sorted(range(len(left)), key=lambda i: PREFERRED.index(free[left[i]].kind)):
        block = precision[np.ix_([*chosen, k], [*chosen, k])]
        if np.all(np.diag(np.linalg.inv(block)) < narrowing**-2):
            chosen.append(k)
    return chosen


def _combination(
    free: Sequence[Unknown], k: int, others: Sequence[int], z: Array, cov: Array, samples: Array, quantile: float
) -> Combination:
    """Return the product of unknown k and of as few others as possible, with rounded exponents and an interval."""
    prior_sd, n = np.array([unknown.prior_sd for unknown in free]), len(free)

    def sd_of(exponents: Array) -> float:
        scaled = exponents * prior_sd
        return math.sqrt(float(scaled @ cov @ scaled))

    def exponents_by(indices: Sequence[int]) -> Array:
        # the exponents that give the narrowest product of unknown k and these unknowns, by regression
        vector = np.eye(n)[k]
        vector[indices] = -np.linalg.solve(cov[np.ix_(indices, indices)], cov[indices, k])
        return np.asarray(vector * prior_sd[k] / prior_sd)

    used = list(others)
    acceptable = max(WIDER * sd_of(exponents_by(used)), SLIGHT)
    while used:
        fewer = min(([j for j in used if j != i] for i in used), key=lambda indices: sd_of(exponents_by(indices)))
        if sd_of(exponents_by(fewer)) > acceptable:
            break
        used = fewer
    exact = exponents_by(used)
    for grid in GRIDS:
        exponents = np.asarray(grid * np.round(exact / grid))
        if sd_of(exponents) <= max(ROUNDED * sd_of(exact), SLIGHT):
            break
    scaled = exponents * prior_sd
    middle = float(scaled @ z)
    low, high = middle - quantile * sd_of(exponents), middle + quantile * sd_of(exponents)
    if len(samples) >= MIN_SAMPLES:  # a product is linear about the fit; samples farther away show its error
        values = samples @ scaled
        center, half_width = float(values.mean()), quantile * float(values.std(ddof=1)) * math.sqrt(1 + 1 / len(values))
        low, high = min(low, center - half_width), max(high, center + half_width)
    names = {unknown.factor: round(float(e), 2) for unknown, e in zip(free, exponents, strict=True) if e}
    return Combination(
        exponents=names,
        unknown=free[k].factor,
        narrowing=2 * quantile * float(np.linalg.norm(scaled)) / (high - low),
        value=math.exp(middle),
        low=math.exp(low),
        high=math.exp(high),
        text=_product(names),
    )


def _product(exponents: Mapping[str, float]) -> str:
    """Return a product of powers as text, negative exponents in the denominator of a fraction."""
    parts: tuple[list[str], list[str]] = ([], [])
    for name, e in sorted(exponents.items(), key=lambda one: -abs(one[1])):
        power = "" if abs(abs(e) - 1) < 1e-9 else f"^{abs(e):.3g}"
        parts[e < 0].append(f"{name}{power}")
    numerator, denominator = (" ".join(part) for part in parts)
    if not denominator:
        return numerator
    return f"{numerator or '1'} / ({denominator})" if len(parts[1]) > 1 else f"{numerator or '1'} / {denominator}"
