"""Fixtures of all tests, and how Hypothesis runs."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, settings

import hypertuna as ht
from models import MODELS

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


@pytest.fixture(scope="session")
def tuna() -> ht.Robot:
    """HyperTuna as described: lumped law, joint bandwidth, consistent areas."""
    return ht.load("hypertuna")


@pytest.fixture(scope="session", params=MODELS.values(), ids=MODELS.keys())
def every_model(request: pytest.FixtureRequest) -> ht.Robot:
    """Each robot with each of its water laws and their variants in turn."""
    robot: ht.Robot = request.param
    return robot
