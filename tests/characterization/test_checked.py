"""Check of a family's chosen design by elements: the same values as the bench, without friction, and what failed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.soft_joint import joint_group, joint_models
from hypertuna.characterization.checked import Checked, check_chosen
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.designs import Design, designs
from hypertuna.characterization.family import Family
from hypertuna.characterization.population import Population
from hypertuna.characterization.problem import computed
from hypertuna.errors import InputError
from hypertuna.fe.joint_map import Joint
from hypertuna.fe.model import FeOptions

BENCH = """joint,side,pressure_kpa,branch,angle_deg,volume_ml,shortening_mm,moment_n_m,force_n,arm_mm
II,left,0,,0.1,,,,,
II,left,150,,22,,1.5,,,
II,left,250,,31,,,,,
II,left,150,unload,25,,,,,
II,right,250,,31,1.2,2.5,,,
II,both,250,,,,5,,,
II,left,250,,,,,0.2,,
II,right,200,,,,,,2.4,80
I,right,250,,18,,,,,
"""
APART = 0.03  # of one section and those described
TURN = 1.1


def by_model(turn: float = 1.0, fails: float = math.inf, solved: list[Any] | None = None) -> Any:
    """The fast model as if by elements, bent `turn` times as far; nothing is found above the pressure `fails`."""

    def of_joint(robot: ht.Robot, joint: int, options: FeOptions) -> Joint:
        model, actuator = joint_models(robot)[joint], joint_group(robot, joint)[1]

        def solve(couple: float, path: Sequence[tuple[float, float]]) -> dict[str, Any]:
            if solved is not None:
                solved.append((joint, couple, path[-1]))
            if max(path[-1]) > fails:
                raise InputError("must be without inverted elements", key="mesh")
            angle = 0.0
            for _ in range(60):  # the moment is couple x cos(angle)
                found = model.balance(path[-1], couple * math.cos(angle))
                angle = float(found["angle"][0])
            length = actuator.length + model["length"] * float(found["strain"][0])
            volume = [7e-6 + volume for volume in found["volume"][0].tolist()]  # oil at rest does not count
            return {"angle": turn * angle, "volume": volume, "length": length, "fault": ""}

        return solve

    return of_joint


@pytest.fixture(scope="module")
def described(tuna: ht.Robot, tmp_path_factory: pytest.TempPathFactory) -> Family:
    """A family of one design, the described one."""
    path = tmp_path_factory.mktemp("checked") / "bench.csv"
    path.write_text(BENCH)
    space = designs(tuna, read_bench(path, tuna), "lever")
    one = Design(tuna, np.array([unknown.described for unknown in space.free]))
    found = np.array([space.elements.of(computed(tuna, space.bench))])
    return Family(space, Population(np.zeros((1, 1)), (one,), (), 1, 1, ()), found, (), (), 0, 0, 0.03, 0.0)


def by(checked: Checked, joint: str, side: str, kind: str, pressure: float = 250) -> dict[str, Any]:
    """Return the loading fact of a place."""
    place = {"joint": joint, "side": side, "kind": kind, "pressure_kpa": pressure, "branch": "load"}
    (fact,) = (fact for fact in checked.facts if place.items() <= fact.items())
    return fact


def test_elements_stand_beside_the_model_without_friction(described: Family) -> None:
    reports: list[tuple[int, int]] = []
    checked = check_chosen(described, solve=by_model(), progress=lambda *of: reports.append(of))
    assert len(checked.facts) == 12
    assert not any(checked.faults)
    assert reports == [(k, 13) for k in range(1, 14)]  # 9 states of free joints from rest, and two couples twice
    for fact in checked.facts:
        if fact["pressure_kpa"]:
            assert fact["elements"] == pytest.approx(fact["without_friction"], rel=APART), fact
            assert fact["elements"] > 0
    rubs = by(checked, "II", "left", "angle")
    assert rubs["chosen"] < 0.99 * rubs["without_friction"]  # rising pressure
    up, down = (fact for fact in checked.facts if (fact["kind"], fact["pressure_kpa"]) == ("angle", 150))
    assert (up["branch"], down["branch"]) == ("load", "unload")
    assert up["without_friction"] == pytest.approx(down["without_friction"])
    assert up["chosen"] < down["chosen"]
    for side, pressure in (("left", 250), ("right", 200)):  # of couple and force, whose joint is a beam
        held = by(checked, "II", side, "moment", pressure)
        assert held["elements"] == pytest.approx(held["without_friction"], rel=1e-6)
    assert math.isnan(by(checked, "II", "left", "angle", 0)["difference_percent"])


def test_elements_that_bend_a_tenth_farther_differ_by_a_tenth(described: Family) -> None:
    checked = check_chosen(described, solve=by_model(TURN))
    exact = check_chosen(described, solve=by_model())
    for joint, side in (("I", "right"), ("II", "left"), ("II", "right")):
        near, far = (by(one, joint, side, "angle") for one in (exact, checked))
        assert far["elements"] == pytest.approx(TURN * near["elements"])
        assert far["difference_percent"] == pytest.approx(100 * (far["without_friction"] / far["elements"] - 1))
    # Where the joint is straight does not depend on how far it bends.
    held = by(checked, "II", "left", "moment")
    assert held["elements"] == pytest.approx(held["without_friction"], rel=1e-6)


def test_a_stronger_joint_is_held_by_a_stronger_couple(described: Family) -> None:
    """Elements whose couple has an effect of four fifths need five fourths of it; the model's is the first guess."""

    def weaker(*joint: Any) -> Joint:
        solve = by_model()(*joint)
        return lambda couple, path: solve(0.8 * couple, path)

    held = by(check_chosen(described, solve=weaker), "II", "left", "moment")
    assert held["elements"] == pytest.approx(held["without_friction"] / 0.8, rel=0.01)
    assert held["difference_percent"] == pytest.approx(-20, abs=1)


def test_what_elements_do_not_reach_is_told_and_not_tried_again(described: Family) -> None:
    solved: list[Any] = []
    checked = check_chosen(described, solve=by_model(fails=160e3, solved=solved))
    reason = "finite elements (mesh must be without inverted elements)"
    assert by(checked, "II", "left", "angle")["fault"] == f"Joint II, left: 250 kPa was not reached by {reason}."
    held = by(checked, "II", "right", "moment", 200)
    assert held["fault"] == f"Joint II, right, held straight: 200 kPa was not reached by {reason}."
    assert math.isnan(held["elements"])
    assert math.isfinite(held["without_friction"])
    assert by(checked, "II", "left", "angle", 150)["fault"] == ""
    high = [(joint, pair) for joint, _, pair in solved if max(pair) > 160e3]
    ways = [(0, (0.0, 250e3)), (1, (0.0, 200e3)), (1, (0.0, 250e3)), (1, (250e3, 0.0)), (1, (250e3, 0.0))]
    assert sorted(high) == [*ways, (1, (250e3, 250e3))]
    solved.clear()
    low = check_chosen(described, solve=by_model(fails=100e3, solved=solved))
    assert by(low, "II", "left", "angle")["fault"].startswith("Joint II, left: 150 kPa was not reached")
    assert (1, 0.0, (250e3, 0.0)) not in solved
