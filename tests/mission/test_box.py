"""The shipped mission `box`, from start to home: what a builder flies first."""

import hypertuna as ht
from hypertuna.mission.flight import fly, outcome


def test_the_box_is_done_without_a_release() -> None:
    """A turn adds 8 and 12 deg of bias to beats of 16 and 25: once, pressure passed the hard limit and ended it."""
    flight = fly(ht.read_mission("box"), ht.load("hypertuna"))
    assert flight.status == "done"
    assert outcome(flight).waypoints_reached == 4
    assert "tail_lost" not in flight.record.first_reasons
    assert flight.record.data["pump_pressure"].max() < 270e3
