"""Tracked markers or midline points over time, of any form of file: times in s, places in m on the swimming plane."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.ranges import POSITIVE, check_choice
from hypertuna.trials.clock import clock_of
from hypertuna.trials.forms import read_points
from hypertuna.trials.points import Points

MIN_FRAMES, MAX_MARKERS = 12, 300  # of a file; comparing each marker with all others takes time
SURE = 1.5  # a likelihood beyond it is no part of 1
PERCENT, FLAGS = 100.0, (0.0, 1.0, 2.0)  # flags of visibility: missing, hidden, seen
UNSET = (0.0, -1.0)  # coordinates that programs write for a marker that they have not found
PARTS = 1.5  # px: places within it are parts of a picture
SAME_UNIT = 0.01  # relative difference of two scales that are the same
AXES = "xyz"  # names of the axes
AXIS_COSINE = np.cos(np.radians(20))  # a normal within this angle of an axis is taken as that axis
ACROSS = 0.5  # cosine of a plane's normal to the axis that should point up: the plane stands upright
MAX_THICKNESS = 0.5  # largest spread off the plane, over that across the fish, for which the plane is clear
MAX_POINTS = 20_000  # from which the plane is found
# By axis that points up: index and sign of the plane's two axes, the second counter-clockwise from the first.
PLANE_AXES = {0: ((1, 1.0), (2, 1.0)), 1: ((0, 1.0), (2, -1.0)), 2: ((0, 1.0), (1, 1.0))}


@dataclass(frozen=True)
class Markers:
    """Tracked markers of one animal or robot."""

    time: Array  # (frames,) [s]
    place: Array  # (frames, markers, 2) [m], y counter-clockwise from x; NaN where a marker is missing
    weight: Array  # (frames, markers) likelihood or visibility of each marker, 0 where it is missing
    names: tuple[str, ...]  # of the markers
    file: str = ""
    ignored: tuple[str, ...] = ()  # columns of the file without a use
    form: str = ""  # of the file
    notes: tuple[str, ...] = ()  # sentences on how the file was read, without the final dot


def read_markers(
    path: str | Path,
    *,
    scale: float | None = None,
    frame_rate: float | None = None,
    y_down: bool | None = None,
    pixels: bool = False,
    min_likelihood: float = 0.5,
    individual: str | None = None,
    vertical: str | None = None,
) -> Markers:
    """Read tracked markers from a file of any form of `hypertuna.trials.forms`.

    Parameters
    ----------
    path : str or Path
    scale : float, optional
        Meters per unit of the file; default: as the file says, or 1.
    frame_rate : float, optional
        Frames per second [Hz], for files without a column of time.
    y_down : bool, optional
        Whether y points down; default: as the form of the file says, else in pixels only.
    pixels : bool
        Whether the unit of the file is pixels.
    min_likelihood : float
        A marker of lower likelihood counts as missing.
    individual : str, optional
        Which of several tracked animals, or cameras.
    vertical : {"x", "y", "z"}, optional
        Axis of points in space that points up; default: as the form of the file says, or found from the points.

    Returns
    -------
    Markers
    """
    points = read_points(path, individual)
    if len(points.names) > MAX_MARKERS:
        rule, fix = f"must have at most {MAX_MARKERS} markers", "leave those of the fish, and not all of them"
        raise InputError(rule, file=str(path), value=f"{len(points.names)} of them", fix=fix)
    return markers_of(
        points,
        scale=scale,
        frame_rate=frame_rate,
        y_down=y_down,
        pixels=pixels,
        min_likelihood=min_likelihood,
        vertical=vertical,
    )


def markers_of(
    points: Points,
    *,
    scale: float | None = None,
    frame_rate: float | None = None,
    y_down: bool | None = None,
    pixels: bool = False,
    min_likelihood: float = 0.5,
    vertical: str | None = None,
) -> Markers:
    """Return tracked points as markers in m and s, without those of low weight; options: as of `read_markers`."""
    scale, notes = _scale(points, scale, pixels)
    points = _without_unset(points)
    time, clock_notes = clock_of(points, frame_rate)
    if len(time) < MIN_FRAMES:
        fix = "record a longer run"
        raise InputError(f"must have at least {MIN_FRAMES} frames", file=points.file, value=f"{len(time)}", fix=fix)
    weight, weight_notes = _weight(points)
    in_plane, plane_notes = on_plane(points, vertical)
    seen = np.isfinite(in_plane).all(axis=2) & (weight >= min_likelihood) & (weight > 0)
    down = next(choice for choice in (y_down, points.y_down, pixels) if choice is not None)
    place = scale * in_plane * np.array([1.0, -1.0 if down else 1.0])
    place[~seen] = np.nan
    weight = np.where(seen, np.minimum(weight, 1.0), 0.0)
    all_notes = (*points.notes, *notes, *clock_notes, *weight_notes, *plane_notes)
    return Markers(time, place, weight, points.names, points.file, points.ignored, points.form, all_notes)


def _without_unset(points: Points) -> Points:
    """Return points without places of zeros, or of -1, off the body: programs write them where a marker is missing."""
    place = points.place
    unset = np.isin(place[..., 0], UNSET) & (place == place[..., :1]).all(axis=2)
    seen = np.isfinite(place).all(axis=2) & ~unset
    frames = seen.any(axis=1)
    if not unset.any() or not frames.any():
        return points
    off = np.zeros(unset.shape)
    center = np.nanmedian(np.where(seen[..., np.newaxis], place, np.nan)[frames], axis=1, keepdims=True)
    off[frames] = np.linalg.norm(place[frames] - center, axis=2)
    length = 2 * float(np.median(np.max(np.where(seen, off, 0.0)[frames], axis=1)))
    unset &= (off > length) | ~frames[:, np.newaxis]
    if not (count := int(unset.sum())):
        return points
    note = f"{count} places of zeros or -1, off the body, count as missing"
    return replace(points, place=np.where(unset[..., np.newaxis], np.nan, place), notes=(*points.notes, note))


def _scale(points: Points, given: float | None, pixels: bool) -> tuple[float, tuple[str, ...]]:
    """Return the scale [m per unit] that the user or the file states, and sentences on it; they must agree."""
    if given is not None:
        POSITIVE.check(given, "scale", "give meters per unit")
    file_scale = points.length_unit
    if points.in_pixels != pixels and (points.in_pixels or file_scale is not None):
        of_file = "px" if points.in_pixels else f"{file_scale:g} m"
        fix = "give --unit px and --scale in m/px" if points.in_pixels else "leave out --unit and --scale"
        value = "px" if pixels else "a length"
        raise InputError(f"must be {of_file}, as the file says", file=points.file, key="--unit", value=value, fix=fix)
    if pixels and 0 < np.nanmax(np.abs(points.place), initial=0.0) <= PARTS:
        rule, value = "must be pixels", f"within {PARTS:g}: parts of the picture's width and height?"
        fix = "multiply x by the width and y by the height of the picture in px"
        raise InputError(rule, file=points.file, key="the places of the markers", value=value, fix=fix)
    if file_scale is None:
        return 1.0 if given is None else given, ()
    if given is not None and abs(given / file_scale - 1) > SAME_UNIT:
        rule = f"must agree with the file, whose form is that of {points.form} and whose unit is {file_scale:g} m"
        fix = "leave out --unit and --scale"
        raise InputError(rule, file=points.file, key="--unit or --scale", value=f"{given:g} m", fix=fix)
    return file_scale, ()


def _weight(points: Points) -> tuple[Array, tuple[str, ...]]:
    """Return weights (rows, points) from 0 to 1, 1 for points set by hand without likelihood; and sentences on them."""
    weight = points.weight
    stated = weight[np.isfinite(weight)]
    notes: tuple[str, ...] = ()
    if len(stated) and stated.max() > SURE:
        if np.isin(stated, FLAGS).all():
            weight, notes = np.minimum(weight, 1.0), ("visibility is taken as 0 missing, 1 hidden, 2 seen",)
        elif PERCENT / 2 <= stated.max() <= PERCENT and float(np.median(stated)) > SURE:
            weight, notes = weight / PERCENT, ("likelihoods are taken as percent",)
        else:
            rule, fix = "must be parts of 1, or percent", "scale the column; of logits, take 1/(1 + exp(-logit))"
            value = f"up to {stated.max():g}"
            raise InputError(rule, file=points.file, key="the likelihood of the markers", value=value, fix=fix)
    if len(stated) and stated.min() < 0 and stated.max() <= 0:
        rule, fix = "must be parts of 1", "give likelihoods, not their logarithms"
        raise InputError(rule, file=points.file, key="the likelihood of the markers", value="negative", fix=fix)
    unsure = np.isnan(weight)
    if len(stated) and (count := int((unsure & np.isfinite(points.place).all(axis=2)).sum())):
        notes += (f"{count} places have no likelihood, and count as seen",)
    return np.where(unsure, 1.0, weight), notes


def on_plane(points: Points, vertical: str | None = None) -> tuple[Array, tuple[str, ...]]:
    """Return places (rows, points, 2) on the swimming plane, in the file's unit, and notes on the plane.

    The axis that points up is the given one, or the form's, or else the normal of the plane of least variance.
    """
    if vertical is not None:
        check_choice(vertical, AXES, "--vertical")
    if points.place.shape[2] == 2:
        return points.place, ()
    up = points.vertical if vertical is None else AXES.index(vertical)
    complete = points.place[np.isfinite(points.place).all(axis=2)]
    complete = complete[:: len(complete) // MAX_POINTS + 1]
    above = () if up is None else (f"points in space are seen from above, along {AXES[up]}",)
    if len(complete) < 3 or vertical is not None:
        return _seen(points.place, 2 if up is None else up), above
    _, spread, axes = np.linalg.svd(complete - complete.mean(axis=0), full_matrices=False)
    normal, clear = axes[2], bool(spread[2] <= MAX_THICKNESS * spread[1])
    flat_axis = int(np.argmax(np.abs(normal)))
    if up is not None and clear and abs(normal[up]) < ACROSS:
        rule = f"must point up, as the form of {points.form} says, but the fish moves along {AXES[up]}"
        fix = f"give --vertical {AXES[flat_axis]}, across the plane of the points, or --vertical {AXES[up]} if it does"
        raise InputError(rule, file=points.file, key=f"axis {AXES[up]}", fix=fix)
    if up is not None:
        return _seen(points.place, up), above
    up = flat_axis
    if not clear:
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
