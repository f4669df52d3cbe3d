"""Tracked points in MATLAB's files: x and y, points, or the points of DLTdv, by the names of variables."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.matlab import read_matlab
from hypertuna.trials.form import FRAME, RATES, TIME, WEIGHTS, one_point, plain, time_and_frame
from hypertuna.trials.form_clock import CALL
from hypertuna.trials.points import Points, Rows, choose_individual, seen

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "px": None}
END = re.compile(r"_(m|cm|mm|px)$")
X = re.compile(r"(?P<before>.*?)(?P<x>x)(?P<after>[a-z]*|_?(?:pos|position|coords?|data|pts|points))", re.IGNORECASE)
PAIRS = (
    "xypts",
    "xyzpts",
    "points",
    "pts",
    "xy",
    "xyz",
    "markers",
    "midline",
)  # names of x1, y1, x2, y2, ... in columns
QUALISYS = "trajectories.labeled.data"  # end of the name of its places
LONGER = 3  # times as many frames as points, from which on the longer side is that of frames
FIX = "save x and y, each of frames by points (nose to tail), and t in s or fps: save('points.mat', 'x', 'y', 'fps')"


def read(path: str | Path, individual: str | None) -> Points:
    """Read the points of a file of MATLAB of version 5."""
    variables = read_matlab(path)
    return points_of_arrays("MATLAB", variables.file, variables.arrays, individual)


def points_of_arrays(form: str, file: str, arrays: dict[str, Array], individual: str | None) -> Points:
    """Return the points of variables whose names and shapes suit points; `individual` names one of several."""
    if qualisys := next((key for key in arrays if key.lower().endswith(QUALISYS) and arrays[key].ndim == 3), ""):
        return _qualisys(file, arrays, qualisys)
    candidates = candidates_of(arrays)
    if not candidates:
        if any(key in arrays for name in arrays if (key := _other(name)) and arrays[name].size > 1):
            raise one_point(form, file, "save the points along the body, each a column of x and y")
        listed = ", ".join(list(arrays)[:12])
        value = f"a file of {form} with {shown(listed)}" if listed else f"a file of {form} without arrays of numbers"
        rule = "must hold variables of points: x and y, points (frames, points, 2), or xypts of DLTdv"
        raise InputError(rule, file=file, value=value, fix=FIX)
    name = choose_individual(file, list(candidates), individual, what="variable")
    place = candidates[name]
    if name not in arrays or arrays[name].ndim == 3:  # two variables, or a block
        place = _by_frames(file, arrays, name, place)
    if name.rpartition(".")[2].startswith(("xypts", "xyzpts")):
        place = np.where((place == 0).all(axis=-1, keepdims=True), np.nan, place)  # of DLTdv: empty where none was set
        form = "DLTdv"
    count, end = len(place), END.search(name.split(" ")[0])
    clock = _clock(file, arrays, count)
    if form == "DLTdv" and not clock.keys() & {"time", "frame"}:
        clock["frame"] = np.arange(float(count))  # its rows are the frames of the film
    return Points(
        form,
        file,
        tuple(f"{k + 1}" for k in range(place.shape[1])),
        seen(place),
        _weight(arrays, place.shape[:2]),
        Rows("row", np.arange(1.0, count + 1)),
        length_unit=UNITS[end[1]] if end else None,
        notes=(f"the points are those of {name}: {count} frames of {place.shape[1]} points",),
        **clock,
    )


def _qualisys(file: str, arrays: dict[str, Array], name: str) -> Points:
    """Return the points of an export of Qualisys: (markers, 4, frames), x, y, z in mm, z up, and a residual."""
    place = seen(arrays[name].transpose(2, 0, 1)[:, :, :3])
    stated = {key.lower(): float(one.ravel()[0]) for key, one in arrays.items() if one.size == 1}
    before = name.lower().removesuffix(QUALISYS)
    frame = stated.get(f"{before}startframe", 1.0) + np.arange(float(len(place)))
    rate = stated.get(f"{before}framerate", 0.0)
    names, no_weight = tuple(f"{k + 1}" for k in range(place.shape[1])), np.full(place.shape[:2], np.nan)
    fields: dict[str, Any] = {"rate": rate if rate > 0 else None, "length_unit": UNITS["mm"], "vertical": 2}
    return Points("Qualisys", file, names, place, no_weight, Rows("frame", frame), frame=frame, y_down=False, **fields)


def candidates_of(arrays: dict[str, Array]) -> dict[str, Array]:
    """Return the variables, by name, whose names and shapes suit points."""
    return {**_pairs(arrays), **_blocks(arrays)}


def _weight(arrays: dict[str, Array], shape: tuple[int, ...]) -> Array:
    """Return the likelihoods (frames, points) of a variable of that name; NaN without one."""
    named = (one for key, one in arrays.items() if plain(_last(key)) in WEIGHTS and one.ndim == 2)
    either = (one if one.shape == shape else one.T for one in named if shape in (one.shape, one.shape[::-1]))
    return np.asarray(next(either, np.full(shape, np.nan)), dtype=float)


def _vectors(arrays: dict[str, Array]) -> dict[str, Array]:
    """Return the columns of time and frames by variable's name."""
    found = {}
    for key, one in arrays.items():
        name = plain(_last(key))
        if 1 < one.size == max(one.shape) and name not in PAIRS and (TIME.fullmatch(name) or FRAME.fullmatch(name)):
            found[key] = one.ravel()
    return found


