"""Sobol's indices of the twin's estimates: runs that diverge are no results."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sensitivity as sobol
from sensitivity import influence

import hypertuna as ht
from hypertuna.simulation.estimates import varied

ROBOT = ht.load("hypertuna")
GAIT = ht.Gait.from_degrees(frequency=3, amplitude=(6, 9), phase=(0, 30))
BORE = ("joints.line.bore_m",)


def test_runs_that_diverge_have_no_outputs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of a whole tick: every other run ends in states that are no robot's, and must not enter the indices."""
    options, asked = sobol._options, []

    def coarse(*given: Any) -> dict[str, Any]:
        asked.append(given)
        return options(*given) | ({"step": 0.01} if len(asked) % 2 else {})

    monkeypatch.setattr(sobol, "_options", coarse)
    found = influence(ROBOT, GAIT, factors=BORE, samples=2, seconds=0.7)
    assert found.diverged == 3
    for values in (found.first, found.total, found.error, found.mean, found.deviation):
        assert np.isnan(values).all()


def test_the_working_limit_takes_the_others_along() -> None:
    """From 200 to 600 kPa for HyperTuna's; the limits keep their ratios."""
    before = ROBOT.controller
    assert before is not None
    for part, work in ((0.0, 200e3), (0.5, 346.41e3), (1.0, 600e3)):
        after = varied(ROBOT, {"controller.pressure_work_pa": part}).controller
        assert after is not None
        assert after.pressure_work == pytest.approx(work, rel=1e-4)
        for name in ("pressure_soft", "pressure_hard"):
            ratios = [getattr(one, name) / one.pressure_work for one in (before, after)]
            assert ratios[0] == pytest.approx(ratios[1])
