"""Hinges in the settled beat against an independent form, energy, similarity, limits and differences."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hypertuna as ht
from hypertuna.description.new import new_robot
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.actuator import Hinge
from hypertuna.swimming.beat import settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.yielding import reduced_inertia, softness
from oracles import planar
from oracles.planar import Chain, Joints, Real, strip_of

FREQUENCY = 2.0
GAIT = ht.Gait.from_degrees(frequency=FREQUENCY, amplitude=(16,), phase=(0,))
GAITS = Gaits.of([GAIT])


@functools.cache
def rigid(hinges: int = 1, beating: bool = False) -> Robot:
    """A fish whose first joint is driven, and others are there for hinges, in strips.

    Without `beating`: the share of the speed that beating makes is discontinuous where a link's middle is at rest, and
    a fin that yields comes close to that.
    """
    document = new_robot("x", links=2 + hinges, length=0.3, mass=0.85)
    document["joints"] = document["joints"][:1]
    for name in ("gaits", "gait_bounds"):
        del document[name], document["sources"][name]
    if not beating:
        document["water"]["strip"]["drag_beating"] = [0.0] * (2 + hinges)
    return parse(document)


def hinged(
    ratio: float, zeta: float = 0.05, *, robot: Robot | None = None, frequency: float = FREQUENCY, hinges: int = 1
) -> Robot:
    """The fish with hinges at its last links, of a stiffness over that at resonance and a damping ratio, one by one."""
    robot = robot or rigid(hinges)
    last = len(robot.links.name)
    tables = [{"link": link, "stiffness_n_m_per_rad": 1.0} for link in range(last - hinges, last)]
    probe = parse(robot.document() | {"hinges": tables})
    for table, inertia in zip(tables, reduced_inertia(probe).diagonal().tolist(), strict=True):
        stiffness = ratio * inertia * (2 * math.pi * frequency) ** 2
        damping = 2 * zeta * math.sqrt(stiffness * inertia)
        table |= {"stiffness_n_m_per_rad": stiffness, "damping_n_m_s_per_rad": damping}
    return parse(robot.document() | ({"hinge": tables[0]} if hinges == 1 else {"hinges": tables}))


def with_hinge(robot: Robot, only: int | None = None, *, stiffness: float = 1.0, damping: float = 1.0) -> Robot:
    """The same with multiples of the springs' numbers, or of one spring's."""
    document = robot.document()
    tables = [document["hinge"]] if robot.hinge else document["hinges"]
    for table in tables if only is None else [tables[only]]:
        table["stiffness_n_m_per_rad"] *= stiffness
        table["damping_n_m_s_per_rad"] *= damping
    return parse(document)


def spring_moment(hinge: Hinge, angle: float, rate: float, clock: float) -> float:
    """Moment at a hinge of spring, damper and stops, and of what drives it by the gait's clock [rad]."""
    moment = hinge.moment * math.sin(clock - hinge.moment_phase)
    moment += -hinge.stiffness * (angle - hinge.rest) - hinge.cubic * (angle - hinge.rest) ** 3 - hinge.damping * rate
    beyond = 0.0 if hinge.stop is None else max(abs(angle) - hinge.stop, 0.0)
    side = math.copysign(1.0, angle)
    return moment - beyond * (side * (hinge.stop_stiffness or 0.0) + hinge.stop_dissipation * rate)


def oracle_rate(robot: Robot, gait: ht.Gait) -> Callable[[float, Real], Real]:
    """Rate of (x, y, heading, their rates, hinges' angles, their rates): Newton and Euler of every link in the world.

    The torques that hinges need are linear in their accelerations: those at which springs and dampers give them.
    """
    links, at = robot.links, [hinge.link for hinge in robot.hinges]
    count = len(at)
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
        driven[:2, at] = y[6:].reshape(2, count)

        trial = np.stack([driven] * (count + 1), axis=1)
        trial[2, 1:, at] = np.eye(count)
        need = planar.torques(chain, water, Joints(*trial), np.stack([y[:6]] * (count + 1)))[:, at]
        bends = zip(robot.hinges, y[6 : 6 + count], y[6 + count :], strict=True)
        given = [spring_moment(*one, omega * t) for one in bends]
        driven[2, at] = np.linalg.solve((need[1:] - need[0]).T, given - need[0])
        body = planar.acceleration(chain, water, Joints(*driven), y[:6])
        return np.concatenate([y[3:6], body, driven[1, at], driven[2, at]])

    return rate


def test_ten_beats_from_rest_equal_an_independent_velocity_form() -> None:
    """SciPy's adaptive integrator, by accelerations; the start is that of no momentum."""
    hinges = 2
    robot = hinged(1.6, hinges=hinges)
    motion = ht.swim(robot, GAIT, from_rest=5.0, steps=512).trajectory
    first = motion.isel(time=0)
    links = slice(2, 2 + hinges)
    start = [0, 0, 0, *(float(first[name]) for name in ("u", "v", "r")), *[0.0] * hinges, *first.joint_rate[links]]
    found = solve_ivp(oracle_rate(robot, GAIT), (0, 5.0), start, method="DOP853", rtol=1e-7, atol=1e-9)
    end = found.y[:, -1]
    last = motion.isel(time=-1)
    for name, value in zip(("x", "y", "heading"), end, strict=False):
        assert float(last[name]) == pytest.approx(value, abs=5e-6)
    assert last.joint_angle[links].values == pytest.approx(end[6 : 6 + hinges], abs=2e-5)
    assert last.joint_rate[links].values == pytest.approx(end[6 + hinges :], abs=3e-4)


