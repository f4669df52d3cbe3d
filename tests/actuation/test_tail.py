"""Tails that yield: chains of springs against a beam, and first robots with a passive or a flexible tail."""

import math
import tomllib
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.actuation.tail import RATIO, SEGMENTS, plate_springs
from hypertuna.description.robot import Robot, parse
from hypertuna.swimming.yielding import softness

LENGTH, HEIGHT, THICKNESS, MODULUS = 0.08, 0.1, 1e-3, 2e9
BENDING = MODULUS * HEIGHT * THICKNESS**3 / 12


def tip(segments: int, moment: str) -> float:
    """Deflection of a chain's tip over that of the beam, under a force at the tip or the same load all along."""
    springs = plate_springs([LENGTH / segments] * segments, [HEIGHT] * segments, THICKNESS, MODULUS)
    arm = LENGTH * (1 - np.arange(segments) / segments)
    power, beam = {"force": (1, 1 / 3), "pressure": (2, 1 / 8)}[moment]
    chain = sum(a**power / math.factorial(power) / k * a for a, k in zip(arm, springs, strict=True))
    return float(chain / (beam * LENGTH ** (power + 2) / BENDING))


@pytest.mark.parametrize("segments", [1, 2, 3, 10])
def test_a_force_at_the_tip_bends_a_chain_as_a_beam(segments: int) -> None:
    assert tip(segments, "force") == pytest.approx(1, rel=1e-12)


def test_the_same_load_all_along_bends_a_chain_more_and_less_with_more_segments() -> None:
    """By 1/3, 1/9 and 1/19: for the springs of a force at the tip are too soft for a load nearer the front."""
    off = [tip(segments, "pressure") - 1 for segments in (1, 2, 3)]
    assert off == pytest.approx([1 / 3, 1 / 9, 1 / 19], rel=1e-12)


@pytest.mark.parametrize(("tail", "count"), [("passive", 1), ("flexible", SEGMENTS)])
def test_a_first_robot_with_a_tail_that_yields_swims(tail: str, count: int) -> None:
    """At the stiffness that was asked for, and better than with a rigid tail; with servos too."""
    robot = first(tail)
    (gait,) = robot.gaits.values()
    assert softness(robot, gait.frequency) == pytest.approx(RATIO, rel=0.01)
    beat, rigid = (ht.swim(one, "cruise") for one in (robot, rigid_of(robot)))
    assert (beat.settled, len(beat.bends)) == (True, count)
    assert beat.efficiency > rigid.efficiency
    assert beat.speed > rigid.speed
    assert len(first(tail, actuation="servo").joints) == len(robot.joints) == 1


def first(tail: str, **options: Any) -> Robot:
    """A first robot of a tail."""
    return parse(tomllib.loads(first_robot("x", tail=tail, **options)))


def rigid_of(robot: Robot) -> Robot:
    """The same without hinges."""
    document = {key: value for key, value in robot.document().items() if key not in ("hinge", "hinges")}
    sources = {key: text for key, text in document["sources"].items() if not key.startswith("hinge")}
    return parse(document | {"sources": sources})


def test_a_tail_that_yields_needs_a_joint_ahead() -> None:
    with pytest.raises(ht.InputError, match="--links must be at least 3 with --tail passive"):
        first_robot("x", tail="passive", links=2)


@pytest.mark.parametrize("tail", ["passive", "flexible"])
@pytest.mark.parametrize("names", [["A"], ["A", "B"], ["A", "B", "C"]])
def test_named_joints_share_the_links_ahead_of_the_tail(tail: str, names: list[str]) -> None:
    """None is dropped without a word; four names are one too many for three driven joints."""
    document = tomllib.loads(first_robot("x", tail=tail, links=5, joints=names))
    assert [group["name"] for group in document["joints"]] == names
    assert [link for group in document["joints"] for link in group["links"]] == [1, 2, 3]
    assert len(document["gaits"]["cruise"]["amplitude_deg"]) == len(names)
    with pytest.raises(ht.InputError, match="--joints must be at most 3 different names, a driven joint for each link"):
        first_robot("x", tail=tail, links=5, joints=["A", "B", "C", "D"])


@pytest.mark.parametrize("sizes", [{"links": 11, "length": 0.9}, {"links": 19}, {"lengths": [0.1, 0.1, 0.01]}])
def test_a_fin_that_has_no_room_for_segments_is_refused_by_the_option_that_was_given(sizes: dict[str, Any]) -> None:
    """Each third would be shorter than 2 % of the length, or the links more than 20."""
    key = "--lengths" if "lengths" in sizes else "--links"
    with pytest.raises(ht.InputError, match=f"^{key} must leave the fin .* give fewer and longer links"):
        first_robot("x", tail="flexible", **sizes)
