"""Uncertainty: intervals, unidentifiable directions and criteria of problems with known answers."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import hypertuna as ht
from hypertuna.identification.coefficients import Free, free, sample_robots
from hypertuna.identification.experiment import Experiment, experiment
from hypertuna.identification.loss import loss_terms
from hypertuna.identification.prediction import Prediction, predict, weighted
from hypertuna.identification.residuals import autocorrelation_time, criteria, errors, lack_of_fit, squares
from hypertuna.identification.sentences import helpful_measurements
from hypertuna.identification.uncertainty import _units, uncertainty
from hypertuna.trials.trials import Trials
from synthetic import NINE, grid, steady, swims

Array = NDArray[np.float64]

T95 = 2.0452  # Student's t, 29 degrees of freedom, from a table


@cache
def some_runs(count: int) -> tuple[ht.Robot, Trials]:
    """Runs whose speeds do not matter."""
    tuna = ht.load("hypertuna")
    return tuna, steady(tuna, grid([2.0], [(16, 25)], np.linspace(0, 90, count)), cost=False)


def straight_line(noise: Array, *, told: bool = True, loss: str = "linear") -> tuple[Experiment, Prediction, Array]:
    """Runs whose speeds lie on a line a + b t, fitted by its normal equations: a problem whose covariance is known."""
    tuna, runs = some_runs(len(noise))
    t = np.linspace(-1, 1, len(noise))
    slope = np.column_stack([np.ones_like(t), t])
    measured = slope @ [1.0, 0.5] + noise
    values = np.linalg.lstsq(slope, measured, rcond=None)[0]
    none = np.zeros(len(t), dtype=bool)
    samples = np.arange(len(t))
    frees = (Free("water.lumped.drag[0]", 0.0, 30.0, 1.0), Free("water.lumped.drag[7]", 0.0, 30.0, 0.5))
    known, one = ~none if told else none, 1 + none
    laid_out = (measured, samples, 0 * samples, samples, np.full(len(t), 0.1), known, one, ())
    data = Experiment(tuna, runs, frees, *laid_out, loss=loss)
    return data, Prediction(slope @ values, slope, none, none, {}), values


def test_intervals_of_a_straight_line() -> None:
    """Var a = sd^2 / n and var b = sd^2 / sum t^2, uncorrelated: with residuals of exactly the stated noise."""
    noise = 0.1 * np.resize([1.0, -1.0], 31)
    data, found, values = straight_line(noise)
    result = uncertainty(data, values, found, {})
    t = np.linspace(-1, 1, 31)
    expected = np.array([0.1 / math.sqrt(31), 0.1 / math.sqrt((t**2).sum())])
    assert result.freedom == 29
    assert result.sd == pytest.approx(result.factor * expected, rel=1e-12)
    assert result.factor == pytest.approx(math.sqrt(31 / 29), rel=1e-2)  # the line takes two degrees of freedom
    assert result.high - result.low == pytest.approx(2 * T95 * result.sd, rel=1e-4)
    assert result.correlation == pytest.approx(np.eye(2), abs=1e-12)
    assert [d.constrained for d in result.directions] == [True, True]
    assert np.exp(np.log([d.singular_value for d in result.directions]).sum()) == pytest.approx(
        np.prod(result.unit / result.sd)
    )


def test_residuals_beyond_the_stated_noise_widen_the_intervals_and_none_narrows_them() -> None:
    noise = 0.1 * np.resize([1.0, -1.0], 31)
    for times, factor in ((3.0, 3 * math.sqrt(31 / 29)), (0.1, 1.0)):
        data, found, values = straight_line(times * noise)
        assert uncertainty(data, values, found, {}).factor == pytest.approx(factor, rel=1e-2)


def test_intervals_hold_the_truth_in_19_of_20_cases() -> None:
    """By Monte Carlo with a fixed seed: 400 lines, each with 2 coefficients; 3 sd of the count are 2.3 %."""
    rng = np.random.default_rng(0)
    held = 0
    for _ in range(400):
        data, found, values = straight_line(0.1 * rng.standard_normal(31))
        result = uncertainty(data, values, found, {})
        held += ((result.low <= [1.0, 0.5]) & (result.high >= [1.0, 0.5])).sum()
    assert 0.927 < held / 800 < 0.985


def test_two_coefficients_of_the_same_effect_cannot_be_distinguished() -> None:
    data, found, _ = straight_line(0.1 * np.resize([1.0, -1.0], 31))
    same = Prediction(found.computed, found.jacobian[:, :1].repeat(2, axis=1), found.failed, found.unstable, {})
    result = uncertainty(data, np.array([1.0, 1.0]), same, {})
    assert [d.constrained for d in result.directions] == [True, False]
    assert result.directions[1].singular_value < 1e-6
    assert result.directions[1].sentence == (
        "water.lumped.drag[0] and water.lumped.drag[7] cannot be distinguished from speed alone; "
        "other gaits, or recordings of transients, may."
    )
    assert np.isinf(result.sd).all()
    assert (result.low == 0).all()
    assert (result.high == 30).all()
    assert result.correlation[0, 1] == pytest.approx(-1)


def test_a_coefficient_without_effect_is_unidentifiable() -> None:
    data, found, _ = straight_line(0.1 * np.resize([1.0, -1.0], 31))
    idle = Prediction(found.computed, found.jacobian * [1.0, 0.0], found.failed, found.unstable, {})
    result = uncertainty(data, np.array([1.0, 1.0]), idle, {})
    assert result.constrained == (True, False)
    assert result.directions[1].sentence.startswith("water.lumped.drag[7] is not constrained by speed alone")


def test_values_on_their_bounds_are_reported() -> None:
    data, found, _ = straight_line(0.1 * np.resize([1.0, -1.0], 31))
    assert uncertainty(data, np.array([0.0, 30.0]), found, {}).bound == ("lower", "upper")
    assert uncertainty(data, np.array([0.1, 29.9]), found, {}).bound == (None, None)


def test_added_mass_and_mass_of_the_tail(tuna: ht.Robot) -> None:
    """Both are inertia of the same link, m (1 + c_m): only their sum is seen, but for the link's moment of inertia."""
    frees = free(tuna, ["water.added_mass[7]", "links.mass[7]"])
    values = np.array([f.start for f in frees])
    data = experiment(tuna, steady(tuna, grid([2, 4, 6], [(16, 25)], [0, 30, 60]), cost=False), frees)
    found = predict(data, values)
    result = uncertainty(data, values, found, {"speed": 0.01})
    assert not result.directions[1].constrained
    assert result.directions[1].sentence.startswith(
        "water.lumped.added_mass[7] and links.mass[7] cannot be distinguished from speed alone"
    )
    mass, added = tuna.links.mass[7], values[0]
    along = result.directions[1].vector * result.unit
    assert along[1] * (1 + added) / (mass * along[0]) == pytest.approx(-1, abs=0.1)  # m (1 + c_m) stays


