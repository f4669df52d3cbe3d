"""Sequential quadratic programming (SciPy's SLSQP; Kraft, 1988) with ask and tell, from one or several starts."""

import threading
from collections.abc import Callable, Generator
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Self, final

import numpy as np

from hypertuna.arrays import Array, rounded, rounded_number
from hypertuna.optimization.objective import Evaluation
from hypertuna.optimization.optimizers import Optimizer

PRECISION = 1e-8  # a search ends when the value changes by less
MARGIN = 1e-7  # constraints are tightened by this, since SLSQP meets them only nearly
PENALTY = 1e3  # value and violation of an unusable point
SAME = 1e-3  # values within this relative difference count as the same


@dataclass(frozen=True)
class SqpPoint:
    """Value, constraints and derivatives at a point of the unit box."""

    u: Array  # (dim,) coordinates from 0 to 1
    value: float  # value to minimize
    gradient: Array  # (dim,) gradient of the value
    constraints: Array  # (constraints,), not violated if >= 0
    jacobian: Array  # (constraints, dim)
    merit: float  # the point with the least merit is the best
    feasible: bool  # whether the point can be the best

    def rounded(self) -> Self:
        """Return the point with rounded numbers, so that rounding errors of the kernels do not affect a search."""
        value, merit = rounded_number(self.value), rounded_number(self.merit)
        gradient, constraints, jacobian = map(rounded, (self.gradient, self.constraints, self.jacobian))
        return type(self)(self.u, value, gradient, constraints, jacobian, merit, self.feasible)


@final
class SQP:
    """A search from one start: the caller evaluates `u` and tells the point, until `u` is None.

    The last `slacked` constraints are relaxed by one slack s >= 0, which is added to the value.
    """

    def __init__(self, start: Array, iterations: int, slacked: int = 0) -> None:
        self._points: list[SqpPoint] = []
        self._search = _slsqp(start, iterations, slacked)
        self.u: Array | None = next(self._search)

    def tell(self, point: SqpPoint) -> None:
        """Take the evaluation of `u`."""
        point = point.rounded()
        self._points.append(point)
        try:
            self.u = self._search.send(point)
        except StopIteration:
            self.u = None

    @property
    def best(self) -> SqpPoint | None:
        """The feasible point with the least merit; None if no point is feasible."""
        return min((p for p in self._points if p.feasible), key=lambda point: point.merit, default=None)


class _AbandonedError(Exception):
    """Raised in the thread of a search whose generator was closed."""


