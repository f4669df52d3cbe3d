"""Read tracked points from NumPy archives of TRex: poses or midlines; one point per animal is refused."""

import re
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.door import CELLS, MB, opened, read_npy, read_npz
from hypertuna.trials.form import one_point
from hypertuna.trials.form_matlab import candidates_of, points_of_arrays
from hypertuna.trials.points import Points, Rows, seen

POSE = re.compile(r"pose([XY])([0-9]{1,4})")  # name of an array of TRex's poses
FIX = "track several points of one body, by DeepLabCut or SLEAP"  # in errors
STATIONS = 11  # points along a midline, including nose and tail


def read(path: str | Path, individual: str | None) -> Points:
    """Read the points of an archive (.npz) of TRex, which holds one animal per file."""
    file = str(path)
    with opened(path, "points") as stream:
        single = stream.read(6) == b"\x93NUMPY"
    if single:
        if (array := read_npy(path, "points")) is None:
            raise one_point("an array of NumPy, as idtracker.ai writes it (trajectories.npy)", file, FIX)
        return points_of_arrays("NumPy", file, {"points": array}, individual)
    arrays = {name: np.squeeze(array) for name, array in read_npz(path, "points", 256 * MB).items()}
    if {"midline_points", "midline_lengths", "frames"} <= set(arrays):
        return _midlines(file, arrays)
    if poses := {name: array for name, array in arrays.items() if POSE.fullmatch(name)}:
        return _poses(file, arrays, poses)
    if "trajectories" in arrays:
        raise one_point("idtracker.ai", file, FIX)
    if "X#wcentroid" in arrays or {"X", "Y", "missing"} <= set(arrays):
        raise one_point("TRex", file, "give the file *_posture_*.npz (output_posture_data = true), or export poses")
    if candidates_of(arrays):
        return points_of_arrays("NumPy", file, arrays, individual)
    listed, fix = ", ".join(list(arrays)[:12]), "export it from TRex again, or write a CSV file with a line of names"
    rule = "must hold points of TRex: poseX0, poseY0, ... or midline_points"
    raise InputError(rule, file=file, value=f"an archive of {shown(listed)}" if listed else "empty", fix=fix)


def _numbers(file: str, arrays: dict[str, Array], name: str, shape: tuple[int, ...]) -> Array:
    """Return an array of an archive by name, after checking its type and shape."""
    array = arrays.get(name)
    if array is None or array.shape != shape or array.dtype.kind not in "biuf":
        value = "missing" if array is None else f"of the shape {array.shape}"
        rule, fix = f"must be an array of numbers of the shape {shape}", "export it from TRex again"
        raise InputError(rule, file=file, key=name, value=value, fix=fix)
    return array.astype(float)


def _poses(file: str, arrays: dict[str, Array], poses: dict[str, Array]) -> Points:
    """Read TRex's poses: points [px], which are infinite in the file if missing."""
    count = next(iter(poses.values())).shape[:1]
    numbers = sorted({int(match[2]) for name in poses if (match := POSE.fullmatch(name))})
    axes = [np.stack([_numbers(file, arrays, f"pose{axis}{k}", count) for k in numbers], axis=1) for axis in "XY"]
    return _of_trex(file, arrays, tuple(f"pose{k}" for k in numbers), np.stack(axes, axis=-1), "frame")


def _midlines(file: str, arrays: dict[str, Array]) -> Points:
    """Read TRex's midlines [px], and resample each at equal steps from its first to its last point."""
    count = arrays["frames"].shape[:1]
    lengths, total = _numbers(file, arrays, "midline_lengths", count), len(arrays["midline_points"])
    points = seen(_numbers(file, arrays, "midline_points", (total, 2)))
    lengths = np.where(np.isfinite(lengths), lengths, 0)
    ends = np.cumsum(np.clip(lengths, 0, total + 1))
    if (lengths < 0).any() or (lengths != np.round(lengths)).any() or (len(ends) and ends[-1] != total):
        rule, fix = f"must add up to the {total} points of midline_points", "export it from TRex again"
        raise InputError(rule, file=file, key="midline_lengths", value="not", fix=fix)
    if len(lengths) * STATIONS * 2 > CELLS:
        rule = f"must have at most {CELLS // STATIONS // 2} frames"
        raise InputError(rule, file=file, key="midline_lengths", value="more", fix="cut the film into parts")
    place = np.full((len(lengths), STATIONS, 2), np.nan)
    for k, (length, end) in enumerate(zip(lengths.astype(int), ends.astype(int), strict=True)):
        line = points[end - length : end]
        step = np.linalg.norm(np.diff(line, axis=0), axis=1)
        if length >= 3 and np.isfinite(line).all() and step.sum() > 0:
            along = np.append(0, np.cumsum(step)) / step.sum()
            place[k] = np.column_stack([np.interp(np.linspace(0, 1, STATIONS), along, axis) for axis in line.T])
    return _of_trex(file, arrays, tuple(f"{k + 1}" for k in range(STATIONS)), place, "frames")


def _of_trex(file: str, arrays: dict[str, Array], names: tuple[str, ...], place: Array, frames: str) -> Points:
    """Return places (frames, points, 2) as points, with the archive's frame numbers, times and rate."""
    count = place.shape[:1]
    frame = _numbers(file, arrays, frames, count) if frames in arrays else None
    clock = next((name for name in ("time", "timestamp") if name in arrays), None)
    time = _numbers(file, arrays, clock, count) if clock else None
    stated = arrays.get("frame_rate")
    rate = float(stated) if stated is not None and stated.size == 1 and stated.dtype.kind in "iuf" else 0.0
    return Points(
        "TRex",
        file,
        names,
        seen(place),
        np.full(place.shape[:2], np.nan),
        Rows("row", np.arange(1.0, len(place) + 1)),
        time=None if time is None else np.where(np.isfinite(time), time, np.nan),
        y_down=True,
        time_unit=1.0 if clock == "time" else None,
        time_name=clock or "time",
        frame=None if frame is None else np.where(np.isfinite(frame), frame, np.nan),
        rate=rate if 0 < rate < np.inf else None,
    )
