"""Angles tracked through ripples: noise of 2 deg that is taken for motion, unless its size and memory are stated."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.identification.identify import Fit, identify
from hypertuna.swimming.beat import settle
from hypertuna.swimming.model import core_model
from hypertuna.trials.manifest import Recording
from hypertuna.trials.replay import head_center, replay
from hypertuna.trials.smoothing import Harmonics, smooth
from hypertuna.trials.tracks import JointSeries, Track
from hypertuna.trials.trials import Trials
from models import changed

RATE, FINE = 60.0, 4  # frames per second, instants of the motion per frame
SD, MEMORY = math.radians(2.0), 8.0  # of the angles; frames
TRUTH = {"drag_tangential": 2.0, "drag_normal": 0.667, "added_mass_normal": 1.25}  # times the file's
FILMS = ((2.5, 5.0), (1.5, 5.0), (4.0, 2.5))  # frequency [Hz] and length [s]


def minnow(factors: dict[str, float]) -> ht.Robot:
    fish = ht.load("examples/minnow.toml")
    strip = fish.document()["water"]["strip"]
    return changed(fish, {f"water.strip.{key}": [f * x for x in strip[key]] for key, f in factors.items()})


def film(frequency: float, seconds: float, seed: int) -> Recording:
    """A settled gait of the true fish, whose angles have noise of first order; poses of 0.3 mm and 0.3 deg."""
    fish, rng = minnow(TRUTH), np.random.default_rng(seed)
    gait = replace(ht.named_gait(fish, "cruise"), frequency=frequency)
    fine = np.arange(0, seconds, 1 / RATE / FINE)
    waves = {kind: list(getattr(gait, kind)) for kind in ("amplitude", "phase", "bias")}
    made = _core.joint_motion(core_model(fish), frequency=frequency, **waves, clock=2 * np.pi * frequency * fine)
    angle = made[:, 1:, 0]
    twist = settle(fish, ht.Gaits.of([gait]))["twist"][0]
    swim = replay(fish, smooth(JointSeries(fine, angle), noise=0.0), twist=tuple(twist))
    time, keep = fine[::FINE], (MEMORY - 1) / (MEMORY + 1)
    noise = rng.standard_normal((len(time), 3))
    for k in range(1, len(noise)):
        noise[k] = keep * noise[k - 1] + math.sqrt(1 - keep**2) * noise[k]
    pose = np.column_stack([np.interp(time, swim.time, axis) for axis in head_center(fish, swim).T])
    pose += rng.standard_normal(pose.shape) * [3e-4, 3e-4, math.radians(0.3)]
    series = JointSeries(time, angle[::FINE] + SD * noise)
    return Recording(f"{frequency:g} Hz", series, None, (Track("0", time, pose),), moving=True, file="films.toml")


def told(recording: Recording) -> Recording:
    """The recording with size and memory of its noise."""
    return replace(recording, noise=(SD, SD, SD), noise_tau=MEMORY / RATE)


@cache
def films(seed: int) -> tuple[Recording, ...]:
    return tuple(film(*one, seed=10 * seed + k) for k, one in enumerate(FILMS))


def held(fit: Fit) -> list[bool]:
    return [row["low"] <= truth <= row["high"] for row, truth in zip(fit.parameters, TRUTH.values(), strict=True)]


def test_a_steady_gait_is_few_harmonics_once_its_noise_is_told() -> None:
    """Untold noise of a memory of 8 frames looks like 0.8 deg of white noise, and a spline follows the rest."""
    for recording in films(2):
        curve, better = recording.smoothed(), told(recording).smoothed()
        assert not isinstance(curve.curves[0], Harmonics)
        assert (curve.noise < SD / 2).all()
        assert isinstance(better.curves[0], Harmonics)
        assert len(better.curves[0].cosine) == 2
        assert better.noise == pytest.approx([SD] * 3)
        # a sine of N / 8 independent samples has errors of about SD sqrt(2 * 8 / N)
        clean, again = better(recording.joints.time)[..., 0], better.drawn(np.random.default_rng(0)).angle
        step = np.diff(again - clean, axis=0)
        assert np.std(again - clean) == pytest.approx(SD, rel=0.2)
        assert np.std(step) == pytest.approx(SD * math.sqrt(2 * (1 - 7 / 9)), rel=0.1)


def test_intervals_hold_the_truth_once_the_noise_is_told() -> None:
    """Thrust of flapping that the noise makes is taken for less drag and added mass; told, the excess is gone."""
    robot = minnow({})
    before = identify(robot, Trials(films(2)), validate=0, starts=1)
    assert held(before) == [False, True, False]
    fit = identify(robot, Trials(tuple(told(one) for one in films(2))), validate=0, starts=1)
    assert held(fit) == [True, True, True]
    off, was = (np.abs(np.log(one.values / list(TRUTH.values()))) for one in (fit, before))
    assert (off[[0, 2]] < 0.7 * was[[0, 2]]).all()


def test_no_interval_is_given_where_none_can_be_estimated() -> None:
    """One film is three measurements: of three coefficients the intervals are those of the priors."""
    fit = identify(minnow({}), Trials((told(films(2)[0]),)), validate=0, starts=1)
    assert any(
        "neither noise nor intervals can be estimated. Intervals are those of the priors" in w for w in fit.warnings
    )
    for row, factor in zip(fit.parameters, (10.0, 1.5, 2.0), strict=True):
        ends = [max(factor**-1.96, row["lower"]), min(factor**1.96, row["upper"])]
        assert [row["low"], row["high"]] == pytest.approx(ends)
        assert not row["constrained"]
    loose = identify(minnow({}), Trials((told(films(2)[0]),)), [f.name for f in fit.free], validate=0, starts=1)
    assert all(math.isnan(row["low"]) and math.isnan(row["high"]) for row in loose.parameters)
    assert "none" in repr(loose)


def test_noise_of_each_joint_is_read() -> None:
    from hypertuna.trials.manifest import Joints

    table = {"file": "a.csv", "columns": ["a", "b"], "unit": "deg"}
    assert Joints.model_validate(table | {"noise_deg": 2}).noise == pytest.approx(SD)
    assert Joints.model_validate(table | {"noise_deg": [2, 1], "noise_tau_s": 0.1}).noise == pytest.approx((SD, SD / 2))
