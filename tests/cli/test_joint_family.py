"""The command `hypertuna joint family`: what it prints, draws and writes, and what it says of bad input."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.characterization.checked import check_chosen
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.family import family
from hypertuna.fe.joint_map import Joint
from hypertuna.fe.model import FeOptions
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
    "facts": {
        "file",
        "line",
        "joint",
        "side",
        "branch",
        "pressure_kpa",
        "kind",
        "unit",
        "measured",
        "sd",
        "low",
        "median",
        "high",
    },
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
    assert "I, left, 250 kPa: angle" in text
    assert "add --check, or write it by -o FILE.toml, then" in text
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


def elements(robot: ht.Robot, joint: int, options: FeOptions) -> Joint:
    """The fast model as if by elements, whose joint II has no equilibrium."""
    assert options.mesh == "fine"

    def solve(couple: float, path: Sequence[tuple[float, float]]) -> dict[str, Any]:
        angle = math.radians(18.5) if max(path[-1]) else 0.0
        return {"angle": angle, "volume": [0.0, 0.0], "length": 0.1, "fault": "no step lowers the energy" * joint}

    return solve


def test_the_chosen_design_is_checked_by_elements(run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("hypertuna.cli.joint_family.need_fe", lambda: None)
    monkeypatch.setattr("hypertuna.cli.joint_family.check_chosen", partial(check_chosen, solve=elements))
    fault = "Joint II, left: 0 kPa was not reached by finite elements (no step lowers the energy)."
    robot = tmp_path / "one.toml"
    command = (*PAPER, *FEW, "-o", str(robot), "--check", "--mesh", "fine")
    code, output, _ = run(*command)
    text = " ".join(output.split())
    assert (code, robot.exists()) == (1, True)
    assert "Chosen design by finite elements, mesh fine:" in text
    assert "Finite elements have no friction" in text
    assert fault in text
    assert "hypertuna fe bend" not in text
    code, output, _ = run(*command, "--json")
    told = json.loads(output)
    first, second = told["check"]["facts"]
    assert (code, told["check"]["mesh"]) == (1, "fine")
    assert first["elements"] == pytest.approx(18.5)
    assert first["chosen"] == pytest.approx(18.2, rel=0.1)
    assert first["without_friction"] > first["chosen"]
    assert first["difference_percent"] == pytest.approx(100 * (first["without_friction"] / 18.5 - 1))
    assert (first["fault"], second["fault"], second["elements"]) == ("", fault, None)
    shown = [f"{first[key]:.3g}" for key in ("measured", "chosen", "without_friction", "elements")]
    assert f"I, left, 250 kPa: angle deg {' '.join(shown)} {first['difference_percent']:+.1f}" in text


def test_a_check_needs_the_extra_a_mesh_and_to_be_asked_for(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    code, _, errors = run(*PAPER, "--mesh", "fine")
    assert (code, "--mesh is used only with --check: add --check" in errors) == (2, True)
    code, _, errors = run(*PAPER, "--check", "--mesh", "finer")
    assert (code, "finer" in errors) == (2, True)
    monkeypatch.setattr("hypertuna.io.extras.find_spec", lambda name: None)
    code, _, errors = run(*PAPER, "--check")
    assert (code, "ngsolve is needed by finite elements and is not installed: pip install" in errors) == (2, True)


def test_a_bad_bench_writes_nothing(run: Run, tmp_path: Path) -> None:
    bad, robot = tmp_path / "bad.csv", tmp_path / "one.toml"
    bad.write_text("joint,side,pressure_kpa,force_n\nI,left,100,5\n")
    code, _, errors = run("joint", "family", str(bad), "--robot", "hypertuna", "-o", str(robot))
    assert (code, robot.exists()) == (2, False)
    assert f"{bad}: line 2, arm_mm must be given with a force, but is empty" in errors
    bad.write_text("joint,side,pressure_kpa,angle_deg\n1,left,100,5\n")
    code, _, errors = run("joint", "family", str(bad), "--robot", "rexeel")
    assert (code, "drive_unit is missing: add the table [drive_unit]" in errors) == (2, True)
