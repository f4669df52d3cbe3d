"""Potential: of all that the twin's table can be, the one that is nearest to a joint of finite elements.

The twin takes a joint for U(alpha) - sum_s P_s V_s(alpha), in which V_right(alpha) = V_left(-alpha), and its lines for
a compliance. Its moment and its volumes are linear in the terms of U' and V:

    M = U'(alpha) - sum_s P_s V_s'(alpha),    V_s = V(+-alpha) + c P_s + d P_other,

so linear least squares on moments and volumes together find them, and virtual work holds whatever stays unexplained.
The numbers of terms are those that say most about points that they were not fitted to.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna.errors import InputError

__all__ = ["Left", "Potential", "Samples", "best_potential", "fit_potential", "left"]

Array = NDArray[np.float64]

ELASTIC = (1, 2, 3, 4)  # numbers of terms of U', odd powers of the angle
VOLUME = (1, 2, 3, 4, 5, 6)  # degrees of V
SAME = 1e-9  # relative: sums of pressures that differ by less are the same


@dataclass(frozen=True)
class Samples:
    """A joint in equilibrium under moments and pressures."""

    group: NDArray[np.int64]  # (n,) What is left out together in cross-validation
    angle: Array  # (n,) [rad], and from outside [N m]
    moment: Array  # (n,) [rad], and from outside [N m]
    pressure: Array  # (n, 2) Of the left and the right side [Pa], [m^3]
    volume: Array  # (n, 2) Of the left and the right side [Pa], [m^3]

    def only(self, which: NDArray[np.bool_]) -> Samples:
        """Return some of the points."""
        return Samples(*(getattr(self, field.name)[which] for field in fields(self)))

    def with_mirror(self) -> Samples:
        """Return these points and their mirror images: sides exchanged, angles and moments turned round."""
        sides = self.pressure[:, ::-1], self.volume[:, ::-1]
        other = Samples(self.group, -self.angle, -self.moment, *sides)
        return Samples(
            *(np.concatenate([getattr(side, field.name) for side in (self, other)]) for field in fields(self))
        )

    @property
    def taut(self) -> NDArray[np.bool_]:
        """Whether the braids of either side are sure to be taut: under pressure; shape (n, 2)."""
        return self.pressure > 0


@dataclass(frozen=True)
class Potential:
    """The twin's potential, a polynomial."""

    reach: float  # largest angle [rad]
    elastic_terms: Array  # (k,) Of U' in odd powers of angle / reach [N m]
    volume_terms: Array  # (l,) Of V in powers of angle / reach [m^3]
    compliance: float  # c and d [m^3/Pa]
    cross: float  # c and d [m^3/Pa]

    def elastic(self, angle: ArrayLike) -> Array:
        """Moment that holds an angle without pressure. `angle` (n,) [rad]; returns [N m]."""
        return np.asarray(_odd(np.asarray(angle) / self.reach, len(self.elastic_terms)) @ self.elastic_terms)

    def volume(self, angle: ArrayLike, *, slope: bool = False) -> Array:
        """Oil in the drive units of the left side; the right side has at -angle what the left has at angle.

        `angle` (n,) [rad]; returns [m^3].
        """
        s, count = np.asarray(angle) / self.reach, len(self.volume_terms)
        return np.asarray((_slopes(s, count) / self.reach if slope else _powers(s, count)) @ self.volume_terms)

    @property
    def sound(self) -> bool:
        """Whether elastic moments straighten the joint, and volumes are positive and rise, all over the table."""
        angle = np.linspace(-self.reach, self.reach, 201)
        restores = self.elastic(angle[angle > 0]) > 0
        return bool(restores.all() and (self.volume(angle, slope=True) > 0).all() and self.volume(angle[0]) > 0)


@dataclass(frozen=True)
class Left:
    """What a potential leaves unexplained, roots of mean squares: of moments [N m], of volumes of taut sides [m^3]."""

    moment: float
    volume: float


def fit_potential(samples: Samples, elastic: int, volume: int) -> Potential:
    """Fit the twin's potential to moments and volumes together.

    Volumes are weighed by their spread, moments by the work that the largest pressure does on it from end to end. Sides
    without pressure do not count: where they are shortened, their braids hang loose.
    """
    reach = float(abs(samples.angle).max())
    rows, values = _equations(samples, reach, elastic, volume)
    moment, spread = _scales(samples)
    weight = np.concatenate([np.full(len(samples.angle), 1 / moment), samples.taut.T.ravel() / spread])
    rows, values = rows * weight[:, None], values * weight
    sums = samples.pressure.sum(axis=1)
    if np.ptp(sums) <= SAME * sums.max():
        rows[:, -1] = 0.0  # nothing tells what the sum of the pressures does: it counts to the volumes
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0] = 1.0  # of a compliance that no point tells of
    solved = np.linalg.lstsq(rows / scale, values, rcond=1e-12)[0] / scale
    elastic_terms, volume_terms, given = np.split(solved, [elastic, elastic + volume + 1])
    return Potential(reach, elastic_terms, volume_terms, *map(float, given))


