"""Descents by sequential quadratic programming (SciPy's SLSQP; Kraft, 1988) that ask for one point after the other.

SciPy drives its own loop. So a descent is started anew for each point and answered from what is known, until it asks
for a point that is not. All is scaled: coordinates to the unit box, values to what matters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["MARGIN", "STEEP", "Stop", "Walk"]

Array = NDArray[np.float64]

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
