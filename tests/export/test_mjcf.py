"""Robots as MuJoCo models: they compile, are dragged as the water law says, and swim as here."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path

import mujoco
import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.cli.main import app
from hypertuna.description.robot import parse
from hypertuna.export.mjcf import losses
from hypertuna.swimming.model import core_model
from models import changed
from mujoco_play import PUBLISHED, model, play, speed
from random_robots import random_robot

LAWS = ("lumped", "strip", "elongated")
DESCRIBED = [(name, law) for name in ht.robots() for law in LAWS if getattr(ht.load(name).water, law) is not None]
IDEAL = ht.load("hypertuna").using(joints="ideal", water="lumped")


@pytest.mark.parametrize("gait", PUBLISHED)
def test_the_published_gaits_swim_within_1_percent(gait: str) -> None:
    assert speed(model(IDEAL), gait, beats=20) == pytest.approx(ht.swim(IDEAL, gait).speed, rel=0.01)


def test_joints_with_a_bandwidth_lag_behind_their_commands() -> None:
    robot = ht.load("hypertuna").using(joints="bandwidth")
    assert speed(model(robot), "unoptimised-0.4", beats=20) == pytest.approx(
        ht.swim(robot, "unoptimised-0.4").speed, rel=0.01
    )


SPRUNG = {"link": 7, "stiffness_n_m_per_rad": 0.5, "damping_n_m_s_per_rad": 0.01, "rest_deg": 3.0}
SPRUNG |= {"cubic_n_m_per_rad3": 4.0, "stop_deg": 30.0, "stop_stiffness_n_m_per_rad": 20.0}


def test_a_hinge_has_its_spring_and_swims_within_2_percent() -> None:
    """Rest angle and cubic term; MuJoCo's limits stand at the stops, and the file says so."""
    robot = changed(IDEAL, {"hinge": SPRUNG})
    m = model(robot)
    joint = m.joint(f"hinge-{robot.links.name[7]}")
    np.testing.assert_allclose(joint.range, np.radians([-30, 30]))
    d = mujoco.MjData(m)
    d.qpos[joint.qposadr], d.qvel[joint.dofadr] = 0.2, 0.0
    mujoco.mj_forward(m, d)
    bent = 0.2 - np.radians(3.0)
    assert d.qfrc_passive[joint.dofadr] == pytest.approx(-0.5 * bent - 4 * bent**3, rel=1e-9)
    gait = "unoptimised-0.4"
    assert speed(m, gait, beats=20) == pytest.approx(ht.swim(robot, gait).speed, rel=0.02)
    assert [line for line in losses(robot, plugin=False, free=False) if "stops" in line or "cubic" in line]
    plain = changed(IDEAL, {"hinge": {"link": 7, "stiffness_n_m_per_rad": 0.5}})
    assert not any("stops" in line or "cubic" in line for line in losses(plain, plugin=False, free=False))


def test_a_motor_gives_a_hinge_the_moment_that_drives_it() -> None:
    """As the comment of the file says; with this phase it slows the robot down by a sixth."""
    keys = {"moment_n_m": 0.15, "moment_phase_deg": 200.0, "rest_deg": 0.0}
    robot, gait = changed(IDEAL, {"hinge": SPRUNG | keys}), "unoptimised-0.4"
    text = ht.mjcf(robot)
    assert (
        f"The control of motor moment-{robot.links.name[7]} is a moment in N m: 0.15 sin(2 pi frequency t - 3.49"
        in text
    )
    m = mujoco.MjModel.from_xml_string(text)
    motor = m.actuator(f"moment-{robot.links.name[7]}").id
    assert motor == m.nu - 1
    driven = speed(m, gait, beats=20, moment=lambda clock: 0.15 * np.sin(clock - np.radians(200.0)))
    assert driven == pytest.approx(ht.swim(robot, gait).speed, rel=0.02)
    assert abs(driven / speed(m, gait, beats=20) - 1) > 0.1


