"""Whether muscles, a film on the axis, and oil pipes of the joints behind fit in a joint's sections."""

import math

from hypertuna.actuation.soft_joint import drive_unit, joint_group
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.fe.geometry import WALL, joint_body

PIPE = 1e-3  # m, wall thickness of an oil pipe
PIPES = 2  # oil pipes of a joint, one for each side


def with_room(robot: Robot, joint: int) -> Robot:
    """Return the robot with a joint's drive units far enough apart; InputError if they or oil pipes do not fit.

    The muscles must meet the rules of finite elements in the narrowest section (`joint_body`). A film on the axis must
    fit between the muscles of the two sides. The pipes of the joints behind must fit there, or above and below.
    """
    unit, (group, actuator) = drive_unit(robot), joint_group(robot, joint)
    spacing = unit.outer_diameter + WALL
    if actuator.spacing is None or actuator.spacing < spacing:
        group_spaced = group.model_copy(update={"actuator": actuator.model_copy(update={"spacing": spacing})})
        joints = tuple(group_spaced if g == joint else other for g, other in enumerate(robot.joints))
        robot = robot.model_copy(update={"joints": joints})
    body = joint_body(robot, joint)
    gap = min(actuator.levers) - body.radius - WALL
    if gap < 0:
        rule, fix = "must leave room for a film on the axis", "give a longer lever or thinner hoses"
        raise InputError(rule, key=f"joint {group.name}, lever_m", fix=fix)
    bores = [other.line.bore for other in robot.joints[joint + 1 :] if other.line is not None]
    pipe = max(bores, default=0.0) / 2 + PIPE
    if not bores or gap >= pipe:
        return robot
    top = max(channel.z for channel in body.channels)
    distance = body.radius + WALL + pipe
    lowest = top + math.sqrt(max(0.0, distance**2 - min(actuator.levers) ** 2))
    highest = lowest + (PIPES * len(bores) / 2 - 1) * (2 * pipe + WALL)  # half of the pipes are below
    if _to_rim(float(body.semi_major.min()), float(body.semi_minor.min()), highest) < pipe + WALL:
        rule, fix = "must leave room for the oil pipes of the joints behind", "give a longer lever or thinner hoses"
        raise InputError(rule, key=f"joint {group.name}, lever_m", fix=fix)
    return robot


def _to_rim(a: float, b: float, z: float) -> float:
    """Return the distance [m] from a point at z on the semi-axis a of an ellipse to its rim; negative outside."""
    if z < (a**2 - b**2) / a:  # there are two nearest points, on either side of the semi-axis
        return b * math.sqrt(1 - z**2 / (a**2 - b**2))
    return a - z
