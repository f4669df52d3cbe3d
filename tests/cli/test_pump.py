"""The command `hypertuna pump`: what it prints and writes, and what it says of bad input."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from hypertuna.actuation.cards import sizes_verdict
from hypertuna.actuation.sizing import largest_beat, size_over, size_pump
from program import Run

PUMP = ("pump", "--robot", "hypertuna")


def test_json_tells_the_sizes_of_the_function(run: Run, tuna: ht.Robot) -> None:
    code, output, _ = run(*PUMP, "--bore", "3:4:2", "--temperature", "20", "--json")
    assert code == 0
    told = json.loads(output)["sizes"]
    frequency, amplitude = largest_beat(tuna)
    sizes = size_pump(tuna, frequency=[frequency], amplitude=amplitude, bore=[3e-3, 4e-3], temperature=[293.15])
    assert [(row["joint"], row["bore_mm"]) for row in told] == [("I", 3), ("II", 3), ("I", 4), ("II", 4)]
    for row, size in zip(told, sizes, strict=True):
        assert row["bend_deg"] == pytest.approx(math.degrees(size.bend))
        assert row["corner_hz"] == pytest.approx(size.corner)
        assert row["torque_margin"] == pytest.approx(size.torque_limit / size.torque - 1)
        assert tuna.controller is not None
        assert row["pressure_max_kpa"] <= 1e-3 * (tuna.controller.works_at or 0.0)
        assert tuple(row["limits"]) == size.limits


def test_files_hold_the_table(run: Run, tmp_path: Path) -> None:
    table, data, plot = (str(tmp_path / name) for name in ("pump.csv", "pump.nc", "pump.svg"))
    options = ("--frequency", "2", "--temperature", "15:30:2")
    code, output, _ = run(*PUMP, *options, "-o", table, "--plot", plot)
    assert code == 0
    assert output.endswith(f"written: {plot}\nwritten: {table}\n")
    lines = Path(table).read_text().splitlines()
    rows = np.genfromtxt(lines, delimiter=",", names=True, dtype=None, encoding="utf-8")
    assert rows["temperature_c"].tolist() == [15, 15, 30, 30]
    assert "temperature of the oil" in Path(plot).read_text()
    assert run(*PUMP, *options, "-o", data)[0] == 0
    with xr.open_dataset(data, engine="h5netcdf") as found:
        np.testing.assert_allclose(found.bend_deg, rows["bend_deg"], rtol=1e-12)
        assert found.attrs["robot"] == "hypertuna"


def test_table_over_bore_and_temperature(run: Run) -> None:
    output = run(*PUMP, "--frequency", "1", "--amplitude", "4,8", "--bore", "3:4:2", "--temperature", "10:20:2")[1]
    assert "joint I at 1 Hz, 4 deg commanded" in output
    heads = next(line for line in output.splitlines() if "[C]" in line)
    assert heads.split() == ["joint", "[Hz]", "[mm]", "[C]", "[mm^2/s]", "[deg]", "[Hz]", "[W]", "limits"]
    assert len(re.findall(r"^II? +1 +[34] +[12]0 ", output, re.MULTILINE)) == 8


def test_one_case_is_told_in_full(run: Run) -> None:
    output = run(*PUMP, "--gait", "optimised-0.3")[1]
    for words in (
        "of 6.86 N m",
        "of 7.5 rad/s",
        "20 C, 133.8 mm^2/s",
        "resonance, with the muscles",
        "electrical power, both servos",
    ):
        assert output.count(words) == 2, words


def test_flow_beyond_the_laminar_law_is_told(run: Run) -> None:
    """Poiseuille's law ends at a Reynolds number of 2300; oil of 100 C passes it in joint I's line of 2 mm at 6 Hz."""
    case, table = (run(*PUMP, "--frequency", "6", "--bore", "2", "--temperature", at)[1] for at in ("100", "20:100:2"))
    assert case.count("turbulent: the pressure drop is underestimated") == 1
    assert "t turbulent: the pressure drop is underestimated" in table
    told = json.loads(run(*PUMP, "--frequency", "6", "--bore", "2", "--temperature", "20:100:2", "--json")[1])["sizes"]
    assert [row["turbulent"] for row in told] == [row["reynolds"] > 2300 for row in told] == [False, False, True, False]


def test_options_change_a_named_gait(run: Run) -> None:
    sizes = json.loads(run(*PUMP, "--gait", "optimised-0.3", "--frequency", "3", "--json")[1])["sizes"]
    named = json.loads(run(*PUMP, "--gait", "optimised-0.3", "--json")[1])["sizes"]
    assert {size["frequency_hz"] for size in sizes} == {3}
    assert [size["command_deg"] for size in sizes] == [size["command_deg"] for size in named]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--bore", "0"), "bore must be from 1 to 20 mm, but is 0: give it in mm"),
        (("--bore", "0.005"), "bore must be from 1 to 20 mm, but is 0.005"),
        (("--bore", "2:3"), "bore must be a number or start:stop:count"),
        (("--over", "pump.crnk_m=1"), "--over: pump.crnk_m is not a known key: did you mean crank_m?"),
        (("--temperature", "130"), "temperature must be from -9 to 100 degC, but is 130 degC"),
        (("--temperature", "cold"), "temperature must be a number"),
        (("--frequency", "0.001"), "frequency must be from 0.05 to 1000 Hz, but is 0.001"),
        (("--frequency", "0"), "frequency must be greater than 0"),
        (("--amplitude", "16"), "amplitude must be 2 long, one value per joint group"),
        (("--amplitude", "80,25"), "must be at most what pump and joint can do"),
        (("--gait", "turnin"), "did you mean turning?"),
        (("--plot", "pump.doc"), "--plot must end in .svg, .png or .pdf"),
        (("-o", "pump.txt"), "--output must end in .nc or .csv"),
        (("--frequency", "1e308"), "frequency must be from 0.05 to 1000 Hz, but is 1e+308"),
    ],
)
def test_bad_input_is_told_in_one_sentence(run: Run, options: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run(*PUMP, *options)
    assert code == 2
    assert not output
    assert sentence in errors
    assert errors.startswith("error: ")
    assert errors.count("\n") == 1


def test_a_robot_without_a_pump_is_told_so(run: Run) -> None:
    code, _, errors = run("pump", "--robot", "rexeel")
    assert code == 2
    assert errors == "error: robots/rexeel.toml: pump is missing: add the table [pump].\n"


def test_any_key_of_the_robot_can_vary(run: Run, tmp_path: Path) -> None:
    key, table = "servos.piston pump.torque_n_m", tmp_path / "over.csv"
    over = ("pump", "--frequency", "3", "--over", f"{key}=3,6.86", "--over", "joints.I.actuator.lever_m=0.008:0.012:2")
    code, output, _ = run(*over, "--json", "-o", str(table))
    sizes = json.loads(output)["sizes"]
    assert (code, len(sizes)) == (0, 2 * 2 * 2)  # values, values, joints
    assert [size[key] for size in sizes[::4]] == [3, 6.86]
    assert [size["joints.I.actuator.lever_m"] for size in sizes[:4:2]] == [0.008, 0.012]
    assert sizes[0]["torque_limit_n_m"] == pytest.approx(3)
    alone = json.loads(run("pump", "--frequency", "3", "--set", "joints.I.actuator.lever_m=0.012", "--json")[1])
    assert sizes[6]["bend_deg"] == alone["sizes"][0]["bend_deg"] != sizes[4]["bend_deg"]
    rows = [line for line in table.read_text().splitlines() if not line.startswith("#")]
    assert rows[0].startswith(f"{key},joints.I.actuator.lever_m,joint,")
    assert len(rows) == 1 + len(sizes)
    shown = run(*over)[1].splitlines()
    assert shown[1] == f"over {key} and joints.I.actuator.lever_m"
    assert shown[3 + len(sizes)].startswith("II ")
    assert shown[4 + len(sizes)].startswith("limits: c compliance")


def test_the_figure_runs_along_the_key_with_most_values(run: Run, tmp_path: Path) -> None:
    over = ("--over", "pump.crank_m=0.012:0.024:2", "--over", "servos.torque_n_m=0.8:1.6:3")
    assert run(*PUMP, "--frequency", "3", *over, "--plot", str(tmp_path / "pump.svg"))[0] == 0
    text = (tmp_path / "pump.svg").read_text()
    assert "torque [N m]" in text
    assert "crank 0.012 m" in text
    assert "bore of the lines" not in text
    assert "at the pressure limit" not in text  # no case is


def test_missed_bend_has_a_limit_and_the_sweep_a_verdict(run: Run) -> None:
    over = ("--frequency", "3", "--over", "servos.torque_n_m=0.8:1.6:2")
    output = " ".join(run(*PUMP, *over)[1].split())
    assert "nothing" not in output
    assert "limits: v a servo that lags by speed, torque or bandwidth; c compliance of lines, oil and air" in output
    assert (
        "No case reaches 95 % of the commanded bend with enough torque for the pressure limit; the best one reaches"
        in output
    )


def test_the_smallest_case_that_reaches_the_bend_is_named() -> None:
    tuna = ht.load("hypertuna")
    sizes = size_over(tuna, {"pump.crank_m": [0.024, 0.012]}, frequency=[1.0], amplitude=np.radians([10, 10]))
    whole = [replace(size, bend=size.command) for size in sizes]
    sentence = (
        "2 of 2 cases reach 95 % of the commanded bend with enough torque for the pressure limit; the smallest has "
    )
    assert sizes_verdict(whole) == f"{sentence}pump.crank_m = 0.012."
    assert sizes_verdict([*sizes[:2], *whole[2:]]).startswith("1 of 2 cases reach")
