"""Tracked markers or midline points over time, read from CSV files: DeepLabCut, SLEAP, or plain columns."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import Table, parse_float, read_table
from hypertuna.ranges import CELL, POSITIVE

TIMES = ("time_s", "time", "t", "t_s", "timestamp")
FRAMES = ("frame", "frame_idx", "frames")
AXIS = r"x|y|likelihood|score|confidence|visible|visibility|p"
NAMED = re.compile(rf"(?P<name>.+)[_. ](?P<axis>{AXIS})(?:[_. ](?P<unit>m|cm|mm|px))?", re.IGNORECASE)
NUMBERED = re.compile(r"(?P<axis>x|y|p)[_. ]?(?P<name>.+?)(?:[_. ](?P<unit>m|cm|mm|px))?", re.IGNORECASE)
MISSING = ("", "nan", "na", "none", "null", "-")
LISTED = 300  # characters of names that an error lists
HEADS = ("individuals", "bodyparts", "coords")  # lines of names in a file of DeepLabCut, below that of the scorer
MIN_FRAMES = 12


@dataclass(frozen=True)
class Markers:
    """Tracked markers of one animal or robot."""

    time: Array  # (frames,) [s]
    place: Array  # (frames, markers, 2) [m], y counter-clockwise from x; NaN where a marker is missing
    weight: Array  # (frames, markers) likelihood or visibility of each marker, 0 where it is missing
    names: tuple[str, ...]  # of the markers
    file: str = ""
    ignored: tuple[str, ...] = ()  # columns of the file without a use


@dataclass(frozen=True)
class _Columns:
    """Columns of a table: of time or frame, and of x, y and weight of each marker."""

    time: int | None  # of time [s]
    frame: int | None
    of: dict[str, dict[str, int]]  # marker: column of "x", "y" and maybe "weight"
    ignored: tuple[str, ...] = ()


def read_markers(
    path: str | Path,
    *,
    scale: float = 1.0,
    frame_rate: float | None = None,
    y_down: bool = False,
    min_likelihood: float = 0.5,
    individual: str | None = None,
) -> Markers:
    """Read tracked markers from a CSV file of DeepLabCut, of SLEAP (analysis), or of plain columns.

    Parameters
    ----------
    path : str or Path
    scale : float
        Meters per unit of the file.
    frame_rate : float, optional
        Frames per second [Hz], for files without a column of time.
    y_down : bool
        Whether y points down, as in the pixels of an image.
    min_likelihood : float
        A marker of lower likelihood counts as missing.
    individual : str, optional
        Which of several tracked animals.

    Returns
    -------
    Markers
    """
    if Path(path).suffix.lower() in (".h5", ".hdf5", ".slp"):
        fix = "export CSV: analyze_videos(..., save_as_csv=True) in DeepLabCut, Export Analysis CSV in SLEAP"
        raise InputError("must be a CSV file", file=str(path), value=shown(Path(path).suffix), fix=fix)
    POSITIVE.check(scale, "scale", "give meters per unit")
    table = read_table(path)
    if table.head[0].lower() == "scorer":
        table, columns = _deeplabcut(table, individual)
    elif {"track", "frame_idx"} <= set(table.head):
        table, columns = _sleap(table, individual)
    else:
        columns = _plain(table)
    if columns.time is None and frame_rate is None:
        fix = "give --frame-rate in Hz, or a column time_s"
        raise InputError("must have a column of time", file=table.file, key="time_s", value="missing", fix=fix)
    return _markers(table, columns, scale, frame_rate, y_down, min_likelihood)


def _deeplabcut(table: Table, individual: str | None) -> tuple[Table, _Columns]:
    """Return the rows of frames and the columns of a file of DeepLabCut: three lines of names, or four."""
    names = {row[0].lower(): row for _, row in table.checked(table.rows[:3]) if row[0].lower() in HEADS}
    if not {"bodyparts", "coords"} <= set(names):
        fix = "give the file as DeepLabCut wrote it, with its lines scorer, bodyparts and coords"
        raise InputError("must have lines of bodyparts and coords", file=table.file, value="without", fix=fix)
    rows = [(line, row) for line, row in table.rows if row[0].lower() not in names]
    parts, axes = names["bodyparts"], names["coords"]
    animals = names.get("individuals", [""] * len(axes))
    own = _individual(table, [a for a, axis in zip(animals, axes, strict=False) if axis.lower() == "x"], individual)
    of: dict[str, dict[str, int]] = {}
    for k, axis in enumerate(axes[1:], 1):
        if axis and animals[k] in (own, "single"):
            of.setdefault(parts[k], {})["weight" if axis.lower() == "likelihood" else axis.lower()] = k
    head = [f"{part} {axis}".strip() for part, axis in zip(parts, axes, strict=True)]
    named = Table(table.file, table.line, head, rows)
    if len(set(animals)) == 1:
        named.check_once(filter(None, head))
    return named, _Columns(None, 0, of)


def _sleap(table: Table, individual: str | None) -> tuple[Table, _Columns]:
    """Return the rows of one track and the columns of an analysis file of SLEAP."""
    table.check_once(filter(None, table.head))
    track = table.head.index("track")
    own = _individual(table, [row[track] for _, row in table.checked(table.rows)], individual)
    rows = [(line, row) for line, row in table.rows if row[track] == own]
    of: dict[str, dict[str, int]] = {}
    for k, name in enumerate(table.head):
        node, dot, axis = name.rpartition(".")
        if dot and node != "instance":
            of.setdefault(node, {})["weight" if axis == "score" else axis] = k
    return Table(table.file, table.line, table.head, rows), _Columns(None, table.head.index("frame_idx"), of)


def _individual(table: Table, names: Sequence[str], chosen: str | None) -> str:
    """Return the name of the animal to read."""
    known = [name for name in dict.fromkeys(names) if name != "single"] or ["single"]
    if chosen is None and len(known) == 1:
        return known[0]
    if chosen not in known:
        few = len(", ".join(known)) <= LISTED
        rule = f"must be one of {', '.join(known)}" if few else f"must be one of the {len(known)} of the file"
        fix = "choose the animal" if chosen is None and few else did_you_mean(chosen or "", known)
        value = None if chosen is None else shown(chosen)
        raise InputError(rule, file=table.file, key="--individual", value=value, fix=fix)
    return chosen


def _plain(table: Table) -> _Columns:
    """Find time and markers among plain columns: nose_x, nose_y, nose_likelihood, or x1, y1, p1."""
    table.check_once(filter(None, table.head))
    lower = [name.lower() for name in table.head]
    time = next((lower.index(name) for name in TIMES if name in lower), None)
    frame = next((lower.index(name) for name in FRAMES if name in lower), None)
    of: dict[str, dict[str, int]] = {}
    ignored = []
    for k, name in enumerate(table.head):
        match = NAMED.fullmatch(name) or NUMBERED.fullmatch(name)
        if k in (time, frame):
            continue
        if match:
            axis = match["axis"].lower()
            of.setdefault(match["name"], {})[axis if axis in "xy" else "weight"] = k
        else:
            ignored.append(name)
    # a column such as "body" or "yaw" is no pair of coordinates
    lone = [name for name, axes in of.items() if not {"x", "y"} <= set(axes)]
    for name in lone:
        word = all(re.match(r"[xyp][a-z]{2}", table.head[k], re.IGNORECASE) for k in of[name].values())
        if not word and (len(lone) == len(of) or set(of[name]) & {"x", "y"}):
            axis = "y" if "x" in of[name] else "x"
            fix = "name columns of markers x1, y1, x2, y2, ... or nose_x, nose_y, ..."
            raise InputError(f"must have a column of {axis}", file=table.file, key=f"marker {name}", fix=fix)
        ignored += [table.head[k] for k in of.pop(name).values()]
    return _Columns(time, frame, of, tuple(ignored))


def _markers(
    table: Table, columns: _Columns, scale: float, frame_rate: float | None, y_down: bool, min_likelihood: float
) -> Markers:
    """Read the numbers of a table."""
    if len(columns.of) < 2:
        fix = "name columns of markers x1, y1, x2, y2, ... or nose_x, nose_y, ..."
        raise InputError("must have at least two markers", file=table.file, value=f"{len(columns.of)}", fix=fix)
    for name, of in columns.of.items():
        if axis := next((axis for axis in "xy" if axis not in of), None):
            fix = "export the file again"
            raise InputError(f"must have a column of {axis}", file=table.file, key=f"marker {name}", fix=fix)
    axes = [(of["x"], of["y"], of.get("weight")) for of in columns.of.values()]
    clock, values = [], []
    for order, (line, row) in enumerate(table.rows):
        if len(row) != len(table.head):
            rule, fix = f"must have {len(table.head)} cells, like the line of names", "complete the line or remove it"
            raise InputError(rule, file=table.file, key=f"line {line}", value=f"{len(row)} long", fix=fix)

        def number(k: int, row: list[str] = row, line: int = line) -> float:
            if (value := parse_float(row[k])) in CELL:
                return value
            if row[k].lower() in MISSING:
                return math.nan
            key, fix = f"line {line}, {table.head[k]}", "give a number, or leave the cell empty"
            if math.isfinite(value):
                CELL.check(value, key, fix, file=table.file)
            raise InputError("must be a number", file=table.file, key=key, value=shown(row[k]), fix=fix)

        clock.append(_clock(table, columns, number, row, order, frame_rate))
        values.append([[number(x), number(y), 1.0 if w is None else number(w)] for x, y, w in axes])
    time, data = np.array(clock), np.array(values)
    for k in np.flatnonzero(~(np.diff(time) > 0))[:1] + 1:
        key, fix = f"line {table.rows[k][0]}, time", "sort the frames by time, without repeats"
        rule = f"must be later than the previous frame, at {time[k - 1]:g} s"
        raise InputError(rule, file=table.file, key=key, value=f"{time[k]:g} s", fix=fix)
    if len(time) < MIN_FRAMES:
        fix = "record a longer run"
        raise InputError(f"must have at least {MIN_FRAMES} frames", file=table.file, value=f"{len(time)}", fix=fix)
    seen = np.isfinite(data).all(axis=2) & (data[:, :, 2] >= min_likelihood) & (data[:, :, 2] > 0)
    place = scale * data[:, :, :2] * np.array([1.0, -1.0 if y_down else 1.0])
    place[~seen] = np.nan
    weight = np.where(seen, np.minimum(data[:, :, 2], 1.0), 0.0)
    return Markers(time, place, weight, tuple(columns.of), table.file, columns.ignored)


def _clock(
    table: Table,
    columns: _Columns,
    number: Callable[[int], float],
    row: list[str],
    order: int,
    frame_rate: float | None,
) -> float:
    """Return the time of a row [s]: as given, or that of its frame."""
    if columns.time is not None:
        value = number(columns.time)
        if not math.isfinite(value):
            key, fix = f"line {table.rows[order][0]}, {table.head[columns.time]}", "give the time in s"
            raise InputError("must be a finite number", file=table.file, key=key, value="missing", fix=fix)
        return value
    whole = columns.frame is not None and row[columns.frame].isdecimal()
    return (float(row[columns.frame or 0]) if whole else float(order)) / (frame_rate or 1.0)
