"""Combinations of unknowns that a bench determines, written as products of powers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna.characterization.unknowns import Unknown
from hypertuna.identification.estimator import Direction

__all__ = ["DETERMINED", "Combination", "combinations"]

Array = NDArray[np.float64]

DETERMINED = 3.0  # a combination that the bench narrows so many times counts as determined
SHARPNESS = (10.0, DETERMINED)  # the same, by which combinations are told apart: sharp ones first
LOOSER, ROUNDED, SLIGHT = 1.15, 1.1, 0.01  # how much less sharp a combination may be with fewer factors, and rounded
FEWEST = 8  # draws that an interval can be told from
GRIDS = (1.0, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01)
# Which unknown a combination is solved for, first to last: those that no caliper reaches come first.
PREFERRED = (
    *("stiffness_factor", "friction", "asymmetry", "lever", "hose_modulus", "braid_angle", "diameter_ratio"),
    *("outer_diameter", "sleeve", "segment_length", "matrix_modulus"),
)


@dataclass(frozen=True)
class Combination:
    """A product of powers of the unknowns that the bench determines.

    Attributes
    ----------
    exponents : dict of float
        As written: rounded; by `Unknown.factor`.
    unknown : str
        The one with exponent 1, which is known as well as the combination if the others are known.
    narrowing : float
        How many times shorter its interval is than without the bench.
    value, low, high : float
        The product as written, each unknown counted from its described value; 95 % interval.
    text : str
    """

    exponents: dict[str, float]
    unknown: str
    narrowing: float
    value: float
    low: float
    high: float
    text: str


def combinations(
    free: Sequence[Unknown], z: Array, directions: Sequence[Direction], cov: Array, drawn: Array, quantile: float
) -> tuple[Combination, ...]:
    """Write what is determined as products of powers, each solved for one unknown.

    Parameters
    ----------
    free : sequence of Unknown
    z : ndarray, shape (n,)
        The fit: logarithms from what is described, in units of `Unknown.prior_sd` [1].
    directions : sequence of Direction
    cov : ndarray, shape (n, n)
        Covariance in these units [1].
    drawn : ndarray, shape (draws, n)
        Other points that fit [1].
    quantile : float
        Of the 95 % interval, in standard deviations [1].

    Returns
    -------
    tuple of Combination
        As many as directions are determined, the sharpest first.

    Notes
    -----
    With the precision L, the inverse of the covariance, unknowns A given all others B have the covariance 1 / L_AA and
    follow them with the exponents -L_AB / L_AA. Sharp combinations come first; L of the others without A is then
    L_BB - L_BA L_AB / L_AA, and tells the next ones.
    """
    vectors = np.array([one.vector for one in directions])
    known = np.hypot(1, [one.singular_value for one in directions])
    precision, left = np.asarray(vectors.T * known**2 @ vectors), list(range(len(free)))
    found: list[Combination] = []
    for narrowing in SHARPNESS:
        most = int(np.sum(known >= narrowing)) - len(found)  # no more than there are directions
        chosen = _solvable(free, precision, left, narrowing)[:most]
        others = [k for k in range(len(left)) if k not in chosen]
        own = np.linalg.inv(precision[np.ix_(chosen, chosen)])
        known_by = [left[i] for i in others]
        found += [_combination(free, left[k], known_by, z, cov, drawn, quantile) for k in chosen]
        follow = own @ precision[np.ix_(chosen, others)]
        precision = np.asarray(precision[np.ix_(others, others)] - precision[np.ix_(others, chosen)] @ follow)
        left = known_by
    return tuple(sorted(found, key=lambda one: one.high / one.low))


def _solvable(free: Sequence[Unknown], precision: Array, left: Sequence[int], narrowing: float) -> list[int]:
    """Choose unknowns that would all be known so much better than before if the rest of those left were known."""
    chosen: list[int] = []
    for k in sorted(range(len(left)), key=lambda i: PREFERRED.index(free[left[i]].kind)):
        block = precision[np.ix_([*chosen, k], [*chosen, k])]
        if np.all(np.diag(np.linalg.inv(block)) < narrowing**-2):
            chosen.append(k)
    return chosen


def _combination(
    free: Sequence[Unknown], k: int, others: Sequence[int], z: Array, cov: Array, drawn: Array, quantile: float
) -> Combination:
    """Write what an unknown follows: with few others, exponents rounded, and the interval of what is written."""
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
    enough = max(LOOSER * sd_of(solved(kept)), SLIGHT)
    while kept:
        least = min(kept, key=lambda i: sd_of(solved([j for j in kept if j != i])))
        fewer = [j for j in kept if j != least]
        if sd_of(solved(fewer)) > enough:
            break
        kept = fewer
    exact = solved(kept)
    for grid in GRIDS:
        exponents = np.asarray(grid * np.round(exact / grid))
        if sd_of(exponents) <= max(ROUNDED * sd_of(exact), SLIGHT):
            break
    along = exponents * prior_sd
    middle, low, high = _interval(along, z, sd_of(exponents), drawn, quantile)
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


def _interval(along: Array, z: Array, sd: float, drawn: Array, quantile: float) -> tuple[float, float, float]:
    """Return a combination's value and 95 % interval: that about the fit, widened to that of the draws.

    A product of powers holds near the fit; draws further off, but as good, tell how far it really does.
    """
    middle = float(along @ z)
    low, high = middle - quantile * sd, middle + quantile * sd
    if len(drawn) >= FEWEST:
        values = drawn @ along
        about, reach = float(values.mean()), quantile * float(values.std(ddof=1)) * math.sqrt(1 + 1 / len(values))
        low, high = min(low, about - reach), max(high, about + reach)
    return middle, low, high


def _product(exponents: Mapping[str, float]) -> str:
    """Write a product of powers as a fraction."""
    parts: tuple[list[str], list[str]] = ([], [])
    for name, e in sorted(exponents.items(), key=lambda one: -abs(one[1])):
        power = "" if abs(abs(e) - 1) < 1e-9 else f"^{abs(e):.3g}"
        parts[e < 0].append(f"{name}{power}")
    over, under = (" ".join(part) for part in parts)
    if not under:
        return over
    return f"{over or '1'} / ({under})" if len(parts[1]) > 1 else f"{over or '1'} / {under}"
