"""Tables of poses with quaternions, as simulators and motion capture write them: columns, units, clock."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.tables import parse_float
from hypertuna.trials.clock import clock_of
from hypertuna.trials.form import unit_of
from hypertuna.trials.form_clock import Comments, clock_columns, with_comments
from hypertuna.trials.grid import FIRST_LINES, Grid, Samples, is_number, read_grid
from hypertuna.trials.points import Points

MARK = r"[_. /:]"  # between the words of a column's name
QUATERNION = re.compile(
    rf"(?:.*{MARK})?(?:q|quat|quaternion|orientation|rotation|rot)(?:{MARK}\w+)??{MARK}?([xyzw])(?: ?\[\])?",
    re.IGNORECASE,
)
PLACE = re.compile(
    rf"(?:(?:.*{MARK})?(?:p|pos|position|translation|t)(?:{MARK}\w+)??{MARK}?)?([xyz])(?:[_. (\[]+(m|cm|mm)[)\]]?)?",
    re.IGNORECASE,
)
POSE_WIDTHS = {8: "poses of TUM: time, place, quaternion", 12: "poses of KITTI: a rotation and a place"}
KEYS = ("x", "y", "z", "qx", "qy", "qz", "qw")
DEGREES, RADIANS = (
    re.compile(rf"(?:{words})[)\] ]*$", re.IGNORECASE) for words in ("deg(?:s|rees?)?|°", "rad(?:ian)?s?")
)
MOST = 0.9  # of the samples: single wrong angles of a sensor do not count
UNIT_TOLERANCE = 0.1  # largest difference of a quaternion's length from 1
HALF_TURN, QUARTER_TURN = np.pi, np.pi / 2  # rad


@dataclass(frozen=True)
class PoseTable:
    """Poses of one body over time, and joint angles."""

    time: Array  # (rows,) [s] from the first row
    place: Array  # (rows, 3) [m]
    turn: Array  # (rows, 4): quaternions x, y, z, w
    angle: Array  # (rows, joints) [rad]
    notes: tuple[str, ...]


def pose_width(grid: Grid) -> int:
    """Return how many numbers each row of a table without names has, if they are those of TUM or KITTI; otherwise 0."""
    width = len(grid.rows[0][1])
    rows = [row for _, row in grid.rows[:FIRST_LINES]]
    if width not in POSE_WIDTHS or not all(len(row) == width and is_number(*row) for row in rows):
        return 0
    numbers = np.array([[parse_float(cell) for cell in row] for row in rows])
    if width == 8:
        return width * bool((np.abs(np.linalg.norm(numbers[:, 4:], axis=1) - 1) < UNIT_TOLERANCE).all())
    return width * _are_rotations(numbers.reshape(-1, 3, 4)[:, :, :3])


def _are_rotations(turn: Array) -> bool:
    """Return whether matrices (rows, 3, 3) are rotations."""
    return bool(np.allclose(turn @ turn.transpose(0, 2, 1), np.eye(3), atol=UNIT_TOLERANCE))


def pose_samples(path: str | Path) -> tuple[Samples, Comments]:
    """Return the rows of a table below its line of names, and its comments; of TUM or KITTI, under names of `KEYS`."""
    grid = read_grid(path)
    if not (width := pose_width(grid)):
        return grid.below(1, grid.rows[0][1]), grid.comments
    samples = grid.below(0, ["time_s", *KEYS] if width == 8 else [f"m{k}" for k in range(width)])
    return samples if width == 8 else _of_matrices(samples), grid.comments


def _of_matrices(samples: Samples) -> Samples:
    """Return places and quaternions of rows with a rotation and a place each, three rows of four numbers (KITTI)."""
    values = np.column_stack([samples.numbers(k) for k in range(12)]).reshape(-1, 3, 4)
    turn, one = values[:, :, :3], np.ones(len(values))
    trace = np.einsum("kii->k", turn)
    # the largest of four times the squares of w, x, y, z; the others follow from it (Shepperd 1978)
    squares = np.column_stack([one + trace, *(one - trace + 2 * turn[:, i, i] for i in range(3))])
    products = np.zeros((len(values), 4, 4))  # four times those of w, x, y, z
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        products[:, 0, i + 1] = products[:, i + 1, 0] = turn[:, k, j] - turn[:, j, k]
        products[:, i + 1, j + 1] = products[:, j + 1, i + 1] = turn[:, i, j] + turn[:, j, i]
    products[:, range(4), range(4)] = squares
    largest = products[np.arange(len(values)), np.argmax(squares, axis=1)]
    with np.errstate(invalid="ignore", divide="ignore"):
        w, *axes = (largest / np.linalg.norm(largest, axis=1, keepdims=True)).T
    cells = np.column_stack([values[:, :, 3], *axes, w])
    if not _are_rotations(turn):
        rule, fix = "must hold rotations, as KITTI writes them", "name the columns: time_s, x, y, z, qx, qy, qz, qw"
        raise InputError(rule, file=samples.file, value="other numbers, 12 in each row", fix=fix)
    rows = [(line, [repr(x) for x in row]) for (line, _), row in zip(samples.rows, cells.tolist(), strict=True)]
    return Samples(samples.file, list(KEYS), rows)


def pose_table(samples: Samples, joints: Sequence[str], frame_rate: float | None, comments: Comments = ()) -> PoseTable:
    """Read the poses of a table, and the angles of the columns named `joints`; frame_rate: as of `clock_of`."""
    columns, lengths = _columns(samples)
    angles = [samples.head.index(name) for name in joints]
    samples.check_once(angles)
    clock, notes = clock_columns(samples, [*columns, *angles])
    if (time := clock.get("time")) is not None and (repeats := np.flatnonzero(np.diff(time) == 0) + 1).size:
        kept = np.setdiff1d(np.arange(len(time)), repeats).tolist()
        samples, notes = samples.only(kept), (*notes, f"{len(repeats)} rows at the time of another are left out")
        clock = {key: value[kept] if isinstance(value, np.ndarray) else value for key, value in clock.items()}
    values = np.column_stack([samples.numbers(k) for k in columns])
    no_weight = np.full((len(values), 1), np.nan)
    points = Points(
        "poses", samples.file, ("body",), values[:, np.newaxis, :3], no_weight, samples.where, **lengths, **clock
    )
    points = with_comments(points, comments)
    unit = points.length_unit or 1.0
    seconds, clock_notes = clock_of(points, frame_rate)
    angle = np.array([_radians(samples, k) for k in angles]).reshape(len(angles), len(values)).T
    if degrees := [name for name in joints if DEGREES.search(name)]:
        notes = (*notes, f"columns in deg: {', '.join(degrees)}")
    return PoseTable(seconds - seconds[0], unit * values[:, :3], values[:, 3:], angle, (*notes, *clock_notes))


def _columns(samples: Samples) -> tuple[list[int], dict[str, Any]]:
    """Return the index of the column of each of `KEYS`, and the unit of the places as fields of `Points`."""
    found: dict[str, list[int]] = {}
    units: list[str | None] = []
    for k, name in enumerate(samples.head):
        if match := QUATERNION.fullmatch(name):
            found.setdefault(f"q{match[1].lower()}", []).append(k)
        elif match := PLACE.fullmatch(name):
            found.setdefault(match[1].lower(), []).append(k)
            units.append(match[2])
    if missing := [key for key in KEYS if key not in found]:
        rule = f"must have columns of time_s, {', '.join(KEYS)}"
        fix = "name them so; if it has yaw, write a manifest of the table by hand (see the page on trials)"
        raise InputError(rule, file=samples.file, value=f"without {', '.join(missing)}", fix=fix)
    for key, columns in found.items():
        if len(columns) > 1:
            value = ", ".join(samples.head[k] for k in columns)
            fix = "keep the columns of the measured poses of the head, and drop or rename the others"
            raise InputError("must be there once", file=samples.file, key=f"column {key}", value=value, fix=fix)
    return [found[key][0] for key in KEYS], unit_of(samples.file, units)


def _radians(samples: Samples, column: int) -> Array:
    """Return the angles [rad] of a column, whose name says their unit unless they are small."""
    name, angle = samples.head[column], samples.numbers(column)
    for k in np.flatnonzero(np.isnan(angle))[:1]:
        key, fix = f"{samples.where[int(k)]}, {name}", "give a number, or leave out the line"
        raise InputError("must be a number", file=samples.file, key=key, value="missing", fix=fix)
    if DEGREES.search(name):
        return np.radians(angle)
    size = float(np.quantile(np.abs(angle), MOST))
    stated = bool(RADIANS.search(name))
    if size > (HALF_TURN if stated else QUARTER_TURN):
        rule = "must bend by less than half a turn" if stated or size > HALF_TURN else "must say its unit in its name"
        fix = f"are they in deg? Then call it {RADIANS.sub('', name).rstrip('_ ([')}_deg" + ", else _rad" * (not stated)
        raise InputError(rule, file=samples.file, key=name, value=f"{size:.3g} rad", fix=fix)
    return angle
