"""Faults of the twin's body and drives, spelled like sensor faults: stuck servos, lost oil, a line on the robot."""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hypertuna.actuation.hydraulics import drive_names
from hypertuna.arrays import Array
from hypertuna.control.sensors import fault_times
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import check_name

# A fault of body or drives on the command line, such as servo-I-left:stuck@5.
PARTS = r"fin-port|fin-starboard|fins|body|(?:servo|oil)-[^:@]+"
SPELLING = re.compile(rf"(?P<part>{PARTS}):(?P<kind>[^:@]+)@(?P<times>[^:@]+)")
FIN_KINDS = {"stuck": math.nan, "level": 0.0, "up": 1.0, "down": -1.0}  # fractions of the largest angle
FINS = {"fin-port": (0,), "fin-starboard": (1,), "fins": (0, 1)}  # indices of the fins' servos
SNAGS = {"tethered": 1.0, "held": 0.0}  # length [m] of the line that ties the nose to its place at that time


class Mishaps(NamedTuple):
    """Faults of body and drives, each with the times [s] at which it begins and ends."""

    servos: list[tuple[int, float, float, float]]  # servo, angle [rad] (NaN: the present one), from, to
    oil: list[tuple[int, float, float]]  # circuit, from, to
    snags: Array  # (n, 3): from, to, length [m]


def split_mishaps(robot: Robot, spelled: Sequence[str], fin_max: float) -> tuple[tuple[str, ...], Mishaps]:
    """Split spelled faults into those of sensors, left as texts, and those of body and drives."""
    sensors: list[str] = []
    snags: list[tuple[float, float, float]] = []
    mishaps = Mishaps([], [], np.zeros((0, 3)))
    for text in spelled:
        match = SPELLING.fullmatch(text.strip())
        if match is None:
            sensors.append(text)
            continue
        part, kind, times = match["part"], match["kind"], fault_times(text, match["times"])
        if part == "body":
            snags.append((*times, SNAGS[check_name(kind, SNAGS, "fault", "kind")]))
        elif part in FINS:
            angle = FIN_KINDS[check_name(kind, FIN_KINDS, "fault", "kind")] * fin_max
            mishaps.servos.extend((2 * len(robot.joints) + fin, angle, *times) for fin in FINS[part])
        elif part.startswith("servo-"):
            check_name(kind, ("stuck",), "fault", "kind")
            mishaps.servos.append((_circuit(robot, text, part, oil=False), math.nan, *times))
        else:
            check_name(kind, ("lost",), "fault", "kind")
            mishaps.oil.append((_circuit(robot, text, part, oil=True), *times))
    return tuple(sensors), mishaps._replace(snags=np.array(snags, dtype=np.float64).reshape(-1, 3))


def _circuit(robot: Robot, text: str, part: str, *, oil: bool) -> int:
    """Return the index of the circuit that a fault names, such as ``servo-I-left``."""
    kind, _, name = part.partition("-")
    known = {circuit_name: circuit for circuit, circuit_name in enumerate(drive_names(robot, oil=oil)) if circuit_name}
    if name not in known:
        fix = did_you_mean(part, [f"{kind}-{circuit_name}" for circuit_name in known])
        rule = f"must name {'a circuit with oil' if oil else 'a servo'}"
        raise InputError(rule, key="fault", value=shown(text), fix=fix)
    return known[name]