def half_sizes(m: mujoco.MjModel, kind: type = np.float64, smallest: float = 1e-15) -> Array:
    """Half sizes (n, 3) of the boxes that an engine makes of the water bodies [m].

    In its arithmetic, with its smallest difference of moments of inertia [kg m^2]; each in any order of the sum.
    """
    bodies = [b for b in range(m.nbody) if "-water-" in m.body(b).name]
    x, y, z = m.body_inertia[bodies].astype(kind).T
    orders = np.array(
        [
            [one + two - three, one - three + two, one + (two - three)]
            for one, two, three in ((y, z, x), (x, z, y), (x, y, z))
        ]
    )
    assert orders.dtype == kind
    assert (orders == orders[:, :1]).all()
    sizes: Array = np.sqrt(kind(1.5) * np.maximum(kind(smallest), orders[:, 0]) / m.body_mass[bodies].astype(kind)).T
    return sizes


def test_boxes_of_water_have_the_drag_of_their_link() -> None:
    """By hand: MuJoCo's half sizes from moments of inertia, and 2 rho r_y r_z = rho/2 c_f S_f."""
    x, y, z = half_sizes(model(IDEAL)).reshape(-1, 2, 3).transpose(2, 0, 1)  # two at each link
    links, water = IDEAL.links, IDEAL.water.lumped
    assert water is not None
    np.testing.assert_allclose(4 * (y * z).sum(axis=1), np.multiply(water.friction, links.wetted_area), rtol=1e-5)
    np.testing.assert_allclose(4 * (x * z).sum(axis=1), np.multiply(water.drag, links.lateral_area), rtol=1e-4)


@pytest.mark.parametrize("robot", [*DESCRIBED, *range(6)], ids=str)
def test_boxes_of_water_survive_single_precision(robot: tuple[str, str] | int) -> None:
    """MJX and MuJoCo Warp compute in it. The smallest box of MJX is larger, and the file tells what that drags."""
    fish = random_robot(robot) if isinstance(robot, int) else ht.load(robot[0]).using(water=robot[1])
    m = model(fish)
    exact, warp, mjx = half_sizes(m), half_sizes(m, np.float32), half_sizes(m, np.float32, 1e-12)
    np.testing.assert_allclose(warp, exact, rtol=1e-5)
    (x, y, z), (x_mjx, y_mjx, z_mjx) = exact.T, mjx.T
    assert x_mjx @ z_mjx == pytest.approx(x @ z, rel=0.01)
    (line,) = (line for line in losses(fish, plugin=False, free=False) if "MJX" in line)
    more = 100 * (y_mjx @ z_mjx / (y @ z) - 1)
    assert float(line.split("add ")[1].split(" %")[0]) == pytest.approx(more, rel=0.06)  # two digits
    assert 0 < more < (2 if fish.name == "hypertuna" and fish.model.water == "lumped" else 15)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("direction", [0, 1])
def test_a_straight_robot_is_dragged_as_the_law_says(law: str, direction: int) -> None:
    """Along and across, by all links together: backward, so that the tail end leaves no wake."""
    robot = IDEAL.using(water=law)
    m = model(robot)
    d = mujoco.MjData(m)
    d.qvel[direction] = 0.7
    mujoco.mj_forward(m, d)
    links, coefficients, half = robot.links, getattr(robot.water, law), robot.water.density / 2
    if law == "lumped":
        areas = np.multiply(
            *((coefficients.friction, links.wetted_area), (coefficients.drag, links.lateral_area))[direction]
        )
    else:
        pair = ((coefficients.drag_tangential, links.wetted_area), (coefficients.drag_normal, links.lateral_area))
        areas = np.multiply(*pair[direction])
        if direction == 0:
            areas = areas + getattr(coefficients, "blunt_area", 0)
    assert d.qfrc_fluid[direction] == pytest.approx(-half * areas.sum() * 0.7**2, rel=1e-3)


@pytest.mark.parametrize("law", ["strip", "elongated"])
def test_without_the_tail_fin_s_force_it_is_slower_than_the_robot_and_says_so(law: str) -> None:
    """At a quarter to half of the speed, the page says; after ten beats from rest."""
    robot = IDEAL.using(water=law)
    assert 0.2 < speed(model(robot), "unoptimised-max", beats=10) / ht.swim(robot, "unoptimised-max").speed < 0.5
    assert "the tail fin's force, most of the thrust: without the plugin, speeds are too low" in ht.mjcf(robot)


