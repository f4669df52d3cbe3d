"""The body in space: against MuJoCo with a free joint, against its energy, and in the plane against the tail."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from hypertuna import _core
from hypertuna.description.schema.water import LAWS
from oracles import space as oracle
from oracles.cases import Case, random_case
from oracles.planar import Chain, Real, Water
from oracles.space import Space
from simulation.test_tail import COORDINATES, bent, planar_accelerations, shares
from swimming.test_core_against_oracles import ROUNDING, core_model, difference, water_of

FIN = {"x": 0.12, "y": 0.09, "z": -0.01, "span": 0.06, "chord": 0.05, "stall": 0.3, "drag_zero": 0.02}
FIN |= {"bandwidth": 5.0, "speed": 6.0}
DEEP = np.array([0.3, -2.0, -5.0])  # m, where the nose is


def still_sea(**values: float) -> dict[str, float]:
    """Fresh water without current or bottom."""
    nothing = ("current_east", "current_north", "shear_east", "shear_north", "field_east", "field_north", "field_up")
    return (
        dict.fromkeys(nothing, 0.0) | {"density": 1000.0, "bottom": np.inf, "stiffness": 1e4, "air": 101325.0} | values
    )


def random_space(rng: np.random.Generator, case: Case) -> Space:
    """Sections and heights as robots have them."""
    n, mass, length = len(case.chain.mass), case.chain.mass, case.chain.length
    links = {
        "com_height": rng.uniform(-0.03, 0.03, n),
        "roll": mass * 0.01**2 * rng.uniform(0.5, 2, n),
        "pitch": mass * length**2 / 12 * rng.uniform(0.5, 2, n),
        "volume": mass / 1000 * rng.uniform(0.8, 1.2, n),
        "center": length * rng.uniform(0.3, 0.7, n),
        "center_height": rng.uniform(-0.03, 0.03, n),
        "height": rng.uniform(0.03, 0.2, n),
        "width": rng.uniform(0.01, 0.1, n),
        "drag_vertical": rng.uniform(0.5, 2, n),
        "added_vertical": rng.uniform(0, 1.5, n),
        "drag_roll": rng.uniform(0.5, 2, n),
    }
    return Space(links, FIN, still_sea(), rng.uniform(0, 1))


def without_drag(space: Space) -> Space:
    """No drag across the plane, and no fins to speak of."""
    nothing = {name: 0 * space.links[name] for name in ("drag_vertical", "drag_roll")}
    fin = space.fin | {"span": 1e-9, "chord": 1e-9}
    return replace(space, links=space.links | nothing, fin=fin, shedding=0.0)


def random_attitude(rng: np.random.Generator) -> Real:
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


class State:
    """A random state of a body in space with coordinates bent by moments."""

    def __init__(self, rng: np.random.Generator, links: int) -> None:
        self.share = shares(rng, links)
        self.angle, self.rate = rng.uniform(-0.3, 0.3, COORDINATES), rng.uniform(-5, 5, COORDINATES)
        self.moment = rng.uniform(-1, 1, COORDINATES)
        self.case = bent(random_case(rng, links), self.share, self.angle, self.rate, np.zeros(COORDINATES))
        self.space = random_space(rng, self.case)
        self.twist = rng.uniform(-1, 1, 6) * np.array([1, 1, 1, 5, 5, 5])
        self.attitude, self.position = random_attitude(rng), DEEP
        self.fins = np.zeros(2)

    def accelerations(self, law: str) -> Real:
        body = _core.Body(core_model(self.case, law, "consistent"), {"share": self.share} | self.space.body_columns())
        return body.accelerations(
            _core.World(self.space.sea_columns()),
            bend=np.stack([self.angle, self.rate])[None],
            twist=self.twist[None],
            pose=np.concatenate([self.position, self.attitude, self.fins])[None],
            moment=self.moment[None],
        )[0]

    def water(self, law: str) -> Water:
        return water_of(self.case, law)


def roll_of_the_water(space: Space, chain: Chain) -> Real:
    """Added moment of inertia of ellipses about the links' axes."""
    thick = (space.links["height"] ** 2 - space.links["width"] ** 2) / 4
    result: Real = 1000 * np.pi / 8 * thick**2 * chain.length
    return result


