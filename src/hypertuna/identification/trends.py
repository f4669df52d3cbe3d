"""Trends of the speed's errors with frequency, amplitude or speed, and the coefficient that would explain them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.coefficients import prior_rows, to_scale
from hypertuna.identification.experiment import Experiment
from hypertuna.identification.fixed import fixed_coefficients
from hypertuna.identification.prediction import Prediction, predict
from hypertuna.trials.kinds import kind_of

# Fixed before any data were seen; the level is divided by the number of tests (Bonferroni).
LEVEL = 0.05  # probability of a warning if errors do not depend on any quantity
MIN_VALUES = 4  # runs or recordings
# Significance needs six motions: with five, the rarest order has p = 1 / 60, and three tests need less than that. A
# trend that is not significant still counts if all three of these limits are exceeded.
MIN_CORRELATION, MIN_DIFFERENCE, MIN_SHARE = (
    0.75,
    0.005,
    0.75,
)  # rank correlation; range of relative errors; share of squared errors that one coefficient would explain
MIN_REMAINDER = 1e-12  # fraction of squared errors: if less is left, the free coefficients would explain them all
MAX_EXACT, SHUFFLES = 8, 9999  # number of runs up to which all orders are tried; number of random orders beyond
NAMED_SHARE = 0.25  # share of the squared errors that a coefficient must explain to be named


@dataclass(frozen=True)
class Trend:
    """A trend of the relative error of the speed with one quantity."""

    quantity: str  # frequency, amplitude or speed
    correlation: float  # Spearman's rank correlation
    p: float
    motions: int  # number of runs and recordings
    tests: int  # number of quantities tested
    clear: bool  # whether the trend is significant
    shares: dict[str, float]  # by coefficient that is not free: share of the squared errors that it would explain

    @property
    def sentence(self) -> str:
        """Sentence on the trend, with the coefficient that would explain most of it."""
        verb = "rises" if self.correlation > 0 else "falls"
        chance = f"below {LEVEL:g} / {self.tests} tests" if self.clear else "which may be chance"
        best = max(self.shares, key=lambda name: self.shares[name], default="")
        explanation = f"{best} would take {100 * self.shares.get(best, 0.0):.0f} % of the squared errors; free it"
        if not self.shares:
            explanation = "no coefficient of the water law is left to free"
        elif self.shares[best] < NAMED_SHARE:
            explanation = f"no coefficient that is not free would take more than {100 * NAMED_SHARE:.0f} % of it"
        return (
            f"The error of the speed {verb} with {self.quantity} (rank correlation {self.correlation:.2f} of "
            f"{self.motions} motions, p = {self.p:.1g}, {chance}): {explanation}."
        )


def trends(data: Experiment, values: Array, prediction: Prediction, seed: int) -> tuple[Trend, ...]:
    """Return the trends of the speed's errors with frequency, amplitude and speed."""
    rows, first = list[dict[int, float]](), 0
    for group in data.groups:
        rows += [{first + k: weight for k, weight in row.items()} for row in group.speed_errors()]
        first += len(group.measured)
    motions = [kind_of(trial).motion(trial) for trial in data.trials.members]
    used = [k for k, row in enumerate(rows) if row and "speed" in motions[k]]
    if len(used) < MIN_VALUES:
        return ()
    matrix = _sparse([rows[k] for k in used], len(data.sample))
    error = matrix @ (prediction.computed - data.measured)
    quantities = {name: np.array([motions[k][name] for k in used]) for name in ("frequency", "amplitude", "speed")}
    tested = {name: x for name, x in quantities.items() if np.ptp(x) > 1e-6 * np.abs(x).max()}
    results = {}
    for name, x in tested.items():
        rho, p = rank_correlation(x, error, seed)
        clear = p < LEVEL / len(tested)
        if clear or (abs(rho) >= MIN_CORRELATION and float(np.ptp(error)) > MIN_DIFFERENCE):
            results[name] = rho, p, len(used), len(tested), clear
    shares = _shares(data, values, matrix, error) if results else {}
    explained = max(shares.values(), default=0.0) > MIN_SHARE
    return tuple(Trend(name, *facts, shares) for name, facts in results.items() if facts[-1] or explained)


def linear_drag(found: Sequence[Trend]) -> str | None:
    """Return the name of linear drag along the body, if it would explain a trend with speed or frequency."""
    for trend in found:
        for name, share in trend.shares.items():
            candidate = trend.quantity != "amplitude" and ".linear_tangential[" in name
            if candidate and share > (NAMED_SHARE if trend.clear else MIN_SHARE):
                return name
    return None


def rank_correlation(x: Array, y: Array, seed: int) -> tuple[float, float]:
    """Return Spearman's rank correlation and its two-sided p-value, from all orders or from 9999 random ones."""
    from scipy.stats import rankdata  # imported here: slow to import

    a, b = rankdata(x) - (len(x) + 1) / 2, rankdata(y) - (len(y) + 1) / 2
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    if size == 0:
        return 0.0, 1.0
    rho = float(a @ b) / size
    if len(x) <= MAX_EXACT:
        orders = np.array(list(permutations(b.tolist())))
        return rho, float(np.mean(np.abs(orders @ a) >= (abs(rho) - 1e-12) * size))
    rng = np.random.default_rng(seed)
    count = sum(abs(float(rng.permutation(b) @ a)) >= (abs(rho) - 1e-12) * size for _ in range(SHUFFLES))
    return rho, (1 + count) / (1 + SHUFFLES)


def _sparse(rows: Sequence[dict[int, float]], columns: int) -> Any:
    """Return rows of weights, by column, as a sparse matrix."""
    from scipy.sparse import csr_array  # imported here: slow to import

    indices = [k for k, row in enumerate(rows) for _ in row], [k for row in rows for k in row]
    return csr_array(([weight for row in rows for weight in row.values()], indices), shape=(len(rows), columns))


def _shares(data: Experiment, values: Array, matrix: Any, error: Array) -> dict[str, float]:
    """Return by name the share of squared errors that each coefficient which is not free would explain."""
    candidates = fixed_coefficients(data.robot, data.free)
    if not candidates:
        return {}
    extended = replace(data, free=(*data.free, *candidates))
    start = np.append(values, [candidate.start for candidate in candidates])
    jacobian = matrix @ predict(extended, start, gradient_steps=data.steps).jacobian / np.sqrt(np.mean(error**2))
    prior_error, of_priors = prior_rows(data.free, to_scale(data.free, values))
    free_columns = np.concatenate([jacobian[:, : len(data.free)], of_priors])
    other_columns = np.concatenate([jacobian[:, len(data.free) :], np.zeros((len(of_priors), len(candidates)))])
    error = np.append(error / np.sqrt(np.mean(error**2)), prior_error)
    basis = np.linalg.qr(free_columns)[0]
    remainder = error - basis @ (basis.T @ error)
    if remainder @ remainder < MIN_REMAINDER * (error @ error):
        return {}
    shares = {}
    for candidate, column in zip(candidates, other_columns.T, strict=True):
        independent = column - basis @ (basis.T @ column)
        square = float(independent @ independent)
        step = -float(independent @ remainder) / square if square > 1e-18 else 0.0
        allowed = step > 0 or (step < 0 and candidate.start > candidate.lower)
        shares[candidate.name] = step**2 * square / float(remainder @ remainder) if allowed else 0.0
    return shares
