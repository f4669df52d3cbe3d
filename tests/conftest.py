"""Fixtures of all tests, and how Hypothesis runs."""

from __future__ import annotations

import sys
from importlib.util import find_spec

import pytest
from hypothesis import HealthCheck, Phase, settings

import hypertuna as ht
from hypertuna.cli.main import main
from models import MODELS
from program import Run

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


FE = ("netgen", "ngsolve", "pyvista")  # packages of the extra fe


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what is marked `fe` where the extra is not installed."""
    missing = [name for name in FE if find_spec(name) is None]
    if missing and item.get_closest_marker("fe"):
        pytest.skip(f"needs the extra fe ({', '.join(missing)} not installed): make test-fe")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `hypertuna` with arguments, on a terminal wide enough for every line: exit code, output, errors."""
    monkeypatch.setenv("COLUMNS", "400")

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
