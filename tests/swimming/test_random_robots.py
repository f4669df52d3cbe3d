"""Random robots: speeds that are speeds, wakes that give no energy, beats that say where a start from rest leads."""

from __future__ import annotations

import math

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.swimming.beat import settle
from hypertuna.swimming.model import core_model
from models import changed
from random_robots import random_gaits, random_robot

FASTEST = 10.0  # body lengths a beat: no swimmer is faster
BEATS = 1500  # from rest
# Gaits that settle elsewhere from rest, of random robots with a tenth of the drag across (with all of it, none of 6,000
# does): seed of the robot, number of the gait among 60.
AWAY = ((4, 54), (11, 2), (19, 5))
WAKE = {"strip": "water.strip.tail_shedding", "elongated": "water.elongated.added_mass_edge"}  # 0: drag alone
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


def with_fin(robot: ht.Robot, seed: int, own: bool) -> ht.Robot:
    """The robot on strips that sheds at the end of its last link, or from a fin of its own with random numbers."""
    random = np.random.default_rng(seed)
    height = robot.links.lateral_area[-1] / robot.links.length[-1]
    aspect, lift, mass = random.uniform(0.5, 8.0), random.uniform(0.2, 1.0) if own else 1.0, random.uniform(0.3, 1.0)
    suction = min(1.0, 4 * mass / (aspect * lift * (1 - lift / 2))) * random.choice([0.0, 1.0])
    fin = {"tail_shedding": random.uniform(0.6, 1.0), "edge_lift": lift, "edge_suction": suction}
    fin |= {"edge_height_m": own * height * random.uniform(0.5, 2.0), "edge_aspect": own * aspect}
    return changed(robot, {f"water.strip.{key}": value for key, value in (fin | {"edge_added_mass": mass}).items()})


@pytest.mark.parametrize("fin", ["last link", "own", "elongated"])
@pytest.mark.parametrize("seed", range(3))
def test_no_wake_gives_energy_and_joints_do_the_work_of_all_losses(fin: str, seed: int) -> None:
    """At every instant of settled beats the water takes at least the drag's power; hinge work = wake + drag."""
    robot = random_robot(6 * seed + (5 if fin == "elongated" else 1))
    robot = robot if fin == "elongated" else with_fin(robot, seed, fin == "own")
    still, taken = core_model(changed(robot, {WAKE[robot.model.water]: 0.0})), 0.0
    for gait in list(random_gaits(robot, 16, seed))[::2]:
        swim = ht.swim(robot, gait, steps=512)
        motion, joints = swim.trajectory, np.zeros((513, len(robot.links.name), 3))
        joints[:, :, 0], joints[:, :, 1] = motion.joint_angle, motion.joint_rate
        drag = _core.dynamics(still, joints, np.stack([motion[name] for name in "uvr"], axis=-1))["loss"]
        wake = motion.power_to_water.values - drag
        assert swim.settled
        assert wake.min() > -1e-12 * drag.max()
        assert swim.mechanical_power == pytest.approx(swim.power_to_water, rel=1e-6)
        taken = max(taken, wake.mean() / drag.mean())
    assert taken > 0.01  # it is a wake


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
