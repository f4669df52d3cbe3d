"""Inertia with added mass, and drag along and across, of each link in water, as the core computes them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.simulation.sea import link_bodies
from hypertuna.swimming.model import model_columns

PER_GROUP = ("bandwidth", "phase_offset")


@dataclass(frozen=True)
class LinkWater:
    """Inertia and drag of a straight link alone in still water: no beating, no wake."""

    inertia: Array  # (3, 3) along it, across it, turn, at its center of mass, with the link's own [kg, kg m, kg m^2]
    along: float  # kg/m: force along it per speed squared
    across: float  # kg/m
    turn: float  # kg m^2: moment per rate of turn squared, about its center of mass


def links_water(robot: Robot) -> list[LinkWater]:
    """Return inertia and drag of each link by the robot's water law."""
    columns = model_columns(robot, {})
    return [_link_alone(robot, columns, i) for i in range(len(robot.links.name))]


def _link_alone(robot: Robot, columns: dict[str, Any], link: int) -> LinkWater:
    """Return inertia and drag of a body that is this link alone."""
    links = len(robot.links.name)

    def pick(name: str, value: Any) -> Any:
        column = np.ravel(np.asarray(value, dtype=float))
        return column[link : link + 1] if name not in PER_GROUP and np.ndim(value) and len(column) == links else value

    alone = {name: pick(name, value) for name, value in columns.items()} | {"joint_group": [-1], "joint_share": [0.0]}
    if "edge_aspect" in alone and link < links - 1:  # no tail fin, whose added mass has a place of its own
        alone["edge_aspect"] = 0.0
    # Backward, across, and turning: the tail fin pushes only along itself then. Twists of the nose.
    from_com = np.array([[1.0, 0, 0], [0, 1, -robot.links.com[link]], [0, 0, 1]])
    twists = from_com.T
    answer = _core.dynamics(
        _core.Model(robot.model.water, alone), np.zeros((6, 1, 3)), np.concatenate([twists, 2 * twists])
    )
    force = -answer["wrench"] @ from_com  # at the center of mass
    linear_and_square = np.array([np.diag(force[:3]), np.diag(force[3:])])  # b + a, 2 b + 4 a
    along, across, turn = (linear_and_square[1] - 2 * linear_and_square[0]) / 2
    return LinkWater(from_com.T @ answer["inertia"][0] @ from_com, float(along), float(across), float(turn))


def lost_drag(robot: Robot) -> list[str]:
    """List the parts of the law's drag that are no squares of the speeds along and across, in words."""
    coefficients = getattr(robot.water, robot.model.water)
    parts = {
        "cross_flow": "cross flow in the drag: v_n |v_n| stands for v_n |v|",
        "drag_beating": "the drag that beating adds",
        "linear_tangential": "linear drag along the links",
        "linear_normal": "linear drag across the links",
    }
    return [text for name, text in parts.items() if np.any(getattr(coefficients, name, False))]


def balanced(moments: Sequence[float]) -> tuple[Array, Array]:
    """Return moments of inertia (3,) that a rigid body can have, and what `moments` have beyond them [kg m^2].

    No moment of a body exceeds the sum of the two others; a rod's about z beside an ellipsoid's about x and y may.
    """
    body = np.array(moments, dtype=np.float64)
    largest = int(np.argmax(body))
    body[largest] = min(body[largest], 0.999 * (body.sum() - body[largest]))
    return body, moments - body


def moments(robot: Robot, link: int) -> tuple[float, float, float]:
    """Return a link's moments of inertia about its center of mass, along, across and up [kg m^2]."""
    turn = robot.links.inertia[link]
    if robot.spatial is None:  # nothing turns but about the axis up
        return turn, turn, turn
    bodies = link_bodies(robot)
    return float(bodies["roll"][link]), float(bodies["pitch"][link]), turn


def rotor(robot: Robot) -> float:
    """Return the inertia of joints' rotors [kg m^2]: more than robot and water have about any joint."""
    return sum(float(water.inertia[1, 1]) for water in links_water(robot)) * robot.body.length**2
