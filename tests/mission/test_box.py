"""The shipped mission `box`, from start to home: what a builder flies first."""

from dataclasses import replace

import pytest

import hypertuna as ht
from hypertuna.mission.flight import fly, outcome


def test_the_box_is_done_without_a_release() -> None:
    """A turn adds 8 and 12 deg of bias to beats of 16 and 25: once, pressure passed the hard limit and ended it."""
    flight = fly(ht.read_mission("box"), ht.load("hypertuna"))
    assert flight.status == "done"
    assert outcome(flight).waypoints_reached == 4
    assert "tail_lost" not in flight.record.first_reasons
    assert flight.record.data["pump_pressure"].max() < 270e3


@pytest.mark.parametrize("air", [86325.0, 102325.0, 105325.0])
def test_the_box_is_done_in_any_weather(air: float) -> None:
    """From a mountain lake to high weather at the sea: without a surface zero it failed beyond 8 hPa."""
    box = ht.read_mission("box")
    flight = fly(replace(box, mission=replace(box.mission, air_pressure=air)), ht.load("hypertuna"))
    assert flight.status == "done"
    assert outcome(flight).waypoints_reached == 4
    deep = flight.record.data["mode"] == 1
    error = flight.record.data["depth_estimated"] - flight.record.depth
    assert abs(error[deep]).max() < 0.1
    assert flight.record.depth[-1] < 0.12
