"""Energy: battery, range and endurance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description import Robot
from hypertuna.errors import InputError

__all__ = ["BatteryColumns", "Range", "battery_columns", "range_of"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BatteryColumns:
    """The battery of a robot as the core takes it.

    Parameters
    ----------
    columns : tuple of str
        As `core/include/hypertuna/battery.hpp` names them.
    values : ndarray, shape (columns,)
        SI units.
    """

    columns: tuple[str, ...]
    values: Array


def battery_columns(robot: Robot) -> BatteryColumns:
    """Describe the battery of a robot to the core.

    Parameters
    ----------
    robot : Robot
        With the table battery, and in it the number of cells in series.

    Returns
    -------
    BatteryColumns

    Raises
    ------
    InputError
        If table or number are missing.
    """
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
