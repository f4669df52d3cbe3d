"""Lock-step: the messages between twin and firmware in every tick (firmware/boards/lockstep.hpp)."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.channels import ANALOG, COUNTED
from hypertuna.firmware.parameters import CONVERTER, SIGNED, FirmwareTable
from hypertuna.mission.geodesy import from_local

SIZES = [channel.count(_core.BOARD_JOINTS) for channel in COUNTED.values()]  # samples of each channel in a message
SAMPLES = sum(SIZES)  # samples of all channels in a message
DEPTH_MAX = 300_000  # counts of the depth sensor, 30 bar
NO_SAMPLE = -(2**31)  # sample of a silent sensor
NUMBERS = max(16, 3 * _core.BOARD_JOINTS + 3)  # numbers of an order: enough for a mission or a gait
DEGREES = 1e7  # counts of the satellite receiver in a degree
FIXED, LEAK, GROUND, LAST, STACK, RESET, KEPT = 1, 2, 4, 8, 16, 32, 64  # bits of the flags
RADIO = 62  # bytes that the radio can receive in a tick
# Names of orders, by their numbers
ORDERS = ("none", "give", "gait", "sticks", "leg", "origin", "begin", "waypoint", "corner", "end", "parameter")

# Fields of sensors and orders in a message to the board
REQUEST: list[Any] = [("sample", "<i4", SAMPLES), ("fix", "<i4", 2), ("accuracy", "<i4")]
REQUEST += [(name, "u1") for name in ("flags", "order", "which", "satellites")]
# Fields of what the board's radio receives
HEARD: list[Any] = [("missed", "u1"), ("length", "u1"), ("radio", "u1", RADIO)]
TO_BOARD = np.dtype([*REQUEST, ("number", "<f4", NUMBERS), *HEARD])
# Fields of an answer that are equal on all boards
SAME: list[Any] = [("tick", "<u4"), ("pulse", "<f4", _core.BOARD_SERVOS)]
SAME += [("quaternion", "<f4", 4), ("position", "<f4", 2)]
SAME += [(name, "<f4") for name in ("depth", "speed", "position_error")]
SAME += [(name, "<u4") for name in ("status", "reasons", "faults")]
SAME += [(name, "u1") for name in ("mode", "state", "answer", "refusal", "leg")]
SAME += [("spare", "u1", 3), ("digest", "<u4")]
# Fields that differ between boards.
OWN: list[Any] = [(name, "<u4") for name in ("controller", "pilot", "whole", "radio", "stack")]
FROM_BOARD = np.dtype(SAME + OWN)
COMPARED = np.dtype(SAME).itemsize  # bytes that must be equal on all boards


def order(kind: str, *numbers: float, which: int = 0, fix: tuple[int, int] = (0, 0)) -> Any:
    """Return a message (TO_BOARD) with a command of kind `ORDERS`, and without readings."""
    message = np.zeros((), TO_BOARD)
    message["sample"] = NO_SAMPLE
    message["order"], message["which"], message["fix"] = ORDERS.index(kind), which, fix
    message["number"][: len(numbers)] = numbers
    return message


# Names of the orders of `give`, in the order of their numbers.
ORDERS_GIVEN = tuple(name for name, *_ in _core.order_table())


def give(name: str) -> Any:
    """Return a message that gives an order of the firmware's table of states (firmware/app/vehicle/states.hpp)."""
    return order("give", which=ORDERS_GIVEN.index(name))


class Counts:
    """Convert readings to counts: the inverse of the firmware's calibration."""

    def __init__(self, table: FirmwareTable, origin: tuple[int, int]) -> None:
        joints = len(table.robot.joints)
        places = np.split(np.arange(SAMPLES), np.cumsum(SIZES)[:-1])
        channels = {name: place[: COUNTED[name].count(joints)] for name, place in zip(COUNTED, places, strict=True)}
        self.channels = np.concatenate(list(channels.values()))
        self.names = [name for name, place in channels.items() for _ in place]
        self.zero = np.concatenate([table.column(f"{name}_zero") for name in channels]).astype(float)
        self.scale = np.concatenate([table.column(f"{name}_scale") for name in channels]).astype(float)
        limits = {name: (0, CONVERTER - 1) if name in ANALOG else (-SIGNED, SIGNED - 1) for name in channels}
        limits["depth"] = (0, DEPTH_MAX)
        self.low, self.high = np.array([limits[name] for name in self.names]).T
        self.analog = np.isin(self.names, ANALOG)
        self.origin = origin

    def of(self, readings: Array) -> NDArray[np.int32]:
        """Return the samples (SAMPLES,) of all channels, in counts, from readings (n,) [SI]."""
        counts = np.rint(np.where(np.isfinite(readings), readings, np.inf) / self.scale + self.zero)
        silent = ~np.isfinite(readings) | (~self.analog & ((counts < self.low) | (self.high < counts)))
        samples = np.full(SAMPLES, NO_SAMPLE, np.int32)
        samples[self.channels] = np.where(silent, NO_SAMPLE, np.clip(counts, self.low, self.high))
        return samples

    def fix(self, east: float, north: float) -> tuple[int, int]:
        """Return latitude and longitude [1e-7 deg] of a position [m] east and north of the origin."""
        origin = (math.radians(self.origin[0] / DEGREES), math.radians(self.origin[1] / DEGREES))
        latitude, longitude = np.degrees(from_local(origin, [east, north]))
        return round(float(latitude) * DEGREES), round(float(longitude) * DEGREES)
