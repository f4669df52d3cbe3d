"""Volume ratio J of the matrix of a bent joint, by parts of its volume."""

from __future__ import annotations

from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.fe.model import FeModel

KEPT = 0.02  # a volume counts as unchanged where J differs from 1 by less
LEAST = 1e-3  # part of the volume below "low" and above "high" of `volume_kept`


def volume_ratios(model: FeModel) -> tuple[Array, Array, Array]:
    """Return J, volume at rest [m^3] and place (n, 3) [m] at points farther than a hose's diameter from both plates."""
    import ngsolve as ngs

    rule = ngs.IntegrationRule(ngs.TET, 2 * model.options.size.order)
    points = model.mesh.MapToAllElements(rule, model.mesh.Materials("matrix"))
    ratio = np.asarray(ngs.Det(ngs.Id(3) + ngs.Grad(model.displacement))(points)).ravel()
    size = np.asarray(ngs.Det(ngs.specialcf.JacobianMatrix(3))(points)).ravel()
    weight = size * np.tile(np.array(rule.weights), len(size) // len(rule.weights))
    place = np.column_stack([np.asarray(axis(points)).ravel() for axis in (ngs.x, ngs.y, ngs.z)])
    away = 2 * model.wall.outer
    inside = (place[:, 0] > away) & (place[:, 0] < model.body.length - away)
    return ratio[inside], weight[inside], place[inside]


def volume_kept(model: FeModel) -> dict[str, Any]:
    """Return extremes and 0.1 % quantiles of J away from the plates, and which part of the volume changed.

    `at_hose` is the distance of the largest difference from the nearest channel's axis, over the radius [1].
    """
    ratio, weight, place = volume_ratios(model)
    order = np.argsort(ratio)
    below = np.cumsum(weight[order]) / weight.sum()
    low, high = (float(ratio[order][np.searchsorted(below, part)]) for part in (LEAST, 1 - LEAST))
    _, y, z = place[np.abs(ratio - 1).argmax()]
    near = min(np.hypot(y - channel.y, z - channel.z) for channel in model.body.upper) / model.wall.outer
    return {
        "min": float(ratio.min()),
        "low": low,
        "high": high,
        "max": float(ratio.max()),
        "not_kept_percent": 100 * float(weight[np.abs(ratio - 1) > KEPT].sum() / weight.sum()),
        "at_hose": float(near),
    }
