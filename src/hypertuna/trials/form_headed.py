"""Text forms with names above axes or below settings: Vicon, TRC, Tracker, EthoVision, LabVIEW; Kinovea; one point."""

import re
from dataclasses import replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.tables import parse_float
from hypertuna.trials.form import SECONDS, UNITS, WEIGHTS, Text, one_point, plain
from hypertuna.trials.form_columns import MARKER, read_plain
from hypertuna.trials.grid import FIRST_LINES, Grid, Samples
from hypertuna.trials.points import Points, Rows

AXIS = re.compile(r"([xyz])\d*")
LEVEL = re.compile(rf"{MARKER.pattern}|coords?|axis|")  # what pandas writes above an index
# Programs that track one point of each animal, or none, by names of their columns.
ONE_POINT = {
    "TrackMate": {"track_id", "position_x"},
    "AnimalTA": {"x_arena0_ind0", "y_arena0_ind0"},
    "idTracker": {"x1", "y1", "probid1"},
    "ToxTrac": {"arena", "track", "label"},
    "MTrackJ": {"tid", "pid"},
    "ImageJ": {"area", "x", "y", "slice"},
    "ImageJ, multi-point": {"x", "y", "slice", "counter"},
    "ImageJ, Manual Tracking": {"x", "y", "distance", "velocity", "pixel value"},
}
EVENTS = {"BORIS": {"behavior", "subject"}}


def _axes_row(grid: Grid) -> int | None:
    """Return the index of a line of axes x, y, x, y, ... below one of names, of the first section of trajectories."""
    begin = next((k for k, (_, row) in enumerate(grid.rows) if row[0].lower() == "trajectories"), 0)
    for k in range(begin + 1, min(begin + FIRST_LINES, len(grid.rows))):
        names, axes = grid.cells(k - 1), grid.cells(k)
        columns = [m for m, cell in enumerate(axes) if AXIS.fullmatch(cell)]
        if len(columns) > 3 and names[columns[0] : columns[0] + 1] not in ([], [""]):
            over = [names[m] for m in columns if m < len(names) and names[m]]
            if not any(AXIS.fullmatch(name) for name in over) and 1 < len(dict.fromkeys(over)) < len(columns):
                return k
    return None


def _stacked(grid: Grid, individual: str | None) -> Points:
    """Read columns whose names stand above the axes, maybe with units below, in the forms of Vicon, TRC and Tracker."""
    k = _axes_row(grid)
    assert k is not None
    names, axes, unit, rate = grid.rows[k - 1][1], grid.rows[k][1], "", 0.0
    form, first = "names above axes", grid.cells(0)[0]
    if first == "pathfiletype":
        stated = dict(zip(grid.cells(1), grid.cells(2), strict=False))
        form, unit, rate = "TRC", stated.get("units", ""), parse_float(stated.get("datarate", ""))
    elif any(row[0].lower() == "trajectories" for _, row in grid.rows[:k]):
        form, rate = "Vicon", parse_float(grid.rows[max(k - 2, 0)][1][0])
    elif grid.comment.lower().startswith("#multi"):
        form = "Tracker"
    below = grid.rows[k + 1 :]
    has_units = bool(below) and any(below[0][1]) and {cell.lower() for cell in below[0][1]} <= {"", *UNITS, *SECONDS}
    units, below = (below[0][1], below[1:]) if has_units else ([], below)
    width = max((len(row) for _, row in below[:FIRST_LINES] if any(row)), default=len(axes))
    head, name = [], ""
    for m in range(width):
        above, axis, own = (row[m] if m < len(row) else "" for row in (names, axes, units))
        name = above or name
        match = AXIS.fullmatch(axis.lower())
        own = own or (unit if match else "")
        text = f"{name}_{match[1]}" if match else next((t for t in (axis, above) if not LEVEL.fullmatch(plain(t))), "")
        if (text and text in head) or (name and plain(text) in WEIGHTS):  # a speed or a likelihood of each point
            text = f"{name}_{text}"
        head.append(f"{text} ({own})" if own else text)
    while width and not head[-1] and not any(row[width - 1] for _, row in below if len(row) >= width):
        width, head = width - 1, head[:-1]  # lines may end with a mark
    points = read_plain(Grid(grid.file, [(grid.rows[k][0], head), *below], grid.comments), individual)
    unstated = points.time is not None and points.time_unit is None and form != "names above axes"
    return replace(
        points,
        form=form,
        rate=rate if rate > 0 else points.rate,
        time_unit=1.0 if unstated else points.time_unit,
    )


def _is_ethovision(grid: Grid) -> bool:
    return grid.cells(0)[0].startswith("number of header lines")


def _ethovision(grid: Grid, individual: str | None) -> Points:
    """Read an export of EthoVision: settings, names of columns, their units, then a row for each frame."""
    count = parse_float(grid.rows[0][1][1]) if len(grid.rows[0][1]) > 1 else 0.0
    lines = {line: row for line, row in grid.rows if line in (count - 1, count)}
    if len(lines) < 2:
        fix = "export the raw data again, as text with its header"
        raise InputError("is of the form of EthoVision, but lacks the header that it states", file=grid.file, fix=fix)
    pairs = zip(lines[int(count) - 1], lines[int(count)], strict=False)
    head = [f"{name} ({unit})" if unit else name for name, unit in pairs]
    below = [(line, row) for line, row in grid.rows if line > count]
    return replace(read_plain(Grid(grid.file, [(int(count) - 1, head), *below]), individual), form="EthoVision")


def _is_labview(grid: Grid) -> bool:
    return grid.cells(0)[0] == "labview measurement"


def _labview(grid: Grid, individual: str | None) -> Points:
    """Read a measurement file of LabVIEW (.lvm): settings, then columns below the last end of a header."""
    ends = [k for k, (_, row) in enumerate(grid.rows) if row[0].lower() == "***end_of_header***"]
    if not ends or grid.cells(ends[-1] + 1)[:1] != ["x_value"]:
        fix = "write it with one column of times (X_Columns One)"
        raise InputError("is of the form of LabVIEW, but has no column X_Value", file=grid.file, fix=fix)
    (line, (_, *names)), *below = grid.rows[ends[-1] + 1 :]
    # the column of comments comes last, and may lack a cell
    rows = [(n, row + [""] * (names[-1:] == ["Comment"] and len(row) == len(names))) for n, row in below]
    return replace(read_plain(Grid(grid.file, [(line, ["time_s", *names]), *rows]), individual), form="LabVIEW")


def _is_kinovea(grid: Grid) -> bool:
    return grid.comment.lstrip("# ").lower().startswith("kinovea")


def _kinovea(grid: Grid, individual: str | None) -> Points:
    """Read trajectories of Kinovea as text: time, x, y, of one point after the other, each maybe below its name."""
    rows = [(line, row) for line, row in grid.rows if row[0].lower() not in ("t", "time")]
    samples = Grid(grid.file, rows).below(0, ["time", "x", "y"])
    time, place = _kinovea_times(samples), np.column_stack([samples.numbers(1), samples.numbers(2)])
    begins = [0, *(np.flatnonzero(np.diff(time) < 0) + 1).tolist()]
    if len(begins) < 2:
        raise one_point("Kinovea", grid.file, "track several points along the body, and export them together")
    titles = [(line, text.lstrip("# ")) for line, text in grid.comments]
    instants, row = np.unique(time, return_inverse=True)
    markers = np.repeat(np.arange(len(begins)), np.diff([*begins, len(time)]))
    names = []
    for m, begin in enumerate(begins):
        after = rows[begin - 1][0] if begin else grid.comments[min(1, len(grid.comments) - 1)][0]
        names.append(next((title for line, title in titles if after < line < rows[begin][0]), f"p{m + 1}"))
    if len(set(names)) < len(names) or len({*zip(row.tolist(), markers.tolist(), strict=True)}) < len(row):
        rule, fix = "must have each point and time once", "give each point a name of its own, and export them again"
        raise InputError(rule, file=grid.file, fix=fix)
    points = np.full((len(instants), len(begins), 2), np.nan)
    points[row, markers] = place
    weight, where = np.full(points.shape[:2], np.nan), Rows("instant", np.arange(1.0, len(instants) + 1))
    coded = ":" in rows[0][1][0]
    unit = 1.0 if coded else None
    return Points("Kinovea", grid.file, tuple(names), points, weight, where, time=instants, time_unit=unit)


def _kinovea_times(samples: Samples) -> Array:
    """Return times: numbers, or [s] of a code such as 0:00:01:25, which ends with hundredths or thousandths."""
    texts = samples.text(0)
    if not all(re.fullmatch(r"(\d+:){2,3}\d{2,3}", text) for text in texts):
        return samples.times(0)[0]
    seconds = []
    for text in texts:
        *whole, part = text.split(":")
        seconds.append(sum(int(x) * 60.0**k for k, x in enumerate(reversed(whole))) + int(part) / 10 ** len(part))
    return np.array(seconds)


def _program(grid: Grid, programs: dict[str, set[str]]) -> str:
    """Return the program among these whose names of columns a grid has, or ""."""
    heads = [set(grid.cells(k)) for k in range(min(FIRST_LINES, len(grid.rows)))]
    return next((program for program, names in programs.items() if any(names <= head for head in heads)), "")


def _point(grid: Grid, individual: str | None) -> Points:
    fix = "track several points along the body, and write nose_x, nose_y, ... in one row of each frame"
    raise one_point(_program(grid, ONE_POINT), grid.file, fix)


def _events(grid: Grid, individual: str | None) -> Points:
    rule, fix = "and holds events, no points", "track points along the body by DeepLabCut, SLEAP or others"
    raise InputError(f"is of the form of {_program(grid, EVENTS)}, {rule}", file=grid.file, fix=fix)


# Text formats that this module reads, in the order in which they are tried.
TEXTS = (
    Text("EthoVision", _is_ethovision, _ethovision),
    Text("LabVIEW", _is_labview, _labview, individuals=True),
    Text("names above axes", lambda grid: _axes_row(grid) is not None, _stacked, individuals=True),
    Text("Kinovea", _is_kinovea, _kinovea),
    Text("a table of one point", lambda grid: bool(_program(grid, ONE_POINT)), _point),
    Text("a table of events", lambda grid: bool(_program(grid, EVENTS)), _events),
)