def test_a_measurement_that_would_help_is_named(tuna: ht.Robot) -> None:
    """With ideal joints the speed of a gait grows as its frequency for any coefficients: it determines one number."""
    robot = tuna.using(joints="ideal")
    frees = free(robot, ["water.friction[1-6]", "water.drag[7]"])
    values, levels = np.array([f.start for f in frees]), {"speed": 0.01, "cost_of_transport": 0.01}
    sentences = []
    for cost in (False, True):
        data = experiment(robot, steady(robot, grid(np.arange(2, 6, 0.5), [(16, 25)], [40]), cost=cost), frees)
        result = uncertainty(data, values, predict(data, values), levels)
        sentences.append(result.directions[1].sentence)
    assert sentences[0].endswith(
        "cannot be distinguished from speed alone; the cost of transport of the same runs, known to 2 %, "
        "would constrain them."
    )
    assert sentences[1].startswith("Speed and cost of transport constrain ")


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("slope", "named"), [(0.7, False), (0.9, True)])
def test_a_measurement_helps_if_two_percent_of_it_tell_half_a_unit(size: float, slope: float, named: bool) -> None:
    """By four equal runs the deviation is 0.02 / 2 / slope; a 95 % interval must be narrower than a unit, 0.05."""
    runs = np.full(4, size)
    prediction: Any = SimpleNamespace(measurable={"cost_of_transport": (runs, slope * runs[:, np.newaxis])})
    direction: Any = SimpleNamespace(vector=np.ones(1), constrained=False)
    data: Any = SimpleNamespace(kind=np.zeros(4, dtype=int))
    unit, unknown = np.array([0.05]), np.zeros((4, 1))
    (text,) = helpful_measurements(data, prediction, unknown, unit, 1.96, [direction])
    assert bool(text) == named


