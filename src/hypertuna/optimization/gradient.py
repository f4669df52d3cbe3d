"""Gradient descents from several starts, behind ask and tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from hypertuna.optimization.objective import Evaluation
from hypertuna.optimization.optimizers import Optimizer

__all__ = ["MARGIN", "STEEP", "Descents", "Stop", "Walk", "latin_hypercube"]

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


PRECISION = 1e-8  # change of the value at which a descent ends
MARGIN = 1e-7  # limits are to be kept with so much to spare: SLSQP only nears them
STEEP = 1e3  # what a point that cannot be used is told to cost, and to pass its limits by


@dataclass(frozen=True)
class Stop:
    """What is known of a point on the way.

    Attributes
    ----------
    u : ndarray, shape (dim,)
        Where it is, in the unit box.
    value : float
        What falls.
    slope : ndarray, shape (dim,)
    room : ndarray, shape (limits,)
        What is left to each limit, kept where >= 0.
    room_slopes : ndarray, shape (limits, dim)
    worth : float
        By which the best is chosen.
    kept : bool
        Whether it can be chosen.
    """

    u: Array
    value: float
    slope: Array
    room: Array
    room_slopes: Array
    worth: float
    kept: bool


class _UnknownError(Exception):
    """SciPy asks for a point that is not known yet."""

    def __init__(self, u: Array) -> None:
        self.u = u


class Walk:
    """One way down.

    Parameters
    ----------
    start : ndarray, shape (dim,)
        In the unit box.
    iterations : int
        Of SLSQP at most.
    soft : int
        So many limits, the last ones, give way to a slack s >= 0, which is added to the value.
    """

    def __init__(self, start: Array, iterations: int, soft: int = 0) -> None:
        self.start = start
        self.known: dict[bytes, Stop] = {}
        self._iterations, self._soft = iterations, soft

    def learn(self, stop: Stop) -> None:
        """Take what was found at a point asked for."""
        self.known[stop.u.tobytes()] = stop

    def best(self) -> Stop | None:
        """Return the point of least worth of those kept, None if there is none."""
        return min((stop for stop in self.known.values() if stop.kept), key=lambda stop: stop.worth, default=None)

    def ask(self) -> Array | None:
        """Return the next point, None at the end of the way."""
        from scipy.optimize import minimize

        dim = len(self.start)

        def at(z: Array) -> Stop:
            u = np.minimum(np.maximum(z[:dim], 0.0), 1.0)
            if u.tobytes() not in self.known:
                raise _UnknownError(u)
            return self.known[u.tobytes()]

        try:
            first = at(self.start)
            more = np.zeros((len(first.room), min(self._soft, 1)))  # d(room)/ds
            more[len(more) - self._soft :] = 1.0
            needed = np.max(-first.room[:, np.newaxis] * more, axis=0, initial=0.0)
            minimize(
                lambda z: at(z).value + z[dim:].sum(),
                np.append(self.start, needed),
                jac=lambda z: np.append(at(z).slope, np.ones(len(z) - dim)),
                bounds=[(0.0, 1.0)] * dim + [(0.0, None)] * len(needed),
                constraints={
                    "type": "ineq",
                    "fun": lambda z: at(z).room + more @ z[dim:],
                    "jac": lambda z: np.hstack([at(z).room_slopes, more]),
                },
                method="SLSQP",
                options={"ftol": PRECISION, "maxiter": self._iterations},
            )
        except _UnknownError as question:
            return question.u
        return None
