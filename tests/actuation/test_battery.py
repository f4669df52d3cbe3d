"""Energy: the battery's charge against energies by hand, range and endurance, the published arithmetic."""

from __future__ import annotations

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.battery import battery_columns, range_of
from hypertuna.description.robot import parse
from hypertuna.errors import InputError

FASTEST, LAKE = {"power": 22.45, "speed": 0.56}, {"power": 18.2, "speed": 800 / 1800}


def with_battery(robot: ht.Robot, **values: object) -> ht.Robot:
    """Return the robot with other values in its table battery; None removes one."""
    document = robot.document()
    battery = document["battery"] | values
    document["battery"] = {key: value for key, value in battery.items() if value is not None}
    document["sources"] = {}
    return parse(document, file="changed.toml")


LOSSLESS = {
    "resistance_ohm": 0.0,
    "usable": 1.0,
    "converter_v": None,
    "converter_efficiency": None,
    "electronics_w": 0.0,
}


def test_four_cells_carry_four_and_a_half_kilometers(tuna: ht.Robot) -> None:
    found = range_of(tuna, **FASTEST)
    assert found.cost_of_transport == pytest.approx(22.45 / (3.3 * 0.56))  # 12.15 J/(kg m): the mass is in it
    assert found.energy == pytest.approx(4 * 3.5 * 3600 * 3.6)  # 50.4 Wh
    assert found.nominal_range == pytest.approx(4526, abs=1)
    assert range_of(tuna, **LAKE).nominal_range == pytest.approx(4431, abs=1)
    # The published 21.12 km: 14 Ah x 16.8 V, the cells in parallel and in series at once.
    claimed = 14 * 3600 * 16.8 / 22.45 * 0.56
    assert claimed == pytest.approx(21120, rel=1e-3)


def test_battery_without_losses_gives_its_nominal_energy(tuna: ht.Robot) -> None:
    # The voltage falls straight from 4.2 to 3.0 V a cell: its mean over the charge is the nominal 3.6 V.
    found = range_of(with_battery(tuna, **LOSSLESS), **FASTEST)
    assert found.range == pytest.approx(found.nominal_range, rel=1e-12)
    assert found.voltage == pytest.approx((16.8, 12.0))
    half = range_of(with_battery(tuna, **LOSSLESS, charged_v=None), **FASTEST, reserve=0.5)
    assert half.endurance == pytest.approx(half.nominal_endurance / 2, rel=1e-12)


def test_endurance_against_stepping_through_time(tuna: ht.Robot) -> None:
    columns = np.array([*battery_columns(tuna).values()])
    taken, time, step = 0.0, 0.0, 20.0
    whole = 0.95 * 0.9 * 3.5 * 3600
    while taken < whole:  # Euler at the middle of each step
        current = _core.battery_output(columns, np.array([taken]), np.array([20.0]))[0, 1]
        middle = np.array([taken + current * step / 2])
        taken += step * _core.battery_output(columns, middle, np.array([20.0]))[0, 1]
        time += step
    found = range_of(tuna, power=20.0, speed=0.5, reserve=0.1)
    assert found.endurance == pytest.approx(time, abs=step)
    assert found.range == pytest.approx(0.5 * found.endurance)
    assert found.energy_at_servos == pytest.approx(20.0 * found.endurance)


def test_series_and_parallel_hold_the_same_energy(tuna: ht.Robot) -> None:
    rows = {}
    for series in (1, 2, 4):
        robot = with_battery(tuna, series=series, converter_v=None)
        rows[series] = battery_columns(robot)
        assert rows[series]["charge"] * series == pytest.approx(4 * 3.5 * 3600)
        # n in series of n^2-fold resistance between one string and four: the same sag in watts.
        assert rows[series]["resistance"] / series**2 == pytest.approx(0.035 / 4)
        assert range_of(robot, **FASTEST).range == pytest.approx(range_of(with_battery(tuna), **FASTEST).range)


def test_losses_and_reserve_shorten_the_range(tuna: ht.Robot) -> None:
    found = range_of(tuna, **FASTEST)
    assert found.range < found.nominal_range
    for values in ({"usable": 0.8}, {"converter_efficiency": 0.8}, {"resistance_ohm": 0.2}):
        assert range_of(with_battery(tuna, **values), **FASTEST).range < found.range
    # A fifth of the charge is less than a fifth of the way: the last part of it has the least voltage.
    assert 0.8 < range_of(tuna, **FASTEST, reserve=0.2).range / found.range < 0.85


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"power": -3.0}, "power must be greater than 0, but is -3"),
        ({"power": 0.0}, "power must be greater than 0"),
        ({"power": 900.0}, r"power must be at most 2\d\d\.?\d*, the battery's largest power"),
        ({"speed": 0.0}, "speed must be greater than 0"),
        ({"reserve": 1.0}, "reserve must be at least 0 and less than 1, but is 1"),
        ({"reserve": -0.1}, "reserve must be at least 0 and less than 1"),
        ({"reserve": float("nan")}, "reserve must be a finite number"),
    ],
)
def test_impossible_numbers_are_refused(tuna: ht.Robot, options: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        range_of(tuna, **(FASTEST | options))


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"series": 3}, "battery.series must divide cells = 4, but is 3"),
        ({"charged_v": 3.0}, "battery.charged_v must be at least voltage_v = 3.6, and less than twice that voltage"),
        ({"charged_v": 7.2}, "battery.charged_v must be at least voltage_v = 3.6, and less than twice that voltage"),
        ({"converter_efficiency": 0.0}, "battery.converter_efficiency must be greater than 0"),
    ],
)
def test_impossible_batteries_are_refused(tuna: ht.Robot, values: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        with_battery(tuna, **values)


def test_a_robot_without_a_battery_is_told_so(tuna: ht.Robot) -> None:
    with pytest.raises(InputError, match=r"rexeel.toml: battery is missing: add the table \[battery\]"):
        range_of(ht.load("rexeel"), **FASTEST)
    with pytest.raises(InputError, match=r"battery.series is missing"):
        range_of(with_battery(tuna, series=None), **FASTEST)