def left(fit: Potential, samples: Samples) -> Left:
    """Say what a potential leaves unexplained."""
    rows, values = _equations(samples, fit.reach, len(fit.elastic_terms), len(fit.volume_terms) - 1)
    terms = np.concatenate([fit.elastic_terms, fit.volume_terms, [fit.compliance, fit.cross]])
    moment, volume = np.split(rows @ terms - values, [len(samples.angle)])
    return Left(_rms(moment), _rms(volume[samples.taut.T.ravel()]))


def best_potential(samples: Samples) -> tuple[Potential, Left]:
    """Choose the numbers of terms by what each choice says of groups of points that it was not fitted to."""
    groups = np.unique(samples.group)
    best: tuple[float, Potential, Left] | None = None
    for elastic, volume in itertools.product(ELASTIC, VOLUME):
        fewest = min((samples.group != group).sum() for group in groups) if len(groups) > 1 else 0
        if fewest < elastic + volume + 3:
            continue
        fit = fit_potential(samples, elastic, volume)
        if not fit.sound:
            continue
        new = _left_out(samples, groups, elastic, volume)
        moment, spread = _scales(samples)
        score = math.hypot(new.moment / moment, new.volume / spread)
        if best is None or score < best[0]:
            best = score, fit, new
    if best is None:
        rule = "must suffice for a table with moments that straighten the joint and volumes that rise with its angle"
        value, fix = f"{len(samples.angle) // 2} that were found", "ask for more of them, or for a finer mesh"
        raise InputError(rule, key="points of pressure and couple", value=value, fix=fix)
    return best[1:]


def _left_out(samples: Samples, groups: NDArray[np.int64], elastic: int, volume: int) -> Left:
    """Rms of each group by a fit to the others."""
    squares = np.zeros(2)
    for group in groups:
        held = samples.only(samples.group == group)
        found = left(fit_potential(samples.only(samples.group != group), elastic, volume), held)
        squares += [found.moment**2 * len(held.angle), found.volume**2 * held.taut.sum()]
    moment, spread = np.sqrt(squares / [len(samples.angle), samples.taut.sum()]).tolist()
    return Left(moment, spread)


def _scales(samples: Samples) -> tuple[float, float]:
    """Moment that the largest pressure makes on the way from end to end [N m], and spread of the volumes [m^3]."""
    spread = float(np.ptp(samples.volume[samples.taut]))
    return float(samples.pressure.max()) * spread / float(np.ptp(samples.angle)), spread


def _equations(samples: Samples, reach: float, elastic: int, volume: int) -> tuple[Array, Array]:
    """Rows and right sides: of all moments, then of all volumes of the left, then of the right side."""
    s, count, n = samples.angle / reach, volume + 1, len(samples.angle)
    first, second = samples.pressure.T
    pull = (second[:, None] * _slopes(-s, count) - first[:, None] * _slopes(s, count)) / reach
    none = np.zeros((n, elastic))
    rows = [
        np.hstack([_odd(s, elastic), pull, np.zeros((n, 2))]),
        np.hstack([none, _powers(s, count), samples.pressure]),
        np.hstack([none, _powers(-s, count), samples.pressure[:, ::-1]]),
    ]
    return np.concatenate(rows), np.concatenate([samples.moment, *samples.volume.T])


def _odd(s: Array, count: int) -> Array:
    """Odd powers, shape (..., count)."""
    return np.asarray(s[..., None] ** (2 * np.arange(count) + 1))


def _powers(s: Array, count: int) -> Array:
    """Powers from 0 on, shape (..., count)."""
    return np.asarray(s[..., None] ** np.arange(count))


def _slopes(s: Array, count: int) -> Array:
    """Slopes of the powers, shape (..., count)."""
    k = np.arange(count)
    return np.asarray(k * s[..., None] ** np.maximum(k - 1, 0))


def _rms(values: Array) -> float:
    """Root of the mean square, 0 of nothing."""
    return math.sqrt(float((values**2).mean())) if len(values) else 0.0
