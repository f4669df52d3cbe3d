"""The option --design of `optimize`, `pareto` and `sweep`: files and tables that it makes, and what it refuses."""

import json
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.description.writer import write_robot
from optimization.test_design_variables import robot_named
from program import Run


def test_the_optimum_is_a_file_that_swims_at_the_printed_speed(run: Run, tmp_path: Path) -> None:
    robot = robot_named("hypertuna strip hinge")
    file, best = tmp_path / "fish.toml", tmp_path / "best.toml"
    write_robot(robot, str(file))
    options = ("--speed", "0.4", "--design", "hinge.stiffness=0.05:2", "--design", "fin.area=0.8:1.2")
    code, output, errors = run("optimize", "--robot", str(file), *options, "-o", str(best), "--json")
    assert (code, "error" in errors) == (0, False)
    told = json.loads(output)
    assert list(told["design"]) == ["hinge.stiffness_n_m_per_rad", "fin.area"]
    assert run("robot", "check", str(best))[0] == 0
    written = ht.load(best)
    assert written.hinge is not None
    assert written.hinge.stiffness == told["design"]["hinge.stiffness_n_m_per_rad"]
    assert written.source("hinge.stiffness_n_m_per_rad") == "best design found by hypertuna optimize"
    for key in ("links.lateral_area_m2", "water.strip.edge_height_m"):  # an estimate stays one
        assert written.source(key) == f"{robot.source(key)}; best design found by hypertuna optimize"
    code, output, _ = run("swim", "--robot", str(best), "--gait", "best", "--json")
    swum = json.loads(output)
    assert swum["speed_m_s"] == pytest.approx(told["speed_m_s"], rel=1e-10)
    assert told["robot_hash"] != robot.hash


