"""What a command makes of a file: its answer, and what no user should meet in it."""

import contextlib
import io
import json
import os
import re
import resource
import shlex
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

LONGEST = 10.0  # s of processor, of a command
TRACED = 8.0 if "HYPERTUNA_LINES" in os.environ else 1.0  # times as long while validation/mutants notes each line
LONGEST_ERROR = 8000  # characters: a robot's file can have a hundred faults, a block to paste for each missing table
VARYING = ("seconds",)  # keys of results that differ between two runs
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e]")
WITHOUT_NUMBERS = re.compile(r"\b(nan|inf)\b")  # a robot's file, which is shown, may say so


@dataclass(frozen=True)
class Answer:
    """What a command answered."""

    code: int
    output: str
    errors: str
    seconds: float  # of processor
    problem: str  # what no user should meet, empty if there is nothing

    @property
    def result(self) -> Any:
        """The JSON object on the output, without what differs between two runs."""
        return _steady(json.loads(self.output))


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in Python that takes longer."""

    def ring(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@dataclass
class Watch:
    """What came of a piece of code."""

    problem: str = ""  # what no user should meet, empty if there is nothing
    seconds: float = 0.0  # of processor
    raised: BaseException | None = None  # of those that are right


@contextlib.contextmanager
def watched(*right: type[BaseException], longest: float = LONGEST, hangs: float) -> Iterator[Watch]:
    """Watch the time that code takes and what it raises: all but the `right` exceptions reach users as tracebacks."""
    watch, begin = Watch(), time.process_time()
    try:
        with limited(hangs):
            yield watch
    except right as error:
        watch.raised = error
    except TimeoutError:
        watch.problem = "hangs"
    except BaseException as error:
        watch.problem = f"{type(error).__name__}: {error}"[:300]
    watch.seconds = time.process_time() - begin
    if watch.seconds > TRACED * longest:
        watch.problem = watch.problem or f"takes {watch.seconds:.0f} s of processor"


def answer(command: str, folder: Path, *, longest: float = LONGEST) -> Answer:
    """Run a command in a folder, in this process, as a user's shell does."""
    from hypertuna.cli.main import main

    output, errors = io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(folder),
        mock.patch.dict(os.environ, {"COLUMNS": "80", "NO_COLOR": "1"}),
        mock.patch.object(sys, "argv", ["hypertuna", *shlex.split(command)]),
        contextlib.redirect_stdout(output),
        contextlib.redirect_stderr(errors),
        watched(SystemExit, longest=longest, hangs=30 * longest) as watch,
    ):
        main()
    exit_ = getattr(watch.raised, "code", 0)
    code = exit_ if isinstance(exit_, int) else 0
    text, told = output.getvalue(), errors.getvalue()
    problem = watch.problem or _problem(command, code, text, told) or _empty_file(folder)
    return Answer(code, text, told, watch.seconds, problem)


def _problem(command: str, code: int, output: str, errors: str) -> str:
    """Return what no user should meet in an answer."""
    if "Traceback" in errors or "Traceback" in output:
        return errors[-300:]
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if code == 2 and not re.search("^error: ", errors, re.MULTILINE):
        return f"refused without a sentence: {errors[:200]!r}"
    if code == 2 and "enough memory" in errors:
        return errors[-300:]
    if "Warning:" in errors:
        return f"a warning of Python: {errors[:300]}"
    if len(errors) > LONGEST_ERROR:
        return f"{len(errors)} characters of errors"
    if sign := CONTROL.search(output + errors):
        return f"the control character {sign[0]!r}"
    if code == 0 and not command.startswith("robot show") and (number := WITHOUT_NUMBERS.search(output)):
        return f"exit code 0 and {number[0]}"
    if code == 0 and '"settled": true' in output and re.search(r'"(speed_m_s|mechanical_power_w)": null', output):
        return "settled without numbers"
    return ""


def _empty_file(folder: Path) -> str:
    """Return the name of a file that a command left empty."""
    empty = [path.name for path in folder.iterdir() if path.name.startswith("out.") and not path.stat().st_size]
    return f"leaves {empty[0]} empty" if empty else ""


def _steady(value: Any) -> Any:
    """Return a result without what differs between two runs."""
    if isinstance(value, dict):
        return {key: _steady(part) for key, part in value.items() if key not in VARYING}
    return [_steady(part) for part in value] if isinstance(value, list) else value


@contextlib.contextmanager
def memory_above(size: int | None) -> Iterator[None]:
    """Let a piece of code take a number of bytes above those of this process; without a size, all."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    if size is not None:
        now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (now + size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
