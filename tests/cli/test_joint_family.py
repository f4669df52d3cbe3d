"""The command `hypertuna joint family`: what it prints, draws and writes, and what it says of bad input."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.family import family
from program import Run

BENCH = Path(__file__).parents[2] / "examples" / "bench"
PAPER = ("joint", "family", str(BENCH / "paper.csv"), "--robot", "hypertuna")
FEW = ("--free", "lever,stiffness_factor,outer_diameter", "--members", "50")
# Keys of the record, of its lists and of what made it.
KEYS = {
    "": {
        "members",
        "distinct",
        "chosen",
        "values",
        "quantities",
        "seed",
        "model_error",
        "draws",
        "evaluations",
        "powers",
    },
    "unknowns": {"name", "unit", "described", "lower", "upper", "low", "median", "high", "chosen"},
    "facts": {"file", "line", "joint", "pressure_kpa", "kind", "unit", "measured", "sd", "low", "median", "high"},
    "ranges": {"quantity", "unit", "low", "median", "high", "chosen"},
    "next": {"text", "unit", "bits", "expected", "narrows"},
}


def test_json_tells_what_the_function_finds(run: Run, tuna: ht.Robot) -> None:
    code, output, _ = run(*PAPER, *FEW, "--json", "--seed", "3")
    told = json.loads(output)
    found = family(tuna, read_bench(BENCH / "paper.csv", tuna), FEW[1], members=50, seed=3)
    assert code == 0
    for key, names in KEYS.items():
        for row in [told] if not key else told[key]:
            assert names <= row.keys(), key
    assert {"hypertuna_version", "robot_hash", "files", "checks", "warnings", "seconds"} <= told.keys()
    assert (told["members"], told["seed"], told["robot_hash"]) == (50, 3, tuna.hash)
    assert told["values"]["lever[I]"] == pytest.approx((1e3 * found.values[:, 0]).tolist(), rel=1e-6)
    assert told["ranges"][0]["quantity"] == "blocked moment of joint I at 250 kPa"
    assert [len(values) for values in told["quantities"].values()] == [50] * len(told["ranges"])
    assert [one["text"] for one in told["next"]] == [one.text for one in found.next]


def test_the_terminal_says_what_is_open_and_what_to_measure_next(run: Run) -> None:
    code, output, _ = run(*PAPER, *FEW)
    text = " ".join(output.split())
    assert code == 0
    assert "hypertuna, joints I and II: 50 designs that meet 2 values" in text
    assert "blocked moment of joint I at 250 kPa" in text
    first = r"What to measure next, the most informative first: [\d.]+ bits \S.+?: [\d.]+ to [\d.]+ .+?\. It narrows \S"
    assert re.search(first, text)
    assert "write it by -o FILE.toml, then" in text
    assert "hypertuna fe bend --robot FILE.toml --joint II --pressure 0:250:6" in text


def test_it_draws_and_writes_a_robot_that_bends_as_measured(run: Run, tmp_path: Path) -> None:
    plot, robot = tmp_path / "family.svg", tmp_path / "one.toml"
    code, output, _ = run(*PAPER, *FEW, "--plot", str(plot), "-o", str(robot))
    assert code == 0
    assert f"written: {plot}" in output
    assert f"hypertuna fe bend --robot {robot} --joint I --pressure 0:250:6" in " ".join(output.split())
    assert "<!-- blocked moment [N m] -->" in plot.read_text()
    chosen = ht.load(robot)
    assert (chosen.source("joints.actuator.lever_m") or "").startswith("one of 50 designs of hypertuna joint family")
    for joint, angle in (("I", 18.2), ("II", 31.2)):
        assert math.degrees(bend(chosen, joint, [250e3]).angle[0]) == pytest.approx(angle, rel=0.12)


def test_a_bad_bench_writes_nothing(run: Run, tmp_path: Path) -> None:
    bad, robot = tmp_path / "bad.csv", tmp_path / "one.toml"
    bad.write_text("joint,side,pressure_kpa,force_n\nI,left,100,5\n")
    code, _, errors = run("joint", "family", str(bad), "--robot", "hypertuna", "-o", str(robot))
    assert (code, robot.exists()) == (2, False)
    assert f"{bad}: line 2, arm_mm must be given with a force, but is empty" in errors
    bad.write_text("joint,side,pressure_kpa,angle_deg\n1,left,100,5\n")
    code, _, errors = run("joint", "family", str(bad), "--robot", "rexeel")
    assert (code, "drive_unit is missing: add the table [drive_unit]" in errors) == (2, True)
