"""Text forms that are refused by the shape of their table: transposed, single coordinates, poses."""

import re

from hypertuna.errors import InputError
from hypertuna.trials.form import Text, plain
from hypertuna.trials.form_columns import MARKER, NAMED, NUMBERED
from hypertuna.trials.grid import FIRST_LINES, Grid, is_number
from hypertuna.trials.points import Points
from hypertuna.trials.pose_table import POSE_WIDTHS, QUATERNION, pose_width

SPACE = re.compile("axis|space|coords?|coordinates?|dim(ension)?|direction")  # names of a column that holds x or y
PAIR = re.compile(r"[(\[]\s*[-+.\de]+[,;\s]+[-+.\de]+\s*[)\]]", re.IGNORECASE)
FEW, MAX_NAMES = 8, 1200  # columns of a table of single coordinates, and names of these
COLUMNS = "frame, marker, x, y in a row for each frame and marker"


def _is_of_poses(grid: Grid) -> bool:
    axes = {match[1].lower() for name in grid.rows[0][1] if (match := QUATERNION.fullmatch(name))}
    return pose_width(grid) > 0 or axes == {*"xyzw"}


def _poses(grid: Grid, individual: str | None) -> Points:
    form = POSE_WIDTHS.get(pose_width(grid), "poses")
    rule, fix = f"is of the form of {form}, and holds no markers", "import them: hypertuna trials import poses"
    raise InputError(rule, file=grid.file, fix=fix)


def _below(grid: Grid, column: int) -> list[str]:
    """Return the cells of a column below the first row."""
    return [row[column] if len(row) > column else "" for _, row in grid.rows[1:]]


def _is_transposed(grid: Grid) -> bool:
    """Return whether the rows, and not the columns, have the names of coordinates, or of markers with few rows."""
    first, second, width = _below(grid, 0), _below(grid, 1), len(grid.rows[0][1])
    if width < 4 or any(is_number(cell) for cell in first):
        return False
    named = [f"{one}_{two}" if two.lower() in ("x", "y", "z") else one for one, two in zip(first, second, strict=True)]
    numbers = all(is_number(cell) for _, row in grid.rows[1:FIRST_LINES] for cell in row[2:] if cell)
    coordinates = sum(bool(NAMED.fullmatch(name) or NUMBERED.fullmatch(name)) for name in named)
    by_marker = bool(MARKER.fullmatch(plain(grid.rows[0][1][0]))) and not {"x", "y"} <= {*grid.cells(0)}
    return numbers and len(set(named)) == len(named) and (coordinates > len(named) / 2 or by_marker)


def _transposed(grid: Grid, individual: str | None) -> Points:
    rule = "is a transposed table: a row for each coordinate or marker, and a column for each frame"
    fix = f"transpose it (Paste special, Transpose in a spreadsheet; df.T in pandas), or write {COLUMNS}"
    raise InputError(rule, file=grid.file, fix=fix)


def _is_single(grid: Grid) -> bool:
    """Return whether each row has one coordinate of one marker."""
    if len(grid.rows[0][1]) > FEW:
        return False
    for k in range(len(grid.rows[0][1])):
        cells = {cell.lower() for cell in _below(grid, k)}
        if {"x", "y"} <= cells <= {"x", "y", "z", "likelihood", "score", "confidence"}:
            return bool(SPACE.fullmatch(plain(grid.rows[0][1][k])))
        if 3 < len(cells) <= MAX_NAMES and all(NAMED.fullmatch(cell) for cell in cells):
            return True
    return False


def _single(grid: Grid, individual: str | None) -> Points:
    rule, fix = "has a row for each coordinate", f"pivot it (df.pivot in pandas), and write {COLUMNS}"
    raise InputError(rule, file=grid.file, fix=fix)


def _is_of_pairs(grid: Grid) -> bool:
    cells = [cell for _, row in grid.rows[1:FIRST_LINES] for cell in row if cell]
    return bool(cells) and sum(bool(PAIR.fullmatch(cell)) for cell in cells) > len(cells) / 2


def _of_pairs(grid: Grid, individual: str | None) -> Points:
    rule, fix = "has x and y of a marker in one cell", "write each into a column of its own: nose_x, nose_y"
    raise InputError(rule, file=grid.file, fix=fix)


# Text formats that this module refuses, in the order in which they are tried.
TEXTS = (
    Text("poses", _is_of_poses, _poses, individuals=True),
    Text("a transposed table", _is_transposed, _transposed, individuals=True),
    Text("a row for each coordinate", _is_single, _single, individuals=True),
    Text("pairs in cells", _is_of_pairs, _of_pairs, individuals=True),
)
