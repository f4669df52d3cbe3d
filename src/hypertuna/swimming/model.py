"""Core model of a robot: the columns of its parameters, and the name of each in the robot's description."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description.robot import Robot, cached
from hypertuna.description.schema.water import LAWS
from hypertuna.errors import InputError, did_you_mean, shown


def core_model(robot: Robot, columns: Mapping[str, Sequence[float]] | None = None) -> _core.Model:
    """Return the core's model of a robot, with other values for some `columns` if given.

    Columns are named as by `parameter_names`, without index: ``water.lumped.drag``, ``links.mass`` [kg]. Dependent
    values of the description (a slender rod's inertia, the robot's mass) stay as they are.
    """
    if columns is not None:
        return _make(robot, columns)
    return cached(robot, "core_model", lambda: _make(robot, {}))


def parameter_names(robot: Robot) -> tuple[str, ...]:
    """Name every parameter that results have derivatives by: ``gait.amplitude[0]``, ``links.mass[3]``, ..."""
    places = _places(robot)

    def full(name: str) -> str:
        column, bracket, index = name.partition("[")
        return places[column] + bracket + index

    return tuple(full(name) for name in core_model(robot).parameter_names())


def twist_from_rest(robot: Robot, joints: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the twist (3,) [m/s, m/s, rad/s] of a robot at rest whose joints set in: M xi + b is still zero.

    Joints (links, 3): angle [rad], rate [rad/s], acceleration [rad/s^2] of the front joint of every link.
    """
    still = _core.dynamics(core_model(robot), np.ascontiguousarray(joints[np.newaxis]), np.zeros((1, 3)))
    return -np.linalg.solve(still["inertia"][0], still["momentum"][0])


def _water_columns(robot: Robot) -> dict[str, tuple[str, str]]:
    """Table and attribute of the robot that hold each column of its water law."""
    law = robot.model.water
    areas = LAWS[law].areas.get(robot.model.areas, {})
    own = type(getattr(robot.water, law)).model_fields
    return {
        name: (f"water.{law}", name) if name in own else ("links", areas.get(name, name))
        for name, _, _ in dict(_core.water_laws())[law]
    }


def _places(robot: Robot) -> dict[str, str]:
    """Name the place of each column of the core: an attribute of gait or robot."""
    tables = dict.fromkeys(("frequency", "amplitude", "phase", "bias"), "gait")
    tables |= dict.fromkeys(("length", "com", "mass", "inertia"), "links")
    tables |= {"bandwidth": "joints", "phase_offset": "joints", "density": "water"}
    places = {column: f"{table}.{column}" for column, table in tables.items()}
    return places | {column: f"{table}.{name}" for column, (table, name) in _water_columns(robot).items()}


def _columns(robot: Robot) -> dict[str, Sequence[float]]:
    """Values of the columns of the core, without those of the gait."""
    ideal = robot.model.joints == "ideal"
    columns: dict[str, Sequence[float]] = {
        "bandwidth": [math.inf if ideal or joints.bandwidth is None else joints.bandwidth for joints in robot.joints],
        "phase_offset": [joints.phase_offset for joints in robot.joints],
        "density": [robot.water.density],
    }
    columns |= {name: getattr(robot.links, name) for name in ("length", "com", "mass", "inertia")}
    coefficients = getattr(robot.water, robot.model.water)
    for column, (table, name) in _water_columns(robot).items():
        value = getattr(robot.links if table == "links" else coefficients, name)
        columns[column] = value if isinstance(value, tuple) else [value]
    return columns


def _make(robot: Robot, changes: Mapping[str, Sequence[float]]) -> _core.Model:
    """Make the model of a robot with other values for some columns."""
    group = [-1] * len(robot.links.name)
    share = [0.0] * len(robot.links.name)
    for g, joint_group in enumerate(robot.joints):
        for link, part in zip(joint_group.links, joint_group.share, strict=True):
            group[link], share[link] = g, part
    columns = _columns(robot)
    if changes:
        places = _places(robot)
        known = {places[column]: column for column in columns}
        for name, values in changes.items():
            if name not in known:
                fix = did_you_mean(name, known)
                raise InputError("must be a column of the robot's model", key="columns", value=shown(name), fix=fix)
            columns[known[name]] = values
    coefficients = dict(getattr(robot.water, robot.model.water))
    flags = {name: float(value) for name, value in coefficients.items() if isinstance(value, bool)}
    body = {"body_length": robot.body.length, "joint_group": group, "joint_share": share}
    return _core.Model(robot.model.water, columns | flags | body)
