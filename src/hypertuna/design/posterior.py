"""Posterior of the unknowns and of what the model misses, given measured runs: linear about its mean."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from hypertuna.arrays import Array
from hypertuna.design.discrepancy import DAYS, SIZES, correlation, same_day
from hypertuna.design.prediction import Row, predict
from hypertuna.design.runs import Measurement
from hypertuna.design.unknowns import Unknowns
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import bounds_of

ROUNDS = 12  # of linearization
FAR = 1.0  # of a scaled coefficient: the largest step of one round
DONE = 1e-2  # of the prior's standard deviation


@dataclass(frozen=True)
class Kernel:
    """One size of discrepancy and of the days' offsets: the conditional normal distribution that follows."""

    size: float
    day: float
    weight: float  # probability of these sizes, given the runs
    inverse: Array  # (rows, rows) of the covariance of the results
    weighted: Array  # (rows,) that inverse times the residuals


@dataclass(frozen=True)
class Posterior:
    """What is known after runs, as a mixture over the sizes of the discrepancy."""

    unknowns: Unknowns
    results: tuple[Measurement, ...]
    x: Array  # (n,) mean of the scaled coefficients, about which all is linear
    rows: tuple[Row, ...]  # of the results
    jacobian: Array  # (rows, n)
    kernels: tuple[Kernel, ...]

    @cached_property
    def size(self) -> float:
        """Root mean square of the discrepancy's standard deviation."""
        return float(np.sqrt(sum(one.weight * one.size**2 for one in self.kernels)))

    @cached_property
    def day(self) -> float:
        """Root mean square of the standard deviation of the days' offsets."""
        return float(np.sqrt(sum(one.weight * one.day**2 for one in self.kernels)))

    def predict(self, rows: Sequence[Row]) -> tuple[Array, Array]:
        """Return mean and standard deviation (rows,) of the logarithm of what a run would measure without noise."""
        there = predict(self.unknowns, self.x, rows)
        return self._mixed(there.log, there.jacobian, correlation(rows, self.rows))

    @cached_property
    def coefficients(self) -> tuple[Array, Array]:
        """Mean and standard deviation (n,) of the scaled coefficients."""
        return self._mixed(self.x, np.eye(len(self.x)), None)

    def _mixed(self, value: Array, jacobian: Array, near: Array | None) -> tuple[Array, Array]:
        """Return the moments of the mixture for linear functions, whose discrepancies correlate with the results'."""
        prior = self.unknowns.covariance
        begin = value + jacobian @ (self.unknowns.mean - self.x)
        own = np.einsum("ij,jk,ik->i", jacobian, prior, jacobian)
        means, variances = [], []
        for one in self.kernels:
            known = jacobian @ prior @ self.jacobian.T
            alone = 0.0
            if near is not None:
                known, alone = known + one.size**2 * near, one.size**2
            means.append(begin + known @ one.weighted)
            variances.append(own + alone - np.einsum("ij,jk,ik->i", known, one.inverse, known))
        weight = np.array([one.weight for one in self.kernels])
        mean = weight @ np.array(means)
        spread = weight @ (np.maximum(variances, 0.0) + np.square(means - mean))
        return mean, np.sqrt(spread)


def infer(unknowns: Unknowns, results: Sequence[Measurement], sizes: Sequence[float] = SIZES) -> Posterior:
    """Fit the unknowns to results, with discrepancies of sizes that the results make likely.

    Gauss-Newton steps toward the mean of the mixture. The offset of a day counts where results of several days are
    known.
    """
    rows = tuple(Row(one.run, one.quantity) for one in results)
    x = unknowns.mean.copy()
    lower, upper = bounds_of(unknowns.free)
    made = Posterior(
        unknowns, tuple(results), x, rows, np.zeros((0, len(x))), _kernels((), np.zeros(0), np.zeros(0), sizes)
    )
    if not rows:
        return made
    measured = np.log([one.value for one in results])
    for _ in range(ROUNDS):
        there = predict(unknowns, x, rows)
        _check_swims(results, there.log)
        residuals = measured - there.log + there.jacobian @ (x - unknowns.mean)
        known = there.jacobian @ unknowns.covariance @ there.jacobian.T
        made = Posterior(unknowns, tuple(results), x, rows, there.jacobian, _kernels(results, residuals, known, sizes))
        step = np.clip(made.coefficients[0] - x, -FAR, FAR)
        following = np.clip(x + step, lower, upper)
        if np.all(np.abs(following - x) <= DONE * unknowns.sd):
            break
        x = following
    return made


def _check_swims(results: Sequence[Measurement], log: Array) -> None:
    """Check that the model swims every gait of the results forward."""
    lost = [one for one, value in zip(results, log, strict=True) if not np.isfinite(value)]
    if lost:
        rule, fix = "has no settled beat forward in the model", "leave the run out, or correct the robot file"
        raise InputError(rule, key=f"the gait of {lost[0].name or 'a run'}", fix=fix)


def _kernels(
    results: Sequence[Measurement], residuals: Array, known: Array, sizes: Sequence[float]
) -> tuple[Kernel, ...]:
    """Return every pair of sizes with its probability by the residuals, whose covariance by the unknowns is `known`."""
    rows = [Row(one.run, one.quantity) for one in results]
    noise = np.diag([one.noise**2 for one in results])
    near, days = correlation(rows, rows), same_day([one.day for one in results])
    several = len({one.day for one in results}) > 1
    made, logs = [], []
    for size, day in product(sizes, DAYS if several else (0.0,)):
        covariance = known + noise + size**2 * near + day**2 * days
        inverse = np.asarray(np.linalg.inv(covariance), dtype=np.float64)
        weighted = inverse @ residuals
        logs.append(0.5 * (np.linalg.slogdet(inverse)[1] - residuals @ weighted))
        made.append((size, day, inverse, weighted))
    weights = np.exp(np.array(logs) - max(logs))
    weights /= weights.sum()
    return tuple(
        Kernel(size, day, float(w), inverse, seen) for (size, day, inverse, seen), w in zip(made, weights, strict=True)
    )
