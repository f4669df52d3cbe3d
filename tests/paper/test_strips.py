"""Strips in the ledger: what is fitted, what is predicted, and the study in validation/hydrodynamics."""

import json
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.paper.chapters.strips import CHAPTER, IN_TWIN, Strips, findings, sections
from hypertuna.paper.computed import OURS, SPEEDS, STRIPS, try_robot
from hypertuna.paper.ledger import Finding, published, published_value
from hypertuna.swimming.gait import named_gait

STUDY = Path(__file__).parents[2] / "validation" / "hydrodynamics" / "results.json"
FISH = ht.load("hypertuna")


@pytest.fixture(scope="module")
def strips() -> Strips:
    return CHAPTER.compute({OURS: try_robot(FISH.using(joints="bandwidth"), published())}, False, lambda: None)


@pytest.fixture(scope="module")
def found(strips: Strips) -> dict[tuple[str, str], Finding]:
    return {(one.id, one.model): one for one in findings(strips)}


def test_two_numbers_are_fitted_and_four_speeds_are_not(strips: Strips, found: dict[tuple[str, str], Finding]) -> None:
    assert [free.name for free in strips.fit.free] == ["water.strip.blunt_area[0]", "joints.bandwidth[0-1]"]
    water = strips.trial.robot.water.strip
    assert water is not None
    assert (water.blunt_area[0], strips.trial.robot.joints[0].bandwidth) == pytest.approx(strips.values, rel=1e-12)
    for model in (STRIPS, IN_TWIN):
        classes = [found[f"speed/{name}", model].class_ for name in SPEEDS]
        assert classes == ["fitted"] * 4 + ["prediction"] * 3 + ["fitted"]  # the last is almost the fourth gait
    swim = ht.swim(strips.trial.robot, named_gait(strips.trial.robot, "optimised-0.5"))
    assert found["speed/optimised-0.5", STRIPS].computed == swim.speed


def test_the_form_drag_of_the_robots_file_is_the_fit(strips: Strips) -> None:
    assert FISH.water.strip is not None
    assert FISH.water.strip.blunt_area[0] == pytest.approx(strips.values[0], rel=0.03)


def test_straight_tow() -> None:
    # Power 1/2 rho (sum C_t S + C_D A) U^3 with the areas of Table II; the efficiency is it over mechanical power.
    robot = FISH.using(water="strip")
    water, swim = robot.water.strip, ht.swim(robot, named_gait(robot, "unoptimised-0.5"))
    assert water is not None
    area = np.dot(water.drag_tangential, robot.links.wetted_area) + sum(water.blunt_area)
    assert swim.efficiency * swim.mechanical_power == pytest.approx(0.5 * 1000 * area * swim.speed**3, rel=1e-9)
    lumped = np.dot(FISH.water.lumped.friction, robot.links.wetted_area)  # type: ignore[union-attr]  # the robot has the table
    friction = np.dot(water.drag_tangential, robot.links.wetted_area)
    assert 500 * np.array([lumped, friction, area]) == pytest.approx([3.8, 0.48, 4.9], rel=0.02)  # docs/model.md, kg/m


def test_the_study_is_that_of_the_shipped_robot(strips: Strips) -> None:
    stored = json.loads(STUDY.read_text())
    assert stored["gaits"] == list(SPEEDS)
    result = stored["results"]["as in the file"]
    assert (result["blunt_area"], result["bandwidth"]) == pytest.approx(strips.values, rel=0.005)
    speeds = [strips.trial.gaits[name].speed for name in SPEEDS]
    assert result["speeds"] == pytest.approx(speeds, rel=0.005)
    truth = np.array([published_value(f"speed/{name}") for name in SPEEDS])
    names = ("as in the file", "no shedding")
    errors = {name: np.array(stored["results"][name]["speeds"]) / truth - 1 for name in names}
    four, eight = errors["as in the file"][4:], errors["as in the file"]
    assert [round(100 * float(np.sqrt(np.mean(e**2))), 1) for e in (four, eight)] == [5.9, 4.2]  # docs/model.md
    assert float(np.sqrt(np.mean(errors["no shedding"] ** 2))) > 2 * float(np.sqrt(np.mean(eight**2)))


def test_strips_answer_what_the_paper_says_of_the_tank_and_of_table_iv(found: dict[tuple[str, str], Finding]) -> None:
    """Best phases, trends, optima, turns, a start from rest, and powers in the twin."""
    asked = [key for key in published()["values"] if key.startswith(("optimum/", "optimal-phase/", "turning/"))]
    asked += ["cost-of-transport/cheapest-hz", "cost-of-transport/cheapest-phase", "start/steady"]
    asked += ["speed/over-frequency", "speed/over-amplitude", "speed/slows", "cost-of-transport/over-amplitude"]
    assert {key for key in asked if (key, STRIPS) not in found} == set()
    assert {f"power/{name}" for name in ("fastest", "lake") if (f"power/{name}", IN_TWIN) in found} == {
        "power/fastest",
        "power/lake",
    }


def test_the_page_shows_both_models(strips: Strips) -> None:
    (section,) = sections(strips)
    assert "strips" in section.title
