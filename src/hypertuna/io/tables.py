"""Tables of comma-separated values."""

import csv
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from hypertuna.errors import InputError, InputErrors, did_you_mean
from hypertuna.io.door import CELLS, LONGEST, ROWS, read_text

R = TypeVar("R")

EMPTY = ",; \t\r"  # in lines that spreadsheets leave below a table
MAX_NAMED, MAX_BAD = 5, 1000  # bad rows that an error describes; bad rows after which reading stops
# Units at the ends of column names, a dict per quantity: unit -> its size in the unit whose size is 1.
UNITS: tuple[dict[str, float], ...] = (
    {"m_s": 1, "cm_s": 1e-2, "mm_s": 1e-3, "km_h": 1 / 3.6},
    {"m": 1, "cm": 1e-2, "mm": 1e-3, "km": 1e3},
    {"pa": 1, "kpa": 1e3, "mpa": 1e6, "mbar": 1e2, "bar": 1e5},
    {"deg": 1, "rad": 180 / math.pi},
    {"deg_s": 1, "rad_s": 180 / math.pi},
    {"n": 1, "mn": 1e-3, "kn": 1e3},
    {"w": 1, "mw": 1e-3, "kw": 1e3},
    {"hz": 1, "mhz": 1e-3, "rpm": 1 / 60},
    {"s": 1, "ms": 1e-3, "min": 60},
    {"ml": 1, "l": 1e3, "mm3": 1e-3, "m3": 1e6},
)


@dataclass(frozen=True)
class Table:
    """A CSV file: names of its columns, and its rows."""

    file: str
    line: int  # number of the line of names
    head: list[str]
    rows: list[tuple[int, list[str]]]  # line number and cells of each row

    def keys(
        self,
        known: Mapping[str, str],
        required: Mapping[str, str],
        *,
        fix: str,
        hint: Callable[[str], str] = lambda column: "",
    ) -> list[str]:
        """Return the key of each column; check that all are known, given once, and none missing.

        known: key by name of a column; required: name by key; fix: for a missing column; hint: for an unknown one, in
        place of the nearest name. All errors are reported together.
        """
        keys: list[str] = []
        errors: list[InputError] = []
        suggested: set[str] = set()
        advice = ""  # the first hint
        for column in self.head:
            if len(errors) == MAX_BAD:
                break
            place = f"line {self.line}, {column}"
            if column not in known:
                unused = [c for c, key in known.items() if c not in self.head and key not in keys]
                text = hinted = hint(column)
                if not hinted:
                    near = did_you_mean(column, unused)
                    text = near if "did you mean" in near or not unused else f"use one of {', '.join(unused)}"  # all
                advice = advice or hinted
                name = text.partition("did you mean ")[2].removesuffix("?")
                suggested.add(known.get(name, ""))
                text += conversion(column, name)
                if not name and any("use one of" in str(error.fix) for error in errors):
                    text = "use one of those above"
                errors.append(InputError("is not a known column", file=self.file, key=place, fix=text))
                continue
            if known[column] in keys:
                value = f"{self.head[[known.get(c) for c in self.head].index(known[column])]}, too"
                rule, remedy = "must appear only once", "remove one of the two"
                errors.append(InputError(rule, file=self.file, key=place, value=value, fix=remedy))
            keys.append(known[column])
        for key, column in required.items():
            if key not in keys and key not in suggested:
                errors.append(InputError("must be a column", file=self.file, key=column, value="missing", fix=fix))
        if errors:
            # more errors than columns: a file of another kind or robot, unless its names are only misspelled
            foreign = len(errors) > len(self.head) and (bool(keys) or not suggested - {""})
            unknown = [column for column in self.head if column not in known]
            if foreign and len(unknown) > 1:
                place, text = f"line {self.line}, {', '.join(unknown)}", f"known ones are {', '.join(known)}"
                raise InputError("are not known columns", file=self.file, key=place, fix=advice or text)
            raise InputErrors(errors) if len(errors) > 1 and not foreign else errors[0]
        return keys

    def _wrong_length(self, row: list[str]) -> InputError:
        """Return the error of a row with more or fewer cells than columns."""
        rule, fix = f"must have {len(self.head)} cells, like the line of names", "complete the line or remove it"
        return InputError(rule, value=f"{len(row)} long", fix=fix)

    def check_once(self, names: Iterable[str]) -> None:
        """Check that none of these names belongs to two columns: it would be ambiguous."""
        for name in names:
            if (count := self.head.count(name)) > 1:
                rule, value, fix = "must be there once", f"there {count} times", "rename or remove the others"
                raise InputError(rule, file=self.file, key=f"column {name}", value=value, fix=fix)

    def parse(
        self,
        make: Callable[[int, dict[str, str]], R],
        keys: Sequence[str] | None = None,
        names: Mapping[str, str] | None = None,
    ) -> list[R]:
        """Return `make(line number, cells by key)` for each row; bad rows are reported together, in one error.

        keys: one per column (default: its name); names: key -> name of columns that the file may lack, for errors.
        """
        keys = self.head if keys is None else keys
        columns = {**(names or {}), **dict(zip(keys, self.head, strict=True))}
        values: list[R] = []
        bad: dict[tuple[str | None, ...], list[int]] = {}  # lines by column, rule, value and fix
        for line, row in self.rows:
            try:
                if len(row) != len(self.head):
                    raise self._wrong_length(row)
                values.append(make(line, dict(zip(keys, row, strict=True))))
            except InputError as error:
                bad.setdefault((columns.get(error.key or ""), error.rule, error.value, error.fix), []).append(line)
                if sum(map(len, bad.values())) > MAX_BAD:
                    break
        errors = [
            InputError(str(rule), file=self.file, key=_place(lines, column), value=value, fix=fix)
            for (column, rule, value, fix), lines in bad.items()
        ]
        if len(errors) > 1:
            texts = [str(InputError(e.rule, key=e.key, value=e.value)).removesuffix(".") for e in errors[:MAX_NAMED]]
            texts += [f"and {len(errors) - MAX_NAMED} more"] * (len(errors) > MAX_NAMED)
            number = sum(map(len, bad.values()))
            count = f"{number}" if number <= MAX_BAD else f"more than {MAX_BAD}"
            raise InputError(f"has {count} rows that cannot be used", file=self.file, fix="; ".join(texts))
        if errors:
            raise errors[0]
        return values


