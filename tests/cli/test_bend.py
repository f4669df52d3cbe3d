"""The command `hypertuna joint bend`: what it prints, writes and draws, and what it says of bad input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.actuation.plots import plot_bend
from hypertuna.actuation.soft_joint import MATERIAL_SETS
from program import Run

BEND = ("joint", "bend", "--robot", "hypertuna", "--joint", "I")


def own_set(robot: ht.Robot) -> str:
    """The material set that the robot's file names."""
    assert robot.drive_unit is not None
    return robot.drive_unit.material_set


def test_json_tells_what_the_function_finds(run: Run, tuna: ht.Robot) -> None:
    code, output, _ = run(*BEND, "--pressure", "0:250:26", "--unload", "--json")
    told = json.loads(output)
    loop = bend(tuna, "I", np.linspace(0, 250e3, 26), unload=True)
    assert code == 0
    np.testing.assert_allclose(told["pressure_kpa"], np.linspace(0, 250, 26))
    np.testing.assert_allclose(told["angle_deg"], np.degrees(loop.angle))
    np.testing.assert_allclose(told["unload_pressure_kpa"], np.linspace(250, 0, 26))
    np.testing.assert_allclose(told["unload_angle_deg"], np.degrees(loop.unload_angle))
    assert told["loop_area_kpa_deg"] == pytest.approx(np.degrees(loop.loop_area) / 1e3)
    assert (told["friction_loss_j"], told["status"]) == (loop.friction_loss, "free")
    assert told["robot_hash"] == tuna.hash


def test_a_joint_may_be_counted_from_the_head(run: Run) -> None:
    by_name, by_number = (json.loads(run(*BEND[:-1], joint, "--json")[1]) for joint in ("II", "2"))
    assert by_number["joint"] == "II"
    assert by_number["angle_deg"] == by_name["angle_deg"]


def test_the_other_branch_is_told_only_when_asked_for(run: Run) -> None:
    told = json.loads(run(*BEND, "--pressure", "50,100:250:4", "--side", "right", "--json")[1])
    assert told["pressure_kpa"] == [50, 100, 150, 200, 250]
    assert told["side"] == "right"
    assert not [key for key in told if key.startswith("unload")]
    assert told["friction_loss_j"] is None
    assert json.loads(run(*BEND, "--pressure", "50", "--json")[1])["r_squared"] is None


def test_all_material_sets_and_their_spread(run: Run, tuna: ht.Robot, tmp_path: Path) -> None:
    code, output, _ = run(*BEND, "--material", "all", "--unload", "-o", str(tmp_path / "all.nc"), "--json")
    told = json.loads(output)
    assert code == 0
    assert tuple(told["materials"]) == MATERIAL_SETS
    largest = [bend(tuna, "I", [250e3], material=name).angle[0] for name in MATERIAL_SETS]
    assert [part["angle_deg"][-1] for part in told["materials"].values()] == pytest.approx(np.degrees(largest))
    assert list(told["spread_deg"].values()) == pytest.approx([min(np.degrees(largest)), max(np.degrees(largest))])
    assert told["angle_deg"] == told["materials"][own_set(tuna)]["angle_deg"]  # the robot's own set stands first
    whole = xr.load_dataset(tmp_path / "all.nc")
    assert dict(whole.sizes) == {"material": len(MATERIAL_SETS), "gauge_pressure": 26}
    np.testing.assert_allclose(whole.angle[:, -1], largest)
    assert whole.angle.attrs["units"] == "rad"
    assert whole.attrs["command"].startswith("hypertuna joint bend")
    text = run(*BEND, "--material", "all", "--unload")[1]
    low, high = np.degrees([min(largest), max(largest)])
    assert f"spread of the materials at 250 kPa: {low:.1f} to {high:.1f} deg" in text


def test_files_have_what_was_printed(run: Run, tuna: ht.Robot, tmp_path: Path) -> None:
    table, labeled = tmp_path / "bend.csv", tmp_path / "bend.nc"
    code, output, _ = run(*BEND, "--unload", "--material", "fe", "-o", str(table))
    assert code == 0
    assert f"written: {table}" in output
    lines = table.read_text().splitlines()
    assert lines[0] == "material,branch,pressure_kpa,angle_deg"
    assert (lines[26].split(",")[:3], lines[27].split(",")[:3]) == (["fe", "load", "250.0"], ["fe", "unload", "250.0"])
    assert json.loads(Path(f"{table}.json").read_text())["robot_hash"] == tuna.hash
    assert run(*BEND, "--unload", "--no-friction", "-o", str(labeled))[0] == 0
    found = xr.load_dataset(labeled)
    smooth = bend(tuna, "I", np.linspace(0, 250e3, 26), friction=False)
    np.testing.assert_allclose(found.angle, smooth.angle)
    np.testing.assert_allclose(found.unload_angle, smooth.angle, atol=1e-14)
    assert (found.attrs["friction"], found.attrs["material"]) == ("false", own_set(tuna))


