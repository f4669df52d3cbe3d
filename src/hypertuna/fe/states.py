"""States of a joint by finite elements and by the fast model, under the same pressures and moments."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from hypertuna.actuation.soft_joint import JointModel, drive_unit, joint_group
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot

STRAIN = 0.3  # largest strain of the axis in a search
STATES = {  # columns in files: unit and meaning
    "angle": ("rad", "bend to the left"),
    "moment": ("N m", "moment from outside that holds the bend"),
    "volume_left": ("m^3", "oil in the drive units of the left side"),
    "volume_right": ("m^3", "oil in the drive units of the right side"),
    "length": ("m", "length of the bent axis"),
}


@dataclass(frozen=True)
class States:
    """States of a joint under m couples and n pairs of pressures; NaN where finite elements have no equilibrium."""

    angle: Array  # (m, n) bend [rad]
    moment: Array  # (m, n) external moment that holds the bend of the finite elements [N m]
    volume: Array  # (m, n, 2) oil in the drive units of each side [m^3]
    length: Array  # (m, n) length of the bent axis [m]

    def record(self) -> dict[str, Any]:
        """Return all numbers by names with units, with a row for each couple."""
        oil = {f"volume_{side}_ml": 1e6 * self.volume[..., s] for s, side in enumerate(("left", "right"))}
        angle = {"angle_deg": np.degrees(self.angle), "moment_n_m": self.moment}
        return angle | oil | {"length_mm": 1e3 * self.length}


def state_columns(elements: States, model: States) -> dict[str, Array]:
    """Return the states of both models as columns, with a row for each couple."""
    columns = {}
    for prefix, states in (("", elements), ("model_", model)):
        volumes = {f"volume_{side}": states.volume[..., s] for s, side in enumerate(("left", "right"))}
        for name in STATES:
            columns[f"{prefix}{name}"] = volumes[name] if name in volumes else getattr(states, name)
    return columns


def apart(elements: States, model: States, name: str) -> float:
    """Return the largest difference of the field `name` between two sets of states; NaN if all are NaN."""
    difference = np.abs(getattr(model, name) - getattr(elements, name))
    return float(np.nanmax(difference)) if np.isfinite(difference).any() else math.nan


def states_of(points: Sequence[Mapping[str, Any]], couple: Array, pairs: int) -> States:
    """Return the states (couples, pairs) that records of finite elements hold; NaN without an equilibrium."""
    missing = {"angle": math.nan, "volume": [math.nan, math.nan], "length": math.nan}
    valid = [missing if point["fault"] else point for point in points]
    angle, length = (np.array([point[key] for point in valid]).reshape(-1, pairs) for key in ("angle", "length"))
    volume = np.array([point["volume"] for point in valid]).reshape(-1, pairs, 2)
    return States(angle, couple[:, None] * np.cos(angle), volume, length)


def fast_states(robot: Robot, model: JointModel, pressure: Array, elements: States) -> States:
    """Return the fast model's states under the moments of `elements` and pairs of pressures (n, 2) [Pa]."""
    group, actuator = joint_group(robot, model.name)
    shape, solved = elements.angle.shape, np.isfinite(elements.angle)
    pressures = np.broadcast_to(pressure, (*shape, 2))[solved]
    # One call per couple: within a call, each search starts from the solution before, which changes the last bits.
    rows = [model.balance(pressure[row], moment[row]) for row, moment in zip(solved, elements.moment, strict=True)]
    balanced = {name: np.concatenate([row[name] for row in rows]) for name in ("angle", "strain", "volume")}
    moments = [holding_moment(model, a, pair) for a, pair in zip(elements.angle[solved], pressures, strict=True)]
    # At the stiff ends the channels keep their volume, and the axis keeps its length.
    lumen = math.pi / 4 * drive_unit(robot).inner_diameter ** 2
    rigid_volume = cast(int, group.drive_units) * lumen * (actuator.length - model["length"])
    length = actuator.length + model["length"] * (model["rest"] + balanced["strain"])
    states = States(*(np.full(size, math.nan) for size in (shape, shape, (*shape, 2), shape)))
    values = (balanced["angle"], np.array(moments), balanced["volume"] + rigid_volume, length)
    for target, column in zip((states.angle, states.moment, states.volume, states.length), values, strict=True):
        target[solved] = column
    return states


def holding_moment(model: JointModel, angle: float, pressure: ArrayLike) -> float:
    """Return the external moment [N m] that holds an angle [rad] under a pair of pressures [Pa]."""
    pair = np.asarray(pressure, dtype=np.float64)

    def axial_force(strain: float) -> float:
        loads = model.at(angle, strain, pair)
        return float(loads["axial"][0] + loads["gain"][0] @ pair)

    loads = model.at(angle, brentq(axial_force, -STRAIN, STRAIN, xtol=1e-12), pair)
    return -float(loads["elastic"][0] + loads["slope"][0] @ pair)
