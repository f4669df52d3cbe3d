"""Inertia with added mass, and drag, of each link alone in water, as the core computes them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.simulation.sea import link_bodies
from hypertuna.swimming.model import model_columns

PER_GROUP = ("bandwidth", "phase_offset")  # columns per joint group, not per link


@dataclass(frozen=True)
class LinkWater:
    """Inertia and drag of one straight link alone in still water, without beating or wake."""

    inertia: Array  # (3, 3) of link and added mass: along, across, yaw, about the center of mass [kg, kg m, kg m^2]
    along: float  # kg/m: drag along the link per speed squared
    across: float  # kg/m: drag across the link per speed squared
    turn: float  # kg m^2: drag moment about the center of mass per yaw rate squared


def links_water(robot: Robot) -> list[LinkWater]:
    """Return inertia and drag of each link, from the robot's water law."""
    columns = model_columns(robot, {})
    return [_link_alone(robot, columns, i) for i in range(len(robot.links.name))]


def _link_alone(robot: Robot, columns: dict[str, Any], link: int) -> LinkWater:
    """Return inertia and drag of one link, computed as a robot that consists of this link."""
    links = len(robot.links.name)

    def pick(name: str, value: Any) -> Any:
        column = np.ravel(np.asarray(value, dtype=float))
        return column[link : link + 1] if name not in PER_GROUP and np.ndim(value) and len(column) == links else value

    alone = {name: pick(name, value) for name, value in columns.items()} | {"joint_group": [-1], "joint_share": [0.0]}
    if "edge_aspect" in alone and link < links - 1:  # no tail fin, which has an added mass of its own
        alone["edge_aspect"] = 0.0
    # Twists of the nose: backward (the tail fin then pushes only along itself), across, yaw; at single and double rate.
    from_com = np.array([[1.0, 0, 0], [0, 1, -robot.links.com[link]], [0, 0, 1]])
    twists = from_com.T
    answer = _core.dynamics(
        _core.Model(robot.model.water, alone), np.zeros((6, 1, 3)), np.concatenate([twists, 2 * twists])
    )
    force = -answer["wrench"] @ from_com  # about the center of mass
    linear_and_square = np.array([np.diag(force[:3]), np.diag(force[3:])])  # b + a and 2 b + 4 a: b linear, a square
    along, across, turn = (linear_and_square[1] - 2 * linear_and_square[0]) / 2
    return LinkWater(from_com.T @ answer["inertia"][0] @ from_com, float(along), float(across), float(turn))


def lost_drag(robot: Robot) -> list[str]:
    """List, in words, the parts of the law's drag that are not squares of the speeds along and across."""
    coefficients = getattr(robot.water, robot.model.water)
    parts = {
        "cross_flow": "cross flow in the drag: v_n |v_n| stands for v_n |v|",
        "drag_beating": "the drag that beating adds",
        "linear_tangential": "linear drag along the links",
        "linear_normal": "linear drag across the links",
    }
    return [text for name, text in parts.items() if np.any(getattr(coefficients, name, False))]


def balanced(moments: Sequence[float]) -> tuple[Array, Array]:
    """Reduce moments of inertia (3,) to those of a possible rigid body; return these and the excess [kg m^2].

    No moment of a rigid body exceeds the sum of the two others; a mix of a rod's and an ellipsoid's may.
    """
    body = np.array(moments, dtype=np.float64)
    largest = int(np.argmax(body))
    body[largest] = min(body[largest], 0.999 * (body.sum() - body[largest]))
    return body, moments - body


def moments(robot: Robot, link: int) -> tuple[float, float, float]:
    """Return a link's moments of inertia about its center of mass, along, across and up [kg m^2]."""
    turn = robot.links.inertia[link]
    if robot.spatial is None:  # the robot turns only about the vertical
        return turn, turn, turn
    bodies = link_bodies(robot)
    return float(bodies["roll"][link]), float(bodies["pitch"][link]), turn


def rotor(robot: Robot) -> float:
    """Return an inertia for the joints' rotors [kg m^2] that is larger than robot and water have about any joint."""
    return sum(float(water.inertia[1, 1]) for water in links_water(robot)) * robot.body.length**2
