"""Output of the commands: strict JSON, tables, sentences, progress; and the folder of a run."""

from __future__ import annotations

import contextlib
import json
import math
import shlex
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
import typer

from hypertuna.cli import streams
from hypertuna.errors import InputError, escaped
from hypertuna.io.quantity import counted

R = TypeVar("R")
PATIENCE = 1.0  # seconds after which work shows its progress on a terminal
PERIOD = 10.0  # seconds between two lines of progress elsewhere


def plain(value: Any) -> Any:
    """Return a value in the types of strict JSON: arrays as lists, NaN and infinity as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def json_text(value: Any) -> str:
    """Return a value as the text of strict JSON, control characters escaped."""
    return escaped(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False), "\n")


def print_json(value: Any) -> None:
    """Print a value as strict JSON, in characters that the output can write."""
    text, encoding = json_text(value), getattr(sys.stdout, "encoding", None) or "utf-8"
    typer.echo(text if encoding.lower().startswith("utf") else _ascii_json(text))


def _ascii_json(text: str) -> str:
    """Return the text of JSON in ASCII, other characters escaped."""
    return json.dumps(json.loads(text), indent=2, allow_nan=False)


def print_lines(lines: Iterable[Any]) -> None:
    """Print lines on the terminal: parts of a card, objects of rich, and sentences as text or as (text, style)."""
    from rich.console import Console

    console = Console()
    for line in lines:
        console.print(_laid_out(line))


def print_written(*paths: str | None) -> None:
    """Print the names of the files that were written."""
    for path in paths:
        if path is not None:
            typer.echo(f"written: {path}")


def _text(part: Any) -> Any:
    """Return a sentence, or (text, style), as rich's text: markup ignored, control characters escaped."""
    from rich.text import Text

    text, *style = (part,) if isinstance(part, str) else part if isinstance(part, tuple) else ("",)
    return Text(escaped(text, "\n"), *style) if isinstance(part, str | tuple) else part


def _laid_out(part: Any) -> Any:
    """Return a part of a card as rich prints it: a table, facts as label, value and unit, or a text."""
    from rich.table import Table

    from hypertuna import display  # imported here, because the help of commands does not need it

    if isinstance(part, display.Table):
        grid = Table(box=None, pad_edge=False, header_style="bold", collapse_padding=part.tight)
        for k, head in enumerate(part.heads):
            side: Literal["left", "right"] = "left" if k in part.left else "right"
            wrap = part.fold not in (-1, k) or k == part.whole
            grid.add_column(_text(head), justify=side, no_wrap=wrap, overflow="fold")
    elif isinstance(part, display.Facts):
        grid = Table(box=None, pad_edge=False, show_header=False)
        grid.add_column(style="dim")
        numbers = any(not isinstance(value, str) for value in part.values.values())
        grid.add_column(justify="right" if numbers else "left", style="bold" if numbers else "", overflow="fold")
        grid.add_column()
    else:
        return _text(part)
    for row in part.rows if isinstance(part, display.Table) else part.rows():
        grid.add_row(*map(_text, row))
    return grid


@contextlib.contextmanager
def progress_bar(
    what: str, *, slow: bool = False, parts: str = "", checkpoint: str | Path | None = None
) -> Iterator[Callable[[int, int], None]]:
    """Yield a function of count and total that shows progress on the error output.

    On a terminal a bar appears once the work takes a second, elsewhere a line every 10 seconds. For `slow` parts the
    bar appears at once, and each part has its line. With the name of its `parts`, Ctrl-C tells how many are done and
    where they are kept.
    """
    start, terminal, ended = time.monotonic(), sys.stderr.isatty(), threading.Event()
    bar: Any = None
    count = total = 0

    def line() -> None:
        elapsed = time.monotonic() - start
        share_done = f": {count} of {total}" if total else ""
        time_left = f", about {elapsed * (total - count) / count:.0f} s left" if count else ""
        streams.write_error(f"{what}{share_done}, {elapsed:.0f} s{time_left}\n")

    def watch() -> None:
        """Show the bar, or a line every PERIOD, even if the work reports no progress."""
        nonlocal bar
        if terminal and (slow or not ended.wait(PATIENCE)):
            bar = _bar(what)
            bar.update(bar.task_ids[0], completed=count, total=total or None)
        while not terminal and not ended.wait(PERIOD):
            line()

    def report(new_count: int, new_total: int) -> None:
        nonlocal count, total
        count, total = new_count, new_total
        if bar is not None:
            bar.update(bar.task_ids[0], completed=count, total=total)
        if slow and count and not terminal:
            line()

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield report
    except BaseException:
        if count and parts:
            done = f"{count} of {counted(total, parts)} {'is' if count == 1 else 'are'} done"
            resume = f" and kept in {checkpoint}; run the same command again to go on"
            streams.state["done"] = done + (resume if checkpoint else ", but not kept: --checkpoint FILE keeps them")
        raise
    finally:
        ended.set()
        watcher.join()
        if bar is not None:
            bar.stop()


def attended(what: str, work: Callable[[], R]) -> R:
    """Run `work` in a thread and return its result; meanwhile show progress, and end the work on Ctrl-C."""
    from concurrent.futures import Future  # imported here, because its import takes longer than many commands

    done: Future[R] = Future()

    def run() -> None:
        try:
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)

    with progress_bar(what):
        threading.Thread(target=run, daemon=True).start()
        return done.result()


def _bar(what: str) -> Any:
    """Return a started progress bar on the error output."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    bar.add_task(what)
    bar.start()
    return bar


def command_line() -> str:
    """Return the command line as typed, for the attributes of files."""
    return shlex.join(["hypertuna", *sys.argv[1:]])


@contextlib.contextmanager
def run_folder(output: str | None, journal: str) -> Iterator[Path | None]:
    """Make the folder of a run and yield its path; remove a new folder again if the input was bad.

    A folder that holds files is accepted only if one of them is the `journal` of an earlier run.
    """
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
        rule, value = "must be a folder that can be made", f"{output} ({error.strerror})"
        fix = "make the folder around it first, or choose one that can be written"
        raise InputError(rule, key="--output", value=value, fix=fix) from None
    try:
        yield folder
    except InputError:
        if new:
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise
