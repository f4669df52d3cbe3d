"""From servo to wake, plainly: Lagrange's equations in the world frame, pressures by root finding, SciPy's DOP853.

The chain is the paper's: lumped added mass and drag at each center of mass, or none of them in air with the head held.
Muscles are integrated numerically through their walls; pressures are roots of the oil's volume; the inertia is
made of Jacobians, and those of complex steps. Nothing is shared with the core but the equations of the documentation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import BSpline, make_interp_spline
from scipy.optimize import brentq

Real = NDArray[np.float64]
ATMOSPHERE = 101325.0
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


@dataclass(frozen=True)
class Muscle:
    """A hose (outer, inner diameter [m]) of neo-Hookean silicone C1 [Pa] in a braid at ``angle`` [rad]."""

    outer: float
    inner: float
    angle: float
    c1: float

    def braid(self, stretch: float) -> float:
        """Diameter of the braid [m]: a strand of given length wound a given number of times."""
        strand, turns = 1 / np.cos(self.angle), np.tan(self.angle) / (np.pi * self.outer)
        return np.sqrt(strand**2 - stretch**2) / (turns * np.pi)

    def lumen(self, stretch: float) -> float:
        """Volume inside the hose per length at rest [m^2]: what the braid encloses less the wall."""
        wall = np.pi / 4 * (self.outer**2 - self.inner**2)
        return np.pi / 4 * self.braid(stretch) ** 2 * stretch - wall

    def energy(self, stretch: float) -> float:
        """Energy of the wall per length at rest [J/m], integrated through it."""
        R = (self.outer + self.inner + (self.outer - self.inner) * NODES) / 4
        r2 = (self.braid(stretch) / 2) ** 2 - ((self.outer / 2) ** 2 - R**2) / stretch
        hoop2 = r2 / R**2
        density = self.c1 * (stretch**2 + hoop2 + 1 / (stretch**2 * hoop2) - 3) * 2 * np.pi * R
        return float(WEIGHTS @ density) * (self.outer - self.inner) / 4


@dataclass(frozen=True)
class Joint:
    """Segments that bend as the pressure of one side alone bends them; ``units`` muscles a side at ``lever`` [m]."""

    muscle: Muscle
    units: int
    lever: float
    length: Sequence[float]  # m
    stiffness: Sequence[float]  # N m^2, E I
    relaxation: float  # s
    pressure_max: float  # Pa, of one side alone, up to which the joint is looked at

    def segment_energy(self, i: int, bend: float) -> float:
        """Energy of a segment's matrix and walls [J]."""
        strain = self.lever * bend / self.length[i]
        walls = self.muscle.energy(1 - strain) + self.muscle.energy(1 + strain)
        return 0.5 * self.stiffness[i] / self.length[i] * bend**2 + self.units * self.length[i] * walls

    def segment_volume(self, i: int, bend: float) -> float:
        """Oil in the muscles of the segment's left side [m^3]; the right side has that of the opposite bend."""
        return self.units * self.length[i] * self.muscle.lumen(1 - self.lever * bend / self.length[i])

    def segment_bend(self, i: int, pressure: float) -> float:
        """Bend at which a segment's energy less the work of the left side's pressure is least [rad]."""
        h = 1e-5

        def slope(bend: float) -> float:
            energy = self.segment_energy(i, bend + h) - self.segment_energy(i, bend - h)
            return energy - pressure * (self.segment_volume(i, bend + h) - self.segment_volume(i, bend - h))

        return float(brentq(slope, -1e-3, 0.6 * self.length[i] / self.lever * 0.4, xtol=1e-14))

    @cached_property
    def splines(self) -> tuple[BSpline, BSpline, BSpline]:
        """Energy, and oil of the left and the right side beyond the straight joint's, over the whole bend."""
        segments = range(len(self.length))
        rows = []
        for pressure in np.linspace(0, self.pressure_max**0.5, 60) ** 2:
            bends = [self.segment_bend(i, pressure) if pressure > 0 else 0.0 for i in segments]
            energy = sum(self.segment_energy(i, bend) for i, bend in zip(segments, bends, strict=True))
            left, right = (
                sum(self.segment_volume(i, side * bend) for i, bend in zip(segments, bends, strict=True))
                for side in (1, -1)
            )
            rows.append((sum(bends), energy, left, right))
        mirrored = [(-bend, energy, right, left) for bend, energy, left, right in rows[:0:-1]]
        table = np.array(mirrored + rows)
        table[:, 1:] -= table[len(rows) - 1, 1:]
        return tuple(make_interp_spline(table[:, 0], column, k=7) for column in table.T[1:])

    @cached_property
    def viscosity(self) -> float:
        """Viscous moment per rate [N m s/rad]: the relaxation time of matrix and walls times the stiffness at rest."""
        return self.relaxation * float(self.splines[0](0.0, 2))


