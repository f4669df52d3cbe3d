"""Weather of a mission: what air, field and water do to the sensors' readings, taken where a board would take them."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array
from hypertuna.control.mission import Mission
from hypertuna.errors import InputError
from hypertuna.mission.file import _joined, parse_mission
from hypertuna.mission.run import fly_part, mission_start
from hypertuna.simulation.sea import DIP

PULSE = 1500e-6  # s: all servos at neutral
AFLOAT = Mission((), heading=-math.pi / 2)  # at the surface, facing north


@pytest.fixture(scope="module")
def robot() -> ht.Robot:
    return ht.load("hypertuna")


def readings(robot: ht.Robot, mission: Mission, *, ticks: int = 100, **options: Any) -> list[Array]:
    """Readings that a board gets which does nothing, of a robot that someone holds at the surface."""
    got: list[Array] = []

    def board(sensors: list[float], antenna: float) -> list[float]:
        got.append(np.array(sensors))
        return [PULSE] * (2 * len(robot.joints) + 2)

    start = mission_start(robot, mission, seed=1, released=1e5, **options)
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
    """Facing north, aft is south; the sensor's errors are the same at any field."""
    plain = mean(robot, AFLOAT, "field")
    for declination, dip in ((math.radians(10), math.radians(60)), (-0.2, math.radians(72))):
        flat = np.array([-math.cos(dip) * math.cos(declination), math.cos(dip) * math.sin(declination)])
        wanted = np.array([*flat, -math.sin(dip)]) - [-math.cos(DIP), 0.0, -math.sin(DIP)]
        got = mean(robot, replace(AFLOAT, field_declination=declination, dip=dip), "field") - plain
        assert got == pytest.approx(wanted, abs=2e-3)


def fixes(robot: ht.Robot, mission: Mission, *, ticks: int, **options: Any) -> list[int]:
    """Ticks of the fixes that a board gets."""
    rows = readings(robot, mission, ticks=ticks, **options)
    count = min(len(row) for row in rows)
    return [tick for tick, row in enumerate(rows) if len(row) > count]


def test_a_cold_receiver_takes_half_a_minute_to_a_minute(robot: ht.Robot) -> None:
    assert fixes(robot, AFLOAT, ticks=300) == [0, 100, 200]
    (first, *_) = fixes(robot, replace(AFLOAT, cold=True), ticks=6200)
    assert 3000 <= first <= 6100


def test_a_receiver_restarts_with_its_power_and_after_a_gap(robot: ht.Robot) -> None:
    restarted = fixes(robot, AFLOAT, ticks=1200, resets=(3.5,))
    assert restarted[:4] == [0, 100, 200, 300]
    assert 450 <= restarted[4] <= 900  # 1 to 5 s
    gap = fixes(robot, replace(AFLOAT, gaps=((2.5, 62.5),)), ticks=7000)
    assert gap[:3] == [0, 100, 200]
    assert 6350 <= gap[3] <= 6800


def test_the_keys_of_weather_and_receiver() -> None:
    place = {"x_m": 0.0, "y_m": 0.0}
    document: dict[str, Any] = {
        "format": 1,
        "name": "weather",
        "start": place | {"heading_deg": 0.0},
        "waypoints": [place | {"speed_m_s": 0.3, "radius_m": 1.0}],
    }
    calm = parse_mission(document).mission
    assert (calm.air_pressure, calm.tide, calm.gust, calm.cold, calm.jump_every) == (101325, (0, 0), (0, 0), False, 0)
    assert calm.dip == pytest.approx(math.radians(60))
    origin = {"latitude_deg": 50.0, "longitude_deg": 9.0, "declination_deg": 4.0}
    assert parse_mission(document | {"origin": origin}).mission.field_declination == pytest.approx(math.radians(4))
    weather = {"air_pressure_pa": 98.9e3, "dip_deg": 70.0, "declination_deg": -10.0, "tide_m_s": 0.2, "tide_deg": 90.0}
    weather |= {"tide_period_s": 600.0, "gust_m_s": 0.1, "gust_deg": 180.0, "gust_depth_m": 2.0, "gust_time_s": 5.0}
    receiver = {"cold": True, "jump_m": 20.0, "jump_every_s": 60.0, "jump_told": False}
    rough = parse_mission(document | {"weather": weather, "gps": receiver}).mission
    assert (rough.air_pressure, rough.tide_period, rough.gust_depth, rough.gust_time) == (98.9e3, 600, 2, 5)
    assert rough.field_declination == pytest.approx(math.radians(-10))
    assert rough.tide == pytest.approx((0.2, 0))
    assert rough.gust == pytest.approx((0, -0.1))
    assert (rough.cold, rough.jump, rough.jump_every, rough.jump_told) == (True, 20, 60, False)
    for table, key, value in (("weather", "air_pressure_pa", 980.0), ("weather", "gust_time_s", 0.0)):
        with pytest.raises(InputError, match=rf"{table}\.{key} must be"):
            parse_mission(document | {table: {key: value}})


def test_a_robot_is_held_until_it_is_released(robot: ht.Robot) -> None:
    """Held it reads gravity and stays; released it falls in, for its antenna was out of the water."""
    heights: list[float] = []

    def board(_: list[float], antenna: float) -> list[float]:
        heights.append(antenna)
        return [PULSE] * (2 * len(robot.joints) + 2)

    start = mission_start(robot, AFLOAT, seed=1, released=1.0)
    record, _ = fly_part(replace(start, core=start.core | {"board": board, "every": 1}), 200)
    assert np.ptp(heights[:101]) == 0
    assert heights[0] == pytest.approx(0.086, abs=1e-3)
    assert heights[-1] < -0.1
    assert record["acceleration_measured"][50:100].mean(axis=0) == pytest.approx([0, 0, 9.81], abs=0.1)


def test_gaps_that_meet_are_one() -> None:
    assert _joined([(0, 1), (1, 2), (3, 3), (4, 6), (5, 5.5)]) == ((0, 2), (4, 6))
    assert _joined([(0, 1), (1.5, 2)]) == ((0, 1), (1.5, 2))
