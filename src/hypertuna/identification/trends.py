"""Trends of residuals with frequency, amplitude or speed, and the coefficient that would take them."""

from collections.abc import Sequence
from itertools import permutations
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.coefficients import Free, column_of
from hypertuna.identification.experiment import KINDS, Experiment, experiment
from hypertuna.identification.names import COMMON, NUISANCES, Names, default_bounds
from hypertuna.identification.prediction import Prediction, predict
from hypertuna.trials.reach import motions_of

# Fixed before any data were seen: the usual level, divided by the number of tests (Bonferroni).
LEVEL = 0.05  # probability of a warning where residuals go with nothing
MIN_VALUES = 6  # runs or recordings: with 5, no order is rarer than 1 in 60, and three tests need 1 in 60
EXACT, SHUFFLES = 8, 9999  # runs up to which all orders are tried, and random orders beyond
TAKES = 0.25  # of the squared errors that a coefficient must explain to be named


def trend_warnings(data: Experiment, values: Array, prediction: Prediction, seed: int) -> list[str]:
    """Write a warning for each of frequency, amplitude and speed with which errors of the speed rise or fall."""
    rows, motions = _speed_errors(data), motions_of(data.trials)
    kept = [k for k, row in enumerate(rows) if row and "speed" in motions[k]]
    if len(kept) < MIN_VALUES:
        return []
    matrix = _sparse([rows[k] for k in kept], len(data.sample))
    error = matrix @ (prediction.computed - data.measured)
    given = {name: np.array([motions[k][name] for k in kept]) for name in ("frequency", "amplitude", "speed")}
    tested = {name: x for name, x in given.items() if np.ptp(x) > 1e-6 * np.abs(x).max()}
    sentences = []
    for name, x in tested.items():
        rho, p = rank_correlation(x, error, seed)
        if p < LEVEL / len(tested):
            goes = "rises" if rho > 0 else "falls"
            sentences.append(
                f"The error of the speed {goes} with {name} (rank correlation {rho:.2f} of {len(kept)} motions, "
                f"p = {p:.1g}, below {LEVEL:g} / {len(tested)} tests): {_taker(data, values, matrix, error)}."
            )
    return sentences


def rank_correlation(x: Array, y: Array, seed: int) -> tuple[float, float]:
    """Return Spearman's rank correlation and its two-sided p-value under all orders, or 9999 random ones."""
    from scipy.stats import rankdata  # imported here: slow to import

    a, b = rankdata(x) - (len(x) + 1) / 2, rankdata(y) - (len(y) + 1) / 2
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    if size == 0:
        return 0.0, 1.0
    rho = float(a @ b) / size
    if len(x) <= EXACT:
        orders = np.array(list(permutations(b.tolist())))
        return rho, float(np.mean(np.abs(orders @ a) >= (abs(rho) - 1e-12) * size))
    rng = np.random.default_rng(seed)
    count = sum(abs(float(rng.permutation(b) @ a)) >= (abs(rho) - 1e-12) * size for _ in range(SHUFFLES))
    return rho, (1 + count) / (1 + SHUFFLES)


def _speed_errors(data: Experiment) -> list[dict[int, float]]:
    """Return for each steady run and recording what makes a relative error of speed of elements' errors, if anything.

    Weights by element: a row of all elements would take memory by the square of the runs.
    """
    kinds, runs = data.kind[data.sample], data.run[data.sample]
    first = len(data.trials.steady)
    rows: list[dict[int, float]] = [{} for _ in range(first)]
    for own in np.flatnonzero((kinds == 0) & (data.measured != 0)).tolist():
        rows[runs[own]] = {own: 1 / data.measured[own]}
    for recording in data.recordings:
        row: dict[int, float] = {}
        for run in range(first, first + recording.runs):
            # along the net displacement: the error of the last frame over its distance from the start
            last = [np.flatnonzero((kinds == KINDS.index(axis)) & (runs == run))[-1] for axis in ("x", "y")]
            distance = max(float(np.sum(data.measured[last] ** 2)), 1e-300)
            row |= {k: data.measured[k] / distance / recording.runs for k in last}
        rows.append(row)
        first += recording.runs
    return rows


def _sparse(rows: Sequence[dict[int, float]], columns: int) -> Any:
    """Return rows of few weights as a sparse matrix."""
    from scipy.sparse import csr_array  # imported here: slow to import

    place = [k for k, row in enumerate(rows) for _ in row], [k for row in rows for k in row]
    return csr_array(([weight for row in rows for weight in row.values()], place), shape=(len(rows), columns))


def _taker(data: Experiment, values: Array, matrix: Any, error: Array) -> str:
    """Name the coefficient that is not free which would take most of the errors."""
    candidates = _candidates(data)
    if not candidates:
        return "no coefficient of the water law is left to free"
    more = experiment(data.robot, data.trials, (*data.free, *candidates), steps=data.steps, threads=data.threads)
    start = np.append(values, [one.start for one in candidates])
    by = matrix @ predict(more, start, gradient_steps=data.steps).jacobian
    known = np.linalg.qr(by[:, : len(data.free)])[0]
    rest = error - known @ (known.T @ error)
    best, share = None, 0.0
    for one, column in zip(candidates, by[:, len(data.free) :].T, strict=True):
        free = column - known @ (known.T @ column)
        size = float(free @ free)
        step = -float(free @ rest) / size if size > 1e-18 else 0.0
        if (step > 0 or (step < 0 and one.start > one.lower)) and step**2 * size > share * float(rest @ rest):
            best, share = one, step**2 * size / float(rest @ rest)
    if best is None or share < TAKES:
        return f"no coefficient that is not free would take more than {100 * TAKES:.0f} % of it"
    return f"{best.name} would take {100 * share:.0f} % of the squared errors; free it"


def _candidates(data: Experiment) -> Sequence[Free]:
    """Return the water law's columns that are not free, each as one factor, or one value where all are 0."""
    law, taken = data.robot.model.water, {f.column for f in data.free}
    known = Names(data.robot).known
    found = []
    for column, count in known.items():
        own = column.startswith(f"water.{law}.") or (
            column == "joints.bandwidth" and data.robot.model.joints != "ideal"
        )
        if not own or column in taken | NUISANCES.keys() or column not in default_bounds()["coefficient"]:
            continue
        present, table = [float(x) for x in column_of(data.robot, column)], default_bounds()["coefficient"][column]
        index = f"[0-{count - 1}]" if count > 1 else ""
        if any(present):
            found.append(Free(column + index + COMMON, 0.0, table["upper"] / max(present), 1.0))
        else:
            found.append(Free(column + index, table["lower"], table["upper"], 0.0))
    return found
