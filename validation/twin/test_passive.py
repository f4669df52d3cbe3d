"""What is stored of joint II as a spring is what the study computes."""

import json

import passive
import pytest

import hypertuna as ht

STORED = json.loads(passive.FILE.read_text(encoding="utf-8"))


def test_the_fish_with_a_spring_at_its_peduncle_is_as_stored() -> None:
    assert passive.platform() == pytest.approx(STORED["platform"], rel=1e-3)


def test_a_member_swims_as_stored() -> None:
    """The default robot in lumped water: costs are between gaits of a grid, which processors round alike."""
    found = passive.electrical(ht.load("hypertuna").using(water="lumped"), seed=STORED["seed"])
    stored = STORED["electrical"]["lumped"]
    assert found["one_spring"] == pytest.approx(stored["one_spring"], rel=1e-2)
    for kind in ("active", "passive"):
        for name, best in stored[kind].items():
            assert found[kind][name]["cost"] == pytest.approx(best["cost"], rel=1e-2), (kind, name)


def test_a_fin_that_reaches_no_speed_has_none() -> None:
    small = passive.with_fin(ht.load("hypertuna").using(water="strip"), 0.5, 0.5)
    assert passive.active(small)["0.5"] is None
