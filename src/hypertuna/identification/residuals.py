"""Agreement of computed and measured: errors of runs, squared residuals of samples, information criteria."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.identification.prediction import KINDS, Experiment, Prediction, loss_terms, weighted

__all__ = [
    "ERRORS",
    "LABELS",
    "Errors",
    "criteria",
    "curvature",
    "errors",
    "excess",
    "misfit",
    "normal_mean",
    "squares",
]

Array = NDArray[np.float64]

LEVEL_ROUNDS, SAME_LEVEL = 200, 1e-6  # of looking for the likeliest level of noise
# Errors by kind: the name that says the unit, and how people read it (name, unit, how many of it are one of these).
ERRORS = {"speed": "speed_relative", "cost_of_transport": "cost_of_transport_relative", "x": "x_m", "y": "y_m"}
ERRORS |= {"yaw": "yaw_deg"}
LABELS = {
    "speed_relative": ("speed", "%", 100.0),
    "cost_of_transport_relative": ("cost of transport", "%", 100.0),
    "x_m": ("x", "cm", 100.0),
    "y_m": ("y", "cm", 100.0),
    "yaw_deg": ("yaw", "deg", 1.0),
}


@dataclass(frozen=True)
class Errors:
    """Computed minus measured, of some runs.

    Attributes
    ----------
    rms, largest : dict of float
        By quantity, the unit in its name: ``speed_relative``, ``cost_of_transport_relative``, ``x_m``, ``yaw_deg`` ...
    runs : tuple of dict
        Of each run: its name, and for every quantity what was measured and computed, or the rms over its frames.
    """

    rms: dict[str, float]
    largest: dict[str, float]
    runs: tuple[dict[str, Any], ...]


def squares(data: Experiment, found: Prediction, levels: dict[str, float]) -> Array:
    """Return the squared residual of every sample, in units of its variance.

    Parameters
    ----------
    data : Experiment
    found : Prediction
    levels : dict of float
        As for `hypertuna.identification.prediction.weighted` [1, m and rad].

    Returns
    -------
    ndarray, shape (samples,)
        [1].
    """
    residual, _ = weighted(data, found, levels)
    return np.bincount(data.sample, residual**2, minlength=len(data.kind)).astype(np.float64)


def normal_mean(loss: str) -> float:
    """Return the mean of z rho'(z) for normal errors of the stated noise.

    Parameters
    ----------
    loss : str
        As for `hypertuna.identification.prediction.loss_terms`.

    Returns
    -------
    float
        1 for a linear loss.
    """
    node, weight = np.polynomial.hermite_e.hermegauss(60)
    return float(weight @ (node**2 * loss_terms(loss, node**2)[1]) / weight.sum())


def excess(z: Array, loss: str, count: int = 0) -> float:
    """Tell how many times larger residuals are than their stated noise.

    Parameters
    ----------
    z : ndarray, shape (samples,)
        Squared residuals, from `squares` [1].
    loss : str
        As for `hypertuna.identification.prediction.loss_terms`; outliers count as little as there.
    count : int
        Number of coefficients that were fitted to them.

    Returns
    -------
    float
        The s at which the mean of (z/s^2) rho'(z/s^2) is what it is for normal errors, n - count degrees of freedom.
    """
    normal = normal_mean(loss)
    freedom = max(len(z) - count, 1) / len(z)
    square = float(np.mean(z)) or 1.0
    for _ in range(LEVEL_ROUNDS):
        ratio = float(np.mean(z / square * loss_terms(loss, z / square)[1])) / (normal * freedom)
        square *= ratio
        if square == 0 or abs(ratio - 1) < SAME_LEVEL:
            break
    return math.sqrt(square)


def curvature(data: Experiment, z: Array, loss: str) -> float:
    """Tell how much less than a square a loss bends on average, where a fit ended.

    Parameters
    ----------
    data : Experiment
    z : ndarray, shape (samples,)
        Squared residuals, from `squares` [1].
    loss : str
        As for `hypertuna.identification.prediction.loss_terms`.

    Returns
    -------
    float
        Mean of psi', 1 for a linear loss; of a sample of many elements, across its residual.
    """
    _, first, second = loss_terms(loss, z)
    return max(float(np.mean(np.where(data.count > 1, first, first + 2 * z * second))), 1e-3)


def misfit(data: Experiment, z: Array) -> float:
    """Tell how far the model is from the mean of a recording's runs, which no number of runs makes smaller.

    R runs that scatter about their mean by sd have mean squares z of (R - 1)/R + e^2/sd^2 about a model that is e off
    the mean. The mean itself is known to sd/sqrt(R): in units of that, e^2 is R e^2/sd^2 = R mean(z) - (R - 1).

    Parameters
    ----------
    data : Experiment
    z : ndarray, shape (samples,)
        Squared residuals, from `squares` [1].

    Returns
    -------
    float
        Mean of that over recordings and axes [1]: 1 for a sound model, 0 without recordings whose noise is known.
    """
    first, found = len(data.trials.steady), []
    for swim in data.swims:
        for kind in range(2, len(KINDS)):
            mine = data.known & (data.kind == kind) & (data.run >= first) & (data.run < first + swim.runs)
            if mine.any():
                found.append(swim.runs * float(z[mine].mean()) - (swim.runs - 1))
        first += swim.runs
    return max(float(np.mean(found)), 0.0) if found else 0.0


def criteria(data: Experiment, found: Prediction, levels: dict[str, float], loss: str, count: int) -> dict[str, Any]:
    """Compute Akaike's corrected and the Bayesian information criterion.

    Parameters
    ----------
    data : Experiment
    found : Prediction
    levels : dict of float
        As for `hypertuna.identification.prediction.weighted` [1, m and rad].
    loss : str
        Stands for -2 ln of the likelihood of a sample, but for a constant.
    count : int
        Number of free coefficients. Every unknown noise level counts as one more.

    Returns
    -------
    dict
        ``samples``, ``parameters``, ``minus_2_log_likelihood``, ``aicc`` (None where there are too few samples) and
        ``bic``; lower is better, and only differences between fits to the same runs mean anything. Every run of a
        recording counts: where a model misses the mean of the runs by more than they scatter, differences are
        overstated. All are None for the loss "cauchy", which is no likelihood.
    """
    if loss == "cauchy":  # 1/sqrt(1 + z) has no finite integral: no likelihood
        return dict.fromkeys(("samples", "parameters", "minus_2_log_likelihood", "aicc", "bic"))
    z = squares(data, found, levels)
    level = np.array([levels.get(name, 1.0) for name in KINDS])[data.kind]
    variance = np.where(data.known, data.sd, data.sd * level) ** 2
    # an unknown level takes the value that makes its samples likeliest: where the mean of z rho'(z) is 1
    for k in range(len(KINDS)):
        mine = ~data.known & (data.kind == k)
        for _ in range(LEVEL_ROUNDS if mine.any() else 0):
            best = float(np.mean(z[mine] * loss_terms(loss, z[mine])[1]))
            if best <= 0 or abs(best - 1) < SAME_LEVEL:
                break
            variance[mine] *= best
            z[mine] /= best
    total = float(np.sum(loss_terms(loss, z)[0] + np.log(2 * math.pi * variance)))
    n, k = len(z), count + len(data.unknown_kinds)
    aicc = total + 2 * k + 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else None
    return {
        "samples": n,
        "parameters": k,
        "minus_2_log_likelihood": total,
        "aicc": aicc,
        "bic": total + k * math.log(n),
    }


def errors(data: Experiment, found: Prediction) -> Errors:
    """Compare what was computed with what was measured.

    Parameters
    ----------
    data : Experiment
    found : Prediction

    Returns
    -------
    Errors
        Relative for steady runs, except where a measured speed is 0, which is left out.
    """
    difference = found.computed - data.measured
    kinds = data.kind[data.sample]
    per_run: list[dict[str, Any]] = [{"run": name} for name in data.trials.runs]
    rms, largest = {}, {}
    for k, name in enumerate(KINDS):
        mine = np.flatnonzero((kinds == k) & ((k > 1) | (data.measured != 0)))
        if not len(mine):
            continue
        error = difference[mine] / data.measured[mine] if k < 2 else difference[mine]
        error = np.degrees(error) if name == "yaw" else error
        label = ERRORS[name]
        rms[label], largest[label] = float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())
        run = data.run[data.sample[mine]]
        for r in np.unique(run):
            here = error[run == r]
            if k < 2:
                at = mine[run == r][0]
                pair = {"measured": float(data.measured[at]), "computed": float(found.computed[at])}
                per_run[r] |= {f"{name}_{key}": value for key, value in pair.items()} | {label: float(here[0])}
            else:
                per_run[r] |= {f"{label}_rms": float(np.sqrt(np.mean(here**2)))}
    for r in np.flatnonzero(found.failed | found.unstable):
        per_run[r]["status"] = "not settled" if found.failed[r] else "unstable"
    return Errors(rms, largest, tuple(per_run))
