"""Positions of a robot's links, seen from above."""

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot

Points = NDArray[np.complex128]


def body_points(robot: Robot, pose: Array, angles: Array) -> Points:
    """Return positions x + i y (instants, links + 1) [m] of nose, front end of every link behind it, and tail tip.

    `pose` (times, 3) [m], [rad], `angles` (times, links) [rad]; returns x + i y (times, links + 1) [m].
    """
    theta = pose[:, 2:] + np.cumsum(angles, axis=1)
    steps = np.array(robot.links.length) * (np.cos(theta) + 1j * np.sin(theta))
    nose = pose[:, :1] + 1j * pose[:, 1:2]
    return np.concatenate([nose, nose + np.cumsum(steps, axis=1)], axis=1)


def group_shares(robot: Robot) -> Array:
    """Return the share of each group's bend at the joint in front of every link (links, groups) [1]."""
    share = np.zeros((len(robot.links.name), len(robot.joints)))
    for g, group in enumerate(robot.joints):
        share[list(group.links), g] = group.share
    return share
