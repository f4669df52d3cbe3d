"""Map of a joint: the fast model comes back from its own points, and a journal goes on where it was."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
import hypertuna.cli.fe  # its help lists the meshes, before a test adds one
from cf_checker import cf_issues, same_files
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.description.robot import parse
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError
from hypertuna.fe.joint_map import Joint, JointMap, joint_by_elements, joint_map, joint_map_shards
from hypertuna.fe.mesh import MESHES, MeshSize
from hypertuna.fe.model import FeOptions
from hypertuna.fe.states import holding_moment
from program import Run

ROBOT = ht.load("hypertuna")
MODEL = {model.name: model for model in joint_models(ROBOT)}
PRESSURE = np.linspace(0, 250e3, 6)
ENDS = math.pi * 0.00125**2 * 0.008  # m^3, lumen of one hose in the ends, a diameter of 4 mm each
UNITS = {"I": 5, "II": 3}
LENGTH = {"I": 0.080, "II": 0.060}


def by_model(name: str, turn: float = 1.0, fails: float = math.inf) -> Joint:
    """The fast joint as if by elements, bent `turn` times as far; couples above `fails` find nothing."""

    def solve(couple: float, path: Sequence[tuple[float, float]]) -> dict[str, Any]:
        if couple > fails:
            return {"fault": "no step lowers the energy"}
        model, angle = MODEL[name], 0.0
        for _ in range(60):  # the moment is couple x cos(angle)
            found = model.balance(path[-1], couple * math.cos(angle))
            angle = float(found["angle"][0])
        length = LENGTH[name] + model["length"] * float(model["rest"] + found["strain"][0])
        volume = found["volume"][0] + UNITS[name] * ENDS
        return {"angle": turn * angle, "volume": volume.tolist(), "length": length, "fault": ""}

    return solve


@pytest.mark.parametrize("name", ["I", "II"])
def test_the_fast_model_comes_back_from_its_own_points(name: str) -> None:
    assert ROBOT.joints[("I", "II").index(name)].drive_units == UNITS[name]
    found = joint_map(ROBOT, name, pressure=PRESSURE, solve=by_model(name))
    assert found.status_text == "All 30 points have an equilibrium."
    # Sides share their oil about the line's fill: left and right add up to twice that until the right has none.
    whole = 2 * ROBOT.joints[("I", "II").index(name)].line.fill_pressure
    left, right = found.pressure.T
    np.testing.assert_allclose(right, np.maximum(0, whole - left))
    assert found.couple.tolist() == pytest.approx((np.linspace(-0.5, 0.5, 5) * found.straight).tolist(), rel=0.03)
    assert found.model.angle == pytest.approx(found.elements.angle, abs=1e-6)
    assert found.model.moment == pytest.approx(found.elements.moment, abs=1e-6)
    assert found.model.volume == pytest.approx(found.elements.volume, abs=1e-12)
    assert found.model.length == pytest.approx(found.elements.length, abs=1e-9)
    assert found.moment_difference < 1e-5
    assert found.volume_difference < 1e-5


def test_a_joint_that_bends_a_tenth_farther_is_seen() -> None:
    """The moment's difference is the tenth of the angle times the stiffness there, by the model's own slope."""
    found = joint_map(ROBOT, "II", pressure=[250e3], couple=[0.0], fill=0.0, solve=by_model("II", turn=1.1))
    both, h = (250e3, 0.0), 1e-3
    angle = found.model.angle[0, 0]
    assert found.elements.angle[0, 0] == pytest.approx(1.1 * angle)
    slope = (holding_moment(MODEL["II"], angle + h, both) - holding_moment(MODEL["II"], angle - h, both)) / (2 * h)
    assert found.largest("moment") == pytest.approx(0.1 * angle * slope, rel=0.15)
    assert found.straight == pytest.approx(-holding_moment(MODEL["II"], 0.0, both))
    assert found.record()["moment_difference_percent"] == pytest.approx(100 * found.largest("moment") / found.straight)


def test_points_that_were_not_found_are_left_out() -> None:
    found = joint_map(ROBOT, "II", pressure=PRESSURE, couple=[-0.1, 0, 0.1], solve=by_model("II", fails=0.05))
    assert found.status == "partial"
    assert found.status_text == "6 of 18 points have no equilibrium; the first: no step lowers the energy."
    assert np.isnan(found.elements.angle[2]).all()
    assert np.isnan(found.model.volume[2]).all()
    assert found.moment_difference < 1e-5
    nothing = joint_map(ROBOT, "II", pressure=PRESSURE, solve=by_model("II", fails=-1.0))
    assert math.isnan(nothing.moment_difference)
    assert math.isnan(nothing.volume_difference)


def same(a: JointMap, b: JointMap) -> bool:
    """Whether two maps are the same to the last bit."""
    pairs = ((a.elements, b.elements), (a.model, b.model))
    return all(np.array_equal(getattr(x, name), getattr(y, name)) for x, y in pairs for name in vars(x))


def test_a_killed_map_goes_on_where_it_was(tmp_path: Path) -> None:
    asked = 0
    given: dict[str, Any] = {"pressure": PRESSURE, "checkpoint": tmp_path / "map.journal"}
    whole = joint_map(ROBOT, "II", pressure=PRESSURE, solve=by_model("II"))

    def dies(couple: float, path: Sequence[tuple[float, float]]) -> Any:
        nonlocal asked
        asked += 1
        if asked == 9:
            raise KeyboardInterrupt
        return by_model("II")(couple, path)

    with pytest.raises(KeyboardInterrupt):
        joint_map(ROBOT, "II", solve=dies, **given)
    resumed = joint_map(ROBOT, "II", solve=dies, **given)
    assert asked == 9 + 30 - 8  # of 30 points eight were known
    assert same(whole, resumed)
    with pytest.raises(InputError, match="was started with pressure"):
        joint_map(ROBOT, "II", solve=dies, **given | {"fill": 0.0})


def test_shards_of_couples_merge_to_the_map(tmp_path: Path) -> None:
    given: dict[str, Any] = {"pressure": PRESSURE, "couple": [-0.1, 0, 0.1], "solve": by_model("II", fails=0.05)}
    whole = joint_map(ROBOT, "II", **given).dataset()
    assert [joint_map_shards(ROBOT, 1, tmp_path / "a.shards", part=(k, 2), **given) for k in (2, 1)] == [1, 2]
    merged = ht.merge_shards(tmp_path / "a.shards")
    assert merged.identical(whole)
    assert np.isnan(merged.angle[2]).all()
    assert np.isfinite(merged.model_angle[:2]).all()
    with pytest.raises(InputError, match="was started with pressure"):
        joint_map_shards(ROBOT, "II", tmp_path / "a.shards", **given | {"fill": 0.0})


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"pressure": [0, 1e5, 1e5]}, "pressure must increase"),
        ({"pressure": [-1e3, 1e5]}, "pressure must not be negative, but is -1 kPa"),
        ({"pressure": [math.nan]}, "pressure must be a list of finite numbers"),
        ({"pressure": [0.0]}, "pressure must end above 0"),
        ({"fill": -2e3}, "fill must not be negative, but is -2 kPa"),
        ({"couple": "much"}, "couple must be a list of finite numbers"),
        ({"joint": "III"}, "joint III is not a joint of the robot"),
    ],
)
def test_bad_input_is_told(change: dict[str, Any], sentence: str) -> None:
    arguments = {"joint": "II", "pressure": PRESSURE, "solve": by_model("II")} | change
    with pytest.raises(InputError) as caught:
        joint_map(ROBOT, arguments.pop("joint"), **arguments)
    assert sentence in str(caught.value)


# Finite elements themselves, on a small joint: what is tested is the way, not the numbers.


def small() -> ht.Robot:
    """HyperTuna whose joint II is 30 mm long, with one drive unit on each side."""
    document = ROBOT.document()
    body = {"segment_length_m": [0.03], "semi_major_m": [0.014], "semi_minor_m": [0.013]}
    document["joints"][1] |= {"drive_units": 1, "actuator": document["joints"][1]["actuator"] | body}
    document["joints"][1] |= {"bend_max_deg": 8.0, "amplitude_max_deg": 6.0}
    return parse(document, file="small.toml")


SMALL = MeshSize(0.8, largest=6.0, order=3, pieces=3.0)  # seconds instead of minutes


@pytest.mark.fe
def test_pressure_and_couple_have_one_potential() -> None:
    """Maxwell: what the sine of the angle gains by the pressure, the volume gains by the couple."""
    solve = joint_by_elements(small(), "II", FeOptions(mesh=SMALL))
    (p, dp), (t, dt) = (100e3, 4e3), (0.0, 0.004)
    found = {(i, k): solve(t + i * dt, [(p + m * dp, 20e3) for m in range(k + 1)]) for i in (0, 1) for k in (0, 1)}
    assert not any(point["fault"] for point in found.values())
    turns = [(math.sin(found[i, 1]["angle"]) - math.sin(found[i, 0]["angle"])) / dp for i in (0, 1)]
    swells = [(found[1, k]["volume"][0] - found[0, k]["volume"][0]) / dt for k in (0, 1)]
    assert np.mean(turns) == pytest.approx(np.mean(swells), rel=4e-3)


MAP = ("--fill", "60", "--moment", "-0.05:0.05:3", "--mesh", "small")


def map_command(folder: Path, pressure: str) -> list[str]:
    """Write the small robot and return the command that maps its joint II."""
    write_robot(small(), folder / "small.toml")
    return ["fe", "map", "--robot", str(folder / "small.toml"), "--joint", "II", "--pressure", pressure, *MAP]


@pytest.mark.fe
def test_the_command_maps_a_joint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    monkeypatch.setitem(MESHES, "small", SMALL)
    command = [*map_command(tmp_path, "60,250"), "--checkpoint", str(tmp_path / "keep")]
    code, output, _ = run(*command, "--json")
    told = json.loads(output)
    assert (code, told["status"], told["joint"]) == (0, "converged", "II")
    angle = np.array(told["elements"]["angle_deg"])
    assert angle[1, 0] == pytest.approx(0, abs=0.3)  # both sides have 60 kPa; the mesh is not symmetrical
    assert angle[0, 0] == pytest.approx(-angle[2, 0], abs=0.6)
    assert (np.diff(angle, axis=0) > 0).all()
    assert (np.diff(angle, axis=1) > 0).all()
    assert np.array(told["model"]["angle_deg"]).shape == (3, 2)
    assert (np.array(told["elements"]["length_mm"])[:, -1] < 30).all()
    # The journal knows all points: nothing is solved again.
    monkeypatch.setattr("hypertuna.fe.joint_map.fe_model", lambda *_: pytest.fail("solved again"))
    assert run(*command, "-o", str(tmp_path / "map.csv"))[0] == 0
    assert (
        (tmp_path / "map.csv").read_text().startswith("couple_n_m,pressure_kpa,pressure_right_kpa,angle_deg,moment_n_m")
    )
    code, output, _ = run(*command)
    assert code == 0
    assert f"differ by at most {told['moment_difference_percent']:.1f} % of" in output


@pytest.mark.fe
def test_the_command_of_an_array_job_makes_the_same_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    """The way alone: the fast model stands for the elements."""
    monkeypatch.setitem(MESHES, "small", SMALL)
    monkeypatch.setattr("hypertuna.fe.joint_map.joint_by_elements", lambda *_: by_model("II"))
    shards, merged = str(tmp_path / "map.shards"), str(tmp_path / "merged.nc")
    command = map_command(tmp_path, "60,120,250")
    assert [run(*command, "-o", shards, "--shard", f"{k}/2")[0] for k in (1, 2)] == [0, 0]
    assert run("shards", "merge", shards, "-o", merged)[0] == 0
    assert run(*command, "-o", str(tmp_path / "map.nc"))[0] == 0
    assert cf_issues(tmp_path / "map.nc", Path(merged)) == ""
    same_files(merged, str(tmp_path / "map.nc"))


@pytest.mark.fe
def test_elements_check_the_chosen_design_of_a_family(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    """In a joint so short, plain sections are off by 11 % of the bend and 6 % of the moment."""
    monkeypatch.setitem(MESHES, "small", SMALL)
    fish, bench = tmp_path / "small.toml", tmp_path / "bench.csv"
    write_robot(small(), fish)
    bench.write_text("joint,side,pressure_kpa,angle_deg,moment_n_m\nII,right,100,6.4,\nII,right,100,,0.042\n")
    command = ("joint", "family", str(bench), "--robot", str(fish), "--free", "stiffness_factor", "--members", "50")
    code, output, errors = run(*command, "--check", "--mesh", "small", "--json")
    assert code == 0, errors
    bend, moment = json.loads(output)["check"]["facts"]
    assert bend["elements"] == pytest.approx(bend["without_friction"], rel=0.15)
    assert moment["elements"] == pytest.approx(moment["without_friction"], rel=0.1)
