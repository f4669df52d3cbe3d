"""The twin at sea: closed forms of what falls, coasts, hangs and rolls; current, surface and bottom; dive and float."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.simulation.sea import space_columns, world_at_sea
from hypertuna.swimming.model import core_model
from models import changed
from oracles.planar import Real

ROBOT = ht.load("hypertuna")
LINKS = len(ROBOT.links.name)
MASS, LENGTH = np.array(ROBOT.links.mass), np.array(ROBOT.links.length)
STILL = ht.Gait.from_degrees(frequency=1, amplitude=(0, 0), phase=(0, 0))
SWIMS = ht.Gait.from_degrees(frequency=3, amplitude=(16, 25), phase=(0, 0))
G = _core.GRAVITY


def each(value: float) -> list[float]:
    return [value] * LINKS


def robot_with(changes: Mapping[str, Any]) -> ht.Robot:
    return changed(ROBOT, changes)


def vertical(robot: ht.Robot) -> tuple[Real, Real]:
    """Mass with what the water adds (n,) [kg], and drag per velocity squared (n,) [kg/m], of links that sink level."""
    assert robot.spatial is not None
    width = np.array(robot.spatial.width)
    added = np.array(robot.spatial.added_mass_vertical) * 1000 * np.pi / 4 * width**2 * np.array(robot.links.length)
    return np.array(robot.links.mass) + added, 500 * np.array(robot.spatial.drag_vertical) * width * robot.links.length


def test_a_level_body_falls_as_the_hyperbolic_tangent_says() -> None:
    """Each link's weight in water, inertia and drag in one proportion, acting in its middle: all fall alike."""
    middle, inertia_share = (LENGTH / 2).tolist(), 0.9
    plain = robot_with({"spatial.added_mass_vertical": each(inertia_share), "fins.span_m": 1e-6, "fins.chord_m": 1e-6})
    assert plain.spatial is not None
    width = np.sqrt(MASS * inertia_share / (1000 * np.pi / 4 * inertia_share * LENGTH))  # added mass 0.9 of the mass
    speed = 0.3
    falling = changed(
        plain,
        {
            "links.com_m": middle,
            "spatial.buoyancy_center_m": middle,
            "spatial.width_m": width.tolist(),
            "spatial.com_height_m": each(0.0),
            # drag at this speed is a fiftieth of each link's weight
            "spatial.drag_vertical": (0.02 * MASS * G / (500 * width * LENGTH * speed**2)).tolist(),
            "spatial.volume_m3": (0.98 * MASS / 1000).tolist(),
        },
    )
    run = ht.twin_at_sea(falling, STILL, duration=12, speed=0.0)
    inertia, drag = vertical(falling)
    assert drag.sum() * speed**2 == pytest.approx(0.02 * MASS.sum() * G)
    rate = speed * drag.sum() / inertia.sum()
    # the step's fourth order leaves 1e-9; noise of the sensors moves the pumps by less than it shows here
    assert run.sink == pytest.approx(speed * np.tanh(rate * run.time), abs=1e-6)
    assert run.depth - 2 == pytest.approx(speed / rate * np.log(np.cosh(rate * run.time)), abs=1e-5)
    assert run.sink[-1] > 0.99 * speed


def test_a_body_coasts_as_its_friction_says() -> None:
    """M du/dt = -q u^2: u = u0 / (1 + q u0 t / M), with the fins' drag along their plates."""
    robot = robot_with({"spatial.com_height_m": each(0.0)})
    assert robot.water.lumped is not None
    assert robot.fins is not None
    mass = (MASS * (1 + np.array(robot.water.lumped.added_mass))).sum()
    drag = 500 * (np.array(robot.water.lumped.friction) * np.array(robot.links.wetted_area)).sum()
    drag += 500 * 2 * robot.fins.span * robot.fins.chord * robot.fins.drag_zero
    run = ht.twin_at_sea(robot, STILL, duration=10, speed=0.5)
    assert run.speed == pytest.approx(0.5 / (1 + drag * 0.5 * run.time / mass), abs=1e-6)
    assert run.position[-1, 1] == pytest.approx(mass / drag * np.log(1 + drag * 0.5 * run.time[-1] / mass), abs=1e-5)


