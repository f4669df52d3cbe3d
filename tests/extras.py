"""Hooks of the conftest of each folder of tests: skip tests whose extra is not installed, and collect tests alone."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

import pytest
from _pytest.doctest import DoctestModule

if TYPE_CHECKING:
    from collections.abc import Generator

FE = ("netgen", "ngsolve", "pyvista")  # packages of the extra fe


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what is marked `fe` where the extra is not installed."""
    missing = [name for name in FE if find_spec(name) is None]
    if missing and item.get_closest_marker("fe"):
        pytest.skip(f"needs the extra fe ({', '.join(missing)} not installed): make test-fe")


@pytest.hookimpl(wrapper=True)
def pytest_collect_file() -> Generator[None, list[pytest.Collector], list[pytest.Collector]]:
    """Look for examples in the docstrings of the package alone: those of tests have none."""
    return [one for one in (yield) if not isinstance(one, DoctestModule)]
