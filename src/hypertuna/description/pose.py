"""Positions of a robot's links, seen from above."""

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot

Points = NDArray[np.complex128]  # positions x + i y [m]


def body_points(robot: Robot, pose: Array, angles: Array) -> Points:
    """Return the positions x + i y (times, links + 1) [m] of the nose and of every link's rear end.

    `pose` (times, 3): x, y [m] and heading [rad] of the head; `angles` (times, links) [rad].
    """
    theta = pose[:, 2:] + np.cumsum(angles, axis=1)
    steps = np.array(robot.links.length) * (np.cos(theta) + 1j * np.sin(theta))
    nose = pose[:, :1] + 1j * pose[:, 1:2]
    return np.concatenate([nose, nose + np.cumsum(steps, axis=1)], axis=1)


def group_shares(robot: Robot) -> Array:
    """Return the share of each joint group's bend that every link's front joint takes (links, groups) [1]."""
    share = np.zeros((len(robot.links.name), len(robot.joints)))
    for g, group in enumerate(robot.joints):
        share[list(group.links), g] = group.share
    return share


def coordinate_names(robot: Robot) -> tuple[str, ...]:
    """Return the names of the joint groups, then those of the hinges: ``hinge``, or ``hinge_1`` of several."""
    several = len(robot.hinges) > 1
    hinges = (f"hinge_{d + 1}" if several else "hinge" for d in range(len(robot.hinges)))
    return (*(group.name for group in robot.joints), *hinges)


def coordinate_shares(robot: Robot) -> Array:
    """Return the share of each of D coordinates (joint groups, then hinges) at every link's joint (links, D) [1]."""
    hinges = np.zeros((len(robot.links.name), len(robot.hinges)))
    for d, hinge in enumerate(robot.hinges):
        hinges[hinge.link, d] = 1.0
    return np.hstack([group_shares(robot), hinges])
