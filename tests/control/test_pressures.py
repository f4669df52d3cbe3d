"""The pressure that no circuit passes: the worst random twins of validation/control, and what the guard costs."""

from functools import cache

import numpy as np
import pressures
import pytest
from pressures import TICK, Order, Sample, run_of

import hypertuna as ht
from hypertuna.description.changes import changed

# The worst of 1,564 random twins of an earlier HyperTuna without a limit on the rate of a pump, and of 200 of today's.
WORST = [1226, 190, 1258, 107, 382, 559, 226, 1452, 1546, 683, 353, 463, 27, 797, 1515, 908, 944, 995, 766, 513, 891]
WORST += [284, 67, 212, 55, 44, 8, 158, 73, 135]
WORST += [8952]  # with the limit, as long as a sensor that repeats itself was believed
LOW = {"work": 200e3, "soft": 250e3, "hard": 300e3}  # Pa, limits that the same gaits pass otherwise
LOW_HARD = 1.05e-3 * LOW["hard"]  # kPa


def limited(pressures: dict[str, float]) -> ht.Robot:
    """HyperTuna with other limits of its pressure."""
    robot = ht.load("hypertuna")
    return changed(robot, {f"controller.pressure_{name}_pa": pressure for name, pressure in pressures.items()})


@cache
def peak(seed: int, low: bool) -> float:
    """Largest pressure [kPa] of a random twin, with its own limits or the low ones."""
    with pytest.MonkeyPatch.context() as patch:
        if low:
            patch.setattr(pressures, "ROBOT", limited(LOW))
            patch.setattr(pressures, "robot_at", pressures.robot_at.__wrapped__)
        run = pressures.row(seed)
    assert run["status"] == "completed"
    return max(float(run["peak_kpa"]), float(run["unit_kpa"]))


@pytest.mark.parametrize("seed", WORST)
def test_the_worst_random_twins_keep_the_hard_limit(seed: int) -> None:
    """Gaits to 8 Hz, steps of the command, faulty sensors, oil of -9 to 60 C, air and water."""
    assert peak(seed, low=False) < pressures.HARD
    assert peak(seed, low=True) < LOW_HARD


def test_the_limits_hold_the_worst_random_twins() -> None:
    """By its own limits most of them pass the low ones: nothing but these holds them there."""
    assert np.mean([peak(seed, low=False) > LOW_HARD for seed in WORST]) > 0.8


def test_a_gait_keeps_its_speed() -> None:
    """The limits act on transients and faults: a steady gait is as fast as with half as high ones again."""
    robot = ht.load("hypertuna")
    control = robot.controller
    assert control is not None
    limits = {name: 1.5 * float(getattr(control, f"pressure_{name}")) for name in LOW}
    limits["hard"] = min(limits["hard"], 0.99e6)  # below what the sensor reads
    own, free = (ht.twin(fish, "optimised-0.3", duration=20.0, seed=1) for fish in (robot, limited(limits)))
    np.testing.assert_allclose(own.speed, free.speed, rtol=1e-3)


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_without_pressure_sensors_still_steers(side: int) -> None:
    """The bias changes its side after they failed: joint II follows, or the robot could turn to one side only."""
    swing, phase, bias = np.radians((8, 12)), (0.0, 0.7), side * np.radians((8, 11))
    orders = [Order(since, 2.0, tuple(swing), phase, tuple(b), True) for since, b in ((0.0, bias), (2.5, -bias))]
    record, _ = run_of(1, Sample(20.0, False, 7.4, tuple(orders), ("pressure-II:nan@2",)))
    mean = record["angle"][-round(1 / TICK) :, 1].mean()  # of the last two beats
    np.testing.assert_allclose(mean, -bias[1], rtol=0.15)
