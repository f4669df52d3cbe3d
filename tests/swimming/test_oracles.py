"""The oracles against one another and against numbers done by hand: what judges the core must be right itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oracles import beats, kirchhoff, lagrangian, mujoco_chain, planar
from oracles.cases import Case, random_case
from oracles.planar import Chain, Joints, Lumped, Real, Strip, Water

# The 3 x 3 systems and the joint rows have condition numbers up to about 1e4 (masses and lengths differ by up to 100),
# so that rounding leaves 1e-12 of the largest entry; two decades on top.
ROUNDING = 1e-10
# A torque can be a small difference of larger moments: another decade.
CANCELLED = 1e-9


def difference(a: Real, b: Real) -> float:
    """Largest difference relative to the largest entry."""
    return float(abs(a - b).max() / abs(b).max())


def cases(seed: int, count: int, links: tuple[int, int]) -> list[Case]:
    rng = np.random.default_rng(seed)
    return [random_case(rng, int(rng.integers(links[0], links[1] + 1))) for _ in range(count)]


def no_joints(links: int) -> Joints:
    return Joints(np.zeros(links), np.zeros(links), np.zeros(links))


def still_strip(**values: Real | float) -> Strip:
    """One strip with nothing but the given quantities."""
    names = ("mu_normal", "mu_tangential", "added_inertia", "quadratic_normal", "quadratic_tangential")
    return Strip(**({name: np.zeros(1) for name in names} | values))


def random_pose(case: Case, rng: np.random.Generator) -> Real:
    return np.concatenate([rng.uniform(-3, 3, 3), case.twist])


def test_planar_agrees_with_mujoco_on_the_lumped_law() -> None:
    rng = np.random.default_rng(1)
    for k, case in enumerate(cases(seed=2, count=100, links=(2, 12))):
        water = case.lumped_water("consistent" if k % 2 else "as-printed")
        state = random_pose(case, rng)
        base, torques = mujoco_chain.solve(case.chain, water, case.joints, state)
        assert difference(planar.acceleration(case.chain, water, case.joints, state), base) < ROUNDING
        assert difference(planar.torques(case.chain, water, case.joints, state)[1:], torques) < CANCELLED


@pytest.mark.parametrize("links", [2, 3])
def test_planar_agrees_with_the_lagrangian_on_anisotropic_added_mass(links: int) -> None:
    rng = np.random.default_rng(3)
    for case in cases(seed=4, count=50, links=(links, links)):
        water = case.without_drag().strip_water()
        state = random_pose(case, rng)
        base, torques = lagrangian.solve(case.chain, water, case.joints, state)
        assert difference(planar.acceleration(case.chain, water, case.joints, state), base) < ROUNDING
        assert difference(planar.torques(case.chain, water, case.joints, state)[1:], torques) < CANCELLED


ELLIPSE = kirchhoff.ellipse(0.1, 0.03, 1000.0)
MASS, INERTIA = 4.0, 0.02


def ellipse_chain() -> tuple[Chain, Strip]:
    """The ellipse as a chain of one link: what a strip of length 2 a needs to have the ellipse's added masses."""
    length = np.array([0.2])
    strip = still_strip(
        mu_normal=ELLIPSE.normal / length,
        mu_tangential=ELLIPSE.tangential / length,
        added_inertia=np.array([ELLIPSE.inertia]),
    )
    return Chain(length, length / 2, np.array([MASS]), np.array([INERTIA])), strip


@pytest.mark.parametrize(
    ("name", "twist", "rate"),
    [
        ("towed straight: no load (d'Alembert)", (-0.7, 0, 0), (0, 0, 0)),
        ("towed aslant: Munk's moment alone", (-0.7, 0.4, 0), (0, 0, 0)),
        ("turned in place: no load", (0, 0, 3), (0, 0, 0)),
        ("turned while towed", (-0.7, 0.4, 3), (0, 0, 0)),
        ("accelerated", (0, 0, 0), (2, -1, 5)),
        ("all at once", (-0.7, 0.4, 3), (2, -1, 5)),
    ],
)
def test_strip_inertia_is_kirchhoffs(name: str, twist: tuple[float, ...], rate: tuple[float, ...]) -> None:
    chain, strip = ellipse_chain()
    (u, v, r), (du, dv, dr) = twist, rate
    angle = 0.6
    # the center's world velocity and acceleration, then those of the nose, half a length ahead
    e = np.exp(1j * angle)
    velocity, acceleration = e * (u + 1j * v), e * ((du - r * v) + 1j * (dv + r * u))
    arm = -chain.length[0] / 2 * e
    nose_v, nose_a = velocity + 1j * r * arm, acceleration + (1j * dr - r**2) * arm
    state = np.array([0.3, -0.2, angle, nose_v.real, nose_v.imag, r])
    motion = planar.motion(chain, no_joints(1), state, np.array([nose_a.real, nose_a.imag, dr]))
    needed = planar.strip_inertia(chain, strip, motion)
    force = needed.force[0] / e
    about_center = needed.moment[0] + planar.cross(arm, needed.force[0])
    got = -np.array([force.real, force.imag, about_center])
    # rounding of terms of the size of the largest mass times the largest rate (about 100)
    assert got == pytest.approx(kirchhoff.loads(ELLIPSE, np.array(twist), np.array(rate)), abs=1e-12 * 100), name


