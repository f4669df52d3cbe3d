"""The shipped mission `box`, from start to home: what a builder flies first."""

import math
from dataclasses import replace

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array
from hypertuna.mission.flight import fly, outcome


@pytest.mark.parametrize(("air", "seed"), [(86325.0, 0), (102325.0, 3), (105325.0, 0)])
def test_the_box_is_done_in_any_weather_without_a_release(air: float, seed: int) -> None:
    """From a mountain lake to high weather at the sea: without a surface zero it failed beyond 8 hPa.

    With seed 3 the robot once dived with a position error of nearly the radius: two waypoints, and time was up.
    A turn adds 8 and 12 deg of bias to beats of 16 and 25: once, pressure passed the hard limit and ended the box.
    """
    box, robot = ht.read_mission("box"), ht.load("hypertuna")
    flight = fly(replace(box, mission=replace(box.mission, air_pressure=air)), robot, seed=seed)
    assert flight.status == "done"
    assert outcome(flight).waypoints_reached == 4
    assert robot.controller is not None
    assert "tail_lost" not in flight.record.first_reasons
    assert flight.record.data["pump_pressure"].max() < robot.controller.pressure_hard
    deep = flight.record.data["mode"] == 1
    error = flight.record.data["depth_estimated"] - flight.record.depth
    assert abs(error[deep]).max() < 0.1
    assert flight.record.depth[-1] < 0.12 + 0.1  # at the surface, as far as the zero is known


def test_a_stated_declination_turns_the_compass() -> None:
    """At 10 deg west the box was missed by 16.6 m: the pilot took magnetic north for true north."""
    box, west = ht.read_mission("box"), math.radians(-10)
    for told, error in ((west, 0.0), (0.0, 10.0)):
        mission = replace(box.mission, field_declination=west, declination=told)
        record = fly(replace(box, mission=mission), ht.load("hypertuna"), duration=40.0).record
        seen, true = (_azimuth(record.data[name]) for name in ("attitude_estimated", "attitude"))
        assert math.degrees(np.median((seen - true)[100:])) == pytest.approx(error, abs=2.0)


def _azimuth(attitude: Array) -> Array:
    """Return where the head points, clockwise from north [rad], of quaternions (T, 4)."""
    w, x, y, z = attitude.T
    return np.unwrap(np.arctan2(-(1 - 2 * (y * y + z * z)), -2 * (x * y + w * z)))
