"""Project points in space onto the plane that the fish swims in, seen from above."""

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.ranges import check_choice
from hypertuna.trials.points import Points

AXES = "xyz"  # names of the axes
AXIS_COSINE = np.cos(np.radians(20))  # a normal within this angle of an axis is taken as that axis
MAX_THICKNESS = 0.5  # largest spread off the plane, over that across the fish, for which the plane is clear
MAX_POINTS = 20_000  # from which the plane is found
# By axis that points up: index and sign of the plane's two axes, the second counter-clockwise from the first.
PLANE_AXES = {0: ((1, 1.0), (2, 1.0)), 1: ((0, 1.0), (2, -1.0)), 2: ((0, 1.0), (1, 1.0))}


def on_plane(points: Points, vertical: str | None = None) -> tuple[Array, tuple[str, ...]]:
    """Return places (rows, points, 2) on the swimming plane, in the file's unit, and notes on the plane.

    The axis that points up is the given one, or the form's, or else the normal of the plane of least variance.
    """
    if vertical is not None:
        check_choice(vertical, AXES, "--vertical")
    if points.place.shape[2] == 2:
        return points.place, ()
    up = points.vertical if vertical is None else AXES.index(vertical)
    if up is not None:
        return _seen(points.place, up), (f"points in space are seen from above, along {AXES[up]}",)
    complete = points.place[np.isfinite(points.place).all(axis=2)]
    if len(complete) < 3:
        return points.place[..., :2], ()
    complete = complete[:: len(complete) // MAX_POINTS + 1]
    _, spread, axes = np.linalg.svd(complete - complete.mean(axis=0), full_matrices=False)
    normal = axes[2]
    up = int(np.argmax(np.abs(normal)))
    if spread[2] > MAX_THICKNESS * spread[1]:
        rule = "must say which axis points up: the points do not lie in one plane"
        raise InputError(rule, file=points.file, key="--vertical", fix="give --vertical x, y or z")
    rms = spread[2] / np.sqrt(len(complete))
    side = (
        f"the plane of least variance, which the points leave by {rms:.2g} of the file's units; if {AXES[up]} points "
    )
    if abs(normal[up]) > AXIS_COSINE:
        flat = _seen(points.place, up)
        return flat, (f"points in space are seen along {AXES[up]}, across {side}down, give --y-axis down",)
    normal = normal * np.sign(normal[up])
    (first, sign), _ = PLANE_AXES[up]
    east = sign * np.eye(3)[first] - sign * normal[first] * normal
    east = east / np.linalg.norm(east)
    flat = points.place @ np.column_stack([east, np.cross(normal, east)])
    return flat, (f"points in space are seen across {side}down, give --y-axis down",)


def _seen(place: Array, up: int) -> Array:
    """Return places (..., 2) as seen from above; up: index of the axis that points up."""
    return np.stack([sign * place[..., axis] for axis, sign in PLANE_AXES[up]], axis=-1)