def _slsqp(start: Array, iterations: int, slacked: int) -> Generator[Array, SqpPoint, None]:
    """Yield the points that SLSQP wants evaluated; evaluated points are sent back.

    SciPy calls the objective, so SLSQP runs in a thread of its own. The thread and this generator take turns, and never
    run at the same time.
    """
    questions: SimpleQueue[Array | BaseException | None] = SimpleQueue()
    answers: SimpleQueue[SqpPoint | None] = SimpleQueue()
    answered: dict[bytes, SqpPoint] = {}

    def point_at(z: Array) -> SqpPoint:
        u = rounded(np.minimum(np.maximum(z[: len(start)], 0.0), 1.0))
        key = u.tobytes()
        if key not in answered:
            questions.put(u)
            answer = answers.get()
            if answer is None:
                raise _AbandonedError
            answered[key] = answer
        return answered[key]

    def run() -> None:
        try:
            _minimize(point_at, start, iterations, slacked)
            questions.put(None)
        except BaseException as error:
            questions.put(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        while (question := questions.get()) is not None:
            if isinstance(question, BaseException):
                raise question
            answers.put((yield question))
    finally:
        answers.put(None)
        thread.join()


def _minimize(point_at: Callable[[Array], SqpPoint], start: Array, iterations: int, slacked: int) -> None:
    """Run SLSQP on the points of `point_at`; its variables z are the coordinates of the box, then the slack if any."""
    from scipy.optimize import minimize

    dim, first = len(start), point_at(start)
    slack_jacobian = np.zeros((len(first.constraints), min(slacked, 1)))
    slack_jacobian[len(slack_jacobian) - slacked :] = 1.0
    slack = np.max(-first.constraints[:, np.newaxis] * slack_jacobian, axis=0, initial=0.0)
    minimize(
        lambda z: point_at(z).value + z[dim:].sum(),
        np.append(start, slack),
        jac=lambda z: np.append(point_at(z).gradient, np.ones(len(z) - dim)),
        bounds=[(0.0, 1.0)] * dim + [(0.0, None)] * len(slack),
        constraints={
            "type": "ineq",
            "fun": lambda z: point_at(z).constraints + slack_jacobian @ z[dim:],
            "jac": lambda z: np.hstack([point_at(z).jacobian, slack_jacobian]),
        },
        method="SLSQP",
        options={"ftol": PRECISION, "maxiter": iterations},
    )


@final
class MultiStart(Optimizer):
    """SQP from several starts in lockstep: a batch has the next point of every search that has not ended.

    Since |U - U_e| has a kink, the searches minimize a slack with s >= U - U_e and s >= U_e - U instead.
    """

    needs_derivatives = True

    def __init__(
        self,
        lower: Array,
        upper: Array,
        expected: float | None,  # expected speed U_e [m/s]
        scale: float,  # values are divided by it [unit of the value]
        *,
        starts: int,
        iterations: int,  # most points in a search
        seed: int,
    ) -> None:
        super().__init__(lower, upper, starts * iterations)
        self._expected, self._scale, self._iterations = expected, scale, iterations
        slacked = 0 if expected is None else 2
        self._searches = [SQP(u, iterations, slacked) for u in latin_hypercube(starts, len(lower), seed)]
        self._running = list(self._searches)
        self._cut = 0  # number of searches cut off at the largest number of points

    @property
    def stop(self) -> str | None:
        """Reason why the search has ended, as a sentence; None while it goes on."""
        if self._running:
            return None
        merits = [np.inf if search.best is None else search.best.merit for search in self._searches]
        least = min(merits)
        same_count = sum(end <= least + SAME * abs(least) for end in merits) if np.isfinite(least) else 0
        verb = "was" if self._cut == 1 else "were"
        cut = f"; {self._cut} {verb} cut off after {self._iterations} points" if self._cut else ""
        return f"All {len(merits)} gradient searches have ended, {same_count} of them at the best value{cut}."

    def _propose(self) -> Array:
        points = [search.u for search in self._running if search.u is not None]
        return self.lower + np.stack(points) * (self.upper - self.lower)

    def _learn(self, evaluation: Evaluation) -> None:
        for k, search in enumerate(self._running):
            if search.u is not None:
                search.tell(self._point(evaluation, k, search.u))
        unfinished = [search for search in self._running if search.u is not None]
        self._running = unfinished if len(self.batches) < self._iterations else []
        self._cut = len(unfinished) - len(self._running)

    def _point(self, evaluation: Evaluation, k: int, u: Array) -> SqpPoint:
        """Return point k of an evaluation, scaled; an unusable gait gets a large penalty and zero gradient."""
        assert evaluation.value_jacobian is not None
        assert evaluation.violation_jacobian is not None
        assert evaluation.speed_gradient is not None
        width, scale = self.upper - self.lower, self._scale
        constraints, jacobian = -evaluation.violation[k] - MARGIN, -evaluation.violation_jacobian[k] * width
        gradient = evaluation.value_jacobian[k, 0] * width / scale
        value = merit = float(evaluation.value[k, 0]) / scale
        if self._expected is not None:
            error = float(evaluation.quantities["speed"][k] - self._expected) / scale
            speed_gradient = evaluation.speed_gradient[k] * width / scale
            # The value without |U - U_e|, and the two constraints of the slack.
            value, gradient = value - abs(error), gradient - np.sign(error) * speed_gradient
            constraints = np.append(constraints, [-error, error])
            jacobian = np.vstack([jacobian, -speed_gradient, speed_gradient])
        if not np.isfinite(merit):
            violated = np.full_like(constraints, -PENALTY)
            return SqpPoint(u, PENALTY, np.zeros_like(gradient), violated, np.zeros_like(jacobian), PENALTY, False)
        return SqpPoint(u, value, gradient, constraints, jacobian, merit, bool(evaluation.feasible[k]))


def latin_hypercube(count: int, dim: int, seed: int) -> Array:
    """Return random points of the unit box, shape (count, dim), one in each of `count` slices of every coordinate."""
    random = np.random.default_rng(seed)
    slices = np.stack([random.permutation(count) for _ in range(dim)], axis=1)
    return np.asarray((slices + random.random((count, dim))) / count)
