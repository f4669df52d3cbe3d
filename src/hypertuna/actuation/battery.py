"""Energy: battery, range and endurance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.metrics import cost_of_transport

__all__ = ["BatteryColumns", "Range", "battery_columns", "range_of"]

Array = NDArray[np.float64]

POINTS = 32  # of Gauss and Legendre over the charge: voltage and current are smooth


@dataclass(frozen=True)
class BatteryColumns:
    """The battery of a robot as the core takes it."""

    columns: tuple[str, ...]  # As `core/include/hypertuna/actuation/battery.hpp` names them
    values: Array  # (columns,) SI units


def battery_columns(robot: Robot) -> BatteryColumns:
    """Describe the battery of a robot to the core."""
    battery = robot.battery
    if battery is None or battery.series is None:
        key, fix = ("battery", "add the table [battery]") if battery is None else ("battery.series", "give that number")
        raise InputError("is needed for the energy", file=robot.file or None, key=key, fix=fix)
    strings = battery.cells // battery.series
    charged = battery.voltage if battery.charged is None else battery.charged
    row = {
        "charge": strings * battery.capacity,
        "full": battery.series * charged,
        "empty": battery.series * (2 * battery.voltage - charged),
        "resistance": battery.resistance * battery.series / strings,
        "converter": math.inf if battery.converter is None else battery.converter,
        "efficiency": battery.efficiency,
    }
    columns = tuple(_core.battery_columns())
    return BatteryColumns(columns, np.array([row[name] for name in columns], dtype=np.float64))


@dataclass(frozen=True)
class Range:
    """How far and how long a robot swims on one charge."""

    power: float  # Of the servos [W]; through the water [m/s]
    speed: float
    cost_of_transport: float  # P / (m |U|), Eq. 38 with the mass of the whole robot in it [J/(kg m)]
    reserve: float  # Part of the usable charge that is kept [1]
    energy: float  # All cells' capacity at their nominal voltage [J]
    nominal_range: float  # All of that at the servos: no reserve, nothing lost [m, s]
    nominal_endurance: float
    given: float  # Energy that reaches the servos of the usable charge less the reserve [J]
    range: float  # With that [m, s]
    endurance: float
    voltage: tuple[float, float]  # Of the battery under load, at the start and at the end [V]
    supply: float  # Lowest voltage at the servos [V]


def range_of(robot: Robot, *, power: float, speed: float, reserve: float = 0.0) -> Range:
    """Return range and endurance at a steady power and speed: `power` [W], `speed` [m/s]."""
    for key, value, unit in (("power", power, "W"), ("speed", speed, "m/s")):
        if not 0 < abs(value) < math.inf or (key == "power" and value < 0):
            raise InputError("must be greater than 0", key=key, value=f"{value:g}", fix=f"give it in {unit}")
    if not 0 <= reserve < 1:
        fix = "give the part of the charge that is kept, such as 0.1"
        raise InputError("must be from 0 to less than 1", key="reserve", value=f"{reserve:g}", fix=fix)
    columns = battery_columns(robot)
    battery = robot.battery
    assert battery is not None  # or there were no columns
    charge = dict(zip(columns.columns, columns.values.tolist(), strict=True))["charge"]
    taken = battery.usable * (1 - reserve) * charge * (np.polynomial.legendre.leggauss(POINTS)[0] + 1) / 2
    ends = np.array([0.0, battery.usable * (1 - reserve) * charge])
    at = _core.battery_output(columns.values, taken, np.full(POINTS, power))
    edge = _core.battery_output(columns.values, ends, np.full(2, power))
    if (edge[:, 0] * edge[:, 1] * battery.efficiency < power * (1 - 1e-9)).any():
        most = float((edge[:, 0] * edge[:, 1]).min() * battery.efficiency)
        raise InputError(
            f"must be at most {most:.4g}, which is all that the battery can give at its inner resistance",
            key="power",
            value=f"{power:g}",
            fix="give the mean power in W",
        )
    # Time passes at 1 / current for each charge taken: Gauss-Legendre over the charge.
    weights = np.polynomial.legendre.leggauss(POINTS)[1] * ends[1] / 2
    endurance = float((weights / at[:, 1]).sum())
    energy = battery.cells * battery.capacity * battery.voltage
    return Range(
        power=power,
        speed=speed,
        cost_of_transport=float(cost_of_transport(power, robot.body.mass, speed)),
        reserve=reserve,
        energy=energy,
        nominal_range=abs(speed) * energy / power,
        nominal_endurance=energy / power,
        given=power * endurance,
        range=abs(speed) * endurance,
        endurance=endurance,
        voltage=(float(edge[0, 0]), float(edge[1, 0])),
        supply=float(edge[:, 2].min()),
    )