def test_aicc_of_a_normal_sample() -> None:
    """-2 ln L = sum z + n ln(2 pi sd^2) where the noise is given; n (ln(2 pi s^2) + 1), s^2 = mean r^2, where not."""
    noise = 0.1 * np.resize([1.0, -1.0], 31)
    data, found, _ = straight_line(noise)
    told = criteria(data, found, {})
    residual = found.computed - data.measured
    total = (residual**2).sum() / 0.01 + 31 * math.log(2 * math.pi * 0.01)
    assert told["minus_2_log_likelihood"] == pytest.approx(total)
    assert told["aicc"] == pytest.approx(total + 4 + 12 / 28)
    assert told["bic"] == pytest.approx(total + 2 * math.log(31))
    data, found, _ = straight_line(noise, told=False)
    total = 31 * (math.log(2 * math.pi * (residual**2).mean()) + 1)
    for level in (0.5, 2.0):  # any assumed level
        assert criteria(data, found, {"speed": level})["minus_2_log_likelihood"] == pytest.approx(total)
    assert criteria(data, found, {"speed": 1.0})["parameters"] == 3


@pytest.mark.parametrize("loss", ["linear", "soft_l1", "huber", "cauchy"])
def test_losses_are_those_of_scipy(loss: str) -> None:
    """SciPy's cost is half the sum of rho; the derivatives agree with differences."""
    from scipy.optimize import least_squares

    residual = np.array([0.0, 0.3, 0.9, 1.1, 4.0])
    cost = least_squares(lambda x: residual + 0 * x, [0.0], loss=loss, max_nfev=1).cost
    z, step = residual**2, 1e-6
    value, first, second = loss_terms(loss, z)
    assert 0.5 * value.sum() == pytest.approx(cost, rel=1e-12)
    up, down = loss_terms(loss, z + step), loss_terms(loss, z - step)
    assert first == pytest.approx((up[0] - down[0]) / (2 * step), rel=1e-6)
    assert second == pytest.approx((up[1] - down[1]) / (2 * step), rel=1e-6, abs=1e-9)


def test_frames_of_a_track_share_one_loss() -> None:
    """Two samples, of 1 and of 4 elements, all off by their standard deviation times 0, 1 and sqrt(4)."""
    data, _, _ = straight_line(np.zeros(5))
    grouped = Experiment(
        data.robot,
        data.trials,
        data.free,
        np.array([0.0, 2.0, 2.0, 2.0, 2.0]),
        np.array([0, 1, 1, 1, 1]),
        np.array([0, 2]),
        np.array([0, 1]),
        np.ones(2),
        np.ones(2, dtype=bool),
        np.array([1, 4]),
        (),
    )
    none = np.zeros(5, dtype=bool)
    found = Prediction(np.zeros(5), np.ones((5, 1)), none, none, {})
    assert squares(grouped, found, {}) == pytest.approx([0, 4])
    assert weighted(grouped, found, {})[0] == pytest.approx([0, -1, -1, -1, -1])


def test_errors_are_relative_for_steady_runs() -> None:
    data, found, _ = straight_line(np.zeros(5))
    off = Prediction(1.1 * data.measured, found.jacobian, found.failed | (np.arange(5) == 2), found.unstable, {})
    told = errors(data, off)
    assert told.rms == pytest.approx({"speed_relative": 0.1})
    assert told.max == pytest.approx({"speed_relative": 0.1})
    assert told.runs[0]["speed_measured_m_s"] == data.measured[0]
    assert [run.get("status") for run in told.runs] == [None, None, "not settled", None, None]


@pytest.mark.parametrize("loss", ["linear", "soft_l1", "huber", "cauchy"])
def test_residuals_thirty_times_the_stated_noise_make_intervals_thirty_times_as_wide(loss: str) -> None:
    """With any loss, outliers are judged by the estimated noise."""
    noise = np.random.default_rng(2).normal(scale=0.1, size=31)

    def result(scale: float):
        data, found, values = straight_line(scale * noise, loss=loss)
        return uncertainty(data, values, found, {})

    assert result(300.0).residual_scale == pytest.approx(10 * result(30.0).residual_scale, rel=1e-4)
    assert result(30.0).residual_scale == pytest.approx(30, rel=0.3)
    assert result(30.0).factor / result(30.0).residual_scale == pytest.approx(1.1, abs=0.25)


