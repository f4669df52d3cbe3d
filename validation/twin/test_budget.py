"""The uncertainty budget: its intervals, runs that diverge, what is open beside the family, and what is stored."""

import json
import sys
from functools import partial

import budget
import family
import numpy as np
import pytest

import hypertuna as ht
from hypertuna.paper import studies
from hypertuna.paper.computed import SPEEDS
from hypertuna.paper.seeds import taken_hash

ROBOT = ht.load("hypertuna")
KEYS = ("speed", "power", "pressure", "swing I", "swing II", "cylinder I", "cylinder II")


def numbers(values: list[float]) -> budget.Numbers:
    """Return members whose every number is one value."""
    return {f"{name} {key}": np.array(values) for name in SPEEDS for key in KEYS}


def test_an_interval_is_that_of_equal_weights() -> None:
    values = np.random.default_rng(0).normal(size=2001)
    np.testing.assert_allclose(budget.interval(values), np.percentile(values, (5, 50, 95)), atol=0.01)


def test_members_whose_run_diverged_are_left_out() -> None:
    """Speeds of 1 to 5 m/s; the member without a number in one gait changes no interval."""
    whole, lost = numbers([1.0, 2.0, 3.0, 4.0, 5.0]), numbers([1.0, 2.0, 3.0, 4.0, 5.0, 9.0])
    lost["optimised-max power"][-1] = np.nan
    assert budget.intervals(budget.kept(lost)) == budget.intervals(whole)
    assert budget.intervals(whole)["speed_m_s"]["optimised-max"][1] == 3


def test_the_default_robot_has_its_place_in_the_family() -> None:
    found = budget.standing(numbers([1.0, 2.0, 3.0, 4.0, 5.0]), numbers([2.5]))
    assert found["percentile_power"] == 40  # two of five are below 2.5 W


def test_published_numbers_inside_their_intervals_are_counted() -> None:
    """Eight speeds of 0.3 to 0.582 m/s; both powers are far above."""
    assert budget.intervals(numbers([0.1, 0.2, 0.35, 0.45]))["inside"] == 4  # 0.3 and 0.4 m/s, twice each
    assert budget.intervals(numbers([0.1, 0.2, 0.7]))["inside"] == 8


def test_what_is_open_beside_the_family_changes_body_and_fin_alone() -> None:
    other = budget.opened(ROBOT, np.random.default_rng(3))
    assert 1 < sum(other.links.mass) / sum(ROBOT.links.mass) < 3.3 / 2.687
    assert other.hinge is not None
    assert (other.joints, other.controller, other.servos) == (ROBOT.joints, ROBOT.controller, ROBOT.servos)


def test_a_diverging_run_has_no_numbers() -> None:
    run = ht.twin(ROBOT, "unoptimised-max", duration=1.0, start="swimming", step=0.01)
    assert run.status == "diverged"
    assert np.isnan(list(budget.measured(run).values())).all()


def test_stored_intervals_are_of_the_present_robot_and_family() -> None:
    record = json.loads(budget.FILE.read_text())
    assert record["taken_hash"] == taken_hash(ROBOT), f"run: {record['command']}"
    assert record["family_hash"] == budget.family_hash(), f"run: {record['command']}"
    assert len(record["members"]["lumped"]["speed_m_s"]) == record["draws"] == family.MEMBERS


def test_stored_speeds_of_a_member_are_those_of_the_present_program() -> None:
    """Of the slowest members, too, which controller and pumps hold back: of a changed controller they tell first."""
    stored = json.loads(budget.FILE.read_text())["members"]
    slowest = np.argsort(np.sum(np.array(stored["lumped"]["speed_m_s"], float), axis=1))[:3].tolist()
    places = [0, *slowest]
    robots = [one for k, one in enumerate(budget.members()) if k in places]
    for law, choice in (("lumped", robots), ("strips", [one.using(water="strip") for one in robots])):
        runs = budget.swim(choice, SPEEDS, law, sorted(places))
        for key, word, close in (("speed_m_s", "speed", 0.02), ("power_w", "power", 0.05)):
            expected = np.array([stored[law][key][place] for place in sorted(places)], float)
            np.testing.assert_allclose(budget.eight(runs, word), expected, rtol=close)


@pytest.mark.parametrize("study", ["turns", "lakes", "dives", "phases"])
def test_a_member_that_diverges_has_no_numbers(study: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (studies, sys.modules["hypertuna.simulation.dive"]):
        for name in {"twin", "twin_at_sea"} & vars(module).keys():
            monkeypatch.setattr(module, name, partial(getattr(module, name), step=0.01))
    with pytest.raises(studies.Diverged):
        studies.STUDIES[study].run(ROBOT, 0)


def test_who_diverges_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(robot: ht.Robot, seed: int) -> dict[str, float]:
        if seed == 1:
            raise studies.Diverged
        return {"radius": float(seed)}

    monkeypatch.setitem(studies.STUDIES, "turns", studies.Study(run))
    assert budget.studied([ROBOT] * 3, "turns")["radius"].tolist() == [0, 2]
