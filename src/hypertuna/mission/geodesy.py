"""Positions on the Earth: latitude and longitude against east and north of an origin, exactly, on WGS 84."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["FARTHEST", "from_local", "to_local"]

Array = NDArray[np.float64]

SEMI_MAJOR, FLATTENING = 6378137.0, 1 / 298.257223563  # WGS 84 (NIMA TR 8350.2)
SQUARE = FLATTENING * (2 - FLATTENING)  # of the eccentricity
FARTHEST = 100e3  # m from the origin that positions make sense at


def to_local(origin: tuple[float, float], latitude: ArrayLike, longitude: ArrayLike) -> Array:
    """Return east and north of an origin: the tangent plane of the ellipsoid there.

    `origin` [rad], `latitude`, `longitude` (...) [rad]; returns (..., 2) [m].
    """
    away = _centered(np.asarray(latitude, float), np.asarray(longitude, float)) - _centered(*map(np.asarray, origin))
    result: Array = away @ _axes(*origin).T
    return result


def from_local(origin: tuple[float, float], place: ArrayLike) -> Array:
    """Return latitude and longitude of places on the ellipsoid: the inverse of `to_local`.

    `origin` [rad], `place` (..., 2) [m]; returns (..., 2) [rad].
    """
    place = np.asarray(place, dtype=np.float64)
    east_north = _axes(*origin)
    up = np.cross(*east_north)
    across = np.array([1.0, 1.0, 1 - SQUARE])  # of the ellipsoid x^2 + y^2 + z^2 / (1 - e^2) = a^2
    plane = _centered(*map(np.asarray, origin)) + place @ east_north
    # The surface lies below the tangent plane: the nearer root of a quadratic in the height.
    a, half = (up**2 / across).sum(), (plane * up / across).sum(axis=-1)
    c = (plane**2 / across).sum(axis=-1) - SEMI_MAJOR**2
    height = -c / (half + np.sqrt(half**2 - a * c))
    x, y, z = np.moveaxis(plane + height[..., np.newaxis] * up, -1, 0)
    return np.stack([np.arctan2(z / (1 - SQUARE), np.hypot(x, y)), np.arctan2(y, x)], axis=-1)


def _centered(latitude: Array, longitude: Array) -> Array:
    """Return positions from the Earth's center."""
    prime = SEMI_MAJOR / np.sqrt(1 - SQUARE * np.sin(latitude) ** 2)  # radius of curvature across the meridian
    across = prime * np.cos(latitude)
    parts = (across * np.cos(longitude), across * np.sin(longitude), (1 - SQUARE) * prime * np.sin(latitude))
    return np.stack(parts, axis=-1)


def _axes(latitude: float, longitude: float) -> Array:
    """Return the unit vectors east and north."""
    east = (-math.sin(longitude), math.cos(longitude), 0.0)
    up = math.sin(latitude)
    north = (-up * math.cos(longitude), -up * math.sin(longitude), math.cos(latitude))
    return np.array([east, north])
