"""Numbers over seeds: what is stored is that of the shipped robots and of this program, and what is stale says so."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.paper import seeds
from hypertuna.paper.chapters.seeds import findings
from hypertuna.paper.computed import SPEEDS, TWIN
from hypertuna.paper.ledger import Entry, judge, published
from hypertuna.paper.seeds import SEEDS, Stored, all_seeds, compute_seeds, read_seeds, taken_hash
from hypertuna.paper.studies import STUDIES, Study, dives, postures

PAPER = published()


@pytest.fixture(scope="module")
def studies() -> dict[str, Stored]:
    return all_seeds()


@pytest.fixture(scope="module")
def entries(studies: dict[str, Stored]) -> dict[tuple[str, str], Entry]:
    return {(found.id, found.model): judge(PAPER, found) for found in findings(studies)}


def test_what_is_stored_belongs_to_the_shipped_robots(studies: dict[str, Stored]) -> None:
    for study, stored in studies.items():
        assert stored.record is not None, f"python -m hypertuna.paper.seeds {study}: {stored.reason}"
        assert stored.record["robot"] == "hypertuna"
        assert stored.record["seeds"] == list(range(32))
        for key in ("command", "hypertuna_version", "isa", "robot_hash"):
            assert stored.record[key]
        assert all(values.shape == (32,) for values in stored.numbers.values())


@pytest.mark.parametrize("run", [postures, dives])
def test_a_seed_computed_anew_is_the_stored_one(run: object, studies: dict[str, Stored]) -> None:
    # The hash of the robot knows nothing of a change of the program: a seed of the quick studies does.
    (study,) = [name for name, one in STUDIES.items() if one.run is run]
    numbers = STUDIES[study].run(ht.load("hypertuna"), 3)
    for name, values in studies[study].numbers.items():
        assert numbers[name] == pytest.approx(values[3], rel=0.01, abs=0.05), name


def test_numbers_follow_from_the_stored_ones(entries: dict[tuple[str, str], Entry], studies: dict[str, Stored]) -> None:
    numbers = studies["swims"].numbers
    for gait in SPEEDS:
        assert entries[f"speed/{gait}", TWIN].computed == np.sort(numbers[f"{gait} speed"])[15]
    cost = numbers["unoptimised-0.4 power"] / (3.3 * numbers["unoptimised-0.4 speed"])  # Eq. 38 with the mass
    after = numbers["optimised-0.4 power"] / (3.3 * numbers["optimised-0.4 speed"])
    change = entries["cost-of-transport/change-0.4", TWIN]
    assert change.computed == pytest.approx(np.sort(100 * (after / cost - 1))[15])
    assert entries["pressure/lowest", TWIN].computed < 0  # type: ignore[operator]  # a stored number


def test_settling_is_judged_as_a_bound_by_the_sensor(entries: dict[tuple[str, str], Entry]) -> None:
    for hertz in PAPER["posture"]["frequency_hz"]:
        for model in (TWIN, f"{TWIN}, by the true bend"):
            entry = entries[f"control/settling-{hertz:g}hz", model]
            assert (entry.bound, entry.published_text, entry.class_) == ("≤", "≤ 4 s", "calibrated")
            assert entry.seeds is not None
            assert entry.verdict == ("holds" if entry.seeds.passed >= 0.9 * 32 else "violated")


def test_what_is_stale_says_so_and_counts_for_nothing(
    studies: dict[str, Stored], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(seeds, "shipped", lambda _: tmp_path)
    fish = ht.load("hypertuna")
    assert "no seeds of hypertuna are stored" in read_seeds("dives", fish).reason
    path = tmp_path / "dives-hypertuna.json"
    record = dict(studies["dives"].record or {})
    path.write_text(json.dumps(record))
    assert read_seeds("dives", fish).record == record
    path.write_text(json.dumps(record | {"taken_hash": "of another robot"}))
    stale = read_seeds("dives", fish)
    assert stale.reason.startswith("stale: hypertuna has changed since its seeds were stored")
    told = [found for found in findings(studies | {"dives": stale}) if found.id.startswith("diving")]
    entries = {found.id: judge(PAPER, found) for found in told if found.model == TWIN}
    assert set(entries) == {"diving/depth-rate", "diving/pitch-span"}
    assert {(entry.computed, entry.verdict, entry.note) for entry in entries.values()} == {
        (None, "not-computed", stale.reason)
    }


def test_every_study_that_is_missing_leaves_its_numbers_to_come(studies: dict[str, Stored]) -> None:
    missing = {key: replace(stored, record=None, reason="none") for key, stored in studies.items()}
    assert {judge(PAPER, found).verdict for found in findings(missing)} == {"not-computed"}


def test_only_what_the_twin_takes_makes_seeds_stale() -> None:
    fish = ht.load("hypertuna")
    document = fish.document()
    document["water"]["strip"]["drag_normal"] = [2.0] * 8  # of a law that the twin of this robot does not use
    assert taken_hash(parse(document)) == taken_hash(fish) != fish.hash
    depth = next(part for part in document["sensors"] if part["measures"] == "depth")  # only the pilot reads it
    depth["noise"] *= 2
    assert taken_hash(parse(document)) == taken_hash(fish)
    document["controller"]["learning"] *= 0.9
    assert taken_hash(parse(document)) != taken_hash(fish)


def test_what_is_computed_is_stored_with_what_made_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seeds, "shipped", lambda _: tmp_path)
    monkeypatch.setitem(STUDIES, "lots", Study(lambda robot, seed: {"number": seed + 1 / 3}, ("hypertuna",)))
    fish = ht.load("hypertuna")
    made = compute_seeds("lots", fish)
    assert made.record == read_seeds("lots", fish).record
    assert made.numbers["number"] == pytest.approx([seed + 1 / 3 for seed in SEEDS], rel=1e-5)
    found = made.finding("lake/speed", TWIN, "prediction", made.numbers["number"], "a note")
    assert found.computed == pytest.approx(15 + 1 / 3, rel=1e-5)