@pytest.mark.parametrize("hinges", [1, 2, 3])
def test_work_in_is_what_water_and_dampers_take(hinges: int) -> None:
    """To 1e-6 at 128 steps, 3e-6 with three hinges; falling at fourth order until kinks of the drag stop it."""

    def off(ratio: float, steps: int) -> float:
        robot = hinged(ratio, hinges=hinges)
        beat = settle(robot, GAITS, steps=steps)
        taken = beat["power_to_water"][0] + sum(beat[name][0] for name in beat if name.startswith("damping_power"))
        return abs(float(beat["mechanical_power"][0] / taken) - 1)

    for ratio in (0.5, 1.0, 1.6, 3.0):
        assert off(ratio, 128) < (1e-6 if hinges < 3 else 3e-6)
        assert off(ratio, 512) < 1e-8


@pytest.mark.parametrize("hinges", [1, 2, 3])
def test_stiff_hinges_tend_to_rigid_joints(hinges: int) -> None:
    """First order in the compliance."""
    speed = settle(rigid(hinges), GAITS, steps=512)["speed"][0]
    robots = [hinged(ratio, 0.0, hinges=hinges) for ratio in (100, 200, 400)]
    off = [settle(robot, GAITS, steps=512)["speed"][0] / speed - 1 for robot in robots]
    assert 0 < off[0] < 0.05 * hinges
    assert off[0] / off[1] == pytest.approx(2, rel=0.05)
    assert off[1] / off[2] == pytest.approx(2, rel=0.025)


@pytest.mark.parametrize("hinges", [1, 3])
def test_stiffness_as_the_square_of_the_frequency_gives_the_same_motion(hinges: int) -> None:
    """In water without linear drag: to rounding, of a settled beat that is searched to 1e-7 of a stride."""
    beats = []
    for factor in (1.0, 2.0, 0.5):
        robot = with_hinge(hinged(1.6, hinges=hinges), stiffness=factor**2, damping=factor)
        gait = ht.Gait.from_degrees(frequency=factor * FREQUENCY, amplitude=(16,), phase=(0,))
        beat = settle(robot, Gaits.of([gait]))
        peak = "bend_peak" if hinges == 1 else "bend_peak_3"
        beats.append([beat[n][0] / factor**p for n, p in (("speed", 1), ("mechanical_power", 3), (peak, 0))])
    np.testing.assert_allclose(beats[1:], [beats[0]] * 2, rtol=1e-12)


def test_small_swings_are_in_resonance_where_the_stiffness_says() -> None:
    """Of fin and spring in water that hardly resists: the hinge lags by a right angle there, within 0.1 %."""
    robot = hinged(1.0, 0.01)
    inertia = reduced_inertia(robot)[0, 0]
    frequencies = FREQUENCY * np.array([0.999, 1.001])
    gaits = Gaits.of([ht.Gait.from_degrees(frequency=f, amplitude=(0.05,), phase=(0,)) for f in frequencies])
    swung = settle(robot, gaits, steps=256)
    assert robot.hinge is not None
    assert swung["stiffness_ratio"] == pytest.approx(robot.hinge.stiffness / (inertia * (2 * np.pi * frequencies) ** 2))
    low, high = swung["bend_lag"] % np.pi
    assert low < np.pi / 2 < high


def test_two_hinges_are_in_resonance_at_the_natural_frequencies_of_both() -> None:
    """In water that hardly resists: within 0.1 %, the swing of the outer one is largest at the lower frequency."""
    robot = hinged(1.0, 0.002, hinges=2)
    natural = FREQUENCY * math.sqrt(softness(robot, FREQUENCY))
    assert natural < 0.8 * FREQUENCY  # far from those of each alone
    frequencies = natural * np.array([0.998, 0.999, 1.0, 1.001, 1.002])
    gaits = Gaits.of([ht.Gait.from_degrees(frequency=f, amplitude=(0.02,), phase=(0,)) for f in frequencies])
    swung = settle(robot, gaits, steps=256)["bend_amplitude_2"]
    low, middle, high = np.polynomial.Polynomial.fit(frequencies / natural - 1, swung, 2).convert().coef
    assert -middle / (2 * high) == pytest.approx(0, abs=1e-3)
    assert high < 0 < low


