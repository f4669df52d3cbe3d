"""Random robots: speeds that are speeds, and settled beats that say whether a start from rest leads to them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.swimming.beat import settle
from models import changed
from random_robots import random_gaits, random_robot

FASTEST = 10.0  # body lengths a beat: no swimmer is faster
BEATS = 1500  # from rest
# Gaits that settle elsewhere from rest, of random robots with a tenth of the drag across (with all of it, none of 6,000
# does): seed of the robot, number of the gait among 60.
AWAY = ((11, 2), (19, 5), (58, 43))
SPINS = ((6, 55), (7, 49), (9, 7))  # these turn the body by more than half a circle a beat


def find(seed: int, k: int) -> tuple[ht.Robot, ht.Gait]:
    robot = random_robot(seed)
    return robot, random_gaits(robot, 100, seed)[k]


@pytest.mark.parametrize("seed", range(6))
def test_every_settled_beat_is_where_a_start_from_rest_ends_or_says_that_it_is_not(seed: int) -> None:
    robot = random_robot(seed)
    gaits = random_gaits(robot, 40, seed)
    found = ht.sweep(robot, gaits, check_rest=True, threads=1)
    swum = settle(robot, gaits, wait=BEATS)  # plain beats, no search
    settled, reached = found.settled.values, found.reached_from_rest.values
    assert settled.mean() > 0.8
    assert (settled | ~reached).all()
    ends = np.where(np.isfinite(found.speed_from_rest), found.speed_from_rest, found.speed)
    stride = 1e-3 * gaits.frequency * robot.body.length
    assert (np.abs(swum["speed"] - ends) < 1e-2 * np.abs(ends) + stride)[settled & np.isfinite(ends)].all()
    assert not (np.abs(found.stride_length.values[settled]) > FASTEST).any()


@pytest.mark.parametrize(("seed", "k"), AWAY)
def test_both_beats_are_returned_where_a_start_from_rest_leads_elsewhere(seed: int, k: int) -> None:
    robot = random_robot(seed)
    key = f"water.{robot.model.water}.drag_normal"
    drag = robot.document()["water"][robot.model.water]["drag_normal"]
    robot, gait = changed(robot, {key: [0.1 * one for one in drag]}), random_gaits(robot, 60, seed)[k]
    swim = ht.swim(robot, gait)
    other = swim.settled_from_rest
    assert swim.settled
    assert swim.reached_from_rest is False
    assert other is not None
    assert other.settled
    assert other.speed != pytest.approx(swim.speed, rel=0.1)
    assert f"From rest the robot settles into another motion instead: {other.speed:.4g} m/s, in " in swim.status_text
    waited = ht.swim(robot, gait, from_rest=(BEATS + 0.5) / gait.frequency)
    assert waited.settled  # though it is not where Newton's method ends
    assert waited.speed == pytest.approx(other.speed, rel=1e-3)


@pytest.mark.parametrize(("seed", "k"), SPINS)
def test_a_body_that_spins_has_no_speed(seed: int, k: int) -> None:
    robot, gait = find(seed, k)
    swim = ht.swim(robot, gait)
    turn = abs(swim.turn_rate) / gait.frequency
    assert swim.settled
    assert turn > math.pi
    for name in (
        "speed",
        "speed_bl",
        "cost_of_transport",
        "strouhal",
        "stride_length",
        "tail_excursion",
        "turn_radius",
    ):
        assert math.isnan(getattr(swim, name)), name
    assert swim.mechanical_power > 0
    assert f"It spins: {math.degrees(turn):.0f} deg a beat, more than half a circle, is no path" in swim.status_text
    assert ht.swim(robot, gait, from_rest=(BEATS + 0.5) / gait.frequency).settled
    with pytest.raises(ht.InputError, match="must have a speed to have derivatives"):
        ht.gradient(robot, gait)


def test_the_ordinary_case_says_that_a_start_from_rest_leads_there(tuna: ht.Robot) -> None:
    swim = ht.swim(tuna, tuna_gait())
    assert swim.reached_from_rest is True
    assert swim.settled_from_rest is None
    assert swim.status_text.endswith(" beats.")


def tuna_gait() -> ht.Gait:
    return ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))


def test_a_sweep_says_whether_starts_were_checked(tuna: ht.Robot) -> None:
    plain, checked = (ht.sweep(tuna, [tuna_gait()], check_rest=check) for check in (False, True))
    assert plain.attrs["check_rest"] == 0
    assert "reached_from_rest" not in plain
    assert checked.attrs["check_rest"] == 1
    assert bool(checked.reached_from_rest[0])
    assert float(checked.speed_from_rest[0]) == float(checked.speed[0]) == float(plain.speed[0])
    with pytest.raises(ht.InputError, match="must be by newton to check starts from rest"):
        ht.sweep(tuna, [tuna_gait()], check_rest=True, method="beats")