def test_a_free_ellipse_sways_as_the_elliptic_functions_say() -> None:
    """Fourth-order convergence to the closed form, in the center's path as well as in the angle."""
    chain, strip = ellipse_chain()
    total = kirchhoff.Body(ELLIPSE.tangential + MASS, ELLIPSE.normal + MASS, ELLIPSE.inertia + INERTIA)
    end = 0.5  # half a sway
    first, last = kirchhoff.swaying(total, 4.0, 1.1, np.array([0.0, end]))

    def nose(center: Real, sign: float) -> Real:
        """State of the nose from that of the center (sign -1), or back (sign +1)."""
        arm = sign * chain.length[0] / 2 * np.exp(1j * center[2])
        turning = 1j * center[5] * arm
        return center + np.array([arm.real, arm.imag, 0, turning.real, turning.imag, 0])

    def error(steps: int) -> float:
        def rate(_: float, y: Real) -> Real:
            return np.concatenate([y[3:], planar.acceleration(chain, strip, no_joints(1), y)])

        y = nose(first, -1)
        for _ in range(steps):
            y = beats.runge_kutta(rate, 0, 0, y, end / steps)
        return float(abs(nose(y, 1) - last).max())

    coarse, fine = error(50), error(100)
    # step times the pendulum's rate (6 / s) is 0.03: its fourth power, 1e-6, times turning rates of some rad/s
    assert fine < 5e-6
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.1)  # next order: a few times 0.03


def test_swaying_obeys_kirchhoffs_equations_and_their_integrals() -> None:
    total = kirchhoff.Body(ELLIPSE.tangential + MASS, ELLIPSE.normal + MASS, ELLIPSE.inertia + INERTIA)
    impulse, h = 8.0, 1e-5
    time = np.linspace(0, 2, 41)

    def twist(t: Real) -> Real:
        state = kirchhoff.swaying(total, impulse, 1.1, t)
        v = (state[:, 3] + 1j * state[:, 4]) * np.exp(-1j * state[:, 2])
        return np.stack([v.real, v.imag, state[:, 5]], axis=-1)

    rates = np.array([kirchhoff.free(total, x) for x in twist(time)])
    # a central difference: h^2 / 6 times the third derivative (about 1e3), and rounding 1e-16 / h
    assert difference((twist(time + h) - twist(time - h)) / (2 * h), rates) < 1e-7
    states = kirchhoff.swaying(total, impulse, 1.1, time)
    moved = (kirchhoff.swaying(total, impulse, 1.1, time + h) - kirchhoff.swaying(total, impulse, 1.1, time - h)) / (
        2 * h
    )
    assert difference(moved[:, :3], states[:, 3:]) < 1e-7
    u, v, r = twist(time).T
    energy = (total.tangential * u**2 + total.normal * v**2 + total.inertia * r**2) / 2
    assert np.ptp(energy) < 1e-13 * energy[0]
    assert total.tangential**2 * u**2 + total.normal**2 * v**2 == pytest.approx(impulse**2, rel=1e-13)
    assert total.inertia * r - states[:, 1] * impulse == pytest.approx(0, abs=1e-13)


def waters(case: Case) -> list[Water]:
    return [case.lumped_water("consistent"), case.strip_water()]


def later(joints: Joints, state: Real, acceleration: Real, h: float) -> tuple[Joints, Real]:
    """Joints and state after the short time ``h``, right to second order."""
    moved = Joints(
        joints.angle + h * joints.rate + h**2 / 2 * joints.acceleration,
        joints.rate + h * joints.acceleration,
        joints.acceleration,
    )
    position = state[:3] + h * state[3:] + h**2 / 2 * acceleration
    return moved, np.concatenate([position, state[3:] + h * acceleration])


def test_joint_power_is_the_gain_of_energy_and_what_the_drag_takes() -> None:
    h = 1e-6  # a central difference: rounding 1e-16 / h of the energy (some J) against powers of 100 W and more
    for case in cases(seed=5, count=30, links=(2, 8)):
        for water in waters(case):
            arguments = (case.chain, water, case.joints, case.state)
            acceleration = planar.acceleration(*arguments)
            before, after = (
                planar.kinetic_energy(case.chain, water, *later(case.joints, case.state, acceleration, s * h))
                for s in (-1, 1)
            )
            gain = (after - before) / (2 * h)
            taken = planar.drag_power(*arguments)
            assert taken > 0
            assert planar.power(*arguments) == pytest.approx(gain + taken, rel=1e-6, abs=1e-6 * (abs(gain) + taken))


