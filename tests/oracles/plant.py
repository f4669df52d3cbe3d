"""From servo to wake, plainly: Lagrange's equations in the world frame, pressures by root finding, SciPy's DOP853.

The chain is the paper's: lumped added mass and drag at each center of mass, or none of them in air with the head held.
Muscles are integrated numerically through their walls; pressures are roots of the oil's volume; the inertia is
made of Jacobians, and those of complex steps. Nothing is shared with the core but the equations of the documentation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import BSpline, RectBivariateSpline, make_interp_spline
from scipy.optimize import brentq, fsolve

Real = NDArray[np.float64]
ATMOSPHERE = 101325.0
Lumen = tuple[float | None, float | None]  # of the muscles of the left and right side [m^2]; None: as the braid has it
TAUT: Lumen = (None, None)
Pressure = Callable[[int, float], float]  # of a side [Pa] at its volume [m^3]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


@dataclass(frozen=True)
class Muscle:
    """A hose (outer, inner diameter [m]) of neo-Hookean silicone C1 [Pa] in a braid at ``angle`` [rad]."""

    outer: float
    inner: float
    angle: float
    c1: float

    def braid(self, stretch: Real) -> Real:
        """Diameter of the braid [m]: a strand of given length wound a given number of times."""
        strand, turns = 1 / np.cos(self.angle), np.tan(self.angle) / (np.pi * self.outer)
        return np.sqrt(strand**2 - stretch**2) / (turns * np.pi)

    def lumen(self, stretch: Real) -> Real:
        """Volume inside the hose per length at rest [m^2]: what the braid encloses less the wall."""
        wall = np.pi / 4 * (self.outer**2 - self.inner**2)
        return np.pi / 4 * self.braid(stretch) ** 2 * stretch - wall

    def energy(self, stretch: Real, lumen: Real, outside: float, matrix: float) -> Real:
        """Energies of the wall, and of what its swelling does to matrix C1 [Pa] up to a radius, per length [J/m]."""
        wall = self.ring(self.c1, self.inner / 2, self.outer / 2, stretch, lumen)
        alone = matrix * (stretch**2 + 2 / stretch - 3) * np.pi * (outside**2 - (self.outer / 2) ** 2)
        return wall + self.ring(matrix, self.outer / 2, outside, stretch, lumen) - alone

    def ring(self, c1: float, inner: float, outer: float, stretch: Real, lumen: Real) -> Real:
        """Energies of a ring around the lumen, per length at rest [J/m], integrated through it."""
        R = (outer + inner + (outer - inner) * NODES) / 2
        axial = stretch[..., None]
        hoop2 = (lumen[..., None] / np.pi + R**2 - (self.inner / 2) ** 2) / axial / R**2
        density = c1 * (axial**2 + hoop2 + 1 / (axial**2 * hoop2) - 3) * 2 * np.pi * R
        return density @ WEIGHTS * (outer - inner) / 2


@dataclass(frozen=True)
class Section:
    """A piece of a joint: length [m], area [m^2] and second moment [m^4] of matrix, radius of it around a hose [m]."""

    length: float
    area: float
    second: float
    outside: float


@dataclass(frozen=True)
class Joint:
    """Sections that bend and shorten; ``units`` muscles a side at ``lever`` [m] in neo-Hookean matrix C1 [Pa]."""

    muscle: Muscle
    units: int
    lever: float
    sections: Sequence[Section]
    matrix: float
    relaxation: float  # s
    fill: float  # Pa, of both sides of the straight joint
    highest: float  # Pa, of one side, under which one section stands for all

    def stretches(self, at: Section, bend: float, strain: float) -> Real:
        """Stretches of the muscles of the left and the right side; what shortens gets wider."""
        axis = 1 + strain
        turn = self.lever * bend / at.length / np.sqrt(axis)
        return np.array([axis - turn, axis + turn])

    @cached_property
    def curves(self) -> dict[float, tuple[BSpline, RectBivariateSpline]]:
        """By the radius of the matrix around a muscle: energy and lumen of the taut one over its stretch; its energy
        over stretch and lumen."""
        stretch, m = np.linspace(0.7, 1.2, 101), self.muscle
        taut, lumen = m.lumen(stretch), np.geomspace(0.02, 3.0, 141) * np.pi / 4 * m.inner**2
        return {
            outside: (
                make_interp_spline(
                    stretch, np.stack([m.energy(stretch, taut, outside, self.matrix), taut], axis=1), k=7
                ),
                RectBivariateSpline(
                    stretch, lumen, m.energy(stretch[:, None], lumen, outside, self.matrix), kx=5, ky=5
                ),
            )
            for outside in (self.mean, *(at.outside for at in self.sections))
        }

    @cached_property
    def mean(self) -> float:
        """Mean radius of the matrix around a hose [m]."""
        return float(np.average([at.outside for at in self.sections], weights=[at.length for at in self.sections]))

    def energy(self, at: Section, bend: float, strain: float, lumen: Lumen = TAUT) -> float:
        """Energy of matrix and muscles [J]: a bar in tension, bent a little; muscles as taut or with a lumen."""
        axis, c1 = 1 + strain, self.matrix
        bar = c1 * (axis**2 + 2 / axis - 3) * at.area
        bent = c1 * (1 + 2 / axis**3) * at.second * (bend / at.length) ** 2 / axis
        taut, loose = self.curves[at.outside]
        walls = [
            taut(stretch)[0] if now is None else loose.ev(stretch, now)
            for stretch, now in zip(self.stretches(at, bend, strain), lumen, strict=True)
        ]
        return at.length * (bar + bent + self.units * float(sum(walls)))

    def volume(self, at: Section, bend: float, strain: float) -> Real:
        """Oil in the taut muscles of the left and the right side [m^3]."""
        return self.units * at.length * self.curves[at.outside][0](self.stretches(at, bend, strain))[:, 1]

    def lumen(self, at: Section, bend: float, strain: float, pressure: Pressure) -> Lumen:
        """Lumens [m^2] of slack muscles: where the energy rises by it as fast as the oil presses; None where taut."""
        loose, whole = self.curves[at.outside][1], self.units * at.length
        found: list[float | None] = []
        for side, stretch in enumerate(self.stretches(at, bend, strain)):

            def excess(lumen: float, side: int = side, stretch: float = stretch) -> float:
                return float(loose.ev(stretch, lumen, dy=1)) - pressure(side, whole * lumen)

            braid = self.muscle.lumen(stretch)
            least = 0.02 * np.pi / 4 * self.muscle.inner**2
            found.append(brentq(excess, least, braid, xtol=1e-20, rtol=1e-14) if excess(braid) > 0 else None)
        return found[0], found[1]

    def forces(self, at: Section, bend: float, strain: float, lumen: Lumen = TAUT) -> tuple[Real, Real]:
        """-dU (2,) by bend [N m] and strain [J], and dV (2, 2) by them of both sides, by differences."""
        h, push, opens = 1e-5, [], []
        taut = np.array([now is None for now in lumen])
        for db, de in ((h, 0.0), (0.0, h)):
            push.append(self.energy(at, bend - db, strain - de, lumen) - self.energy(at, bend + db, strain + de, lumen))
            opens.append(taut * (self.volume(at, bend + db, strain + de) - self.volume(at, bend - db, strain - de)))
        return np.array(push) / (2 * h), np.array(opens) / (2 * h)

    def left(self, at: Section, bend: float, strain: float, pressure: Real) -> Real:
        """What is left of both forces under given pressures."""
        push, opens = self.forces(at, bend, strain, self.lumen(at, bend, strain, lambda side, _: pressure[side]))
        return push + opens @ pressure

    def balance(self, at: Section, pressure: Real) -> Real:
        """Bend [rad] and strain at which nothing is left of both forces."""
        return 0.1 * fsolve(lambda state: self.left(at, *(0.1 * state), pressure), [0.0, -0.1], xtol=1e-8)

    @cached_property
    def whole(self) -> Section:
        """The one section that bends and shortens under the highest pressure as all do together."""
        pressure = np.array([self.highest, 0.0])
        states = np.array([self.balance(at, pressure) for at in self.sections])
        lengths = np.array([at.length for at in self.sections])
        bend, strain = states[:, 0].sum(), lengths @ states[:, 1] / lengths.sum()

        def left(scale: Real) -> Real:
            return self.left(
                Section(lengths.sum(), 1e-3 * scale[0], 1e-7 * scale[1], self.mean), bend, strain, pressure
            )

        area, second = fsolve(left, [1.0, 1.0], xtol=1e-8)
        return Section(lengths.sum(), 1e-3 * area, 1e-7 * second, self.mean)

    @cached_property
    def rest(self) -> float:
        """Strain of the straight joint when it is filled."""
        return float(self.balance(self.whole, np.array([self.fill] * 2))[1])

    @cached_property
    def viscosity(self) -> Real:
        """Viscous moment and force per rate: the relaxation time times the stiffnesses at rest."""
        h = 1e-4
        bent, long = self.forces(self.whole, h, 0.0)[0][0], self.forces(self.whole, 0.0, h)[0][1]
        short = self.forces(self.whole, 0.0, -h)[0][1]
        return -self.relaxation * np.array([bent / h, (long - short) / (2 * h)])


@dataclass(frozen=True)
class Circuit:
    """Servo, slider-crank, cylinder, line and muscles of one side; names and units as the documentation has them."""

    area: float
    crank: float
    rod: float
    neutral: float
    chamber: float
    seal: float
    stall_torque: float
    speed: float
    bandwidth: float
    friction: float
    voltage: float
    stall_current: float
    idle_current: float
    inertia: float
    resistance: float
    loss: float
    inertance: float
    oil_pump: float
    oil_unit: float
    unit_rest: float
    compliance: float
    bulk_modulus: float
    air: float
    cavitation: float

    def piston(self, angle: float) -> float:
        """Travel of the piston from full retraction [m], by the triangle of crank and rod."""
        beta = self.neutral + angle
        reach = -self.crank * np.cos(beta) + np.sqrt(self.rod**2 - (self.crank * np.sin(beta)) ** 2)
        return reach - (self.rod - self.crank)

    def pushed(self, angle: float) -> float:
        """Oil pushed out since neutral [m^3]."""
        return self.area * (self.piston(angle) - self.piston(0.0))

    def lever(self, angle: float) -> float:
        """Torque per pressure [m^3/rad]."""
        h = 1e-5
        return (self.pushed(angle + h) - self.pushed(angle - h)) / (2 * h)

    def pressure(self, oil: float, space: float, compliance: float) -> float:
        """Pressure at which oil and bubbles fill a space that gives [Pa], by bisection; not below cavitation."""

        def excess(p: float) -> float:
            bubbles = self.air * ATMOSPHERE / (ATMOSPHERE + p)
            return oil * (1 - p / self.bulk_modulus + bubbles) - space - compliance * p

        if excess(self.cavitation) < 0:
            return self.cavitation
        return brentq(excess, self.cavitation, 1e12, xtol=1e-6, rtol=1e-15)

    def servo(self, supply: float, load: float, target: float, angle: float, rate: float) -> float:
        """Acceleration of the servo [rad/s^2]: a critically damped loop within the torque-speed line."""
        loop = 2 * np.pi * self.bandwidth / np.sqrt(np.sqrt(2) - 1)
        lever = abs(self.lever(angle)) / self.area  # m of the piston per rad
        rubbed = (self.friction + self.seal * lever) * rate / np.hypot(rate, 0.05)
        motor = [self.stall_torque * (sign * supply / self.voltage - rate / self.speed) for sign in (-1, 1)]
        least, most = ((torque - load - rubbed) / self.inertia for torque in motor)
        return float(np.clip(loop**2 * (target - angle) - 2 * loop * rate, least, most))


@dataclass(frozen=True)
class Robot:
    """Chain and what moves it; ``share`` (links, joints): part of each bend that the joint before a link takes."""

    length: Real
    com: Real
    mass: Real
    inertia: Real
    share: Real
    joints: Sequence[Joint]
    circuits: Sequence[Circuit]
    added: Real  # kg
    friction: Real  # kg/m, 1/2 rho c_f S
    drag: Real  # kg/m
    clamped: bool


def centers(robot: Robot, q: NDArray[np.complex128] | Real) -> tuple[NDArray, NDArray, NDArray]:
    """Positions x, y of the centers of mass and angles of the links at q = (x, y, heading, bends) or its columns."""
    theta = q[2] + np.cumsum(robot.share @ q[3:], axis=0)
    c, s = np.cos(theta), np.sin(theta)
    length, com = (values.reshape(-1, *[1] * (q.ndim - 1)) for values in (robot.length, robot.com))
    x = q[0] + np.concatenate([0 * c[:1], np.cumsum(length * c, axis=0)[:-1]]) + com * c
    y = q[1] + np.concatenate([0 * s[:1], np.cumsum(length * s, axis=0)[:-1]]) + com * s
    return x, y, theta


def jacobian(robot: Robot, q: Real) -> NDArray:
    """Derivatives (3, links, coordinates) of x, y and angle of every link, by complex steps."""
    return np.array(centers(robot, q[:, None] + 1e-30j * np.eye(q.size))).imag / 1e-30


def accelerations(robot: Robot, q: Real, v: Real, moment: Real) -> Real:
    """Lagrange's equations for a mass that does not depend on the coordinates: J^T W (J q'' + J' q') = Q."""
    J, h = jacobian(robot, q), 1e-6
    turning = (jacobian(robot, q + h * v) - jacobian(robot, q - h * v)) / (2 * h)
    weights = np.stack([robot.mass + robot.added, robot.mass + robot.added, robot.inertia])
    M = np.einsum("pla,pl,plb->ab", J, weights, J)
    bias = np.einsum("pla,pl,plb,b->a", J, weights, turning, v)
    vx, vy, _ = J @ v
    theta = centers(robot, q)[2]
    c, s = np.cos(theta), np.sin(theta)
    along, across = c * vx + s * vy, c * vy - s * vx
    f_t, f_n = -robot.friction * along * abs(along), -robot.drag * across * abs(across)
    force = np.stack([c * f_t - s * f_n, s * f_t + c * f_n])
    load = np.einsum("pla,pl->a", J[:2], force) - bias
    load[3:] += moment
    out = np.zeros(q.size)
    free = slice(3, None) if robot.clamped else slice(None)
    out[free] = np.linalg.solve(M[free, free], load[free])
    return out


