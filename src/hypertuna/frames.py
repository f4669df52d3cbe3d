"""Poses and twists between our planar frames and those of others: NED with FRD bodies (Fossen), ENU with FLU bodies.

Ours: the world is (x, y) with angles counter-clockwise seen from above. The body frame sits at the nose; its axis x_0
runs from nose to tail and y_0 is 90 degrees counter-clockwise of it, so the robot faces, and swims, toward -x_0.

| frame | pose | twist |
|---|---|---|
| ours | x, y of the nose; theta of axis x_0 | u, v along x_0, y_0; r counter-clockwise |
| ENU | x east, y north; yaw of the facing direction, counter-clockwise from east | forward, left; counter-clockwise |
| NED | x north, y east; heading of the facing direction, clockwise from north | surge, sway to starboard; clockwise |

Our x is east and our y is north. The origin stays at the nose. Angles are not wrapped: a steady turn stays continuous.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna.errors import InputError, did_you_mean, shown

__all__ = ["Frame", "pose_from", "pose_to", "twist_from", "twist_to"]

Frame = Literal["ned", "enu"]
Array = NDArray[np.float64]

# theirs = A ours + b, with A orthogonal.
_POSE: dict[str, tuple[Array, Array]] = {
    "enu": (np.eye(3), np.array([0.0, 0.0, np.pi])),  # yaw = theta + pi
    "ned": (np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.array([0.0, 0.0, -np.pi / 2])),  # psi = -pi/2 - theta
}
_TWIST: dict[str, tuple[Array, Array]] = {
    "enu": (np.diag([-1.0, -1.0, 1.0]), np.zeros(3)),
    "ned": (np.diag([-1.0, 1.0, -1.0]), np.zeros(3)),
}


def pose_to(frame: Frame, pose: ArrayLike) -> Array:
    """Convert poses of the head from our world frame.

    Parameters
    ----------
    frame : {"ned", "enu"}
        Frame to convert to.
    pose : array_like, shape (..., 3)
        x [m], y [m] of the nose and theta [rad] of the axis from nose to tail.

    Returns
    -------
    ndarray, shape (..., 3)
        NED: north [m], east [m], heading [rad]; ENU: east [m], north [m], yaw [rad].

    Raises
    ------
    InputError
        If the frame is unknown or the last axis does not have length 3.

    Examples
    --------
    A robot whose tail points east faces west:

    >>> float(np.degrees(pose_to("ned", [1.0, 2.0, 0.0])[2]))
    -90.0
    """
    return _forward(_POSE, frame, "pose", pose)


def pose_from(frame: Frame, pose: ArrayLike) -> Array:
    """Convert poses of the head to our world frame: the inverse of `pose_to`.

    Parameters
    ----------
    frame : {"ned", "enu"}
        Frame to convert from.
    pose : array_like, shape (..., 3)
        NED: north [m], east [m], heading [rad]; ENU: east [m], north [m], yaw [rad].

    Returns
    -------
    ndarray, shape (..., 3)
        x [m], y [m] of the nose and theta [rad] of the axis from nose to tail.

    Raises
    ------
    InputError
        If the frame is unknown or the last axis does not have length 3.
    """
    return _backward(_POSE, frame, "pose", pose)


def twist_to(frame: Frame, twist: ArrayLike) -> Array:
    """Convert twists of the head from our body frame.

    Parameters
    ----------
    frame : {"ned", "enu"}
        Frame whose body axes to convert to: forward-right-down or forward-left-up.
    twist : array_like, shape (..., 3)
        u, v [m/s] of the nose along x_0 and y_0, and r [rad/s] counter-clockwise.

    Returns
    -------
    ndarray, shape (..., 3)
        NED: surge, sway to starboard [m/s], yaw rate clockwise [rad/s];
        ENU: forward, left [m/s], yaw rate counter-clockwise [rad/s].

    Raises
    ------
    InputError
        If the frame is unknown or the last axis does not have length 3.

    Examples
    --------
    Swimming forward is negative in ours and positive in theirs:

    >>> float(twist_to("ned", [-0.5, 0.0, 0.0])[0])
    0.5
    """
    return _forward(_TWIST, frame, "twist", twist)


def twist_from(frame: Frame, twist: ArrayLike) -> Array:
    """Convert twists of the head to our body frame: the inverse of `twist_to`.

    Parameters
    ----------
    frame : {"ned", "enu"}
        Frame whose body axes to convert from.
    twist : array_like, shape (..., 3)
        As `twist_to` returns it.

    Returns
    -------
    ndarray, shape (..., 3)
        u, v [m/s] of the nose along x_0 and y_0, and r [rad/s] counter-clockwise.

    Raises
    ------
    InputError
        If the frame is unknown or the last axis does not have length 3.
    """
    return _backward(_TWIST, frame, "twist", twist)


def _forward(maps: dict[str, tuple[Array, Array]], frame: str, key: str, values: ArrayLike) -> Array:
    """Apply theirs = A ours + b."""
    matrix, offset = _map(maps, frame)
    result: Array = _triples(key, values) @ matrix.T + offset
    return result


def _backward(maps: dict[str, tuple[Array, Array]], frame: str, key: str, values: ArrayLike) -> Array:
    """Apply ours = A^T (theirs - b); A is orthogonal."""
    matrix, offset = _map(maps, frame)
    result: Array = (_triples(key, values) - offset) @ matrix
    return result


def _map(maps: dict[str, tuple[Array, Array]], frame: str) -> tuple[Array, Array]:
    """Return the affine map of a frame."""
    if frame not in maps:
        raise InputError("must be a known frame", key="frame", value=shown(frame), fix=did_you_mean(frame, maps))
    return maps[frame]


def _triples(key: str, values: ArrayLike) -> Array:
    """Return an array whose last axis has length 3."""
    array = np.asarray(values, dtype=float)
    if array.ndim == 0 or array.shape[-1] != 3:
        shape = f"of shape {array.shape}"
        raise InputError("must have shape (..., 3)", key=key, value=shape, fix="give two coordinates and an angle")
    return array