def test_the_printed_equations_come_with_the_size_of_their_errors(run: Run, tuna: ht.Robot) -> None:
    told = json.loads(run(*BEND, "--law", "as_printed", "--json")[1])
    assert told["law"] == "as_printed"
    assert told["angle_deg"][-1] == told["misprints"][0]["angle_deg"] > 30
    assert told["misprints"][-1]["angle_deg"] == pytest.approx(np.degrees(bend(tuna, "I", [250e3]).angle[0]))
    assert "Eqs 10-11: true stress" in run(*BEND, "--law", "as_printed")[1]


def test_the_figure_shows_both_branches_and_all_materials(run: Run, tuna: ht.Robot, tmp_path: Path) -> None:
    picture = tmp_path / "bend.svg"
    assert run(*BEND, "--unload", "--plot", str(picture))[0] == 0
    text = picture.read_text()
    own = own_set(tuna)
    lines = (f"{own} set, loading", f"{own} set, unloading", "datasheet set", "tensile set")
    for words in (*lines, "gauge pressure [kPa]", "bend [deg]"):
        assert f"<!-- {words} -->" in text
    sets = {name: bend(tuna, "II", [1e5, 2e5, 2.5e5], material=name) for name in MATERIAL_SETS}
    axes = plot_bend(sets[own], sets).axes[0]
    assert {line.get_label() for line in axes.lines} >= {f"{own} set, loading", "datasheet set", "tensile set"}
    np.testing.assert_allclose(axes.lines[-1].get_xydata(), [[250, 31.2]])  # what the description says of this joint


BAD = {
    "joint": ((*BEND[:-1], "III"), "joint must be a joint of hypertuna, but is 'III': did you mean II?"),
    "robot": (("joint", "bend", "--robot", "rexeel", "--joint", "1"), "robots/rexeel.toml: drive_unit is missing"),
    "negative": ((*BEND, "--pressure", "-50:250:4"), "pressure must not be negative, but is -50 kPa"),
    "falling": ((*BEND, "--pressure", "250:0:4"), "pressure must increase, but is 250 kPa, then"),
    "word": ((*BEND, "--pressure", "high"), "--pressure must be a number, but is 'high': give it in kPa"),
    "pascal": ((*BEND, "--pressure", "250000"), "--pressure must be at most 2000, but is 250000: give it in kPa"),
    "many": ((*BEND, "--pressure", "0:250:20000"), "--pressure must be at most 10000 pressures, but is 20000"),
    "nan": ((*BEND, "--pressure", "0,nan"), "--pressure[1] must be a finite number"),
    "material": ((*BEND, "--material", "rubber"), "must be a known material set, but is 'rubber'"),
    "law": ((*BEND, "--law", "printed"), "law must be a known law, but is 'printed': did you mean as_printed?"),
    "side": ((*BEND, "--side", "up"), "side must be left or right, but is 'up'"),
    "plot": ((*BEND, "--plot", "bend.txt"), "--plot must end in .svg, .png or .pdf"),
    "output": ((*BEND, "-o", "nowhere/bend.nc"), "--output must be in a folder that exists"),
}


@pytest.mark.parametrize(("arguments", "sentence"), BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_sentence(run: Run, arguments: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run(*arguments)
    assert (code, output) == (2, "")
    assert sentence in errors
    assert errors.count("\n") == 1


def test_without_the_way_back_there_is_no_loop(run: Run) -> None:
    told = json.loads(run("joint", "bend", "--robot", "hypertuna", "--joint", "I", "--json")[1])
    assert told["loop_area_kpa_deg"] is None
    assert told["friction_loss_j"] is None


def test_a_sample_of_the_pressures_is_told(run: Run) -> None:
    asked = ("joint", "bend", "--robot", "hypertuna", "--joint", "I", "--pressure")
    assert "11 of 26 pressures; -o FILE.csv and --json have all" in run(*asked, "0:250:26")[1]
    assert "pressures; -o" not in run(*asked, "0:250:11")[1]
