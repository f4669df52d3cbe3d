"""Motion of a body as a labeled dataset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.pose import Points, body_points, group_shares
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.io.files import dataset

if TYPE_CHECKING:
    import xarray as xr


def trajectory(
    robot: Robot,
    time: Array,
    joints: Array,
    motion: Mapping[str, Any],
    *,
    current: tuple[float, float] = (0.0, 0.0),
    driven: Array | None = None,
    hinge_power: Array | float = 0.0,
) -> xr.Dataset:
    """Return a motion that the core computed as a dataset, labeled with units.

    `time` (times,) [s], `joints` (times, links, 3) [rad], [rad/s], [rad/s^2], `current` [m/s]. If a hinge yields,
    `driven` is the part of `joints` that the joint groups move, whose power counts as mechanical power beside
    `hinge_power` (times,) [W], that of the moments at hinges.
    """
    driven = joints if driven is None else driven
    pose = np.array(motion["pose"])
    pose[:, :2] += np.outer(time, current)
    twist, torque = motion["twist"], motion["torque"]
    tail = body_points(robot, pose, joints[:, :, 0])[:, -1]
    power = torque * driven[:, :, 1]
    groups = [joint.name for joint in robot.joints]
    members = [list(joint.links) for joint in robot.joints]
    coupling = group_shares(robot) / [joint.turns for joint in robot.joints]  # motor torque over joint torque

    def per_group(column: Array) -> Array:
        return np.stack([column[:, links].sum(axis=1) for links in members], axis=1)

    heading = pose[:, 2]
    ahead = -twist[:, 0]
    variables = {
        "x": ("time", pose[:, 0], "m", "position of the nose"),
        "y": ("time", pose[:, 1], "m", "position of the nose"),
        "heading": ("time", heading, "rad", "angle of the head's axis (nose to tail) from x, counter-clockwise"),
        "u": ("time", twist[:, 0], "m/s", "velocity of the nose through the water along the head's axis, to the tail"),
        "v": ("time", twist[:, 1], "m/s", "velocity of the nose through the water across the head's axis"),
        "r": ("time", twist[:, 2], "rad/s", "rate of turn of the head, counter-clockwise"),
        "forward_speed": ("time", ahead, "m/s", "velocity of the nose through the water along the head's axis, ahead"),
        "tail_x": ("time", tail.real, "m", "position of the tail tip"),
        "tail_y": ("time", tail.imag, "m", "position of the tail tip"),
        "joint_angle": (("time", "link"), joints[:, :, 0], "rad", "angle of the joint at the front of the link"),
        "joint_rate": (("time", "link"), joints[:, :, 1], "rad/s", "rate of the joint"),
        "joint_torque": (("time", "link"), torque, "N m", "torque of the joint on the link"),
        "bend": (("time", "group"), per_group(driven[:, :, 0]), "rad", "angle of the joint group"),
        "group_mechanical_power": (("time", "group"), per_group(power), "W", "mechanical power of the joint group"),
        "motor_torque": (("time", "group"), torque @ coupling, "N m", "torque at the axle or drum of the joint group"),
        "mechanical_power": ("time", power.sum(axis=1) + hinge_power, "W", "mechanical power of all joints"),
        "power_to_water": ("time", motion["loss"], "W", "power that the water takes"),
        "energy": ("time", motion["energy"], "J", "kinetic energy of body and entrained water"),
    }
    names = {"link": ("link", list(robot.links.name)), "group": ("group", groups)}
    facts = {"current_x_m_s": current[0], "current_y_m_s": current[1]}
    return dataset(variables, {"time": ("time", time, "s", "time")} | names, provenance(robot) | facts)


def nose_points(motion: xr.Dataset) -> Points:
    """Return the positions x + i y of the nose (times,) [m]."""
    points: Points = motion.x.values + 1j * motion.y.values
    return points


def center_of(motion: xr.Dataset) -> complex:
    """Return the center x + i y [m] about which a settled beat turns."""
    nose = nose_points(motion)
    spin = np.exp(1j * (motion.heading.values[-1] - motion.heading.values[0]))
    return complex((nose[-1] - spin * nose[0]) / (1 - spin))


def body_of(robot: Robot, motion: xr.Dataset) -> Points:
    """Return the positions x + i y of the joints of the body (times, links + 1) [m]."""
    pose = np.stack([motion.x.values, motion.y.values, motion.heading.values], axis=-1)
    return body_points(robot, np.atleast_2d(pose), np.atleast_2d(motion.joint_angle.values))
