"""Which run comes next: the greedy choice by the exact expected narrowing, with discrepancies in the design."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.design.discrepancy import DESIGNED, correlation, same_day
from hypertuna.design.posterior import Posterior
from hypertuna.design.prediction import Row, predict
from hypertuna.design.runs import QUANTITIES, SLOWEST, TankRun, noise_of

WISHES = {"speed": "speed", "turn": "turn_rate", "cost": "cost_of_transport", "coefficients": ""}  # of the targets
CHECK = 4  # every fourth run is made where the design has none
AS_FAR = 0.98  # of the largest variance of the discrepancy: gaits that are as far from all others
NEVER = 0.8  # of the prior's standard deviation: what remains of it where no run tells a coefficient


@dataclass(frozen=True)
class Design:
    """Joint normal distribution of candidates, targets and coefficients, narrowed run by run.

    What is measured does not change how much a run narrows, so that several runs are chosen before the first is made.
    """

    want: str
    rows: tuple[Row, ...]  # of the candidates; then follow targets and coefficients
    places: Mapping[TankRun, NDArray[np.intp]]  # rows of each candidate
    value: Array  # (rows,) expected [SI]
    noise: Array  # (rows,) variance of the logarithm of one measurement
    targets: slice
    free: slice
    prior: Array  # (n,) variance of the coefficients before all runs
    covariance: Array  # of logarithms and scaled coefficients
    made: tuple[TankRun, ...]

    def width(self) -> float:
        """Root mean square of the standard deviations of the log targets."""
        return float(np.sqrt(np.diag(self.covariance)[self.targets].mean()))

    def sd(self) -> Array:
        """Return the standard deviations (n,) of the scaled coefficients."""
        return np.sqrt(np.maximum(np.diag(self.covariance)[self.free], 0.0))

    def score(self, run: TankRun) -> float:
        """Return the mean variance that a run would leave: of the log targets, or of coefficients over their priors."""
        at, aim = self.places[run], self.free if self.want == "coefficients" else self.targets
        by = self.covariance[aim, at]
        gain = np.linalg.solve(self.covariance[np.ix_(at, at)] + np.diag(self.noise[at]), by.T)
        left = np.diag(self.covariance)[aim] - np.einsum("ij,ji->i", by, gain)
        return float(np.mean(left / self.prior if self.want == "coefficients" else left))

    def after(self, runs: Sequence[TankRun]) -> "Design":
        """Return the design with runs made."""
        at = np.concatenate([self.places[run] for run in runs])
        covariance = narrowed(self.covariance, at, np.diag(self.noise[at]))
        return replace(self, covariance=covariance, made=(*self.made, *runs))

    def best(self) -> TankRun:
        """Return the run that narrows most; one that was made counts as its repeat."""
        return min(self.places, key=self.score)

    def farthest(self) -> TankRun:
        """Return the gait where the runs tell least of what the model misses: the check of a design."""
        swims = [run for run in self.places if run.swims and (run.turns or self.want != "turn")]
        gaits = [run for run in swims if run not in self.made]
        if not gaits:
            return self.best()
        here, known = ([Row(run, "speed") for run in runs if run.swims] for runs in (gaits, self.made))
        near, among = correlation(here, known), correlation(known, known)
        blind = 1 - np.einsum("ij,ji->i", near, np.linalg.solve(among + 1e-6 * np.eye(len(known)), near.T))
        far = [run for run, variance in zip(gaits, blind, strict=True) if variance >= AS_FAR * blind.max()]
        return min(far, key=self.score)

    def never(self) -> Array:
        """Return the standard deviations (n,) that all candidates together would leave of the coefficients."""
        return self.after(list(self.places)).sd()


def planned(run: TankRun, want: str) -> tuple[str, ...]:
    """Return what a run of a design measures."""
    if not run.swims:
        return run.measured
    if want == "turn" and run.turns:
        return ("turn_rate",)
    return ("speed", "cost_of_transport") if want == "cost" else ("speed",)


def design(posterior: Posterior, want: str, candidates: Sequence[TankRun], targets: Sequence[Row]) -> Design:
    """Return the design after the runs of a posterior; gaits that the model does not swim are no candidates."""
    made = tuple(dict.fromkeys(one.run for one in posterior.results))
    rows = [Row(run, name) for run in dict.fromkeys((*candidates, *made)) for name in planned(run, want)]
    every = [*rows, *targets, *posterior.rows]
    there, prior = predict(posterior.unknowns, posterior.x, every), posterior.unknowns.covariance
    sound = np.isfinite(there.log)
    jacobian = np.where(sound[:, np.newaxis], there.jacobian, 0.0)
    known, size = jacobian @ prior, max(DESIGNED, posterior.size)
    joint = np.block([[known @ jacobian.T + size**2 * correlation(every, every), known], [known.T, prior]])
    told = slice(len(rows) + len(targets), len(every))
    offsets = posterior.day**2 * same_day([one.day for one in posterior.results])
    joint = narrowed(
        joint, np.arange(told.start, told.stop), np.diag([one.noise**2 for one in posterior.results]) + offsets
    )
    kept = np.delete(np.arange(len(joint)), np.arange(told.start, told.stop))
    value = np.exp(there.log[: len(rows)])
    fast = [sound[k] and value[k] > SLOWEST * QUANTITIES[row.quantity].absolute for k, row in enumerate(rows)]
    places: dict[TankRun, list[int]] = {}
    for k, row in enumerate(rows):
        places.setdefault(row.run, []).append(k)
    return Design(
        want,
        tuple(rows),
        {run: np.array(at) for run, at in places.items() if all(fast[k] for k in at)},
        value,
        np.array([noise_of(row.quantity, v) ** 2 for row, v in zip(rows, value, strict=True)]) + posterior.day**2,
        slice(len(rows), told.start),
        slice(told.start, len(kept)),
        np.diag(prior),
        joint[np.ix_(kept, kept)],
        tuple(one.run for one in posterior.results),
    )


def narrowed(covariance: Array, at: NDArray[np.intp], noise: Array) -> Array:
    """Return a covariance (m, m) after measurements of the rows `at` with noise of a covariance (k, k)."""
    if not len(at):
        return covariance
    by = covariance[:, at]
    return np.asarray(covariance - by @ np.linalg.solve(covariance[np.ix_(at, at)] + noise, by.T))