@pytest.mark.parametrize("part", [1.0, 0.1, 0.01])
def test_it_says_how_much_the_boxes_resist_turning(part: float) -> None:
    """About the center of mass, beside the core's drag, for any friction."""
    assert IDEAL.water.lumped is not None
    robot = changed(IDEAL, {"water.lumped.friction": [part * one for one in IDEAL.water.lumped.friction]})
    m, links = model(robot), robot.links
    middle = np.dot(links.mass, np.cumsum([0, *links.length[:-1]]) + links.com) / sum(links.mass)
    about = np.array([0, -middle, 1])
    d = mujoco.MjData(m)
    d.qvel[:3] = about
    mujoco.mj_forward(m, d)
    core = _core.dynamics(core_model(robot), np.zeros((1, 8, 3)), about[np.newaxis])["wrench"][0]
    excess = 100 * (d.qfrc_fluid[:3] @ about / (core @ about) - 1)
    (line,) = (line for line in losses(robot, plugin=False, free=False) if line.startswith("rotation as free"))
    assert float(line.split("add ")[1].split(" %")[0]) == pytest.approx(excess, rel=0.06)  # two digits
    assert 0.05 < excess < 0.15


@pytest.mark.parametrize("robot", [*ht.robots(), *range(6)])
def test_the_compiler_takes_it_with_its_masses(robot: str | int) -> None:
    fish = random_robot(robot) if isinstance(robot, int) else ht.load(robot)
    m = model(fish)
    assert m.nu == len(fish.joints)
    assert m.nv == 3 + sum(len(group.links) for group in fish.joints)
    straight = mujoco.MjData(m)
    mujoco.mj_forward(m, straight)
    if fish.model.water == "lumped":
        assert fish.water.lumped is not None
        wet = np.multiply(fish.links.mass, np.add(1, fish.water.lumped.added_mass))
        assert m.body_mass.sum() == pytest.approx(wet.sum(), rel=1e-12)
        fronts = np.cumsum([0, *fish.links.length[:-1]]) + fish.links.com
        assert straight.subtree_com[1, 0] == pytest.approx(wet @ fronts / wet.sum(), rel=1e-12)
        turn = np.array(fish.links.inertia).sum() + wet @ fronts**2
        row = np.zeros(m.nv)
        mujoco.mj_mulM(m, straight, row, np.eye(m.nv)[2])
        assert row[2] == pytest.approx(turn, rel=1e-9)


@pytest.mark.parametrize("share", [(0.0, 0.4, 0.6), (-1.0, 1.5, 0.5)])
def test_joints_are_coupled_by_any_shares(share: tuple[float, ...]) -> None:
    document = IDEAL.document()
    document["joints"][1]["share"] = list(share)
    m = model(parse(document))
    d = mujoco.MjData(m)
    for i, part in zip((5, 6, 7), share, strict=True):
        d.joint(f"joint-L{i}").qpos = 0.3 * part
    mujoco.mj_forward(m, d)
    assert d.efc_pos == pytest.approx(np.zeros(4), abs=1e-15)
    assert d.ten_length == pytest.approx([0, 0.3])


def test_joints_on_tendons_bend_as_their_levers_have_it() -> None:
    """MuJoCo's position actuator on the group's fixed tendon bends the example's four joints by their shares."""
    fish = ht.load("examples/tendonfish.toml")
    m = model(fish)
    d = mujoco.MjData(m)
    d.ctrl[:] = 0.4
    mujoco.mj_step(m, d, nstep=2000)
    bends = np.array([d.joint(f"joint-{name}").qpos[0] for name in fish.links.name[1:]])
    assert bends == pytest.approx(0.4 * np.array(fish.joints[0].share), abs=4e-4)


def test_free_motion_needs_the_plugin() -> None:
    with pytest.raises(ht.InputError, match="^--free must come with the engine plugin"):
        ht.mjcf(IDEAL, free=True)


@pytest.mark.parametrize(
    ("key", "zeros", "message"),
    [
        ("friction", range(8), "0 along link L0"),
        ("drag", [2], "0 across link L2"),
    ],
)
def test_boxes_of_water_need_drag(key: str, zeros: Iterable[int], message: str) -> None:
    """MuJoCo would refuse a flat box."""
    values = list(getattr(IDEAL.water.lumped, key))
    for i in zeros:
        values[i] = 0.0
    robot = changed(IDEAL, {f"water.lumped.{key}": values})
    with pytest.raises(ht.InputError, match=f"water.lumped must drag each link .*{message}"):
        ht.mjcf(robot)
    assert ht.mjcf(robot, plugin=True)


