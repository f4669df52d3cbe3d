"""The family in the ledger: what its range does to a verdict, and what it is of."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array
from hypertuna.paper.chapters import budget
from hypertuna.paper.chapters.budget import TABLES, Budget, bands, read_budget, sections
from hypertuna.paper.chapters.posterior import findings as fitted_findings
from hypertuna.paper.chapters.posterior import read_posterior
from hypertuna.paper.chapters.seeds import swim_findings
from hypertuna.paper.computed import SPEEDS, STRIPS, TWIN
from hypertuna.paper.ledger import FAST, UNPUBLISHED, Finding, fast, judge, published, published_value
from hypertuna.paper.seeds import Stored, taken_hash
from hypertuna.paper.studies import swim_gaits

PAPER = published()
MEMBERS = 6


@pytest.fixture(scope="module")
def numbers(tuna: ht.Robot) -> dict[str, Array]:
    """Make up six members: speeds from 0.1 m/s, powers from 5 W, each member with more of both than the last."""
    part = np.linspace(1, 2, MEMBERS)
    made: dict[str, Array] = {}
    for k, name in enumerate(swim_gaits(tuna)):
        made |= {f"{name} speed": (0.1 + 0.01 * k) * part, f"{name} power": (5.0 + k) * part**3}
        made |= {f"{name} pressure": -10.0 * part, f"{name} swing I": part, f"{name} swing II": part}
    return made


@pytest.fixture
def record(tuna: ht.Robot, numbers: dict[str, Array]) -> dict[str, Any]:
    """Make the file that validation/twin/budget.py writes of them."""

    def of(what: str) -> dict[str, list[float]]:
        return {name: np.percentile(numbers[f"{name} {what}"], (5, 50, 95)).tolist() for name in SPEEDS}

    made = {"taken_hash": taken_hash(tuna), "interval_percent": [5.0, 95.0], "draws": MEMBERS}
    made |= {"speed_m_s": of("speed"), "power_w": of("power"), "entries": bands(tuna, {"swims": numbers})}
    shipped = {"rms_percent": 40.0, "percentile_rms": 50.0, "percentile_power": 50.0}
    return made | {"rms_percent": [20.0, 40.0, 60.0], "shipped": shipped}


@pytest.fixture
def store(record: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Put it in the place of the stored one."""
    monkeypatch.setattr(budget, "shipped", lambda _: tmp_path)
    path = tmp_path / "budget.json"
    path.write_text(json.dumps(record))
    return path


@pytest.mark.parametrize(
    ("key", "computed", "band", "verdict"),
    [
        # 0.56 m/s within 5 %: all of the family; a part of it; the twin alone; the family alone; neither
        ("speed/unoptimised-max", 0.55, (0.54, 0.58), "reproduced"),
        ("speed/unoptimised-max", 0.55, (0.30, 0.58), "undetermined"),
        ("speed/unoptimised-max", 0.55, (0.40, 0.55), "undetermined"),
        ("speed/unoptimised-max", 0.40, (0.30, 0.58), "undetermined"),
        ("speed/unoptimised-max", 0.40, (0.30, 0.55), "deviates"),
        ("speed/unoptimised-max", 0.70, (0.60, 0.80), "deviates"),
        ("speed/optimised-0.4", 0.30, (0.20, 0.45), "undetermined"),
        # at 2 and 3 Hz the twin is judged as if everything were known
        ("speed/optimised-0.3", 0.31, (0.29, 0.32), "reproduced"),
        ("speed/optimised-0.3", 0.31, (0.20, 0.32), "undetermined"),
        ("speed/optimised-0.3", 0.20, (0.20, 0.40), "deviates"),
        ("speed/unoptimised-0.4", 0.30, (0.20, 0.50), "deviates"),
        # bounds
        ("power/bound-0.3", 13.0, (12.5, 15.0), "holds"),
        ("power/bound-0.3", 13.0, (11.0, 15.0), "undetermined"),
        ("power/bound-0.3", 11.0, (10.0, 15.0), "violated"),
        ("power/bound-0.5", 11.0, (10.0, 25.0), "undetermined"),
        ("power/bound-0.5", 11.0, (10.0, 19.0), "violated"),
        # points of a grid, and what the paper contradicts itself
        ("cost-of-transport/cheapest-hz", 2.0, (1.0, 6.0), "undetermined"),
        ("cost-of-transport/cheapest-hz", 2.0, (1.0, 5.0), "deviates"),
        ("range/battery", 4.0, (3.0, 6.0), "contradicted"),
    ],
)
def test_a_range_opens_a_verdict_and_closes_it(
    key: str, computed: float, band: tuple[float, float], verdict: str
) -> None:
    entry = judge(PAPER, Finding(key, TWIN, "prediction", computed, band=band))
    assert entry.verdict == verdict
    assert bool(entry.why) == (verdict == "undetermined")
    assert entry.band_text == f"{band[0]:.3g} to {band[1]:.3g}"


