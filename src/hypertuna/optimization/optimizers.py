"""Optimizers, all alike: ask for points, tell what was found there, until one says why it stops."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from hypertuna.errors import InputError
from hypertuna.optimization.objective import UNUSABLE, Evaluation

__all__ = ["CovarianceAdaptation", "Optimizer", "de", "pso"]

Array = NDArray[np.float64]

# Of a particle swarm that converges: Clerc and Kennedy (2002), constriction of phi = 4.1.
INERTIA, LEARNING = 0.7298, 1.49618


class Optimizer(ABC):
    """Looks for the point of least value in a box.

    It asks for a batch of points and is told all of them, in that order: by a simulation, a tank or a cluster. Asking
    again before telling gives the same batch. Points that keep all limits come before those that do not (Deb, 2000).

    Parameters
    ----------
    lower, upper : ndarray, shape (dim,)
        The box [any].
    """

    needs_slopes = False

    def __init__(self, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, upper
        self.history: list[float] = []  # least feasible value after each batch, infinite before there is one
        self.batches: list[int] = []  # points of each batch told
        self._batch: Array | None = None
        self._best: Evaluation | None = None

    @property
    def evaluations(self) -> int:
        """Number of points told."""
        return sum(self.batches)

    def ask(self) -> Array:
        """Return the points to evaluate next, shape (points, dim)."""
        if self._batch is None:
            self._batch = np.clip(self._propose(), self.lower, self.upper)
        return self._batch.copy()

    def tell(self, told: Evaluation) -> None:
        """Take what was found at all the points last asked for.

        Parameters
        ----------
        told : Evaluation

        Raises
        ------
        InputError
            If they are not the points asked for.
        """
        if self._batch is None or not np.array_equal(told.x, self._batch):
            fix = "ask first, and tell every point of the batch in its order"
            raise InputError("must be the points last asked for", key="tell", fix=fix)
        self._batch = None
        self.batches.append(len(told.x))
        self._best = self._better(told)
        self.history.append(float(self._best.value[0, 0]) if self._best.feasible[0] else np.inf)
        self._learn(told)

    @property
    @abstractmethod
    def stop(self) -> str | None:
        """Why there is nothing more to ask, in a sentence; None while there is."""

    @property
    def result(self) -> Evaluation | None:
        """The best point told, as an evaluation of one row; the one nearest to the limits if none keeps them."""
        return self._best

    @abstractmethod
    def _propose(self) -> Array:
        """Return the next points."""

    @abstractmethod
    def _learn(self, told: Evaluation) -> None:
        """Take what was found at them."""

    def _better(self, told: Evaluation) -> Evaluation:
        """Return the best of the points told and the best so far, which stays if it is as good."""
        rows = told if self._best is None else self._best.followed_by(told)
        return rows.rows([int(np.lexsort((rows.value[:, 0], rows.excess, ~rows.feasible))[0])])


@final
class _Population(Optimizer):
    """An evolutionary algorithm of pymoo.

    Parameters
    ----------
    algorithm : pymoo Algorithm
        Not set up yet.
    lower, upper : ndarray, shape (dim,)
        The box [any].
    iterations : int
        Batches to ask for.
    done : str
        Sentence that says so.
    """

    def __init__(self, algorithm: Any, lower: Array, upper: Array, *, iterations: int, done: str) -> None:
        import scipy.spatial.distance  # noqa: F401 - pymoo needs it in its first iteration: what is timed has no imports

        super().__init__(lower, upper)
        self._algorithm, self._iterations, self._done = algorithm, iterations, done
        algorithm.setup(_clipped_problem(lower, upper), termination=("n_iter", iterations + 1))
        self._infills: Any = None

    @property
    def stop(self) -> str | None:
        """Why there is nothing more to ask."""
        return self._done if len(self.history) >= self._iterations else None

    def _propose(self) -> Array:
        self._infills = self._algorithm.ask()
        return np.asarray(self._infills.get("X"), dtype=np.float64)

    def _learn(self, told: Evaluation) -> None:
        # All limits are one constraint: by how much they are passed in all.
        values = np.where(np.isfinite(told.value), told.value, UNUSABLE)
        self._infills.set("F", values, "CV", told.excess[:, np.newaxis])
        self._algorithm.tell(infills=self._infills)


def pso(lower: Array, upper: Array, *, particles: int = 15, iterations: int = 60, seed: int = 1) -> Optimizer:
    """Search by a particle swarm (Kennedy and Eberhart, 1995) with constant inertia and learning factors.

    v <- w v + c1 r1 (p_best - p) + c2 r2 (g_best - p),  p <- p + v, with fresh random numbers r1 and r2 in [0, 1] for
    every coordinate; a particle that leaves the box stays on its edge, and no velocity passes a fifth of its width.

    Parameters
    ----------
    lower, upper : ndarray, shape (dim,)
        The box [any].
    particles, iterations, seed : int

    Returns
    -------
    Optimizer
    """
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.operators.repair.to_bound import ToBoundOutOfBoundsRepair

    algorithm = PSO(
        pop_size=particles,
        w=INERTIA,
        c1=LEARNING,
        c2=LEARNING,
        adaptive=False,
        pertube_best=False,
        repair=ToBoundOutOfBoundsRepair(),
        seed=seed,
    )
    done = f"All {iterations} iterations of {particles} particles are done."
    return _Population(algorithm, lower, upper, iterations=iterations, done=done)


def de(lower: Array, upper: Array, *, particles: int = 15, iterations: int = 60, seed: int = 1) -> Optimizer:
    """Search by differential evolution (Storn and Price, 1997), DE/best/1/bin.

    Parameters
    ----------
    lower, upper : ndarray, shape (dim,)
        The box [any].
    particles, iterations, seed : int

    Returns
    -------
    Optimizer
    """
    from pymoo.algorithms.soo.nonconvex.de import DE
    from pymoo.operators.repair.to_bound import ToBoundOutOfBoundsRepair
    from pymoo.operators.sampling.lhs import LHS

    algorithm = DE(
        pop_size=particles,
        sampling=LHS(),
        variant="DE/best/1/bin",
        CR=0.9,
        F=0.7,
        repair=ToBoundOutOfBoundsRepair(),
        seed=seed,
    )
    done = f"All {iterations} generations of {particles} gaits are done."
    return _Population(algorithm, lower, upper, iterations=iterations, done=done)


def _clipped_problem(lower: Array, upper: Array) -> Any:
    """Return pymoo's problem of a box whose edges it must not mind: points beyond are put on them by a repair.

    Its own way, drawing such points anew inside, keeps a swarm off the edges, where the fastest gaits are.
    """
    from pymoo.core.problem import Problem as Box

    class Clipped(Box):  # type: ignore[misc]
        def has_bounds(self) -> bool:
            return False

    return Clipped(n_var=len(lower), n_obj=1, n_ieq_constr=1, xl=lower, xu=upper)


@final
class CovarianceAdaptation(Optimizer):
    """CMA-ES by pycma (Hansen, 2016), in coordinates scaled to the unit box.

    Parameters
    ----------
    lower, upper : ndarray, shape (dim,)
        The box [any].
    particles : int or None
        Points per generation; pycma's 4 + 3 ln dim if None.
    iterations, seed : int
    """

    REASONS: ClassVar = {
        "tolfun": "the values of its last generations differ by less than 1e-9",
        "tolfunhist": "its best values have not changed for many generations",
        "tolflatfitness": "all points of its last generations have the same value",
        "tolx": "its steps have become smaller than 1e-9 of the box",
        "tolstagnation": "its values have not become better for many generations",
    }

    def __init__(self, lower: Array, upper: Array, *, particles: int | None, iterations: int, seed: int) -> None:
        super().__init__(lower, upper)
        import cma

        random = np.random.default_rng(seed)
        options = {
            "bounds": [0, 1],
            "randn": lambda *shape: random.standard_normal(shape),  # not NumPy's global numbers
            "seed": np.nan,
            "maxiter": iterations,
            "tolfun": 1e-9,
            "tolx": 1e-9,
            "verbose": -9,
        }
        options |= {} if particles is None else {"popsize": particles}
        self._strategy = cma.CMAEvolutionStrategy(np.full(len(lower), 0.5), 0.3, options)
        self.particles = int(self._strategy.popsize)
        self._iterations = iterations
        self._points: list[Array] = []
        self._worst = 0.0

    @property
    def stop(self) -> str | None:
        """Why there is nothing more to ask."""
        reasons = self._strategy.stop()
        if not reasons:
            return None
        if "maxiter" in reasons:
            return f"All {self._iterations} generations of {self.particles} gaits are done."
        name = next(iter(reasons))
        return f"CMA-ES has converged: {self.REASONS.get(name, f'pycma says {name}')}."

    def _propose(self) -> Array:
        self._points = self._strategy.ask()
        return self.lower + np.array(self._points) * (self.upper - self.lower)

    def _learn(self, told: Evaluation) -> None:
        # Only ranks count: what passes a limit comes after the worst value that keeps them all.
        value, feasible = told.value[:, 0], told.feasible
        self._worst = max([self._worst, *value[feasible]])
        ranked = np.where(feasible, value, self._worst + told.excess)
        self._strategy.tell(self._points, ranked.tolist())
