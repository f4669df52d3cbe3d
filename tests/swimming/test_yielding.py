"""A hinge in the settled beat against an independent form, energy, similarity, limits and differences."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.new import new_robot
from hypertuna.description.robot import Robot, parse
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model
from oracles import planar
from oracles.planar import Chain, Joints, Real, strip_of

FREQUENCY = 2.0
GAIT = ht.Gait.from_degrees(frequency=FREQUENCY, amplitude=(16,), phase=(0,))
GAITS = Gaits.of([GAIT])


@functools.cache
def rigid(beating: bool = False) -> Robot:
    """A fish of three links whose first joint is driven, in strips.

    Without `beating`: the share of the speed that beating makes is discontinuous where a link's middle is at rest, and
    a fin that yields comes close to that.
    """
    document = new_robot("x", links=3, length=0.3, mass=0.85)
    document["joints"] = document["joints"][:1]
    for name in ("gaits", "gait_bounds"):
        del document[name], document["sources"][name]
    if not beating:
        document["water"]["strip"]["drag_beating"] = [0.0, 0.0, 0.0]
    return parse(document)


def hinged(ratio: float, zeta: float = 0.05, *, robot: Robot | None = None, frequency: float = FREQUENCY) -> Robot:
    """The fish with a hinge at its last link, of a stiffness over that at resonance and a damping ratio."""
    robot = robot or rigid()
    link = len(robot.links.name) - 1
    inertia = _core.reduced_inertia(core_model(robot), link)
    stiffness = ratio * inertia * (2 * math.pi * frequency) ** 2
    damping = 2 * zeta * math.sqrt(stiffness * inertia)
    hinge = {"link": link, "stiffness_n_m_per_rad": stiffness, "damping_n_m_s_per_rad": damping}
    return parse(robot.document() | {"hinge": hinge})


def with_hinge(robot: Robot, *, stiffness: float = 1.0, damping: float = 1.0) -> Robot:
    """The same with multiples of the spring's numbers."""
    assert robot.hinge is not None
    document = robot.document()
    document["hinge"]["stiffness_n_m_per_rad"] *= stiffness
    document["hinge"]["damping_n_m_s_per_rad"] *= damping
    return parse(document)


def oracle_rate(robot: Robot, gait: ht.Gait) -> Callable[[float, Real], Real]:
    """Rate of (x, y, heading, their rates, hinge's angle, its rate): Newton and Euler of every link in the world frame.

    The torque that the hinge needs is linear in its acceleration: that at which spring and damper give it is taken.
    """
    links, hinge = robot.links, robot.hinge
    assert hinge is not None
    chain = Chain(*(np.array(getattr(links, name)) for name in ("length", "com", "mass", "inertia")))
    numbers = {name: np.array(x) if isinstance(x, tuple) else x for name, x in dict(robot.water.strip or {}).items()}
    water = strip_of(chain, robot.water.density, np.array(links.lateral_area), np.array(links.wetted_area), **numbers)
    omega = 2 * math.pi * gait.frequency

    def rate(t: float, y: Real) -> Real:
        driven = np.zeros((3, len(links.name)))
        (amplitude,), (phase,), (bias,) = gait.amplitude, gait.phase, gait.bias
        swing = np.array([math.sin(omega * t - phase), omega * math.cos(omega * t - phase), 0.0])
        swing[2] = -(omega**2) * swing[0]
        driven[:, 1] = amplitude * swing
        driven[0, 1] += bias
        driven[:2, hinge.link] = y[6:]

        trial = np.stack([driven, driven], axis=1)
        trial[2, :, hinge.link] = 0.0, 1.0
        need = planar.torques(chain, water, Joints(*trial), np.stack([y[:6], y[:6]]))[:, hinge.link]
        given = -hinge.stiffness * y[6] - hinge.damping * y[7]
        driven[2, hinge.link] = (given - need[0]) / (need[1] - need[0])
        body = planar.acceleration(chain, water, Joints(*driven), y[:6])
        return np.concatenate([y[3:6], body, [y[7], driven[2, hinge.link]]])

    return rate