def impulse(case: Case, water: Water, joints: Joints, state: Real) -> Real:
    """Momentum and moment of momentum about the origin (3,): slopes of the kinetic energy, a quadratic form."""
    units = np.eye(6)[3:]
    energy = [[planar.kinetic_energy(case.chain, water, joints, state + s * e) for s in (-1, 1)] for e in units]
    p = np.array([(after - before) / 2 for before, after in energy])
    return p + np.array([0, 0, state[0] * p[1] - state[1] * p[0]])


def test_without_drag_nothing_changes_the_momentum_of_body_and_water() -> None:
    h = 1e-6
    for case in cases(seed=6, count=30, links=(2, 8)):
        water = case.without_drag().strip_water()
        state = np.concatenate([[0.4, -0.3, 0.8], case.twist])
        acceleration = planar.acceleration(case.chain, water, case.joints, state)
        before, after = (impulse(case, water, *later(case.joints, state, acceleration, s * h)) for s in (-1, 1))
        # rounding 1e-16 / h of the momentum, against single terms of the size of mass times joint acceleration (100 N)
        assert abs(after - before).max() / (2 * h) < 1e-7 * 100


def test_torque_at_the_nose_vanishes() -> None:
    for case in cases(seed=7, count=20, links=(2, 12)):
        for water in waters(case):
            torques = planar.torques(case.chain, water, case.joints, case.state)
            assert abs(torques[0]) < ROUNDING * abs(torques).max()


def test_drag_of_a_plate_turned_about_its_edge() -> None:
    """v_n = r s along the plate: force q r^2 l^3 / 3, moment q r^2 l^4 / 4; a cubic, for Gauss points exact."""
    length, q, r = 0.4, 7.0, 2.5
    chain = Chain(np.array([length]), np.array([length / 2]), np.ones(1), np.ones(1))
    strip = still_strip(quadratic_normal=np.array([q]))
    motion = planar.motion(chain, no_joints(1), np.array([0, 0, 0.3, 0, 0, r]), np.zeros(3))
    drag = planar.drag(chain, strip, motion)
    assert drag.force[0] * np.exp(-0.3j) == pytest.approx(-1j * q * r**2 * length**3 / 3, rel=1e-14)
    assert drag.moment[0] == pytest.approx(-q * r**2 * length**4 / 4, rel=1e-14)


@pytest.mark.parametrize("cross_flow", [False, True])
def test_drag_of_a_plate_towed_aslant(cross_flow: bool) -> None:
    length, q_n, q_t, c_n, c_t = 0.4, 7.0, 0.3, 1.1, 0.6
    chain = Chain(np.array([length]), np.array([length / 2]), np.ones(1), np.ones(1))
    strip = replace(
        still_strip(
            quadratic_normal=np.array([q_n]),
            quadratic_tangential=np.array([q_t]),
            linear_normal=c_n,
            linear_tangential=c_t,
        ),
        cross_flow=cross_flow,
    )
    motion = planar.motion(chain, no_joints(1), np.array([0, 0, 0, -3.0, 4.0, 0]), np.zeros(3))
    across = 5.0 if cross_flow else 4.0  # |v| or |v_n|
    drag = planar.drag(chain, strip, motion)
    assert drag.force[0] == pytest.approx(length * (q_t * 9 + c_t * 3 - 1j * (q_n * 4 * across + c_n * 4)), rel=1e-14)
    assert drag.moment[0] == pytest.approx(drag.force[0].imag * length / 2, rel=1e-14)


EDGES = {
    "strip": planar.Edge(mu=3.0, shed=3.0, front=0.0),
    "strip with suction": planar.Edge(mu=3.0, shed=2.0, front=1.0),
    "fin": planar.Fin(mass=0.3, chord=0.2, lift=3.0, inertia=0.001, slope=0.6, front=0.0),
    "slender": planar.Slender(mu=3.0),
}


def plate_with_edge(
    edge: planar.Edge | planar.Fin | planar.Slender, state: Real
) -> tuple[planar.Wrench, planar.Motion]:
    """What a plate of 3 kg/m, 0.4 m long, sheds in a state of motion."""
    chain = Chain(np.array([0.4]), np.array([0.2]), np.ones(1), np.ones(1))
    strip = still_strip(mu_normal=np.array([3.0]), edge=edge)
    motion = planar.motion(chain, no_joints(1), state, np.zeros(3))
    return planar.shed(chain, strip, motion), motion


