"""The unknowns of a bench as points: zero is the description, and the bounds are those of the unknowns."""

from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.characterization.problem import BenchProblem
from hypertuna.characterization.unknowns import unknowns


@pytest.fixture
def problem(tuna: ht.Robot) -> BenchProblem:
    """All unknowns of HyperTuna's joints, without measurements: points do not need any."""
    none: Any = None
    return BenchProblem(tuna, none, unknowns(tuna, (0, 1), optional=True), "linear", none)


def test_zero_is_the_description_and_bounds_are_those_of_the_unknowns(problem: BenchProblem) -> None:
    low, high = problem.bounds()
    assert (low < 0).all()
    assert (high > 0).all()
    ends = np.column_stack([problem.values(low), problem.values(high)])
    limits = np.array([[u.lower, u.upper] for u in problem.free])
    np.testing.assert_allclose(np.sort(ends, axis=1), np.sort(limits, axis=1), rtol=1e-9)
    described = [u.described for u in problem.free]
    np.testing.assert_allclose(problem.values(np.zeros(len(described))), described, rtol=1e-12)
