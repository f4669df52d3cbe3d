"""From a robot's description to the core's model of it."""

from __future__ import annotations

import math
import weakref
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown

__all__ = ["core_model", "parameter_names", "twist_from_rest"]

_models: dict[int, _core.Model] = {}


def core_model(robot: Robot, columns: Mapping[str, Sequence[float]] | None = None) -> _core.Model:
    """Return the core's model of a robot with its choice of water law, areas and joints.

    Parameters
    ----------
    robot : Robot
    columns : mapping, optional
        Values to take in place of the robot's, one per link or joint group, by the names of `parameter_names` without
        index: ``water.lumped.drag``, ``links.mass`` [kg], ``joints.phase_offset`` [rad]. What follows from them in a
        description (a slender rod's inertia, the mass of the whole robot) stays as it is.

    Returns
    -------
    _core.Model
        Without `columns` made once for each robot object and kept as long as that lives.

    Raises
    ------
    InputError
        If the model has no such column.
    """
    if columns is not None:
        return _make(robot, columns)
    model = _models.get(id(robot))
    if model is None:
        model = _models[id(robot)] = _make(robot, {})
        weakref.finalize(robot, _models.pop, id(robot), None)
    return model


def parameter_names(robot: Robot) -> tuple[str, ...]:
    """Name every parameter that results have derivatives by.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    tuple of str
        As attributes of gait and robot, e.g. ``gait.amplitude[0]`` [rad], ``links.mass[3]`` [kg],
        ``water.lumped.drag[7]``.
    """
    places = _places(robot)

    def full(name: str) -> str:
        column, bracket, index = name.partition("[")
        return places[column] + bracket + index

    return tuple(full(name) for name in core_model(robot).parameter_names())


def twist_from_rest(robot: Robot, joints: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the motion of a robot at rest whose joints set in: its momentum P = M xi + b is still zero.

    Parameters
    ----------
    robot : Robot
    joints : ndarray, shape (links, 3)
        Angle [rad], rate [rad/s] and acceleration [rad/s^2] of the joint at the front of every link.

    Returns
    -------
    ndarray, shape (3,)
        Twist xi = -M^-1 b of the head in its own axes [m/s, m/s, rad/s].
    """
    still = _core.dynamics(core_model(robot), np.ascontiguousarray(joints[np.newaxis]), np.zeros((1, 3)))
    return -np.linalg.solve(still["inertia"][0], still["momentum"][0])


def _areas(robot: Robot) -> tuple[str, str]:
    """Tell which column of areas friction and drag of the lumped law go with."""
    return ("wetted_area", "lateral_area") if robot.model.areas == "consistent" else ("lateral_area", "wetted_area")


def _places(robot: Robot) -> dict[str, str]:
    """Name the place of each of the core's columns: an attribute of gait or robot."""
    friction_area, drag_area = _areas(robot)
    tables = dict.fromkeys(("frequency", "amplitude", "phase", "bias"), "gait")
    tables |= dict.fromkeys(_columns(robot), f"water.{robot.model.water}")
    tables |= dict.fromkeys(("length", "com", "mass", "inertia", "lateral_area", "wetted_area"), "links")
    tables |= {"bandwidth": "joints", "phase_offset": "joints", "density": "water"}
    places = {column: f"{table}.{column}" for column, table in tables.items()}
    return places | {"friction_area": f"links.{friction_area}", "drag_area": f"links.{drag_area}"}


def _columns(robot: Robot) -> dict[str, Sequence[float]]:
    """Values of the core's columns."""
    ideal = robot.model.joints == "ideal"
    bandwidth = [math.inf if ideal or joints.bandwidth is None else joints.bandwidth for joints in robot.joints]
    links = {name: getattr(robot.links, name) for name in ("length", "com", "mass", "inertia")}
    phase_offset = [joints.phase_offset for joints in robot.joints]
    joints = {"bandwidth": bandwidth, "phase_offset": phase_offset}
    return {**joints, **links, "density": [robot.water.density], **_water(robot)}


def _make(robot: Robot, changes: Mapping[str, Sequence[float]]) -> _core.Model:
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
    return _core.Model(
        law=robot.model.water,
        cross_flow=robot.water.strip is not None and robot.water.strip.cross_flow,
        length=robot.body.length,
        joint_group=group,
        joint_share=share,
        columns=columns,
    )


def _water(robot: Robot) -> dict[str, Sequence[float]]:
    """Coefficients of the chosen water law, by the core's names."""
    links, water = robot.links, robot.water
    if robot.model.water == "lumped":
        assert water.lumped is not None  # the description has checked it
        friction_area, drag_area = _areas(robot)
        return {
            "added_mass": water.lumped.added_mass,
            "friction": water.lumped.friction,
            "drag": water.lumped.drag,
            "friction_area": getattr(links, friction_area),
            "drag_area": getattr(links, drag_area),
        }
    assert water.strip is not None
    return {
        "lateral_area": links.lateral_area,
        "wetted_area": links.wetted_area,
        "added_mass_normal": water.strip.added_mass_normal,
        "added_mass_tangential": water.strip.added_mass_tangential,
        "added_inertia": water.strip.added_inertia,
        "drag_normal": water.strip.drag_normal,
        "drag_tangential": water.strip.drag_tangential,
        "linear_normal": water.strip.linear_normal,
        "linear_tangential": water.strip.linear_tangential,
        "tail_shedding": [water.strip.tail_shedding],
    }
