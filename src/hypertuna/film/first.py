"""First guesses of the fish's pose from a connected part of the picture, with the nose at either end."""

from __future__ import annotations

import numpy as np

from hypertuna.arrays import Array
from hypertuna.film.sections import Body


def guesses(body: Body, places: Array, contrast: float) -> list[Array]:
    """Return two guesses of a body's unknowns from the places (n, 2) [m] of its pixels, with the nose at either end."""
    center = places.mean(axis=0)
    centered = places - center
    _, vectors = np.linalg.eigh(centered.T @ centered)
    half = np.sqrt(body.section[:, 0])
    from_nose = float((half * body.stations).sum() / half.sum())  # distance of the area's center from the nose
    return [_guess(body, centered, center, sign * vectors[:, 1], from_nose, contrast) for sign in (1.0, -1.0)]


def _guess(body: Body, centered: Array, center: Array, axis: Array, middle: float, contrast: float) -> Array:
    """Guess a body's unknowns from its pixels (n, 2) [m] about their center: its links follow a fitted parabola.

    axis: unit vector from nose to tail; middle: distance from the nose to the center [m].
    """
    normal = np.array([-axis[1], axis[0]])
    along, across = centered @ axis + middle, centered @ normal
    parabola = np.polynomial.Polynomial.fit(along, across, 2)
    ends = np.append(0.0, np.cumsum(body.length))
    heading = np.arctan2(axis[1], axis[0]) + np.arctan(parabola.deriv()((ends[1:] + ends[:-1]) / 2))
    matrix = np.column_stack([np.ones(len(body.length)), body.share])
    turn = np.linalg.lstsq(matrix, heading, rcond=None)[0]
    nose = center - middle * axis + parabola(0.0) * normal
    return np.concatenate([nose, turn, [0.0, 0.0, contrast]])
