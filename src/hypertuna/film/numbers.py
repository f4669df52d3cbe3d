"""Small CSV files of numbers alone, with named columns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import Range


def read_numbers(path: str | Path, columns: Sequence[str], limits: Range, fix: str) -> Array:
    """Read a CSV file of these columns: numbers (rows, columns) within limits; fix: for a missing column."""
    table = read_table(path, RUNS)
    for column in table.head:
        if column not in columns:
            near = did_you_mean(column, columns)
            raise InputError("is not a known column", file=table.file, key=f"line {table.line}, {column}", fix=near)
    table.check_once(table.head)
    if missing := [column for column in columns if column not in table.head]:
        raise InputError("must be a column", file=table.file, key=missing[0], value="missing", fix=fix)
    rows = []
    for line, cells in table.checked(table.rows):
        named = dict(zip(table.head, cells, strict=True))
        rows.append([_number(named[column], limits, table.file, f"line {line}, {column}") for column in columns])
    return np.array(rows, dtype=float).reshape(-1, len(columns))


def _number(text: str, limits: Range, file: str, key: str) -> float:
    """Read a cell."""
    try:
        number = parse_float(text)
    except ValueError:
        number = float("nan")
    if number not in limits:
        raise InputError(limits.rule, file=file, key=key, value=shown(text), fix="give a number in this range")
    return number
