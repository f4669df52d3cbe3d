"""Where the fish is before anything is known of it: from the pixels of a connected part, in both directions."""

from __future__ import annotations

import numpy as np

from hypertuna.arrays import Array
from hypertuna.film.sections import Body


def guesses(body: Body, places: Array, contrast: float) -> list[Array]:
    """Return unknowns of a bent body over places (n, 2) [m], its nose at either end."""
    center = places.mean(axis=0)
    away = places - center
    _, vectors = np.linalg.eigh(away.T @ away)
    half = np.sqrt(body.section[:, 0])
    middle = float((half * body.stations).sum() / half.sum())  # distance of the area's center from the nose
    return [_along(body, away, center, sign * vectors[:, 1], middle, contrast) for sign in (1.0, -1.0)]


def _along(body: Body, away: Array, center: Array, axis: Array, middle: float, contrast: float) -> Array:
    """Return unknowns of a body along an axis from nose to tail, bent as a parabola through the places."""
    normal = np.array([-axis[1], axis[0]])
    along, across = away @ axis + middle, away @ normal
    line = np.polynomial.Polynomial.fit(along, across, 2)
    ends = np.append(0.0, np.cumsum(body.length))
    heading = np.arctan2(axis[1], axis[0]) + np.arctan(line.deriv()((ends[1:] + ends[:-1]) / 2))
    matrix = np.column_stack([np.ones(len(body.length)), body.share])
    turn = np.linalg.lstsq(matrix, heading, rcond=None)[0]
    nose = center - middle * axis + line(0.0) * normal
    return np.concatenate([nose, turn, [0.0, 0.0, contrast]])
