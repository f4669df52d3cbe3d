"""Latitude and longitude from positions east and north of an origin, and back, on WGS 84; magnetic declination."""

import math
from datetime import UTC, date, datetime
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.extras import need

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


def declination(origin: tuple[float, float], day: date | None = None) -> float:
    """Return the declination [rad, east positive] at a latitude and longitude [rad], on a day (default: today)."""
    need("magnetic", "pygeomag", by="the declination of a mission that lacks origin.declination_deg")
    import pygeomag

    day = datetime.now(UTC).date() if day is None else day
    year = day.year + (day.timetuple().tm_yday - 1) / 365.25
    latitude, longitude = (math.degrees(angle) for angle in origin)
    model: Any = pygeomag.GeoMag()
    try:
        return math.radians(model.calculate(glat=latitude, glon=longitude, alt=0, time=year).d)
    except ValueError:  # outside the five years for which the model is valid
        first, last = model.life_span
        fix = "update pygeomag, or state origin.declination_deg in the mission file"
        rule = f"must be from {first:g} to {last:g}, for which the World Magnetic Model {model.model} holds"
        raise InputError(rule, key="date", value=f"{year:.1f}", fix=fix) from None
