"""Posterior of coefficients and discrepancy, given measured runs: linear about its mean."""

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

ROUNDS = 12  # largest number of Gauss-Newton steps
MAX_STEP = 1.0  # largest change of a scaled coefficient in one step
DONE = 1e-2  # steps end when no coefficient moves by more than this part of its prior standard deviation


@dataclass(frozen=True)
class Kernel:
    """One pair of sizes, of the discrepancy and of days' offsets, with its probability and the results' covariance."""

    size: float  # standard deviation of the discrepancy
    day: float  # standard deviation of the offsets of days
    weight: float  # probability of these sizes, given the runs
    inverse: Array  # (rows, rows) inverse of the covariance of the results
    weighted: Array  # (rows,) `inverse` times the residuals


@dataclass(frozen=True)
class Posterior:
    """Posterior after runs: a mixture of normal distributions, one for each size of discrepancy and days' offsets."""

    unknowns: Unknowns
    results: tuple[Measurement, ...]
    x: Array  # (n,) scaled coefficients about which the model is linearized
    rows: tuple[Row, ...]  # runs and quantities of the results
    jacobian: Array  # (rows, n) derivatives of the logarithms at x
    kernels: tuple[Kernel, ...]

    @cached_property
    def size(self) -> float:
        """Root mean square, over the kernels, of the discrepancy's standard deviation."""
        return float(np.sqrt(sum(kernel.weight * kernel.size**2 for kernel in self.kernels)))

    @cached_property
    def day(self) -> float:
        """Root mean square, over the kernels, of the standard deviation of the days' offsets."""
        return float(np.sqrt(sum(kernel.weight * kernel.day**2 for kernel in self.kernels)))

    def predict(self, rows: Sequence[Row]) -> tuple[Array, Array]:
        """Return mean and standard deviation (rows,) of the true logarithms, without the noise of a measurement."""
        predicted = predict(self.unknowns, self.x, rows)
        return self._mixed(predicted.log, predicted.jacobian, correlation(rows, self.rows))

    @cached_property
    def coefficients(self) -> tuple[Array, Array]:
        """Mean and standard deviation (n,) of the scaled coefficients."""
        return self._mixed(self.x, np.eye(len(self.x)), None)

    def _mixed(self, value: Array, jacobian: Array, cross_correlation: Array | None) -> tuple[Array, Array]:
        """Return mean and sd of linear functions; cross_correlation: of their discrepancies with the results' ones."""
        prior = self.unknowns.covariance
        start = value + jacobian @ (self.unknowns.mean - self.x)
        prior_variance = np.einsum("ij,jk,ik->i", jacobian, prior, jacobian)
        means, variances = [], []
        for kernel in self.kernels:
            cross = jacobian @ prior @ self.jacobian.T
            variance = 0.0
            if cross_correlation is not None:
                cross, variance = cross + kernel.size**2 * cross_correlation, kernel.size**2
            means.append(start + cross @ kernel.weighted)
            variances.append(prior_variance + variance - np.einsum("ij,jk,ik->i", cross, kernel.inverse, cross))
        weight = np.array([kernel.weight for kernel in self.kernels])
        mean = weight @ np.array(means)
        total = weight @ (np.maximum(variances, 0.0) + np.square(means - mean))
        return mean, np.sqrt(total)


def infer(unknowns: Unknowns, results: Sequence[Measurement], sizes: Sequence[float] = SIZES) -> Posterior:
    """Return the posterior given results, with each size of the discrepancy weighted by its probability.

    Gauss-Newton steps go toward the mean of the mixture. Offsets of days count only if the results are of several days.
    """
    rows = tuple(Row(result.run, result.quantity) for result in results)
    x = unknowns.mean.copy()
    lower, upper = bounds_of(unknowns.free)
    post = Posterior(
        unknowns, tuple(results), x, rows, np.zeros((0, len(x))), _kernels((), np.zeros(0), np.zeros(0), sizes)
    )
    if not rows:
        return post
    measured = np.log([result.value for result in results])
    for _ in range(ROUNDS):
        at_x = predict(unknowns, x, rows)
        _check_swims(results, at_x.log)
        residuals = measured - at_x.log + at_x.jacobian @ (x - unknowns.mean)
        coefficient_covariance = at_x.jacobian @ unknowns.covariance @ at_x.jacobian.T
        post = Posterior(
            unknowns,
            tuple(results),
            x,
            rows,
            at_x.jacobian,
            _kernels(results, residuals, coefficient_covariance, sizes),
        )
        step = np.clip(post.coefficients[0] - x, -MAX_STEP, MAX_STEP)
        next_x = np.clip(x + step, lower, upper)
        if np.all(np.abs(next_x - x) <= DONE * unknowns.sd):
            break
        x = next_x
    return post


def _check_swims(results: Sequence[Measurement], log: Array) -> None:
    """Check that the model swims every gait of the results forward."""
    unswum = [result for result, value in zip(results, log, strict=True) if not np.isfinite(value)]
    if unswum:
        what = "settled beat forward" if unswum[0].run.gait is not None else "finite value"
        fix = "check the units of the run, leave it out, or correct the robot file"
        raise InputError(f"has no {what} in the model", key=f"the run {unswum[0].name}".rstrip(), fix=fix)


def _kernels(
    results: Sequence[Measurement], residuals: Array, coefficient_covariance: Array, sizes: Sequence[float]
) -> tuple[Kernel, ...]:
    """Return each pair of sizes with its probability; coefficient_covariance: part of the results' covariance."""
    rows = [Row(result.run, result.quantity) for result in results]
    noise = np.diag([result.noise**2 for result in results])
    correlated, days_equal = correlation(rows, rows), same_day([result.day for result in results])
    several_days = len({result.day for result in results}) > 1
    parts, logs = [], []
    for size, day in product(sizes, DAYS if several_days else (0.0,)):
        covariance = coefficient_covariance + noise + size**2 * correlated + day**2 * days_equal
        inverse = np.asarray(np.linalg.inv(covariance), dtype=np.float64)
        weighted = inverse @ residuals
        logs.append(0.5 * (np.linalg.slogdet(inverse)[1] - residuals @ weighted))
        parts.append((size, day, inverse, weighted))
    weights = np.exp(np.array(logs) - max(logs))
    weights /= weights.sum()
    return tuple(
        Kernel(size, day, float(w), inverse, v) for (size, day, inverse, v), w in zip(parts, weights, strict=True)
    )
