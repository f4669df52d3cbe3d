"""A body that the studio changes is that of the changed file: the image's numbers, its swims, and the file itself.

The page's own code makes the changed images and files here, in Node.js.
"""

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from host_library import ROBOTS, InNode
from host_library import Robot as InHost
from hypertuna.actuation.new import first_robot
from hypertuna.arrays import Array
from hypertuna.cli.main import app
from hypertuna.description.robot import parse
from hypertuna.mission.image import robot_image
from hypertuna.simulation.image_body import FIXED_COLUMNS, _knobs, with_factors
from hypertuna.simulation.image_source import TOKEN, Source, checked_places, source_of
from hypertuna.simulation.image_text import body_text, numbers_of_text
from hypertuna.swimming.gait import Gait
from image_file import columns_of, text_of
from studio_code import Page

TOP = Path(__file__).parents[2]
SAME = 1e-12  # relative
HINGE = {"link": 7, "stiffness_n_m_per_rad": 1.5, "damping_n_m_s_per_rad": 0.001}


def bodies(image: bytes, seed: int) -> list[dict[str, float]]:
    """Draw factors of bodies: one knob, some, all, and the ends of the ranges."""
    chance = np.random.default_rng(seed)
    knobs = text_of(image)["body"]["knobs"]

    def factor(knob: dict[str, Any]) -> float:
        return (
            float(chance.choice(knob["steps"])) if "steps" in knob else round(float(chance.uniform(*knob["range"])), 4)
        )

    drawn = [{knob["name"]: factor(knob) for knob in knobs if chance.random() < part} for part in (0.1, 0.3, 0.6, 1.0)]
    return [one for one in drawn if one] + [{knob["name"]: knob["range"][end] for knob in knobs} for end in (0, 1)]


def different(ours: dict[str, Array], theirs: dict[str, Array]) -> list[str]:
    """Name the columns that differ, without those of what is on board."""
    assert ours.keys() == theirs.keys()
    columns = [name for name in ours if not name.startswith(FIXED_COLUMNS)]
    return [name for name in columns if not np.allclose(ours[name], theirs[name], rtol=SAME, atol=0.0, equal_nan=True)]


GAIT = ("frequency", "amplitude", "phase", "bias")


@pytest.mark.parametrize("name", ROBOTS)
def test_a_changed_body_is_that_of_the_changed_file(page: Page, core: InNode, name: str, tmp_path: Path) -> None:
    """Several knobs at once, to the ends of their ranges: numbers, text, swims, and comments of the file."""
    robot = ht.load(name)
    image = robot_image(robot)
    settled = 0
    for k, factors in enumerate(bodies(image, seed=ROBOTS.index(name))):
        changed, toml, body = page.changed(image, factors)
        file = tmp_path / f"changed-{k}.toml"
        file.write_text(toml)
        exported = ht.load(file)
        assert exported.hash != robot.hash
        ours = columns_of(robot_image(exported))
        assert different(ours, columns_of(changed)) == []
        assert dict(numbers_of_text(body)) == pytest.approx(dict(numbers_of_text(body_text(exported))), rel=SAME)
        swimmer = InHost.read(changed, core)
        assert isinstance(swimmer, InHost)
        for water in text_of(image)["models"]:
            here = exported.using(**water)
            gait = Gait(**{key: getattr(next(iter(robot.gaits.values())), key) for key in GAIT})
            mine, yours = ht.swim(here, gait), swimmer.swim(text_of(image)["models"].index(water), [gait])
            if mine.settled:
                settled += 1
                assert yours["speed"][0] == pytest.approx(mine.speed, rel=1e-10)
                assert yours["cost_of_transport"][0] == pytest.approx(mine.cost_of_transport, rel=1e-10)
    assert settled > 0


