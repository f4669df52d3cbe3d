"""What the twin and the actuator put into the ledger, and what the page says of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.paper import computed as published_twins
from hypertuna.paper.chapters.actuator import ACTUATOR, PRINTED, Bends, bend_published, step_table
from hypertuna.paper.chapters.actuator import findings as bend_findings
from hypertuna.paper.chapters.twin import bore_table, findings, sections, speed_table, tank_table
from hypertuna.paper.computed import SPEEDS, Twins, run_published
from hypertuna.paper.ledger import judge, published
from hypertuna.reports.html import Picture, Section, Table

PAPER = published()


@pytest.fixture(scope="module")
def bends(tuna: ht.Robot) -> Bends:
    return bend_published(tuna)


@pytest.fixture(scope="module")
def twins(tuna: ht.Robot) -> Twins:
    """Everything, but shorter and at fewer frequencies than in the ledger."""
    posture = PAPER["posture"] | {"frequency_hz": [2.0, 6.0]}
    tank = PAPER["tank"] | {"frequency_hz": [1.0, 6.0]}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(published_twins, "SWIM", 2.0)
        return run_published(tuna, PAPER | {"posture": posture, "tank": tank})


@pytest.fixture(scope="module")
def shown(twins: Twins) -> list[Section]:
    return sections(twins)


def test_bends_are_calibrated_and_how_straight_they_are_was_in_view(bends: Bends) -> None:
    classes = {found.id.rpartition("-")[0] or found.id: found.class_ for found in bend_findings(bends)}
    lines = dict.fromkeys(("bending/linear", "bending/below-250kpa"), "in sight")
    assert classes == {"bending/I": "calibrated", "bending/II": "calibrated"} | lines


@pytest.mark.parametrize(("torque", "verdict"), [(0.1, "violated"), (10.0, "holds")])
def test_servos_have_torque_enough_at_6_hz_or_not(twins: Twins, tuna: ht.Robot, torque: float, verdict: str) -> None:
    document = tuna.document()
    (pump,) = [servo for servo in document["servos"] if servo["drives"] == "piston pump"]
    pump["torque_n_m"] *= torque
    found = list(findings(replace(twins, robot=parse(document))))
    assert [one.id for one in found] == ["servo/torque-6hz-I", "servo/torque-6hz-II"]
    assert {judge(PAPER, one).verdict for one in found} == {verdict}


def test_friction_takes_bend_and_the_printed_equations_have_far_too_much(bends: Bends, tuna: ht.Robot) -> None:
    judged = {(found.id, found.model): judge(PAPER, found) for found in bend_findings(bends)}
    for name in ("I", "II"):
        ours, printed = judged[f"bending/{name}", ACTUATOR], judged[f"bending/{name}", PRINTED]
        free = np.degrees(ht.bend(tuna, name, [250e3], friction=False).angle[0])
        assert ours.computed is not None
        assert 0.7 * free < ours.computed < free
        assert printed.relative_error is not None
        assert printed.relative_error > 1
        assert printed.verdict == "deviates"


def test_steps_lead_from_the_printed_bend_to_the_corrected_one(bends: Bends) -> None:
    rows = step_table(bends).rows
    for k, name in enumerate(bends.steps, start=1):
        assert float(rows[0][k]) == pytest.approx(np.degrees(bends.printed[name].angle[-1]), abs=0.06)
        assert float(rows[-1][k]) == pytest.approx(np.degrees(bends.corrected[name].angle[-1]), abs=0.06)


def test_tables_say_what_the_runs_did(twins: Twins) -> None:
    eight = speed_table(twins)
    assert [row[0] for row in eight.rows] == list(SPEEDS)
    for row in eight.rows:
        assert row[5] == f"{twins.gaits[str(row[0])].speed:.3f}"
    for row, run in zip(tank_table(twins).rows, twins.tank, strict=True):
        for group, told, lag, made in zip(twins.robot.joints, row[1::2], row[2::2], run.first_harmonic, strict=False):
            assert told == f"{np.degrees(made):.1f}"
            assert group.bandwidth is not None
            setpoint = run.gait.amplitude[twins.robot.joints.index(group)]
            left = np.degrees(setpoint) / np.sqrt(1 + (run.gait.frequency / group.bandwidth) ** 2)
            assert lag == f"{left:.1f}"


def test_other_bores_are_told_by_their_errors() -> None:
    speeds = {name: PAPER["values"][f"speed/{name}"]["value"] for name in SPEEDS}
    swing = np.radians([10.0, 20.0])
    exact, fast = ({name: (k * speed, swing, 20.0) for name, speed in speeds.items()} for k in (1.0, 1.1))
    table = bore_table({0.004: exact, 0.005: fast})
    assert [row[:2] for row in table.rows] == [["4 mm", "0.0 %"], ["5 mm", "10.0 %"]]
    assert set(table.rows[1][2:10]) == {"+10 %"}
    assert table.rows[0][-2:] == ["10.0, 20.0", "20.0"]


def test_the_page_shows_what_the_issue_names(shown: list[Section]) -> None:
    parts: list[Any] = [part for section in shown for part in section.parts]
    names = {part.name for part in parts if isinstance(part, Picture)}
    assert {"fig8", "twin-pressures", "twin-amplitude"} <= names
    for part in parts:
        if isinstance(part, Picture):
            assert part.shows.endswith(".")
            assert "<svg" in part.svg
        elif isinstance(part, Table):
            assert all(len(row) == len(part.columns) for row in part.rows)
