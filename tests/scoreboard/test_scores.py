"""Scores of predictions and the laws of swimmers, by numbers that can be checked by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hypertuna.scoreboard.laws import Shoal, gazzola, random_shoal, swimming_number
from hypertuna.scoreboard.scores import Score, coverage, leave_one_out, ratios_of, statistics, swimmer_logs


def score(name: str, ratio: float, run: str = "1", **more: float) -> Score:
    return Score(name, run, "speed", 0.1, more.pop("error", None), 0.1 * ratio, **more)


def test_a_swimmer_counts_once_by_the_geometric_mean_of_its_runs() -> None:
    scores = [score("a", 4), score("a", 1, "2"), score("b", 0.5), score("c", 1.2)]
    logs = swimmer_logs(ratios_of(scores))
    assert {name: math.exp(log) for name, log in logs.items()} == pytest.approx({"a": 2, "b": 0.5, "c": 1.2})
    found = statistics(scores)
    assert (found.swimmers, found.missing, found.within_near, found.within_far) == (3, 0, 1, 3)
    assert found.mean_ratio == pytest.approx(1.2 ** (1 / 3))
    assert found.rms_log == pytest.approx(math.sqrt((2 * math.log(2) ** 2 + math.log(1.2) ** 2) / 3))
    assert found.factor == pytest.approx(2)


def test_a_swimmer_without_a_forward_speed_is_missing() -> None:
    found = statistics([score("a", 1), score("b", -1), score("c", math.nan)])
    assert (found.swimmers, found.missing) == (1, 2)


def test_thrusts_and_powers_are_no_speeds() -> None:
    other = Score("a", "1", "thrust", 0.1, None, 5.0)
    assert statistics([score("a", 1), other]) == statistics([score("a", 1)])


def test_bands_count_with_the_published_error() -> None:
    inside, near, outside = (
        score("a", r, low=0.11, high=0.19, error=e) for r, e in ((1.5, 0.2), (1.5, 0.0), (1.5, 0.05))
    )
    assert (inside.inside, near.inside, outside.inside) == (True, False, False)
    assert (inside.verdict, near.verdict) == ("deviates", "deviates")  # the ledger takes no published error
    assert score("a", 1, low=0.09, high=0.12).verdict == "reproduced"
    assert score("a", 1).inside is score("a", 1).verdict is None


def test_coverage_is_the_mean_over_swimmers_of_their_share_inside() -> None:
    scores = [
        score("a", 1, low=0.09, high=0.27),
        score("a", 1, "2", low=0.2, high=0.8),
        score("b", 1, low=0.09, high=0.18),
    ]
    assert coverage(scores) == coverage(scores, estimates_alone=True) == pytest.approx((0.75, 3))
    assert np.isnan(coverage([score("a", 1)])).all()


def test_an_assumed_excursion_widens_the_band() -> None:
    known = score("a", 1, low=0.05, high=0.2)
    wide = replace(known, assumed=True)
    assert known.band == (0.05, 0.2)
    assert wide.band is not None
    # half, and half for an excursion of 0.1 lengths; twice, and 1.5 times for one of 0.3
    assert np.log(np.divide(0.1, wide.band[0])) == pytest.approx(math.sqrt(2) * math.log(2))
    assert np.log(np.divide(wide.band[1], 0.1)) == pytest.approx(math.hypot(math.log(2), math.log(1.5)))
    assert coverage([wide], estimates_alone=True)[1] == pytest.approx(4)
    assert replace(wide, predicted=-0.1, low=-0.2, high=0.1).band is None


def test_own_sections_count_where_they_are_published() -> None:
    found = statistics([score("a", 3, own=0.1), score("b", 3)], own=True)
    assert (found.swimmers, found.mean_ratio) == (1, pytest.approx(1))


def test_leave_one_out_takes_the_mean_of_the_others() -> None:
    assert leave_one_out({"a": 1.0, "b": 2.0, "c": 6.0}) == pytest.approx([1 - 4, 2 - 3.5, 6 - 1.5])
    assert np.isnan(leave_one_out({"a": 1.0})).all()


def test_gazzola_s_line() -> None:
    assert swimming_number(1.0, 0.1, 1.0) == pytest.approx(2 * math.pi * 1e5)
    assert gazzola([1e3, 1e5]) == pytest.approx([0.03 * 1e4, 4e4])
    fish = Shoal(*(np.array([value]) for value in (1.0, 2.0, 0.5, 0.1)))
    assert fish.strouhal == pytest.approx(0.4)
    assert fish.stride == pytest.approx(0.25)
    assert fish.reynolds == pytest.approx(5e5)
    # at turbulent numbers the line is one Strouhal number, 1 / (0.8 pi)
    assert fish.over_gazzola == pytest.approx(1 / (0.8 * math.pi) / fish.strouhal)


def test_random_fish_are_the_same_every_time_and_swim() -> None:
    first, again = random_shoal(10), random_shoal(10)
    np.testing.assert_array_equal(first.speed, again.speed)
    assert np.isfinite(first.speed).all()
    assert (first.speed > 0).all()
    assert len(np.unique(first.length)) == 10
    assert not np.array_equal(first.length, random_shoal(10, seed=1).length)
