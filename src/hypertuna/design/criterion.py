"""Greedy choice of the next run: the one that narrows most, with the discrepancy of the model included."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.design.discrepancy import DESIGNED, correlation, same_day
from hypertuna.design.posterior import Posterior
from hypertuna.design.prediction import Row, predict
from hypertuna.design.runs import QUANTITIES, SLOWEST, TankRun, noise_of

# What a design may ask for, and the quantity of its target gaits.
WISHES = {"speed": "speed", "turn": "turn_rate", "cost": "cost_of_transport", "coefficients": ""}
CHECK = 4  # every fourth run checks the model, with a gait unlike those of the runs so far
FARTHEST = 0.98  # a gait counts as farthest from the runs if its discrepancy has this part of the largest variance
NEVER = 0.8  # no run tells a coefficient if all runs leave more than this part of its prior standard deviation


@dataclass(frozen=True)
class Design:
    """Joint normal distribution of candidates, targets and coefficients, narrowed run by run.

    How much a run narrows does not depend on its measured values, so several runs can be chosen in advance.
    """

    want: str
    rows: tuple[Row, ...]  # quantities of the candidates; in the covariance, targets and coefficients follow them
    places: Mapping[TankRun, NDArray[np.intp]]  # rows of each candidate
    value: Array  # (rows,) expected values [SI]
    noise: Array  # (rows,) variance of the logarithm of one measurement
    targets: slice  # rows of the targets in the covariance
    free: slice  # rows of the coefficients in the covariance
    prior: Array  # (n,) variance of the coefficients before all runs
    covariance: Array  # (m, m) of log rows, log targets and scaled coefficients
    made: tuple[TankRun, ...]  # runs made or chosen so far

    def width(self) -> float:
        """Return the root mean square of the standard deviations of the log targets."""
        return float(np.sqrt(np.diag(self.covariance)[self.targets].mean()))

    def sd(self) -> Array:
        """Return the standard deviations (n,) of the scaled coefficients."""
        return np.sqrt(np.maximum(np.diag(self.covariance)[self.free], 0.0))

    def score(self, run: TankRun) -> float:
        """Return the mean variance after a run: of the log targets, or of the coefficients relative to their priors."""
        rows, wanted = self.places[run], self.free if self.want == "coefficients" else self.targets
        covariance = self.covariance[wanted, rows]
        gain = np.linalg.solve(self.covariance[np.ix_(rows, rows)] + np.diag(self.noise[rows]), covariance.T)
        variance = np.diag(self.covariance)[wanted] - np.einsum("ij,ji->i", covariance, gain)
        return float(np.mean(variance / self.prior if self.want == "coefficients" else variance))

    def after(self, runs: Sequence[TankRun]) -> "Design":
        """Return the design narrowed by the given runs."""
        measured = np.concatenate([self.places[run] for run in runs])
        covariance = narrowed(self.covariance, measured, np.diag(self.noise[measured]))
        return replace(self, covariance=covariance, made=(*self.made, *runs))

    def best(self) -> TankRun:
        """Return the candidate that narrows most; it may repeat a run that was already made."""
        return min(self.places, key=self.score)

    def farthest(self) -> TankRun:
        """Return the check of a design: a swim whose discrepancy correlates least with that of the runs so far."""
        swims = [run for run in self.places if run.swims and (run.turns or self.want != "turn")]
        gaits = [run for run in swims if run not in self.made]
        if not gaits:
            return self.best()
        new, made = ([Row(run, "speed") for run in runs if run.swims] for runs in (gaits, self.made))
        to_made, between = correlation(new, made), correlation(made, made)
        unseen = 1 - np.einsum("ij,ji->i", to_made, np.linalg.solve(between + 1e-6 * np.eye(len(made)), to_made.T))
        farthest = [run for run, variance in zip(gaits, unseen, strict=True) if variance >= FARTHEST * unseen.max()]
        return min(farthest, key=self.score)

    def never(self) -> Array:
        """Return the standard deviations (n,) of the coefficients that all candidates together would leave."""
        return self.after(list(self.places)).sd()


def planned(run: TankRun, want: str) -> tuple[str, ...]:
    """Return the quantities that a run is to measure in a design for `want`, a key of `WISHES`."""
    if not run.swims:
        return run.measured
    if want == "turn" and run.turns:
        return ("turn_rate",)
    return ("speed", "cost_of_transport") if want == "cost" else ("speed",)


def design(posterior: Posterior, want: str, candidates: Sequence[TankRun], targets: Sequence[Row]) -> Design:
    """Return the design after the runs of a posterior, without candidates whose gait the model cannot swim."""
    runs_made = tuple(dict.fromkeys(result.run for result in posterior.results))
    rows = [Row(run, name) for run in dict.fromkeys((*candidates, *runs_made)) for name in planned(run, want)]
    all_rows = [*rows, *targets, *posterior.rows]
    predicted, prior = predict(posterior.unknowns, posterior.x, all_rows), posterior.unknowns.covariance
    finite = np.isfinite(predicted.log)
    jacobian = np.where(finite[:, np.newaxis], predicted.jacobian, 0.0)
    cross, size = jacobian @ prior, max(DESIGNED, posterior.size)
    joint = np.block([[cross @ jacobian.T + size**2 * correlation(all_rows, all_rows), cross], [cross.T, prior]])
    past = slice(len(rows) + len(targets), len(all_rows))
    offsets = posterior.day**2 * same_day([result.day for result in posterior.results])
    joint = narrowed(
        joint, np.arange(past.start, past.stop), np.diag([result.noise**2 for result in posterior.results]) + offsets
    )
    others = np.delete(np.arange(len(joint)), np.arange(past.start, past.stop))
    value = np.exp(predicted.log[: len(rows)])
    usable = [finite[k] and value[k] > SLOWEST * QUANTITIES[row.quantity].absolute for k, row in enumerate(rows)]
    places: dict[TankRun, list[int]] = {}
    for k, row in enumerate(rows):
        places.setdefault(row.run, []).append(k)
    return Design(
        want,
        tuple(rows),
        {run: np.array(k_of_run) for run, k_of_run in places.items() if all(usable[k] for k in k_of_run)},
        value,
        np.array([noise_of(row.quantity, v) ** 2 for row, v in zip(rows, value, strict=True)]) + posterior.day**2,
        slice(len(rows), past.start),
        slice(past.start, len(others)),
        np.diag(prior),
        joint[np.ix_(others, others)],
        tuple(result.run for result in posterior.results),
    )


def narrowed(covariance: Array, rows: NDArray[np.intp], noise: Array) -> Array:
    """Return a covariance (m, m) after k of its rows were measured with noise of covariance (k, k)."""
    if not len(rows):
        return covariance
    cross = covariance[:, rows]
    return np.asarray(covariance - cross @ np.linalg.solve(covariance[np.ix_(rows, rows)] + noise, cross.T))
