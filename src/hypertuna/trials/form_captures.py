"""Text forms of motion capture and manual digitizing: Motive (OptiTrack), Qualisys, and DLTdv."""

import re

import numpy as np

from hypertuna.errors import InputError, shown
from hypertuna.io.door import CELLS
from hypertuna.io.tables import parse_float
from hypertuna.trials.form import Text, of_columns
from hypertuna.trials.form_clock import clock_columns
from hypertuna.trials.grid import FIRST_LINES, Grid, is_number
from hypertuna.trials.points import Points, Rows, choose_individual, no_individuals, seen

MOTIVE_UNITS = {"meters": 1.0, "centimeters": 1e-2, "millimeters": 1e-3}  # in m
Y_UP, Z_UP = 1, 2  # index of the axis that points up
POINTS = ("marker", "rigid body marker", "skeleton marker", "bone marker")  # types of Motive's columns that are read
DIGITIZED = re.compile(r"pt(?P<point>\d+)(?:_cam(?P<camera>\d+))?_(?P<axis>[xyz])")  # a column of DLTdv
XY = "xy"
Y_OF_DLTDV = "DLTdv 8 counts y downward, earlier versions upward: check the picture, and --y-axis"


def _is_motive(grid: Grid) -> bool:
    return grid.cells(0)[0] == "format version"


def _top(grid: Grid) -> list[list[str]]:
    """Return the cells of the first lines of a grid, in lower case."""
    return [grid.cells(k) for k in range(min(FIRST_LINES, len(grid.rows)))]


def _motive(grid: Grid, individual: str | None) -> Points:
    """Read an export of Motive: settings, lines of type and name of each column, then frame, time, x, y, z, ..."""
    settings = grid.rows[0][1]
    info = {key.lower(): value for key, value in zip(settings[::2], settings[1::2], strict=False)}
    if (space := info.get("coordinate space", "Global")).lower() != "global":
        fix = "export again with the coordinate space Global: local places are those in a rigid body's own frame"
        raise InputError("must be Global", file=grid.file, key="Coordinate Space", value=shown(space), fix=fix)
    top = _top(grid)
    head_row = next((k for k, row in enumerate(top) if row[:1] == ["frame"]), None)
    lines = {row[1]: k for k, row in enumerate(top[:head_row]) if len(row) > 2 and row[1] in ("type", "name")}
    if head_row is None or "name" not in lines:
        fix = "export the markers' positions again, with the lines of names"
        raise InputError("is of the form of Motive, but has no lines Name and Frame", file=grid.file, fix=fix)
    names = grid.rows[lines["name"]][1]
    kinds = top[lines["type"]] if "type" in lines else ["marker"] * len(names)
    types = next((row for row in top[lines["name"] + 1 : head_row] if "position" in row or "rotation" in row), [])
    head = grid.rows[head_row][1]
    width = len(head)
    names, kinds, types = ([*row, *[""] * width][:width] for row in (names, kinds, types or ["position"] * width))
    samples = grid.below(head_row + 1, [f"{name} {axis}".strip() for name, axis in zip(names, head, strict=True)])
    columns: dict[str, dict[str, int]] = {}
    for k, axis in enumerate(head):
        if names[k].lower().startswith("unlabeled"):
            continue
        if kinds[k] in POINTS and types[k] in ("position", "") and axis.lower() in ("x", "y", "z") and names[k]:
            columns.setdefault(names[k], {})[axis.lower()] = k
    columns = {name.rpartition(":")[2] if _unique(columns) else name: axes for name, axes in columns.items()}
    rate = next((parse_float(info[key]) for key in ("export frame rate", "capture frame rate") if key in info), None)
    unit = info.get("length units", "").lower()
    if unit and unit not in MOTIVE_UNITS:
        raise InputError(
            "must be a known unit", file=grid.file, key="Length Units", value=shown(unit), fix="export in m"
        )
    clock, _ = clock_columns(samples, range(2, width), head)  # Frame and Time come first
    return of_columns(
        "Motive",
        samples,
        columns,
        **clock,
        rate=rate,
        length_unit=MOTIVE_UNITS.get(unit),
        y_down=False,
        vertical=Y_UP,
    )


def _unique(columns: dict[str, dict[str, int]]) -> bool:
    """Return whether the markers' names remain unique without their prefix before a colon."""
    return len({name.rpartition(":")[2] for name in columns}) == len(columns)


def _is_qualisys(grid: Grid) -> bool:
    return any(row[0] in ("no_of_frames", "no_of_markers", "marker_names") for row in _top(grid))


