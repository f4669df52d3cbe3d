"""A mission for a robot: `mission new` writes one that it can swim, `mission` tells first what it cannot."""

import json
import math
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.control.guidance import curvature, error_of_fixes, gait_table
from hypertuna.control.mission import Mission, Waypoint
from hypertuna.mission.checks import OVERSHOOT, check_fit, course_time, warnings_of
from hypertuna.mission.file import read_mission
from hypertuna.mission.flight import fly, outcome
from hypertuna.mission.new import new_mission, spelled, usual_radius
from program import Run

SIZES: dict[str, Any] = {
    "hydraulic": {"links": 3, "length": 0.3, "actuation": "hydraulic"},
    "servo": {"links": 4, "length": 0.4, "actuation": "servo"},
    "slow": {"links": 2, "length": 0.1, "actuation": "servo", "nose": "blunt"},
    "large": {"links": 4, "length": 1.0, "actuation": "servo"},
}


@pytest.fixture(scope="module")
def fish(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], ht.Robot]:
    folder = tmp_path_factory.mktemp("fish")

    def load(name: str) -> ht.Robot:
        if name == "hypertuna":
            return ht.load(name)
        path = folder / f"{name}.toml"
        path.write_text(first_robot(name, sea=True, **SIZES[name]))
        return ht.load(path)

    return load


@pytest.mark.parametrize("name", ["hypertuna", *SIZES])
def test_a_new_mission_is_scaled_to_the_robot(name: str, fish: Callable[[str], ht.Robot], tmp_path: Path) -> None:
    """Speed, turns, fixes and depths of the robot; nothing that the ground or the board refuses, and no doubt."""
    robot = fish(name)
    (tmp_path / "new.toml").write_text(new_mission(robot, "new"))
    file = read_mission(tmp_path / "new.toml")
    mission, table = file.mission, gait_table(robot)
    assert file.robot == spelled(robot)
    assert ht.load(file.robot).hash == robot.hash
    check_fit(robot, mission)
    assert [sentence[:16] for sentence in warnings_of(robot, mission)] == ["the fastest gait"] * (name == "slow")
    assert robot.guidance is not None
    side = max(point.y for point in mission.waypoints)
    assert side >= 6 / curvature(robot, table, robot.guidance.bias_max)
    for point in mission.waypoints:
        assert 0.8 * table.speed[-1] < point.speed < 0.9 * table.speed[-1]
        assert point.radius > error_of_fixes(robot)
        assert 0 < point.depth <= mission.depth_max - OVERSHOOT
    assert robot.firmware is not None
    assert mission.depth_max <= robot.firmware.depth_max


