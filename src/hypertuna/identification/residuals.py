"""Residuals of a fit: errors of runs, squared residuals of samples, lack of fit, information criteria."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.experiment import NAMES, Experiment
from hypertuna.identification.loss import loss_terms
from hypertuna.identification.prediction import Prediction, weighted
from hypertuna.io.quantity import key_of
from hypertuna.trials.kinds import QUANTITIES

MAX_ITERATIONS, LEVEL_TOLERANCE = 200, 1e-6  # iterations for the most likely noise level; their relative tolerance
LABELS = {
    one.key: (one.label, one.shown, one.factor) for one in QUANTITIES.values()
}  # label, displayed unit, displayed units per unit of the error
NUMBERS = {
    name: one.unit for name, one in QUANTITIES.items() if one.relative
}  # by quantity that is one number per run: its unit


@dataclass(frozen=True)
class Errors:
    """Errors of runs, computed minus measured: over all runs, and of each run."""

    rms: dict[str, float]  # by quantity with unit, such as speed_relative, x_m, yaw_deg
    max: dict[str, float]  # largest magnitude, by the same keys
    runs: tuple[dict[str, Any], ...]  # for each run: name, and measured and computed values or the rms over its frames


def squares(data: Experiment, prediction: Prediction, levels: dict[str, float]) -> Array:
    """Return the squared residual (samples,) of every sample over its variance; levels as for `weighted`."""
    residual, _ = weighted(data, prediction, levels)
    return np.bincount(data.sample, residual**2, minlength=len(data.kind)).astype(np.float64)


def lack_of_fit(data: Experiment, z: Array) -> float:
    """Return the squared distance of the model from the mean of a recording's runs, over the variance of that mean.

    If R runs scatter about their mean by sd, and the model is off by e, the mean of z is (R - 1)/R + e^2/sd^2. The
    result is the mean of R e^2/sd^2 over recordings and axes: 1 for a correct model, 0 without known noise.
    """
    first, distances = 0, []
    for rows in data.groups:
        runs = rows.runs
        for kind in range(len(NAMES)) if rows.one_motion else ():
            selected = data.known & (data.kind == kind) & (data.run >= first) & (data.run < first + runs)
            if selected.any():
                distances.append(runs * float(z[selected].mean()) - (runs - 1))
        first += runs
    return max(float(np.mean(distances)), 0.0) if distances else 0.0


def degrees_taken(jacobian: Array, known: Array) -> float:
    """Return how many degrees of freedom n coefficients use up, from the elements' Jacobian J (elements, n).

    known: Jacobian P (k, n) of the priors, which reduce the number: trace of J (J^T J + P^T P)^-1 J^T.
    """
    if not len(known):
        return float(jacobian.shape[1])
    basis = np.linalg.svd(np.concatenate([jacobian, known]), full_matrices=False)[0]
    return float(np.sum(basis[: len(jacobian)] ** 2))


def stretches(
    data: Experiment, prediction: Prediction, levels: dict[str, float], factor: float, taken: float
) -> tuple[Array, float]:
    """Return the factors (samples,) on standard deviations for intervals, and the degrees of freedom.

    The factor is `factor`, except for tracks whose noise was estimated from their residuals. Their N frames count as
    N / tau independent ones, where tau = 1 + 2 sum of the residuals' autocorrelations, so the variance of a track is
    that of its residuals times tau / N.
    """
    count = data.count.astype(float)
    residual = weighted(data, prediction, levels)[0] * np.sqrt(count)[data.sample]
    correlated = ~data.known & (count > 1)
    tau, mean_square = count.copy(), np.ones(len(count))
    for kind in np.unique(data.kind[correlated]):
        samples = np.flatnonzero(correlated & (data.kind == kind))
        series = [residual[data.sample == k] for k in samples.tolist()]
        tau[samples] = np.minimum(autocorrelation_time(series), count[samples])
        mean_square[samples] = sum(float(r @ r) for r in series) / count[samples].sum()
    independent = np.where(correlated, count / tau, 1.0)
    freedom = float(max(independent.sum() - taken, 1.0))
    variance = mean_square * tau / count * (independent.sum() / freedom)
    return np.where(correlated, np.sqrt(variance), factor), freedom


def autocorrelation_time(series: Sequence[Array]) -> float:
    """Return tau = 1 + 2 sum of the autocorrelations of residuals, estimated jointly from several series.

    The sum ends when the sum of two neighboring correlations is no longer positive (Geyer 1992).
    """
    size = max(len(r) for r in series)
    power = sum(np.abs(np.fft.rfft(r, 2 * size)) ** 2 for r in series)
    correlation = np.fft.irfft(power)[:size]
    if correlation[0] <= 0:
        return float(size)
    pairs = correlation[: size // 2 * 2].reshape(-1, 2).sum(axis=1) / correlation[0]
    end = int(np.argmax(pairs <= 0)) if (pairs <= 0).any() else len(pairs)
    return max(2 * float(pairs[:end].sum()) - 1, 1.0)


def criteria(data: Experiment, prediction: Prediction, levels: dict[str, float]) -> dict[str, Any]:
    """Compute Akaike's corrected (`aicc`) and the Bayesian information criterion (`bic`) of a fit; lower is better.

    The loss is -2 ln(likelihood) of a sample, up to a constant; each unknown noise level counts as a parameter.
    `aicc` is None for too few samples, and all are None for the loss "cauchy", which is no likelihood.
    """
    if data.loss == "cauchy":  # 1/sqrt(1 + z) has no finite integral
        return dict.fromkeys(("samples", "parameters", "minus_2_log_likelihood", "aicc", "bic"))
    z = squares(data, prediction, levels)
    variance = data.noise(levels) ** 2
    # an unknown level gets its maximum-likelihood value, for which the mean of z rho'(z) is 1
    for k in range(len(NAMES)):
        selected = ~data.known & (data.kind == k)
        for _ in range(MAX_ITERATIONS if selected.any() else 0):
            ratio = float(np.mean(z[selected] * loss_terms(data.loss, z[selected])[1]))
            if ratio <= 0 or abs(ratio - 1) < LEVEL_TOLERANCE:
                break
            variance[selected] *= ratio
            z[selected] /= ratio
    total = float(np.sum(loss_terms(data.loss, z)[0] + np.log(2 * math.pi * variance)))
    n, k = len(z), len(data.free) + len(data.unknown_kinds)
    facts = {"samples": n, "parameters": k, "minus_2_log_likelihood": total}
    aicc = total + 2 * k + 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else None
    return facts | {"aicc": aicc, "bic": total + k * math.log(n)}


def errors(data: Experiment, prediction: Prediction) -> Errors:
    """Return the errors of all runs; relative errors leave out runs whose measured value is 0."""
    kinds = data.kind[data.sample]
    per_run: list[dict[str, Any]] = [{"run": name} for name in data.trials.runs]
    rms, largest = {}, {}
    for k, (name, quantity) in enumerate(QUANTITIES.items()):
        index = np.flatnonzero((kinds == k) & ((data.measured != 0) | (not quantity.relative)))
        if not len(index):
            continue
        measured, computed, run = data.measured[index], prediction.computed[index], data.run[data.sample[index]]
        error = (computed - measured) / measured if quantity.relative else (computed - measured) * quantity.per_si
        rms[quantity.key], largest[quantity.key] = float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())
        for r in np.unique(run):
            first = int(np.argmax(run == r))
            if quantity.relative:
                pair = {"measured": measured, "computed": computed}
                values = {key_of(f"{name}_{of}", quantity.unit): float(numbers[first]) for of, numbers in pair.items()}
                per_run[r] |= values | {quantity.key: float(error[first])}
            else:
                per_run[r] |= {f"{quantity.key}_rms": float(np.sqrt(np.mean(error[run == r] ** 2)))}
    for r in np.flatnonzero(prediction.failed | prediction.unstable):
        per_run[r]["status"] = "not settled" if prediction.failed[r] else "unstable"
    return Errors(rms, largest, tuple(per_run))
