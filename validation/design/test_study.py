"""A small sample of the study beside this file, and what its stored result must show."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def study() -> dict[str, Any]:
    return runpy.run_path(str(HERE / "study.py"))


@pytest.mark.parametrize("linear", [False, True])
def test_intervals_hold_the_truth(study: dict[str, Any], linear: bool) -> None:
    """Three draws and 40 gaits each: 95 % of 120, less what the three draws have in common."""
    unknowns = study["synthetic_unknowns"](study["fish"]())
    records = [study["repeat"](unknowns, "design", seed, linear) for seed in range(3)]
    last = [record["after"][12] for record in records]
    assert sum(one["coverage"] for one in last) / 3 >= 0.85
    assert max(record["slowest_s"] for record in records) < 2
    if linear:
        assert sum(one["plain_coverage"] for one in last) / 3 < 0.85


def test_the_stored_result_is_of_this_robot(study: dict[str, Any]) -> None:
    stored = json.loads((HERE / "study.json").read_text())
    assert stored["robot_hash"] == study["fish"]().hash
    records = [json.loads(line)["told"] for line in (HERE / "study.jsonl").read_text().splitlines()[1:]]
    assert study["summary"](records) == stored["summary"]