def _clock(file: str, arrays: dict[str, Array], count: int) -> dict[str, Any]:
    """Return times, frame numbers and rate as fields of `Points`; those of another length or that differ are refused.

    count: frames of the points.
    """
    vectors = _vectors(arrays)
    for key in (key for key, one in vectors.items() if one.size != count):
        rule, fix = f"must have a value for each of the {count} frames", "save those of the points, and no others"
        raise InputError(rule, file=file, key=key, value=f"of {vectors[key].size}", fix=fix)
    names = list(vectors)
    time, second, frame = time_and_frame([_last(key) for key in names])
    clock: dict[str, Any] = {}
    if time is not None:
        clock |= {"time": vectors[names[time]], "time_unit": second, "time_name": names[time]}
        if _last(names[time]) == "t":
            clock["time_unit"] = 1.0
    if frame is not None:
        clock |= {"frame": vectors[names[frame]], "frame_name": names[frame]}
    if not clock:
        for key, one in arrays.items():
            if (
                one.size == count == max(one.shape)
                and plain(_last(key)) not in WEIGHTS
                and (np.diff(one.ravel()) > 0).all()
            ):
                rule = "grows from frame to frame, but nothing says what it counts"
                raise InputError(rule, file=file, key=f"variable {key}", value=f"up to {one.ravel()[-1]:g}", fix=CALL)
    rates = {key: float(one.ravel()[0]) for key, one in arrays.items() if plain(_last(key)) in RATES and one.size == 1}
    rates = {key: rate for key, rate in rates.items() if 0 < rate < np.inf}
    if len(set(rates.values())) > 1:
        value, fix = ", ".join(f"{key} {rate:g}" for key, rate in rates.items()), "keep that of the film, called fps"
        raise InputError("must have one frame rate", file=file, value=value, fix=fix)
    return clock | ({"rate": next(iter(rates.values()))} if rates else {})


def _last(name: str) -> str:
    """Return the last part of a variable's dotted name, in lower case."""
    return name.rpartition(".")[2].lower()


def _other(name: str, axis: str = "y") -> str:
    """Return the name of the y (or z) variable that belongs to an x variable's name; "" where the name is not of x."""
    before, dot, last = name.rpartition(".")
    match = X.fullmatch(last)
    if match is None:
        return ""
    new_axis = axis if match["x"] == "x" else axis.upper()
    return f"{before}{dot}{match['before']}{new_axis}{match['after']}"


def _by_frames(file: str, arrays: dict[str, Array], name: str, place: Array) -> Array:
    """Return places (frames, points, 2): frames are along the side as long as the times, else along the longer side."""
    lengths = {one.size for one in _vectors(arrays).values()}
    rows, columns = (size in lengths for size in place.shape[:2])
    if not rows and not columns:
        if max(place.shape[:2]) < LONGER * min(place.shape[:2]):
            rule, value = "must say which side is of frames", "{} by {}".format(*place.shape[:2])
            fix = "save t in s, or frame, with a value for each frame"
            raise InputError(rule, file=file, key=name, value=value, fix=fix)
        columns = place.shape[1] > place.shape[0]
    return place.transpose(1, 0, 2) if columns and not rows else place


def _pairs(arrays: dict[str, Array]) -> dict[str, Array]:
    """Return places (frames, points, 2 or 3), or transposed ones, from x and y (and z) variables of equal shape."""
    pairs = {}
    for name, x in arrays.items():
        parts = [x, *(arrays[key] for axis in "yz" if (key := _other(name, axis)) in arrays)]
        if len(parts) > 1 and x.ndim == 2 and min(x.shape) > 1 and all(part.shape == x.shape for part in parts):
            pairs[f"{name} and {_other(name)}"] = np.stack(parts, axis=-1)
    return pairs


def _blocks(arrays: dict[str, Array]) -> dict[str, Array]:
    """Return places (frames, points, 2 or 3), or transposed ones, of single variables of 3 sides or of columns."""
    blocks = {}
    for name, array in arrays.items():
        sides = [k for k, size in enumerate(array.shape) if size in (2, 3)]
        if array.ndim == 3 and len(sides) == 1 and array.size:
            blocks[name] = np.moveaxis(array, sides[0], -1)
        last_part, count = _last(name), 3 if _last(name).startswith("xyz") else 2
        if array.ndim == 2 and last_part in PAIRS and array.shape[1] >= 2 * count and array.shape[1] % count == 0:
            blocks[name] = array.reshape(len(array), -1, count)
    return blocks
