"""The command `hypertuna joint fit`: what it prints, draws and writes; what it and `joint family` say of bad input."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.fit import fit_bench
from program import Run

EXAMPLE = Path(__file__).parents[2] / "examples" / "bench"
PAPER = ("joint", "fit", str(EXAMPLE / "paper.csv"), "--robot", "hypertuna", "--starts", "1")
FEW = ("--free", "lever,stiffness_factor,outer_diameter")


def test_json_tells_what_the_function_finds(run: Run, tuna: ht.Robot) -> None:
    code, output, _ = run(*PAPER, *FEW, "--json")
    told = json.loads(output)
    fit = fit_bench(tuna, read_bench(EXAMPLE / "paper.csv", tuna), FEW[1], starts=1)
    assert code == 0
    assert (told["rows"], told["determined"], told["converged"]) == (2, len(fit.combinations), True)
    assert [row["name"] for row in told["unknowns"]] == [one.name for one in fit.free]
    lever, diameter = told["unknowns"][0], told["unknowns"][-1]
    assert (lever["unit"], diameter["name"]) == ("mm", "outer_diameter")
    assert [row["value"] for row in told["unknowns"][:2]] == pytest.approx((1e3 * fit.values[:2]).tolist())
    assert [one["text"] for one in told["combinations"]] == [one.text for one in fit.combinations]
    values = [one["singular_value"] for one in told["spectrum"]]
    assert values == sorted(values, reverse=True)
    assert [one["determined"] for one in told["spectrum"]] == [True, True, False, False, False]
    bits = [one["bits"] for one in told["measurements"]]
    assert bits == sorted(bits, reverse=True)
    assert told["robot_hash"] == tuna.hash
    assert told["fit_hash"] == fit.robot.hash


def test_the_terminal_says_what_is_known_and_what_stays_free(run: Run) -> None:
    code, output, _ = run(*PAPER, *FEW)
    assert code == 0
    assert "hypertuna, joints I and II: 2 rows" in output
    sentence = r"The bench determines 0 of 5 unknowns, and \d combinations? of them; the fitted values are one of many"
    assert re.search(sentence, " ".join(output.split()))
    assert output.count("not determined") >= 3
    assert "ftol" not in output
    assert "Additional measurements, the most informative first:" in output
    assert "outer diameter of the hose, by caliper" in output


def test_bounds_are_what_is_known_before(run: Run) -> None:
    wide, narrow = (
        json.loads(run(*PAPER, *FEW, "--json", *more)[1])["unknowns"][-1]
        for more in ((), ("--bounds", "outer_diameter=3.9:4.1"))
    )
    assert narrow["low"] >= 3.9
    assert narrow["high"] <= 4.1
    assert wide["high"] > 5
    assert narrow["determined"] is False  # by its bounds, not by the bench


def test_it_draws_and_writes_a_robot(run: Run, tmp_path: Path) -> None:
    plot, robot = tmp_path / "fit.svg", tmp_path / "fit.toml"
    code, output, _ = run(*PAPER, *FEW, "--plot", str(plot), "-o", str(robot))
    assert code == 0
    assert f"written: {plot}" in output
    text = plot.read_text()
    for word in ("joint I", "joint II", "spectrum", "95 % intervals", "gauge pressure [kPa]"):
        assert f"<!-- {word} -->" in text
    fitted = ht.load(robot)
    assert (fitted.source("joints.actuator.lever_m") or "").startswith("fitted by hypertuna joint fit to ")
    assert robot.read_text().startswith("# HyperTuna:")
    again = run("joint", "fit", str(EXAMPLE / "paper.csv"), "--robot", str(robot), "--starts", "1", *FEW, "--json")
    assert json.loads(again[1])["robot_hash"] == fitted.hash


BAD = {  # options that a command refuses
    ("fit", "family"): [
        (("--free", "leaver"), "free leaver must be an unknown of this bench and robot"),
        (("--bounds", "lever"), "--bounds must be NAME=LOW:HIGH, but is lever"),
        (("--bounds", "lever=a:b"), "--bounds lever must be a number, but is 'a': give it in mm"),
        (("-o", "robot.csv"), "--output must end in .toml"),
        (("--plot", "fit.txt"), "--plot must end in .svg, .png or .pdf"),
    ],
    ("fit",): [
        (("--bounds", "lever[I]=1:2"), "bounds lever[I] must include the described value, 13 mm, but is 1 to 2 mm"),
        (("--loss", "l2"), "--loss must be soft_l1, linear, huber or cauchy"),
        (("--starts", "some"), "--starts must be a whole number"),
    ],
    ("family",): [
        (("--members", "3"), "members must be from 50 to 5000, but is 3"),
        (("--model-error", "80"), "--model-error must be from 0 to 50 percent"),
    ],
}


@pytest.mark.parametrize(
    ("command", "more", "sentence"),
    [(command, *case) for commands, cases in BAD.items() for command in commands for case in cases],
)
def test_bad_options_are_told(run: Run, command: str, more: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run("joint", command, *PAPER[2:5], *more)
    assert (code, output) == (2, "")
    assert errors.startswith("error: ")
    assert sentence in errors


def test_a_bad_bench_writes_nothing(run: Run, tmp_path: Path) -> None:
    bad, robot = tmp_path / "bad.csv", tmp_path / "fit.toml"
    bad.write_text("joint,side,pressure_kpa,angle_deg\nI,left,100,5\nI,left,nan,6\n")
    code, _, errors = run("joint", "fit", str(bad), "--robot", "hypertuna", "-o", str(robot))
    assert code == 2
    assert f"{bad}: line 3, pressure_kpa must be a finite number, but is 'nan'" in errors
    assert not robot.exists()
    code, _, errors = run("joint", "fit", str(tmp_path / "none.csv"), "--robot", "hypertuna")
    assert (code, "must be a file, but is missing" in errors) == (2, True)
    fine = tmp_path / "fine.csv"
    fine.write_text("joint,side,pressure_kpa,angle_deg\n1,left,100,5\n")
    code, _, errors = run("joint", "fit", str(fine), "--robot", "rexeel")
    assert (code, "drive_unit is missing: add the table [drive_unit]" in errors) == (2, True)


def test_what_is_known_to_a_factor_of_hundreds_is_not_determined(run: Run, tmp_path: Path) -> None:
    """With about as many rows as unknowns and a noise of half a degree, little is known beside the bounds."""
    few = tmp_path / "few.csv"
    rows = [f"I,left,{pressure},{0.06 * pressure:.1f},0.5" for pressure in (50, 75, 100, 150, 200, 250)]
    few.write_text("\n".join(["joint,side,pressure_kpa,angle_deg,angle_sd_deg", *rows]) + "\n")
    told = json.loads(run("joint", "fit", str(few), "--starts", "1", "--json")[1])
    assert len(told["unknowns"]) > 6
    assert told["determined"] == len(told["combinations"]) < len(told["unknowns"])
    assert all(one["high"] <= 4 * one["low"] for one in told["combinations"])
    assert all(one["high"] <= 4 * one["low"] for one in told["unknowns"] if one["determined"])
    few.write_text("\n".join(["joint,side,pressure_kpa,angle_deg", *(row[:-4] for row in rows)]) + "\n")
    code, _, errors = run("joint", "fit", str(few), "--starts", "1")
    assert code == 2
    assert "6 rows are too few for 9 unknowns to estimate their noise: add a column angle_sd_deg" in errors
