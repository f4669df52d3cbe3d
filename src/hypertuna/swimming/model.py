"""Core model of a robot: its columns of parameters, and the place of each column in the robot's description."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.description.robot import Robot, cached
from hypertuna.description.schema.water import LAWS
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.swimming.gait import KINDS, Gait


def core_model(robot: Robot, columns: Mapping[str, Sequence[float]] | None = None) -> _core.Model:
    """Return the core's model of a robot; `columns` replaces some of its columns [SI].

    Columns are named as in `parameter_names`, without index: ``water.lumped.drag``, ``links.mass`` [kg]. Values of the
    description that depend on them (the inertia of a slender rod, the robot's mass) are not changed.
    """
    if columns is not None:
        return _core.Model(robot.model.water, model_columns(robot, columns))
    return cached(robot, "core_model", lambda: _core.Model(robot.model.water, model_columns(robot, {})))


def parameter_names(robot: Robot) -> tuple[str, ...]:
    """Return the names of all parameters with respect to which results have derivatives: ``links.mass[3]``, ..."""
    places = {name: f"gait.{name}" for name in ("frequency", *KINDS)}
    places |= {column: place for column, (place, _) in _columns(robot).items()}

    def full(name: str) -> str:
        column, bracket, index = name.partition("[")
        return places[column] + bracket + index

    return tuple(full(name) for name in core_model(robot).parameter_names())


def parameter_values(robot: Robot, gait: Gait) -> NDArray[np.float64]:
    """Return the value of every parameter of `parameter_names` (parameters,) [SI]."""
    columns = {name: values for name, (_, values) in _columns(robot).items()}
    columns |= {"frequency": [gait.frequency], **{kind: getattr(gait, kind) for kind in KINDS}}

    def value(name: str) -> float:
        column, _, index = name.rstrip("]").partition("[")
        return columns[column][int(index or 0)]

    return np.array([value(name) for name in core_model(robot).parameter_names()])


def link_shares(robot: Robot) -> dict[int, float]:
    """Return each joint's share of its tendon's bend [1], by the index of the link behind the joint.

    It is empty for a robot with passive hinges: its beats have derivatives with respect to springs, not to shares.
    """
    groups = [group for group in robot.joints if group.tendons is not None and not robot.hinges]
    return {k: share for one in groups for k, share in zip(one.links, one.share, strict=True)}


def share_values(robot: Robot) -> dict[str, float]:
    """Return the shares of `link_shares` by parameter name: ``joints.share[3]`` at link 3 [1]."""
    return {f"joints.share[{k}]": share for k, share in link_shares(robot).items()}


def model_values(robot: Robot) -> dict[str, Sequence[float]]:
    """Return the columns of the robot's model [SI], which `core_model` can replace, by place in the description."""
    return dict(_columns(robot).values())


def column_places(robot: Robot) -> dict[str, str]:
    """Return the place in the description of each model column, by column name: ``length`` is at ``links.length``."""
    return {column: place for column, (place, _) in _columns(robot).items()}


def twist_from_rest(robot: Robot, joints: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the twist (3,) [m/s, m/s, rad/s] just after the joints of a resting robot start: the momentum is 0.

    joints (links, 3): angle [rad], rate [rad/s], acceleration [rad/s^2] of the front joint of every link. The momentum
    is M xi + b for the twist xi.
    """
    still = _core.dynamics(core_model(robot), np.ascontiguousarray(joints[np.newaxis]), np.zeros((1, 3)))
    return -np.linalg.solve(still["inertia"][0], still["momentum"][0])


def _columns(robot: Robot) -> dict[str, tuple[str, Sequence[float]]]:
    """Return the place in the description and the values [SI] of each core column, by name, without the gait's."""
    law, links = robot.model.water, robot.links
    ideal = robot.model.joints == "ideal"
    bandwidths = [math.inf if ideal or joints.bandwidth is None else joints.bandwidth for joints in robot.joints]
    columns: dict[str, tuple[str, Sequence[float]]] = {
        name: (f"links.{name}", getattr(links, name)) for name in ("length", "com", "mass", "inertia")
    }
    columns["bandwidth"] = ("joints.bandwidth", bandwidths)
    columns["phase_offset"] = ("joints.phase_offset", [joints.phase_offset for joints in robot.joints])
    columns["density"] = ("water.density", [robot.water.density])
    coefficients = getattr(robot.water, law)
    areas = LAWS[law].areas.get(robot.model.areas, {})
    for name, _, _ in dict(_core.water_laws())[law]:
        in_law = name in type(coefficients).model_fields
        place = name if in_law else areas.get(name, name)
        value = getattr(coefficients if in_law else links, place)
        columns[name] = (
            f"water.{law}.{place}" if in_law else f"links.{place}",
            value if isinstance(value, tuple) else [value],
        )
    return columns


def model_columns(robot: Robot, changes: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    """Return the columns from which the core makes a robot's model; changes: new values of some columns, by place."""
    group = [-1] * len(robot.links.name)
    share = [0.0] * len(robot.links.name)
    for g, joint_group in enumerate(robot.joints):
        for link, fraction in zip(joint_group.links, joint_group.share, strict=True):
            group[link], share[link] = g, fraction
    columns = _columns(robot)
    by_place = {place: column for column, (place, _) in columns.items()}
    for place in changes:
        if place not in by_place:
            fix = did_you_mean(place, by_place)
            raise InputError("must be a column of the robot's model", key="columns", value=shown(place), fix=fix)
    values = {column: changes.get(place, value) for column, (place, value) in columns.items()}
    coefficients = dict(getattr(robot.water, robot.model.water))
    flags = {name: float(value) for name, value in coefficients.items() if isinstance(value, bool)}
    body = {"body_length": robot.body.length, "joint_group": group, "joint_share": share}
    return values | flags | body