def isotropic(state: State, rng: np.random.Generator) -> State:
    """The state with added mass that is alike in all directions at the center of mass: what MuJoCo can have as mass."""
    chain, links = state.case.chain, state.space.links
    added, height = state.case.lumped["added_mass"] * chain.mass, rng.uniform(-0.03, 0.03, len(chain.mass))
    # Moments of inertia that a body can have, with what the water adds to roll and pitch.
    about_z = chain.inertia + roll_of_the_water(state.space, chain)
    about_y = about_z * rng.uniform(0.9, 1.1, len(chain.mass))
    links = links | {"com_height": height, "center_height": height, "pitch": about_y}
    links |= {"roll": about_y + added * chain.length**2 / 12}
    links |= {"added_vertical": added / (1000 * np.pi / 4 * links["width"] ** 2 * chain.length)}
    state.case = Case(**{**vars(state.case), "chain": Chain(chain.length, chain.length / 2, chain.mass, about_z)})
    state.space = replace(state.space, links=links)
    return state


def mujoco_model(state: State) -> mujoco.MjModel:
    """A chain with a free joint whose links have the mass and inertia of link and water."""
    chain, links, case = state.case.chain, state.space.links, state.case
    added = case.lumped["added_mass"] * chain.mass
    roll = links["roll"] + roll_of_the_water(state.space, chain)
    inertia = np.stack([roll, links["pitch"] + added * chain.length**2 / 12, chain.inertia], axis=1)
    bodies, front = "", 0.0
    for i, mass in enumerate(chain.mass + added):
        joint = "<freejoint/>" if i == 0 else '<joint type="hinge" axis="0 0 1"/>'
        place = f"{float(chain.com[i])!r} 0 {float(links['com_height'][i])!r}"
        diagonal = " ".join(repr(float(x)) for x in inertia[i])
        bodies += f'<body pos="{front!r} 0 0">{joint}<inertial pos="{place}" mass="{float(mass)!r}"'
        bodies += f' diaginertia="{diagonal}"/>'
        front = float(chain.length[i])
    bodies += "</body>" * len(chain.mass)
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0"><flag contact="disable"/></option><worldbody>{bodies}</worldbody></mujoco>'
    )


def mujoco_accelerations(state: State, with_drag: bool) -> Real:
    """Rates of the head's twist in its own axes, and of the coordinates."""
    m = mujoco_model(state)
    d = mujoco.MjData(m)
    turn = oracle.attitude(state.attitude)
    v, w = state.twist[:3], state.twist[3:]
    d.qpos[:] = np.concatenate([state.position, state.attitude, (state.share @ state.angle)[1:]])
    d.qvel[:] = np.concatenate([turn @ v, w, (state.share @ state.rate)[1:]])
    mujoco.mj_forward(m, d)
    matrix = np.zeros((m.nv, m.nv))
    for k, unit in enumerate(np.eye(m.nv)):
        mujoco.mj_mulM(m, d, matrix[k], unit)
    load = -d.qfrc_bias.copy()
    chain, links = state.case.chain, state.space.links
    for i in range(m.nbody - 1):
        frame, origin = d.xmat[i + 1].reshape(3, 3), d.xpos[i + 1]
        for force, along, height in (
            (-chain.mass[i], chain.com[i], links["com_height"][i]),
            (1000 * links["volume"][i], links["center"][i], links["center_height"][i]),
        ):
            point = origin + frame @ np.array([along, 0, height])
            mujoco.mj_applyFT(m, d, np.array([0, 0, 9.81 * force]), np.zeros(3), point, i + 1, load)
    columns = np.zeros((m.nv, 6 + COORDINATES))
    columns[:3, :3], columns[3:6, 3:6] = turn, np.eye(3)
    columns[6:, 6:] = state.share[1:]
    force = columns.T @ load + np.concatenate([np.zeros(6), state.moment])
    # d/dt of the world's velocity of the nose is R (v' + w x v)
    turning = np.concatenate([turn @ np.cross(w, v), np.zeros(m.nv - 3)])
    force -= columns.T @ matrix @ turning
    if with_drag:
        arguments = (chain, state.water("lumped"), state.space, state.share, state.angle, state.rate, state.twist)
        force += oracle.drag(*arguments)
        force[:6] += oracle.fins(state.space, state.twist, state.fins)
    return np.linalg.solve(columns.T @ matrix @ columns, force)


@pytest.mark.parametrize("links", [6, 8, 12])
@pytest.mark.parametrize("with_drag", [False, True])
def test_accelerations_against_mujoco(links: int, with_drag: bool) -> None:
    rng = np.random.default_rng([60, links])
    for _ in range(30):
        state = isotropic(State(rng, links), rng)
        if with_drag:
            state.fins = rng.uniform(-1.5, 1.5, 2)
        else:
            state.space = without_drag(state.space)
            dry = state.case.lumped | {"friction": np.zeros(links), "drag": np.zeros(links)}
            state.case = Case(**{**vars(state.case), "lumped": dry})
        assert difference(state.accelerations("lumped"), mujoco_accelerations(state, with_drag)) < ROUNDING