@dataclass(frozen=True)
class Circuit:
    """Servo, slider-crank, cylinder, line and muscles of one side; names and units as the documentation has them."""

    area: float
    crank: float
    rod: float
    neutral: float
    chamber: float
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
        return brentq(excess, self.cavitation, 1e9, xtol=1e-6, rtol=1e-15)

    def servo(self, supply: float, load: float, target: float, angle: float, rate: float) -> float:
        """Acceleration of the servo [rad/s^2]: a critically damped loop within the torque-speed line."""
        loop = 2 * np.pi * self.bandwidth / np.sqrt(np.sqrt(2) - 1)
        rubbed = self.friction * rate / np.hypot(rate, 0.05)
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
    """Positions x, y of the centers of mass and angles of the links at q = (x, y, heading, bends)."""
    theta = q[2] + np.cumsum(robot.share @ q[3:])
    c, s = np.cos(theta), np.sin(theta)
    x = q[0] + np.concatenate([[0], np.cumsum(robot.length * c)[:-1]]) + robot.com * c
    y = q[1] + np.concatenate([[0], np.cumsum(robot.length * s)[:-1]]) + robot.com * s
    return x, y, theta


def jacobian(robot: Robot, q: Real) -> NDArray:
    """Derivatives (3, links, coordinates) of x, y and angle of every link, by complex steps."""
    columns = []
    for k in range(q.size):
        step = q.astype(complex)
        step[k] += 1e-30j
        columns.append([part.imag / 1e-30 for part in centers(robot, step)])
    return np.moveaxis(np.array(columns), 0, -1)


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
    """How the state (q, v, then angle, rate, flow, passed of every circuit) changes; pump and unit pressures."""
    joints = len(robot.joints)
    n = 3 + joints
    q, v, circuits = state[:n], state[n : 2 * n], state[2 * n :].reshape(-1, 4)
    out, moment, seen = np.zeros_like(circuits), np.zeros(joints), np.zeros((circuits.shape[0], 2))
    for j, joint in enumerate(robot.joints):
        bend, (energy, *volume) = q[3 + j], joint.splines
        moment[j] = -energy(bend, 1) - joint.viscosity * v[3 + j]
        for side in (0, 1):
            k = 2 * j + side
            circuit, (angle, rate, flow, passed) = robot.circuits[k], circuits[k]
            space = circuit.chamber - circuit.pushed(angle)
            pump = circuit.pressure(circuit.oil_pump - passed, space, 0.0)
            room = circuit.unit_rest + volume[side](bend)
            unit = circuit.pressure(circuit.oil_unit + passed, room, circuit.compliance)
            moment[j] += unit * volume[side](bend, 1)
            drop = circuit.resistance * flow + circuit.loss * flow * abs(flow)
            turn = circuit.servo(supply, pump * circuit.lever(angle), targets[k], angle, rate)
            out[k] = rate, turn, (pump - unit - drop) / circuit.inertance, flow
            seen[k] = pump, unit
    return np.concatenate([v, accelerations(robot, q, v, moment), out.ravel()]), seen


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
