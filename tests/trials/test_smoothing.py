"""Joint angles smoothed by the motion that the Bayesian criterion chooses."""

import math

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.trials.smoothing import Harmonics, smooth, strongest_frequency, white_noise

NOISE = math.radians(2.0)  # that of 1.5 mm on markers 5 cm apart
RATE, FREQUENCY, AMPLITUDE = 60.0, 0.5, math.radians(15)


def wave(time, order=0, *, ramp=False):
    """Two joints, the second a quarter of a beat late; with a ramp they set in smoothly within a beat."""
    omega = 2 * np.pi * FREQUENCY
    phase = omega * time[:, np.newaxis] - np.array([0.0, np.pi / 2])
    if not ramp:
        return AMPLITUDE * omega**order * np.sin(phase + order * np.pi / 2)
    part = np.clip(time * FREQUENCY, 0, 1)[:, np.newaxis]
    rise, rate = part**2 * (3 - 2 * part), 6 * part * (1 - part) * FREQUENCY
    return AMPLITUDE * (rise * np.sin(phase) if order == 0 else rate * np.sin(phase) + rise * omega * np.cos(phase))


def noisy(seed, **options):
    time = np.arange(0, 8, 1 / RATE)
    angle = wave(time, **options)
    return ht.JointSeries(time, angle + NOISE * np.random.default_rng(seed).standard_normal(angle.shape))


@pytest.mark.parametrize("seed", range(5))
def test_a_periodic_motion_is_found(seed):
    """480 samples determine a sine to NOISE sqrt(2 / 480): 3 numbers and the frequency. A spline had 17 % in the rate.

    In units of the rms of each derivative: NOISE / (AMPLITUDE / sqrt 2) sqrt(3 / 480) = 1.5 %; here three times that.
    """
    series = noisy(seed)
    curve = smooth(series)
    assert isinstance(curve.curves[0], Harmonics)
    assert curve.curves[0].frequency == pytest.approx(FREQUENCY, rel=2e-3)
    assert curve.noise == pytest.approx(NOISE, rel=0.1)
    for order in range(3):
        truth = wave(series.time, order)
        error = curve(series.time)[:, :, order] - truth
        assert np.sqrt(np.mean(error**2)) < 0.045 * np.sqrt(np.mean(truth**2))


@pytest.mark.parametrize("seed", range(5))
def test_a_motion_that_sets_in_is_a_spline(seed):
    """It has no period; within 5 % of the angle and 12 % of the rate, where the fewest knots left 9 and 16 %."""
    series = noisy(seed, ramp=True)
    curve = smooth(series)
    assert not isinstance(curve.curves[0], Harmonics)
    for order, limit in ((0, 0.06), (1, 0.14)):
        truth = wave(series.time, order, ramp=True)
        error = curve(series.time)[:, :, order] - truth
        assert np.sqrt(np.mean(error**2)) < limit * np.sqrt(np.mean(truth**2))


def test_derivatives_of_harmonics_are_those_of_their_angle():
    curve = Harmonics(0.7, np.array([0.1, 0.3, -0.05]), np.array([0.0, -0.2, 0.02]))
    time = np.linspace(0, 3, 50)
    for order in (1, 2):
        before = curve.derivative(order - 1)
        difference = (before(time + 1e-5) - before(time - 1e-5)) / 2e-5
        assert curve.derivative(order)(time) == pytest.approx(difference, abs=1e-6)


def test_noise_and_frequency_of_a_series():
    series = noisy(0)
    assert white_noise(series.angle, series.time) == pytest.approx(NOISE, rel=0.1)
    assert strongest_frequency(series.time, series.angle) == pytest.approx(FREQUENCY, rel=0.02)
    assert (white_noise(series.angle[:6]) == 0).all()  # too few to tell


def test_its_table_has_the_angle_and_rate_of_each_joint_group():
    curve = smooth(noisy(0))
    table, degrees = curve.to_pandas(), np.degrees(curve(curve.series.time))
    assert list(table) == ["time_s", "angle_1_deg", "angle_2_deg", "rate_1_deg_s", "rate_2_deg_s"]
    np.testing.assert_array_equal(table[["angle_1_deg", "angle_2_deg"]], degrees[..., 0])
    np.testing.assert_array_equal(table[["rate_1_deg_s", "rate_2_deg_s"]], degrees[..., 1])