@pytest.mark.parametrize("law", LAWS)
def test_in_the_plane_it_is_the_tail(law: str) -> None:
    """Nothing above or below the plane of the joints, and every link in balance: planar to rounding, at any heading."""
    rng = np.random.default_rng(61)
    for _ in range(50):
        state = State(rng, 6)
        flat = dict.fromkeys(("com_height", "center_height"), np.zeros(6))
        even = {"volume": state.case.chain.mass / 1000, "center": state.case.chain.com}
        state.space = replace(
            state.space, links=state.space.links | flat | even, fin=FIN | {"span": 1e-9, "chord": 1e-9}
        )
        heading = rng.uniform(-np.pi, np.pi)
        state.attitude = np.array([np.cos(heading / 2), 0, 0, np.sin(heading / 2)])
        state.twist[2:5] = 0
        got = state.accelerations(law)
        model, bend = core_model(state.case, law, "consistent"), np.stack([state.angle, state.rate])
        expected = planar_accelerations(model, state.share, bend, state.twist[[0, 1, 5]], state.moment, clamped=False)
        planar = got[[0, 1, 5, *range(6, 6 + COORDINATES)]]
        assert difference(planar, expected) < 1e-11
        assert abs(got[2:5]).max() < 1e-11 * abs(expected).max()


def later(state: State, acceleration: Real, h: float) -> tuple[Real, Real, Real, Real, Real]:
    """Angles, rates, twist, position and rotation after a short time, right to second order."""
    angle = state.angle + h * state.rate + h**2 / 2 * acceleration[6:]
    rate, twist = state.rate + h * acceleration[6:], state.twist + h * acceleration[:6]
    mean = state.twist + h / 2 * acceleration[:6]
    turn = oracle.attitude(state.attitude)
    k = np.array([[0, -mean[5], mean[4]], [mean[5], 0, -mean[3]], [-mean[4], mean[3], 0]])
    position = state.position + h * turn @ mean[:3] + h**2 / 2 * turn @ np.cross(mean[3:], mean[:3])
    return angle, rate, twist, position, turn @ (np.eye(3) + h * k + h**2 / 2 * k @ k)


def lagrange(state: State, law: str, acceleration: Real) -> tuple[Real, Real]:
    """Both sides (6 + d,) of Lagrange's equations: what momenta change by, and weight, buoyancy and moments."""
    chain, water, space, share, h = state.case.chain, state.water(law), state.space, state.share, 1e-7

    def momenta(end: tuple[Real, ...]) -> Real:
        return oracle.momentum(chain, water, space, share, *end[:3])

    rate = (momenta(later(state, acceleration, h)) - momenta(later(state, acceleration, -h))) / (2 * h)
    p, v, w = momenta((state.angle, state.rate, state.twist)), state.twist[:3], state.twist[3:]
    rate[:3] += np.cross(w, p[:3])
    rate[3:6] += np.cross(w, p[3:6]) + np.cross(v, p[:3])
    turn = oracle.attitude(state.attitude)

    def lagrangian(z: Real) -> float:
        small = np.array([[0, -z[5], z[4]], [z[5], 0, -z[3]], [-z[4], z[3], 0]])
        place, tilt = state.position + turn @ z[:3], turn @ (np.eye(3) + small)
        angle = state.angle + z[6:]
        kinetic = oracle.kinetic_energy(chain, water, space, share @ angle, share @ state.rate, state.twist)
        return kinetic - oracle.potential_energy(chain, space, share, angle, place, tilt)

    force = np.array([(lagrangian(e) - lagrangian(-e)) / (2 * h) for e in h * np.eye(6 + COORDINATES)])
    force[6:] += state.moment
    return rate, force


@pytest.mark.parametrize("law", LAWS)
def test_lagranges_equations(law: str) -> None:
    """All six of the head and those of the coordinates, with added mass of any kind, weight and buoyancy."""
    rng = np.random.default_rng(62)
    for _ in range(30):
        state = State(rng, 5)
        dry = state.case.lumped | {"friction": np.zeros(5), "drag": np.zeros(5)}
        state.case = Case(**{**vars(state.case.without_drag()), "lumped": dry})
        state.space = without_drag(state.space)
        rate, force = lagrange(state, law, state.accelerations(law))
        # rounding 1e-16 / h of energies and momenta of some 10 J and N s, against forces of 100 N and more
        assert rate == pytest.approx(force, abs=1e-6 * max(100.0, abs(force).max()))