@pytest.mark.parametrize("part", [1e-3, 1e-300])
def test_friction_below_that_of_the_smallest_boxes_is_told(part: float) -> None:
    assert IDEAL.water.lumped is not None
    robot = changed(IDEAL, {"water.lumped.friction": [part * one for one in IDEAL.water.lumped.friction]})
    (line,) = (line for line in losses(robot, plugin=False, free=False) if line.startswith("friction as low"))
    d = mujoco.MjData(model(robot))
    d.qvel[0] = 1
    mujoco.mj_forward(d.model, d)
    wanted = part * IDEAL.water.density / 2 * np.dot(IDEAL.water.lumped.friction, IDEAL.links.wetted_area)
    excess = float(line.split("add ")[1].split(" %")[0])
    assert excess == pytest.approx(100 * (-d.qfrc_fluid[0] / wanted - 1), rel=0.06)
    assert excess > 1
    assert not any(line.startswith("friction as low") for line in losses(IDEAL, plugin=False, free=False))


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_attached_to_a_scene_with_the_options_of_its_comment_it_swims_as_alone(tilt: float) -> None:
    text = ht.mjcf(IDEAL)
    (line,) = re.findall(r"timestep (\S+), integrator (\S+), density (\S+)\.\n", text)
    scene = mujoco.MjSpec()
    scene.option.timestep, scene.option.density = float(line[0]), float(line[2])
    scene.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{line[1]}")
    frame = scene.worldbody.add_frame(quat=[np.cos(tilt), 0, 0, np.sin(tilt)], pos=[1, 2, 0])
    scene.attach(mujoco.MjSpec.from_string(text), prefix="a_", frame=frame)  # would warn of other options
    m, alone = scene.compile(), play(model(IDEAL), "unoptimised-0.5", beats=3)
    attached = play(m, "a_unoptimised-0.5", beats=3, prefix="a_")
    moved = [np.hypot(*(path[-1, 1:] - path[0, 1:])) for path in (attached, alone)]
    assert moved[0] == pytest.approx(moved[1], rel=1e-6)
    assert moved[1] > 0.15


@pytest.mark.parametrize("name", ["fin-upper", "pectoral-port", "world", "L0-water-0"])
def test_names_that_mujoco_would_refuse(name: str) -> None:
    robot = changed(IDEAL, {"links.name": ["L0", name, *IDEAL.links.name[2:]]})
    with pytest.raises(ht.InputError, match=f"links.name must be no name of the file's own parts, but is '{name}'"):
        ht.mjcf(robot)


@pytest.mark.parametrize(
    ("words", "lost"),
    [
        ([], ["exact timing", "current", "motion out of the plane", "rotation as free", "the same drag in MJX"]),
        (["--plugin"], ["exact timing", "current", "motion out of the plane", "MJX and MuJoCo Warp"]),
        (["--plugin", "--free"], ["exact timing", "current", "the pectoral servos", "MJX and MuJoCo Warp"]),
    ],
)
def test_the_command_writes_it_and_what_it_lacks(words: list[str], lost: list[str], tmp_path: Path) -> None:
    file = tmp_path / "fish.xml"
    words = ["export", "mjcf", "--robot", "hypertuna", "--joints", "ideal", "-o", str(file), "--json", *words]
    result = CliRunner().invoke(app, words)
    text, record = file.read_text(), json.loads(result.output)
    assert text == ht.mjcf(IDEAL, plugin="--plugin" in words, free="--free" in words)
    assert record["file"] == str(file)
    listed = text.split("Not in this file:\n")[1].split("-->")[0].splitlines()[:-1]
    assert [f"- {line}" for line in record["lost"]] == [line.strip() for line in listed]
    assert [part for part in lost if any(line.startswith(part) for line in record["lost"])] == lost
    assert ("rotation as free" in text, "pectoral servos" in text) == ("--plugin" not in words, "--free" in words)
    assert "2.8 ms" in text
