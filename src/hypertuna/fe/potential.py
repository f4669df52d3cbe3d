"""Potential of the twin's table that fits a joint of finite elements best.

The twin's potential of a joint is U(alpha) - sum_s P_s V_s(alpha), with V_right(alpha) = V_left(-alpha), and its lines
have a compliance. Its moment and its volumes are linear in the terms of U' and V:

    M = U'(alpha) - sum_s P_s V_s'(alpha),    V_s = V(+-alpha) + c P_s + d P_other,

so linear least squares on moments and volumes together give the terms, and virtual work holds with any residual.
Cross-validation chooses the numbers of terms.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna.arrays import Array
from hypertuna.errors import InputError

ELASTIC = (1, 2, 3, 4)  # numbers of terms of U', odd powers of the angle
VOLUME = (1, 2, 3, 4, 5, 6)  # degrees of V
SAME = 1e-9  # relative tolerance of equal sums of pressures


@dataclass(frozen=True)
class Samples:
    """A joint in equilibrium under moments and pressures."""

    group: NDArray[np.int64]  # (n,) points left out together in cross-validation
    angle: Array  # (n,) [rad]
    moment: Array  # (n,) external [N m]
    pressure: Array  # (n, 2) of the left and right side [Pa]
    volume: Array  # (n, 2) of the left and right side [m^3]

    def only(self, which: NDArray[np.bool_]) -> Samples:
        """Return some of the points."""
        return Samples(*(getattr(self, field.name)[which] for field in fields(self)))

    def with_mirror(self) -> Samples:
        """Return these points and their mirror images: sides exchanged, angles and moments reversed."""
        sides = self.pressure[:, ::-1], self.volume[:, ::-1]
        other = Samples(self.group, -self.angle, -self.moment, *sides)
        return Samples(
            *(np.concatenate([getattr(side, field.name) for side in (self, other)]) for field in fields(self))
        )

    @property
    def taut(self) -> NDArray[np.bool_]:
        """Whether the braids of each side are under pressure and hence taut, (n, 2)."""
        return self.pressure > 0


@dataclass(frozen=True)
class Potential:
    """The twin's potential, a polynomial."""

    reach: float  # largest angle [rad]
    elastic_terms: Array  # (k,) of U' in odd powers of angle / reach [N m]
    volume_terms: Array  # (l,) of V in powers of angle / reach [m^3]
    compliance: float  # c [m^3/Pa]
    cross: float  # d [m^3/Pa]

    def elastic(self, angle: ArrayLike) -> Array:
        """Return the moment [N m] that holds angles (n,) [rad] without pressure."""
        return np.asarray(_odd(np.asarray(angle) / self.reach, len(self.elastic_terms)) @ self.elastic_terms)

    def volume(self, angle: ArrayLike, *, derivative: bool = False) -> Array:
        """Return the oil in the left drive units [m^3] at angles (n,) [rad], or its derivative [m^3/rad]."""
        s, count = np.asarray(angle) / self.reach, len(self.volume_terms)
        return np.asarray(
            (_derivatives(s, count) / self.reach if derivative else _powers(s, count)) @ self.volume_terms
        )

    @property
    def sound(self) -> bool:
        """Whether elastic moments straighten the joint, and volumes are positive and rise, over the whole table."""
        angle = np.linspace(-self.reach, self.reach, 201)
        restores = self.elastic(angle[angle > 0]) > 0
        return bool(restores.all() and (self.volume(angle, derivative=True) > 0).all() and self.volume(angle[0]) > 0)


@dataclass(frozen=True)
class Residual:
    """Root mean squares of the residuals of moments [N m] and of volumes of taut sides [m^3]."""

    moment: float
    volume: float


def fit_potential(samples: Samples, elastic: int, volume: int) -> Potential:
    """Fit the twin's potential to moments and volumes together.

    Volumes are weighted by their spread, moments by the work of the largest pressure over it. Sides without pressure
    do not count: where they shorten, their braids are slack.
    """
    reach = float(abs(samples.angle).max())
    rows, values = _equations(samples, reach, elastic, volume)
    moment, spread = _scales(samples)
    weight = np.concatenate([np.full(len(samples.angle), 1 / moment), samples.taut.T.ravel() / spread])
    rows, values = rows * weight[:, None], values * weight
    sums = samples.pressure.sum(axis=1)
    if np.ptp(sums) <= SAME * sums.max():
        rows[:, -1] = 0.0  # the effect of a constant sum of pressures belongs to the volumes
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0] = 1.0  # of a compliance that no point determines
    solved = np.linalg.lstsq(rows / scale, values, rcond=1e-12)[0] / scale
    elastic_terms, volume_terms, compliances = np.split(solved, [elastic, elastic + volume + 1])
    return Potential(reach, elastic_terms, volume_terms, *map(float, compliances))


