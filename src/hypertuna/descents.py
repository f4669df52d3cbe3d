"""Gradient descents from several starts, behind ask and tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from hypertuna.objective import Evaluation
from hypertuna.optimizers import Optimizer

__all__ = ["Descents", "latin_hypercube"]

Array = NDArray[np.float64]

SAME = 1e-3  # values so near, relative, are the same


class _UnknownError(Exception):
    """SciPy asks for a point that is not known yet."""

    def __init__(self, point: Array) -> None:
        self.point = point


@final
class Descents(Optimizer):
    """Gradient descents from several starts by sequential quadratic programming (SciPy's SLSQP; Kraft, 1988).

    All go in lockstep: a batch has the next point of every one that has not ended. SciPy drives its own loop, so it
    is started anew for each batch and answered from what is known, until it asks for a point that is not. The kink of
    |U - U_e| is kept from it: it minimizes a slack s >= U - U_e, s >= U_e - U instead, both smooth.

    Parameters
    ----------
    lower, upper : ndarray, shape (dim,)
        The box [any].
    expected : float or None
        U_e [m/s].
    scale : float
        Size of a difference in value that matters [unit of the value].
    starts, iterations, seed : int
        `iterations` is the number of points of a descent at most.
    """

    needs_slopes = True
    PRECISION = 1e-8  # of the value, in scales
    MARGIN = 1e-8  # limits are kept with so much to spare: SLSQP only nears them
    STEEP = 1e3  # what a gait that cannot be used is told to cost, in scales

    def __init__(
        self,
        lower: Array,
        upper: Array,
        expected: float | None,
        scale: float,
        *,
        starts: int,
        iterations: int,
        seed: int,
    ) -> None:
        super().__init__(lower, upper)
        self._expected, self._scale, self._iterations = expected, scale, iterations
        self._starts = latin_hypercube(starts, len(lower), seed)
        self._known: list[dict[bytes, _Point]] = [{} for _ in range(starts)]
        self._running = {k: self._starts[k] for k in range(starts)}
        self._cut = 0  # descents that had not come to their end

    @property
    def stop(self) -> str | None:
        """Why there is nothing more to ask."""
        if self._running:
            return None
        ends = [min((p.value for p in known.values() if p.kept), default=np.inf) for known in self._known]
        least = min(ends)
        same = sum(end <= least + SAME * abs(least) for end in ends) if np.isfinite(least) else 0
        verb = "was" if self._cut == 1 else "were"
        cut = f"; {self._cut} {verb} cut off after {self._iterations} points" if self._cut else ""
        return f"All {len(ends)} gradient descents have ended, {same} of them at the best value{cut}."

    def _propose(self) -> Array:
        return self.lower + np.stack(list(self._running.values())) * (self.upper - self.lower)

    def _learn(self, told: Evaluation) -> None:
        points = _points(told, self._expected, self.upper - self.lower, self._scale, self.STEEP)
        for (k, u), point in zip(self._running.items(), points, strict=True):
            self._known[k][u.tobytes()] = point
        asked = {k: self._next(self._starts[k], self._known[k]) for k in self._running}
        going = {k: u for k, u in asked.items() if u is not None}
        self._running = going if len(self.batches) < self._iterations else {}
        self._cut = len(going) - len(self._running)

    def _next(self, start: Array, known: dict[bytes, _Point]) -> Array | None:
        """Return the point that SLSQP asks for next on its way from a start, None at its end."""
        from scipy.optimize import minimize

        def at(z: Array) -> _Point:
            u = np.clip(z[: len(start)], 0.0, 1.0)
            if u.tobytes() not in known:
                raise _UnknownError(u)
            return known[u.tobytes()]

        slack = self._expected is not None
        inside = [_inequality(lambda p: -p.violation - self.MARGIN, lambda p: -p.d_violation, at, 0.0, slack)]
        if slack:
            inside += [
                _inequality(lambda p: -p.miss, lambda p: -p.d_miss, at, 1.0, slack),
                _inequality(lambda p: p.miss, lambda p: p.d_miss, at, 1.0, slack),
            ]
        try:
            minimize(
                lambda z: at(z).smooth + (z[-1] if slack else 0.0),
                np.append(start, abs(at(start).miss)) if slack else start,
                jac=lambda z: np.append(at(z).d_smooth, 1.0) if slack else at(z).d_smooth,
                bounds=[(0.0, 1.0)] * len(start) + [(0.0, None)] * slack,
                constraints=inside,
                method="SLSQP",
                options={"ftol": self.PRECISION, "maxiter": self._iterations},
            )
        except _UnknownError as question:
            return question.point
        return None


@dataclass(frozen=True)
class _Point:
    """What is known of a point, in coordinates scaled to the unit box and values scaled to what matters."""

    value: float
    kept: bool  # whether it can be used and keeps every limit
    smooth: float  # value without |U - U_e|
    miss: float  # U - U_e, 0 if no speed is expected
    violation: Array  # (limits,)
    d_smooth: Array  # (dim,)
    d_miss: Array  # (dim,)
    d_violation: Array  # (limits, dim)


def _points(told: Evaluation, expected: float | None, width: Array, scale: float, steep: float) -> list[_Point]:
    """Scale what was told; a gait that cannot be used costs much, and has no slope."""
    assert told.value_slopes is not None
    assert told.violation_slopes is not None
    assert told.speed_slopes is not None
    points = []
    for k, usable in enumerate(np.isfinite(told.value[:, 0])):
        miss = 0.0 if expected is None else float(told.found["speed"][k] - expected) / scale
        side = np.sign(miss)
        value = float(told.value[k, 0]) / scale if usable else steep
        d_value = told.value_slopes[k, 0] * width / scale
        d_miss = side * side * told.speed_slopes[k] * width / scale
        columns = [d_value - side * d_miss, d_miss, told.violation_slopes[k] * width]
        d_smooth, d_miss, d_violation = columns if usable else (np.zeros_like(column) for column in columns)
        kept = bool(told.feasible[k])
        points.append(_Point(value, kept, value - abs(miss), miss, told.violation[k], d_smooth, d_miss, d_violation))
    return points


def _inequality(
    value: Callable[[_Point], Any],
    slope: Callable[[_Point], Any],
    at: Callable[[Array], _Point],
    slack: float,
    has: bool,
) -> dict[str, Any]:
    """Return the constraint value + slack s >= 0 as SciPy takes it; s is the last coordinate, if there is one."""

    def values(z: Array) -> Array:
        return np.asarray(value(at(z)) + slack * z[-1]).reshape(-1)

    def slopes(z: Array) -> Array:
        rows = np.atleast_2d(np.asarray(slope(at(z)), dtype=np.float64))
        return np.hstack([rows, np.full((len(rows), 1), slack)]) if has else rows

    return {"type": "ineq", "fun": values, "jac": slopes}


def latin_hypercube(count: int, dim: int, seed: int) -> Array:
    """Spread points over the unit box: one in each of as many slices of every coordinate.

    Parameters
    ----------
    count, dim, seed : int

    Returns
    -------
    ndarray, shape (count, dim)
        [1].
    """
    random = np.random.default_rng(seed)
    slices = np.stack([random.permutation(count) for _ in range(dim)], axis=1)
    return np.asarray((slices + random.random((count, dim))) / count)
