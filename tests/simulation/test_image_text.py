"""Text of a robot image: published numbers with the ledger's stored verdicts."""

from typing import Any

import pytest

import hypertuna as ht
from hypertuna.description.changes import changed
from hypertuna.description.robot import parse
from hypertuna.description.shape import ASPECT
from hypertuna.io.files import verdicts
from hypertuna.simulation import image_text
from hypertuna.simulation.image_text import VERDICT, body_text, robot_facts


def published_of(robot: ht.Robot, gait: str) -> dict[str, Any]:
    """Return the published numbers of a gait in the text of a robot's image."""
    (found,) = [one["published"] for one in robot_facts(robot, [robot])["gaits"] if one["name"] == gait]
    return dict(found)


def test_every_published_number_has_the_ledgers_verdicts() -> None:
    fish, entries = ht.load("hypertuna"), verdicts()["entries"]
    seen = 0
    for gait in fish.gaits:
        for fact in published_of(fish, gait).values():
            wanted = [entry for entry in entries if entry["id"] == fact["id"]]
            assert fact["verdicts"] == [
                {part: entry[part] for part in VERDICT} for entry in wanted
            ]  # the note has the band
            seen += len(wanted)
    assert seen == 8 * 7 + 4 + 1 + 5 + 7  # speeds; power and cost of the fastest, power of the lake, radius
    ledger = robot_facts(fish, [fish])["ledger"]
    assert {entry["verdict"] for entry in entries} <= ledger["marks"].keys()
    assert {entry["class"] for entry in entries} == ledger["classes"].keys()
    assert len(set(ledger["marks"].values())) == len(ledger["marks"])  # told apart without color


def test_verdicts_stay_where_another_model_of_the_robot_comes_first() -> None:
    fish = ht.load("hypertuna").using(joints="ideal")
    assert published_of(fish, "unoptimised-max")["speed"]["verdicts"]
    assert robot_facts(fish, [fish])["ledger"]


def test_a_changed_robot_has_the_published_numbers_without_a_verdict() -> None:
    """Verdicts hold for the robot that the ledger computed, and for no other."""
    fish = ht.load("hypertuna")
    heavier = fish.model_copy(update={"body": fish.body.model_copy(update={"mass": 3.5})})
    for other in (heavier, fish.using(areas="as-printed")):
        speed = published_of(other, "unoptimised-max")["speed"]
        assert (speed["value"], speed["verdicts"]) == (0.56, [])
        assert robot_facts(other, [other])["ledger"] is None


def test_verdicts_of_a_changed_description_count_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    stale = verdicts() | {"robot_hash": "0" * 64}
    monkeypatch.setattr(image_text, "verdicts", lambda: stale)
    fish = ht.load("hypertuna")
    assert published_of(fish, "unoptimised-max")["speed"]["verdicts"] == []
    assert robot_facts(fish, [fish])["ledger"] is None


def test_robots_without_published_numbers_have_no_ledger() -> None:
    fish = ht.load("rexeel")
    facts = robot_facts(fish, [fish])
    assert facts["ledger"] is None
    assert not any(gait["published"] for gait in facts["gaits"])


def test_links_without_a_space_are_ellipses_as_high_as_their_area() -> None:
    """The eel's links are as high as their area over their length, and narrower by the usual ratio of fish."""
    eel = ht.load("rexeel")
    assert eel.spatial is None
    for i, link in enumerate(body_text(eel)["links"]):
        height = eel.links.lateral_area[i] / eel.links.length[i]
        assert (link["height"], link["width"]) == pytest.approx((height, ASPECT * height))
        assert (link["length"], link["mass"]) == (eel.links.length[i], eel.links.mass[i])


def test_a_gait_of_another_name_has_no_published_numbers() -> None:
    """Nor has one of the same name with other numbers, nor one of another robot."""
    tuna = ht.load("hypertuna")
    other = changed(tuna, {"gaits.optimised-max.frequency_hz": 5.0})
    document = tuna.document()
    mine = parse(document | {"gaits": document["gaits"] | {"mine": document["gaits"]["optimised-max"]}})
    renamed = parse(document | {"name": "another"})
    assert published_of(tuna, "optimised-max")
    assert not published_of(other, "optimised-max")
    assert not published_of(mine, "mine")
    assert not published_of(renamed, "optimised-max")
