"""Hinges that yield, in the C interface: settled beats, derivatives and paths of Python, and the page's knobs."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import hypertuna as ht
from host_library import Host, Robot
from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import parse
from hypertuna.mission.image import robot_image
from hypertuna.swimming.beat import STATUSES, directional_derivatives, settle
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.swimming.model import core_model
from image_file import columns_of, with_number
from studio_code import Page

CRUISE = Gait.from_degrees(frequency=2, amplitude=(16,), phase=(0,))
TAILS = ("passive", "flexible", "stopped", "driven")  # of one hinge; of three; these with stops; with moments
SPRUNG = {
    "rest_deg": 2.0,
    "cubic_n_m_per_rad3": 0.05,
    "stop_deg": 8.0,
    "stop_stiffness_n_m_per_rad": 0.1,
    "stop_dissipation_n_m_s_per_rad2": 0.002,
}


def swimmer(tail: str, host: Host) -> tuple[ht.Robot, Robot]:
    """A first robot of a tail, and its image as a host reads it."""
    made = tail if tail == "passive" else "flexible"
    document = tomllib.loads(first_robot("x", tail=made, actuation="servo"))
    if tail == "stopped":
        document["hinges"][:2] = [hinge | SPRUNG for hinge in document["hinges"][:2]]
    if tail == "driven":
        for d, hinge in enumerate(document["hinges"]):
            hinge |= {"moment_n_m": 0.2 * hinge["stiffness_n_m_per_rad"], "moment_phase_deg": -30.0 * d}
    robot = parse(document)
    read = Robot.read(robot_image(robot), host)
    assert isinstance(read, Robot)
    return robot, read


def gaits_of(count: int) -> list[Gait]:
    """Gaits of one joint group; at the slow ones a beat takes more steps, since the springs are faster than it."""
    chance = np.random.default_rng(11)
    sizes = np.radians(chance.uniform((4, -8), (30, 8), (count, 2)))
    return [
        Gait(frequency=float(hertz), amplitude=(float(size),), phase=(0.3,), bias=(float(bias),))
        for hertz, (size, bias) in zip(chance.permutation(np.geomspace(0.3, 4, count)), sizes, strict=True)
    ]


@pytest.mark.parametrize("tail", TAILS)
def test_settled_gaits_and_derivatives_are_those_of_python(host: Host, tail: str) -> None:
    robot, ours = swimmer(tail, host)
    gaits = gaits_of(12)
    beats, found = settle(robot, Gaits.of(gaits)), ours.swim(0, gaits)
    settled = beats["status"] == 0
    assert settled.sum() > 8
    assert np.array_equal(found["status"], beats["status"])
    for name in ("speed", "mechanical_power", "torque_peak", "tail_excursion", "spectral_radius"):
        assert found[name][settled] == pytest.approx(beats[name][settled], rel=1e-9), name
    along = np.eye(len(core_model(robot).parameter_names()), 4)
    wanted = directional_derivatives(robot, Gaits.of(gaits), beats, along)
    k = int(np.flatnonzero(settled)[0])
    for name, values in ours.gradient(0, gaits[k]).items():
        scale = np.abs(wanted[name][k]).max()
        assert values == pytest.approx(wanted[name][k], rel=1e-8, abs=1e-8 * scale), name


@pytest.mark.parametrize("tail", TAILS)
def test_a_beat_that_no_steps_follow_is_told(host: Host, tail: str) -> None:
    """A gait so slow that the springs are too fast for 1024 steps has a status, beside a gait that swims."""
    robot, ours = swimmer(tail, host)
    slow = replace(CRUISE, frequency=1e-3)
    with pytest.raises(ht.InputError, match="must let 1024 steps of a beat at 0.001 Hz follow it"):
        ht.swim(robot, slow)
    found = ours.swim(0, [slow, CRUISE])
    assert [STATUSES[int(status)] for status in found["status"]] == ["unresolved", "settled"]
    assert np.array_equal(np.isfinite(found["speed"]), [False, True])
    assert not any(np.isfinite(values).any() for values in ours.gradient(0, slow).values())
    assert not np.isfinite(ours.path(0, slow, 128)[1:, 1:4]).any()


@pytest.mark.parametrize("tail", TAILS)
def test_the_path_bends_the_hinges(host: Host, tail: str) -> None:
    robot, ours = swimmer(tail, host)
    swim, rows = ht.swim(robot, CRUISE), ours.path(0, CRUISE, 128)
    data = swim.trajectory.isel(time=slice(None, None, swim.steps // 128))
    same = (
        1e-5 if tail == "stopped" else 1e-7
    )  # the last step meets the first instant again here, and the end of as many finer steps there
    assert rows[:, 1:4] == pytest.approx(np.c_[data["x"], data["y"], data["heading"]], abs=same)
    links = [hinge.link for hinge in robot.hinges]
    assert np.abs(rows[:, [4 + link for link in links]]).max() > 0.1  # rad
    assert rows[:, 4 + links[0]] == pytest.approx(data["joint_angle"][:, links[0]], abs=same)


@pytest.mark.parametrize("tail", TAILS)
def test_the_page_changes_the_springs(page: Page, core: Host, tail: str) -> None:
    """A knob a hinge, and one for its moment; the robot that the page saves swims as the page's."""
    robot, _ = swimmer(tail, core)
    names = [knob["name"] for knob in json.loads(Robot.read(robot_image(robot), core).text)["body"]["knobs"]]
    springs, moments = ([name for name in names if name.startswith(kind)] for kind in ("hinge", "moment"))
    assert len(springs) == len(robot.hinges)
    assert len(moments) == (len(robot.hinges) if tail == "driven" else 0)
    changed, toml, _ = page.changed(robot_image(robot), {springs[-1]: 1.4} | dict.fromkeys(moments[-1:], 1.5))
    saved = parse(tomllib.loads(toml))
    assert saved.hinges[-1].stiffness == pytest.approx(1.4 * robot.hinges[-1].stiffness)
    assert saved.hinges[-1].moment == pytest.approx(1.5 * robot.hinges[-1].moment)
    speed = Robot.read(changed, core).swim(0, [CRUISE])["speed"][0]
    assert speed == pytest.approx(ht.swim(saved, CRUISE).speed, rel=1e-9)
    assert abs(speed / ht.swim(robot, CRUISE).speed - 1) > 1e-4


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        ("models.0.spring.link", 0.0, "links behind the head"),
        ("models.0.spring.link", 99.0, "links"),
        ("plant.spring.moment", 0.1, "must be 0 in a twin"),
    ],
)
def test_wrong_hinges_are_refused(core: Host, name: str, value: float, fault: str) -> None:
    robot, _ = swimmer("passive", core)
    image = robot_image(robot)
    sizes = {column: len(numbers) for column, numbers in columns_of(image).items()}
    place = sum([*sizes.values()][: list(sizes).index(name)])
    assert fault in str(Robot.read(with_number(image, place, value), core))
