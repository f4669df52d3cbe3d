"""Battery of a robot, and its range and endurance."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from hypertuna import _core
from hypertuna.description.robot import Robot, require
from hypertuna.errors import InputError
from hypertuna.io.quantity import Format
from hypertuna.metrics import cost_of_transport
from hypertuna.ranges import POSITIVE, Range

POINTS = 32  # Gauss-Legendre points over the charge; voltage and current are smooth


def battery_columns(robot: Robot) -> dict[str, float]:
    """Return the numbers of the robot's battery by their names in core battery.hpp [SI]; `series` must be given."""
    battery = require(robot.battery, "battery", robot)
    series = require(battery.series, "battery.series", robot)
    strings = battery.cells // series
    charged = battery.voltage if battery.charged is None else battery.charged
    row = {
        "charge": strings * battery.capacity,
        "full": series * charged,
        "empty": series * (2 * battery.voltage - charged),
        "resistance": battery.resistance * series / strings,
        "converter": math.inf if battery.converter is None else battery.converter,
        "efficiency": battery.efficiency,
        "electronics": battery.electronics,
    }
    return {name: float(row[name]) for name in _core.battery_columns()}


@dataclass(frozen=True)
class CruisingRange:
    """Range and endurance of a robot on one charge."""

    electrical_power: Annotated[float, Format("W")]  # W, mean of the servos
    speed: Annotated[float, Format("m/s")]  # m/s through the water
    # J/(kg m): P / (m |U|), Eq. 38 with the mass of the whole robot
    cost_of_transport: Annotated[float, Format("J/(kg m)")]
    reserve: Annotated[float, Format()]  # fraction of the usable charge that is kept
    energy: float  # J: capacity of all cells at their nominal voltage
    energy_at_servos: Annotated[float, Format("Wh")]  # J, that the servos get from the usable charge minus the reserve
    voltage: tuple[float, float]  # V, of the battery under load, at the start and at the end
    servo_voltage_min: Annotated[float, Format("V")]  # V: lowest voltage at the servos
    range: Annotated[float, Format("km")]  # m
    endurance: Annotated[float, Format("h")]  # s
    nominal_range: Annotated[float, Format("km")]  # m, if the servos got all `energy` without losses
    nominal_endurance: Annotated[float, Format("h")]  # s, if the servos got all `energy` without losses


def range_of(robot: Robot, *, power: float, speed: float, reserve: float = 0.0) -> CruisingRange:
    """Return range and endurance at a mean electrical power of the servos [W] and a speed [m/s].

    They follow from the battery's charge, voltage, inner resistance and converter. `reserve` is the fraction of the
    usable charge that is kept.
    """
    POSITIVE.check(power, "power", "give it in W")
    POSITIVE.check(abs(speed), "speed", "give it in m/s")
    Range(min=0, below=1).check(reserve, "reserve", "give the fraction of the charge to keep, such as 0.1")
    battery = require(robot.battery, "battery", robot)
    columns = battery_columns(robot)
    numbers, charge = np.array([*columns.values()]), battery.usable * (1 - reserve) * columns["charge"]
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    output = _core.battery_output(numbers, charge * (nodes + 1) / 2, np.full(POINTS, power))
    extremes = _core.battery_output(numbers, np.array([0.0, charge]), np.full(2, power))
    powers = (extremes[:, 0] * extremes[:, 1] - battery.electronics) * battery.efficiency
    if (powers < power * (1 - 1e-9)).any():
        power_max = float(powers.min())
        rule = f"must be at most {power_max:.4g}, the battery's largest power with its inner resistance"
        raise InputError(rule, key="power", value=f"{power:g}", fix="give the mean power in W")
    # The endurance is the integral of 1 / current over the charge.
    endurance = float((weights * charge / 2 / output[:, 1]).sum())
    energy = battery.cells * battery.capacity * battery.voltage
    return CruisingRange(
        electrical_power=power,
        speed=speed,
        cost_of_transport=float(cost_of_transport(power, robot.body.mass, speed)),
        reserve=reserve,
        energy=energy,
        nominal_range=abs(speed) * energy / power,
        nominal_endurance=energy / power,
        energy_at_servos=power * endurance,
        range=abs(speed) * endurance,
        endurance=endurance,
        voltage=(float(extremes[0, 0]), float(extremes[1, 0])),
        servo_voltage_min=float(extremes[:, 2].min()),
    )
