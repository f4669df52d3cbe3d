"""From a robot's description to the core's model of it."""

from __future__ import annotations

import math
import weakref
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description import Robot

__all__ = ["core_model", "parameter_names", "twist_from_rest"]

_models: dict[int, _core.Model] = {}


def core_model(robot: Robot) -> _core.Model:
    """Return the core's model of a robot with its choice of water law, areas and joints.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    _core.Model
        Made once for each robot object and kept as long as that lives.
    """
    model = _models.get(id(robot))
    if model is None:
        model = _models[id(robot)] = _make(robot)
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
    friction_area, drag_area = _areas(robot)
    law = f"water.{robot.model.water}"
    tables = dict.fromkeys(("frequency", "amplitude", "phase", "bias"), "gait")
    tables |= dict.fromkeys(("length", "com", "mass", "inertia", "lateral_area", "wetted_area"), "links")
    tables |= {"bandwidth": "joints", "density": "water"}
    areas = {"friction_area": f"links.{friction_area}", "drag_area": f"links.{drag_area}"}

    def full(name: str) -> str:
        column, bracket, index = name.partition("[")
        return areas.get(column, f"{tables.get(column, law)}.{column}") + bracket + index

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


def _make(robot: Robot) -> _core.Model:
    links = robot.links
    group = [-1] * len(links.name)
    share = [0.0] * len(links.name)
    for g, joint_group in enumerate(robot.joints):
        for link, part in zip(joint_group.links, joint_group.share, strict=True):
            group[link], share[link] = g, part
    ideal = robot.model.joints == "ideal"
    bandwidth = [math.inf if ideal or joints.bandwidth is None else joints.bandwidth for joints in robot.joints]
    columns: dict[str, Sequence[float]] = {
        "length": links.length,
        "com": links.com,
        "mass": links.mass,
        "inertia": links.inertia,
        "density": [robot.water.density],
    }
    return _core.Model(
        law=robot.model.water,
        cross_flow=robot.water.strip is not None and robot.water.strip.cross_flow,
        length=robot.body.length,
        joint_group=group,
        joint_share=share,
        bandwidth=bandwidth,
        columns=columns | _water(robot),
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