@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES)
def test_the_wake_never_gives_energy(edge: planar.Edge | planar.Fin | planar.Slender) -> None:
    rng = np.random.default_rng(10)
    states = np.concatenate([rng.uniform(-1, 1, (100_000, 5)), rng.uniform(-8, 8, (100_000, 1))], axis=1)
    wrench, m = plate_with_edge(edge, states)
    taken = -(planar.dot(wrench.force, m.velocity) + wrench.moment * m.turn)
    assert taken.min() > -1e-12
    assert taken.mean() > 0.01


@pytest.mark.parametrize("slope", [0.01, 0.001])
def test_a_slender_edge_gives_lighthills_thrust_at_small_amplitude(slope: float) -> None:
    """Thrust 1/2 mu (h_t^2 - U^2 h_x^2) of a tail swimming at U toward -x, to second order in the slope."""
    speed, sideways = 1.0, 2.5 * slope
    state = np.array([0, 0, np.arctan(slope), -speed, sideways, 0])
    wrench, _ = plate_with_edge(EDGES["slender"], state)
    thrust = -wrench.force[0].real
    assert thrust == pytest.approx(3.0 / 2 * (sideways**2 - speed**2 * slope**2), rel=10 * slope**2)


def test_a_lagging_joint_moves_as_a_first_order_filter_lets_it() -> None:
    """b + db/dt / (2 pi f_b) = a, with ``a`` the ideal gait; and rates are the derivatives of angles."""
    gait = beats.Gait(np.array(3.0), np.array([0.3, 0.5]), np.array([0.0, 0.7]), np.array([0.1, 0.0]), np.eye(2), 4.7)
    ideal = replace(gait, bandwidth=np.inf)
    for phase in np.linspace(0, 1, 7):
        lagging = gait.joints(phase)
        assert lagging.angle + lagging.rate / (2 * np.pi * 4.7) == pytest.approx(ideal.joints(phase).angle, abs=1e-14)
        h = 1e-5
        before, after = gait.joints(phase - h * 3.0), gait.joints(phase + h * 3.0)
        # h^2 / 6 times omega^3 (7e3) times the amplitude
        assert (after.angle - before.angle) / (2 * h) == pytest.approx(lagging.rate, abs=1e-6)
        assert (after.rate - before.rate) / (2 * h) == pytest.approx(lagging.acceleration, abs=1e-4)


def test_a_batch_is_its_members() -> None:
    members = cases(seed=8, count=4, links=(5, 5))
    one = members[0]
    joints = Joints(
        *(np.stack([getattr(c.joints, name) for c in members]) for name in ("angle", "rate", "acceleration"))
    )
    states = np.stack([c.state for c in members])
    for water in waters(one):
        together = planar.acceleration(one.chain, water, joints, states)
        for k, member in enumerate(members):
            assert (
                difference(together[k], planar.acceleration(one.chain, water, member.joints, member.state)) < ROUNDING
            )


def test_a_towed_lumped_link_stops_as_the_logarithm_says() -> None:
    """m' du/dt = -q u^2: displacement m' / q ln(1 + q u t / m'), m' = m (1 + c_m); 100 steps leave less than 1e-8."""
    chain = Chain(np.array([0.3]), np.array([0.15]), np.array([2.0]), np.array([0.01]))
    water = Lumped(1000.0, np.array([0.5]), np.array([0.2]), np.array([1.0]), np.array([0.02]), np.array([0.01]))
    q, mass, u, end = 0.5 * 1000 * 0.2 * 0.02, 3.0, 1.2, 2.0
    gait = beats.Gait(np.array(1 / end), np.zeros(1), np.zeros(1), np.zeros(1), np.zeros((1, 1)))
    states = beats.beat(chain, water, gait, np.array([0, 0, 0, -u, 0, 0]), steps=100)
    assert states[-1, 0] == pytest.approx(-mass / q * np.log(1 + q * u * end / mass), rel=1e-8)
    assert beats.speed(gait, states) == pytest.approx(-states[-1, 0] / end, rel=1e-14)


def test_a_settled_beat_costs_what_the_water_takes() -> None:
    """Mean joint power = mean drag power once the beat repeats; 16 steps leave 1e-5, 32 less."""
    case = random_case(np.random.default_rng(9), 3)
    water = case.lumped_water("consistent")
    gait = beats.Gait(
        np.array(2.0), np.array([0.3, 0.4]), np.array([0.0, 1.0]), np.array([0.0, 0.1]), np.eye(3)[1:], bandwidth=4.7
    )
    steps = 32
    states = beats.settle(case.chain, water, gait, steps=steps, tolerance=1e-7)
    taken = [planar.drag_power(case.chain, water, gait.joints(k / steps), states[k]) for k in range(steps)]
    assert beats.mean_power(case.chain, water, gait, states) == pytest.approx(np.mean(taken), rel=1e-5)
