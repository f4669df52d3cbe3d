"""The posture test: peak bends between samples, settling, the largest amplitude that is held."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.changes import changed
from hypertuna.errors import InputError
from hypertuna.simulation import posture
from hypertuna.simulation.posture import Held, fitted_peaks, hold, peak_bends, posture_test, reach
from hypertuna.swimming.gait import Gait

RATE = 100.0


@dataclass(frozen=True)
class Beating:
    """A run of a make-believe robot: its amplitude grows to what was set, but no further than a limit."""

    robot: ht.Robot
    gait: Gait
    time: Any
    data: dict[str, Any]
    limits: tuple[str, ...]
    status: str = "completed"
    temperature: float = 20.0


def beating(grow: float, most: float, sensor: float = 1.0) -> Any:
    """Make a stand-in of `twins` whose amplitude has a time constant [s], a limit [rad] and a sensor's gain."""

    def run(robot: ht.Robot, gait: Gait, *, duration: float, **_: Any) -> Beating:
        time = np.arange(0, duration + 0.5 / RATE, 1 / RATE)
        wished = np.array(gait.amplitude)
        rise = 1 - np.exp(-time / grow)
        angle = np.minimum(wished, most) * rise[:, None] * np.sin(2 * np.pi * gait.frequency * time)[:, None]
        limits = ("pressure_soft",) if (wished > most).any() else ()
        return Beating(robot, gait, time, {"angle": angle, "angle_measured": sensor * angle}, limits)

    return lambda runs, measure: [measure(run(**options)) for options in runs]


@pytest.mark.parametrize("frequency", [1.0, 2.13, 6.0])
def test_peaks_are_found_between_samples(frequency: float) -> None:
    # The nearest of 16 samples of a beat is up to 2 % below its peak; a parabola through three is 30 times nearer.
    time = np.arange(0, 8, 1 / RATE)
    angle = 0.1 + 0.3 * np.sin(2 * np.pi * frequency * time - 0.4)
    end, peaks = peak_bends(time, angle, frequency)
    assert len(end) == int(time[-1] * frequency)
    np.testing.assert_allclose(end, np.arange(1, len(end) + 1) / frequency, atol=0.5 / RATE)
    np.testing.assert_allclose(
        peaks[1:], np.tile([0.4, 0.2], (len(end) - 1, 1)), atol=5e-4 * 0.3 * frequency / 6 + 1e-6
    )


def test_a_side_that_is_not_reached_has_a_negative_peak() -> None:
    time = np.arange(0, 4, 1 / RATE)
    _, peaks = peak_bends(time, 0.3 + 0.1 * np.sin(2 * np.pi * time), 1.0)
    assert peaks[:, 1].max() == pytest.approx(-0.2, abs=1e-4)


@pytest.mark.parametrize("frequency", [1.0, 5.0, 6.0])
def test_peaks_are_fitted_in_noise(frequency: float) -> None:
    # Peaks of 0.36 and 0.16 rad, the third harmonic among them. Noise s in each of n readings of a beat passes to the
    # sum of seven coefficients as s sqrt(7 / n); at 1 Hz the largest reading is too large by nearly s.
    noise, beats = 0.0035, 400
    time = np.arange(0, beats / frequency + 0.5 / RATE, 1 / RATE)
    phase = 2 * np.pi * frequency * time - 0.4
    angle = 0.1 + 0.25 * np.sin(phase) - 0.01 * np.sin(3 * phase)
    _, exact = fitted_peaks(time, angle, frequency)
    np.testing.assert_allclose(exact, np.tile([0.36, 0.16], (beats, 1)), atol=1e-5)
    noisy = angle + noise * np.random.default_rng(1).normal(size=len(time))
    _, peaks = fitted_peaks(time, noisy, frequency)
    error = peaks - [0.36, 0.16]
    assert error.std() == pytest.approx(noise * math.sqrt(7 * frequency / RATE), rel=0.1)
    assert abs(error.mean()) < 0.15 * noise
    if frequency == 1:
        assert (peak_bends(time, noisy, frequency)[1] - exact).mean() > 0.8 * noise


@pytest.mark.parametrize("frequency", [4.0, 5.0, 6.0])
def test_joint_ii_settles_whatever_the_noise(tuna: ht.Robot, frequency: float) -> None:
    # A controller that took peaks from single readings met 4 s at 5 Hz with none of these seeds by the sensor; over 32
    # seeds this one meets it with all by the sensor, and with 30 and 31 by the true bend at 5 and 6 Hz.
    runs = [
        hold(tuna, frequency, [0.0, math.radians(20)], duration=8.0, medium="air", seed=seed)[0]
        for seed in (2, 3, 4, 6)
    ]
    assert all(one.settling_measured is not None and one.settling_measured <= 4 for one in runs)
    if frequency > 4:
        assert sum(one.settling is not None and one.settling <= 4 for one in runs) >= 3


