"""Fixtures of all tests, and how Hypothesis runs."""

from __future__ import annotations

import fcntl
import pickle
import sys
import threading
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, Phase, settings

import hypertuna as ht
from extras import pytest_collect_file as pytest_collect_file
from extras import pytest_collection_modifyitems as pytest_collection_modifyitems
from extras import pytest_runtest_setup as pytest_runtest_setup
from hypertuna.cli.main import main
from models import MODELS
from program import Run

if TYPE_CHECKING:
    from hypertuna.paper.reproduce import Ledger

# The same examples in every run: a test that fails on one machine fails on all.
settings.register_profile(
    "hypertuna",
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
    deadline=None,
    max_examples=20,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("hypertuna")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `hypertuna` with arguments, on a terminal wide enough for every line: exit code, output, errors."""
    monkeypatch.setenv("COLUMNS", "400")
    monkeypatch.setattr("hypertuna.cli.console.PERIOD", threading.TIMEOUT_MAX)  # no lines of progress on slow machines

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["hypertuna", *arguments])
        with pytest.raises(SystemExit) as exit_:
            main()
        code = exit_.value.code
        assert isinstance(code, int) or code is None
        return code or 0, *capsys.readouterr()

    return call


@pytest.fixture(scope="session")
def tuna() -> ht.Robot:
    """HyperTuna as described: lumped law, joint bandwidth, consistent areas."""
    return ht.load("hypertuna")


@pytest.fixture(scope="session", params=MODELS.values(), ids=MODELS.keys())
def every_model(request: pytest.FixtureRequest) -> ht.Robot:
    """Each robot with each of its water laws and their variants in turn."""
    robot: ht.Robot = request.param
    return robot


@pytest.fixture(scope="session")
def reproduced(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Ledger, list[tuple[int, int]]]:
    """The paper's ledger, which takes seconds, with its progress: computed once for all workers of a run."""
    from hypertuna.paper.reproduce import reproduce

    folder = tmp_path_factory.getbasetemp()
    file = (folder.parent if hasattr(request.config, "workerinput") else folder) / "ledger.pickle"
    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not file.exists():
            steps: list[tuple[int, int]] = []
            file.write_bytes(pickle.dumps((reproduce(progress=lambda *step: steps.append(step)), steps)))
    found: tuple[Ledger, list[tuple[int, int]]] = pickle.loads(file.read_bytes())
    return found


@pytest.fixture(scope="session")
def ledger(reproduced: tuple[Ledger, list[tuple[int, int]]]) -> Ledger:
    """The paper's ledger."""
    return reproduced[0]
