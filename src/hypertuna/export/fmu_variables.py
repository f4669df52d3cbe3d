"""Variables of a robot's FMU: its inputs, parameters and outputs, with units and start values."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hypertuna.actuation.hydraulics import drive_names
from hypertuna.control.controller import sensor_range
from hypertuna.control.sensors import sensor_absent
from hypertuna.description.channels import CHANNELS, Channel
from hypertuna.description.robot import Robot
from hypertuna.simulation.plant import controller_of
from hypertuna.simulation.recorded import VARIABLES
from hypertuna.simulation.sea_run import VARIABLES as SEA_VARIABLES

# Labels along dimensions whose length does not depend on the robot.
LABELS = {"": ("",), "axis": ("x", "y", "z"), "quaternion": ("w", "x", "y", "z"), "side": ("port", "starboard")}
POSITION = ("east", "north", "up")  # labels of a position's axes
# Columns that the controller and its sensors record, which a plant alone does not have.
CONTROLLER_COLUMNS = ("angle_measured", "angle_set", "pressure_measured", "current", "status")
CONTROLLER_COLUMNS_AT_SEA = ("rate_measured", "acceleration_measured")
MIRRORED = {"speed": "surge"}  # by output: the core's column, which has the opposite sign


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU; `line` describes it in the file that the binary reads."""

    name: str
    causality: str  # "input", "parameter", "output" or "independent"
    unit: str
    description: str
    line: str
    variability: str = "continuous"
    type: str = "Real"  # "Real", "Integer" or "Boolean"
    start: float | None = None
    low: float | None = None
    high: float | None = None


def variables(robot: Robot, kind: str, *, sea: bool, pilot: bool) -> list[Variable]:
    """Return the variables in the order of their value references; pilot: whether the image has a pilot."""
    time = Variable("time", "independent", "s", "simulation time", "r time")
    pilot = pilot and sea
    inputs = _command(robot, sea, pilot=pilot) if kind == "twin" else _pulses(robot, sea)
    readings = _readings(robot, pilot=pilot) if kind == "plant" else ()
    return [time, *inputs, *_parameters(sea), *readings, *_recorded_outputs(robot, kind, sea)]


def _input(place: int, name: str, unit: str, description: str, start: float, low: float, high: float) -> Variable:
    line = f"r input {place} {start!r}"
    return Variable(name, "input", unit, description, line, start=start, low=low, high=high)


def _command(robot: Robot, sea: bool, *, pilot: bool) -> Iterator[Variable]:
    """Yield the inputs of the twin: a gait, the fins, whether the tail is armed, and the pilot's depth and heading."""
    limits, groups = controller_of(robot), [_word(group.name) for group in robot.joints]
    yield _input(0, "frequency", "Hz", "frequency of the beat", 0.0, 0.0, limits["frequency_max"][0])
    kinds = {"amplitude": "amplitude of the bend", "phase": "lag of the bend", "bias": "mean bend, counter-clockwise"}
    for k, (kind, text) in enumerate(kinds.items()):
        for g, group in enumerate(groups):
            high = 2 * math.pi if kind == "phase" else limits["amplitude"][g]
            low = 0.0 if kind == "amplitude" else -high
            yield _input(1 + k * len(groups) + g, f"{kind}_{group}", "rad", f"{text} of joint {group}", 0.0, low, high)
    index = 1 + 3 * len(groups)
    if sea:
        high = limits["fin_max"][0]
        for k, side in enumerate(LABELS["side"]):
            text = f"angle of the {side} fin, leading edge up"
            yield _input(index + k, f"fin_command_{side}", "rad", text, 0.0, -high, high)
    text = "whether the tail beats; otherwise it rests"
    yield Variable("armed", "input", "1", text, f"b input {index + 2} 1", "discrete", "Boolean", 1.0)
    if pilot:
        text = "whether the pilot sets biases and fins, toward depth_command and heading_command"
        yield Variable("steered", "input", "1", text, f"b input {index + 3} 0", "discrete", "Boolean", 0.0)
        deepest = sensor_range(robot, "depth")[1]
        yield _input(index + 4, "depth_command", "m", "depth of the nose to hold, with steered", 2.0, 0.0, deepest)
        text, line = "heading to hold, clockwise from north, with steered", f"r input {index + 5} 0"
        yield Variable("heading_command", "input", "rad", text, line, start=0.0)


def _pulses(robot: Robot, sea: bool) -> Iterator[Variable]:
    """Yield the inputs of the plant: a pulse for each servo."""
    limits, names = controller_of(robot), drive_names(robot)
    center, low, high = (limits[f"pulse_{name}"][0] for name in ("center", "min", "max"))
    for index, name in enumerate((*names, *(f"fin-{side}" for side in LABELS["side"] if sea))):
        if name:
            text = f"pulse to servo {name}, held within its limits"
            yield _input(index, f"pulse_command_{_word(name)}", "s", text, center, low, high)