def test_a_towed_body_reaches_the_speed_at_which_its_drag_is_the_pull() -> None:
    """Nose down, its weight in water tows it along its axis: M du/dt = W - q u^2, u = U tanh(q U t / M)."""
    aft = (np.array(ROBOT.document()["spatial"]["buoyancy_center_m"]) + 0.01).tolist()  # so that the nose stays down
    robot = robot_with(
        {
            "spatial.com_height_m": each(0.0),
            "spatial.volume_m3": (0.99 * MASS / 1000).tolist(),
            "spatial.buoyancy_center_m": aft,
        }
    )
    assert robot.water.lumped is not None
    assert robot.fins is not None
    mass = (MASS * (1 + np.array(robot.water.lumped.added_mass))).sum()
    drag = 500 * (np.array(robot.water.lumped.friction) * np.array(robot.links.wetted_area)).sum()
    drag += 500 * 2 * robot.fins.span * robot.fins.chord * robot.fins.drag_zero
    run = ht.twin_at_sea(robot, STILL, duration=15, speed=0.0, pitch=-math.pi / 2, depth=2)
    terminal = math.sqrt(0.01 * MASS.sum() * G / drag)
    assert run.speed == pytest.approx(terminal * np.tanh(drag * terminal * run.time / mass), abs=1e-5)
    assert run.speed[-1] > 0.95 * terminal


def test_displaced_centers_trim_the_body() -> None:
    """2 mm behind and 10 mm above: the tail rises until the center of buoyancy stands over that of mass."""
    center = list(ROBOT.document()["spatial"]["buoyancy_center_m"])
    center[0] += 0.002
    robot = robot_with({"spatial.buoyancy_center_m": center})
    trim = -math.atan(0.2)
    run = ht.twin_at_sea(robot, STILL, duration=5, speed=0.0, pitch=trim)
    assert run.pitch == pytest.approx(trim, abs=1e-4)
    off = ht.twin_at_sea(robot, STILL, duration=60, speed=0.0, pitch=trim + 0.2)
    swings = off.pitch[-1000:]
    assert (swings.max() + swings.min()) / 2 == pytest.approx(trim, abs=0.01)


def test_a_body_rolls_with_the_period_of_its_pendulum() -> None:
    """Sway and yaw give way: the moment of inertia about the axis is less by what they take."""
    robot = robot_with({"spatial.drag_roll": each(0.0)})
    assert robot.spatial is not None
    assert robot.water.lumped is not None
    height, width = np.array(robot.spatial.height), np.array(robot.spatial.width)
    low = -np.array(robot.spatial.com_height)
    place = np.cumsum(LENGTH) - LENGTH + np.array(robot.links.com)
    sideways = MASS * (1 + np.array(robot.water.lumped.added_mass))
    roll = (MASS * ((height**2 + width**2) / 20 + low**2)).sum()
    roll += (1000 * np.pi / 128 * (height**2 - width**2) ** 2 * LENGTH).sum()
    give = np.array([(MASS * low).sum(), (MASS * low * place).sum()])
    turning = (np.array(robot.links.inertia) + sideways * place**2).sum()
    across = np.array([[sideways.sum(), (sideways * place).sum()], [(sideways * place).sum(), turning]])
    inertia = roll - give @ np.linalg.solve(across, give)
    period = 2 * np.pi * np.sqrt(inertia / ((MASS * low).sum() * G))
    run = ht.twin_at_sea(robot, STILL, duration=12, speed=0.0, roll=math.radians(1))
    crossing = np.flatnonzero((run.roll[:-1] < 0) & (run.roll[1:] >= 0))
    exact = run.time[crossing] - run.roll[crossing] * run.tick / (run.roll[crossing + 1] - run.roll[crossing])
    # the tail's joints give a little, the fins' drag takes a little
    assert np.diff(exact).mean() == pytest.approx(period, rel=0.01)
    assert len(crossing) > 5


def test_a_uniform_current_carries_everything_alike() -> None:
    sea = ht.Sea(current=(0.2, -0.1))
    options: dict[str, Any] = {"duration": 4, "fins": -0.4, "heading": 0.7}
    still, carried = ht.twin_at_sea(ROBOT, SWIMS, **options), ht.twin_at_sea(ROBOT, SWIMS, **options, sea=sea)
    drift = still.time[:, np.newaxis] * np.array([0.2, -0.1, 0.0])
    assert carried.position - still.position == pytest.approx(drift, abs=1e-12)
    assert (carried.attitude == still.attitude).all()
    assert (carried.data["pump_pressure"] == still.data["pump_pressure"]).all()


