"""Conversion of poses, twists and attitudes between our frames and NED (Fossen, FRD bodies) or ENU (FLU bodies).

Ours: the world is (x, y) with angles counter-clockwise seen from above. The body frame sits at the nose; its axis x_0
runs from nose to tail and y_0 is 90 degrees counter-clockwise of it, so the robot faces, and swims, toward -x_0.

| frame | pose | twist |
|---|---|---|
| ours | x, y of the nose; theta of axis x_0 | u, v along x_0, y_0; r counter-clockwise |
| ENU | x east, y north; yaw of the facing direction, counter-clockwise from east | forward, left; counter-clockwise |
| NED | x north, y east; heading of the facing direction, clockwise from north | surge, sway to starboard; clockwise |

Our x is east and our y is north. The origin stays at the nose. Angles are not wrapped: a steady turn stays continuous.

In space our z is up, in the world and in the body. An attitude is the unit quaternion w, x, y, z that turns body axes
into world axes. Roll, pitch and heading are Fossen's angles of the NED attitude: starboard down, nose up, clockwise
from north.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.ranges import check_name

Frame = Literal["ned", "enu"]  # frames other than ours

# A and b of the map theirs = A ours + b, with A orthogonal.
_POSE: dict[str, tuple[Array, Array]] = {
    "enu": (np.eye(3), np.array([0.0, 0.0, np.pi])),  # yaw = theta + pi
    "ned": (np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.array([0.0, 0.0, -np.pi / 2])),  # psi = -pi/2 - theta
}
_TWIST: dict[str, tuple[Array, Array]] = {
    "enu": (np.diag([-1.0, -1.0, 1.0]), np.zeros(3)),
    "ned": (np.diag([-1.0, 1.0, -1.0]), np.zeros(3)),
}
# In space: quaternions of the half turns from our axes to theirs, of the world and of the body.
_HALF = np.sqrt(0.5)
_TURNS: dict[str, tuple[Array, Array]] = {
    "enu": (np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 1.0])),  # about z
    "ned": (np.array([0.0, _HALF, _HALF, 0.0]), np.array([0.0, 0.0, 1.0, 0.0])),  # about northeast; about y
}


def pose_to(frame: Frame, pose: ArrayLike) -> Array:
    """Convert poses of the head (..., 3) from our world frame, x, y [m], theta [rad].

    NED: north, east [m], heading [rad]; ENU: east, north [m], yaw [rad].

    Examples
    --------
    A robot whose tail points east faces west:

    >>> float(np.degrees(pose_to("ned", [1.0, 2.0, 0.0])[2]))
    -90.0
    """
    return _forward(_POSE, frame, "pose", pose)


def pose_from(frame: Frame, pose: ArrayLike) -> Array:
    """Convert poses of the head (..., 3) to our world frame, x, y [m], theta [rad]: the inverse of `pose_to`."""
    return _backward(_POSE, frame, "pose", pose)


def twist_to(frame: Frame, twist: ArrayLike) -> Array:
    """Convert twists of the head (..., 3) from our body frame, u, v [m/s] of the nose, r [rad/s].

    NED: surge, sway to starboard [m/s], clockwise yaw rate [rad/s]; ENU: forward, left, counter-clockwise.

    Examples
    --------
    Swimming forward is negative in ours and positive in theirs:

    >>> float(twist_to("ned", [-0.5, 0.0, 0.0])[0])
    0.5
    """
    return _forward(_TWIST, frame, "twist", twist)


def twist_from(frame: Frame, twist: ArrayLike) -> Array:
    """Convert twists of the head (..., 3) to our body frame, u, v [m/s], r [rad/s]: the inverse of `twist_to`."""
    return _backward(_TWIST, frame, "twist", twist)


def attitude_to(frame: Frame, attitude: ArrayLike) -> Array:
    """Convert attitudes of the head from our axes, unit quaternions (..., 4), in world and body axes alike.

    Examples
    --------
    A robot whose tail points south faces north, level:

    >>> tail_south = attitude_of(roll=0.0, pitch=0.0, heading=0.0)
    >>> attitude_to("ned", tail_south).round(12).tolist()
    [1.0, 0.0, 0.0, 0.0]
    """
    world, body = _affine_map(_TURNS, frame)
    return _with_positive_w(_product(_product(world, _quaternions(attitude)), _conjugate(body)))


def attitude_from(frame: Frame, attitude: ArrayLike) -> Array:
    """Convert attitudes of the head (..., 4) to our axes, w not negative: the inverse of `attitude_to`."""
    world, body = _affine_map(_TURNS, frame)
    return _with_positive_w(_product(_product(_conjugate(world), _quaternions(attitude)), body))


def angles_of(attitude: ArrayLike) -> Array:
    """Return roll, pitch and heading, 0 to 2 pi, of attitudes (..., 4): (..., 3) [rad].

    Examples
    --------
    A robot whose tail points west faces east:

    >>> np.degrees(angles_of([0.0, 0.0, 0.0, 1.0])).round(9).tolist()
    [0.0, 0.0, 90.0]
    """
    rotation = rotation_of(attitude_to("ned", attitude))
    roll = np.arctan2(rotation[..., 2, 1], rotation[..., 2, 2])
    pitch = -np.arcsin(np.clip(rotation[..., 2, 0], -1.0, 1.0))
    heading = np.arctan2(rotation[..., 1, 0], rotation[..., 0, 0]) % (2 * np.pi)
    return np.stack([roll, pitch, heading], axis=-1) + 0.0  # turns -0.0 into 0.0


def attitude_of(*, roll: float, pitch: float, heading: float) -> Array:
    """Return the attitude of a roll, a pitch and a heading [rad], w not negative: the inverse of `angles_of`."""
    half = np.array([roll, pitch, heading]) / 2
    turns = np.column_stack([np.cos(half), np.diag(np.sin(half))])
    return attitude_from("ned", _product(_product(turns[2], turns[1]), turns[0]))


def rotation_of(attitude: ArrayLike) -> Array:
    """Return rotation matrices (..., 3, 3) of attitudes (..., 4): columns are the body's axes in the world."""
    w, x, y, z = np.moveaxis(_quaternions(attitude), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _product(a: Array, b: Array) -> Array:
    """Return the product a b of quaternions (..., 4)."""
    scalar = a[..., 0] * b[..., 0] - (a[..., 1:] * b[..., 1:]).sum(axis=-1)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar[..., np.newaxis], vector], axis=-1)