def _place(lines: Sequence[int], column: str | None) -> str:
    """Return the place of an error in one line or several, in a column if it has one."""
    more = f" and {len(lines) - MAX_NAMED} more" if len(lines) > MAX_NAMED else ""
    place = f"line{'s' * (len(lines) > 1)} {', '.join(map(str, lines[:MAX_NAMED]))}{more}"
    return f"{place}, {column}" if column else place


def read_table(path: str | Path, rows: int = ROWS) -> Table:
    """Read a CSV file of at most `rows` lines; lines without a cell that is filled in and comments (#) are skipped."""
    file, lines = str(path), enumerate(read_lines(path, rows), 1)
    content = [(n, line) for n, line in lines if line.strip(EMPTY) and line.lstrip()[0] != "#"]
    if len(content) < 2:
        fix = "give a line of column names, then one line per sample"
        raise InputError("must be a table", file=file, value="empty", fix=fix)
    for mark, name in {";": "semicolons", "\t": "tabs"}.items():
        if mark in content[0][1] and "," not in content[0][1]:
            rule, fix = "must be separated by commas", "save it with commas, and decimal points in numbers"
            raise InputError(rule, file=file, value=f"separated by {name}", fix=fix)
    if long := next((n for n, line in content if len(line) > LONGEST), None):
        rule, fix = f"must have at most {LONGEST} characters", "give one sample a line"
        raise InputError(rule, file=file, key=f"line {long}", value="longer", fix=fix)
    (line, head), *samples = ((n, split_line(line, file, n)) for n, line in content)
    return Table(file, line, head, samples)


def table_of(source: str | Path | Table, rows: int = ROWS) -> Table:
    """Return a table of at most `rows` lines: of a CSV file, or one read before."""
    if not isinstance(source, Table):
        return read_table(source, rows)
    if len(source.rows) > rows:
        raise too_large(source.file, f"{rows} lines")
    return source


def read_lines(path: str | Path, rows: int = ROWS) -> list[str]:
    """Return the lines of a CSV file of at most `rows` lines."""
    text = read_text(path, "csv")
    lines, cells = text.count("\n"), max(map(text.count, ",;\t"))
    for count, limit, noun in ((lines, rows, "lines"), (lines + cells, CELLS, "cells")):
        if count > limit:
            raise too_large(str(path), f"{limit} {noun}")
    return text.split("\n")


def too_large(file: str, most: str) -> InputError:
    """Return the error of a file that has more than `most` lines or cells."""
    return InputError(f"must have at most {most}", file=file, value="larger", fix="cut it, or thin it out")


def conversion(column: str, near: str) -> str:
    """Return how to convert a column to the unit of the nearest known name; empty if only the unit does not differ."""
    for units in UNITS:
        unit, goal = (max((u for u in units if name.endswith(f"_{u}")), key=len, default="") for name in (column, near))
        if unit and goal and unit != goal and column.removesuffix(unit) == near.removesuffix(goal):
            factor = units[unit] / units[goal]
            return f" Then {'multiply' if factor > 1 else 'divide'} the numbers by {max(factor, 1 / factor):.6g}"
    return ""


def parse_float(text: str) -> float:
    """Parse a number; NaN for other text, also `1_000` or digits of other scripts, which Python would accept."""
    try:
        return float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        return math.nan


def split_line(line: str, file: str, number: int, mark: str = ",") -> list[str]:
    """Split a line of a CSV file."""
    try:
        quoted = '"' in line or "\r" in line
        cells = next(csv.reader([line], delimiter=mark, strict=True)) if quoted else line.split(mark)
        return [cell.strip() for cell in cells]
    except csv.Error as error:
        rule, fix = "must be cells separated by commas", "close its quotation marks on the same line"
        raise InputError(rule, file=file, key=f"line {number}", value=f"not ({error})", fix=fix) from None