def test_sinking_into_slower_water_the_body_outruns_it() -> None:
    """Rigid masses keep their way, displaced water does not: M du/dt = -m dw/dt, dw/dt = w'(z) dz/dt."""
    sea = ht.Sea(current=(0.0, -0.4), current_bottom=(0.0, 0.0), bottom=10.0)  # toward the tail of a body facing north
    robot = robot_with({"spatial.com_height_m": each(0.0), "fins.span_m": 1e-6, "fins.chord_m": 1e-6})
    attitude = [math.cos(-math.pi / 4), 0, 0, math.sin(-math.pi / 4)]
    body = _core.Body(core_model(ROBOT), {"share": np.eye(LINKS)[:, 1:2]} | space_columns(robot))
    got = body.accelerations(
        world_at_sea(robot, sea),
        bend=np.zeros((1, 2, 1)),
        twist=np.array([[0, 0, -0.5, 0, 0, 0.0]]),
        pose=np.array([[0, 0, -5.0, *attitude, 0, 0]]),
        moment=np.zeros((1, 1)),
    )[0]
    assert ROBOT.water.lumped is not None
    whole = (MASS * (1 + np.array(ROBOT.water.lumped.added_mass))).sum()
    gain = -0.04 * 0.5  # the current toward the tail falls by 0.04 1/s times 0.5 m/s
    # sinking also pitches it, but not yet: its rate of turn is zero
    assert got[0] == pytest.approx(-gain * MASS.sum() / whole, rel=1e-9)


def test_it_floats_where_what_is_under_water_carries_it() -> None:
    """Sections of one height, 2 % too light: s^2 (3 - 2 s) = 1 / 1.02 of a height is under water."""
    level = {"spatial.height_m": each(0.12), "spatial.com_height_m": each(-0.01)}
    robot = robot_with(level | {"spatial.volume_m3": (1.02 * MASS / 1000).tolist()})
    run = ht.twin_at_sea(robot, STILL, duration=60, depth=0.3, speed=0.0)
    roots = np.roots([-2, 3, 0, -1 / 1.02])
    (share,) = [r.real for r in roots if abs(r.imag) < 1e-12 and 0 < r.real < 1]
    assert run.averaged(run.depth)[-300] == pytest.approx(0.12 * (share - 0.5), abs=2e-3)
    assert run.depth.min() > -0.05


def test_it_comes_to_rest_on_the_bottom() -> None:
    robot = robot_with({"spatial.volume_m3": (0.97 * MASS / 1000).tolist()})
    run = ht.twin_at_sea(robot, STILL, duration=30, depth=1.0, speed=0.0, sea=ht.Sea(bottom=2.0))
    assert run.status == "completed"
    assert abs(run.sink[-100:]).max() < 0.01
    assert run.depth[-1] == pytest.approx(2.0, abs=0.01)
    assert run.depth.max() < 2.02


def test_neutral_buoyancy_holds_the_depth_and_nothing_drifts() -> None:
    run = ht.twin_at_sea(ROBOT, STILL, duration=30, speed=0.0)
    assert run.depth == pytest.approx(2.0, abs=1e-6)
    assert abs(run.pitch).max() < 1e-6
    assert abs(run.angles).max() < 2e-3  # the sensors' noise moves the pumps, they the tail
    assert np.linalg.norm(run.attitude, axis=1) == pytest.approx(1, abs=1e-15)


def test_level_at_depth_it_swims_as_in_the_plane() -> None:
    """Fins level: their drag apart, the speed is the planar twin's, and it rolls and pitches by a few degrees only."""
    no_drag = robot_with({"fins.drag_zero": 0.0})
    run = ht.twin_at_sea(no_drag, SWIMS, duration=15)
    planar = ht.twin(ROBOT, SWIMS, duration=15, start="swimming")
    assert run.averaged(run.speed)[-300] == pytest.approx(planar.data["speed"][-300:].mean(), rel=0.02)
    assert abs(np.degrees(run.roll)).max() < 3
    assert abs(np.degrees(run.averaged(run.pitch))).max() < 5


def test_fins_down_it_dives_and_fins_up_it_floats() -> None:
    """As in Fig. 15: -45, then 45 degrees, at 3 Hz; the pitch stays."""
    down, up = (ht.twin_at_sea(ROBOT, SWIMS, duration=20, depth=5, fins=math.radians(a)) for a in (-45, 45))
    rates = [run.sink[-600:].mean() for run in (down, up)]
    assert rates[0] > 0.05
    assert rates[1] < -0.05
    assert rates[0] == pytest.approx(-rates[1], rel=0.25)
    for run in (down, up):
        pitch = np.degrees(run.averaged(run.pitch))
        assert np.ptp(pitch[1200:-100]) < 0.5, "it is steady"
        assert abs(pitch).max() < 12


