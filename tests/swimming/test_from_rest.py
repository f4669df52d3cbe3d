"""Swims from rest: where they start, what they report, and where they end after long enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import hypertuna as ht
from hypertuna import _core
from hypertuna.swimming.model import core_model
from models import MODELS, fastest, turning


def test_from_rest_starts_without_momentum_and_lasts_as_long_as_asked(tuna: ht.Robot) -> None:
    swim = ht.swim(tuna, fastest(tuna), from_rest=1.25)
    start = swim.trajectory.isel(time=0)
    assert [float(start[name]) for name in ("x", "y", "heading")] == [0, 0, 0]
    joints = np.stack([start.joint_angle, start.joint_rate, 0 * start.joint_rate], axis=1)
    twist = np.array([start.u, start.v, start.r])
    found = _core.dynamics(core_model(tuna), joints[None], twist[None])
    np.testing.assert_allclose(found["momentum"], 0, atol=1e-12)
    assert float(swim.trajectory.time[-1]) == pytest.approx(1.25)
    assert swim.beats == 7  # whole beats in 1.25 s of 6 Hz
    assert np.isnan(swim.spectral_radius)
    assert np.isnan(swim.multipliers).all()


def test_from_rest_reports_its_last_whole_beat(tuna: ht.Robot) -> None:
    gait, beats_swum = fastest(tuna), 4
    swim = ht.swim(tuna, gait, from_rest=beats_swum / gait.frequency)
    last = swim.trajectory.isel(time=slice((beats_swum - 1) * swim.steps, None))
    assert swim.beats == beats_swum
    assert swim.mechanical_power == pytest.approx(float(last.mechanical_power[:-1].mean()))
    assert swim.turn_rate == pytest.approx(float(last.heading[-1] - last.heading[0]) * gait.frequency, abs=1e-12)


@given(st.integers(1, 50), st.floats(0.1, 6.0))
@example(1, 1.9)  # 1 / 1.9 * 1.9 is less than 1
def test_so_many_periods_are_so_many_beats(count: int, frequency: float) -> None:
    """Rounding of n / f loses no beat."""
    robot = MODELS["hypertuna-lumped"]
    gait = replace(fastest(robot), frequency=frequency)
    assert ht.swim(robot, gait, from_rest=count / frequency).beats == count


def test_too_few_beats_are_unsettled(tuna: ht.Robot) -> None:
    gait = fastest(tuna)
    swim = ht.swim(tuna, gait, from_rest=3 / gait.frequency)
    final = ht.swim(tuna, gait)
    assert swim.status == "unsettled"
    assert not swim.settled
    assert swim.speed < 0.99 * final.speed
    short = f"its speed is {final.speed - swim.speed:.2g} m/s below the settled {final.speed:.4g} m/s."
    assert f"after 3 beats from rest: {short}" in swim.status_text


@pytest.mark.parametrize("gait_of", [fastest, turning])
def test_newton_finds_what_waiting_finds(every_model: ht.Robot, gait_of: Callable[[ht.Robot], ht.Gait]) -> None:
    gait = gait_of(every_model)
    settled = ht.swim(every_model, gait)
    # 0.972, the slowest of these to settle, to the power of 1000 is 5e-13
    waited = ht.swim(every_model, gait, from_rest=1000.5 / gait.frequency)
    assert (settled.status, waited.status) == ("settled", "settled")
    assert waited.beats == 1000
    for name in ("speed", "mechanical_power", "tail_excursion", "turn_rate"):
        known = {"rel": 1e-6, "abs": 1e-6 * gait.frequency if name == "turn_rate" else 0}
        assert getattr(settled, name) == pytest.approx(getattr(waited, name), **known), name
