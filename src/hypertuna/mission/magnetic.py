"""Declination of the Earth's magnetic field at a place, from the World Magnetic Model."""

import math
from datetime import UTC, date, datetime
from typing import Any

from hypertuna.errors import InputError
from hypertuna.io.extras import need


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
