"""How far the estimates of a description may be off, and random robots within these ranges."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.description.robot import Robot, parse
from hypertuna.errors import InputError


@dataclass(frozen=True)
class Factor:
    """One estimate of a description and how far it may be off."""

    name: str  # in words
    key: str  # place in the robot's file, e.g. ``joints.line.bore_m``: in a list of tables, of every one that has it
    low: float  # multiples of the description's value, or values, on a logarithmic scale; or what is added to it
    high: float
    how: Literal["times", "plus", "to"] = "times"
    along: tuple[str, ...] = ()  # keys of the same table that keep their ratio to this one

    def change(self, part: ArrayLike) -> Any:
        """Return the multiple, the value or the addend at a part of the range."""
        part = np.asarray(part)
        if self.how == "plus":
            return self.low + (self.high - self.low) * part
        return np.exp(math.log(self.low) + math.log(self.high / self.low) * part)


# How far HyperTuna's estimates may be off, by the reasons that its [sources] give.
FACTORS = (
    Factor("bore of the lines", "joints.line.bore_m", 0.8, 1.2),
    Factor("temperature of the oil", "oil.temperature_c", -10.0, 10.0, "plus"),
    Factor("entrained air", "oil.air", 0.5, 5.0),
    Factor("compliance of the circuits", "joints.line.compliance_m3_pa", 0.3, 3.0),
    Factor("fill pressure", "joints.line.fill_pressure_pa", 0.4, 1.6),
    Factor("speed of the servos", "servos.speed_rad_s", 0.9, 1.1),
    Factor("bandwidth of the servos", "servos.bandwidth_hz", 0.5, 2.0),
    Factor("inertia of the servos", "servos.inertia_kg_m2", 0.7, 3.0),
    Factor(
        "working limit", "controller.pressure_work_pa", 200e3, 600e3, "to", ("pressure_soft_pa", "pressure_hard_pa")
    ),
    Factor("stiffness of the silicone", "joints.actuator.stiffness_factor", 0.7, 1.4),
)

_DEFAULTS: dict[str, float] = {"stiffness_factor": 1.0}  # of keys that a file may leave out


def varied(robot: Robot, changes: Mapping[Factor, float]) -> Robot:
    """Return a robot with some of its estimates changed."""
    document = robot.document()
    for factor, change in changes.items():
        path, _, last = factor.key.rpartition(".")
        found = [table for table in _tables(document, path.split(".")) if last in table or last in _DEFAULTS]
        if not found:
            fix = "leave this factor out"
            raise InputError("must be a value of the robot", file=robot.file, key=factor.key, fix=fix)
        for table in found:
            value = table[last] if last in table else _DEFAULTS[last]
            new = {"times": value * change, "plus": value + change, "to": change}[factor.how]
            table |= {key: table[key] * new / value for key in factor.along} | {last: new}
    return parse(document, file=robot.file)


def random_robots(robot: Robot, count: int, seed: int, factors: Sequence[Factor] = FACTORS) -> list[Robot]:
    """Sample robots with estimates off at random: those of `factors` that the description has, but the controller's."""
    document = robot.document()
    has = [f for f in factors if not f.key.startswith("controller.") and _has(document, f.key)]
    parts = np.random.default_rng(seed).random((count, len(has)))
    return [varied(robot, {f: float(f.change(part)) for f, part in zip(has, row, strict=True)}) for row in parts]


def _has(document: dict[str, Any], key: str) -> bool:
    path, _, last = key.rpartition(".")
    return any(last in table or last in _DEFAULTS for table in _tables(document, path.split(".")))


def _tables(node: Any, path: Sequence[str]) -> list[dict[str, Any]]:
    """Collect the tables at a path, of every entry where there is a list."""
    if isinstance(node, list):
        return [table for part in node for table in _tables(part, path)]
    if not path:
        return [node]
    return _tables(node[path[0]], path[1:]) if path[0] in node else []
