"""Read tracked points from sheets of workbooks (.xlsx), like cells of text files. Needs the extra `xlsx`."""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError, shown
from hypertuna.io.door import CELLS, KINDS, MB, ROWS, archived, check_tags, damage, opened
from hypertuna.io.extras import need
from hypertuna.trials.forms import points_of_grid
from hypertuna.trials.grid import Grid
from hypertuna.trials.points import Points

MAX_UNPACKED = 128 * MB  # largest size of a workbook's unpacked texts; a million cells take 60 MB


def read(path: str | Path, individual: str | None) -> Points:
    """Read the points of the first sheet of a workbook."""
    need("xlsx", "openpyxl", by="workbooks")
    grid, others = _grid(path)
    points = points_of_grid(grid, individual)
    return replace(points, notes=(*points.notes, *others))


def _grid(path: str | Path) -> tuple[Grid, tuple[str, ...]]:
    """Return the grid of the first sheet that has more than one line, and a sentence on others; no second like it."""
    from openpyxl import load_workbook

    file, found = str(path), {}
    errors: tuple[type[Exception], ...] = (LookupError, ArithmeticError, *damage())
    try:
        with opened(path, "points") as stream, warnings.catch_warnings(action="ignore"):
            check_tags(archived(stream, MAX_UNPACKED))
            book = load_workbook(stream, read_only=True, data_only=True, keep_links=False)
            for sheet in book.worksheets:
                rows = _rows(file, sheet)
                if len(rows) > 1:
                    found[str(sheet.title)] = rows
    except InputError as error:
        raise InputError(error.rule, file=file, key=error.key, value=error.value, fix=error.fix) from None
    except errors:
        fix = "save it again as .xlsx, or the sheet as CSV"
        raise InputError("must be a whole workbook (.xlsx)", file=file, value="not", fix=fix) from None
    if found:
        (name, rows), *others = found.items()
        if alike := [other for other, others_rows in others if others_rows[0][1] == rows[0][1]]:
            rule, fix = "must have one sheet of a run", "save each run in a file of its own"
            value = f"{shown(name)} and {shown(alike[0])} with the same columns"
            raise InputError(rule, file=file, value=value, fix=fix)
        notes = (f"the sheet {shown(name)} is read, and of {len(others)} others nothing",) if others else ()
        return Grid(file, rows), notes
    fix = "give a sheet with a line of column names, then one line per frame"
    raise InputError("must be a table", file=file, value="empty", fix=fix)


def _rows(file: str, sheet: Any) -> list[tuple[int, list[str]]]:
    """Return line number and cells of each non-empty line of a sheet, padded to the length of the longest."""
    rows, count, letters, width = [], 0, 0, 0
    for number, row in enumerate(sheet.iter_rows(values_only=True), 1):
        texts = ["" if cell is None else str(cell) for cell in row]
        count, letters = count + len(row), letters + sum(map(len, texts))  # a text may stand in all cells
        texts = [text.strip() for text in texts] if letters < KINDS["csv"].largest else []
        while texts and not texts[-1]:
            texts.pop()
        if texts and not texts[0].startswith("#"):
            rows.append((number, texts))
            width = max(width, len(texts))
        if max(count, width * len(rows)) > CELLS or number > ROWS or letters > KINDS["csv"].largest:
            rule = f"must have at most {CELLS} cells and {ROWS} lines, and as CSV {KINDS['csv'].largest // MB} MB"
            raise InputError(rule, file=file, value="more", fix="cut the sheet into parts")
    return [(number, texts + [""] * (width - len(texts))) for number, texts in rows]