def test_the_file_keeps_its_comments_and_marks_what_changed(page: Page) -> None:
    robot = ht.load("hypertuna")
    image = robot_image(robot)
    _, toml, _ = page.changed(image, {"length-7": 1.2, "length-1": 0.9, "mass-0": 1.1})
    before, after = source_of(robot).text.splitlines(), toml.splitlines()
    assert len(before) == len(after)
    lines = [(old, new) for old, new in zip(before, after, strict=True) if old != new]
    assert [new for _, new in lines] == [
        "length_m = 0.5358  # changed from 0.520",
        "mass_kg = 3.5209  # changed from 3.3",
        "length_m        = [0.281,    0.018,    0.020,    0.020,    0.050,    0.020,    0.020,    0.1068]"
        "  # [1] changed from 0.020, [7] changed from 0.089",
        "com_m           = [0.1663,   0.00864,   0.0096,   0.0095,   0.0220,   0.0096,   0.0096,   0.03756]"
        "  # [1] changed from 0.0096, [7] changed from 0.0313",
        "mass_kg         = [2.4299,    0.117,    0.091,    0.069,    0.106,    0.026,    0.020,    0.049]"
        "  # [0] changed from 2.209",
        "lateral_area_m2 = [0.03375,  0.002079,  0.00208,  0.00184,  0.00356,  0.00107,  0.00092,  0.006132]"
        "  # [1] changed from 0.00231, [7] changed from 0.00511",
        "wetted_area_m2  = [0.00903,  0.005337,  0.00528,  0.00461,  0.00888,  0.00271,  0.00237,  0.013848]"
        "  # [1] changed from 0.00593, [7] changed from 0.01154",
        "buoyancy_center_m   = [0.1663,  0.00864,  0.0096,  0.0095,  0.0220,  0.0096,  0.0096,  0.03756]"
        "  # [1] changed from 0.0096, [7] changed from 0.0313",
    ]


def test_the_saved_file_swims_on_the_command_line(page: Page, tmp_path: Path) -> None:
    image = robot_image(ht.load("examples/myfish.toml"))
    changed, toml, _ = page.changed(image, {"length-2": 1.3, "fin": 1.2})
    assert " # length of each link; [2] changed from 0.075" in toml
    file = tmp_path / "myfish-changed.toml"
    file.write_text(toml)
    done = CliRunner().invoke(app, ["swim", "--robot", str(file), "--frequency", "2", "--amplitude", "20,30", "--json"])
    assert done.exit_code == 0, done.output
    assert different(columns_of(robot_image(ht.load(file))), columns_of(changed)) == []


def test_a_robot_without_a_file_has_a_source_too(page: Page) -> None:
    """A description of a hinge that no file holds."""
    document = ht.load("hypertuna").document() | {"hinge": HINGE}
    robot = parse(document)
    image = robot_image(robot)
    factors = {"hinge": 1.5, "length-7": 0.8, "fin": 1.4}
    changed, toml, _ = page.changed(image, factors)
    exported = parse(tomllib.loads(toml))
    assert exported.hinge is not None
    assert exported.hinge.stiffness == pytest.approx(1.5 * HINGE["stiffness_n_m_per_rad"])
    assert different(columns_of(robot_image(exported)), columns_of(changed)) == []
    assert [knob["name"] for knob in text_of(image)["body"]["knobs"]][-2:] == ["hinge", "silicone"]


def test_numbers_of_odd_layouts_are_found_or_left_alone() -> None:
    """Dotted and quoted keys, comments in lists, several lines, carriage returns; an inline table is left alone."""
    lines = (
        *("# 1 = 2, é \U0001f41f", 'title = "a = 1 # no"', "[a.b]", "x = 1_000.5e-1 # 3", "y.z = -2", '"q r" = 3'),
        *("list = [", "  1.0, # 2", "  [2, +3], ]", "day = 2026-11-23", "inline = {k = 4}", 'long = """', 'x = 5"""'),
        *("[[t]]", "u = 6", "[t.v]", "w = 7", "[[t]]", "u = 8\r", "last = 9"),
    )
    source = Source("\n".join(lines), places := checked_places("\n".join(lines)))
    numbers = {
        key: tomllib.loads(f"x = {token[0]}")["x"]
        for key, at in places.items()
        if (token := TOKEN.match(source.text, at))
    }
    assert numbers == {
        **{"a.b.x": 100.05, "a.b.y.z": -2, "a.b.q r": 3, "a.b.list[0]": 1.0, "a.b.list[1][0]": 2, "a.b.list[1][1]": 3},
        **{"t[0].u": 6, "t[0].v.w": 7, "t[1].u": 8, "t[1].last": 9},
    }
    assert source.at("a.b.x") == places["a.b.x"] + 1  # the fish takes two units
    assert not source.holds(["a.b.x", "a.b.inline.k"])
    assert checked_places("[broken") == {}


