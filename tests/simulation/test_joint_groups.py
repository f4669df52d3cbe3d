"""Robots with more joint groups than a twin takes: they swim, their image has no twin, and what needs one says why."""

import json
import re
import struct
import tomllib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import parse
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.wiring import wiring_of
from hypertuna.learning.environments import SwimmerEnv
from hypertuna.learning.spans import span_of
from hypertuna.mission.image import robot_image
from hypertuna.simulation.posture import posture_test

MOST = _core.MAX_JOINTS


def fish(groups: int, actuation: str = "servo") -> ht.Robot:
    """A first robot with as many joint groups."""
    return parse(tomllib.loads(first_robot("fish", links=groups + 1, actuation=actuation)))


def text_of(image: bytes) -> dict[str, Any]:
    """The text of a robot image."""
    count, names, text, _ = struct.unpack_from("<4I", image, 16)
    start = 32 + 12 * count + names
    told: dict[str, Any] = json.loads(image[start : start + text])
    return told


@pytest.mark.parametrize("actuation", ["servo", "hydraulic"])
def test_an_image_has_a_twin_up_to_as_many_groups_as_the_core_takes(actuation: str) -> None:
    for groups, reason in {
        MOST: "",
        MOST + 1: f"it has {MOST + 1} joint groups, and the twin takes at most {MOST}",
    }.items():
        image = robot_image(fish(groups, actuation))
        told = text_of(image)
        assert (told["no_twin"], told["twin"] is None) == (reason, bool(reason))
        assert (b"plant.share" in image) is (not reason)
    assert text_of(robot_image(fish(2, "none")))["no_twin"] == "its file has no controller"


@pytest.mark.parametrize(
    "use",
    [
        lambda robot: ht.twin(robot, "cruise", duration=1.0),
        lambda robot: ht.twin_at_sea(robot, "cruise", duration=1.0),
        lambda robot: posture_test(robot, frequencies=[2.0], angle=[0.01] * (MOST + 1), duration=2.0),
        span_of,
    ],
    ids=["twin", "twin_at_sea", "posture_test", "learning"],
)
@pytest.mark.parametrize("actuation", ["none", "servo", "hydraulic"])
def test_what_needs_a_twin_names_the_rule_and_a_file_that_has_one(
    use: Callable[[ht.Robot], object], actuation: str
) -> None:
    with pytest.raises(ht.InputError) as caught:
        use(fish(MOST + 1, actuation))
    error = caught.value
    assert (error.key, error.value) == ("joints", f"{MOST + 1}")
    assert error.rule == f"must be at most {MOST} groups for the twin"
    assert re.search(r"--joints J1,J2,.*,J12( |$)", error.fix or "")


@pytest.mark.parametrize(("actuation", "groups"), [("servo", 4), ("hydraulic", 3)])
def test_firmware_names_its_own_bound_and_a_file_that_it_takes(actuation: str, groups: int) -> None:
    """Its messages have room for four joint groups."""
    for use in (firmware_table, wiring_of):
        with pytest.raises(ht.InputError) as caught:
            use(fish(5, actuation))
        error = caught.value
        assert (error.key, error.rule, error.value) == ("joints", "must be at most 4 groups for the firmware", "5")
        assert f"--joints {','.join(f'J{j + 1}' for j in range(groups))} " in (error.fix or "")


@pytest.mark.parametrize("sea", [False, True], ids=["plane", "sea"])
@pytest.mark.parametrize("actuation", ["servo", "hydraulic"])
def test_the_longest_tails_swim_in_the_twin(actuation: str, sea: bool) -> None:
    """With oil their silicones' viscosity asks for steps of its own: without them these tails break at once."""
    robot = parse(tomllib.loads(first_robot("eel", links=MOST + 1, actuation=actuation, length=1.0, sea=sea)))
    run = (ht.twin_at_sea if sea else ht.twin)(robot, "cruise", duration=1.0)
    assert run.status == "completed"
    assert run.dataset()["angle"].shape == (100, MOST)


def test_an_eel_of_ten_joints_is_an_environment() -> None:
    eel = fish(10)
    env = SwimmerEnv("Swim", robot=eel)
    assert env.action_space.shape == (1 + 10 + 9 + 10,)
    env.reset(seed=1)
    observation, *_ = env.step(np.zeros(30, np.float32))
    assert np.isfinite(observation).all()