def test_ten_beats_from_rest_equal_an_independent_velocity_form() -> None:
    """SciPy's adaptive integrator, by accelerations; the start is that of no momentum."""
    robot = hinged(1.6)
    motion = ht.swim(robot, GAIT, from_rest=5.0, steps=512).trajectory
    first = motion.isel(time=0)
    link = len(robot.links.name) - 1
    start = [0, 0, 0, *(float(first[name]) for name in ("u", "v", "r")), 0.0, float(first.joint_rate[link])]
    found = solve_ivp(oracle_rate(robot, GAIT), (0, 5.0), start, method="DOP853", rtol=1e-7, atol=1e-9)
    end = found.y[:, -1]
    last = motion.isel(time=-1)
    for name, value in zip(("x", "y", "heading"), end, strict=False):
        assert float(last[name]) == pytest.approx(value, abs=5e-6)
    assert float(last.joint_angle[link]) == pytest.approx(end[6], abs=2e-5)
    assert float(last.joint_rate[link]) == pytest.approx(end[7], abs=3e-4)


def test_work_in_is_what_water_and_damper_take() -> None:
    """To 1e-6 at 128 steps; falling at fourth order until kinks of the drag stop it."""

    def off(ratio: float, steps: int) -> float:
        beat = settle(hinged(ratio), GAITS, steps=steps)
        taken = beat["power_to_water"][0] + beat["damping_power"][0]
        return abs(float(beat["mechanical_power"][0] / taken) - 1)

    for ratio in (0.5, 1.0, 1.6, 3.0):
        assert off(ratio, 128) < 1e-6
        assert off(ratio, 512) < 1e-8


def test_a_stiff_hinge_tends_to_a_rigid_joint() -> None:
    """First order in the compliance."""
    speed = settle(rigid(), GAITS, steps=512)["speed"][0]
    off = [settle(hinged(ratio, 0.0), GAITS, steps=512)["speed"][0] / speed - 1 for ratio in (100, 200, 400)]
    assert 0 < off[0] < 0.05
    assert off[0] / off[1] == pytest.approx(2, rel=0.05)
    assert off[1] / off[2] == pytest.approx(2, rel=0.025)


def test_stiffness_as_the_square_of_the_frequency_gives_the_same_motion() -> None:
    """In water without linear drag: to rounding, of a settled beat that is searched to 1e-7 of a stride."""
    beats = []
    for factor in (1.0, 2.0, 0.5):
        robot = with_hinge(hinged(1.6), stiffness=factor**2, damping=factor)
        gait = ht.Gait.from_degrees(frequency=factor * FREQUENCY, amplitude=(16,), phase=(0,))
        beat = settle(robot, Gaits.of([gait]))
        beats.append([beat[n][0] / factor**p for n, p in (("speed", 1), ("mechanical_power", 3), ("bend_peak", 0))])
    np.testing.assert_allclose(beats[1:], [beats[0]] * 2, rtol=1e-12)


def test_small_swings_are_in_resonance_where_the_stiffness_says() -> None:
    """Of fin and spring in water that hardly resists: the hinge lags by a right angle there, within 0.1 %."""
    robot = hinged(1.0, 0.01)
    inertia = _core.reduced_inertia(core_model(robot), 2)
    frequencies = FREQUENCY * np.array([0.999, 1.001])
    gaits = Gaits.of([ht.Gait.from_degrees(frequency=f, amplitude=(0.05,), phase=(0,)) for f in frequencies])
    swung = settle(robot, gaits, steps=256)
    assert robot.hinge is not None
    assert swung["stiffness_ratio"] == pytest.approx(robot.hinge.stiffness / (inertia * (2 * np.pi * frequencies) ** 2))
    low, high = swung["bend_lag"] % np.pi
    assert low < np.pi / 2 < high