def _parameters(sea: bool) -> Iterator[Variable]:
    """Yield the parameters: seed and initial state, which are fixed, and the current, which is tunable."""
    text = "seed of the sensors' errors"
    yield Variable("seed", "parameter", "1", text, "i fixed 0 0", "fixed", "Integer", 0.0, 0.0)
    at_start = [("start_speed", "m/s", "speed ahead at the start", 0.0)]
    if sea:
        at_start.append(("start_depth", "m", "depth of the nose at the start", 2.0))
        at_start.append(("start_heading", "rad", "heading at the start, clockwise from north", 0.0))
    for index, (name, unit, text, start) in enumerate(at_start, start=1):
        low = 0.0 if name == "start_depth" else None
        yield Variable(name, "parameter", unit, text, f"r fixed {index} {start!r}", "fixed", start=start, low=low)
    for index, toward in enumerate(("east", "north") if sea else (), start=4):
        text, line = f"current of the water toward {toward}", f"r tunable {index} 0"
        yield Variable(f"current_{toward}", "parameter", "m/s", text, line, "tunable", start=0.0)


def _output(name: str, unit: str, description: str, column: str, place: int, factor: float = 1.0) -> Variable:
    integer = name in ("status", "fixed")
    line = f"{'i' if integer else 'r'} output {column} {place} {factor!r}"
    variability, kind = ("discrete", "Integer") if integer else ("continuous", "Real")
    return Variable(name, "output", unit, description, line, variability, kind)


def _readings(robot: Robot, *, pilot: bool) -> Iterator[Variable]:
    """Yield the sensors' readings as outputs: the controller's, and the pilot's if the image has a pilot."""
    channels = [c for c in CHANNELS.values() if not sensor_absent(robot, c.name) and (pilot or not c.pilot)]
    for channel in channels:
        for index, label in enumerate(_channel_labels(robot, channel)):
            if label is not None:
                name = _joined(channel.column, label)
                text = f"{_joined(channel.name, label, ' ')} {channel.meaning}"
                yield _output(name, channel.unit, text, channel.column, index)
    if pilot:
        yield _output("fixed", "1", "1 where the satellite receiver has a fix in this tick", "fixed", 0)


def _channel_labels(robot: Robot, channel: Channel) -> list[str | None]:
    """Return the labels of a channel's sensors; None in place of a sensor that the robot lacks."""
    if channel.per == "joint":
        return [group.name if group.drive.oil else None for group in robot.joints]
    if channel.per == "circuit":
        return [name or None for name in drive_names(robot, oil=channel.name == "pressure")]
    axes = POSITION if channel.name == "position" else LABELS["axis"]
    return [axis if channel.size > 1 else "" for axis in axes[: channel.size]]


def _recorded_outputs(robot: Robot, kind: str, sea: bool) -> Iterator[Variable]:
    """Yield the quantities that a twin records as outputs, without the controller's if the FMU is only the plant."""
    left_out = (*CONTROLLER_COLUMNS, *CONTROLLER_COLUMNS_AT_SEA) if kind == "plant" else ()
    drives, oil = drive_names(robot), [group.drive.oil for group in robot.joints]
    places: dict[str, Any] = LABELS | {
        "joint": [group.name for group in robot.joints],
        "hinge": [robot.links.name[hinge.link] for hinge in robot.hinges],
        "circuit": drive_names(robot, oil=True),
        "drive": drives,
        "servo": [*drives, *(f"fin-{side}" for side in LABELS["side"] if sea)],
    }
    for name, (dim, unit, text) in (SEA_VARIABLES if sea else VARIABLES).items():
        if name in left_out:
            continue
        for index, label in enumerate(POSITION if name == "position" else places[dim]):
            if (dim and not label) or (name == "angle_measured" and not oil[index]):
                continue
            column, factor = MIRRORED.get(name, name), -1.0 if name in MIRRORED else 1.0
            if dim == "hinge":  # the core records hinges after the joint groups
                column, index = name.removeprefix("hinge_"), index + len(robot.joints)
            yield _output(_joined(name, label), unit, _joined(text, label, ": "), column, index, factor)
    if sea:
        yield _output("speed", "m/s", "velocity of the nose through the water, ahead", "velocity", 0, -1.0)
        yield _output("depth", "m", "depth of the nose", "position", 2, -1.0)
        for index, (name, text) in enumerate(ANGLES.items()):
            yield _output(name, "rad", text, "angles", index)


ANGLES = {  # outputs of the head's attitude [rad], with their descriptions
    "roll": "roll of the head, starboard down",
    "pitch": "pitch of the head, nose up",
    "heading": "heading of the head, clockwise from north",
}


def _joined(name: str, label: str, by: str = "_") -> str:
    """Return a name joined with a label; the name alone without a label."""
    return f"{name}{by}{_word(label)}" if label else name


def _word(name: str) -> str:
    """Return a name with underscores in place of characters other than letters and digits."""
    return "".join(letter if letter.isalnum() else "_" for letter in name)