def test_more_runs_of_one_recording_do_not_hide_that_the_model_is_off() -> None:
    """e off the mean of R runs that scatter by sd: z = (R - 1)/R + e^2/sd^2, so R e^2/sd^2 for any scatter."""
    tuna = ht.load("hypertuna")
    for runs in (4, 20):
        data = experiment(tuna, swims(tuna, runs=runs, noise=0.02), ())
        for off in (0.0, 3.0):
            z = np.full(len(data.kind), (runs - 1) / runs + off**2)
            assert lack_of_fit(data, z) == pytest.approx(runs * off**2, abs=1e-9)


def test_samples_keep_what_few_runs_determine() -> None:
    """Nine coefficients from three speeds: six directions are unidentifiable, but every sample swims those speeds."""
    tuna = ht.load("hypertuna")
    runs = steady(tuna, grid([2.0, 4.0, 6.0], [(16, 25)], [20.0]), noise=0.01, cost=False, told=True)
    fit = ht.identify(tuna, runs, NINE, validate=0, starts=1)
    measured = np.array([run.speed for run in runs.steady])
    gaits = [run.gait for run in runs.steady]
    swum = np.array([ht.sweep(robot, gaits, threads=1)["speed"] for robot in sample_robots(fit.robot, 24, 1)])
    assert np.sqrt(np.mean((swum / measured - 1) ** 2)) < 0.04
    spread = np.array([robot.water.lumped.drag[0] for robot in sample_robots(fit.robot, 24, 1)])
    assert np.ptp(spread) > 10  # unidentifiable directions extend from bound to bound


def test_units_of_offsets_are_absolute() -> None:
    """An offset of 0.001 s +- 0.01 s is known: 0 is no smaller than another time. Relative to its value, it is not."""
    frees = (
        Free("time_offset[a]", -0.25, 0.25, 0.001),
        Free("joints.phase_offset[0]", -1.0, 1.0, 0.0),
        Free("time_offset[b]", -0.02, 0.02, 0.0),
        Free("water.lumped.drag[0]", 0.0, 30.0, 20.0),
    )
    assert _units(frees, np.array([0.001, 0.0, 0.0, 20.0]), np.array([0.5, 2.0, 0.04, 30.0])) == pytest.approx(
        [0.1, 0.1, 0.04, 20.0]
    )


def test_no_sentence_names_one_coefficient_as_several() -> None:
    data, found, _ = straight_line(0.1 * np.resize([1.0, -1.0], 31))
    several = 0
    for weak in (1.0, 0.1, 1e-2, 1e-4, 0.0):
        one = Prediction(found.computed, weak * found.jacobian[:, :1], found.failed, found.unstable, {})
        (direction,) = uncertainty(replace(data, free=data.free[:1]), np.array([1.0]), one, {}).directions
        start = "Speed constrains" if direction.constrained else "water.lumped.drag[0] is not constrained"
        assert direction.sentence.startswith(f"{start} ")
        own, alike = found.jacobian * [1.0, weak], found.jacobian[:, :1] + found.jacobian[:, 1:] * [0.0, weak]
        for jacobian in (own, alike):
            both = Prediction(found.computed, jacobian, found.failed, found.unstable, {})
            for told in uncertainty(data, np.array([1.0, 1.0]), both, {}).directions:
                assert told.sentence[0] != " "
                if "distinguished" in told.sentence or "combination" in told.sentence:
                    assert "] and water" in told.sentence
                    several += 1
    assert several == 10  # both directions of the five that are alike


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_autocorrelation_time_of_noise_that_persists(rho: float) -> None:
    """Of a first-order process it is (1 + rho) / (1 - rho): frames count as that many times fewer."""
    rng = np.random.default_rng(1)
    series = []
    for _ in range(6):
        noise, x = rng.standard_normal(2000), np.zeros(2000)
        for k in range(1, 2000):
            x[k] = rho * x[k - 1] + noise[k]
        series.append(x)
    assert autocorrelation_time(series) == pytest.approx((1 + rho) / (1 - rho), rel=0.25)
    assert autocorrelation_time([np.ones(50)]) > 25  # an error that stays: one measurement
