"""Any lengths that `robot new` accepts give a file that every command takes."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.actuation.sizing import size_pump
from hypertuna.description.robot import parse
from hypertuna.description.schema.body import DRIVES
from hypertuna.description.shape import FULL
from hypertuna.description.twin import new_command
from hypertuna.errors import InputError
from hypertuna.firmware.header import header
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.wiring import wiring_of
from hypertuna.mission.file import read_mission
from hypertuna.mission.image import robot_image
from hypertuna.mission.run import mission_start
from hypertuna.simulation.dive import dive
from hypertuna.simulation.posture import posture_test
from hypertuna.swimming.gait import named_gait

Uses = dict[str, Callable[[ht.Robot], object]]


@st.composite
def sizes(draw: st.DrawFn, most: int) -> dict[str, Any]:
    """Lengths, mass and joint groups as they may be asked for: short heads, long ones, thin fish and thick ones."""
    parts = draw(st.lists(st.floats(0.05, 1.0), min_size=2, max_size=8))
    parts[0] *= draw(st.sampled_from([0.2, 1.0, len(parts)]))
    length = draw(st.sampled_from([0.05, 0.2, 0.5, 2.0]))
    lengths = [float(f"{length * part / sum(parts):.3g}") for part in parts]
    groups = draw(st.integers(1, min(len(parts) - 1, most)))
    mass = float(f"{draw(st.sampled_from([0.1, 0.3, 1.0, 3.0])) * FULL * sum(lengths) ** 3:.2g}")
    return {"lengths": lengths, "mass": mass, "joints": [f"J{j}" for j in range(groups)]}


def written(**options: Any) -> ht.Robot:
    """The robot that `robot new` writes; a size that it refuses is no case."""
    try:
        return parse(tomllib.loads(first_robot("fish", **options)))
    except InputError as error:
        if (error.key or "").startswith("--"):  # of an option, not of a key that nobody gave
            assume(False)
        raise


def beats(robot: ht.Robot, count: float) -> float:
    """Duration of a number of beats [s]."""
    return count / named_gait(robot, "cruise").frequency


SWIMS: Uses = {"swim": lambda robot: ht.swim(robot, "cruise"), "image": robot_image}
TWIN: Uses = {
    "twin": lambda robot: ht.twin(robot, "cruise", duration=beats(robot, 2.1)),
    "posture": lambda robot: posture_test(
        robot,
        frequencies=[named_gait(robot, "cruise").frequency],
        angle=[0.5 * (group.bend_max or 0.0) for group in robot.joints],
        duration=beats(robot, 3),
        limits=False,
    ),
}
SEA: Uses = {
    "dive": lambda robot: dive(robot, "cruise", duration=beats(robot, 8.1)),
    "firmware": lambda robot: (header(firmware_table(robot)), wiring_of(robot)),
}


def pumped(robot: ht.Robot) -> None:
    """Size the pump at the robot's gait, unless its oil lines are so narrow that the refusal says so."""
    gait = named_gait(robot, "cruise")
    try:
        size_pump(robot, frequency=[gait.frequency], amplitude=list(gait.amplitude))
    except InputError as error:
        if not (error.key or "").endswith(".line"):
            raise


@pytest.mark.parametrize("actuation", ["none", "servo", "hydraulic"])
@settings(max_examples=8)
@given(data=st.data())
def test_a_written_robot_swims_and_has_a_twin(actuation: str, data: st.DataObject) -> None:
    robot = written(actuation=actuation, **data.draw(sizes(4)))
    more: dict[str, Uses] = {"none": {}, "servo": TWIN, "hydraulic": TWIN | {"pump": pumped}}
    for use in (SWIMS | more[actuation]).values():
        use(robot)


@pytest.mark.parametrize("actuation", ["servo", "hydraulic"])
@settings(max_examples=8)
@given(data=st.data())
def test_a_written_robot_at_sea_dives_and_has_firmware_and_starts_missions(actuation: str, data: st.DataObject) -> None:
    robot = written(actuation=actuation, sea=True, **data.draw(sizes(DRIVES[actuation].on_board)))
    for use in (TWIN | SEA).values():
        use(robot)
    try:
        mission_start(robot, read_mission("box").mission)
    except InputError as error:
        if error.key not in ("water.current_m_s", "guidance.gaits"):  # slower than 5 cm/s, no robot comes home
            raise


def test_a_fish_whose_slow_gait_is_no_slower_has_one_gait() -> None:
    """A head of 7 mm, 2.5 g in all: at half the amplitude it swims 1.4 mm/s, not 0.8."""
    tiny = written(actuation="servo", sea=True, lengths=(0.00714, 0.0429), mass=0.0025)
    assert tiny.guidance is not None
    assert tiny.guidance.gaits == ("cruise",)
    SEA["firmware"](tiny)


@pytest.mark.parametrize("tail", ["driven", "passive", "flexible"])
@pytest.mark.parametrize("joints", [(), ("front", "rear")])
def test_the_command_that_a_refusal_names_keeps_the_tail(tail: str, joints: tuple[str, ...]) -> None:
    fish = written(links=6, tail=tail, joints=joints)
    words = new_command(fish).split()
    given = dict(zip(words[4::2], words[5::2], strict=True))
    lengths = [float(length) for length in given["--lengths"].split(",")]
    again = written(lengths=lengths, joints=given["--joints"].split(","), tail=given.get("--tail", "driven"))
    assert [(group.name, group.links) for group in again.joints] == [(group.name, group.links) for group in fish.joints]
    assert [hinge.link for hinge in again.hinges] == [hinge.link for hinge in fish.hinges]
    assert again.links.length == pytest.approx(fish.links.length, rel=1e-4)


def test_short_heads_carry_their_fins() -> None:
    robot = written(lengths=[0.12, 0.1, 0.1, 0.1], actuation="servo", sea=True)
    assert robot.fins is not None
    assert robot.fins.x < 0.12


@pytest.mark.parametrize("name", ht.robots())
@pytest.mark.parametrize("sea", [False, True])
def test_the_command_that_a_refusal_names_is_accepted(name: str, sea: bool) -> None:
    words = new_command(ht.load(name), sea=sea).split()
    given = dict(zip(words[4::2], words[5::2], strict=False))
    robot = written(
        lengths=[float(length) for length in given["--lengths"].split(",")],
        mass=float(given["--mass"]) if "--mass" in given else None,
        joints=given["--joints"].split(","),
        actuation=given["--actuation"],
        sea=sea,
    )
    ht.twin(robot, "cruise", duration=beats(robot, 2.1))