@pytest.mark.parametrize("hinges", [1, 2])
@pytest.mark.parametrize("quantity", ["speed", "mechanical_power", "cost_of_transport"])
def test_derivatives_equal_differences(quantity: str, hinges: int) -> None:
    """By the springs, the gait, the body and the water."""
    robot, h, steps = hinged(1.6, hinges=hinges), 1e-4, 512
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
        f"{robot.hinge_keys[0]}.stiffness": lambda x: (with_hinge(robot, 0, stiffness=x), GAITS),
        f"{robot.hinge_keys[hinges - 1]}.damping": lambda x: (with_hinge(robot, hinges - 1, damping=x), GAITS),
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
        found.append([result[name][0] for name in ("status", "retry", "beats", "arrived")])
    status, retry, beats, arrived = np.array(found, dtype=float).T
    assert not retry.any()
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


@pytest.mark.parametrize(("hinges", "most"), [(1, 3.5), (2, 6.0), (3, 10.0)])
def test_a_settled_beat_with_hinges_costs_little_more(hinges: int, most: float) -> None:
    """2.9 times a prescribed one of the same robot with one hinge, 4.0 with two, 5.7 with three; timings vary."""
    amplitudes = [(float(a),) for a in np.radians(np.linspace(8, 24, 64))]
    gaits = Gaits.grid(frequency=[FREQUENCY], amplitude=amplitudes, phase=[(0.0,)])
    robots = rigid(hinges), hinged(1.6, hinges=hinges)
    times = []
    for _ in range(7):
        for robot in robots:
            begin = time.process_time()
            settle(robot, gaits)
            times.append(time.process_time() - begin)
    assert min(times[1::2]) < most * min(times[::2])


def test_a_swim_tells_how_its_hinge_swings() -> None:
    """The same numbers as its motion, which integrates the bent body; the hinge does no work."""
    robot = hinged(1.6)
    beat = ht.swim(robot, GAIT, steps=256)
    (bend,) = beat.bends
    assert beat.settled
    assert beat.reached_from_rest
    motion = beat.trajectory
    angle = motion.joint_angle.values[:-1, 2]
    part = 2 * np.mean(angle * np.exp(-2j * np.pi * np.arange(256) / 256))
    assert abs(part) == pytest.approx(bend.bend_amplitude, rel=1e-7)
    assert np.angle(part * 1j) % (2 * np.pi) == pytest.approx(-bend.bend_lag % (2 * np.pi), rel=1e-7)
    assert abs(angle).max() == pytest.approx(bend.bend_peak, rel=1e-7)
    assert motion.mechanical_power.values[:-1].mean() == pytest.approx(beat.mechanical_power, rel=1e-5)
    assert motion.power_to_water.values[:-1].mean() == pytest.approx(beat.power_to_water, rel=1e-5)
    end = motion.isel(time=-1)
    assert math.hypot(end.x, end.y) * FREQUENCY == pytest.approx(beat.speed, rel=1e-5)
    assert float(end.joint_angle[2]) == pytest.approx(angle[0], abs=1e-7)
    assert {"stiffness_ratio", "bend_amplitude_deg", "bend_lag_deg", "damping_power_w"} <= {*beat.summary()}


def test_a_spring_gets_the_steps_that_it_needs_or_a_sentence() -> None:
    """A stiff one is followed by more steps; beyond 1024 there is a sentence."""
    stiff = settle(hinged(3000.0), GAITS)
    assert stiff["steps"][0] == 256
    assert stiff["status"][0] == 0
    assert stiff["speed"][0] == pytest.approx(settle(rigid(), GAITS)["speed"][0], rel=1e-3)
    with pytest.raises(ht.InputError, match="hinge.stiffness_n_m_per_rad must let 1024 steps of a beat at 2 Hz"):
        settle(hinged(1e6), GAITS)
    with pytest.raises(ht.InputError, match="hinge.damping_n_m_s_per_rad must let 1024 steps of a beat at 2 Hz"):
        settle(hinged(100.0, 50.0), GAITS)


@pytest.mark.parametrize("zeta", [0.05, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("ratio", [30.0, 100.0, 300.0, 700.0])
def test_a_damped_hinge_gets_the_steps_that_its_power_needs(ratio: float, zeta: float) -> None:
    """Stiff and critically damped, it was off by 3e-2 at 128 steps."""
    beat = settle(hinged(ratio, zeta), GAITS)
    taken = beat["power_to_water"][0] + beat["damping_power"][0]
    assert beat["mechanical_power"][0] / taken == pytest.approx(1, abs=1.5e-3)


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
        "No steady beat: the tail is too soft, k/k_r = 0.12 (stiffness of the hinge over that at resonance)."
    )
    assert "too soft" not in too_soft(2.0)


def test_a_tail_that_swings_through_the_body_says_so() -> None:
    """A link of a chain that is soft at its first joint, and no spring to speak of."""
    document = new_robot("x", links=4, length=1.0)
    document["hinge"] = {"link": 1, "stiffness_n_m_per_rad": 1e-9}
    beat = ht.swim(parse(document), "cruise")
    assert beat.bends[0].bend_peak > math.pi
    assert "The hinge bends by more than half a turn, through the body" in beat.status_text
    assert "half a turn" not in ht.swim(hinged(1.6), GAIT).status_text
