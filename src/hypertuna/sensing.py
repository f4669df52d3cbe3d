"""Sensors of a robot as the core takes them, and the faults that the command line spells."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from hypertuna import _core
from hypertuna.description import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.hydraulics import SIDES, needed

__all__ = ["Fault", "channels", "faults", "sensor_columns"]

QUANTITIES = ("bend", "pressure", "current", "rate", "acceleration", "voltage")
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
    control = needed(robot.controller, "controller", "add the table [controller]", robot)
    columns = {"joints": [float(len(robot.joints))], "tick": [1 / control.rate]}
    for quantity in QUANTITIES:
        sensor = next((sensor for sensor in robot.sensors if sensor.quantity == quantity), None)
        sensor = needed(sensor, "sensors", f"add [[sensors]] with quantity = {quantity!r}", robot)
        for name in ("low", "high", "noise", "resolution", "drift", "bias", "nonlinearity"):
            columns[f"{quantity}.{name}"] = [float(getattr(sensor, name))]
    return columns


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
    return {**names, "imu": (first["imu"], first["imu"] + 5), "battery": (first["battery"],) * 2}


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
