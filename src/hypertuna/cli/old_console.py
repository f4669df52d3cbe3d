"""What the commands share: lists and ranges of numbers, strict JSON, a progress bar, checks of output files."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from hypertuna.errors import InputError, shown

__all__ = [
    "check_suffix",
    "command_line",
    "number",
    "number_list",
    "plain",
    "print_json",
    "progress_bar",
    "ranges",
    "run_folder",
    "tell_written",
    "whole_number",
]

PATIENCE = 1.0  # seconds after which work shows its progress
MOST_VALUES = 1_000_000  # of one range


def number(text: str, key: str, unit: str) -> float:
    """Read a number."""
    try:
        value = float(text)
    except ValueError:
        raise InputError("must be a number", key=key, value=shown(text), fix=f"give it in {unit}") from None
    if not math.isfinite(value):
        raise InputError("must be a finite number", key=key, value=text, fix=f"give it in {unit}")
    return value


def whole_number(text: str, key: str) -> int:
    """Read a whole number."""
    try:
        return int(text)
    except ValueError:
        raise InputError("must be a whole number", key=key, value=shown(text), fix="write digits only") from None


def number_list(text: str, key: str, unit: str) -> tuple[float, ...]:
    """Read numbers separated by commas."""
    return tuple(number(part, f"{key}[{i}]" if "," in text else key, unit) for i, part in enumerate(text.split(",")))


def ranges(text: str, key: str, unit: str) -> list[tuple[float, ...]]:
    """Read numbers or ranges separated by commas, and combine every value of each.

    Examples
    --------
    >>> ranges("0,0:180:3", "phase", "deg")
    [(0.0, 0.0), (0.0, 90.0), (0.0, 180.0)]
    """
    return list(itertools.product(*(_range(part, key, unit) for part in text.split(","))))


def plain(value: Any) -> Any:
    """Return a value as strict JSON can hold it: what is no finite number becomes null."""
    if isinstance(value, dict):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def print_json(value: Any) -> None:
    """Print a value as strict JSON."""
    typer.echo(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False))


def tell_written(*paths: str | None) -> None:
    """Name the files that were written."""
    for path in paths:
        if path is not None:
            typer.echo(f"written: {path}")


@contextlib.contextmanager
def progress_bar(what: str, patience: float = PATIENCE, *, lines: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show progress on the terminal once the work takes longer than a second."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    bar = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
    task = bar.add_task(what)
    start = time.monotonic()

    def report(done: int, total: int) -> None:
        bar.update(task, completed=done, total=total)
        if lines and done and not console.is_terminal:
            print(f"{what}: {done} of {total}, {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
        if time.monotonic() - start >= patience:
            bar.start()

    try:
        yield report
    finally:
        bar.stop()


def check_suffix(path: str | None, suffixes: Sequence[str], key: str) -> str:
    """Check the ending of an output file before any work is done for it."""
    if path is None:
        return ""
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        choices = " or ".join(", ".join(suffixes).rsplit(", ", 1))
        raise InputError(f"must end in {choices}", key=key, value=shown(path), fix="rename the file")
    if not Path(path).parent.is_dir():
        raise InputError("must be in a folder that exists", key=key, value=shown(path), fix="make the folder first")
    return suffix


def command_line() -> str:
    """Return the command as it was typed, for the files that it writes."""
    return shlex.join(["hypertuna", *sys.argv[1:]])


def _range(text: str, key: str, unit: str) -> list[float]:
    """Return the values of a number or of start:stop:count."""
    if ":" not in text:
        return [number(text, key, unit)]
    parts = text.split(":")
    if len(parts) != 3:
        rule = "must be a number or start:stop:count"
        raise InputError(rule, key=key, value=shown(text), fix="write, for example, 1:6:6 for 1, 2, 3, 4, 5 and 6")
    start, stop = (number(part, key, unit) for part in parts[:2])
    count = whole_number(parts[2], f"{key}'s count")
    if not 1 <= count <= MOST_VALUES:
        rule = f"must be from 1 to {MOST_VALUES}"
        raise InputError(rule, key=f"{key}'s count", value=str(count), fix="give the number of values")
    return [float(value) for value in np.linspace(start, stop, count)]


@contextlib.contextmanager
def run_folder(output: str | None, journal: str) -> Iterator[Path | None]:
    """Make the folder of a run; one that was made for bad input goes again."""
    if output is None:
        yield None
        return
    folder = Path(output)
    if folder.exists() and not folder.is_dir():
        rule, fix = "must be a folder", "choose another name"
        raise InputError(rule, key="--output", value=f"the file {output}", fix=fix)
    new = not folder.exists()
    if not new and any(folder.iterdir()) and not (folder / journal).exists():
        rule, value = "must be a new or empty folder, or one that such a run made", f"{output} with other files in it"
        raise InputError(rule, key="--output", value=value, fix="choose another folder")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        value, fix = (
            f"{output} ({error.strerror})",
            "make the folder around it first, or choose one that can be written",
        )
        raise InputError("must be a folder that can be made", key="--output", value=value, fix=fix) from None
    try:
        yield folder
    except InputError:
        if new:
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise
