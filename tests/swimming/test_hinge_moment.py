"""Hinges that a moment drives: closed form of small swings, limit of a stiff spring, powers, phases, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.description.robot import Robot, parse
from hypertuna.description.twin import twin_note
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.yielding import reduced_inertia
from swimming.test_hinge_springs import MOMENT, sprung
from swimming.test_yielding import FREQUENCY, GAIT, hinged, rigid

OMEGA = 2 * math.pi * FREQUENCY
STILL = ht.Gait(FREQUENCY, (0.0,), (0.0,))  # no joint group beats


@pytest.mark.parametrize("hinges", [1, 2])
@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.6, 3.0])
def test_small_swings_in_still_water_are_those_of_a_driven_oscillator(ratio: float, hinges: int) -> None:
    """Amplitude and lag of (K - omega^2 I + i omega C) q = M within 0.1 %; I is that of the free body and its water."""
    robot = sprung(ratio, 0.1, hinges=hinges, moment=1e-5, moment_phase_deg=40.0)
    numbers = (
        np.array([getattr(hinge, name) for hinge in robot.hinges]) for name in ("stiffness", "damping", "moment")
    )
    stiffness, damping, moment = numbers
    impedance = np.diag(stiffness + 1j * OMEGA * damping) - OMEGA**2 * reduced_inertia(robot)
    expected = np.linalg.solve(impedance, moment * np.exp(-1j * math.radians(40.0)))
    bends = ht.swim(robot, STILL, from_rest=30.0).bends
    found = [bend.bend_amplitude * np.exp(-1j * bend.bend_lag) for bend in bends]
    np.testing.assert_allclose(found, expected, rtol=1e-3)


def test_a_beat_that_diverged_has_no_quantities() -> None:
    """A moment that would bend the hinge by 1000 rad; the largest angle was 0, the largest torque 53 N m."""
    beat = ht.swim(sprung(moment=1e3), GAIT)
    assert beat.status == "diverged"
    numbers = [beat.speed, beat.mechanical_power, beat.torque_peak, beat.tail_excursion]
    assert np.isnan([*numbers, *list(vars(beat.bends[0]).values())[1:]]).all()


BOTH = ht.Gait.from_degrees(frequency=FREQUENCY, amplitude=(16, 10), phase=(0, 60))


def with_joint() -> Robot:
    """The fish with a joint group in place of the hinge."""
    document = rigid().document()
    document["joints"] = [
        {**document["joints"][0], "name": name, "links": [k + 1]} for k, name in enumerate(("I", "II"))
    ]
    return parse(document)


def test_a_muscle_at_a_stiff_joint_is_a_prescribed_joint() -> None:
    """The moment k a bends a joint of stiffness k by a: speed and power differ by the first power of 1/k."""
    prescribed = settle(with_joint(), Gaits.of([BOTH]), steps=1024)
    muscle = {"moment": math.radians(10), "moment_phase_deg": 60.0}
    off = []
    for ratio in (100.0, 200.0):
        beat = settle(sprung(ratio, 0.0, **muscle), Gaits.of([GAIT]), steps=1024)
        off.append([float(beat[name][0] / prescribed[name][0] - 1) for name in ("speed", "mechanical_power")])
    assert np.abs(off[0]).max() < 0.05
    np.testing.assert_allclose(np.divide(*off), 2, rtol=0.1)


@pytest.mark.parametrize("ratio", [0.5, 1.6, 20.0])
def test_the_first_harmonic_of_the_torque_nearly_replays_a_prescribed_joint(ratio: float) -> None:
    """Other harmonics, which no moment has, are a hundredth of the torque; without them the speed differs by 3e-4."""
    beat = ht.swim(with_joint(), BOTH)
    torque, angle = (beat.trajectory[name].values[:-1, 2] for name in ("joint_torque", "joint_angle"))
    harmonics = np.abs(np.fft.rfft(torque))
    assert 0.005 < np.hypot.reduce(harmonics[2:]) / harmonics[1] < 0.02
    hinge = hinged(ratio, 0.0).hinges[0]
    moment = np.fft.rfft(torque + hinge.stiffness * angle)[1] * 2j / len(angle)  # Im(moment e^(i omega t)) is the wave
    drive = {"moment_n_m": float(abs(moment)), "moment_phase_deg": -math.degrees(np.angle(moment))}
    replayed = ht.swim(sprung(ratio, 0.0, **drive), GAIT)
    assert replayed.speed == pytest.approx(beat.speed, rel=5e-4)
    assert replayed.mechanical_power == pytest.approx(beat.mechanical_power, rel=1e-3)
    assert replayed.bends[0].bend_amplitude == pytest.approx(BOTH.amplitude[1], rel=5e-4)
    assert replayed.bends[0].bend_lag == pytest.approx(BOTH.phase[1], rel=1e-3)


@pytest.mark.parametrize("hinges", [1, 2, 3])
def test_a_fish_swims_by_moments_alone(hinges: int) -> None:
    """The phase of all moments together changes nothing then, and their work is what water and dampers take."""
    beats = [
        ht.swim(sprung(hinges=hinges, **MOMENT | {"moment_phase_deg": phase}), STILL) for phase in (40.0, 77.0, 220.0)
    ]
    for beat in beats:
        assert beat.settled
        assert beat.reached_from_rest
        assert beat.speed == pytest.approx(beats[0].speed, rel=1e-5)
        taken = beat.power_to_water + sum(bend.damping_power for bend in beat.bends)
        assert beat.mechanical_power == pytest.approx(taken, rel=3e-6)
    assert beats[0].speed > 0.05
    largest = max(hinge.moment for hinge in beats[0].robot.hinges)
    assert beats[0].torque_peak > 0.999 * largest  # of three hinges, that of the joint is less


@pytest.mark.parametrize("gait", [GAIT, STILL])
def test_the_motion_has_the_power_of_the_beat(gait: ht.Gait) -> None:
    beat = ht.swim(sprung(hinges=2, **MOMENT), gait)
    power = beat.trajectory.mechanical_power.values
    assert power[:-1].mean() == pytest.approx(beat.mechanical_power, rel=1e-5)
    assert beat.mechanical_power_positive > beat.mechanical_power


def test_the_twin_refuses_a_moment() -> None:
    """It has no motor there; without the moment it takes the hinge."""
    servo = ht.load("examples/servofish.toml").document()
    spring = {"link": len(servo["links"]["length_m"]) - 1, "stiffness_n_m_per_rad": 0.2}

    def with_moment(moment: float) -> Robot:
        return parse(servo | {"hinge": spring | {"moment_n_m": moment}, "sources": {}})

    robot = with_moment(0.05)
    assert "a moment drives its hinge at link" in twin_note(robot)
    assert not twin_note(with_moment(0.0))
    with pytest.raises(ht.InputError, match="hinge.moment_n_m must be 0 in twin and firmware, .* but is 0.05"):
        ht.twin(robot, next(iter(robot.gaits)), duration=0.1)


def test_hinges_of_a_list_have_moments_of_their_own() -> None:
    """Derivatives by each, and a search over them."""
    robot = sprung(hinges=2, **MOMENT)
    slopes = ht.gradient(robot, GAIT)
    assert {f"hinges[{d}].{name}" for d in (0, 1) for name in ("moment", "moment_phase")} <= {*slopes.names}
    assert hinged(1.6).hinges[0].moment == 0
    found = ht.sweep(robot, Gaits.of([GAIT]), design={"hinges[1].moment_phase": (0.0, 90.0, 180.0)}, threads=1)
    assert np.ptp(np.ravel(found.speed.values)) > 0.01