@pytest.mark.parametrize("quantity", ["speed", "mechanical_power", "cost_of_transport"])
def test_derivatives_equal_differences(quantity: str) -> None:
    """By the spring, the gait, the body and the water."""
    robot, h, steps = hinged(1.6), 1e-4, 512
    slopes = ht.gradient(robot, GAIT, steps=steps)
    value = settle(robot, GAITS, steps=steps)[quantity][0]

    def numeric(swum: object) -> float:
        high, low = (settle(*swum(1 + side * h), steps=steps)[quantity][0] for side in (1, -1))  # type: ignore[operator]
        return float((high - low) / (2 * h) / value)

    def of_water(x: float) -> tuple[Robot, Gaits]:
        document = robot.document()
        document["water"]["strip"]["edge_lift"] *= x
        return parse(document), GAITS

    def of_gait(x: float) -> tuple[Robot, Gaits]:
        return robot, Gaits.of([ht.Gait.from_degrees(frequency=FREQUENCY * x, amplitude=(16,), phase=(0,))])

    cases = {
        "hinge.stiffness": lambda x: (with_hinge(robot, stiffness=x), GAITS),
        "hinge.damping": lambda x: (with_hinge(robot, damping=x), GAITS),
        "gait.frequency": of_gait,
        "water.strip.edge_lift": of_water,
    }
    for name, swum in cases.items():
        k = slopes.names.index(name)
        exact = slopes.derivatives[quantity][k] * slopes.values[k] / value
        assert exact == pytest.approx(numeric(swum), rel=1e-6, abs=1e-7), name


def test_random_fish_settle_in_the_first_stage() -> None:
    """With a last joint that yields, at 0.3 of the stiffness at resonance and more; where rest leads."""
    random = np.random.default_rng(1)
    found = []
    for _ in range(200):
        robot, gait = yielding_fish(random)
        result = settle(robot, Gaits.of([gait]), approach=2000)
        found.append([result[name][0] for name in ("status", "rung", "beats", "arrived")])
    status, rung, beats, arrived = np.array(found, dtype=float).T
    assert not rung.any()
    assert not status.any()
    assert arrived.all()
    assert np.median(beats) - 3 <= 6  # two plain beats at the start, and the one that is measured


def yielding_fish(random: np.random.Generator) -> tuple[Robot, ht.Gait]:
    """A random fish of `robot new` whose last joint yields, and a gait."""
    links = int(random.integers(3, 6))
    document = new_robot("x", links=links, length=float(random.uniform(0.1, 1.0)))
    document["joints"] = document["joints"][:-1]
    for name in ("gaits", "gait_bounds"):
        del document[name], document["sources"][name]
    frequency = float(np.exp(random.uniform(np.log(0.5), np.log(4.0))))
    ratio, zeta = np.exp(random.uniform(np.log([0.3, 0.001]), np.log([30.0, 0.3])))
    robot = hinged(float(ratio), float(zeta), robot=parse(document), frequency=frequency)
    amplitude = (random.uniform(5, 35, links - 2) / (links - 2)).tolist()
    phase = [30.0 * g for g in range(links - 2)]
    gait = ht.Gait.from_degrees(frequency=frequency, amplitude=amplitude, phase=phase)
    return robot, gait


def test_a_settled_beat_with_a_hinge_costs_little_more() -> None:
    """3.2 times as much as a prescribed one of the same robot; timings vary."""
    amplitudes = [(float(a),) for a in np.radians(np.linspace(8, 24, 64))]
    gaits = Gaits.grid(frequency=[FREQUENCY], amplitude=amplitudes, phase=[(0.0,)])
    robots = rigid(), hinged(1.6)
    times = []
    for _ in range(7):
        for robot in robots:
            begin = time.process_time()
            settle(robot, gaits)
            times.append(time.process_time() - begin)
    assert min(times[1::2]) < 4 * min(times[::2])


