"""NSGA-II behind ask and tell, and what measures a set of points: dominance and hypervolume."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.optimization.objective import UNUSABLE, Evaluation

__all__ = ["Evolution", "hypervolume", "nondominated"]

Array = NDArray[np.float64]


class Evolution:
    """The multi-objective genetic algorithm NSGA-II (Deb et al., 2002), by pymoo.

    Points that violate a constraint give way to those that violate it less, and all of them to feasible ones.

    Parameters
    ----------
    lower, upper : ndarray, shape (dim,)
        Bounds [unit of each variable].
    goals, constraints : int
        Numbers of objectives, all minimized, and of constraints.
    population, generations, seed : int
    """

    def __init__(
        self,
        lower: Array,
        upper: Array,
        goals: int,
        constraints: int,
        *,
        population: int,
        generations: int,
        seed: int,
    ) -> None:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.problem import Problem

        pymoo: Any = Problem(n_var=len(lower), n_obj=goals, n_ieq_constr=constraints + 1, xl=lower, xu=upper)
        self._algorithm: Any = NSGA2(pop_size=population, seed=seed)
        self._algorithm.setup(pymoo, termination=("n_gen", generations), verbose=False)
        self._generations = generations
        self._asked: Any = None
        self._kept: Evaluation | None = None  # what is known of the population

    @property
    def stop(self) -> str | None:
        """Why there is nothing more to ask, None while there is."""
        if self._algorithm.has_next():
            return None
        return f"The {self._generations} generations are done."

    def ask(self) -> Array:
        """Return the next population, shape (n, dim) [unit of each variable]."""
        self._asked = self._algorithm.ask()
        return np.array(self._asked.get("X"), dtype=np.float64)

    def tell(self, told: Evaluation) -> None:
        """Take what was found at the population asked for."""
        usable = np.all(np.isfinite(told.value), axis=1, keepdims=True)
        # One more limit, so that a point without finite values is infeasible whatever the others are.
        violation = np.column_stack([told.violation, np.where(usable, -1.0, UNUSABLE)])
        self._asked.set("F", np.where(usable, told.value, UNUSABLE), "G", violation)
        self._asked.set("H", np.zeros((len(told.x), 0)))
        for individual in self._asked:
            individual.evaluated.update("FGH")
        self._algorithm.tell(infills=self._asked)
        members = {x.tobytes() for x in self._algorithm.pop.get("X")}
        self._kept = told if self._kept is None else self._kept.followed_by(told)
        self._kept = self._kept.rows([k for k, x in enumerate(self._kept.x) if x.tobytes() in members])

    @property
    def result(self) -> Evaluation:
        """The points of the last population that keep all limits and that no other dominates."""
        assert self._kept is not None  # it is asked for when there is nothing more to ask
        best = np.flatnonzero(self._kept.feasible)
        return self._kept.rows(best[nondominated(self._kept.value[best])])


def nondominated(value: Array) -> NDArray[np.intp]:
    """Find the points that no other dominates.

    Parameters
    ----------
    value : ndarray, shape (points, goals)
        Objectives, all minimized [unit of each objective].

    Returns
    -------
    ndarray of int
        Their indices, in order; of points with equal values the first.

    Examples
    --------
    >>> nondominated(np.array([[1.0, 3.0], [2.0, 2.0], [2.0, 3.0], [2.0, 2.0]]))
    array([0, 1])
    """
    from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

    if not len(value):
        return np.zeros(0, dtype=np.intp)
    first = np.sort(np.unique(value, axis=0, return_index=True)[1])
    best = NonDominatedSorting().do(value[first], only_non_dominated_front=True)
    return np.sort(first[best])


def hypervolume(value: Array, reference: Array) -> float:
    """Measure what a front dominates: the volume between its points and a reference point that is worse than them.

    Parameters
    ----------
    value : ndarray, shape (points, goals)
        Objectives, all minimized [unit of each objective].
    reference : ndarray, shape (goals,)
        [unit of each objective].

    Returns
    -------
    float
        [product of the units].

    Examples
    --------
    >>> hypervolume(np.array([[1.0, 2.0], [2.0, 1.0]]), np.array([3.0, 3.0]))
    3.0
    """
    from pymoo.indicators.hv import HV

    return float(HV(ref_point=reference)(value)) if len(value) else 0.0
