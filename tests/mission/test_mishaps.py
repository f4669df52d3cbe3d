"""Mishaps: what holds the robot, what its circuits lose, which servo stands."""

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.mission.file import read_mission
from hypertuna.mission.mishaps import split_mishaps
from hypertuna.mission.run import fly_part, mission_start


def test_mishaps_are_parted_from_faults_of_sensors() -> None:
    robot = ht.load("hypertuna")
    texts = ["depth:nan@3", "fins:up@1-2", "servo-II-left:stuck@4", "oil-I-right:lost@5", "body:tethered@6-9"]
    sensors, found = split_mishaps(robot, texts, 0.5)
    assert sensors == ("depth:nan@3",)
    assert found.servos[:2] == [(4, 0.5, 1, 2), (5, 0.5, 1, 2)]
    assert found.servos[2][::2] == (2, 4)
    assert found.oil == [(1, 5, np.inf)]
    assert found.snags.tolist() == [[6, 9, 1]]
    for wrong in ("body:eaten@1", "oil-I-up:lost@1", "servo-III-left:stuck@1", "oil-I-left:nan@1"):
        with pytest.raises(InputError):
            split_mishaps(robot, [wrong], 0.5)


@pytest.mark.parametrize(("fault", "reach"), [("body:held@10", 0.1), ("body:tethered@10", 1.2)])
def test_a_line_holds_the_nose_within_its_length(fault: str, reach: float) -> None:
    start = mission_start(ht.load("hypertuna"), read_mission("box").mission, seed=1, faults=fault)
    place = fly_part(start, 4000)[0]["position"]
    away = np.linalg.norm(place[101:] - place[100], axis=1)
    assert away.max() < reach
    assert np.linalg.norm(place[100] - place[0]) > 1


def test_a_hole_lets_the_pressure_of_its_circuit_out_alone() -> None:
    start = mission_start(ht.load("hypertuna"), read_mission("box").mission, seed=1, faults="oil-I-left:lost@10")
    swing = np.ptp(fly_part(start, 2000)[0]["unit_pressure"][150:], axis=0)
    assert swing[0] < 20e3
    assert (swing[2:] > 100e3).all()
