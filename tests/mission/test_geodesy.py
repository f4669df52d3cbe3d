"""Declination by the World Magnetic Model."""

import math
import sys
from datetime import date

import pytest

from hypertuna.errors import InputError
from hypertuna.mission.file import read_mission
from hypertuna.mission.geodesy import declination


def test_a_value_of_the_report_on_the_model() -> None:
    """80 deg north, 0 deg east, 2025.0: 1.28 deg (NOAA and BGS, The US/UK World Magnetic Model for 2025-2030)."""
    found = declination((math.radians(80), 0.0), date(2025, 1, 1))
    assert math.degrees(found) == pytest.approx(1.28, abs=0.005)


def test_the_lake() -> None:
    lake = read_mission("lake")
    assert lake.declination is None
    assert math.degrees(declination(lake.origin, date(2026, 11, 25))) == pytest.approx(-10.6, abs=0.1)


def test_the_year_is_that_of_the_day() -> None:
    """The model is linear in time within its five years: each day changes as much, also from one year to the next."""
    days = [date(2026, 1, 1), date(2026, 12, 31), date(2027, 1, 1)]
    first, last, next_year = (declination((math.radians(80), 0.0), day) for day in days)
    assert next_year - last == pytest.approx((last - first) / 364, rel=0.3)  # 365 days, or 366, are a year of 365.25


def test_a_day_beyond_the_model_is_refused() -> None:
    with pytest.raises(InputError, match="must be from 2025 to 2030"):
        declination((0.7, 2.0), date(2031, 1, 1))


def test_without_the_package_the_command_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygeomag", None)
    monkeypatch.setattr("hypertuna.io.extras.find_spec", lambda name: None)
    with pytest.raises(InputError, match="pygeomag is needed by the declination"):
        declination((0.7, 2.0))
