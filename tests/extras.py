"""Skip tests whose extra is not installed: a hook of the conftest of each folder of tests."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

FE = ("netgen", "ngsolve", "pyvista")  # packages of the extra fe


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what is marked `fe` where the extra is not installed."""
    missing = [name for name in FE if find_spec(name) is None]
    if missing and item.get_closest_marker("fe"):
        pytest.skip(f"needs the extra fe ({', '.join(missing)} not installed): make test-fe")