def test_a_twin_that_would_need_other_steps_does_not_follow() -> None:
    """A hinge with much damping is the fastest of the plant: shorter steps for a lighter tail."""
    robot = parse(ht.load("hypertuna").document() | {"hinge": HINGE | {"damping_n_m_s_per_rad": 0.01}})
    knobs = text_of(robot_image(robot))["body"]["knobs"]
    assert len(knobs) == 19
    assert not any(knob["twin"] for knob in knobs)
    assert not any(column.startswith("plant.") for knob in knobs for column in knob["columns"])


def test_bodies_that_are_no_robots_or_have_no_twin_are_no_fault_of_the_image(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pump as long as the shortest body; a twin that cannot be stepped where all is changed."""
    from hypertuna.simulation import image as image_module

    document = ht.load("hypertuna").document()
    robot = parse(document | {"pump": document["pump"] | {"rod_m": 0.35}})
    knobs = text_of(robot_image(robot))["body"]["knobs"]
    assert len(knobs) == 18
    assert all(knob["twin"] for knob in knobs)
    steps, length = image_module.steps_of, robot.body.length

    def refused(tick: float, parts: Any, one: ht.Robot) -> int:
        if one.body.length > 1.3 * length:
            raise ht.InputError("must not be so stiff", key="hinge", fix="give less")
        return steps(tick, parts, one)

    monkeypatch.setattr(image_module, "steps_of", refused)
    assert not any(knob["twin"] for knob in text_of(robot_image(robot))["body"]["knobs"])


def with_inertias(robot: ht.Robot) -> ht.Robot:
    """Return a robot whose file gives the moments of inertia that are an ellipsoid's by default."""
    document = robot.document()
    document["spatial"] |= {f"inertia_{axis}_kg_m2": [2e-3] * len(robot.links.name) for axis in ("roll", "pitch")}
    document["links"]["inertia_kg_m2"] = list(robot.links.inertia)
    return parse(document)


def follow(columns: dict[str, Array], knobs: list[dict[str, Any]], factors: dict[str, float]) -> dict[str, Array]:
    """Return the columns with factors on the knobs, as the image says: sums first, then products."""
    found = {name: values.ravel().copy() for name, values in columns.items()}
    laws = [
        (name, place, law, factors.get(knob["name"], 1.0))
        for knob in knobs
        for column, rows in knob["columns"].items()
        for name in columns
        if re.fullmatch(re.escape(column).replace(r"\*", r"\d+"), name)
        for place, *law in rows
    ]
    for name, place, law, factor in laws:
        found[name][place] += law[1] * (factor ** law[0] - 1) if len(law) == 2 else 0.0
    for name, place, law, factor in laws:
        found[name][place] *= factor ** law[0] if len(law) == 1 else 1.0
    return {name: values.reshape(columns[name].shape) for name, values in found.items()}


@pytest.mark.parametrize("make", ["servofish", "minnow", "sea", "inertias"])
def test_numbers_follow_factors_as_their_keys_are_declared(make: str) -> None:
    """Every number of the image at once, without the page: of robots without a twin, with servos, at sea."""
    sea = parse(tomllib.loads(first_robot("sea", links=3, length=0.6, actuation="servo", sea=True)))
    made = {"sea": lambda: sea, "inertias": lambda: with_inertias(sea)}
    robot = made.get(make, lambda: ht.load(f"examples/{make}.toml"))()
    image, document = robot_image(robot), robot.document()
    knobs = text_of(image)["body"]["knobs"]
    links = len(robot.links.name)
    assert len(knobs) == 2 * links + 1
    for factors in bodies(image, seed=3):
        changed = robot_image(parse(with_factors(document, list(_knobs(robot, document)), factors)))
        expected = follow(columns_of(image), knobs, factors)
        assert different(columns_of(changed), expected) == []


def test_a_silicone_that_a_pump_cannot_bend_is_no_knob() -> None:
    """The pump of a tiny fish turns too little for the reach of softer or stiffer joints."""
    lengths = [0.154, 0.00513, 0.0411]
    text = first_robot("tiny", joints=["a", "b"], actuation="hydraulic", lengths=lengths, mass=0.016)
    robot = parse(tomllib.loads(text))
    assert [knob["name"] for knob in text_of(robot_image(robot))["body"]["knobs"]][-1] == "fin"
