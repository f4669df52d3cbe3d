"""Joint II as a spring: the robots, the search for their best gaits, the verdicts, and what is stored."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from passive_search import Swum, best_of, cheapest, fastest, tuned, with_fin

import hypertuna as ht
from hypertuna.paper.chapters import passive
from hypertuna.paper.chapters.passive import (
    SAME,
    answer_table,
    claim_table,
    fin_table,
    parts_table,
    read_passive,
    sections,
    spring_table,
    stiffness_table,
    verdict,
)
from hypertuna.paper.passive import LAWS, PLACE, PUMP, ROOT, passive_robot
from hypertuna.reports.html import Table


def power_law(rows: tuple[float, ...] = (0.1, 0.2, 0.4, 0.8)) -> Swum:
    """Speeds f A / 10 and costs f^2 A^3 (1 + log(k / 0.3)^2): the cheapest has the largest frequency."""
    frequency, size = (1.0, 2.0, 4.0), (1.0, 2.0)
    row, f, a = np.meshgrid(rows, frequency, size, indexing="ij")
    return Swum(rows, frequency, size, f * a / 10, f**2 * a**3 * (1 + np.log(row / 0.3) ** 2))


def test_the_cheapest_gait_at_a_speed_lies_between_neighbors() -> None:
    found = cheapest(power_law(), 0.5)
    for one, row in zip(found, power_law().rows, strict=True):
        assert one is not None
        assert (one.frequency, one.size) == pytest.approx((4.0, 1.25))
        assert one.cost == pytest.approx(16 * 1.25**3 * (1 + np.log(row / 0.3) ** 2))
    best = best_of(power_law(), 0.5)
    assert best is not None
    assert best.row == 0.4
    assert cheapest(power_law(), 0.9) == [None] * 4
    assert fastest(power_law()).speed == pytest.approx(0.8)


def test_a_gait_without_a_speed_is_none() -> None:
    swum = power_law()
    swum.speed[2], swum.cost[2] = np.nan, np.nan
    found = cheapest(swum, 0.5)
    assert [one is None for one in found] == [False, False, True, False]


def test_the_best_stiffness_is_that_of_a_parabola() -> None:
    found = tuned(power_law(), 0.5)
    assert found is not None
    cost, stiffness, low, high = found
    assert cost == pytest.approx(16 * 1.25**3)
    assert stiffness == pytest.approx(0.3)
    assert low <= high
    assert tuned(power_law(), 0.9) is None


def test_a_passive_robot_is_the_same_fish_with_one_joint(tuna: ht.Robot) -> None:
    robot = passive_robot(tuna, 0.3)
    assert [group.name for group in robot.joints] == ["I"]
    assert robot.links == tuna.links
    assert robot.body.mass == tuna.body.mass
    assert robot.hinge is not None
    assert (robot.hinge.link, robot.hinge.stiffness, robot.hinge.damping) == (ROOT, 0.3, 0.0015)
    counts = [{servo.drives: servo.count for servo in one.servos} for one in (tuna, robot)]
    assert (counts[0][PUMP], counts[1][PUMP]) == (4, 2)


def test_a_stiff_hinge_is_a_tail_whose_joint_ii_stands_still(tuna: ht.Robot) -> None:
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(16,), phase=(0,))
    rigid = ht.Gait.from_degrees(frequency=2, amplitude=(16, 0), phase=(0, 0))
    for law in ("lumped", "strip"):
        fish = tuna.using(water=law)
        stiff = ht.swim(passive_robot(fish, 200.0, relaxation=0.0), gait)
        assert stiff.speed == pytest.approx(ht.swim(fish, rigid).speed, rel=2e-2)


def test_a_fin_of_factors_one_is_the_same_and_others_follow(tuna: ht.Robot) -> None:
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 60))
    fish = tuna.using(water="strip")
    assert ht.swim(with_fin(fish, 1, 1), gait).speed == pytest.approx(ht.swim(fish, gait).speed, rel=1e-12)
    longer, wider = with_fin(fish, 1.4, 1), with_fin(fish, 1, 1.4)
    assert longer.water.strip is not None
    assert wider.water.strip is not None
    assert longer.links.lateral_area[-1] == pytest.approx(wider.links.lateral_area[-1])
    assert longer.water.strip.edge_height == pytest.approx(0.224)
    assert (longer.water.strip.edge_aspect, wider.water.strip.edge_aspect) == pytest.approx((7, 5 / 1.4))
    # The fin is all that its link adds: kappa rho pi/4 c^2 b over rho pi/4 h^2 l.
    for robot, span, chord in ((longer, 1.4, 1.0), (wider, 1.0, 1.4)):
        strip, links = robot.water.strip, robot.links
        assert strip is not None
        added = strip.edge_added_mass * (0.032 * chord) ** 2 * 0.16 * span
        assert strip.added_mass_normal[-1] * links.lateral_area[-1] ** 2 / links.length[-1] == pytest.approx(
            added, rel=5e-3
        )
        assert links.mass[-1] == pytest.approx(1.4 * fish.links.mass[-1])


def made_up(changes: dict[str, tuple[float, ...]]) -> dict[str, Any]:
    """A record whose members change the cost at 0.3 m/s by percentages."""

    def member(percent: float) -> dict[str, Any]:
        return {"active": {"0.3": {"cost": 10.0}}, "passive": {"0.3": {"cost": 10.0 + percent / 10}}}

    return {"family": {law: {f"{k}": member(one) for k, one in enumerate(values)} for law, values in changes.items()}}


@pytest.mark.parametrize(
    ("lumped", "strip", "said"),
    [
        ((-40, -30, -20), (-30, -20, -10), "passive is cheaper"),
        ((10, 20, 30), (5, 6, 7), "passive is dearer"),
        ((-40, -30, -20), (-30, -20, 10), "not decided"),
        ((-40, -30, -20), (10, 20, 30), "not decided"),
        ((-40, -30, -20), (), "not decided"),
        ((), (), "not reached"),
    ],
)
def test_a_band_that_crosses_none_decides_nothing(lumped: Any, strip: Any, said: str) -> None:
    assert verdict(made_up({"lumped": lumped, "strip": strip}), "0.3") == said


def test_what_is_stored_is_swum_again(tuna: ht.Robot) -> None:
    found = read_passive(tuna)
    assert found.reason == ""
    assert 0 < found.gap < SAME
    record = found.record
    for law in LAWS:
        case = record["mechanical"][law]["root of the fin, no damping, joint I without lag"]
        assert case["exponent"] == pytest.approx(2, abs=0.05)  # by similarity
        assert record["mechanical"][law][PLACE]["exponent"] > case["exponent"]
    makers = answer_table, parts_table, spring_table, stiffness_table, fin_table, claim_table
    tables = [make(record) for make in makers]
    for table in tables:
        assert all(len(row) == len(table.columns) for row in table.rows)
    shown = [part for section in sections(found) for part in section.parts if isinstance(part, Table)]
    assert [table.rows for table in shown] == [table.rows for table in tables]


def test_another_robot_or_gaits_that_swim_otherwise_are_told(tuna: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    other = read_passive(tuna.using(water="strip"))
    assert "stale" in other.reason
    assert not other.record
    (section,) = sections(other)
    assert "Nothing is shown: stale" in str(section.parts[0])
    monkeypatch.setattr(passive, "SAME", 0.0)
    assert "swim up to" in read_passive(tuna).reason
