"""Small CSV files of numbers alone, with named columns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import Range


def read_rows(path: str | Path, columns: Sequence[str], limits: Range, fix: str) -> Array:
    """Read numbers (rows, columns) of a CSV file's columns, checked for limits; fix: advice on a missing column."""
    table = read_table(path, RUNS)
    own = {column: column for column in columns}
    table.keys(own, own, fix=fix)

    def row(_: int, cells: dict[str, str]) -> list[float]:
        values = [parse_float(cells[column]) for column in columns]
        for column, value in zip(columns, values, strict=True):
            if value not in limits:
                fix = "give a number in this range"
                raise InputError(limits.rule, key=column, value=shown(cells[column]), fix=fix)
        return values

    return np.array(table.parse(row), dtype=float).reshape(-1, len(columns))