def _conjugate(q: Array) -> Array:
    result: Array = q * np.array([1.0, -1.0, -1.0, -1.0])
    return result


def _with_positive_w(q: Array) -> Array:
    """Return quaternions (..., 4) or their negatives, which are the same attitudes: those whose w is not negative."""
    result: Array = np.where(q[..., :1] < 0, -q, q) + 0.0
    return result


def _array(values: ArrayLike, size: int, key: str, fix: str) -> Array:
    """Return an array whose last axis has a given size."""
    array = np.asarray(values, dtype=float)
    if array.ndim == 0 or array.shape[-1] != size:
        raise InputError(f"must have shape (..., {size})", key=key, value=f"of shape {array.shape}", fix=fix)
    return array


def _quaternions(values: ArrayLike) -> Array:
    return _array(values, 4, "attitude", "give w, x, y and z")


def _triples(key: str, values: ArrayLike) -> Array:
    return _array(values, 3, key, "give two coordinates and an angle")


def _forward(maps: dict[str, tuple[Array, Array]], frame: str, key: str, values: ArrayLike) -> Array:
    """Return values (..., 3) in another frame from ours: theirs = A ours + b."""
    matrix, offset = _affine_map(maps, frame)
    result: Array = _triples(key, values) @ matrix.T + offset
    return result


def _backward(maps: dict[str, tuple[Array, Array]], frame: str, key: str, values: ArrayLike) -> Array:
    """Return values (..., 3) in our frame from another: ours = A^T (theirs - b); A is orthogonal."""
    matrix, offset = _affine_map(maps, frame)
    result: Array = (_triples(key, values) - offset) @ matrix
    return result


def _affine_map(maps: dict[str, tuple[Array, Array]], frame: str) -> tuple[Array, Array]:
    """Return matrix A and offset b of the map to a frame, or the quaternions of its axes."""
    return maps[check_name(frame, maps, "frame", "frame")]
