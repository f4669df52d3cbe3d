"""The commands `hypertuna robot ...` and the drawing."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from hypertuna.cli.main import app
from hypertuna.cli.robot import robot_app
from hypertuna.description.plots import midline, plot_robot
from hypertuna.description.reference import json_schema
from hypertuna.description.robot import load, parse, robots
from hypertuna.description.writer import write_robot
from hypertuna.errors import InputError
from hypertuna.figures import save


def run(*arguments: str) -> Result:
    """Run `hypertuna robot` with arguments, on a terminal wide enough for every line."""
    return CliRunner(env={"COLUMNS": "400"}).invoke(robot_app, arguments)


def test_schema_prints_the_schema() -> None:
    assert json.loads(run("schema").stdout) == json_schema()


@pytest.mark.parametrize("name", robots())
def test_check_tells_what_is_estimated(name: str) -> None:
    robot = load(name)
    told = json.loads(run("check", name, "--json").stdout)
    assert told["valid"]
    assert told["hash"] == robot.hash
    assert told["estimates"] == [entry.key for entry in robot.entries() if entry.estimate]
    text = run("check", name).stdout
    assert text.startswith(f"robots/{name}.toml: valid; {len(robot.links.name)} links, ")
    line = " ".join(text.split()).partition("estimated: ")[2].partition(" without a source: ")[0]
    shown = re.split(", |; |all of ", line)
    for entry in (entry for entry in robot.entries() if entry.estimate and entry.numeric):
        plain = re.sub(r"\[\d+\]", "", entry.key)
        assert entry.key in shown or any(f"{plain}.".startswith(f"{part}.") for part in shown), entry.key


def test_check_of_a_bad_file(tmp_path: Path) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text("format = 3")
    for arguments in (["check", str(bad)], ["check", str(bad), "--json"]):
        result = run(*arguments)
        assert isinstance(result.exception, InputError)
    told = json.loads(result.stdout)
    assert (told["valid"], told["file"], told["error"]) == (False, str(bad), str(result.exception))


@pytest.mark.parametrize("name", robots())
def test_show_gives_every_value_with_unit_and_source(name: str) -> None:
    robot = load(name)
    told = json.loads(run("show", name, "--json").stdout)
    assert [value["key"] for value in told["values"]] == [entry.key for entry in robot.entries()]
    lines = {line.split()[0]: line for line in run("show", name).stdout.splitlines() if line.strip()}
    for entry in robot.entries():
        assert entry.unit in lines[entry.key]
        assert ("~" in lines[entry.key]) == entry.estimate


def test_midline_bends_by_the_whole_angle() -> None:
    fish = load("hypertuna")
    angles = np.array([0.2, -0.5])
    steps = np.diff(midline(fish, angles))
    theta = np.angle(steps)
    assert np.abs(steps) == pytest.approx(fish.links.length)
    assert theta == pytest.approx([0, 0, 0.2 / 3, 0.4 / 3, 0.2, 0.2 - 0.5 / 3, 0.2 - 1 / 3, -0.3])


@pytest.mark.parametrize("name", robots())
def test_the_drawing_is_to_scale(name: str, tmp_path: Path) -> None:
    robot = load(name)
    figure = plot_robot(robot)
    side, top = figure.axes
    gap = 0.002 * robot.body.length
    areas = [(box.get_width() + gap) * box.get_height() for box in side.patches]
    assert areas == pytest.approx(robot.links.lateral_area)
    figure.canvas.draw()
    scales = [axes.transData.transform([(0, 0), (1, 1)]) for axes in (side, top)]
    (dx, dy), (tx, ty) = (scale[1] - scale[0] for scale in scales)
    assert (dy, tx, ty) == pytest.approx((dx, dx, dx))
    for kind, start in (("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")):
        save(figure, tmp_path / f"fish.{kind}")
        assert (tmp_path / f"fish.{kind}").read_bytes().startswith(start)


def test_a_robot_without_gaits_is_drawn_straight() -> None:
    document = load("rexeel").document()
    del document["gaits"], document["sources"]["gaits"]
    top = plot_robot(parse(document)).axes[1]
    assert all(math.isclose(y, 0) for line in top.lines for y in line.get_ydata())


@pytest.mark.parametrize("path", ["fish.jpg", "fish", "missing/fish.svg"])
def test_a_drawing_that_cannot_be_written_leaves_nothing(path: str, tmp_path: Path) -> None:
    result = run("show", "hypertuna", "--plot", str(tmp_path / path))
    assert isinstance(result.exception, InputError)
    assert str(result.exception).startswith("--plot ")
    assert list(tmp_path.iterdir()) == []


def test_new_writes_a_robot_that_swims_and_never_over_another(tmp_path: Path) -> None:
    file = tmp_path / "first.toml"
    told = run("new", str(file), "--links", "4", "--length", "0.4", "--mass", "1.2", "--joints", "front,rear").stdout
    assert told.startswith(f"written: {file}; 4 links, 2 joint groups")
    robot = load(file)
    assert ([group.name for group in robot.joints], robot.body.mass) == (["front", "rear"], 1.2)
    assert CliRunner().invoke(app, ["swim", "--robot", str(file)]).exit_code == 0  # its only gait
    before = file.read_text()
    assert isinstance(run("new", str(file)).exception, InputError)
    assert file.read_text() == before
    assert run("new", str(file), "--force", "--actuation", "servo").exit_code == 0
    assert load(file).joints[0].servo is not None


def test_check_tells_unlikely_values_and_all_mistakes(tmp_path: Path) -> None:
    file = tmp_path / "first.toml"
    run("new", str(file))
    file.write_text(file.read_text().replace("frequency_hz = 2.0", "frequency_hz = 200.0"))
    assert run("check", str(file)).stdout.startswith(f"{file}: 1 value is unlikely, but the file is valid; 3 links")
    assert "unlikely: gaits.cruise.frequency_hz has 200 Hz; usual are 0.02 to 20" in run("check", str(file)).stdout
    (warning,) = json.loads(run("check", str(file), "--json").stdout)["warnings"]
    assert warning.startswith("gaits.cruise.frequency_hz has 200 Hz")
    file.write_text(file.read_text().replace("[0.15,", "[-0.15,").replace("\ndrag_normal", "\ndrag_norma"))
    told = json.loads(run("check", str(file), "--json").stdout)
    assert [error["key"] for error in told["errors"]] == ["water.strip.drag_norma", "links.length_m[0]"]


def test_keys_are_listed_by_parts_of_their_names() -> None:
    told = run("keys", "line.bore").stdout.splitlines()
    assert told[0] == "joints.line.bore_m [m]: inner diameter of the line"
    assert told[1] == "  number > 0; default: required; typical: 0.0045"
    assert len(told) == 3
    assert next(key["key"] for key in json.loads(run("keys", "pump.", "--json").stdout)["keys"]) == "pump.bore_m"
    assert str(run("keys", "bors").exception).startswith("PART is in no key, but is 'bors': ")


@pytest.mark.parametrize(
    ("numbers", "key"),
    [
        ({"stiffness_n_m_per_rad": 1e6}, "stiffness_n_m_per_rad"),
        ({"damping_n_m_s_per_rad": 9.0}, "damping_n_m_s_per_rad"),
        ({"cubic_n_m_per_rad3": 1e5}, "cubic_n_m_per_rad3"),
        ({"stop_deg": 5.0, "stop_stiffness_n_m_per_rad": 1e5}, "stop_stiffness_n_m_per_rad"),
        ({}, ""),
    ],
)
def test_check_says_which_spring_no_settled_beat_follows(numbers, key, run, tmp_path) -> None:
    hinge = {"link": 7, "stiffness_n_m_per_rad": 0.5, "damping_n_m_s_per_rad": 1e-3} | numbers
    document = load("hypertuna").document()
    write_robot(parse(document | {"hinge": hinge, "sources": {}}), file := tmp_path / "fish.toml")
    code, _, errors = run("robot", "check", str(file))
    assert code == 0
    if key:
        assert f"note: settled beats refuse hypertuna: hinge.{key} must let 1024 steps of a beat at " in errors
        code, _, refused = run("swim", "--robot", str(file), "--gait", "unoptimised-0.3")
        assert code == 2
        assert f"hinge.{key} must let 1024 steps" in refused
    else:
        assert errors == ""
