"""Robots as SDF models: what is read back has the core's kinetic energy, volumes and drag."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.cli.main import app
from hypertuna.description.robot import parse
from hypertuna.simulation.sea import Sea, space_columns, world_at_sea
from hypertuna.swimming.model import core_model
from models import changed
from random_robots import random_robot

AXES = "xyzpqr"
ROBOTS = [(name, law) for name in ht.robots() for law in ("lumped", "strip", "elongated")]


def fish_of(name: str, law: str) -> ht.Robot:
    """A robot by another law, if it has it."""
    fish = ht.load(name)
    if getattr(fish.water, law) is None:
        pytest.skip(f"{name} has no coefficients of the law")
    return fish.using(water=law)


def numbers(element: ElementTree.Element, path: str) -> Array:
    """Numbers of an element."""
    return np.array([float(word) for word in (element.findtext(path) or "").split()])


def inertia(link: ElementTree.Element) -> tuple[Array, Array, Array]:
    """Place of a link's center of mass, and its own inertia and its added mass (6, 6) there."""
    own, added = np.zeros((6, 6)), np.zeros((6, 6))
    own[:3, :3] = np.eye(3) * numbers(link, "inertial/mass")
    for a, row in enumerate("xyz"):
        for b, column in enumerate("xyz"[a:], start=a):
            own[3 + a, 3 + b] = own[3 + b, 3 + a] = numbers(link, f"inertial/inertia/i{row}{column}")[0]
    for a, row in enumerate(AXES):
        for b, column in enumerate(AXES[a:], start=a):
            added[a, b] = added[b, a] = numbers(link, f"inertial/fluid_added_mass/{row}{column}")[0]
    return numbers(link, "pose")[:3], own, added


def links_of(fish: ht.Robot) -> list[ElementTree.Element]:
    """The links of its model."""
    return ElementTree.fromstring(ht.sdf(fish)).findall("model/link")


def at_nose(place: Array, matrix: Array) -> Array:
    """A link's inertia for a twist (v, w) of the straight robot's nose."""
    x, y, z = place
    to_link = np.eye(6)
    to_link[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]  # w x place
    return to_link.T @ matrix @ to_link


@pytest.mark.parametrize(("name", "law"), ROBOTS)
def test_in_the_plane_it_has_the_inertia_of_the_core(name: str, law: str) -> None:
    fish = fish_of(name, law)
    total = sum(at_nose(place, own + added) for place, own, added in map(inertia, links_of(fish)))
    straight = np.zeros((1, len(fish.links.name), 3))
    expected = _core.dynamics(core_model(fish), straight, np.zeros((1, 3)))["inertia"][0]
    assert total[np.ix_((0, 1, 5), (0, 1, 5))] == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("law", ["lumped", "strip", "elongated"])
def test_in_space_it_has_the_inertia_of_the_core(law: str) -> None:
    """The core's accelerations of the straight robot from rest tell its inverse, by pushes of fins and joints."""
    heights = [0.004, -0.003, 0.002, 0.001, 0.002, -0.001, 0.003, -0.002]
    fish = changed(fish_of("hypertuna", law), {"spatial.buoyancy_height_m": heights}).using(water=law)
    driven = [2, 3, 4, 5, 7]  # as many as the core has coordinates
    share = np.eye(8)[:, driven]
    body = _core.Body(core_model(fish), {"share": share, **space_columns(fish)})
    moments = np.concatenate([np.zeros((1, 5)), np.eye(5)])
    states = len(moments)
    turned = [1, 0.2, -0.3, 0.4]
    pose = np.array([[0, 0, -5, *np.divide(turned, np.linalg.norm(turned)), 0, 0]] * states)
    rest = np.zeros((states, 2, 5)), np.zeros((states, 6))
    rates = body.accelerations(world_at_sea(fish, Sea()), bend=rest[0], twist=rest[1], pose=pose, moment=moments)
    inverse = (rates[1:] - rates[0]).T  # (11, 5)

    fronts = np.cumsum([0, *fish.links.length[:-1]])
    matrix, weight = np.zeros((11, 11)), np.zeros(11)
    up = up_of(pose[0, 3:7])
    for i, link in enumerate(links_of(fish)):
        place, own, added = inertia(link)
        columns = np.zeros((6, 11))
        columns[:, :6] = np.eye(6)
        columns[:3, 3:6] = -np.cross(np.eye(3), -place).T
        for d, joint in enumerate(driven):
            if joint <= i:
                columns[:, 6 + d] = [0, place[0] - fronts[joint], 0, 0, 0, 1]
        matrix += columns.T @ (own + added) @ columns
        box = numbers(link, "collision/geometry/box/size").prod() * fish.water.density
        arm = numbers(link, "collision/pose")[:3]
        weight += columns.T @ np.concatenate([9.81 * (box - own[0, 0]) * up, np.cross(arm, 9.81 * box * up)])
    assert matrix @ inverse == pytest.approx(np.eye(11)[:, 6:], abs=1e-9)
    assert matrix @ rates[0] == pytest.approx(weight, abs=1e-9)


