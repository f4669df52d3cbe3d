"""A small sample of the study beside this file, and what its stored result must show."""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # of `ways`, which reads `draws`


@pytest.fixture(scope="module")
def study() -> dict[str, Any]:
    return runpy.run_path(str(HERE / "draws.py"))


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


def test_no_other_way_to_choose_is_better_than_the_greedy_one(study: dict[str, Any]) -> None:
    """One draw anew, and all that are stored: the differences are within the scatter of 40 draws."""
    ways = runpy.run_path(str(HERE / "ways.py"))
    lines = json.loads((HERE / "ways.json").read_text())
    seed, unknowns = next(iter(lines)), study["synthetic_unknowns"](study["fish"]())
    assert {how: ways["error"](unknowns, how, int(seed)) for how in ways["RUNS"]} == pytest.approx(
        lines[seed], rel=0.01
    )
    for how in ways["RUNS"]:
        ratio = np.log([line[how] / line["greedy"] for line in lines.values()])
        assert abs(ratio.mean()) <= 2 * ratio.std() / len(ratio) ** 0.5


def test_the_stored_result_is_of_this_robot(study: dict[str, Any]) -> None:
    stored = json.loads((HERE / "study.json").read_text())
    assert stored["robot_hash"] == study["fish"]().hash
    records = [json.loads(line)["told"] for line in (HERE / "study.jsonl").read_text().splitlines()[1:]]
    assert study["summary"](records) == stored["summary"]