def residual(fit: Potential, samples: Samples) -> Residual:
    """Return the residual of a potential."""
    rows, values = _equations(samples, fit.reach, len(fit.elastic_terms), len(fit.volume_terms) - 1)
    terms = np.concatenate([fit.elastic_terms, fit.volume_terms, [fit.compliance, fit.cross]])
    moment, volume = np.split(rows @ terms - values, [len(samples.angle)])
    return Residual(_rms(moment), _rms(volume[samples.taut.T.ravel()]))


def best_potential(samples: Samples) -> tuple[Potential, Residual]:
    """Fit the numbers of terms with the smallest cross-validated residual; return that residual, too."""
    groups = np.unique(samples.group)
    best: tuple[float, Potential, Residual] | None = None
    for elastic, volume in itertools.product(ELASTIC, VOLUME):
        fewest = min((samples.group != group).sum() for group in groups) if len(groups) > 1 else 0
        if fewest < elastic + volume + 3:
            continue
        fit = fit_potential(samples, elastic, volume)
        if not fit.sound:
            continue
        new = _cross_validated(samples, groups, elastic, volume)
        moment, spread = _scales(samples)
        score = math.hypot(new.moment / moment, new.volume / spread)
        if best is None or score < best[0]:
            best = score, fit, new
    if best is None:
        rule = "must suffice for a table with moments that straighten the joint and volumes that rise with its angle"
        value, fix = f"{len(samples.angle) // 2} with an equilibrium", "add points, or use a finer mesh"
        raise InputError(rule, key="points of pressure and couple", value=value, fix=fix)
    return best[1:]


def _cross_validated(samples: Samples, groups: NDArray[np.int64], elastic: int, volume: int) -> Residual:
    """Return the cross-validated residual: of each group by a fit to the others."""
    squares = np.zeros(2)
    for group in groups:
        held = samples.only(samples.group == group)
        group_residual = residual(fit_potential(samples.only(samples.group != group), elastic, volume), held)
        squares += [group_residual.moment**2 * len(held.angle), group_residual.volume**2 * held.taut.sum()]
    moment, spread = np.sqrt(squares / [len(samples.angle), samples.taut.sum()]).tolist()
    return Residual(moment, spread)


def _scales(samples: Samples) -> tuple[float, float]:
    """Return scales: mean moment of the largest pressure from end to end [N m], and spread of the volumes [m^3]."""
    spread = float(np.ptp(samples.volume[samples.taut]))
    return float(samples.pressure.max()) * spread / float(np.ptp(samples.angle)), spread


def _equations(samples: Samples, reach: float, elastic: int, volume: int) -> tuple[Array, Array]:
    """Return rows and right sides of all moments, all volumes of the left side, all volumes of the right side."""
    s, count, n = samples.angle / reach, volume + 1, len(samples.angle)
    first, second = samples.pressure.T
    pull = (second[:, None] * _derivatives(-s, count) - first[:, None] * _derivatives(s, count)) / reach
    none = np.zeros((n, elastic))
    rows = [
        np.hstack([_odd(s, elastic), pull, np.zeros((n, 2))]),
        np.hstack([none, _powers(s, count), samples.pressure]),
        np.hstack([none, _powers(-s, count), samples.pressure[:, ::-1]]),
    ]
    return np.concatenate(rows), np.concatenate([samples.moment, *samples.volume.T])


def _odd(s: Array, count: int) -> Array:
    """Return odd powers (..., count)."""
    return np.asarray(s[..., None] ** (2 * np.arange(count) + 1))


def _powers(s: Array, count: int) -> Array:
    """Return powers from 0 (..., count)."""
    return np.asarray(s[..., None] ** np.arange(count))


def _derivatives(s: Array, count: int) -> Array:
    """Return derivatives of the powers (..., count)."""
    k = np.arange(count)
    return np.asarray(k * s[..., None] ** np.maximum(k - 1, 0))


def _rms(values: Array) -> float:
    """Return the root mean square, 0 without values."""
    return math.sqrt(float((values**2).mean())) if len(values) else 0.0
