"""Read texts typed on the command line: numbers, lists, ranges, bounds, names of files."""

import itertools
import math
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from hypertuna.errors import InputError, shown
from hypertuna.ranges import FINITE, Range, Whole

SPREADSHEETS = (".xlsx", ".xls", ".ods", ".tsv", ".txt")  # suffixes of programs that read .csv
COUNTS = Whole(min=1, max=1_000_000)  # number of values of one range, and of one option


class Bound(NamedTuple):
    """NAME=LOW:HIGH as typed."""

    name: str
    low: float
    high: float


class Setting(NamedTuple):
    """NAME=VALUE as typed."""

    name: str
    value: float


def number(text: str, key: str, unit: str, limits: Range = FINITE) -> float:
    """Read one finite number within limits; `key` and `unit` are for the error."""
    try:
        value = float(text.replace("\N{MINUS SIGN}", "-"))
    except ValueError:
        raise InputError("must be a number", key=key, value=shown(text), fix=_fix(text, unit)) from None
    return limits.check(value, key, f"give it in {unit}")


def _fix(text: str, unit: str) -> str:
    """Return the fix for a text that is no number, such as a number with a unit."""
    number_match = re.match(r"-?[\d.]+", text.strip())
    suffix = text.strip()[number_match.end() :].strip() if number_match else ""
    if re.fullmatch(r"[\d.,;\s-]+", text) and ";" in text:
        return "separate values with commas, and write decimal points"
    if text.strip()[:1] in ("[", "(", "{"):
        return "write the values without brackets, such as 16,25"
    if re.fullmatch(r"(-|to|\.\.)\s*[\d.]+", suffix):
        return "write a range as START:STOP:COUNT, such as 1:6:6 for 1, 2, 3, 4, 5 and 6"
    if re.fullmatch(r"[\d.\s-]+", suffix):
        return "write the values with commas and without spaces, such as 16,25"
    return f"give the number alone, in {unit}" if number_match and suffix else f"give it in {unit}"


def whole_number(text: str, key: str) -> int:
    """Read one whole number."""
    try:
        return int(text)
    except ValueError:
        raise InputError("must be a whole number", key=key, value=shown(text), fix="write digits only") from None


def numbers(text: str, key: str, unit: str, count: int | None = None) -> tuple[float, ...]:
    """Read numbers separated by commas: `count` of them, or any number."""
    values = tuple(number(part, f"{key}[{i}]" if "," in text else key, unit) for i, part in enumerate(text.split(",")))
    if count is not None and len(values) != count:
        fix = f"give them{f' in {unit}' if unit != '1' else ''}, separated by commas"
        raise InputError(f"must be {count} numbers", key=key, value=text, fix=fix)
    return values


def ranges(text: str, key: str, unit: str) -> list[tuple[float, ...]]:
    """Read numbers or ranges start:stop:count separated by commas; return every combination, the last varying fastest.

    Examples
    --------
    >>> ranges("0,0:180:3", "phase", "deg")
    [(0.0, 0.0), (0.0, 90.0), (0.0, 180.0)]
    """
    parts = _parts(text, key, unit)
    _check_many(math.prod(map(len, parts)), key, "combinations of values")
    return list(itertools.product(*parts))


def values(text: str, key: str, unit: str, limits: Range = FINITE) -> list[float]:
    """Read numbers or ranges separated by commas; return them one after another."""
    parts = _parts(text, key, unit, limits)
    _check_many(sum(map(len, parts)), key, "values")
    return list(itertools.chain.from_iterable(parts))


def interval(text: str, key: str, unit: str) -> tuple[float, float]:
    """Return low and high from LOW:HIGH."""
    ends = text.split(":")
    if len(ends) != 2:
        raise InputError("must be LOW:HIGH", key=key, value=shown(text), fix=f"give two numbers in {unit}")
    return number(ends[0], key, unit), number(ends[1], key, unit)


def bound(text: str, key: str, unit: str) -> Bound:
    """Return name, low and high from NAME=LOW:HIGH."""
    name, value = pair(text, key, "NAME=LOW:HIGH")
    return Bound(name, *interval(value, f"{key} {name}", unit))