def test_only_what_swims_at_4_75_hz_and_more_is_excused(tuna: ht.Robot) -> None:
    """Of every gait with a published number of its own."""
    gaits = {f"speed/{name}": name for name in SPEEDS} | {key: name for key, (_, name) in TABLES.items()}
    for key, name in gaits.items():
        assert fast(key) == (tuna.gaits[name].frequency >= 4.75), key
        missed = judge(PAPER, Finding(key, TWIN, "prediction", 0.0, band=(0.0, 1e3)))
        assert missed.verdict == ("undetermined" if fast(key) else "violated" if missed.bound else "deviates")
        assert missed.why == (UNPUBLISHED if fast(key) else "")
    for pattern in FAST:  # each is for something
        assert any(fast(key) for key in PAPER["values"]), pattern


def test_bounds_of_power_are_the_lowest_cost_at_the_speeds_of_the_tested_gaits() -> None:
    cost = published_value("cost-of-transport/minimum") * 3.3  # J/m, Table I
    for speed in (0.3, 0.4, 0.5):
        assert published_value(f"power/bound-{speed}") == round(cost * speed, 1)
        assert judge(PAPER, Finding(f"power/bound-{speed}", TWIN, "calibrated", cost * speed)).verdict == "holds"


def test_every_number_of_the_twin_s_swims_has_its_range(store: Path, tuna: ht.Robot, numbers: dict[str, Array]) -> None:
    found = list(swim_findings(Stored("swims", tuna, {"numbers": numbers})))
    entries = {one.id: judge(PAPER, one) for one in read_budget(tuna).judged(found)}
    assert len(entries) == len(found) > 20
    for key, entry in entries.items():
        assert entry.band is not None, key
        assert entry.band[0] <= entry.band[1]
    last = 13  # gait of the tank tests at 6 Hz; the members' costs are as 1 to 4
    cheapest = min((5 + k) / (0.1 + 0.01 * k) for k in range(last + 1)) / 3.3
    assert entries["cost-of-transport/minimum"].band == pytest.approx((cheapest, 4 * cheapest))
    assert entries["pressure/lowest"].band == (-20, -10)
    speeds = np.linspace(0.1, 0.2, MEMBERS)
    assert entries["speed/unoptimised-0.3"].band == pytest.approx(np.percentile(speeds, (5, 95)))


def test_other_models_have_no_range_unless_it_was_computed(store: Path, tuna: ht.Robot) -> None:
    key, model = "speed/unoptimised-max", f"{STRIPS}, {TWIN}"
    (one,) = read_budget(tuna).judged([Finding(key, model, "prediction", 0.3)])
    assert one.band is None
    record = json.loads(store.read_text())
    record["entries"][f"{key} | {model}"] = [0.2, 0.3, 0.6]
    store.write_text(json.dumps(record))
    (one,) = read_budget(tuna).judged([Finding(key, model, "prediction", 0.3)])
    assert (one.band, judge(PAPER, one).verdict) == ((0.2, 0.6), "undetermined")


def test_turns_and_dives_have_ranges_of_the_members_that_ran_them(tuna: ht.Robot) -> None:
    phases = PAPER["turning"]["phase_deg"]
    others = {"radius": 0.8, "speed": 0.1}  # BL, m/s
    turned = {f"{phase:g} deg {what}": np.full(4, value) for phase in phases for what, value in others.items()}
    best = published_value("turning/best-phase")
    turned[f"{best:g} deg radius"] = np.array([0.2, 0.3, 0.4, 0.9])  # tighter than at other phases but for the last
    dived = {f"{leg} {what}": np.full(4, 5.0) for leg in ("down", "up") for what in ("rate", "pitch", "pitch range")}
    found = bands(tuna, {"turns": turned, "dives": dived})
    assert found[f"turning/radius-bl | {TWIN}"] == [0.2, 0.3, 0.9]
    assert found[f"turning/best-phase | {TWIN}"][0] == min(phases)
    assert found[f"diving/depth-rate | {TWIN}"] == [5.0, 5.0, 5.0]


