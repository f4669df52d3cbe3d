"""Equilibrium by finite elements: Newton's method on the energy, with line search and load steps."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

MAX_STEPS = 40  # most Newton steps in a load step
CLOSE = 1e-7  # converged if the next Newton step lowers the energy by less than this part of the energy's change so far
MIN_WORK = 1e-12  # J, changes of energy below this count as zero
SHORTEST = 1 / 64  # smallest load step, as a part of the change of loads
HALVINGS = 12  # most halvings of a step in a line search
HOLDS = 8  # number of regularizations tried, each ten times the last
HOLD = 0.1  # 1/m^2, first regularization over the shear modulus


@dataclass(frozen=True)
class Problem:
    """An energy [J] to minimize under variable loads, and the present state."""

    energy: Any  # ngsolve.BilinearForm of `ngsolve.Variation` [J]
    state: Any  # ngsolve.GridFunction, the present state
    loads: tuple[Any, ...]  # the loads, each an ngsolve.Parameter
    shear: float  # shear modulus of the soft parts [Pa], scale of the regularization

    @property
    def free(self) -> Any:
        """Unknowns that a Newton step may change, as a bit array."""
        return self.state.space.FreeDofs()


@dataclass(frozen=True)
class Equilibrium:
    """Result of the search for an equilibrium: whether it converged, iterations, and a sentence."""

    converged: bool
    iterations: int  # Newton steps of all load steps
    text: str  # sentence without its period


def lead(problem: Problem, loads: Sequence[float], *, least: float = MIN_WORK) -> Equilibrium:
    """Bring a problem from its state to the equilibrium under other loads, in one step or in smaller steps.

    If Newton's method does not converge, the state is the last equilibrium on the way. `least`: a decrease of energy
    [J] that counts as converged even if the loads hardly change, for example from the state of a coarser space.
    """
    start, end = [load.Get() for load in problem.loads], [float(load) for load in loads]
    last_state = problem.state.vec.CreateVector()
    last_state.data = problem.state.vec
    reached, step, iterations = 0.0, 1.0, 0
    while reached < 1:
        fraction = min(1.0, reached + step)
        _set(problem, start, end, fraction)
        steps, fault = _newton(problem, least)
        iterations += steps
        if not fault:
            reached, step = fraction, 2 * step
            last_state.data = problem.state.vec
            continue
        problem.state.vec.data = last_state
        _set(problem, start, end, reached)
        step /= 2
        if step < SHORTEST:
            text = f"{fault}, {100 * reached:.0f} % of the way from the previous loads"
            return Equilibrium(False, iterations, text)
    return Equilibrium(True, iterations, f"converged in {iterations} Newton steps")


def _set(problem: Problem, start: Sequence[float], end: Sequence[float], part: float) -> None:
    """Set the loads between start and end; part: 0 at the start, 1 at the end."""
    for load, old, new in zip(problem.loads, start, end, strict=True):
        load.Set(old + part * (new - old))


def _newton(problem: Problem, least: float) -> tuple[int, str]:
    """Minimize the energy under the present loads; return the number of steps, and the failure or an empty text."""
    u, energy = problem.state.vec, problem.energy
    gradient, step, trial = (u.CreateVector() for _ in range(3))
    value_first = value_now = _value(problem, u)
    for k in range(1, MAX_STEPS + 1):
        energy.Apply(u, gradient)
        energy.AssembleLinearization(u)
        gain, free = _direction(problem, gradient, step)
        if not math.isfinite(gain):
            return k, "the tangent is singular"
        # A regularized step lowers the energy little everywhere; the free step decides if this is an equilibrium.
        if max(gain, abs(free)) <= CLOSE * abs(value_now - value_first) + least:
            trial.data = u - step
            if math.isfinite(_value(problem, trial)):
                u.data = trial
            return k, ""
        length = 1.0
        for _ in range(HALVINGS):
            trial.data = u - length * step
            value = _value(problem, trial)
            if math.isfinite(value) and value <= value_now - 1e-4 * length * gain:
                break
            length /= 2
        else:
            return k, "no step lowers the energy"
        u.data, value_now = trial, value
    return MAX_STEPS, f"Newton's method did not converge in {MAX_STEPS} steps"


def _value(problem: Problem, vector: Any) -> float:
    """Return the energy of a state [J]."""
    return float(problem.energy.Energy(vector))


def _direction(problem: Problem, gradient: Any, step: Any) -> tuple[float, float]:
    """Solve for the Newton step; return the first-order decrease of energy [J] by this step and by the free step.

    An indefinite tangent (before buckling) is regularized until the step descends; the free step has no regularization.
    """
    tangent, held_back, free = problem.energy.mat, 0.0, math.nan
    for k in range(HOLDS + 1):
        if k:
            hold = HOLD * problem.shear * 10 ** (k - 1)
            squares = _squares(problem)  # keeps the matrix alive as long as its vector
            tangent.AsVector().data += (hold - held_back) * squares.AsVector()
            held_back = hold
        step.data = tangent.Inverse(problem.free, inverse="sparsecholesky") * gradient
        gain = float(step.InnerProduct(gradient))
        free = free if k else gain
        if gain > 0 or (gain == 0 and k == 0):
            return gain, free
    return math.nan, free


def _squares(problem: Problem) -> Any:
    """Return the mass matrix, with the sparsity pattern of the tangent matrix."""
    import ngsolve as ngs

    space = problem.state.space
    squares = ngs.BilinearForm(space, symmetric=True)
    trials, tests = (part if isinstance(part, (tuple, list)) else (part,) for part in space.TnT())
    for trial, test in zip(trials, tests, strict=True):
        squares += ngs.InnerProduct(trial, test) * ngs.dx
    return squares.Assemble().mat