def up_of(quaternion: Array) -> Array:
    """The world's up in body axes."""
    w, x, y, z = quaternion
    return np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])


@pytest.mark.parametrize("fish", [*map(ht.load, ht.robots()), *map(random_robot, range(6))], ids=lambda fish: fish.name)
def test_moments_of_inertia_are_those_of_bodies(fish: ht.Robot) -> None:
    """Gazebo refuses others: one that exceeds the sum of the two others."""
    for link in links_of(fish):
        three = np.diag(inertia(link)[1])[3:]
        assert (three > 0).all()
        assert 2 * three.max() <= three.sum()


def test_the_drag_is_that_of_the_law_with_gazebos_signs() -> None:
    fish = fish_of("hypertuna", "lumped")
    assert fish.water.lumped is not None
    plugins = ElementTree.fromstring(ht.sdf(fish)).findall("model/plugin[@name='gz::sim::systems::Hydrodynamics']")
    assert [plugin.findtext("link_name") for plugin in plugins] == list(fish.links.name)
    across = [numbers(plugin, "yVabsV")[0] for plugin in plugins]
    areas = np.multiply(fish.water.lumped.drag, fish.links.lateral_area)
    assert across == pytest.approx(-0.5 * fish.water.density * areas)
    assert [numbers(plugin, "nRabsR")[0] for plugin in plugins] == pytest.approx(np.zeros(8), abs=1e-12)


def stated(text: str) -> list[str]:
    """What a file says that it lacks."""
    return [
        line.strip().removeprefix("- ")
        for line in text.split("Not in this file:\n")[1].split("-->")[0].splitlines()[:-1]
    ]


def test_it_says_what_it_lacks() -> None:
    fish = ht.load("hypertuna")
    lost = stated(ht.sdf(fish))
    assert "first-order lag of joint group II: 4.7 Hz" in lost
    for part in ("gaits: ", "joints beyond 50 rad/s and 90 deg: ", "pectoral fins: "):
        assert sum(line.startswith(part) for line in lost) == 1
    assert not any("lag" in line for line in stated(ht.sdf(fish.using(joints="ideal"))))
    assert not any("pectoral" in line for line in stated(ht.sdf("rexeel")))


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("cross_flow", "cross flow in the drag: v_n |v_n| stands for v_n |v|"),
        ("linear_tangential_pa_s", "linear drag along the links"),
        ("linear_normal_pa_s", "linear drag across the links"),
    ],
)
def test_it_says_what_of_the_drag_it_lacks(key: str, line: str) -> None:
    fish = changed(ht.load("hypertuna").using(water="strip"), {"water.strip.cross_flow": False})
    more = changed(fish, {f"water.strip.{key}": True if key == "cross_flow" else [0.1] * 8})
    assert [one for one in stated(ht.sdf(more)) if one not in stated(ht.sdf(fish))] == [line]
    assert [one for one in stated(ht.mjcf(more)) if one not in stated(ht.mjcf(fish))] == [line]


def test_it_has_the_shares_and_offsets_of_each_group() -> None:
    document = ht.load("hypertuna").document()
    document["joints"][1] |= {"share": [0.1, 0.4, 0.5], "phase_offset_deg": 10.0}
    lost = stated(ht.sdf(parse(document)))
    first, second = (line.split(": ")[-1] for line in lost if line.startswith("coupling"))
    third = 1 / 3
    assert first == f"joint-L2 {third}, joint-L3 {third}, joint-L4 {third}"
    assert second == "joint-L5 0.1, joint-L6 0.4, joint-L7 0.5"
    offsets = [line for line in lost if line.startswith("phase offset")]
    assert offsets == [f"phase offset of joint group II: {np.radians(10.0)} rad, to add to a gait's phase"]


@pytest.mark.parametrize("name", ["joint-L2", "world"])
def test_names_that_gazebo_would_refuse(name: str) -> None:
    fish = ht.load("hypertuna")
    with pytest.raises(ht.InputError, match="links.name must be no name of the file's own parts"):
        ht.sdf(changed(fish, {"links.name": [name, *fish.links.name[1:]]}))


def test_the_command_writes_it(tmp_path: Path) -> None:
    file = tmp_path / "eel.sdf"
    result = CliRunner().invoke(app, ["export", "sdf", "--robot", "rexeel", "-o", str(file), "--json"])
    assert result.exit_code == 0
    assert file.read_text() == ht.sdf("rexeel")
    record = json.loads(result.output)
    assert record["file"] == str(file)
    assert record["lost"] == stated(file.read_text())
