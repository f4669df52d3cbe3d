"""Lock-step: what a twin and firmware tell each other in every tick, as firmware/boards/lockstep.hpp has it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.firmware.parameters import CONVERTER, SIGNED, FirmwareTable
from hypertuna.mission.geodesy import from_local

__all__ = ["CHANNELS", "COMPARED", "FROM_BOARD", "ORDERS", "TO_BOARD", "Counts", "order"]

Array = NDArray[np.float64]

DIGITAL = ("rate", "acceleration", "depth", "field")  # the others hang on the analog converter
MOST_SERVOS = 10
CHANNELS = {"bend": 4, "pressure": 8, "current": 8, "rate": 3, "acceleration": 3, "voltage": 1, "depth": 1, "field": 3}
DEEPEST = 300_000  # counts of the depth sensor, 30 bar
NO_SAMPLE = -(2**31)
NUMBERS = 16
DEGREES = 1e7  # counts of the satellite receiver
FIXED, LEAK, GROUND, LAST, STACK = 1, 2, 4, 8, 16  # flags
ORDERS = ("none", "arm", "gait", "manual", "control", "origin", "begin", "waypoint", "corner", "end", "parameter")

TO_BOARD = np.dtype(
    [
        ("sample", "<i4", sum(CHANNELS.values())),
        ("fix", "<i4", 2),
        ("flags", "u1"),
        ("order", "u1"),
        ("which", "u1"),
        ("spare", "u1"),
        ("number", "<f4", NUMBERS),
    ]
)
SAME: list[Any] = [
    ("tick", "<u4"),
    ("pulse", "<f4", MOST_SERVOS),
    ("quaternion", "<f4", 4),
    ("position", "<f4", 2),
    ("depth", "<f4"),
    ("speed", "<f4"),
    ("position_error", "<f4"),
    ("status", "<u4"),
    ("reasons", "<u4"),
    ("faults", "<u4"),
    ("mode", "u1"),
    ("control", "u1"),
    ("armed", "u1"),
    ("answer", "u1"),
    ("refusal", "u1"),
    ("leg", "u1"),
    ("spare", "<u2"),
    ("digest", "<u4"),
]
# These may differ from board to board.
OWN: list[Any] = [(name, "<u4") for name in ("controller", "pilot", "whole", "link", "stack")]
FROM_BOARD = np.dtype(SAME + OWN)
COMPARED = np.dtype(SAME).itemsize  # bytes that boards must agree on


def order(kind: str, *numbers: float, which: int = 0, fix: tuple[int, int] = (0, 0)) -> Any:
    """Make a message with an order, and without readings yet.

    Parameters
    ----------
    kind : str
        One of `ORDERS`.
    *numbers : float
        As firmware/boards/lockstep.hpp has them for the kind.
    which : int
        The same.
    fix : tuple of int
        Latitude and longitude of the origin [1e-7 deg].

    Returns
    -------
    ndarray of TO_BOARD, shape ()
    """
    message = np.zeros((), TO_BOARD)
    message["sample"] = NO_SAMPLE
    message["order"], message["which"], message["fix"] = ORDERS.index(kind), which, fix
    message["number"][: len(numbers)] = numbers
    return message


class Counts:
    """What a board's converters make of readings: the inverse of the firmware's calibration.

    Parameters
    ----------
    table : FirmwareTable
    origin : tuple of int
        Latitude and longitude that a fix's east and north count from [1e-7 deg].
    """

    def __init__(self, table: FirmwareTable, origin: tuple[int, int]) -> None:
        joints = len(table.robot.joints)
        used = {"bend": joints, "pressure": 2 * joints, "current": 2 * joints}
        at = np.cumsum([0, *CHANNELS.values()])
        names = list(CHANNELS)
        self.channels = np.concatenate([at[k] + np.arange(used.get(n, CHANNELS[n])) for k, n in enumerate(names)])
        self.zero = np.concatenate([table.column(f"{n}_zero") for n in names]).astype(float)
        self.scale = np.concatenate([table.column(f"{n}_scale") for n in names]).astype(float)
        analog = np.concatenate([np.full(used.get(n, CHANNELS[n]), n not in DIGITAL) for n in names])
        self.low = np.where(analog, 0, -SIGNED)
        self.high = np.where(analog, CONVERTER - 1, SIGNED - 1)
        depth = len(analog) - CHANNELS["field"] - 1
        self.low[depth], self.high[depth] = 0, DEEPEST
        self.analog = analog
        self.names = [n for n in names for _ in range(used.get(n, CHANNELS[n]))]
        self.origin = origin

    def of(self, readings: Array) -> NDArray[np.int32]:
        """Return the samples of all channels.

        Parameters
        ----------
        readings : ndarray, shape (n,)
            Bends, pressures, currents, rates, accelerations, battery, depth, field [SI].

        Returns
        -------
        ndarray of int32, shape (31,)
            An analog converter stops at its ends; a digital sensor beyond its own does not answer.
        """
        raw = np.rint(np.where(np.isfinite(readings), readings, np.inf) / self.scale + self.zero)
        silent = ~np.isfinite(readings) | (~self.analog & ((raw < self.low) | (self.high < raw)))
        samples = np.full(sum(CHANNELS.values()), NO_SAMPLE, np.int32)
        samples[self.channels] = np.where(silent, NO_SAMPLE, np.clip(raw, self.low, self.high))
        return samples

    def fix(self, east: float, north: float) -> tuple[int, int]:
        """Return what the satellite receiver shows at a place.

        Parameters
        ----------
        east, north : float
            Of the origin [m].

        Returns
        -------
        tuple of int
            Latitude and longitude [1e-7 deg].
        """
        origin = (math.radians(self.origin[0] / DEGREES), math.radians(self.origin[1] / DEGREES))
        latitude, longitude = np.degrees(from_local(origin, [east, north]))
        return round(float(latitude) * DEGREES), round(float(longitude) * DEGREES)