@pytest.mark.parametrize(("error", "radius"), [(1.0, 3.0), (2.0, 3.0), (2.5, 3.8), (4.0, 6.0)])
def test_waypoints_are_half_as_large_again_as_the_error_of_fixes(
    error: float, radius: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rounded up to a tenth of a meter, and 3 m at least."""
    monkeypatch.setattr("hypertuna.mission.new.error_of_fixes", lambda robot: error)
    assert usual_radius(ht.load("hypertuna")) == radius


@pytest.mark.parametrize("name", ["hydraulic", "servo"])
def test_a_new_mission_is_swum_to_its_end(name: str, fish: Callable[[str], ht.Robot], tmp_path: Path) -> None:
    robot = fish(name)
    (tmp_path / "new.toml").write_text(new_mission(robot, "new"))
    flight = fly(tmp_path / "new.toml", robot, seed=1)
    assert flight.status == "done"
    assert [(row["waypoint"], row["outcome"]) for row in outcome(flight).waypoints] == [
        (number, "reached") for number in (1, 2, 3, 4)
    ]


def test_a_shallow_hull_has_a_shallow_mission(fish: Callable[[str], ht.Robot], tmp_path: Path) -> None:
    robot = fish("servo")
    assert robot.firmware is not None
    shallow = robot.model_copy(update={"firmware": robot.firmware.model_copy(update={"depth_max": 0.8})})
    (tmp_path / "new.toml").write_text(new_mission(shallow, "new"))
    mission = read_mission(tmp_path / "new.toml").mission
    assert mission.depth_max == 0.8
    assert {point.depth for point in mission.waypoints} == {0.5}
    with pytest.raises(ht.InputError, match=r"limits.depth_m must be at most 0.8 m, the limit of the robot's hull"):
        check_fit(shallow, replace(mission, depth_max=0.9))


def test_the_time_of_a_course_counts_the_current() -> None:
    """By hand: 60 m at 0.4 m/s against 0.1 m/s are 200 s, back with it 120 s, across it 60 / sqrt(0.15) = 154.9 s."""

    def there(x: float, y: float, east: float) -> float:
        current = (east, 0.0)
        mission = Mission((Waypoint(x, y, 0.0, 0.4, 3.0),), current=current, current_bottom=current, stay=True)
        return course_time(mission, math.inf)

    assert there(60, 0, -0.1) == pytest.approx(200)
    assert there(60, 0, 0.1) == pytest.approx(120)
    assert there(0, 60, 0.1) == pytest.approx(60 / math.sqrt(0.15))
    assert there(0, 0, 0.1) == 0
    deep = Mission((Waypoint(60.0, 0.0, 5.0, 0.4, 3.0),), bottom=10.0, current=(-0.2, 0.0), stay=True)
    assert course_time(deep, 0.35) == pytest.approx(60 / 0.25)  # half of the current, half way down


def test_doubts_name_speed_time_and_charge(fish: Callable[[str], ht.Robot]) -> None:
    robot, box = fish("hypertuna"), read_mission("box").mission
    assert warnings_of(robot, box) == []
    (hasty,) = warnings_of(robot, replace(box, home_speed=0.8))
    assert hasty == f"the mission commands 0.8 m/s, but the fastest gait reaches {gait_table(robot).speed[-1]:.3g} m/s"
    (late,) = warnings_of(robot, replace(box, duration=500.0))
    assert late.startswith("the course takes 267 s, and waits for fixes often double that; limits.duration_s is 500 s")
    (flat,) = warnings_of(robot, replace(box, battery=0.201))
    assert "the course takes 267 s, but the charge above the reserve lasts" in flat
    (empty,) = warnings_of(robot, replace(box, battery=0.1))
    assert empty == "the battery starts at its reserve, limits.battery: the pilot turns home at once"


# --- the commands


@pytest.fixture
def run(run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    """Run `hypertuna` in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return run


def test_a_slow_robot_is_told_before_the_flight(run: Run, tmp_path: Path) -> None:
    Path("slow.toml").write_text(first_robot("slow", sea=True, **SIZES["slow"]))
    code, output, errors = run("mission", "box", "--robot", "slow.toml", "--duration", "1", "--json")
    assert code == 1
    lines = [line for line in errors.splitlines() if line.startswith("note: ")]
    assert len(lines) == 4
    assert "below 0.1 m/s the pilot cannot tell whether a current sweeps the robot away" in lines[1]
    assert lines[0].startswith("note: the mission commands 0.3 m/s, but the fastest gait reaches 0.0")
    assert "limits.duration_s is 900 s, so the pilot may turn home before the last waypoint" in lines[2]
    assert lines[3] == (
        "note: `hypertuna mission new FILE.toml --robot slow.toml` writes a mission that this robot can swim"
    )
    assert [row["waypoint"] for row in json.loads(output)["waypoints"]] == [1, 2, 3, 4]
    code, output, errors = run("mission", "new", "own.toml", "--robot", "slow.toml")
    assert (code, errors) == (0, "")
    assert output.splitlines() == [
        "written: own.toml, a square of 10 m for slow",
        "next:",
        "  hypertuna mission own.toml",
    ]
    assert run("mission", "own.toml", "--duration", "1")[2].count("note: ") == 1  # its speed
    code, _, errors = run("mission", "new", "own.toml", "--robot", "slow.toml")
    assert (code, errors) == (2, "error: own.toml exists already: give another name, or replace it with --force.\n")


def test_a_robot_without_a_pilot_has_no_mission(run: Run) -> None:
    code, _, errors = run("mission", "new", "own.toml", "--robot", "rexeel")
    assert code == 2
    assert errors.startswith("error: robots/rexeel.toml: ")
    assert not Path("own.toml").exists()


def test_a_file_whose_name_no_mission_can_have_is_not_written(run: Run) -> None:
    code, output, errors = run("mission", "new", "two\nlines.toml")
    rule = "name must be one line without control characters, but is 'two\\nlines': give the name of the mission."
    assert (code, output, errors, os.listdir()) == (2, "", f"error: {rule}\n", [])


def test_a_file_that_is_written_is_read_whichever_case_its_ending_has(run: Run) -> None:
    assert run("mission", "new", "OWN.TOML")[0] == 0
    assert read_mission("OWN.TOML").name == "OWN"
    Path("FISH.TOML").write_text(first_robot("fish"))
    assert ht.load("FISH.TOML").name == "fish"
