"""Notes: what a command takes as it is, in a sentence on the error output and in JSON, without another exit code."""

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import parse
from hypertuna.description.writer import write_robot
from optimization.test_design_variables import robot_named
from program import Run

RIGID = "the hinge of link 2 stays rigid here: `swim` bends it."
GAIT = ("--frequency", "2", "--amplitude", "10,20", "--phase", "0,40")


@pytest.fixture
def hinged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A file of a robot with a passive hinge, in the working folder."""
    document = tomllib.loads(first_robot("hinged", actuation="servo"))
    document["hinge"] = {"link": 2, "stiffness_n_m_per_rad": 0.2}
    monkeypatch.chdir(tmp_path)
    write_robot(parse(document), "hinged.toml")
    return "hinged.toml"


def test_an_exported_model_says_that_a_hinge_stays_rigid(run: Run, hinged: str) -> None:
    command = ("export", "sdf", "-o", "fish.sdf")
    code, _, errors = run(*command, "--robot", hinged)
    assert (code, errors.count(f"note: {RIGID}\n")) == (0, 1)
    assert json.loads(run(*command, "--robot", hinged, "--json")[1])["notes"] == [RIGID]
    spring = "stiffness_n_m_per_rad = 0.2\n"
    Path(hinged).write_text(Path(hinged).read_text().replace(spring, f"{spring}rest_deg = 5.0\n"))
    straight = RIGID.replace("rigid", "rigid and straight")
    assert json.loads(run(*command, "--robot", hinged, "--json")[1])["notes"] == [straight]


def test_a_model_for_mujoco_has_the_hinge_and_says_nothing(run: Run, hinged: str) -> None:
    code, _, errors = run("export", "mjcf", "-o", "fish.xml", "--robot", hinged)
    assert (code, errors) == (0, "")
    assert '<joint name="hinge-' in Path("fish.xml").read_text()


@pytest.mark.parametrize(
    "command",
    [
        ("swim", *GAIT),
        ("sweep", *GAIT),
        ("turn", *GAIT, "--bias", "5,5"),
        ("optimize", "--maximize", "speed", "--method", "pso", "--particles", "4", "--iterations", "2"),
        ("pareto", "--generations", "1", "--population", "4"),
    ],
    ids=lambda command: command[0],
)
def test_what_swims_settled_beats_bends_a_hinge(run: Run, hinged: str, command: tuple[str, ...]) -> None:
    """Without a word, and with another result than that of a rigid one."""
    code, output, errors = run(*command, "--robot", hinged, "--json")
    assert (code, errors, "notes" in json.loads(output)) == (0, "", False)
    Path("rigid.toml").write_text(Path(hinged).read_text().partition("[hinge]")[0])
    rigid = json.loads(run(*command, "--robot", "rigid.toml", "--json")[1])
    same = {"hypertuna_version", "isa", "robot", "robot_file", "robot_hash"}
    assert {name: value for name, value in json.loads(output).items() if name not in same} != {
        name: value for name, value in rigid.items() if name not in same
    }


def test_recordings_are_swum_with_a_rigid_hinge(run: Run, hinged: str) -> None:
    Path("runs.csv").write_text(
        "frequency_hz,amplitude_J1_deg,amplitude_J2_deg,phase_J1_deg,phase_J2_deg,speed_m_s\n"
        "2,10,20,0,40,0.15\n1.5,10,20,0,40,0.11\n1,10,20,0,40,0.07\n2,15,30,0,40,0.2\n"
    )
    assert "notes" not in json.loads(run("identify", "runs.csv", "--robot", hinged, "--json")[1])
    where = RIGID.replace("link 2 stays rigid here", "link 7 stays rigid in tracked recordings")
    write_robot(robot_named("hypertuna strip hinge"), "tuna.toml")
    manifest = str(Path(__file__).parents[2] / "examples" / "tank" / "tank.toml")
    assert run("identify", manifest, "--robot", "tuna.toml", "--free", "nothing")[2].startswith(f"note: {where}\n")
    Path("angles.csv").write_text("time_s,J1,J2\n" + "".join(f"{0.05 * k},{k % 4},{k % 3}\n" for k in range(40)))
    replayed = ("replay", "angles.csv", "--columns", "J1,J2", "--unit", "deg", "--robot", hinged)
    assert f"note: {RIGID}\n" in run(*replayed)[2]
    assert RIGID not in run("studio", hinged, "-o", "page.html")[2]  # its page bends the hinge


def test_the_hinge_stays_rigid_while_the_head_is_held_or_towed(run: Run, hinged: str) -> None:
    Path("thrusts.csv").write_text(
        "frequency_hz,amplitude_J1_deg,amplitude_J2_deg,phase_J1_deg,phase_J2_deg,thrust_n\n2,10,20,0,40,0.15\n"
    )
    Path("tows.csv").write_text("u_m_s,drag_n\n0.1,0.01\n0.2,0.04\n")
    where = RIGID.replace("here", "in tows and held thrusts")
    assert f"note: {where}\n" in run("identify", "thrusts.csv", "tows.csv", "--robot", hinged, "--validate", "0")[2]
    spring = ("identify", "thrusts.csv", "tows.csv", "--robot", hinged, "--free", "hinge.stiffness")
    code, _, errors = run(*spring)
    assert code == 2
    rule = "error: free hinge.stiffness needs trials in which the spring bends the hinge"
    assert errors.splitlines()[-1].startswith(rule)
    asked = ("design", "ask", "--state", "tank.jsonl", "--robot", hinged, "--prior", "hinge.stiffness=1.5")
    assert "note" not in run(*asked)[2]
    tow = ("design", "ask", "--state", "tow.jsonl", "--robot", hinged, "--prior", "water.drag_tangential=3", "--tow")
    code, output, errors = run(*tow, "--runs", "6", "--json")
    assert (f"note: {where.replace(' and held thrusts', '')}\n" in errors) == ("tow_m_s" in output)


def test_the_twin_bends_the_hinge_and_says_nothing(run: Run, hinged: str) -> None:
    for command in ("twin", "range"):
        code, output, errors = run(command, "--robot", hinged, "--gait", "cruise", "--duration", "2", "--json")
        assert code in (0, 1)
        assert (errors, "notes" in json.loads(output)) == ("", False)


def test_a_hinge_is_of_a_link_that_the_robot_has(run: Run, hinged: str) -> None:
    Path(hinged).write_text(Path(hinged).read_text().replace("link = 2", "link = 3"))
    assert run("robot", "check", hinged)[2] == (
        "error: hinged.toml: hinge.link must be a link from 1 to 2, but is 3: link 0 is the head.\n"
    )


def test_several_hinges_are_listed_from_nose_to_tail(run: Run, hinged: str) -> None:
    """They swim, one by one in the record, and the twin bends them."""
    rigid = Path(hinged).read_text().partition("[hinge]")[0]
    one, two = (f"\n[[hinges]]\nlink = {link}\nstiffness_n_m_per_rad = 0.5\n" for link in (1, 2))

    def checked(tables: str) -> str:
        Path("two.toml").write_text(rigid + tables)
        return run("robot", "check", "two.toml")[2]

    assert "hinges[1].link must be behind link 2, and at most 2, but is 1" in checked(two + one)
    assert "hinges must not stand beside [hinge], but is given" in checked(one + two.replace("[[hinges]]", "[hinge]"))
    assert "no twin" not in checked(one + two)
    assert run("twin", "--robot", "two.toml", *GAIT, "--duration", "1", "--json")[::2] == (0, "")
    code, output, errors = run("swim", "--robot", "two.toml", *GAIT, "--json")
    record = json.loads(output)
    assert (code, errors) == (0, "")
    assert 0 < record["bend_amplitude_1_deg"] != record["bend_amplitude_2_deg"] > 0


@pytest.mark.parametrize(
    ("options", "sentences"),
    [
        (("--frequency", "600"), ["--frequency 600 Hz is outside gait_bounds.frequency_hz of hypertuna, 0.1 to 6 Hz."]),
        (
            ("--amplitude", "10,80"),
            ["--amplitude 80 deg of joint group II is outside gait_bounds.amplitude_deg of hypertuna, 0 to 25 deg."],
        ),
        (
            ("--amplitude", "0.2,0.3"),
            ["amplitudes are in degrees, and these are small; multiply radians by 57.3."],
        ),
        (("--frequency", "6", "--amplitude", "16,25"), []),
    ],
)
def test_gaits_beyond_the_file_s_own_bounds_are_noted(run: Run, options: tuple[str, ...], sentences: list[str]) -> None:
    code, output, errors = run("swim", "--gait", "unoptimised-max", *options, "--json")
    assert code in (0, 1)
    assert errors == "".join(f"note: {sentence}\n" for sentence in sentences)
    told: dict[str, Any] = json.loads(output)
    assert told.get("notes", []) == sentences


def test_a_grid_beyond_the_bounds_has_one_note(run: Run) -> None:
    errors = run("sweep", "--gait", "unoptimised-max", "--frequency", "1:600:3")[2]
    assert errors.count("note: ") == 1
    assert "--frequency 600 Hz" in errors


@pytest.mark.parametrize(
    ("links", "groups", "hinged", "key", "told"),
    [(3, 2, [1], "hinge", "link 1"), (13, 5, [11, 12], "hinges[0]", "links 11, 12")],
)
def test_oil_has_no_rotor_that_hinges_could_turn_against(
    run: Run, tmp_path: Path, links: int, groups: int, hinged: list[int], key: str, told: str
) -> None:
    """The robot swims and has a studio, but no twin, and its check says so."""
    names = [f"J{j}" for j in range(groups)]
    document = tomllib.loads(first_robot("oily", actuation="hydraulic", links=links, joints=names))
    assert hinged in [group["links"] for group in document["joints"]]
    hinges = [{"link": link, "stiffness_n_m_per_rad": 0.3} for link in hinged]
    document |= {"hinges": hinges} if len(hinges) > 1 else {"hinge": hinges[0]}
    file = str(tmp_path / "oily.toml")
    write_robot(parse(document), file)
    rule = f"{key}.link must leave the joint group that oil bends there a link without a hinge, in the twin, "
    code, _, errors = run("twin", "--robot", file)
    assert (code, f"{rule}but is {hinged[0]}: " in errors) == (2, True)
    assert run("studio", file, "-o", str(tmp_path / "page.html"))[0] == 0
    assert f"has no twin: oil bends its {told} alone" in run("robot", "check", file)[2]


def test_a_robot_with_a_hinge_flies_a_mission(run: Run, tmp_path: Path) -> None:
    """Its log has the angles of the joint groups alone."""
    robot, mission = str(tmp_path / "sea.toml"), str(tmp_path / "square.toml")
    assert run("robot", "new", robot, "--actuation", "servo", "--sea")[0] == 0
    with Path(robot).open("a") as file:
        file.write("\n[hinge]\nlink = 2\nstiffness_n_m_per_rad = 1.0\n")
    assert run("mission", "new", mission, "--robot", robot)[0] == 0
    code, output, errors = run("mission", mission, "--robot", robot, "--json")
    assert (code, json.loads(output)["status"]) == (0, "done"), errors
