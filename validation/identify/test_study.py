"""A small sample of the study beside this file."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import pytest

import hypertuna as ht

REPEATS = 24


@pytest.fixture(scope="module")
def study() -> dict[str, Any]:
    return runpy.run_path(str(Path(__file__).parent / "study.py"))


def test_intervals_hold_the_truth(study: dict[str, Any]) -> None:
    """Two coefficients, both constrained: 48 intervals, of which 95 % hold the truth; 40 are 4 sd fewer."""
    robot, gaits = ht.load("hypertuna"), study["tank"]()[::20]
    names = ("water.friction[1-6]", "water.drag[7]")
    records = [study["repeat"](robot, gaits, names, seed) for seed in range(REPEATS)]
    found = study["summary"](records)
    assert found["converged"] == REPEATS
    assert found["reported_as_constrained"] == [REPEATS, REPEATS]
    assert found["coverage"] >= 40 / 48


def test_open_directions_of_nine_coefficients_are_flagged(study: dict[str, Any]) -> None:
    """The truth lies far from the result along some directions: those are reported as open."""
    robot = ht.load("hypertuna")
    record = study["repeat"](robot, study["tank"](), study["NINE"], 0)
    assert record["constrained"][:3] == [True] * 3
    assert record["constrained"][-3:] == [False] * 3
    far = [abs(off) * sd > 1 for off, sd in zip(record["off"], record["sd"], strict=True)]
    assert any(far)
    assert not any(is_far and known for is_far, known in zip(far, record["constrained"], strict=True))


def test_intervals_hold_the_truth_while_the_model_is_wrong() -> None:
    """A small sample of coverage.py: 54 intervals of 90 %, of which 43 are 2.5 sd fewer; none is called short."""
    study = runpy.run_path(str(Path(__file__).parent / "coverage.py"))
    records = [study["fitted"](model, "defaults", seed) for model in study["MODELS"] for seed in range(6)]
    assert sum(sum(record["held"]) for record in records) >= 43
    alone = [study["fitted"]("drag area off by 2", "drag along", seed) for seed in range(6)]
    assert [record["constrained"] for record in alone] == [[False]] * 6
    assert sum(record["held"][0] for record in alone) >= 5


def test_intervals_hold_a_hidden_stiffness() -> None:
    """A small sample of springs.py: eight intervals of 95 %, of which five are 4 sd fewer."""
    study = runpy.run_path(str(Path(__file__).parent / "springs.py"))
    records = [study["repeat"]("noise", seed) for seed in range(8)]
    assert sum(record["held"] for record in records) > 5
    assert all(record["constrained"] and record["converged"] for record in records)
