"""A hinge's rest angle, cubic term, stops, and the moment that drives it, against closed forms and other code."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipk

import hypertuna as ht
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, parse
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model
from hypertuna.swimming.yielding import given_springs, key_of, reduced_inertia, spring_values
from swimming.test_yielding import FREQUENCY, GAIT, GAITS, hinged, oracle_rate, rigid

REST, STOP, HARD = 12.0, 14.0, 30.0  # deg, deg, stiffness of a stop over that of the spring


def sprung(ratio: float = 1.6, zeta: float = 0.05, *, hinges: int = 1, **changes: Any) -> Robot:
    """The fish of the other tests, with more keys in each hinge; cubic and moment are over the stiffness [SI]."""
    document = hinged(ratio, zeta, hinges=hinges).document()
    for table in [document["hinge"]] if hinges == 1 else document["hinges"]:
        more = dict(changes)
        for name, key in (("cubic", "cubic_n_m_per_rad3"), ("moment", "moment_n_m")):
            if name in more:
                more[key] = more.pop(name) * table["stiffness_n_m_per_rad"]
        if "stop_deg" in more:
            more.setdefault("stop_stiffness_n_m_per_rad", HARD * table["stiffness_n_m_per_rad"])
            more.setdefault("stop_dissipation_n_m_s_per_rad2", 0.5 * more["stop_stiffness_n_m_per_rad"])
        table |= more
    return parse(document)


MOMENT = {"moment": 0.2, "moment_phase_deg": 40.0}  # of a muscle that would bend the hinge by 0.2 rad
KINDS: dict[str, dict[str, Any]] = {
    "moment": MOMENT,
    "rest": {"rest_deg": REST},
    "cubic": {"cubic": 10.0},
    "stops": {"stop_deg": 13.0},
    "all": {"rest_deg": 3.0, "cubic": 5.0, "stop_deg": STOP},
}


def free_swing(robot: Robot, angle: float, rate: float, seconds: float) -> Array:
    """Time, angle and rate (3, 5001) of the hinge [s, rad], let go in still water."""
    inertia, steps = float(reduced_inertia(robot)[0, 0]), 5000
    state = np.array([0.0, 0.0, 0.0, angle, inertia * rate])  # the body without momentum
    still = Gaits.of([ht.Gait(1 / seconds, (0.0,), (0.0,))])
    springs, at = np.array([[*spring_values(robot).values()]]), dict[str, Any](steps=steps, count=steps + 1)
    bends = _core.yield_bends(core_model(robot), [2], springs, *still.columns, state, **at)
    return np.vstack([np.linspace(0, seconds, steps + 1), bends[:, 0, :2].T])


def thin(ratio: float, **changes: Any) -> Robot:
    """The fish with an undamped hinge in water that drags nothing."""
    document = sprung(ratio, 0.0, **changes).document()
    none = {name: [0.0] * 3 for name in ("drag_normal", "drag_tangential", "blunt_area_m2")}
    document["water"]["strip"] |= none | {"edge_lift": 0.0}
    return parse(document)


@pytest.mark.parametrize("hardening", [0.1, 1.0, 10.0])
def test_a_cubic_spring_swings_as_duffings_oscillator(hardening: float) -> None:
    """A quarter of a free swing without drag takes the time that an elliptic integral gives, at any amplitude."""
    amplitude = 0.01
    robot = thin(1.0, cubic=hardening / amplitude**2)
    hinge, inertia = robot.hinge, float(reduced_inertia(robot)[0, 0])
    assert hinge is not None
    straight = hinge.stiffness + hinge.cubic * amplitude**2
    quarter = float(ellipk(hinge.cubic * amplitude**2 / (2 * straight))) * math.sqrt(inertia / straight)
    time, angle, _ = free_swing(robot, amplitude, 0.0, 1.2 * quarter)
    assert np.interp(0.0, -angle, time) == pytest.approx(quarter, rel=1e-4)


@pytest.mark.parametrize("speed", [0.2, 1.0, 5.0])
def test_a_stop_returns_what_hunt_and_crossley_say(speed: float) -> None:
    """Bend and speed of the rebound against the first integral of I q'' = -K x (1 + a q')."""
    stiffness, dissipation = 200.0, 1.0  # N m/rad, s/rad
    keys = {"stop_stiffness_n_m_per_rad": stiffness, "stop_dissipation_n_m_s_per_rad2": stiffness * dissipation}
    robot, stop = thin(0.01, stop_deg=0.5, **keys), math.radians(0.5)
    inertia = float(reduced_inertia(robot)[0, 0])

    def integral(v: float) -> float:
        return v / dissipation - math.log1p(dissipation * v) / dissipation**2

    beyond = math.sqrt(2 * inertia * integral(speed) / stiffness)
    back = brentq(lambda v: integral(v) - integral(speed), -1 / dissipation + 1e-12, -1e-9)
    _, angle, rate = free_swing(robot, stop, speed, 2 * math.pi * math.sqrt(inertia / stiffness))
    assert angle.max() - stop == pytest.approx(beyond, rel=2e-3)
    left = int(np.flatnonzero(angle[1:] < stop)[0]) + 1
    assert rate[left] == pytest.approx(back, rel=2e-3)
    assert -back < speed


def test_stops_hold_a_bend_within_their_compression() -> None:
    """A beat compresses a stop by what stops a hinge of its largest rate and its load, undamped, at most."""
    bends = {}
    for hard in (30.0, 120.0, 480.0):
        robot = sprung(0.6, stop_deg=10.0)
        hinge, stop = robot.hinge, math.radians(10.0)
        assert hinge is not None
        robot = sprung(0.6, stop_deg=10.0, stop_stiffness_n_m_per_rad=hard * hinge.stiffness)
        beat = ht.swim(robot, GAIT)
        assert beat.settled
        motion, inertia = beat.trajectory, float(reduced_inertia(robot)[0, 0])
        angle, rate = (motion[name].values[:, 2] for name in ("joint_angle", "joint_rate"))
        free = abs(angle) < stop
        load = abs(inertia * np.gradient(rate, motion.time.values) + hinge.stiffness * angle)[free].max()
        stiff = hard * hinge.stiffness
        bends[hard] = beat.bends[0].bend_peak - stop
        assert 0 < bends[hard] < math.sqrt(inertia / stiff) * abs(rate).max() + 2 * load / stiff
    assert bends[30.0] > 1.5 * bends[120.0] > 2.25 * bends[480.0]


def test_beats_from_rest_equal_an_independent_velocity_form() -> None:
    """With all that a hinge can have, at once; the tail strikes its stops."""
    robot = sprung(**KINDS["all"], **MOMENT)
    motion = ht.swim(robot, GAIT, from_rest=1.0, steps=1024).trajectory
    first, last = motion.isel(time=0), motion.isel(time=-1)
    hinge = robot.hinge
    assert hinge is not None
    start = [0, 0, 0, *(float(first[name]) for name in ("u", "v", "r")), hinge.rest, float(first.joint_rate[2])]
    assert float(first.joint_angle[2]) == hinge.rest
    rate = oracle_rate(robot, GAIT)
    found = solve_ivp(rate, (0, 1.0), start, method="DOP853", rtol=1e-7, atol=1e-9, max_step=0.005)
    end = found.y[:, -1]
    for name, value in zip(("x", "y", "heading"), end, strict=False):
        assert float(last[name]) == pytest.approx(value, abs=2e-5)
    assert float(last.joint_angle[2]) == pytest.approx(end[6], abs=5e-5)
    assert abs(motion.joint_angle[:, 2] - hinge.rest).max() > math.radians(STOP)


def test_a_tail_rests_at_its_rest_angle() -> None:
    """In still water without a beat; the twin's tests have the same."""
    still = ht.swim(sprung(rest_deg=REST), ht.Gait(FREQUENCY, (0.0,), (0.0,)), from_rest=4.0)
    np.testing.assert_allclose(still.trajectory.joint_angle[:, 2], math.radians(REST), atol=1e-12)
    assert abs(still.trajectory.x).max() < 1e-12


def test_a_rest_angle_turns_the_fish_as_a_bias_of_that_joint() -> None:
    """Of a stiff hinge the yaw rate is that of a prescribed joint with this bias, and it changes its sign."""
    document = rigid().document()
    document["joints"] = [*document["joints"], {**document["joints"][0], "name": "II", "links": [2]}]
    document["joints"][0]["links"] = [1]
    gait = ht.Gait.from_degrees(frequency=FREQUENCY, amplitude=(16, 0), phase=(0, 0), bias=(0, REST))
    biased = settle(parse(document), Gaits.of([gait]))["turn_rate"][0]
    stiff, mirrored = (settle(sprung(500.0, rest_deg=side * REST), GAITS)["turn_rate"][0] for side in (1, -1))
    assert stiff == pytest.approx(biased, rel=0.02)
    assert mirrored == pytest.approx(-stiff, rel=1e-6)
    soft = settle(sprung(rest_deg=REST), GAITS)["turn_rate"][0]
    assert soft * stiff > 0


@pytest.mark.parametrize("hinges", [1, 2])
@pytest.mark.parametrize("kind", ["rest", "cubic", "moment"])
def test_work_in_is_what_water_and_dampers_take(kind: str, hinges: int) -> None:
    """To 1e-6 at 128 steps where nothing has kinks, 3e-6 with two hinges that harden; less by far at 256."""
    off = [abs(balance(settle(sprung(hinges=hinges, **KINDS[kind]), GAITS, steps=steps))) for steps in (128, 256)]
    assert off[0] < (1e-6 if hinges == 1 else 3e-6)
    assert off[1] < 0.5 * off[0]


def test_what_stops_cost_is_told_by_the_balance() -> None:
    """The kinks of stops: 1.3e-5 at the steps that they and their dissipation ask for, 2e-6 at 2048."""
    robot = sprung(stop_deg=STOP)
    off = [abs(balance(settle(robot, GAITS, steps=steps))) for steps in (128, 2048)]
    assert off[0] < 5e-5
    assert off[1] < 0.2 * off[0]


def balance(beat: dict[str, Any]) -> float:
    """Return the work of the driven joint and of moments over what water, dampers and stops take, less one."""
    taken = beat["power_to_water"][0] + sum(beat[name][0] for name in beat if name.startswith("damping_power"))
    return float(beat["mechanical_power"][0] / taken - 1)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_equal_differences(kind: str) -> None:
    """By all numbers that the file gives of the spring.

    With stops a search may end within 1e-8 of a stride, where others end at rounding. Derivatives are then off by up to
    2e-5.
    """
    near = 3e-5 if "stop" in "".join(KINDS[kind]) else 1e-6
    robot, steps = sprung(**KINDS[kind]), 512
    slopes = ht.gradient(robot, GAIT, steps=steps)
    names = [name for name in slopes.names if name.startswith("hinge.")]
    assert names == given_springs(robot)
    for name in names:
        h, values, key = 1e-5, [], key_of(name.removeprefix("hinge."))
        for side in (1, -1):
            changed = robot.document()
            changed["hinge"][key] *= 1 + side * h
            values.append(settle(parse(changed), GAITS, steps=steps))
        for quantity in ("speed", "mechanical_power"):
            numeric = (values[0][quantity][0] - values[1][quantity][0]) / (2 * h)
            k, value = slopes.names.index(name), slopes.results[quantity]
            exact = slopes.derivatives[quantity][k] * slopes.values[k]
            assert exact == pytest.approx(numeric, rel=near, abs=1e-6 * abs(value)), (name, quantity)


def test_where_rest_leads_is_told_if_it_is_another_beat() -> None:
    """A spring that hardens, in water that drags little: the search finds the large swing, and rest the small one."""
    document = sprung(0.4, 0.003, cubic=10.0).document()
    strip = document["water"]["strip"]
    strip |= {"drag_normal": [0.3 * drag for drag in strip["drag_normal"]], "edge_lift": 0.3 * strip["edge_lift"]}
    beat = ht.swim(parse(document), ht.Gait.from_degrees(frequency=FREQUENCY, amplitude=(4,), phase=(0,)))
    assert "From rest the robot settles into another motion instead" in beat.status_text
    other = beat.settled_from_rest
    assert other is not None
    assert 2 * other.bends[0].bend_peak < beat.bends[0].bend_peak
    assert beat.settled
    assert other.settled


def test_numbers_that_do_nothing_change_no_bit() -> None:
    """A rest angle, a cubic term and a moment of zero are none; the gradient of a plain hinge lists none of them."""
    plain, zeros = hinged(1.6), sprung(rest_deg=0.0, cubic=0.0, moment=0.0, moment_phase_deg=40.0)
    one, other = settle(plain, GAITS), settle(zeros, GAITS)
    for name in one:
        np.testing.assert_array_equal(one[name], other[name])
    assert given_springs(plain) == ["hinge.stiffness", "hinge.damping"]


@pytest.mark.parametrize(
    ("key", "ends"),
    [("rest", (2.0, 12.0)), ("cubic", (0.01, 1.0)), ("stop", (6.0, 20.0)), ("moment", (0.0, 0.05))],
)
def test_a_design_has_the_new_numbers(key: str, ends: tuple[float, float]) -> None:
    """`sweep` takes them as variables; searches are in the tests of designs."""
    found = ht.sweep(sprung(**KINDS["all"]), GAITS, design={f"hinge.{key}": ends}, threads=1)
    assert len(set(np.ravel(found.speed.values))) == 2


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"stop_deg": 10.0}, "hinge.stop_stiffness_n_m_per_rad must be given with stop_deg, but is missing"),
        ({"stop_stiffness_n_m_per_rad": 1.0}, "hinge.stop_deg must be given with the numbers of stops, but is missing"),
        (
            {"stop_dissipation_n_m_s_per_rad2": 1.0},
            "hinge.stop_deg must be given with the numbers of stops, but is missing",
        ),
        (
            {"stop_deg": 10.0, "stop_stiffness_n_m_per_rad": 1.0, "rest_deg": -12.0},
            "hinge.rest_deg must be between the stops, at -10 and 10, but is -12: rest the spring between them",
        ),
        ({"rest_deg": 91.0}, "rest_deg"),
        ({"moment_n_m": -0.1}, "moment_n_m must not be negative"),
        ({"cubic_n_m_per_rad3": -1.0}, "cubic_n_m_per_rad3"),
    ],
)
def test_what_no_hinge_has_is_refused(keys: dict[str, float], message: str) -> None:
    document = hinged(1.6).document()
    with pytest.raises(ht.InputError, match=message):
        parse(document | {"hinge": document["hinge"] | keys})


def test_a_stop_that_no_steps_follow_is_refused() -> None:
    """By what is too fast: the spring of the stop, or its dissipation."""
    stiff, dissipation = "stop_stiffness_n_m_per_rad", "stop_dissipation_n_m_s_per_rad2"
    for key, values in ((stiff, {stiff: 1e6, dissipation: 0.0}), (dissipation, {stiff: 1.0, dissipation: 5e4})):
        with pytest.raises(ht.InputError, match=f"hinge.{key} must let 1024 steps of a beat at 2 Hz"):
            settle(sprung(stop_deg=STOP, **values), GAITS)
