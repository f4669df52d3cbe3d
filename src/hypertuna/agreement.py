"""Agreement of computed and measured: errors of runs, squared residuals of samples, information criteria."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.predict import KINDS, Experiment, Prediction, loss_terms, weighted

__all__ = ["ERRORS", "LABELS", "Errors", "criteria", "errors", "squares"]

Array = NDArray[np.float64]

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
        As for `hypertuna.predict.weighted` [1, m and rad].

    Returns
    -------
    ndarray, shape (samples,)
        [1].
    """
    residual, _ = weighted(data, found, levels)
    return np.bincount(data.sample, residual**2, minlength=len(data.kind)).astype(np.float64)


def criteria(data: Experiment, found: Prediction, levels: dict[str, float], loss: str, count: int) -> dict[str, Any]:
    """Compute Akaike's corrected and the Bayesian information criterion.

    Parameters
    ----------
    data : Experiment
    found : Prediction
    levels : dict of float
        As for `hypertuna.predict.weighted` [1, m and rad].
    loss : str
        Stands for -2 ln of the likelihood of a sample, but for a constant.
    count : int
        Number of free coefficients. Every unknown noise level counts as one more.

    Returns
    -------
    dict
        ``samples``, ``parameters``, ``minus_2_log_likelihood``, ``aicc`` (None where there are too few samples) and
        ``bic``; lower is better, and only differences between fits to the same runs mean anything.
    """
    z = squares(data, found, levels)
    level = np.array([levels.get(name, 1.0) for name in KINDS])[data.kind]
    variance = np.where(data.known, data.sd, data.sd * level) ** 2
    # an unknown level takes the value that makes its samples likeliest
    for k in range(len(KINDS)):
        mine = ~data.known & (data.kind == k)
        if mine.any() and (best := float(loss_terms(loss, z[mine])[0].mean())) > 0:
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
