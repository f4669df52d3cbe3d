"""Text files: TOML and tables of comma-separated values."""

from __future__ import annotations

import csv
import os
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError


def read_text(path: str | Path, kind: str, *, file: str | None = None) -> str:
    """Read a text file in UTF-8; errors name it by `file`, the path by default, and `kind`: "a CSV file"."""
    file = file or str(path)
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError("must be a file", file=file, value="missing", fix="check the path") from None
    except (OSError, ValueError) as error:
        if os.path.isdir(path):
            raise InputError("is a folder", file=file, fix=f"give the path of {kind}") from None
        value = f"not ({error.strerror if isinstance(error, OSError) else type(error).__name__})"
        raise InputError("must be readable", file=file, value=value, fix=f"give {kind} in UTF-8") from None


def read_toml(path: str | Path, *, file: str | None = None) -> dict[str, Any]:
    """Read a TOML file; errors name it by `file`, the path by default."""
    content = read_text(path, "a TOML file", file=file)
    try:
        return tomllib.loads(content)
    except (ValueError, RecursionError) as error:
        fix = "correct that line"
        raise InputError("must be valid TOML", file=file or str(path), value=f"not ({error})", fix=fix) from None


def read_rows(path: str | Path) -> list[tuple[int, list[str]]]:
    """Read line numbers and cells of a CSV file, column names first; empty lines and comments (#) are skipped."""
    file = str(path)
    lines = enumerate(read_text(path, "a CSV file").split("\n"), 1)
    content = [(n, line) for n, line in lines if line.strip() and line.lstrip()[0] != "#"]
    if len(content) < 2:
        fix = "give a line of column names, then one line per sample"
        raise InputError("must be a table", file=file, value="empty", fix=fix)
    for mark, name in {";": "semicolons", "\t": "tabs"}.items():
        if mark in content[0][1] and "," not in content[0][1]:
            rule, fix = "must be separated by commas", "save it with commas, and decimal points in numbers"
            raise InputError(rule, file=file, value=f"separated by {name}", fix=fix)
    return [(n, _cells(line, file, n)) for n, line in content]


def _cells(line: str, file: str, number: int) -> list[str]:
    """Split a line of a CSV file."""
    try:
        return [cell.strip() for cell in next(csv.reader([line], strict=True))]
    except csv.Error as error:
        rule, fix = "must be cells separated by commas", "close its quotation marks on the same line"
        raise InputError(rule, file=file, key=f"line {number}", value=f"not ({error})", fix=fix) from None


def check_width(row: Sequence[str], head: Sequence[str], *, file: str, line: int) -> None:
    """Check that a row of a CSV file has as many cells as the line of names."""
    if len(row) != len(head):
        rule, value = f"must have {len(head)} cells, like the line of names", f"{len(row)} long"
        raise InputError(rule, file=file, key=f"line {line}", value=value, fix="complete the line or remove it")
