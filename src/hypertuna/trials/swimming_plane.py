"""Points in space on the plane that the fish swims in, seen from above."""

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.ranges import check_choice
from hypertuna.trials.points import Points

AXES = "xyz"
SNAP = np.cos(np.radians(20))  # a normal nearer to an axis is that axis
FLAT = 0.5  # of the spread across the fish: points that leave their plane by more do not say which plane it is
MOST = 20_000  # points from which the plane is found
# The two axes of the plane seen against each axis that points up, so that the second is counter-clockwise of the first.
SEEN = {0: ((1, 1.0), (2, 1.0)), 1: ((0, 1.0), (2, -1.0)), 2: ((0, 1.0), (1, 1.0))}


def on_plane(points: Points, vertical: str | None = None) -> tuple[Array, tuple[str, ...]]:
    """Return places (rows, points, 2) on the swimming plane, in the file's unit, and sentences on the plane.

    The axis that points up is the given one, or that of the form, or the normal of the plane of least variance.
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
    complete = complete[:: len(complete) // MOST + 1]
    _, spread, axes = np.linalg.svd(complete - complete.mean(axis=0), full_matrices=False)
    normal = axes[2]
    up = int(np.argmax(np.abs(normal)))
    if spread[2] > FLAT * spread[1]:
        rule = "must say which axis points up: the points do not lie in one plane"
        raise InputError(rule, file=points.file, key="--vertical", fix="give --vertical x, y or z")
    rms = spread[2] / np.sqrt(len(complete))
    side = (
        f"the plane of least variance, which the points leave by {rms:.2g} of the file's units; if {AXES[up]} points "
    )
    if abs(normal[up]) > SNAP:
        flat = _seen(points.place, up)
        return flat, (f"points in space are seen along {AXES[up]}, across {side}down, give --y-axis down",)
    normal = normal * np.sign(normal[up])
    (first, sign), _ = SEEN[up]
    east = sign * np.eye(3)[first] - sign * normal[first] * normal
    east = east / np.linalg.norm(east)
    flat = points.place @ np.column_stack([east, np.cross(normal, east)])
    return flat, (f"points in space are seen across {side}down, give --y-axis down",)


def _seen(place: Array, up: int) -> Array:
    """Return places (..., 2) as seen from above, for the axis `up` that points up."""
    return np.stack([sign * place[..., axis] for axis, sign in SEEN[up]], axis=-1)
