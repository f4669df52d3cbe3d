"""Sensor models of a robot for the core, and sensor faults parsed from the command line's spelling."""

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from hypertuna import _core
from hypertuna.actuation.hydraulics import has_oil
from hypertuna.description.channels import CHANNELS
from hypertuna.description.robot import Robot, require
from hypertuna.description.schema.control import Sensor
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import parse_float

NUMBERS = ("low", "high", "noise", "resolution", "drift", "bias", "nonlinearity")  # of a sensor's error model
KINDS = tuple(kind for kind in _core.fault_kinds() if kind != "none")  # of sensor faults
FOREVER = float("inf")  # end of a fault that lasts to the end of the run [s]
STANDARD_AIR = 101325.0  # Pa (ISO 2533): air pressure at which depth sensors are calibrated
# A fault on the command line, such as bend-II:stuck@5.
SPELLING = re.compile(r"(?P<channel>[^:@]+):(?P<kind>[^:@]+)@(?P<start>[^:@]+)")


class Fault(NamedTuple):
    """A fault of consecutive sensor channels: its kind and times."""

    kind: str  # one of KINDS
    first: int  # channel
    last: int  # channel
    start: float  # s
    end: float = FOREVER  # s


def sensor_columns(robot: Robot) -> dict[str, list[float]]:
    """Return the error models of the controller's sensors, by their names in core sensors.hpp [SI]."""
    control = require_controller(robot)
    return {"joints": [float(len(robot.joints))], "tick": [1 / control.rate]} | _models(robot, pilot=False)


def pilot_sensor_columns(robot: Robot) -> dict[str, list[float]]:
    """Return the error models of the controller's and the pilot's sensors, by name [SI]."""
    columns = sensor_columns(robot) | _models(robot, pilot=True)
    period = require(sensor_of(robot, "position").period, "sensors.period_s", robot)
    return columns | {"fix_every": [float(max(1, round(period / columns["tick"][0])))]}


def sensor_of(robot: Robot, quantity: str) -> Sensor:
    """Return the robot's sensor of a quantity; raise an error if there is none."""
    sensor = next((sensor for sensor in robot.sensors if sensor.quantity == quantity), None)
    return require(sensor, "sensors", robot, f"add [[sensors]] with quantity = {quantity!r}")


def _models(robot: Robot, *, pilot: bool) -> dict[str, list[float]]:
    """Return the error models of the pilot's or the controller's sensors by name [SI]."""
    names = [name for name, channel in CHANNELS.items() if channel.pilot == pilot]
    zeros = dict.fromkeys(NUMBERS, 0.0)
    models = {name: zeros if sensor_absent(robot, name) else vars(sensor_of(robot, name)) for name in names}
    return {f"{name}.{key}": [float(model[key])] for name, model in models.items() for key in NUMBERS}


def sensor_absent(robot: Robot, quantity: str) -> bool:
    """Return whether a robot lacks a sensor and does not need it, since no joint has oil and no pilot reads the sensor.

    The sensor's model then has the range 0 to 0 and reads 0; the controller ignores it.
    """
    present = any(sensor.quantity == quantity for sensor in robot.sensors)
    return not (has_oil(robot) or CHANNELS[quantity].pilot or present)


def channels(robot: Robot, *, pilot: bool) -> dict[str, tuple[int, int]]:
    """Return the first and last channel of every sensor by name, such as ``bend-I`` or ``imu``.

    pilot: include the pilot's sensors. A name without joint or side covers all joints and sides.
    """
    sensors = {sensor.quantity for sensor in robot.sensors} if pilot else set()
    names: dict[str, tuple[int, int]] = {}
    for channel in CHANNELS.values():
        if (channel.pilot and channel.name not in sensors) or sensor_absent(robot, channel.name):
            continue
        first = channel.first
        last = first + channel.count(len(robot.joints)) - 1
        names[channel.part] = (names.get(channel.part, (first,))[0], last)
        for j, group in enumerate(robot.joints):
            name = f"{channel.part}-{group.name}"
            servos, oil = group.drive.servos, group.drive.oil
            if channel.per == "joint" and oil:
                names[name] = (first + j, first + j)
            elif channel.per == "circuit" and servos and (oil or channel.name == "current"):
                names[name] = (first + 2 * j, first + 2 * j + len(servos) - 1)
                names |= {f"{name}{end}": (first + 2 * j + s,) * 2 for s, end in enumerate(servos)}
    return names


def fault_texts(spelled: str | Iterable[str]) -> tuple[str, ...]:
    """Return the texts of faults as a tuple, from one text or several."""
    texts = tuple(spelled) if isinstance(spelled, Iterable) and not isinstance(spelled, str) else (spelled,)
    for k, text in enumerate(texts):
        if not isinstance(text, str):
            fix = "spell them as on the command line, bend-II:stuck@5"
            raise InputError("must be text", key=f"faults[{k}]", value=shown(text), fix=fix)
    return texts


def faults(
    spelled: str | Iterable[str], robot: Robot, duration: float = FOREVER, *, pilot: bool = False
) -> tuple[Fault, ...]:
    """Parse faults spelled ``CHANNEL:KIND@START`` or ``CHANNEL:KIND@START-END``, with times in s.

    ``bend-II:stuck@5`` is the bend sensor of joint II, stuck from 5 s on; `KINDS` has the kinds. Each must start within
    the duration of the run [s]. Sensors of the pilot can fail only where a pilot reads them.
    """
    channel_table = channels(robot, pilot=pilot)
    return tuple(_fault(text, channel_table, duration) for text in fault_texts(spelled))


def _fault(spelled: str, known: Mapping[str, tuple[int, int]], duration: float) -> Fault:
    """Parse one fault; known: channels by name; errors quote the text."""

    def refusal(rule: str, fix: str) -> InputError:
        return InputError(rule, key="fault", value=shown(spelled), fix=fix)

    match = SPELLING.fullmatch(spelled.strip())
    if match is None:
        fix = "write for example bend-II:stuck@5, or bend-II:stuck@5-8 for a fault that ends"
        raise refusal("must be CHANNEL:KIND@SECONDS", fix)
    if match["channel"] not in known:
        raise refusal("must be of a sensor that is read in this run", did_you_mean(match["channel"], known))
    if match["kind"] not in KINDS:
        raise refusal("must be of a known kind", f"use one of {', '.join(KINDS)}")
    times = fault_times(spelled, match["start"])
    if times[0] >= duration:
        rule, fix = (
            f"must start before the run ends at {duration:g} s",
            "start the fault earlier, or let the run last longer",
        )
        raise refusal(rule, fix)
    return Fault(match["kind"], *known[match["channel"]], *times)


def fault_times(spelled: str, times: str) -> tuple[float, float]:
    """Return start and end [s] of a fault from the text START or START-END."""
    start_text, dash, end_text = times.partition("-")
    start, end = parse_float(start_text), parse_float(end_text) if dash else FOREVER
    if not 0 <= start < end:
        fix = "give seconds from the start of the run, the end after the start"
        raise InputError("must have a time", key="fault", value=shown(spelled), fix=fix)
    return start, end
