"""Large work: counted first, refused if it cannot end, announced if it is long; and progress in pipes, too."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.cli import console
from hypertuna.errors import InputError
from hypertuna.parallel.shards import shard_size
from hypertuna.swimming import gait_checks
from program import Run

SWEEP = ("sweep", "--frequency", "2:4:3", "--amplitude", "16,25", "--phase", "0,0:90:8")


def test_progress_in_a_pipe_is_a_line_now_and_then(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(console, "PERIOD", 0.05)
    with console.progress_bar("swimming") as report:
        report(1, 4)
        time.sleep(0.3)
    assert re.fullmatch(r"(swimming: 1 of 4, 0 s, about [01] s left\n){2,}", capsys.readouterr().err)
    assert console.attended("simulating", lambda: time.sleep(0.3) or 7) == 7  # type: ignore[func-returns-value]
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) > 1
    assert set(lines) == {"simulating, 0 s"}


def test_the_choice_of_runs_shows_progress(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(console, "PERIOD", 0.01)
    code, _, errors = run("design", "ask", "--robot", "rexeel", "--state", str(tmp_path / "eel.state"))
    assert (code, errors.startswith("choosing runs, ")) == (0, True), errors


def test_an_error_of_a_single_call_is_its_own() -> None:
    def fail() -> None:
        raise InputError("must be less")

    with pytest.raises(InputError, match="must be less"):
        console.attended("simulating", fail)


def test_ctrl_c_ends_a_single_long_call() -> None:
    """A twin of 10000 s is one call of the core, of minutes."""
    command = [sys.executable, "-m", "hypertuna", "twin", "--gait", "optimised-0.3", "--duration", "10000"]
    heard = partial(signal.signal, signal.SIGINT, signal.default_int_handler)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heard) as run:
        time.sleep(6)  # the call runs by then
        run.send_signal(signal.SIGINT)
        start = time.monotonic()
        _, errors = run.communicate(timeout=60)
    assert errors.endswith("interrupted\n")
    assert "Traceback" not in errors
    assert run.returncode == 130
    assert time.monotonic() - start < 20


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (
            "--frequency 1:6:1000 --amplitude 1:16:900,1:25:1000 --phase 0:90:900,0:90:1000 -o a.shards",
            "the number of shards must be at most 1000000, but is 6179809571: 810000000000000 results",
        ),
        ("--frequency 1:6:6 --amplitude 1:20:10000,1:20:10000 --phase 0,40", "--amplitude must be at most 1000000"),
        ("--frequency 1:6:1000000,2:3:2 --amplitude 16,25 --phase 0,40", "--frequency must be at most 1000000 values"),
        ("--frequency 1:6:400000 --amplitude 16,25 --phase 0,40 --json", "--json must hold at most 300000 results"),
        ("--frequency 1:6:400000 --amplitude 16,25 --phase 0,40 -o a.csv", "--output must hold at most 300000 results"),
        (
            "--frequency 1:6:2000 --amplitude 16,1:25:6000 --phase 0,40",
            "the number of gaits must be at most 10000000, but is 12000000: take fewer values, or write shards",
        ),
        (
            "--frequency 1:6:2 --amplitude 16,25 --phase 0,40 -o a.shards --shard-size 100000000",
            "--shard-size must be from 1 to 1000000",
        ),
    ],
)
def test_a_grid_that_cannot_end_is_refused_at_once(
    typed: str, sentence: str, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    code, output, errors = run("sweep", *typed.split())
    assert (code, output) == (2, "")
    assert errors.splitlines()[-1].startswith(f"error: {sentence}")
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (
            "pump --over joints.I.line.bore_m=0.003:0.006:1000 --over joints.II.line.bore_m=0.003:0.006:1000",
            "the number of cases must be at most 10000, but is 1000000: take fewer values",
        ),
        ("pump --frequency 1:2:10001", "the number of cases must be at most 10000, but is 10001"),
        (
            "fe map --joint I --pressure 0:200:100 --moment 0:1:10000",
            "the number of points must be at most 10000, but is 1000000: take fewer pressures or moments",
        ),
        ("posture-test --frequency 1:6:1000000", "frequency must be 1 to 100 values, but is 1000000 long"),
        ("posture-test --duration 10000", "duration must be from two beats to 600 s"),
        ("twin --gait optimised-0.3 --duration 1e6", "duration must be from 0.01 to 10000"),
        ("dive --gait optimised-0.3 --duration 1e6", "duration must be from 0.01 to 10000"),
        ("swim --gait optimised-0.3 --from-rest 1e9", "from_rest must last between one beat and 10000 beats"),
        ("turn --gait turning --phase 0,0:90:10000", "the number of gaits must be at most 2000"),
        ("optimize --maximize speed --particles 100000", "particles must be from 1 to 10000"),
        ("optimize --maximize speed --iterations 100000", "iterations must be from 1 to 10000"),
        ("optimize --maximize speed --robust mean --samples 100000", "samples must be from 1 to 10000"),
        ("pareto --population 100000", "population must be from 2 to 10000"),
        ("pareto --generations 100000", "generations must be from 1 to 10000"),
        ("joint bend --joint I --pressure 0:200:100000", "--pressure must be at most 10000 pressures"),
        ("mission box --seeds 0:1000000", "seeds must be from 1 to 10000 seeds"),
    ],
)
def test_counts_of_every_command_have_a_bound(typed: str, sentence: str, run: Run) -> None:
    code, output, errors = run(*typed.split())
    assert (code, output) == (2, "")
    assert errors.splitlines()[-1].startswith(f"error: {sentence}")


def test_shards_have_a_bound() -> None:
    assert shard_size(1_000_000 * 131_072) == 131_072
    with pytest.raises(InputError, match="the number of shards must be at most 1000000"):
        shard_size(1_000_000 * 131_072 + 1)
    with pytest.raises(InputError, match="the number of shards"):
        shard_size(2_000_001, 2)


@pytest.fixture
def large(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A grid of more than ten gaits is large."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hypertuna.cli.sweep.MAX_GAITS", 10)


@pytest.mark.usefixtures("large")
def test_a_large_grid_says_what_it_takes(run: Run, tmp_path: Path) -> None:
    code, _, errors = run(*SWEEP, "-o", "a.shards")
    note = errors.splitlines()[0]
    assert code == 0
    assert note.startswith("note: 24 gaits in shards of 256 take about ")
    assert "the rate of this machine" in note
    size = sum(file.stat().st_size for file in (tmp_path / "a.shards").glob("shard-*"))
    assert size > 24 * 100  # about what the note multiplies, and the archive
    assert run(*SWEEP[:-1], "0,0:90:2", "-o", "b.shards")[2] == ""


@pytest.mark.usefixtures("large")
@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("YEAR", 1e-9, "the sweep must end within a year, but is "),
        ("shutil.disk_usage", lambda _: SimpleNamespace(free=100), "the sweep must fit on the disk of a.shards"),
    ],
)
def test_a_large_grid_that_cannot_end_is_refused(
    name: str, value: Any, sentence: str, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(f"hypertuna.cli.sweep.{name}", value)
    code, _, errors = run(*SWEEP, "-o", "a.shards")
    assert code == 2
    assert errors.startswith(f"error: {sentence}")
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("unit", [1.0, np.pi / 180])
@pytest.mark.parametrize("bias", [None, [(0, 1.5), (0.25, -3)]])
def test_a_grid_is_checked_at_once_as_value_by_value(unit: float, bias: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    given = {"frequency": [1, 2.5], "amplitude": [(0.1, 3)], "phase": [[0, 0.3], [0.1, 1 / 3]], "bias": bias}
    together = gait_checks.grid_axes(given, unit)
    assert gait_checks._sound_axes(given, unit) is not None
    monkeypatch.setattr(gait_checks, "_sound_axes", lambda *_: None)
    for name, axis in gait_checks.grid_axes(given, unit).items():
        assert np.array_equal(axis, together[name])
        assert axis.dtype == together[name].dtype


@pytest.mark.parametrize(
    "wrong",
    [
        {"frequency": [1, True]},
        {"frequency": [1, "2"]},
        {"frequency": [float("nan")]},
        {"frequency": [0.0]},
        {"frequency": [10**400]},
        {"frequency": []},
        {"amplitude": [(-0.1, 0.1)]},
        {"amplitude": [(0.1, 4.0)]},
        {"amplitude": [(0.1, 0.1), (0.1,)]},
        {"amplitude": [0.1, 0.2]},
        {"phase": [(0.0, 7.0)]},
        {"phase": [(0.0,)]},
        {"bias": [(0.0, None)]},
    ],
)
def test_a_grid_with_a_mistake_is_refused_as_before(wrong: dict[str, Any]) -> None:
    sound: dict[str, Any] = {"frequency": [1.0], "amplitude": [(0.1, 0.2)], "phase": [(0.0, 0.3)], "bias": None}
    with pytest.raises(InputError):
        ht.Gaits.grid(**sound | wrong)