def test_a_range_of_another_robot_counts_for_nothing(store: Path, tuna: ht.Robot) -> None:
    found = [
        Finding("speed/unoptimised-max", TWIN, "prediction", 0.55),
        Finding("pressure/lowest", TWIN, "in sight", -10.0),
        Finding("turning/radius-bl", TWIN, "prediction", 0.47),  # no member of the family was turned
    ]
    store.write_text(json.dumps(json.loads(store.read_text()) | {"taken_hash": "of another robot"}))
    read = read_budget(tuna)
    assert read.reason.startswith(f"stale: {tuna.name} or its family has changed since the budget was stored")
    verdicts = [judge(PAPER, one) for one in read.judged(found)]
    assert [one.verdict for one in verdicts] == ["not-computed", "not-computed", "reproduced"]
    assert verdicts[0].note == read.reason
    assert "do not count: stale" in str(sections(read)[0].parts)
    store.unlink()
    read = read_budget(tuna)
    assert "no budget of hypertuna's family is stored" in read.reason
    assert [judge(PAPER, one).verdict for one in read.judged(found)] == ["not-computed", "violated", "reproduced"]
    assert sections(read) == []


def test_a_range_of_another_family_counts_for_nothing(store: Path, tuna: ht.Robot) -> None:
    family = store.with_name("family.json")
    family.write_text('{"members": []}')
    assert read_budget(tuna).reason.startswith("stale: hypertuna or its family has changed")
    own = {"family_hash": hashlib.sha256(family.read_bytes()).hexdigest()}
    store.write_text(json.dumps(json.loads(store.read_text()) | own))
    assert read_budget(tuna).reason == ""
    family.write_text('{"members": [{}]}')
    assert read_budget(tuna).reason.startswith("stale")


def test_the_page_says_how_many_published_numbers_are_inside(store: Path, tuna: ht.Robot) -> None:
    record = json.loads(store.read_text())
    record["speed_m_s"] = {name: [0.35, 0.4, 0.55] for name in SPEEDS}  # holds 0.4 and 0.5
    record["power_w"] = {name: [10.0, 15.0, 20.0] for name in SPEEDS}  # holds 18.2, not 22.45
    (section,) = sections(Budget(record))
    text = str(section.parts)
    assert "4 of the eight published speeds are inside, and 1 of the two powers" in text
    assert UNPUBLISHED in text


def test_members_that_published_speeds_chose_are_no_predictions(
    tuna: ht.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(budget, "shipped", lambda _: tmp_path)
    missing = [judge(PAPER, one) for one in fitted_findings(read_posterior(tuna))]
    assert {entry.verdict for entry in missing} == {"not-computed"}
    assert len(missing) == 2 * (len(SPEEDS) + 2)
    speeds = [published_value(f"speed/{name}") for name in SPEEDS]
    exact = {"speed_m_s": speeds, "power_w": list(range(8)), "axis_n": {"I": 45.2, "II": 3.0}}
    slow = exact | {"speed_m_s": [0.8 * speed for speed in speeds]}
    robots = {"default robot": slow, "best with a free axis": slow, "best with any axis": exact}
    record = {"taken_hash": taken_hash(tuna), "robots": robots}
    (tmp_path / "posterior.json").write_text(json.dumps(record))
    entries = {(one.id, one.model): judge(PAPER, one) for one in fitted_findings(read_posterior(tuna))}
    for name in SPEEDS:
        free, any_ = (entries[f"speed/{name}", f"{TWIN}, {axis} axis"] for axis in ("free", "any"))
        assert (free.verdict, any_.verdict) == ("deviates", "agrees")
        judged = name in ("optimised-0.3", "optimised-0.4", "optimised-0.5")  # the last is almost a fitted gait
        assert free.class_ == any_.class_ == ("in sight" if judged else "fitted")
        assert "its axes carry up to 45 and 3 N" in any_.note
    assert entries["power/fastest", f"{TWIN}, any axis"].computed == SPEEDS.index("unoptimised-max")
    (tmp_path / "posterior.json").write_text(json.dumps(record | {"taken_hash": "of another robot"}))
    assert {judge(PAPER, one).verdict for one in fitted_findings(read_posterior(tuna))} == {"not-computed"}