def test_roll_in_step_with_yaw_trims_the_nose_down() -> None:
    """(I_z - I_x) <p r> ~ m g h sin(pitch), with the weight's depth h: the trim is as the mean product over h."""
    assert ROBOT.spatial is not None
    trims, products = [], []
    for low in (0.01, 0.015):
        robot = robot_with({"spatial.com_height_m": [-low, *each(0.0)[1:]]})
        run = ht.twin_at_sea(robot, SWIMS, duration=25, depth=3)
        rates = run.data["turn_rate"][-600:]
        trims.append(np.degrees(run.pitch[-600:].mean()))
        products.append((rates[:, 0] * rates[:, 2]).mean() / low)
    assert max(trims) < -0.5
    assert products[1] / products[0] == pytest.approx(trims[1] / trims[0], rel=0.1)
    assert products[1] == pytest.approx(products[0], rel=0.25)  # the roll grows with h, and so does what rights it


def test_without_what_the_hull_sheds_it_would_not_keep_its_pitch() -> None:
    """The finding that the coefficient is there for: a potential flow's moment alone turns the hull across."""
    bare = robot_with({"spatial.shedding_vertical": 0.0})
    run = ht.twin_at_sea(bare, SWIMS, duration=20, depth=5)
    assert np.ptp(np.degrees(run.averaged(run.pitch))[1000:]) > 20


def test_one_fin_stuck_rolls_it_but_does_not_turn_it_over() -> None:
    run = ht.twin_at_sea(ROBOT, SWIMS, duration=15, depth=5, fins=(0.0, math.radians(45)))
    assert -30 < np.degrees(run.averaged(run.roll)[-300]) < -2, "the starboard fin lifts its side"
    assert run.status == "completed"


def test_steps_converge() -> None:
    coarse, fine = (
        ht.twin_at_sea(ROBOT, SWIMS, duration=3, fins=-0.5, depth=0.1, roll=0.3, step=step)
        for step in (1 / 3000, 1 / 12000)
    )
    assert coarse.position[-1] == pytest.approx(fine.position[-1], abs=2e-4)
    assert coarse.angles[-1] == pytest.approx(fine.angles[-1], abs=2e-3)


def test_a_seed_repeats_to_the_last_bit_and_fewer_rows_are_the_same_rows() -> None:
    options: dict[str, Any] = {"duration": 1, "fins": lambda t: (0.2 * t, -0.2 * t), "seed": 3}
    a, b = ht.twin_at_sea(ROBOT, SWIMS, **options), ht.twin_at_sea(ROBOT, SWIMS, **options, every=7)
    for name in a.data:
        assert (a.data[name][::7] == b.data[name]).all(), name
    assert b.time == pytest.approx(a.time[::7])
    assert a.data["fin"][-1] == pytest.approx([0.2, -0.2], abs=0.1)
    assert a.dataset()["position"].attrs["units"] == "m"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fins": 2.0}, r"fins must be at most 45 deg, the controller.fin_max_deg, but is 114.592 deg: give less"),
        ({"fins": "up"}, r"fins must be one angle, or one for each fin"),
        ({"depth": -1.0}, r"depth must be from 0 to the bottom at inf m"),
        ({"depth": 5.0, "sea": ht.Sea(bottom=4.0)}, r"depth must be from 0 to the bottom at 4 m, but is 5"),
        ({"pitch": math.nan}, r"pitch must be a finite number"),
        ({"every": 0}, r"every must be at least 1"),
    ],
)
def test_bad_input_gives_one_sentence(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ht.twin_at_sea(ROBOT, SWIMS, **({"duration": 1} | options))


def test_a_robot_without_tables_is_told_which() -> None:
    for table in ("spatial", "fins"):
        document = {key: value for key, value in ROBOT.document().items() if key != table}
        document["sources"] = {k: v for k, v in document["sources"].items() if not re.match(rf"{table}\b", k)}
        robot = parse(document)
        with pytest.raises(InputError, match=rf"\[{table}\] is missing: copy it and its lines of"):
            ht.twin_at_sea(robot, SWIMS, duration=1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"current": (1.0,)}, "current must be two numbers"),
        ({"current": (20.0, 0.0)}, "current must be at most 10 m/s"),
        ({"current_bottom": (0.1, 0.0)}, "current_bottom needs the depth of the bottom"),
        ({"bottom": 0.0}, "bottom must be greater than 0"),
        ({"dip": math.inf}, "dip must be a finite number"),
    ],
)
def test_a_bad_sea_gives_one_sentence(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ht.Sea(**options)
