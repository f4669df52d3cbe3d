"""Damaged input files, and what a command must make of them: an answer or one sentence, never a traceback or a hang.

`hypertuna` runs in this process, as a user's command does: `problem_of` returns what is wrong, empty if nothing is.
"""

import contextlib
import io
import os
import random
import re
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).parents[1]
LONGEST = 10.0  # s, of a command
NUMBER = re.compile(r"(?<![\w.\"])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.\"])")
VALUES = ("0", "-1", "1e300", "-1e300", "1e-300", "nan", "inf", "true", '"x"', "[]", "{}", "", "1_0", "0x10", "9" * 30)
SIGNS = (
    "\0",
    "\x1b[31m",
    "é",
    "\u202e",
    "$",
    "/",
    "[/b]",
    '"',
    "'",
    "\n",
    ",",
    ";",
    "=",
    "[",
    "]",
    "#",
    "\ufeff",
    "\\",
)


@dataclass(frozen=True)
class Case:
    """A file of a user, and the commands that read it."""

    name: str
    file: Path
    commands: tuple[tuple[str, ...], ...]  # FILE stands for the damaged file
    beside: tuple[str, ...] = ()  # files that it names


EXAMPLES, ROBOTS = ROOT / "examples", ROOT / "robots"
CASES = (
    Case("first robot", EXAMPLES / "myfish.toml", (("robot", "check", "FILE"), ("swim", "--robot", "FILE"))),
    Case(
        "servo robot",
        EXAMPLES / "servofish.toml",
        (("robot", "check", "FILE"), ("twin", "--robot", "FILE", "--duration", "0.5")),
    ),
    Case(
        "hydraulic robot",
        ROBOTS / "hypertuna.toml",
        (
            ("robot", "check", "FILE"),
            ("swim", "--robot", "FILE", "--gait", "unoptimised-0.3"),
            ("twin", "--robot", "FILE", "--gait", "unoptimised-0.3", "--duration", "0.5"),
            ("pump", "--robot", "FILE", "--frequency", "2"),
        ),
    ),
    Case(
        "steady runs",
        EXAMPLES / "tank/tank.csv",
        (
            ("trials", "check", "FILE", "--robot", "hypertuna"),
            ("identify", "FILE", "--robot", "hypertuna", "--free", "joints.bandwidth", "--starts", "1"),
        ),
    ),
    Case(
        "manifest",
        EXAMPLES / "tank/tank.toml",
        (("trials", "check", "FILE", "--robot", "hypertuna"), ("replay", "FILE", "--robot", "hypertuna")),
        ("tank.csv", "angles.csv", "poses.csv"),
    ),
    Case(
        "angles",
        EXAMPLES / "tank/angles.csv",
        (("replay", "tank.toml", "--robot", "hypertuna"),),
        ("tank.toml", "tank.csv", "poses.csv"),
    ),
    Case(
        "poses",
        EXAMPLES / "tank/poses.csv",
        (("replay", "tank.toml", "--robot", "hypertuna"),),
        ("tank.toml", "tank.csv", "angles.csv"),
    ),
    Case("bench", EXAMPLES / "bench/bench.csv", (("joint", "fit", "FILE", "--robot", "hypertuna", "--starts", "1"),)),
    Case("mission", ROOT / "missions/box.toml", (("mission", "FILE", "--duration", "1"),)),
)


def mutated(text: str, chance: random.Random) -> str:
    """Damage a text once to three times: numbers, lines, signs, its end."""
    for _ in range(chance.randint(1, 3)):
        text = chance.choice(KINDS)(text, chance)
    return text


def _number(text: str, chance: random.Random) -> str:
    """Replace a number by another one or by what is none."""
    places = list(NUMBER.finditer(text))
    if not places:
        return text
    at = chance.choice(places)
    factor = chance.choice((1e-6, 1e-3, 0.1, -1.0, 10.0, 57.3, 1e3, 1e6))
    new = f"{float(at[0]) * factor:g}" if chance.random() < 0.5 else chance.choice(VALUES)
    return text[: at.start()] + new + text[at.end() :]


def _line(text: str, chance: random.Random) -> str:
    """Drop, double or move a line."""
    lines = text.splitlines(keepends=True) or [""]
    at, to = chance.randrange(len(lines)), chance.randrange(len(lines))
    line = lines[at]
    kind = chance.randrange(3)
    if kind != 1:
        del lines[at]
    if kind != 0:
        lines.insert(to, line)
    return "".join(lines)


def _sign(text: str, chance: random.Random) -> str:
    """Insert, drop or change a character."""
    at = chance.randrange(len(text) + 1)
    return text[:at] + chance.choice((*SIGNS, "")) + text[at + chance.randrange(2) :]


def _word(text: str, chance: random.Random) -> str:
    """Misspell a key or a name."""
    at = chance.choice(list(re.finditer(r"[A-Za-z_]{3,}", text)) or [None])
    return text if at is None else text[: at.start()] + at[0][::-1] + text[at.end() :]


def _end(text: str, chance: random.Random) -> str:
    """Cut the text short."""
    return text[: chance.randrange(len(text) + 1)]


KINDS: tuple[Callable[[str, random.Random], str], ...] = (_number, _number, _number, _line, _sign, _word, _end)


@contextlib.contextmanager
def _limited(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in what takes longer."""

    def ring(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def problem_of(command: tuple[str, ...], folder: Path, *, longest: float = LONGEST) -> str:
    """Run a command in a folder: what no user should meet, empty if there is nothing."""
    from hypertuna.cli.main import main

    output, errors, code = io.StringIO(), io.StringIO(), 0
    begin = time.process_time()
    with (
        contextlib.chdir(folder),
        mock.patch.dict(os.environ, {"COLUMNS": "80", "NO_COLOR": "1"}),
        mock.patch.object(sys, "argv", ["hypertuna", *command]),
        contextlib.redirect_stdout(output),
        contextlib.redirect_stderr(errors),
    ):
        try:
            with _limited(30 * longest):
                main()
        except SystemExit as exit_:
            code = exit_.code if isinstance(exit_.code, int) else 0
        except TimeoutError:
            return "hangs"
        except BaseException as error:  # all of them are traceback for the user
            return f"{type(error).__name__}: {error}"[:300]
    told, seconds = errors.getvalue(), time.process_time() - begin
    if "Traceback" in told or "Traceback" in output.getvalue():
        return told[-300:]
    if code == 2 and "error: " not in told:
        return f"refused without a sentence: {told[:200]!r}"
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if code == 0 and re.search(r"\bnan\b", output.getvalue()):
        return "a result without numbers and exit code 0"
    return f"takes {seconds:.0f} s of processor" if seconds > longest else ""


def problems(case: Case, seed: int, folder: Path) -> list[str]:
    """Damage the file of a case by a seed, and run its commands; return what is wrong, with what made it."""
    text = mutated(case.file.read_text(), random.Random(f"{case.name} {seed}"))
    for name in case.beside:
        shutil.copy(case.file.parent / name, folder / name)
    (folder / case.file.name).write_text(text)
    commands = [tuple(case.file.name if word == "FILE" else word for word in one) for one in case.commands]
    found = [(command, problem_of(command, folder)) for command in commands]
    return [
        f"{case.name}, seed {seed}: hypertuna {' '.join(command)}: {problem}" for command, problem in found if problem
    ]