def setting(text: str, key: str, unit: str) -> Setting:
    """Return name and value from NAME=VALUE."""
    name, value = pair(text, key, "NAME=VALUE")
    return Setting(name, number(value, f"{key} {name}", unit))


def output_file(path: str, suffixes: Sequence[str], key: str) -> str:
    """Return the path of an output file after checks of its suffix and its folder, before any work is done."""
    if not path:
        raise InputError("needs the name of a file", key=key, fix=f"write {key} NAME{suffixes[0]}")
    if Path(path).suffix.lower() not in suffixes:
        spreadsheet = ".csv" in suffixes and Path(path).suffix.lower() in SPREADSHEETS
        fix = f"write {Path(path).stem}{'.csv' if spreadsheet else suffixes[0]}"
        if Path(path).suffix.lower() == ".gpx" and ".mcap" in suffixes:
            fix = f"write --gpx {path}"
        endings = " or ".join(", ".join(suffixes).rsplit(", ", 1))
        raise InputError(f"must end in {endings}", key=key, value=shown(path), fix=fix)
    if not Path(path).parent.is_dir():
        raise InputError("must be in a folder that exists", key=key, value=shown(path), fix="make the folder first")
    if Path(path).is_dir() or not os.access(path if Path(path).exists() else Path(path).parent, os.W_OK):
        raise InputError("must be a file that can be written", key=key, value=shown(path), fix="choose another path")
    return path


def new_file(path: str, force: bool) -> str:
    """Return the path of a file to write after a check that it does not exist, unless `force` replaces it."""
    if Path(path).exists() and not force:
        raise InputError("exists already", file=path, fix="give another name, or replace it with --force")
    return path


def shard_folder(path: str, key: str) -> str:
    """Return the path of a folder of shards after a check that its parent folder exists."""
    if not Path(path).parent.is_dir():
        raise InputError("must be in a folder that exists", key=key, value=shown(path), fix="make the folder first")
    if Path(path).exists() and not Path(path).is_dir():
        raise InputError("must be a folder", key=key, value=f"the file {path}", fix="choose another name")
    return path


def share(text: str, key: str) -> tuple[int, int]:
    """Return I and N from I/N, the I-th of N parts."""
    first, _, count = text.partition("/")
    try:
        part, parts = int(first), int(count)
    except ValueError:
        part, parts = 0, 0
    if not 1 <= part <= parts:
        raise InputError("must be I/N, I from 1 to N", key=key, value=shown(text), fix="write 3/100 for job 3 of 100")
    return part, parts


def pair(text: str, key: str, form: str) -> tuple[str, str]:
    """Return the two sides of NAME=VALUE; form: the expected form, for errors."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise InputError(f"must be {form}", key=key, value=text, fix=f"write it as {form}")
    return name, value


def _parts(text: str, key: str, unit: str, limits: Range = FINITE) -> list[list[float]]:
    """Return the values of each part of a list separated by commas: a number is one value, a range several."""
    parts = text.split(",")
    return [_range(part, f"{key}[{k}]" if len(parts) > 1 else key, unit, limits) for k, part in enumerate(parts)]


def _check_many(count: int, key: str, what: str) -> None:
    """Check the number of values before they are made."""
    if count not in COUNTS:
        raise InputError(f"must be at most {COUNTS.max} {what}", key=key, value=f"{count}", fix="take fewer values")


def _range(text: str, key: str, unit: str, limits: Range) -> list[float]:
    """Return the values of a number or of a range start:stop:count, both ends included."""
    if ":" not in text:
        return [number(text, key, unit, limits)]
    parts = text.split(":")
    if len(parts) != 3:
        rule = "must be a number or start:stop:count"
        raise InputError(rule, key=key, value=shown(text), fix="write, for example, 1:6:6 for 1, 2, 3, 4, 5 and 6")
    start, stop = (number(part, key, unit, limits) for part in parts[:2])
    count = COUNTS.check(whole_number(parts[2], f"{key}'s count"), f"{key}'s count", "give the number of values")
    import numpy as np  # imported here, because only ranges need it

    return [float(value) for value in np.linspace(start, stop, count)]
