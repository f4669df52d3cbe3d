"""Streams that are closed, narrow or left by their reader, and interrupts: no traceback, the right exit code."""

import json
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

SWIM = "swim --robot hypertuna --gait unoptimised-max"
# Sends Ctrl-C to its own process as soon as a module is looked for.
INTERRUPTED = """
import os, signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
from hypertuna.__main__ import main
sys.argv = ["hypertuna", *{arguments!r}]
main()
"""


def shell(line: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a line in the shell; `hypertuna` stands for the program, its exit code is that of the line."""
    line = line.replace("hypertuna", f"{sys.executable} -m hypertuna", 1)
    return subprocess.run(
        ["bash", "-c", f"{line}; exit ${{PIPESTATUS[0]}}"],
        capture_output=True,
        text=True,
        env=os.environ | environment,
        check=False,
    )


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (f"hypertuna {SWIM} >&-", 0),
        (f"hypertuna {SWIM} --json <&- >&- 2>&-", 0),
        ("hypertuna --help >&-", 0),
        ("hypertuna nonsense 2>&-", 2),
        ("hypertuna robot show hypertuna | true", 0),  # by rich
        ("hypertuna robot show hypertuna --json | head -1", 0),  # by the parser
        ("hypertuna nonsense 2>&1 | true", 2),
    ],
)
def test_closed_streams_and_readers_that_stop(line: str, code: int) -> None:
    done = shell(line)
    assert (done.returncode, done.stderr) == (code, "")


def test_a_full_disk_behind_the_output_is_named() -> None:
    done = shell(f"hypertuna {SWIM} >/dev/full")
    assert (done.returncode, done.stderr) == (2, "error: standard output: No space left on device.\n")


def test_ascii_terminals_show_what_they_can(tmp_path: Path) -> None:
    """Letters without their accents on the terminal, escapes in JSON."""
    robot = Path("robots/hypertuna.toml").read_text(encoding="utf-8").replace('name = "', 'name = "Äal', 1)
    file = tmp_path / "fish.toml"
    file.write_text(robot, encoding="utf-8")
    ascii_output = {"PYTHONIOENCODING": "ascii"}
    told = shell(f"hypertuna swim --robot {file} --gait unoptimised-max", **ascii_output)
    assert (told.returncode, told.stderr) == (0, "")
    assert told.stdout.startswith("Aal")
    told = shell(f"hypertuna swim --robot {file} --gait unoptimised-max --json", **ascii_output)
    assert json.loads(told.stdout)["robot"].startswith("Äal")
    told = shell("hypertuna robot check none-Ä.toml", **ascii_output)
    assert (told.returncode, told.stderr.count("\n")) == (2, 1)
    assert "none-A.toml does not exist" in told.stderr


@pytest.mark.parametrize("module", ["typer", "hypertuna.cli.swim", "numpy", "numpy.linalg", "pydantic", "rich.console"])
def test_an_interrupt_while_modules_load(module: str) -> None:
    script = INTERRUPTED.format(module=module, arguments=SWIM.split())
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # else a runner in the background passes SIG_IGN on
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, check=False, preexec_fn=heard)
    assert done.stderr == "interrupted\n"
    assert done.returncode in (130, -2)  # Python itself ends by the signal where it cut a text that was compiled


def test_control_characters_do_not_reach_the_terminal(tmp_path: Path) -> None:
    file = tmp_path / "fish.toml"
    file.write_text('"\\u001b[31m\\u009b\\u202e" = 1\n"' + "k" * 100_000 + '" = 2\n', encoding="utf-8")
    told = shell(f"hypertuna robot check {file}")
    assert told.returncode == 2
    assert len(told.stdout + told.stderr) < 20_000
    assert not {"\x1b", "\x9b", "\u202e"} & set(told.stdout + told.stderr)
    told = shell("hypertuna swim --robot $'a\\e[31mb' --nonsense $'\\e[31m'")
    assert "\x1b" not in told.stderr
