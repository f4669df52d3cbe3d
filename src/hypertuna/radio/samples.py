"""Sample a robot's sensors for a calibration: mean readings, and raw counts of the IMU."""

import contextlib
import math
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, did_you_mean
from hypertuna.radio.client import Client
from hypertuna.radio.dialect import SILENT, dialect

SAMPLING = 2.0  # s over which readings at one reference are averaged
WAIT = 10.0  # s without a message before the robot counts as silent
INTERVAL = 0.1  # s between two messages; a slow radio may carry fewer
VOLTAGE_SILENT = 65535  # value in SYS_STATUS if the voltage cannot be read
ARMED = 128  # MAV_MODE_FLAG_SAFETY_ARMED
SET_INTERVAL = 511  # MAV_CMD_SET_MESSAGE_INTERVAL
# By kind of sensor: its message, and SI per count: bends in centidegrees, pressures in hPa, currents in 10 mA.
MESSAGES = {
    "bend": ("HYDRAULICS", math.pi / 18000),
    "pressure": ("HYDRAULICS", 100.0),
    "current": ("HYDRAULICS", 0.01),
    "voltage": ("SYS_STATUS", 1e-3),
    "depth": ("SCALED_PRESSURE", 10.0),  # counts of the sensor per hPa
}
PARTS = {"acceleration": "acc", "rate": "gyro", "field": "mag"}  # by part of the IMU: suffix of its fields in RAW_IMU
Samples = dict[str, Array]  # by part of the IMU: counts (n, 3)


def set_interval(robot: Client, name: str, interval: float) -> None:
    """Ask the robot to send a message at an interval [s]; 0 restores the interval at boot."""
    names = {kind.msgname: number for number, kind in dialect().mavlink_map.items()}
    if name.upper() not in names:
        raise InputError("must be a message", key=name, fix=did_you_mean(name.upper(), names))
    robot.command(SET_INTERVAL, names[name.upper()], interval * 1e6, name=f"interval of {name}")


@contextlib.contextmanager
def streaming(robot: Client, name: str) -> Iterator[None]:
    """Let the robot send a message every INTERVAL within the context, then restore its interval at boot."""
    set_interval(robot, name, INTERVAL)
    try:
        yield
    finally:
        set_interval(robot, name, 0)


def check_disarmed(robot: Client) -> None:
    """Check that the robot is disarmed, since it refuses parameters while armed."""
    heartbeat = robot.last.get("HEARTBEAT")
    if heartbeat is not None and heartbeat.base_mode & ARMED:
        raise InputError("must be disarmed", key="robot", value="armed", fix="disarm it, and calibrate again")


def average(robot: Client, kind: str, index: int) -> float:
    """Return a sensor's mean reading over SAMPLING seconds, in SI units; for the depth sensor, in its raw counts."""
    name, step = MESSAGES[kind]
    with streaming(robot, name):
        return float(np.mean([step * _count(message, kind, index) for message in messages(robot, name, SAMPLING)]))


def _count(message: Any, kind: str, index: int) -> float:
    """Return a sensor's count in a message; raise an error if the sensor does not answer."""
    if kind == "voltage":
        count, silent = float(message.voltage_battery), VOLTAGE_SILENT
    elif kind == "depth":
        count, silent = float(message.press_abs), SILENT
    else:
        numbers = (*getattr(message, kind), *getattr(message, f"{kind}_34"))  # split over two fields
        count, silent = float(numbers[index]), SILENT
    if count == silent or not math.isfinite(count):
        raise InputError("must answer", key=f"{kind}_{index}", value="silent", fix="check its wires")
    return count


def messages(robot: Client, name: str, seconds: float) -> Iterator[Any]:
    """Yield the messages of a name that arrive within `seconds`; wait longer for the first one."""
    begin = last = time.monotonic()
    received = False
    while (now := time.monotonic()) < begin + seconds or not received:
        for message in robot.poll(0.2):
            if message.get_type() == name:
                received, last = True, now
                yield message
        if now > last + WAIT:
            raise InputError("must arrive from the robot", key=name, value="missing", fix="move closer, and try again")


def imu_counts(message: Any) -> dict[str, tuple[int, int, int]] | None:
    """Return the counts (x, y, z) in a RAW_IMU by part of the IMU; None if a part did not answer."""
    counts = {part: tuple(getattr(message, f"{axis}{suffix}") for axis in "xyz") for part, suffix in PARTS.items()}
    return None if any(SILENT in axes for axes in counts.values()) else counts


def sample_imu(robot: Client, seconds: float) -> Samples:
    """Return the counts (n, 3) of each part of the IMU during `seconds`; RAW_IMU must be streaming."""
    samples = [imu_counts(message) for message in messages(robot, "RAW_IMU", seconds)]
    complete = [counts for counts in samples if counts is not None]
    if not complete:
        raise InputError("must answer", key="IMU", value="silent", fix="check its wires, its baud rate and its frames")
    return {part: np.array([counts[part] for counts in complete], dtype=float) for part in PARTS}
