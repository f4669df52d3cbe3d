"""Hooks of the conftest of each folder of tests: slow tests, tests of extras, no examples of tests."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from _pytest.doctest import DoctestModule

if TYPE_CHECKING:
    from collections.abc import Generator

FE = ("netgen", "ngsolve", "pyvista")  # packages of the extra fe
SLOW = Path(__file__).with_name("slow.txt")  # names of slow tests, after lines of comment


def slow() -> list[str]:
    """Return the names of the tests in slow.txt."""
    lines = SLOW.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if not line.startswith("#")]


@pytest.hookimpl(tryfirst=True)  # before pytest chooses by marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests in slow.txt."""
    names = set(slow())
    for item in items:
        if item.nodeid in names:
            item.add_marker("slow")


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what is marked `fe` where the extra is not installed."""
    missing = [name for name in FE if find_spec(name) is None]
    if missing and item.get_closest_marker("fe"):
        pytest.skip(f"needs the extra fe ({', '.join(missing)} not installed): make test-fe")


@pytest.hookimpl(wrapper=True)
def pytest_collect_file() -> Generator[None, list[pytest.Collector], list[pytest.Collector]]:
    """Look for examples in the docstrings of the package alone: those of tests have none."""
    return [one for one in (yield) if not isinstance(one, DoctestModule)]
