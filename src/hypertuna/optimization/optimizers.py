"""Optimizers with one interface (ask, tell, stop, result): PSO, DE and NSGA-II of pymoo, and CMA-ES of pycma."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array, rounded
from hypertuna.errors import InputError
from hypertuna.optimization.objective import UNUSABLE, Evaluation

# Factors with which a particle swarm converges: Clerc and Kennedy (2002), constriction with phi = 4.1.
INERTIA, LEARNING = 0.7298, 1.49618


class Optimizer(ABC):
    """A search for the point of least value in a box.

    `ask` returns a batch of points; `tell` takes their evaluations in the same order, by a simulation, a tank or a
    cluster. Asking again before telling returns the same batch. Feasible points are better than others (Deb, 2000).
    """

    needs_derivatives = False

    def __init__(self, lower: Array, upper: Array, max_evaluations: int) -> None:
        self.lower, self.upper = lower, upper  # (dim,)
        self.max_evaluations = max_evaluations
        self.history: list[float] = []  # least feasible value after each batch, infinite before there is one
        self.batches: list[int] = []  # number of points in each evaluated batch
        self._batch: Array | None = None
        self._best: Evaluation | None = None

    @property
    def evaluations(self) -> int:
        """Number of evaluated points."""
        return sum(self.batches)

    def ask(self) -> Array:
        """Return the points to evaluate next, shape (points, dim)."""
        if self._batch is None:
            self._batch = np.clip(rounded(self._propose()), self.lower, self.upper)
        return self._batch.copy()

    def tell(self, evaluation: Evaluation) -> None:
        """Take the evaluation of all points of the last batch."""
        if self._batch is None or not np.array_equal(evaluation.x, self._batch):
            fix = "call ask first, then tell with every point of the batch in the same order"
            raise InputError("must be the last points that ask returned", key="tell", fix=fix)
        self._batch, evaluation = None, evaluation.rounded()
        self.batches.append(len(evaluation.x))
        self._best = self._better(evaluation)
        self.history.append(float(self._best.value[0, 0]) if self._best.feasible[0] else np.inf)
        self._learn(evaluation)

    @property
    @abstractmethod
    def stop(self) -> str | None:
        """Reason why the search has ended, as a sentence; None while it goes on."""

    @property
    def result(self) -> Evaluation | None:
        """Best point, as an evaluation of one row; the one with the least violation if none is feasible."""
        return self._best

    @abstractmethod
    def _propose(self) -> Array:
        """Return the points to evaluate next, shape (points, dim)."""

    @abstractmethod
    def _learn(self, evaluation: Evaluation) -> None:
        """Learn from the evaluation of the proposed points."""

    def _better(self, evaluation: Evaluation) -> Evaluation:
        """Return the best of the evaluated points and the best so far; the best so far wins if equal."""
        rows = evaluation if self._best is None else self._best.followed_by(evaluation)
        return rows.rows([int(np.lexsort((rows.value[:, 0], rows.total_violation, ~rows.feasible))[0])])


@final
class Pymoo(Optimizer):
    """Adapter for an evolutionary algorithm of pymoo that has not been set up yet.

    With several objectives the result is the front of the last population, and the algorithm itself keeps its points
    inside the box; with one objective, the algorithm's repair operator does.
    """

    def __init__(
        self, algorithm: Any, lower: Array, upper: Array, *, iterations: int, reason: str, objectives: int = 1
    ) -> None:
        import scipy.spatial.distance  # noqa: F401 - pymoo imports it in its first iteration, which is timed
        from pymoo.core.problem import Problem

        several = objectives > 1

        class Box(Problem):  # type: ignore[misc]  # pymoo is not typed
            def has_bounds(self) -> bool:
                return several

        super().__init__(lower, upper, iterations * algorithm.pop_size)
        self._algorithm, self._iterations, self._reason = algorithm, iterations, reason
        box = Box(n_var=len(lower), n_obj=objectives, n_ieq_constr=1, xl=lower, xu=upper)
        algorithm.setup(box, termination=("n_iter", iterations + 1))
        self._infills: Any = None
        self._several = several
        self._population: Evaluation | None = None  # the last population, if there are several objectives

    @property
    def stop(self) -> str | None:
        """Reason why the search has ended, as a sentence; None while it goes on."""
        return self._reason if len(self.batches) >= self._iterations else None

    @property
    def result(self) -> Evaluation | None:
        """Best point; with several objectives, the nondominated feasible points of the last population."""
        return self._best if self._population is None else pareto_front(self._population)

    def _propose(self) -> Array:
        self._infills = self._algorithm.ask()
        return np.asarray(self._infills.get("X"), dtype=np.float64)

    def _learn(self, evaluation: Evaluation) -> None:
        # pymoo gets all limits as one constraint, the total violation.
        values = np.where(np.isfinite(evaluation.value), evaluation.value, UNUSABLE)
        violation = evaluation.total_violation
        if self._several:
            usable = np.asarray(np.isfinite(evaluation.value).all(axis=1))
            values, violation = np.where(usable[:, np.newaxis], values, UNUSABLE), violation + UNUSABLE * ~usable
        self._infills.set("X", evaluation.x, "F", values, "CV", violation[:, np.newaxis])
        self._algorithm.tell(infills=self._infills)
        if self._several:
            members = {x.tobytes() for x in self._algorithm.pop.get("X")}
            candidates = evaluation if self._population is None else self._population.followed_by(evaluation)
            self._population = candidates.rows([k for k, x in enumerate(candidates.x) if x.tobytes() in members])


def pso(lower: Array, upper: Array, *, particles: int, iterations: int, seed: int) -> Optimizer:
    """Return a particle swarm (Kennedy and Eberhart, 1995) with constant inertia and learning factors.

    v <- w v + c1 r1 (p_best - p) + c2 r2 (g_best - p),  p <- p + v, with new random numbers r1 and r2 in [0, 1] for
    every coordinate. A particle that leaves the box is put on its edge; a velocity is at most a fifth of the box.
    """
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.operators.repair.to_bound import ToBoundOutOfBoundsRepair

    # By default pymoo moves such a particle to a random place inside, which keeps a swarm away from the edges.
    repair = ToBoundOutOfBoundsRepair()
    factors = {"w": INERTIA, "c1": LEARNING, "c2": LEARNING, "adaptive": False, "pertube_best": False}
    algorithm = PSO(pop_size=particles, repair=repair, seed=seed, **factors)
    reason = f"All {iterations} iterations of {particles} particles are done."
    return Pymoo(algorithm, lower, upper, iterations=iterations, reason=reason)


def de(lower: Array, upper: Array, *, particles: int, iterations: int, seed: int) -> Optimizer:
    """Return an optimizer by differential evolution (Storn and Price, 1997), DE/best/1/bin."""
    from pymoo.algorithms.soo.nonconvex.de import DE
    from pymoo.operators.repair.to_bound import ToBoundOutOfBoundsRepair
    from pymoo.operators.sampling.lhs import LHS

    repair = ToBoundOutOfBoundsRepair()
    sizes = {"pop_size": particles, "CR": 0.9, "F": 0.7, "seed": seed}
    algorithm = DE(sampling=LHS(), variant="DE/best/1/bin", repair=repair, **sizes)
    reason = f"All {iterations} generations of {particles} gaits are done."
    return Pymoo(algorithm, lower, upper, iterations=iterations, reason=reason)


def nsga2(lower: Array, upper: Array, objectives: int, *, population: int, generations: int, seed: int) -> Optimizer:
    """Return an optimizer by the multi-objective genetic algorithm NSGA-II (Deb et al., 2002)."""
    from pymoo.algorithms.moo.nsga2 import NSGA2

    algorithm = NSGA2(pop_size=population, seed=seed)
    reason = f"The {generations} generations are done."
    return Pymoo(algorithm, lower, upper, iterations=generations, reason=reason, objectives=objectives)


@final
class CMAES(Optimizer):
    """CMA-ES by pycma (Hansen, 2016), in coordinates scaled to the unit box.

    pycma has ask and tell itself, and takes a random generator; pymoo's wrapper does not pass on a generator.
    """

    REASONS: ClassVar = {
        "tolfun": "the values of its last generations differ by less than 1e-9",
        "tolfunhist": "its best values have not changed for many generations",
        "tolflatfitness": "all points of its last generations have the same value",
        "tolx": "its steps have become smaller than 1e-9 of the box",
        "tolstagnation": "its values have not become better for many generations",
    }

    def __init__(self, lower: Array, upper: Array, *, particles: int | None, iterations: int, seed: int) -> None:
        import cma

        random = np.random.default_rng(seed)
        options = {
            "bounds": [0, 1],
            "randn": lambda *shape: random.standard_normal(shape),  # not NumPy's global generator
            "seed": np.nan,
            "maxiter": iterations,
            "tolfun": 1e-9,
            "tolx": 1e-9,
            "verbose": -9,
        }
        options |= {} if particles is None else {"popsize": particles}  # pycma's default is 4 + 3 ln dim
        self._strategy = cma.CMAEvolutionStrategy(np.full(len(lower), 0.5), 0.3, options)
        self.particles = int(self._strategy.popsize)
        super().__init__(lower, upper, self.particles * iterations)
        self._iterations = iterations
        self._points: list[Array] = []
        self._worst = 0.0

    @property
    def stop(self) -> str | None:
        """Reason why the search has ended, as a sentence; None while it goes on."""
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

    def _learn(self, evaluation: Evaluation) -> None:
        # CMA-ES uses ranks only: infeasible points are ranked after the worst feasible value.
        value, feasible = evaluation.value[:, 0], evaluation.feasible
        self._worst = max([self._worst, *value[feasible]])
        ranked = np.where(feasible, value, self._worst + evaluation.total_violation)
        self._strategy.tell(self._points, ranked.tolist())


def nondominated(value: Array) -> NDArray[np.intp]:
    """Return the sorted indices of nondominated points; among points with equal values, only the first counts.

    >>> nondominated(np.array([[1.0, 3.0], [2.0, 2.0], [2.0, 3.0], [2.0, 2.0]]))
    array([0, 1])
    """
    from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

    if not len(value):
        return np.zeros(0, dtype=np.intp)
    first = np.sort(np.unique(value, axis=0, return_index=True)[1])
    best = NonDominatedSorting().do(value[first], only_non_dominated_front=True)
    return np.sort(first[best])


def pareto_front(points: Evaluation) -> Evaluation:
    """Return the feasible, nondominated points of an evaluation."""
    feasible = np.flatnonzero(points.feasible)
    return points.rows(feasible[nondominated(points.value[feasible])])


def hypervolume(value: Array, reference: Array) -> float:
    """Return the volume between a front, shape (points, objectives), and a reference point worse than the front.

    >>> hypervolume(np.array([[1.0, 2.0], [2.0, 1.0]]), np.array([3.0, 3.0]))
    3.0
    """
    from pymoo.indicators.hv import HV

    return float(HV(ref_point=reference)(value)) if len(value) else 0.0
