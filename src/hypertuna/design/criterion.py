"""Choice of the next run: greedy, by its exact expected narrowing, with the model's discrepancy included."""

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
        """Return the root mean square of the standard deviations of the log targets."""
        return float(np.sqrt(np.diag(self.covariance)[self.targets].mean()))

    def sd(self) -> Array:
        """Return the standard deviations (n,) of the scaled coefficients."""
        return np.sqrt(np.maximum(np.diag(self.covariance)[self.free], 0.0))

    def score(self, run: TankRun) -> float:
        """Return the mean variance after a run: of the log targets, or of the coefficients over their priors."""
        rows, wanted = self.places[run], self.free if self.want == "coefficients" else self.targets
        covariance = self.covariance[wanted, rows]
        gain = np.linalg.solve(self.covariance[np.ix_(rows, rows)] + np.diag(self.noise[rows]), covariance.T)
        variance = np.diag(self.covariance)[wanted] - np.einsum("ij,ji->i", covariance, gain)
        return float(np.mean(variance / self.prior if self.want == "coefficients" else variance))

    def after(self, runs: Sequence[TankRun]) -> "Design":
        """Return the design after the given runs."""
        measured = np.concatenate([self.places[run] for run in runs])
        covariance = narrowed(self.covariance, measured, np.diag(self.noise[measured]))
        return replace(self, covariance=covariance, made=(*self.made, *runs))

    def best(self) -> TankRun:
        """Return the candidate that narrows most; a run that was made before would be its repeat."""
        return min(self.places, key=self.score)

    def farthest(self) -> TankRun:
        """Return a gait that correlates little with the runs made so far, by the discrepancy: the check of a design."""
        swims = [run for run in self.places if run.swims and (run.turns or self.want != "turn")]
        gaits = [run for run in swims if run not in self.made]
        if not gaits:
            return self.best()
        new, made = ([Row(run, "speed") for run in runs if run.swims] for runs in (gaits, self.made))
        to_made, between = correlation(new, made), correlation(made, made)
        unseen = 1 - np.einsum("ij,ji->i", to_made, np.linalg.solve(between + 1e-6 * np.eye(len(made)), to_made.T))
        farthest = [run for run, variance in zip(gaits, unseen, strict=True) if variance >= AS_FAR * unseen.max()]
        return min(farthest, key=self.score)

    def never(self) -> Array:
        """Return the standard deviations (n,) of the coefficients after all candidates together."""
        return self.after(list(self.places)).sd()


def planned(run: TankRun, want: str) -> tuple[str, ...]:
    """Return the quantities that a run of a design measures."""
    if not run.swims:
        return run.measured
    if want == "turn" and run.turns:
        return ("turn_rate",)
    return ("speed", "cost_of_transport") if want == "cost" else ("speed",)


def design(posterior: Posterior, want: str, candidates: Sequence[TankRun], targets: Sequence[Row]) -> Design:
    """Return the design after the runs of a posterior; gaits that the model does not swim are no candidates."""
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


def narrowed(covariance: Array, at: NDArray[np.intp], noise: Array) -> Array:
    """Return a covariance (m, m) after measurements of its rows `at` with noise of covariance (k, k)."""
    if not len(at):
        return covariance
    by = covariance[:, at]
    return np.asarray(covariance - by @ np.linalg.solve(covariance[np.ix_(at, at)] + noise, by.T))
