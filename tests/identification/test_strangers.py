"""Fits of a fish that is known from length and mass alone: what is free, its noise, its priors, and a wrong model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.identification.coefficients import free
from hypertuna.identification.experiment import LARGE_ERROR, experiment
from hypertuna.identification.fixed import fixed_coefficients, whitened
from hypertuna.identification.identify import identify
from hypertuna.identification.names import default_names, default_priors, prior_factor
from hypertuna.identification.prediction import predict
from hypertuna.identification.residuals import degrees_taken
from hypertuna.swimming.beat import settle
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.trials import Trials
from models import changed

FISH = Path(__file__).parents[2] / "examples" / "myfish.toml"
STRIP = "water.strip."
SIX = (0.5, 0.7, 1.0, 1.3, 1.6, 2.0)  # frequencies over that of cruise


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    return ht.load(FISH)


def with_factors(fish: ht.Robot, **factors: float) -> ht.Robot:
    """Return the fish with columns of its strips times a factor."""
    strip = fish.document()["water"]["strip"]
    return changed(fish, {f"{STRIP}{key}": [factor * x for x in strip[key]] for key, factor in factors.items()})


def gaits_of(fish: ht.Robot, frequencies: Sequence[float]) -> list[ht.Gait]:
    cruise = ht.named_gait(fish, "cruise")
    return [ht.Gait(cruise.frequency * f, cruise.amplitude, cruise.phase, cruise.bias) for f in frequencies]


def runs(
    truth: ht.Robot, frequencies: Sequence[float], noise: float = 0.0, times: Sequence[float] | float = 1.0
) -> Trials:
    """Return speeds without a stated noise."""
    gaits, random = gaits_of(truth, frequencies), np.random.default_rng(1)
    speeds = settle(truth, ht.Gaits.of(gaits))["speed"] * (1 + noise * random.standard_normal(len(gaits))) * times
    return Trials(tuple(SteadyRun(str(k), g, float(v)) for k, (g, v) in enumerate(zip(gaits, speeds, strict=True))))


def test_the_drag_of_the_head_is_free_by_default(fish: ht.Robot) -> None:
    """Where it has an area of its own, drag along the body is friction, and known better."""
    names = [f"{STRIP}{name}=common" for name in ("drag_tangential", "drag_normal", "added_mass_normal", "blunt_area")]
    assert default_names(fish) == tuple(names)
    assert list(default_priors(fish).values()) == [2.0, 1.5, 2.0, 3.0]
    assert prior_factor(ht.load("rexeel"), f"{STRIP}drag_tangential") == 10.0
    fit = identify(fish, runs(with_factors(fish, blunt_area_m2=4.0), SIX, 0.01), validate=0, starts=1)
    drag = with_factors(fish, blunt_area_m2=4.0).water.strip.blunt_area[0]  # type: ignore[union-attr]
    assert fit.robot.water.strip.blunt_area[0] == pytest.approx(drag, rel=0.4)  # type: ignore[union-attr]


def test_noise_does_not_grow_to_the_misfit_that_priors_cause(fish: ht.Robot) -> None:
    """A tenth of the head's drag and a third of the friction, both far outside of their priors."""
    fit = identify(fish, runs(with_factors(fish, blunt_area_m2=0.1, drag_tangential=0.3), SIX, 0.02), validate=0)
    assert fit.noise["speed"] < 0.04
    assert fit.train.rms["speed_relative"] < 0.03


def test_a_large_training_error_is_said_and_noise_is_capped(fish: ht.Robot) -> None:
    """Speeds that no coefficient brings about: every other one is a fifth."""
    fit = identify(fish, runs(fish, SIX, times=[1.0, 0.2] * 3), validate=0)
    assert fit.noise == {"speed": LARGE_ERROR}
    percent = f"{100 * fit.train.rms['speed_relative']:.0f} % in speed"
    assert f", but to a training error of {percent}." in fit.stop
    assert fit.warnings[-1].startswith(f"The training error is {percent}: the model does not describe these runs")
    good = identify(fish, runs(fish, SIX, 0.02), validate=0)
    assert "training error" not in " ".join([good.stop, *good.warnings])


