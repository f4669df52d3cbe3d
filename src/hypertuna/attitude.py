"""Attitudes: unit quaternions that take vectors of the body to the world, as angles that people read.

Body axes are those of docs/conventions.md: x from nose to tail, y to starboard, z up; the world has x east, y north and
z up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["angles", "attitude", "multiplied", "rotated", "turned_about"]

Array = NDArray[np.float64]


def rotated(quaternion: ArrayLike, vector: ArrayLike) -> Array:
    """Take vectors from the body to the world.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Unit quaternions w, x, y, z, body to world [1].
    vector : array_like, shape (..., 3)
        In the body [any unit].

    Returns
    -------
    ndarray, shape (..., 3)
        In the world [the same unit].
    """
    q, v = np.asarray(quaternion, float), np.asarray(vector, float)
    w, axis = q[..., :1], q[..., 1:]
    cross = 2 * np.cross(axis, v)
    result: Array = v + w * cross + np.cross(axis, cross)
    return result


def angles(quaternion: ArrayLike) -> Array:
    """Return roll, pitch and heading.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Unit quaternions w, x, y, z, body to world [1].

    Returns
    -------
    ndarray, shape (..., 3)
        Roll, starboard down positive; pitch, nose up positive; heading that the head faces, clockwise from north,
        from 0 to less than 2 pi [rad].
    """
    ahead, starboard, up = (rotated(quaternion, axis) for axis in ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    roll = np.arctan2(-starboard[..., 2], up[..., 2])
    pitch = np.arctan2(ahead[..., 2], np.hypot(ahead[..., 0], ahead[..., 1]))
    heading = np.arctan2(ahead[..., 0], ahead[..., 1]) % (2 * np.pi)
    return np.stack([roll, pitch, heading], axis=-1)


def attitude(roll: ArrayLike, pitch: ArrayLike, heading: ArrayLike) -> Array:
    """Return the attitude of angles: first the heading, then the pitch, then the roll.

    Parameters
    ----------
    roll, pitch, heading : array_like, shape (...)
        As `angles` tells them [rad].

    Returns
    -------
    ndarray, shape (..., 4)
        Unit quaternion w, x, y, z, body to world [1].
    """
    yaw = -np.pi / 2 - np.asarray(heading, float)  # of the axis from nose to tail, counter-clockwise from east
    first = turned_about(2, yaw)
    # With x to the tail a positive angle about y takes the tail down, so the nose up; about x it takes starboard up.
    second, third = turned_about(1, np.asarray(pitch, float)), turned_about(0, -np.asarray(roll, float))
    return multiplied(multiplied(first, second), third)


def turned_about(axis: int, angle: ArrayLike) -> Array:
    """Return the quaternion of a turn about an axis.

    Parameters
    ----------
    axis : int
        0, 1 or 2 for x, y or z.
    angle : array_like, shape (...)
        [rad].

    Returns
    -------
    ndarray, shape (..., 4)
        w, x, y, z [1].
    """
    half = np.asarray(angle, float) / 2
    result = np.zeros((*half.shape, 4))
    result[..., 0], result[..., 1 + axis] = np.cos(half), np.sin(half)
    return result


def multiplied(first: ArrayLike, second: ArrayLike) -> Array:
    """Multiply quaternions: the turn of the second, then that of the first.

    Parameters
    ----------
    first, second : array_like, shape (..., 4)
        w, x, y, z [1].

    Returns
    -------
    ndarray, shape (..., 4)
        w, x, y, z [1].
    """
    a, b = np.asarray(first, float), np.asarray(second, float)
    w = a[..., 0] * b[..., 0] - (a[..., 1:] * b[..., 1:]).sum(axis=-1)
    v = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([w[..., np.newaxis], v], axis=-1)
