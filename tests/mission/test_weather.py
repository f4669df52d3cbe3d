"""Weather of a mission: what air, field and water do to the sensors' readings, taken where a board would take them."""

import math
from dataclasses import replace

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array
from hypertuna.control.mission import Mission
from hypertuna.mission.run import fly_part, mission_start

PULSE = 1500e-6  # s: all servos at neutral
AFLOAT = Mission((), heading=-math.pi / 2)  # at the surface, facing north


@pytest.fixture(scope="module")
def robot() -> ht.Robot:
    return ht.load("hypertuna")


def readings(robot: ht.Robot, mission: Mission, *, ticks: int = 100, seed: int = 1) -> list[Array]:
    """Readings that a board gets which does nothing."""
    got: list[Array] = []

    def board(sensors: list[float]) -> list[float]:
        got.append(np.array(sensors))
        return [PULSE] * (2 * len(robot.joints) + 2)

    start = mission_start(robot, mission, seed=seed)
    fly_part(replace(start, core=start.core | {"board": board}), ticks)
    return got


def mean(robot: ht.Robot, mission: Mission, sensor: str) -> Array:
    """Mean reading (depth: 1, field: 3); the two come last but for fixes, of which the first tick has none to give."""
    rows = readings(robot, mission)
    count = min(len(row) for row in rows)
    first = {"depth": -4, "field": -3}[sensor]
    values = np.array([row[:count] for row in rows])[:, count + first :]
    result: Array = values[:, : 1 if sensor == "depth" else 3].mean(axis=0)
    return result


def test_depth_sensors_read_the_air_too(robot: ht.Robot) -> None:
    """24 hPa below the standard atmosphere are 0.245 m of fresh water; the sensors' errors are the same in both."""
    standard = mean(robot, AFLOAT, "depth")
    low = mean(robot, replace(AFLOAT, air_pressure=101325.0 - 2400), "depth")
    assert low - standard == pytest.approx(-2400 / (robot.water.density * 9.81), abs=2e-3)  # a step of the sensor


def test_the_field_points_where_the_declination_says(robot: ht.Robot) -> None:
    """Facing north with a declination of 10 deg east, the field's horizontal part is 10 deg to starboard."""
    for declination, dip in ((0.0, math.radians(60)), (math.radians(10), math.radians(60)), (-0.2, math.radians(72))):
        mission = replace(AFLOAT, field_declination=declination, dip=dip)
        aft, starboard, up = mean(robot, mission, "field")
        assert math.atan2(starboard, -aft) == pytest.approx(declination, abs=0.03)
        assert math.atan2(-up, math.hypot(aft, starboard)) == pytest.approx(dip, abs=0.03)