@pytest.mark.parametrize(("fill", "asked"), [(None, (16.0, 18.0, 20.0, 22.0)), (30e3, (16.0, 18.0))])
def test_slack_braids_make_joint_ii_jump_at_6_hz(
    tuna: ht.Robot, fill: float | None, asked: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Why no posture of 20 deg settles where a joint is filled to little: steady beats on either side of it only.

    Its pumps draw as fast as they can: the supervisor would keep them from cavities, and from such beats.
    """
    monkeypatch.setattr("hypertuna.control.controller._suction", lambda *_: 1e9)
    fills = {} if fill is None else {f"joints.{group.name}.line.fill_pressure_pa": fill for group in tuna.joints}
    bends, pressures = [], []
    for amplitude in asked:
        beat = ht.Gait.from_degrees(frequency=6.0, amplitude=(0.0, amplitude), phase=(0.0, 0.0))
        run = ht.twin(changed(tuna, fills), beat, duration=4.0, medium="air", closed_loop=False)
        bends.append(np.degrees(np.ptp(run.data["angle"][-100:, 1]) / 2))
        pressures.append(run.data["pump_pressure_high"][-100:, 2:].max())
    if fill is None:
        assert np.diff(bends) == pytest.approx(np.diff(asked), rel=0.25)  # smoothly
    else:
        assert bends[0] < 18.5 < 20 < bends[1]
        assert pressures[1] > 1.3 * pressures[0]


def held(errors: list[float]) -> Held:
    """Make beats of 1 s whose left peak bends have these errors [rad]."""
    peaks = np.column_stack([0.3 + np.array(errors), np.full(len(errors), 0.3)])
    return Held(1, 1.0, 0.3, np.arange(1.0, len(errors) + 1), peaks, peaks, (), None)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("degrees", "settling"),
    [
        ([-5, -2, 0.4, 0.1, -0.2], 3.0),  # third beat and all after it
        ([-5, 0.1, 0.6, 0.1, -0.2], 4.0),  # being near once is not enough
        ([0.1, 0.1, 0.1], 1.0),
        ([-5, 0.1, 0.1, 0.51], None),
        ([-5, 0.1, math.nan, 0.2, 0.2], 4.0),  # no number is no success
        ([-5, 0.1, math.nan], None),
    ],
)
def test_settling_is_the_first_beat_after_which_all_are_near(degrees: list[float], settling: float | None) -> None:
    assert held(np.radians(degrees).tolist()).settling == settling


def test_fig_8_of_a_known_joint(tuna: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    # 20 deg exp(-t/tau) < 0.5 deg from t = tau ln 40 = 1.84 s on, so in the beat that ends by then or the next.
    monkeypatch.setattr(posture, "twins", beating(0.5, 1.0, sensor=0.96))
    done = posture_test(tuna, frequencies=[1, 2, 4], angle=np.radians([0, 20]).tolist(), limits=False)
    assert [(one.frequency, one.name) for one in done.held] == [(1, "II"), (2, "II"), (4, "II")]
    for one in done.held:
        assert one.settling is not None
        assert 0.5 * math.log(40) - 1 / one.frequency < one.settling < 0.5 * math.log(40) + 2 / one.frequency
        assert one.settling_measured is None  # a sensor that shows 4 % too little never shows 20 deg
        assert one.error_measured[-1] == pytest.approx(math.radians(0.8), rel=0.05)
    assert not done.reach
    found = done.dataset()
    assert found.settling.sel(frequency=2, joint="II") == done.held[1].settling
    assert np.isnan(found.reach).all()
    assert found.peak.attrs["units"] == "rad"


def test_reach_is_the_limit_and_says_what_it_is(tuna: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    # A joint that makes 15 deg holds any set angle up to 15.5 deg within half a degree.
    monkeypatch.setattr(posture, "twins", beating(0.2, math.radians(15)))
    far = reach(tuna, 1, 3.0)
    assert math.degrees(far.amplitude_max) == pytest.approx(15.5, abs=0.51)
    assert far.limits == ("pressure_soft",)
    monkeypatch.setattr(posture, "twins", beating(0.2, 9.0))
    free = reach(tuna, 1, 3.0)
    assert math.degrees(free.amplitude_max) == pytest.approx(
        31.2
    )  # the largest bend of the description: no more is tried
    assert free.limits == ()


def test_a_run_that_diverges_holds_nothing(tuna: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = beating(0.2, 9.0)

    def diverged(runs: Any, measure: Any) -> Any:
        return whole(runs, lambda run: measure(replace(run, status="diverged")))

    monkeypatch.setattr(posture, "twins", diverged)
    assert reach(tuna, 0, 3.0).amplitude_max == 0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"angle": [0.3]}, "angle must be 2 values, for joint groups I, II, but is 1 long"),
        ({"angle": [0.0, 0.0]}, "angle must have one angle above 0"),
        ({"angle": [0.1, -0.1]}, "and none below, but is 5.72958, -5.72958 deg"),
        ({"frequencies": []}, "frequency must be 1 to 100 values"),
        ({"frequencies": [0.0]}, "frequency must be greater than 0, but is 0"),
        ({"frequencies": [math.nan]}, "frequency must be a finite number, but is nan"),
        ({"duration": 0.5}, "duration must be from two beats to 600 s, but is 0.5 s at 1 Hz"),
        ({"duration": 1e9}, "duration must be from two beats to 600 s"),
        ({"duration": math.nan}, "duration must be from two beats to 600 s"),
    ],
)
def test_what_cannot_be_tested_is_refused(tuna: ht.Robot, change: dict[str, Any], told: str) -> None:
    good: dict[str, Any] = {"frequencies": [1.0], "angle": [0.0, 0.3], "duration": 8.0}
    with pytest.raises(InputError) as error:
        posture_test(tuna, **(good | change))
    assert told in str(error.value)