def _qualisys(grid: Grid, individual: str | None) -> Points:
    """Read a TSV export of Qualisys: settings, optional column names, then x, y, z of each marker in mm.

    A marker that was not seen is written at the origin.
    """
    stated = {row[0].upper(): row[1:] for _, row in grid.rows[:FIRST_LINES] if re.fullmatch("[A-Z_]+", row[0])}
    # a marker that was not seen may leave the first cell of numbers empty
    head_rows = [k for k, row in enumerate(_top(grid)) if re.fullmatch("[a-z_ ]+", row[0])]
    first_row = head_rows[-1] + 1 if head_rows and head_rows[-1] + 1 < len(grid.rows) else None
    names = [name for name in stated.get("MARKER_NAMES", []) if name]
    if first_row is None or not names or len(set(names)) < len(names):
        fix = "export the 3-D data again, with the header and a name for each marker"
        raise InputError("is of the form of Qualisys, but lacks names or numbers of markers", file=grid.file, fix=fix)
    width = len(grid.rows[first_row][1]) - (not grid.rows[first_row][1][-1])  # lines may end with a tab
    before = width - 3 * len(names)
    if before not in (0, 1, 2):
        rule = f"must have x, y and z of each of {len(names)} markers, maybe behind frame and time"
        value, fix = f"{width} long", "export the 3-D data again, without other data"
        raise InputError(rule, file=grid.file, key=f"line {grid.rows[first_row][0]}", value=value, fix=fix)
    head = [*("Frame", "Time")[:before], *(f"{name} {axis}" for name in names for axis in "XYZ")]
    if before == 1 and any(row[:1] == ["time"] for row in _top(grid)):
        head[0] = "Time"
    samples = grid.below(first_row, head)
    columns = {name: {a: before + 3 * m + k for k, a in enumerate("xyz")} for m, name in enumerate(names)}
    clock, _ = clock_columns(samples, range(before, width))
    clock["time_unit"] = clock.get("time_unit") or 1.0
    rate = parse_float((stated.get("FREQUENCY") or [""])[0])
    points = of_columns(
        "Qualisys",
        samples,
        columns,
        **clock,
        rate=rate if rate > 0 else None,
        length_unit=1e-3,
        y_down=False,
        vertical=Z_UP,
    )
    points.place[(points.place == 0).all(axis=2)] = np.nan
    return points


def _is_digitized(grid: Grid) -> bool:
    head = [name for name in grid.cells(0) if name]
    return len(head) > 3 and sum(bool(DIGITIZED.fullmatch(name)) for name in head) > len(head) / 2


def _digitized(grid: Grid, individual: str | None) -> Points:
    """Read points of DLTdv: pt1_cam1_X, ..., or pt1_X, pt1_Y, pt1_Z, a row for each frame of the film."""
    head = grid.rows[0][1]
    matches = {k: match for k, name in enumerate(head) if (match := DIGITIZED.fullmatch(name.lower()))}
    cameras = [f"cam{match['camera']}" for match in matches.values() if match["camera"]]
    if individual is not None and not cameras:
        raise no_individuals(grid.file, individual)
    camera = choose_individual(grid.file, cameras, individual, what="camera") if cameras else None
    columns: dict[str, dict[str, int]] = {}
    for k, match in matches.items():
        if camera is None or f"cam{match['camera']}" == camera:
            columns.setdefault(f"pt{match['point']}", {})[match["axis"]] = k
    samples = grid.below(1, head)
    samples.check_once([k for axes in columns.values() for k in axes.values()])
    clock, notes = clock_columns(samples, list(matches))
    taken = (clock.get("time_name"), clock.get("frame_name"))
    planar = not any("z" in axes for axes in columns.values())
    return of_columns(
        "DLTdv",
        samples,
        columns,
        **clock,
        ignored=tuple(name for k, name in enumerate(head) if name and k not in matches and name not in taken),
        notes=notes + (Y_OF_DLTDV,) * planar,
    )


def _entries(grid: Grid) -> list[list[float]] | None:
    """Return the rows of a sparse table: frame, column from 1, value; None of a table of another form."""
    rows = [row for _, row in grid.rows if len(row) == 3 and is_number(*row)]
    if len(grid.rows) - len(rows) > 2 or len(rows) < 2 * len(XY):
        return None
    entries = [[parse_float(cell) for cell in row] for row in rows]
    columns = {column for _, column, _ in entries}
    whole = all(frame >= 0 == frame % 1 and column > 0 == column % 1 for frame, column, _ in entries)
    few = len(XY) < len(columns) == max(columns) < len(entries) / 2
    return entries if whole and few and len({(frame, column) for frame, column, _ in entries}) == len(entries) else None


def _sparse(grid: Grid, individual: str | None) -> Points:
    """Read the sparse points of DLTdv 8 (xypts.tsv), in which zeros are no places: columns x and y of each point."""
    entries = np.array(_entries(grid))
    frames, row = np.unique(entries[:, 0], return_inverse=True)
    column, count = entries[:, 1].astype(int) - 1, int(entries[:, 1].max() + 1) // len(XY)
    if len(frames) * count > CELLS:
        rule, fix = f"must have at most {CELLS} places", "leave out points or frames"
        raise InputError(rule, file=grid.file, value=f"{count} points in {len(frames)} frames", fix=fix)
    place = np.full((len(frames), count, len(XY)), np.nan)
    place[row, column // len(XY), column % len(XY)] = entries[:, 2]
    place[(place == 0).all(axis=2)] = np.nan
    names, weight = tuple(f"pt{m + 1}" for m in range(count)), np.full(place.shape[:2], np.nan)
    notes = ("the table does not count the cameras: its columns are taken as x and y of one", Y_OF_DLTDV)
    where, first = Rows("frame", frames), "the first column"
    return Points("DLTdv", grid.file, names, seen(place), weight, where, frame=frames, frame_name=first, notes=notes)


# Text formats that this module reads, in the order in which they are tried.
TEXTS = (
    Text("Motive", _is_motive, _motive),
    Text("Qualisys", _is_qualisys, _qualisys),
    Text("DLTdv", _is_digitized, _digitized, individuals=True),
    Text("DLTdv, sparse", lambda grid: len(grid.rows[-1][1]) == 3 and _entries(grid) is not None, _sparse),
)
