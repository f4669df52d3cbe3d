"""Gradient descents from several starts, behind ask and tell."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from hypertuna.objective import Evaluation
from hypertuna.optimizers import Optimizer
from hypertuna.walk import MARGIN, STEEP, Stop, Walk

__all__ = ["Descents", "latin_hypercube"]

Array = NDArray[np.float64]

SAME = 1e-3  # values so near, relative, are the same


@final
class Descents(Optimizer):
    """Gradient descents from several starts by sequential quadratic programming.

    All go in lockstep: a batch has the next point of every one that has not ended. The kink of |U - U_e| is kept from
    them: they minimize a slack s >= U - U_e, s >= U_e - U instead, both smooth.

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
        soft = 0 if expected is None else 2
        self._walks = [Walk(u, iterations, soft) for u in latin_hypercube(starts, len(lower), seed)]
        self._running = {walk: walk.start for walk in self._walks}
        self._cut = 0  # descents that had not come to their end

    @property
    def stop(self) -> str | None:
        """Why there is nothing more to ask."""
        if self._running:
            return None
        ends = [np.inf if (best := walk.best()) is None else best.worth for walk in self._walks]
        least = min(ends)
        same = sum(end <= least + SAME * abs(least) for end in ends) if np.isfinite(least) else 0
        verb = "was" if self._cut == 1 else "were"
        cut = f"; {self._cut} {verb} cut off after {self._iterations} points" if self._cut else ""
        return f"All {len(ends)} gradient descents have ended, {same} of them at the best value{cut}."

    def _propose(self) -> Array:
        return self.lower + np.stack(list(self._running.values())) * (self.upper - self.lower)

    def _learn(self, told: Evaluation) -> None:
        for (walk, u), k in zip(self._running.items(), range(len(told.x)), strict=True):
            walk.learn(self._stop(told, k, u))
        asked = {walk: walk.ask() for walk in self._running}
        going = {walk: u for walk, u in asked.items() if u is not None}
        self._running = going if len(self.batches) < self._iterations else {}
        self._cut = len(going) - len(self._running)

    def _stop(self, told: Evaluation, k: int, u: Array) -> Stop:
        """Scale what was told of a point; a gait that cannot be used costs much, and has no slope."""
        assert told.value_slopes is not None
        assert told.violation_slopes is not None
        assert told.speed_slopes is not None
        width, scale, room = self.upper - self.lower, self._scale, -told.violation[k] - MARGIN
        slope, room_slopes = told.value_slopes[k, 0] * width / scale, -told.violation_slopes[k] * width
        value = worth = float(told.value[k, 0]) / scale
        if self._expected is not None:
            miss = float(told.found["speed"][k] - self._expected) / scale
            away = told.speed_slopes[k] * width / scale
            # The value without |U - U_e|, and the two limits of the slack.
            value, slope = value - abs(miss), slope - np.sign(miss) * away
            room, room_slopes = np.append(room, [-miss, miss]), np.vstack([room_slopes, -away, away])
        if not np.isfinite(worth):
            gone = np.full_like(room, -STEEP)
            return Stop(u, STEEP, np.zeros_like(slope), gone, np.zeros_like(room_slopes), STEEP, kept=False)
        return Stop(u, value, slope, room, room_slopes, worth, kept=bool(told.feasible[k]))


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
