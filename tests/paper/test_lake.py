"""The ledger's lake: what is made of a flight, and that a stored one counts for its own robot and mission alone."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.mission.file import read_mission
from hypertuna.mission.flight import Flight
from hypertuna.paper.chapters import lake as reproduce_lake
from hypertuna.paper.chapters.lake import STORED, Lake, findings, lake_record, read_lake, sections
from hypertuna.paper.ledger import judge, published
from hypertuna.reports.html import Picture
from voyage import voyage


@pytest.fixture(scope="module")
def record(tuna: ht.Robot) -> dict[str, object]:
    """80 m of way in 267 s at 0.3 m/s, then at rest to 1860 s; mean power 8 + 4/pi W."""
    told = voyage(1860, 5)
    data = dict(told.data) | {"power": 0 * told.time + 18.0, "energy": 20.0 * told.time}
    return lake_record(Flight(read_mission("lake"), tuna, 0, replace(told, data=data), "done"))


def test_the_first_thirty_minutes_count(record: dict[str, object]) -> None:
    assert record["seconds"] == 1800
    assert record["distance_m"] == pytest.approx(80, abs=1)
    assert record["servo_energy_wh"] == pytest.approx(9.0)
    assert record["battery_energy_wh"] == pytest.approx(10.0)
    assert record["whole"]["duration_s"] == pytest.approx(1859.8)  # type: ignore[index]


def test_the_mission_proves_nothing_where_it_agrees(record: dict[str, object]) -> None:
    way, energy = (judge(published(), found) for found in findings(Lake(record | {"distance_m": 730.0})))
    assert (way.id, way.class_, way.verdict) == ("lake/distance", "input", "agrees")
    assert (energy.id, energy.class_, energy.verdict) == ("lake/energy", "in sight", "agrees")
    assert "the battery gives 10 Wh" in energy.note
    (way, _) = (judge(published(), found) for found in findings(Lake(record | {"distance_m": 670.0})))
    assert way.verdict == "deviates"
    _, picture, text = sections(Lake(record | {"distance_m": 670.0}))[0].parts
    assert isinstance(picture, Picture)
    assert "fence" in picture.svg
    assert "In the first 30 min it covers 670 m" in str(text)


def test_what_was_stored_of_another_robot_does_not_count(
    record: dict[str, object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "missions").mkdir()
    monkeypatch.setattr(reproduce_lake, "shipped", lambda _: tmp_path)
    assert "no flight is stored" in read_lake().reason
    (tmp_path / STORED).write_text(json.dumps(record))
    assert read_lake().record is not None
    (tmp_path / STORED).write_text(json.dumps(record | {"robot_hash": "0"}))
    stale = read_lake()
    assert "has changed since the stored flight; validation/missions/lake.py flies it again" in stale.reason
    assert {judge(published(), found).verdict for found in findings(stale)} == {"not-computed"}
    assert "The mission is not available" in str(sections(stale)[0].parts[-1])
