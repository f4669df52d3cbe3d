"""Rows of the twin's study change one thing each, and what is stored is of the present robot and program."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import influence
import pytest
import study

import hypertuna as ht
from hypertuna.paper.seeds import taken_hash

ROBOT = ht.load("hypertuna")
# Keys that change together with the working limit
LIMITS = {"pressure_work_pa", "pressure_soft_pa", "pressure_hard_pa", "high"}


def leaves(node: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every value of a document by the last name on its way, so that both joints' bore is one thing."""
    if isinstance(node, dict):
        for name, part in node.items():
            yield from leaves(part, name)
    elif isinstance(node, list):
        for part in node:
            yield from leaves(part, key)
    else:
        yield "limit" if key in LIMITS else key, node


def things(robot: ht.Robot, options: dict[str, Any]) -> set[str]:
    """Return what differs from the default robot in closed loop."""
    own, other = (list(leaves(one.document() | {"sources": {}})) for one in (ROBOT, robot))
    assert len(own) == len(other)
    changed = {name for (name, value), (_, new) in zip(own, other, strict=True) if value != new}
    known = options.get("controller_robot", ROBOT)
    assert known is ROBOT or known.controller == ROBOT.controller
    return changed | {name for name in options if name != "controller_robot"}


def test_a_row_changes_one_thing() -> None:
    for label, robot, options in study.robots("lumped"):
        if label in {row.label for row in study.ROWS}:
            assert len(things(robot, dict(options))) <= 1, label


def test_a_row_is_in_closed_loop_unless_its_name_says_otherwise() -> None:
    for label, _, options in study.robots("lumped"):
        assert options.get("closed_loop", True) is (label != "open loop"), label


@pytest.mark.parametrize("kpa", study.LIMITS)
def test_a_limit_is_read_by_the_sensor_and_keeps_its_margins(kpa: float) -> None:
    values = study.limit(kpa)
    work, soft, hard = (values[f"controller.pressure_{name}_pa"] for name in ("work", "soft", "hard"))
    assert (work, soft, hard) == (1e3 * kpa, 1.25e3 * kpa, 1.5e3 * kpa)
    assert values["sensors.pressure.high"] >= hard


@pytest.mark.parametrize("path", [study.STORED, influence.STORED], ids=lambda path: path.name)
def test_what_is_stored_is_of_the_present_robot(path: Any) -> None:
    record = json.loads(path.read_text())
    assert record["taken_hash"] == taken_hash(ROBOT), f"run: {record['command']}"


@pytest.mark.parametrize("water", study.WATERS)
def test_stored_speeds_are_those_of_the_present_program(water: Any) -> None:
    stored = json.loads(study.STORED.read_text())[water]["rows"]
    for label, robot, options in study.robots(water):
        if label in ("default robot", "no limit"):
            runs = study.eight(robot, **options)
            for key, close in (("speed_m_s", 0.01), ("power_w", 0.03)):
                assert [run[key] for run in runs] == pytest.approx(stored[label][key], rel=close), (label, key)
