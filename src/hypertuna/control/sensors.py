"""Sensors of a robot as the core takes them, and the faults that the command line spells."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from hypertuna import _core
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.control import Sensor
from hypertuna.errors import InputError, did_you_mean, shown

__all__ = ["Fault", "channels", "faults", "pilot_sensor_columns", "sensor_columns", "sensor_of"]

QUANTITIES = ("bend", "pressure", "current", "rate", "acceleration", "voltage")
PILOT_QUANTITIES = ("depth", "field", "position")
NUMBERS = ("low", "high", "noise", "resolution", "drift", "bias", "nonlinearity")
KINDS = tuple(kind for kind in _core.fault_kinds() if kind != "none")
FOREVER = float("inf")
SPELLING = re.compile(r"(?P<channel>[^:@]+):(?P<kind>[^:@]+)@(?P<start>[^:@]+)")


class Fault(NamedTuple):
    """A fault of neighboring sensor channels, as the core takes it."""

    kind: str  # stuck, open, spike or nan
    first: int  # channel
    last: int  # channel
    start: float  # s
    end: float = FOREVER  # s


def sensor_columns(robot: Robot) -> dict[str, list[float]]:
    """Return what the sensors of a robot get wrong, by the names of core sensors.hpp.

    Parameters
    ----------
    robot : Robot
        With the table ``[controller]`` and ``[[sensors]]`` of every quantity.

    Returns
    -------
    dict of str to list of float
        SI units.

    Raises
    ------
    InputError
        If a table is missing.
    """
    control = require(robot.controller, "controller", robot)
    columns = {"joints": [float(len(robot.joints))], "tick": [1 / control.rate]}
    return columns | _models(robot, QUANTITIES)


def pilot_sensor_columns(robot: Robot) -> dict[str, list[float]]:
    """Return the same with the sensors that only the pilot reads.

    Parameters
    ----------
    robot : Robot
        With the table ``[controller]`` and ``[[sensors]]`` of every quantity, depth, field and position among them.

    Returns
    -------
    dict of str to list of float
        SI units.

    Raises
    ------
    InputError
        If a table is missing.
    """
    columns = sensor_columns(robot) | _models(robot, PILOT_QUANTITIES)
    period = require(sensor_of(robot, "position").period, "sensors.period_s", robot)
    return columns | {"fix_every": [float(max(1, round(period / columns["tick"][0])))]}


def sensor_of(robot: Robot, quantity: str) -> Sensor:
    """Return the sensors of a quantity.

    Parameters
    ----------
    robot : Robot
    quantity : str

    Returns
    -------
    Sensor

    Raises
    ------
    InputError
        If the robot has none.
    """
    sensor = next((sensor for sensor in robot.sensors if sensor.quantity == quantity), None)
    return require(sensor, "sensors", robot, f"add [[sensors]] with quantity = {quantity!r}")


def _models(robot: Robot, quantities: Iterable[str]) -> dict[str, list[float]]:
    """Return the models of the sensors of some quantities."""
    return {f"{q}.{name}": [float(getattr(sensor_of(robot, q), name))] for q in quantities for name in NUMBERS}


def channels(robot: Robot) -> dict[str, tuple[int, int]]:
    """Name the sensors of a robot that can fail.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    dict of str to (int, int)
        First and last channel of ``bend-I``, ``pressure-I``, ``pressure-I-left``, ``imu``, ``battery`` and so on.
        A name without joint or side means all of them.
    """
    joints = len(robot.joints)
    first = _core.sensor_channels()
    names = {"bend": (first["bend"], first["bend"] + joints - 1)}
    for j, group in enumerate(robot.joints):
        names[f"bend-{group.name}"] = (first["bend"] + j,) * 2
    for quantity in ("pressure", "current"):
        start = first[quantity]
        names[quantity] = (start, start + 2 * joints - 1)
        for j, group in enumerate(robot.joints):
            names[f"{quantity}-{group.name}"] = (start + 2 * j, start + 2 * j + 1)
            for s, side in enumerate(SIDES):
                names[f"{quantity}-{group.name}-{side}"] = (start + 2 * j + s,) * 2
    names |= {"imu": (first["imu"], first["imu"] + 5), "battery": (first["battery"],) * 2}
    known = {sensor.quantity for sensor in robot.sensors}
    counts = {"depth": 1, "field": 3, "position": 2}
    return names | {q: (first[q], first[q] + n - 1) for q, n in counts.items() if q in known}


def faults(spelled: str | Iterable[str], robot: Robot) -> tuple[Fault, ...]:
    """Read faults as the command line spells them: ``bend-II:stuck@5`` is joint II's bend sensor, stuck from 5 s on.

    Parameters
    ----------
    spelled : str or iterable of str
        ``CHANNEL:KIND@START`` or ``CHANNEL:KIND@START-END``, times in seconds. Kinds: stuck, open, spike, nan.
    robot : Robot

    Returns
    -------
    tuple of Fault

    Raises
    ------
    InputError
        If the spelling, the channel, the kind or a time is wrong; it names the choices.
    """
    return tuple(_fault(one, robot) for one in ([spelled] if isinstance(spelled, str) else spelled))


def _fault(spelled: str, robot: Robot) -> Fault:
    match = SPELLING.fullmatch(spelled.strip())
    if match is None:
        fix = "write for example bend-II:stuck@5, or bend-II:stuck@5-8 for a fault that ends"
        raise InputError("must be CHANNEL:KIND@SECONDS", key="fault", value=shown(spelled), fix=fix)
    known = channels(robot)
    if match["channel"] not in known:
        fix = did_you_mean(match["channel"], known)
        raise InputError("must be of a sensor that the robot has", key="fault", value=shown(spelled), fix=fix)
    if match["kind"] not in KINDS:
        fix = f"use one of {', '.join(KINDS)}"
        raise InputError("must be of a known kind", key="fault", value=shown(spelled), fix=fix)
    start, dash, end = match["start"].partition("-")
    try:
        times = (float(start), float(end) if dash else FOREVER)
    except ValueError:
        times = (FOREVER, FOREVER)
    if not 0 <= times[0] < times[1]:
        fix = "give seconds from the start of the run, the end after the start"
        raise InputError("must have a time", key="fault", value=shown(spelled), fix=fix)
    return Fault(match["kind"], *known[match["channel"]], *times)