def rates(robot: Robot, state: Real, targets: Real, supply: float) -> tuple[Real, Real]:
    """How the state (q, v, strains; angle, rate, flow, passed of every circuit) changes; pump and unit pressures."""
    joints = len(robot.joints)
    n = 3 + joints
    q, v, strain = np.split(state[: 2 * n + joints], [n, 2 * n])
    circuits = state[2 * n + joints :].reshape(-1, 4)
    out, moment, seen = np.zeros_like(circuits), np.zeros(joints), np.zeros((circuits.shape[0], 2))
    longer = np.zeros(joints)
    for j, joint in enumerate(robot.joints):
        place = joint.whole, q[3 + j], joint.rest + strain[j]
        filled, units = joint.volume(joint.whole, 0.0, joint.rest), np.zeros(2)

        def oil(side: int, volume: float, j: int = j, filled: Real = filled) -> float:
            circuit, passed = robot.circuits[2 * j + side], circuits[2 * j + side, 3]
            room = circuit.unit_rest + volume - filled[side]
            return circuit.pressure(circuit.oil_unit + passed, room, circuit.compliance)

        lumen, volume = joint.lumen(*place, oil), joint.volume(*place)
        push, opens = joint.forces(*place, lumen)
        for side in (0, 1):
            k = 2 * j + side
            circuit, (angle, rate, flow, passed) = robot.circuits[k], circuits[k]
            space = circuit.chamber - circuit.pushed(angle)
            pump = circuit.pressure(circuit.oil_pump - passed, space, 0.0)
            slack = lumen[side]
            units[side] = oil(side, volume[side] if slack is None else joint.units * joint.whole.length * slack)
            drop = circuit.resistance * flow + circuit.loss * flow * abs(flow)
            turn = circuit.servo(supply, pump * circuit.lever(angle), targets[k], angle, rate)
            out[k] = rate, turn, (pump - units[side] - drop) / circuit.inertance, flow
            seen[k] = pump, units[side]
        moment[j], longer[j] = push + opens @ units
        moment[j] -= joint.viscosity[0] * v[3 + j]
        longer[j] /= joint.viscosity[1]
    return np.concatenate([v, accelerations(robot, q, v, moment), longer, out.ravel()]), seen


def run(robot: Robot, state: Real, targets: Real, supply: Real, tick: float) -> tuple[Real, Real]:
    """States and pressures (ticks + 1, ...) under targets (ticks, circuits) that are held for a tick [s] each."""
    states, pressures = [state], [rates(robot, state, targets[0], supply[0])[1]]
    for target, volts in zip(targets, supply, strict=True):
        slope = partial(_slope, robot, target, volts)
        found = solve_ivp(slope, (0, tick), states[-1], method="DOP853", rtol=1e-6, atol=1e-11)
        states.append(found.y[:, -1])
        pressures.append(rates(robot, states[-1], target, volts)[1])
    return np.array(states), np.array(pressures)


def _slope(robot: Robot, target: Real, volts: float, _: float, state: Real) -> Real:
    """`rates` as solve_ivp calls it."""
    return rates(robot, state, target, volts)[0]
