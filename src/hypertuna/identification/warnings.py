"""What a reader of a fit should not overlook, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hypertuna.identification.coefficients import Free, column_of
from hypertuna.identification.names import NUISANCES
from hypertuna.identification.prediction import Experiment
from hypertuna.identification.uncertainty import Certainty
from hypertuna.trials.trials import Trials

__all__ = ["repeated", "warnings_of"]

Array = NDArray[np.float64]

SAME = 1e-6  # of the largest: values of one coefficient that differ by less are one value


def warnings_of(
    data: Experiment,
    frees: Sequence[Free],
    values: Array,
    sure: Certainty,
    failed: NDArray[np.bool_],
    unstable: NDArray[np.bool_],
) -> list[str]:
    """Say what a reader of a fit should not overlook.

    Parameters
    ----------
    data : Experiment
    frees : sequence of Free
    values : ndarray, shape (coefficients,)
        That were fitted.
    sure : Certainty
    failed, unstable : ndarray of bool, shape (runs,)
        Which runs have no settled beat with these values, or one that does not last.

    Returns
    -------
    list of str
        Sentences.
    """
    told = []
    for f in frees:
        if f.column not in NUISANCES:
            before = np.array(column_of(data.robot, f.column), dtype=float)[list(f.indices)]
            if np.ptp(before) > SAME * np.abs(before).max():
                ends = f"{_shown(before.min(), f)} to {_shown(before.max(), f)}"
                told.append(f"{f.name} is one value in place of several, {ends}.")
    for f, value, bound in zip(frees, values, sure.bound, strict=True):
        if bound:
            told.append(f"{f.name} sits on its {bound} bound, {_shown(value, f)}: the runs would have it further.")
    samples = len(data.kind)
    if samples <= len(frees):
        told.append(
            f"There {_counted(len(frees), 'free coefficient')} and {samples} independent "
            f"measurement{'s' * (samples > 1)}: "
            "the runs can be met exactly, so neither noise nor intervals can be told from them."
        )
    for flags, what in ((failed, "have no settled beat"), (unstable, "are periodic but unstable")):
        if flags.any():
            names = [data.trials.runs[k] for k in np.flatnonzero(flags)]
            more = f" and {len(names) - 5} more" if len(names) > 5 else ""
            told.append(f"With the fitted values these runs {what}: {', '.join(names[:5])}{more}.")
    if sure.excess > 1.5 and not data.unknown_kinds:
        told.append(
            f"Residuals are {sure.excess:.2g} times what the stated noise explains: the model cannot meet all runs "
            "with these coefficients, or the noise is understated. The intervals allow for it."
        )
    if all(d.determined for d in sure.directions):
        return told
    told.append("The runs leave some coefficients open: see the directions that are not determined.")
    return told


def _shown(value: float, coefficient: Free) -> str:
    """Write a value with its unit, if it has one; angles in degrees."""
    if coefficient.unit == "rad":
        return f"{np.degrees(value):.4g} deg"
    return f"{value:.4g} {coefficient.unit}".removesuffix(" 1")


def _counted(count: int, noun: str) -> str:
    """Say how many there are."""
    return f"are {count} {noun}s" if count != 1 else f"is 1 {noun}"


def repeated(training: Trials, validation: Trials) -> list[str]:
    """Say where the runs for validation repeat motions that were trained on.

    Parameters
    ----------
    training, validation : Trials

    Returns
    -------
    list of str
        Sentences.
    """
    recordings = [one.name for one in validation.recordings if one.name in {two.name for two in training.recordings}]
    gaits = {run.gait for run in training.steady}
    told = []
    if recordings:
        told.append(
            f"The validation runs of {', '.join(recordings)} repeat joint motions that were fitted: they tell "
            "noise from model, but not how well other motions are predicted. Fit one recording and replay another "
            "to see that."
        )
    if count := sum(run.gait in gaits for run in validation.steady):
        told.append(f"{count} of {len(validation.steady)} steady runs for validation repeat gaits that were fitted.")
    return told
