"""Convert between latitude and longitude and positions east and north of an origin, on WGS 84."""

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.arrays import Array

MAX_DISTANCE = 100e3  # m from the origin
HEIGHT_ITERATIONS = 5  # each leaves (distance / Earth's radius)^2 = 2e-4 of the height's error at 100 km


def to_local(origin: tuple[float, float], latitude: ArrayLike, longitude: ArrayLike) -> Array:
    """Return east and north (..., 2) [m] of an origin in its tangent plane; origin, latitude, longitude [rad]."""
    import pymap3d

    place = pymap3d.geodetic2enu(
        np.asarray(latitude, float), np.asarray(longitude, float), 0.0, *origin, 0.0, deg=False
    )
    return np.stack(place[:2], axis=-1)


def from_local(origin: tuple[float, float], place: ArrayLike) -> Array:
    """Return latitude and longitude (..., 2) [rad] of places (..., 2) [m] on the ellipsoid: inverse of `to_local`."""
    import pymap3d

    east, north = np.moveaxis(np.asarray(place, dtype=np.float64), -1, 0)
    up = np.zeros_like(east)
    for _ in range(HEIGHT_ITERATIONS):  # the surface lies below the tangent plane
        latitude, longitude, height = pymap3d.enu2geodetic(east, north, up, *origin, 0.0, deg=False)
        up = up - height
    # pymap3d returns numbers for arrays of one place
    return np.stack([np.reshape(angle, east.shape) for angle in (latitude, longitude)], axis=-1)
