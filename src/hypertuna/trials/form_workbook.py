"""Sheets of workbooks (.xlsx): their cells as those of a text file. Needs the extra `xlsx`."""

import warnings
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError
from hypertuna.io.door import CELLS, MB, ROWS, archived, damage, opened
from hypertuna.io.extras import need
from hypertuna.trials.forms import points_of_grid
from hypertuna.trials.grid import Grid
from hypertuna.trials.points import Points

LARGEST = 512 * MB  # bytes of its texts, unpacked: a million cells have 60 MB


def read(path: str | Path, individual: str | None) -> Points:
    """Read the points of the first sheet of a workbook."""
    need("xlsx", "openpyxl", by="workbooks")
    return points_of_grid(_grid(path), individual)


def _grid(path: str | Path) -> Grid:
    """Return the cells of the first sheet with more than a line."""
    from openpyxl import load_workbook

    file, rows = str(path), []
    broken: tuple[type[Exception], ...] = (LookupError, ArithmeticError, *damage())
    try:
        with opened(path, "points") as stream, warnings.catch_warnings(action="ignore"):
            archived(stream, LARGEST)
            book = load_workbook(stream, read_only=True, data_only=True, keep_links=False)
            for sheet in book.worksheets:
                rows = _rows(file, sheet)
                if len(rows) > 1:
                    return Grid(file, rows)
    except InputError as error:
        raise InputError(error.rule, file=file, key=error.key, value=error.value, fix=error.fix) from None
    except broken:
        fix = "save it again as .xlsx, or the sheet as CSV"
        raise InputError("must be a whole workbook (.xlsx)", file=file, value="not", fix=fix) from None
    fix = "give a sheet with a line of column names, then one line per frame"
    raise InputError("must be a table", file=file, value="empty", fix=fix)


def _rows(file: str, sheet: Any) -> list[tuple[int, list[str]]]:
    """Return the numbers and cells of the lines of a sheet that are not empty, all as long as the longest."""
    rows, cells = [], 0
    for number, row in enumerate(sheet.iter_rows(values_only=True), 1):
        own = ["" if cell is None else str(cell).strip() for cell in row]
        while own and not own[-1]:
            own.pop()
        cells += len(row)
        if cells > CELLS or number > ROWS:
            rule = f"must have at most {CELLS} cells and {ROWS} lines"
            raise InputError(rule, file=file, value="more", fix="cut the sheet into parts")
        if own and not own[0].startswith("#"):
            rows.append((number, own))
    width = max((len(own) for _, own in rows), default=0)
    return [(number, own + [""] * (width - len(own))) for number, own in rows]
