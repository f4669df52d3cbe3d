"""Equilibrium by finite elements: Newton's method on the energy, with line search and load steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

__all__ = ["Equilibrium", "Problem", "lead"]

MOST = 40  # Newton steps of a load step
CLOSE = 1e-7  # converged where the next step, the last, lowers the energy by less than this part of the loads' work
LEAST = 1e-12  # J, of work that counts
SHORTEST = 1 / 64  # of the load step that was asked for
HALVINGS = 12  # of a line search
HOLDS = 8  # stiffnesses that are tried, each ten times the one before
HOLD = 0.1  # 1/m^2, the first of them over the shear modulus


@dataclass(frozen=True)
class Problem:
    """An energy to minimize, under loads that can be led from one value to another."""

    energy: Any  # made of `ngsolve.Variation` [J]
    state: Any  # changes as the loads do
    loads: tuple[Any, ...]
    shear: float  # shear modulus of what is soft [Pa], for scale
    # called with a vector of the state before its energy is asked for: sets the unknowns that were condensed
    settle: Callable[[Any], None] | None = None

    @property
    def free(self) -> Any:
        """Unknowns that Newton's step solves for."""
        return self.state.space.FreeDofs(self.settle is not None)


@dataclass(frozen=True)
class Equilibrium:
    """How the search for an equilibrium ended."""

    converged: bool
    iterations: int  # newton steps, all load steps together
    text: str  # A sentence without its period


def lead(problem: Problem, loads: Sequence[float]) -> Equilibrium:
    """Lead a problem from its present loads and state to other loads.

    The loads change together, in one step if Newton's method converges, else in smaller ones.
    """
    start, end = [load.Get() for load in problem.loads], [float(load) for load in loads]
    kept = problem.state.vec.CreateVector()
    kept.data = problem.state.vec
    done, step, iterations = 0.0, 1.0, 0
    while done < 1:
        part = min(1.0, done + step)
        _set(problem, start, end, part)
        steps, fault = _newton(problem)
        iterations += steps
        if not fault:
            done, step = part, 2 * step
            kept.data = problem.state.vec
            continue
        problem.state.vec.data = kept
        _set(problem, start, end, done)
        step /= 2
        if step < SHORTEST:
            text = f"{fault}, {100 * done:.0f} % of the way from the loads before"
            return Equilibrium(False, iterations, text)
    return Equilibrium(True, iterations, f"converged in {iterations} Newton steps")


def _set(problem: Problem, start: Sequence[float], end: Sequence[float], part: float) -> None:
    """Set the loads between two ends."""
    for load, first, last in zip(problem.loads, start, end, strict=True):
        load.Set(first + part * (last - first))


def _newton(problem: Problem) -> tuple[int, str]:
    """Minimize the energy under the present loads; return the number of steps and what went wrong, if anything did."""
    u, energy = problem.state.vec, problem.energy
    slope, step, trial = (u.CreateVector() for _ in range(3))
    first = now = _value(problem, u)
    for k in range(1, MOST + 1):
        energy.Apply(u, slope)
        energy.AssembleLinearization(u)
        gain, free = _direction(problem, slope, step)
        if not math.isfinite(gain):
            return k, "the tangent is singular"
        # A step that is held back gains little anywhere: the free one tells whether this is an equilibrium.
        if max(gain, abs(free)) <= CLOSE * abs(now - first) + LEAST:
            trial.data = u - step
            if math.isfinite(_value(problem, trial)):
                u.data = trial
            return k, ""
        length = 1.0
        for _ in range(HALVINGS):
            trial.data = u - length * step
            value = _value(problem, trial)
            if math.isfinite(value) and value <= now - 1e-4 * length * gain:
                break
            length /= 2
        else:
            return k, "no step lowers the energy"
        u.data, now = trial, value
    return MOST, f"Newton's method did not converge in {MOST} steps"


def _value(problem: Problem, vector: Any) -> float:
    """Energy of a state [J], after what was condensed has settled in it."""
    if problem.settle is not None:
        problem.settle(vector)
    return float(problem.energy.Energy(vector))


def _direction(problem: Problem, slope: Any, step: Any) -> tuple[float, float]:
    """Solve for Newton's step; return by how much it, and the step that is free, lower the energy to first order [J].

    Where the tangent is indefinite (a body that is about to buckle), a term that holds the step back is added until the
    step goes downhill; the free step has no such term.
    """
    tangent, held, free = problem.energy.mat, 0.0, math.nan
    for k in range(HOLDS + 1):
        if k:
            hold = HOLD * problem.shear * 10 ** (k - 1)
            squares = _squares(problem)  # its vector lives no longer than the matrix
            tangent.AsVector().data += (hold - held) * squares.AsVector()
            held = hold
        step.data = tangent.Inverse(problem.free, inverse="sparsecholesky") * slope
        gain = float(step.InnerProduct(slope))
        free = free if k else gain
        if gain > 0 or (gain == 0 and k == 0):
            return gain, free
    return math.nan, free


def _squares(problem: Problem) -> Any:
    """Matrix of the squared state, integrated, of the tangent's pattern."""
    import ngsolve as ngs

    space = problem.state.space
    squares = ngs.BilinearForm(space, symmetric=True, condense=problem.settle is not None)
    trials, tests = (part if isinstance(part, (tuple, list)) else (part,) for part in space.TnT())
    for trial, test in zip(trials, tests, strict=True):  # all: what is condensed must not be singular
        squares += ngs.InnerProduct(trial, test) * ngs.dx
    return squares.Assemble().mat
