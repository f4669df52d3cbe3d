"""The shipped missions: their stored flights are nine tenths done, and those of the present robot and files."""

import csv
import json
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.mission.file import missions, read_mission
from hypertuna.mission.flight import fly, outcome

FOLDER = Path(__file__).parents[2] / "validation" / "missions"


def flown(mission: str) -> list[dict[str, str]]:
    """Return the rows of a mission, one per seed."""
    return list(csv.DictReader((FOLDER / f"{mission}-seeds.csv").read_text().splitlines()))


def facts(mission: str) -> dict[str, str]:
    """Return what made them."""
    return dict(json.loads((FOLDER / f"{mission}-seeds.csv.json").read_text()))


@pytest.mark.parametrize("mission", missions())
def test_nine_of_ten_flights_of_a_shipped_mission_are_done(mission: str) -> None:
    flights = flown(mission)
    assert [int(flight["seed"]) for flight in flights] == [*range(1, 33)]
    assert sum(flight["status"] == "done" for flight in flights) >= 0.9 * len(flights)
    assert facts(mission)["mission_hash"] == read_mission(mission).hash
    assert facts(mission)["robot_hash"] == facts("box")["robot_hash"]


def test_the_stored_flights_are_those_of_the_present_robot() -> None:
    """Seed 1 of the box, flown again: to 3 %, as processors differ."""
    again, (stored, *_) = outcome(fly("box", "hypertuna", seed=1)), flown("box")
    assert again.status == stored["status"]
    assert again.duration == pytest.approx(float(stored["duration_s"]), rel=0.03)
    assert again.energy / 3600 == pytest.approx(float(stored["energy_wh"]), rel=0.03)


def test_the_pilot_knows_the_speeds_and_the_power_of_the_twin() -> None:
    """The table of gaits is that of the twin: else every estimate of time, current and charge is off by as much."""
    robot = ht.load("hypertuna")
    assert robot.guidance is not None
    assert robot.guidance.speed is not None
    runs = [ht.twin(robot, gait, duration=20) for gait in robot.guidance.gaits]
    assert [run.speed for run in runs] == pytest.approx(robot.guidance.speed, rel=0.02)
    strongest = max(run.electrical_power for run in runs)
    assert strongest < robot.guidance.power < 1.2 * strongest
