"""Common factors, default coefficients, trends of residuals, and the reach of a fit."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.identification.coefficients import columns, free, sample_robots
from hypertuna.identification.experiment import experiment
from hypertuna.identification.identify import identify
from hypertuna.identification.names import default_names
from hypertuna.identification.prediction import predict
from hypertuna.identification.trends import rank_correlation, trends
from hypertuna.trials.reach import outside
from models import changed
from synthetic import grid, steady

FEW = grid([1, 2, 3, 4, 5, 6], [(16, 25)], [0, 40])


def eel_with(**values: float) -> ht.Robot:
    """A rexeel with other coefficients of its strips, by column, one value for all links."""
    eel = ht.load("rexeel")
    return changed(eel, {f"water.strip.{name}": [value] * 6 for name, value in values.items()})


def test_a_common_factor_keeps_the_values_apart(tuna: ht.Robot) -> None:
    """Drags 20 % larger than described, of different values: the factor is 1.2, and one value for all cannot be."""
    drag = np.array(tuna.water.lumped.drag)
    truth = changed(tuna, {"water.lumped.drag": list(1.2 * drag)})
    fit = identify(tuna, steady(truth, FEW), ["water.drag=common"], validate=0, starts=1)
    assert [f.name for f in fit.free] == ["water.lumped.drag[0-7]=common"]
    assert fit.values == pytest.approx([1.2], rel=1e-6)
    assert fit.robot.water.lumped.drag == pytest.approx(1.2 * drag, rel=1e-6)
    assert not fit.warnings
    assert fit.robot.fit is not None
    assert fit.robot.fit.value == pytest.approx([1.0])  # of the fitted values: drawn robots scatter about them
    drawn = [robot.water.lumped.drag[0] for robot in sample_robots(fit.robot, 20, 0)]
    assert np.mean(drawn) == pytest.approx(1.2 * drag[0], rel=1e-3)


def test_a_common_factor_of_0_leaves_0(tuna: ht.Robot) -> None:
    """A robot without drag: the factor is on its lower bound, and there is nothing that 1 could be relative to."""
    truth = changed(tuna, {"water.lumped.drag": [0.0] * 8, "water.lumped.friction": [1.0] * 8})
    start = changed(tuna, {"water.lumped.friction": [1.0] * 8})
    fit = identify(start, steady(truth, FEW[2:8], cost=False), ["water.drag=common"], validate=0, starts=1)
    assert fit.robot.water.lumped.drag == (0.0,) * 8
    assert fit.robot.fit is not None
    assert fit.robot.fit.value == (0.0,)


def test_common_factor_of_some_links_and_its_errors(tuna: ht.Robot) -> None:
    (one,) = free(tuna, ["water.drag[1-6]=common"])
    drag = np.array(tuna.water.lumped.drag)
    made = columns(tuna, [one], [2.0])["water.lumped.drag"]
    assert made == pytest.approx(np.where(np.arange(8) % 7 == 0, 1, 2) * drag)
    assert one.upper == pytest.approx(max(30 / drag[1:7].max(), 2))
    with pytest.raises(ht.InputError, match="needs a value other than 0 in the robot to have a common factor"):
        free(ht.load("rexeel"), ["water.added_mass_tangential=common"])
    with pytest.raises(ht.InputError, match="is not a value of the robot and cannot have a common factor"):
        free(tuna, ["cost_factor=common"])


def test_default_coefficients_are_those_of_the_law(tuna: ht.Robot) -> None:
    law = "water.lumped."
    assert default_names(tuna) == (f"{law}friction=common", f"{law}drag=common", f"{law}added_mass=common")
    law = "water.strip."
    names = (f"{law}drag_tangential=common", f"{law}drag_normal=common", f"{law}added_mass_normal=common")
    assert default_names(ht.load("rexeel")) == names
    assert default_names(eel_with(drag_tangential=0.0))[0] == "water.strip.drag_tangential"


def test_rank_correlation_by_hand() -> None:
    """Of the 720 orders of 6 values two, up and down, are as strict as the rising one; ties halve nothing."""
    assert rank_correlation(np.arange(6.0), np.arange(6.0) ** 3, 0) == (pytest.approx(1), pytest.approx(2 / 720))
    rho, p = rank_correlation(np.arange(20.0), np.cos(np.arange(20.0) * 2.4), 0)
    assert p > 0.05
    assert abs(rho) < 0.5
    assert rank_correlation(np.arange(20.0), -np.arange(20.0), 0) == (pytest.approx(-1), 1e-4)


def test_a_trend_names_the_linear_drag_that_is_missing(eel_gaits: list[ht.Gait]) -> None:
    """Runs of a robot with linear drag, fitted with quadratic drag alone: slow runs come out too fast."""
    truth = eel_with(linear_tangential_pa_s=0.1)
    trials = steady(truth, eel_gaits, cost=False, noise=0.005, seed=3)
    fit = identify(ht.load("rexeel"), trials, ["water.drag_tangential"], validate=0, starts=1)
    (warning,) = (w for w in fit.warnings if "with speed" in w)
    assert "The error of the speed falls with speed" in warning
    assert "water.strip.linear_tangential[0-5] would take" in warning
    whole = identify(
        ht.load("rexeel"), trials, ["water.drag_tangential", "water.linear_tangential"], validate=0, starts=1
    )
    assert not [w for w in whole.warnings if "The error of the speed" in w]


@pytest.fixture(scope="module")
def eel_gaits() -> list[ht.Gait]:
    """Gaits of the eel over frequency and amplitude."""
    lag = np.arange(5) * 50.4
    return [
        ht.Gait.from_degrees(frequency=f, amplitude=(a,) * 5, phase=lag)
        for f in (0.2, 0.35, 0.5, 0.7, 1.0)
        for a in (10, 20, 30)
    ]


def test_a_swim_outside_the_runs_of_its_fit_is_told(tuna: ht.Robot) -> None:
    fit = identify(tuna, steady(tuna, FEW[2:8]), ["water.drag[7]"], validate=0, starts=1)
    reach = fit.robot.fit
    assert reach is not None
    assert reach.frequency == pytest.approx((2, 4))
    assert reach.amplitude == pytest.approx(np.radians((25, 25)))
    amplitude = np.radians([16, 25])
    assert outside(fit.robot, frequency=3, amplitude=amplitude) == []
    (sentence,) = outside(fit.robot, frequency=6, amplitude=amplitude)
    assert "The frequency 6 Hz is outside the runs that the coefficients were fitted to, 2 to 4 Hz" in sentence
    assert len(outside(fit.robot, frequency=0.5, amplitude=2 * amplitude, speed=9.0)) == 3
    assert outside(tuna, frequency=60, amplitude=amplitude) == []  # not fitted


def test_trends_take_memory_by_the_runs_not_by_their_square(tuna: ht.Robot) -> None:
    """1600 runs: a row of all their speeds and costs for each run would be 41 MB."""
    runs = steady(tuna, grid(np.linspace(1, 6, 40), [(16, 25)], np.linspace(0, 80, 40)), noise=0.02)
    frees = free(tuna, ["water.drag=common"])
    data = experiment(tuna, runs, frees)
    prediction = predict(data, [1.0])
    tracemalloc.start()
    try:
        trends(data, np.array([1.0]), prediction, 0)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