def test_a_sweep_of_the_shell_has_the_values_as_columns(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "grid.csv"
    gait = ("--frequency", "2", "--amplitude", "16,25", "--phase", "0,40")
    design = ("--design", "links.length[7]=0.08:0.1:3", "--design", "fin.aspect_ratio=0.8,1")
    code, output, _ = run("sweep", "--robot", "hypertuna", *gait, *design, "-o", str(table))
    assert code == 0
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    assert head.startswith("links.length_m[7],fin.aspect_ratio,frequency_hz,")
    assert len(rows) == 6
    assert "aspect_ratio" in output
    for more in (
        ("--checkpoint", str(tmp_path / "j")),
        ("--plot", str(tmp_path / "grid.svg")),
        ("-o", str(tmp_path / "grid.shards")),
    ):
        code, _, errors = run("sweep", "--robot", "hypertuna", *gait, *design, *more)
        assert (code, "Traceback" in errors) == (2, False)
        assert "design" in errors
    assert "write one file, -o NAME.nc or -o NAME.csv" in errors


def test_columns_of_a_design_have_the_names_of_the_files_keys(run: Run, tmp_path: Path) -> None:
    file, table = tmp_path / "fish.toml", tmp_path / "table.csv"
    write_robot(robot_named("hypertuna strip hinge"), str(file))
    gait = ("--frequency", "2", "--amplitude", "16,25", "--phase", "0,40")
    sweep = ("sweep", *gait, "--design", "hinge.stiffness=0.3,0.6")
    front = ("pareto", "--population", "4", "--generations", "1", "--no-polish", "--design", "hinge.stiffness=0.3:0.6")
    for command in (sweep, front):
        assert run(*command, "--robot", str(file), "-o", str(table))[0] == 0
        assert "hinge.stiffness_n_m_per_rad" in table.read_text(encoding="utf-8").splitlines()[0].split(",")


def test_the_robots_of_a_design_count_among_the_results(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hypertuna.cli.shards.MAX_TEXT", 3)
    gaits = ("--frequency", "1,2", "--amplitude", "16,25", "--phase", "0,40")
    errors = run("sweep", "--robot", "hypertuna", *gaits, "--design", "fin.area=0.9,1.1", "--json")[2]
    assert "--json must hold at most 3 results as text, but is 4" in errors


@pytest.mark.parametrize("tail", ["passive", "flexible"])
def test_a_sweep_of_the_shell_has_the_bends_of_a_swim(run: Run, tmp_path: Path, tail: str) -> None:
    """Of every hinge, in JSON and CSV."""
    file, table = str(tmp_path / "fish.toml"), tmp_path / "table.csv"
    assert run("robot", "new", file, "--tail", tail)[0] == 0
    command = ("--robot", file, "--gait", "cruise")
    swum = json.loads(run("swim", *command, "--json")[1])
    assert "bend" not in run("sweep", *command, "--frequency", "1,2")[1]  # the terminal shows the speed
    code, output, _ = run("sweep", *command, "-o", str(table), "--json")
    (row,) = json.loads(output)["gaits"]
    names = [name for name in row if name.startswith(("stiffness_ratio", "bend_", "damping_power"))]
    assert (code, len(names)) == (0, 5 if tail == "passive" else 15)
    assert [row[name] for name in names] == pytest.approx([swum[name] for name in names], rel=1e-12)
    assert {*names} <= {*table.read_text(encoding="utf-8").splitlines()[0].split(",")}


@pytest.mark.parametrize("command", [("optimize", "--maximize", "speed"), ("pareto",)], ids=lambda command: command[0])
def test_a_wrong_limit_names_its_option_and_unit(run: Run, command: tuple[str, ...]) -> None:
    for option, unit in (("--max-bend", "deg"), ("--max-joint-rate", "deg/s"), ("--max-mass", "kg")):
        errors = run(*command, option, "-1")[2]
        assert errors == f"error: {option} must be greater than 0, but is -1: give it in {unit}.\n"
    assert run(*command, "--max-bend", "5")[2].startswith("error: --max-bend needs a passive hinge, which the robot l")


REFUSED = {
    "hinge.stiffnes=1:2": "did you mean hinge.stiffness?",
    "links.lenght[7]=1:2": "did you mean links.length[7]?",
    "hinge.stiffness=a:2": "must be a number",
    "hinge.stiffness=1": "must be LOW:HIGH",
    "hinge.stiffness=2:1": "must have a lower value below a higher one",
    "hinge.stiffness=1:1": "must have a lower value below a higher one",
    "hinge.stiffness=1:nan": "finite",
    "hinge.stiffness=0.1:1e9": "must stay within what is usual, 0.0001 to 1000 N m/rad",
    "hinge.link=1:2": "must be a whole number",
    "joints.I.drive_units=1:2": "must be a whole number",
    "name=1:2": "must be a number to design",
    "links.mass=1:2": "choose one with its index: links.mass[0]",
    "links.com[7]=0.01:0.2": "must keep the robot's file valid (at 0.2",
    "battery.capacity=1:2": "its derivative is zero everywhere",
    "water.lumped.drag[7]=10:20": "the robot swims in strip water",
    "body.length=0.5:0.6": "must keep the robot's file valid",
    "fin.size=0.5:1": "must be a size of the caudal fin",
    "fin.area=0:1": "must be greater than 0",
    "fin.chord=0.5:5": "the fin must fit its link",
    "fin.area=0.001:1": "the fin must leave its link an area",
    "joints.I.amplitude_max=10:20": "its derivative is zero everywhere",
    "joints.I.share[0]=0.1:0.2": "must add up to 1",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_cannot_be_varied_is_refused_in_a_sentence(run: Run, tmp_path: Path, text: str) -> None:
    file = tmp_path / "fish.toml"
    write_robot(robot_named("hypertuna strip hinge"), str(file))
    for command in (("optimize", "--maximize", "speed"), ("pareto",)):
        code, _, errors = run(*command, "--robot", str(file), "--design", text)
        assert (code, "Traceback" in errors) == (2, False)
        assert REFUSED[text] in " ".join(errors.split())


def test_a_key_given_twice_is_refused(run: Run) -> None:
    for pair in (("fin.area=0.5:1", "fin.area=0.5:2"), ("links.mass[0]=2:3", "links.mass_kg[0]=2:3")):
        options = [word for text in pair for word in ("--design", text)]
        code, _, errors = run("optimize", "--maximize", "speed", *options)
        assert (code, "must be given once" in errors) == (2, True)
    code, _, errors = run("optimize", "--maximize", "speed", "--design", "fin.area=0.5:1", "--design", "fin.span=0.5:1")
    assert (code, "fin.span and fin.chord, or fin.area and fin.aspect_ratio" in errors) == (2, True)
