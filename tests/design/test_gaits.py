"""Gaits that a design chooses from and aims at, by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.design.runs import gait_of_shares, target_gaits
from hypertuna.optimization.design_space import gait_bounds

MINNOW = ht.load(Path(__file__).parents[2] / "examples" / "minnow.toml")
SPACE = gait_bounds(MINNOW)


def test_a_gait_has_its_shares_of_the_bounds() -> None:
    """At most the joint groups bend by 10, 16 and 22 deg, and the last one lags by 180 deg."""
    gait = gait_of_shares(SPACE, MINNOW, 2.0, 0.5, 0.25, 0.5)
    assert gait.frequency == 2
    assert np.degrees(gait.amplitude) == pytest.approx([5, 8, 5.5])  # half, and of the last group half of that
    assert np.degrees(gait.phase) == pytest.approx([0, 22.5, 45])  # a quarter, in equal steps
    assert np.degrees(gait.bias) == pytest.approx([0, 0, 0])


def test_target_gaits_fill_the_box_evenly() -> None:
    """Of Halton's points: frequencies halve their span again and again, amplitudes part theirs by three."""
    low, high = SPACE.low[0], SPACE.high[0]
    gaits = target_gaits(SPACE, MINNOW, 7)
    shares = [(gait.frequency - low) / (high - low) for gait in gaits]
    assert shares == pytest.approx([1 / 2, 1 / 4, 3 / 4, 1 / 8, 5 / 8, 3 / 8, 7 / 8], rel=0.01)  # three digits
    amplitudes = [np.degrees(gait.amplitude[0]) for gait in gaits]
    assert amplitudes == pytest.approx([6, 8, 14 / 3, 20 / 3, 26 / 3, 16 / 3, 22 / 3], abs=0.05)  # of 4 to 10 deg