@pytest.mark.parametrize("count", [4, 5, 6])
def test_linear_drag_joins_where_errors_go_with_the_speed(fish: ht.Robot, count: int) -> None:
    """With four runs, too; and other frequencies are then predicted, by a factor of four better or more."""
    truth = changed(fish, {f"{STRIP}linear_tangential_pa_s": [0.2] * len(fish.links.name)})
    trials, far = runs(truth, np.linspace(0.4, 1.6, count), 0.01), runs(truth, (0.25, 2.2))
    fit = identify(fish, trials, validate=0, starts=1)
    assert fit.free[-1].column == f"{STRIP}linear_tangential"
    assert fit.warnings[0].startswith(f"{fit.free[-1].name} is free, because errors of the speed go with frequency")
    without = identify(fish, trials, default_names(fish), prior=default_priors(fish), validate=0, starts=1)
    assert any("linear_tangential" in warning and "free it" in warning for warning in without.warnings)
    measured = np.array([run.speed for run in far.steady])
    errors = [
        np.abs(settle(one.robot, ht.Gaits.of(gaits_of(fish, (0.25, 2.2))))["speed"] / measured - 1).max()
        for one in (without, fit)
    ]
    assert errors[1] < errors[0] / 4


def test_linear_drag_stays_out_of_a_right_model(fish: ht.Robot) -> None:
    for frequencies in (SIX[:4], SIX):
        for trials in (runs(with_factors(fish, blunt_area_m2=1.5), frequencies), runs(fish, frequencies, 0.02)):
            assert len(identify(fish, trials, validate=0, starts=1).free) == 4


def test_few_runs_are_all_fitted(fish: ht.Robot) -> None:
    """One of five would be missed where the order of errors is judged; --validate may still hold it out."""
    assert identify(fish, runs(fish, SIX[:5], 0.02), starts=1).validation is None
    assert identify(fish, runs(fish, SIX, 0.02), starts=1).validation is not None
    assert identify(fish, runs(fish, SIX[:5], 0.02), starts=1, validate=0.2).validation is not None


def test_fixed_coefficients_widen_intervals_as_if_they_were_free_with_their_priors() -> None:
    """The normal matrix of J whitened by E is the Schur complement of that of [J E] with rows of 1 for E."""
    random = np.random.default_rng(0)
    jacobian, errors = random.standard_normal((9, 3)), random.standard_normal((9, 2))
    both = np.concatenate([np.hstack([jacobian, errors]), np.eye(5)[3:]])
    covariance = np.linalg.inv(both.T @ both)[:3, :3]
    whole = whitened(jacobian, errors)
    assert np.linalg.inv(whole.T @ whole) == pytest.approx(covariance)
    assert whitened(jacobian, np.zeros((9, 0))) == pytest.approx(jacobian)


def test_intervals_hold_a_truth_that_a_wrong_drag_area_hides(fish: ht.Robot) -> None:
    """Twice the head's drag, held fixed, makes drag along the body come out far too small: it is not known to this."""
    trials = runs(fish, SIX, 0.01)
    name, wrong = f"{STRIP}drag_tangential=common", with_factors(fish, blunt_area_m2=2.0)
    fits = [identify(robot, trials, [name], log=[name], validate=0, starts=1) for robot in (fish, wrong)]
    assert fits[1].values[0] < 0.5
    for fit in fits:
        assert fit.uncertainty.low[0] < 1 < fit.uncertainty.high[0]
        assert not fit.uncertainty.constrained[0]


def test_what_is_fixed(fish: ht.Robot) -> None:
    """All of the law in use that is not free, in part free columns, too; a fitted handful leaves the others."""
    data = experiment(fish, runs(fish, SIX), free(fish, [f"{STRIP}drag_normal[1]", f"{STRIP}blunt_area=common"]))
    names = [one.name for one in fixed_coefficients(data.robot, data.free)]
    assert f"{STRIP}drag_normal[0+2]=common" in names
    assert not any("blunt_area" in name or "lumped" in name for name in names)


def test_a_prior_leaves_degrees_of_freedom_to_the_runs(fish: ht.Robot) -> None:
    names, levels = default_names(fish), {"speed": 0.02}
    frees: Any = free(fish, names, prior=default_priors(fish))
    data = experiment(fish, runs(fish, SIX), frees)
    jacobian = predict(data, [1.0] * 4).jacobian / data.noise(levels)[data.sample][:, np.newaxis]
    known = np.diag(1 / np.log([f.prior[1] for f in frees]))
    assert 0.9 < degrees_taken(jacobian, known) < 3  # six speeds that go as the frequency tell one number
    assert degrees_taken(1e6 * np.eye(6)[:, :4], known) == pytest.approx(4)
    assert degrees_taken(jacobian, known[:0]) == 4