def test_a_swim_tells_how_its_hinge_swings() -> None:
    """The same numbers as its motion, which integrates the bent body; the hinge does no work."""
    robot = hinged(1.6)
    beat = ht.swim(robot, GAIT, steps=256)
    assert beat.bend is not None
    assert beat.settled
    assert beat.reached_from_rest
    motion = beat.trajectory
    angle = motion.joint_angle.values[:-1, 2]
    part = 2 * np.mean(angle * np.exp(-2j * np.pi * np.arange(256) / 256))
    assert abs(part) == pytest.approx(beat.bend.bend_amplitude, rel=1e-7)
    assert np.angle(part * 1j) % (2 * np.pi) == pytest.approx(-beat.bend.bend_lag % (2 * np.pi), rel=1e-7)
    assert abs(angle).max() == pytest.approx(beat.bend.bend_peak, rel=1e-7)
    assert motion.mechanical_power.values[:-1].mean() == pytest.approx(beat.mechanical_power, rel=1e-5)
    assert motion.power_to_water.values[:-1].mean() == pytest.approx(beat.power_to_water, rel=1e-5)
    end = motion.isel(time=-1)
    assert math.hypot(end.x, end.y) * FREQUENCY == pytest.approx(beat.speed, rel=1e-5)
    assert float(end.joint_angle[2]) == pytest.approx(angle[0], abs=1e-7)
    assert {"stiffness_ratio", "bend_amplitude_deg", "bend_lag_deg", "damping_power_w"} <= {*beat.summary()}


def test_a_spring_gets_the_steps_that_it_needs_or_a_sentence() -> None:
    """A stiff one is followed by more steps; beyond 1024 there is a sentence."""
    stiff = settle(hinged(3000.0), GAITS)
    assert stiff["status"][0] == 0
    assert stiff["speed"][0] == pytest.approx(settle(rigid(), GAITS)["speed"][0], rel=1e-3)
    with pytest.raises(ht.InputError, match="hinge.stiffness_n_m_per_rad must let 1024 steps of a beat at 2 Hz"):
        settle(hinged(1e6), GAITS)
    with pytest.raises(ht.InputError, match="hinge.damping_n_m_s_per_rad must let 1024 steps of a beat at 2 Hz"):
        settle(hinged(100.0, 50.0), GAITS)


def test_a_sweep_has_the_hinge_beside_the_gait() -> None:
    """Lanes beside each other are what each gait is alone."""
    robot = hinged(1.6)
    gaits = Gaits.of(
        [ht.Gait.from_degrees(frequency=f, amplitude=(a,), phase=(0,)) for f, a in ((1, 10), (2, 16), (3, 5))]
    )
    swept = ht.sweep(robot, gaits, threads=1)
    for k in range(3):
        alone = settle(robot, Gaits.of([gaits[k]]))
        for name in ("speed", "bend_amplitude", "bend_lag", "damping_power", "stiffness_ratio"):
            assert float(swept[name][k]) == alone[name][0]


def test_a_tail_that_is_too_soft_says_so() -> None:
    """A search that ends without a beat names the stiffness over that at resonance."""
    from hypertuna.swimming.yielding import too_soft

    assert too_soft(0.123) == (
        "no steady beat: the tail is too soft, k/k_r = 0.12 (stiffness of the hinge over that at resonance)."
    )
    assert "too soft" not in too_soft(2.0)


def test_a_tail_that_swings_through_the_body_says_so() -> None:
    """A link of a chain that is soft at its first joint, and no spring to speak of."""
    document = new_robot("x", links=4, length=1.0)
    document["hinge"] = {"link": 1, "stiffness_n_m_per_rad": 1e-9}
    beat = ht.swim(parse(document), "cruise")
    assert beat.bend is not None
    assert beat.bend.bend_peak > math.pi
    assert "The hinge bends by more than half a turn, through the body" in beat.status_text
    assert "half a turn" not in ht.swim(hinged(1.6), GAIT).status_text
