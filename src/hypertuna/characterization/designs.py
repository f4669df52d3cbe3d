"""Designs of an actuator as points of a box: one unknown of each joint is solved from the joint's best measured bend.

The designs that meet measured bends lie on a thin, curved surface. A point on it is given by all unknowns but one of
each joint, and by the noise of one bend of each joint; the last unknown follows.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hypertuna.actuation.soft_joint import LUMEN_MIN, drive_unit, joint_group, joint_sections, muscle, soft_joint
from hypertuna.arrays import Array
from hypertuna.characterization.data import Bench, usual_sd
from hypertuna.characterization.problem import Elements, computed, elements
from hypertuna.characterization.unknowns import Unknown, unknowns, with_unknowns
from hypertuna.description.robot import Robot
from hypertuna.description.schema.actuator import NEUTRAL_BRAID
from hypertuna.errors import InputError
from hypertuna.fe.geometry import WALL, joint_body

GRID = {"stiffness_factor": 2, "lever": 9}  # unknowns to solve for, the preferred first: grid points for brackets
PRECISE, NEAR = 1e-4, 1e-3  # relative tolerance of the solved bend, and relative step of a difference
MAX_STEPS = 50  # most steps of the root search
# Reasons that exclude a design.
NO_ROOM, NO_BEND, LOCKED = "no room in the section", "another bend", "braid or hose at its end"
PIPE = 1e-3  # m, wall thickness of an oil pipe
PIPES = 2  # oil pipes of a joint, one for each side


@dataclass(frozen=True)
class Solved:
    """An unknown of a joint that is solved from a bend, measured under the rising pressure of one side."""

    unknown: int  # index among the free unknowns
    element: int  # index of the bend among the measured values
    joint: int
    both: Array  # (1, 2), pressures of the left and right sides [Pa]
    sign: int  # 1 for a bend to the left


@dataclass(frozen=True)
class Design:
    """A design within the bounds: its robot and unknowns, its fit to the bench, or the reason that excludes it."""

    robot: Robot
    values: Array  # (n,), values of the unknowns [SI]
    excluded: str = ""  # the reason that excludes the design; empty if none does
    weight: float = 0.0  # logarithm of the density of the solved unknowns
    off: Array | None = None  # (elements,), computed minus measured over noise, 0 for the bends of solved unknowns
    fit: float = 0.0  # log-likelihood of the other elements


@dataclass(frozen=True)
class Designs:
    """The space of an actuator's designs: robot, bench, unknowns, measured values, and the unknowns that are solved.

    A point (n + s,) has a coordinate from 0 to 1 for each of n unknowns: its place between the logarithms of its
    bounds, or which solution to take if it is solved. The noise of the s solved bends follows, in standard deviations.
    """

    robot: Robot
    bench: Bench
    free: tuple[Unknown, ...]
    elements: Elements
    sd: Array  # (elements,), noise of instruments and model [SI]
    solved: tuple[Solved, ...]

    def values(self, point: Array) -> Array:
        """Return the unknowns (n,) [SI] at a point; entries of unknowns that are solved later are placeholders."""
        ends = ((u.log(u.lower), u.log(u.upper)) for u in self.free)
        return np.array([u.value(a + x * (b - a)) for u, (a, b), x in zip(self.free, ends, point, strict=False)])

    def at(self, point: Array) -> Design:
        """Return the design at a point (n + s,)."""
        values = self.values(point)
        robot = with_unknowns(self.robot, self.free, values, checked=False)
        try:
            if all(self.free[s.unknown].kind != "lever" for s in self.solved):
                robot = self._with_room(robot)
            log_weight = 0.0
            for k, s in enumerate(self.solved):
                robot, values[s.unknown], log_part = self._solve(robot, s, point, float(point[len(self.free) + k]))
                log_weight += log_part
            robot = self._with_room(robot)
            deviations = self._off(robot)
        except InputError as error:  # a solver's reason, or muscles that do not fit
            return Design(robot, values, str(error) if str(error) in (NO_BEND, LOCKED) else NO_ROOM)
        if not np.isfinite(deviations).all():
            return Design(robot, values, LOCKED)
        return Design(robot, values, "", log_weight, deviations, -0.5 * float(deviations @ deviations))

    def _with_room(self, robot: Robot) -> Robot:
        """Return the robot with drive units far enough apart in all measured joints; InputError if they do not fit."""
        for joint in self.bench.joints:
            robot = with_room(robot, joint)
        return robot

    def _solve(self, robot: Robot, solved: Solved, point: Array, noise: float) -> tuple[Robot, float, float]:
        """Solve an unknown from its bend: return the robot, the unknown's value [SI] and its log density."""
        unknown = self.free[solved.unknown]
        target = float(self.elements.measured[solved.element] + noise * self.sd[solved.element])

        def robot_at(value: float) -> Robot:
            return with_unknowns(robot, (unknown,), np.array([value]), checked=False)

        plain = joint_sections(robot_at(1.0), solved.joint) if unknown.kind == "stiffness_factor" else None

        def miss(value: float) -> float:  # target over bend, minus 1: nearly linear in a stiffness
            if plain is not None:
                model = soft_joint(robot, solved.joint, sections=plain * (1, 1, value, 1))
            else:
                model = soft_joint(robot_at(value), solved.joint)
            bend = solved.sign * float(np.asarray(model.bend(solved.both))[..., 0].sum())
            return target / max(bend, NEAR * target) - 1

        grid = np.geomspace(unknown.lower, unknown.upper, GRID[unknown.kind])
        misses = np.array([miss(value) for value in grid.tolist()])
        # a longer lever has a larger moment but shortens its muscle more, so two levers may give the same bend
        crossings = np.flatnonzero(misses[:-1] * misses[1:] < 0)
        if not len(crossings):
            raise InputError(NO_BEND)
        k = crossings[min(int(point[solved.unknown] * len(crossings)), len(crossings) - 1)]
        value = _crossing(miss, (float(grid[k]), float(grid[k + 1])), (float(misses[k]), float(misses[k + 1])))
        slope = (miss(value * (1 + NEAR)) - miss(value)) / NEAR
        solution = robot_at(value)
        _check_ends(solution, solved)
        return solution, value, math.log(len(crossings) / max(abs(slope), NEAR))

    def _off(self, robot: Robot) -> Array:
        """Return the deviations (elements,): computed minus measured over noise; 0 for the bends of solved unknowns."""
        off = np.zeros(len(self.sd))
        others = np.setdiff1d(np.arange(len(off)), [solved.element for solved in self.solved])
        if len(others):
            off[others] = ((self.elements.of(computed(robot, self.bench)) - self.elements.measured) / self.sd)[others]
        return off


def with_room(robot: Robot, joint: int) -> Robot:
    """Return the robot with a joint's drive units far enough apart; InputError if they or oil pipes do not fit.

    The muscles must meet the rules of finite elements in the narrowest section (`joint_body`). A film on the axis must
    fit between the muscles of the two sides. The pipes of the joints behind must fit there, or above and below.
    """
    unit, (group, actuator) = drive_unit(robot), joint_group(robot, joint)
    spacing = unit.outer_diameter + WALL
    if actuator.spacing is None or actuator.spacing < spacing:
        group_spaced = group.model_copy(update={"actuator": actuator.model_copy(update={"spacing": spacing})})
        joints = tuple(group_spaced if g == joint else other for g, other in enumerate(robot.joints))
        robot = robot.model_copy(update={"joints": joints})
    body = joint_body(robot, joint)
    gap = min(actuator.levers) - body.radius - WALL
    if gap < 0:
        rule, fix = "must leave room for a film on the axis", "give a longer lever or thinner hoses"
        raise InputError(rule, key=f"joint {group.name}, lever_m", fix=fix)
    bores = [other.line.bore for other in robot.joints[joint + 1 :] if other.line is not None]
    pipe = max(bores, default=0.0) / 2 + PIPE
    if not bores or gap >= pipe:
        return robot
    top = max(channel.z for channel in body.channels)
    distance = body.radius + WALL + pipe
    lowest = top + math.sqrt(max(0.0, distance**2 - min(actuator.levers) ** 2))
    highest = lowest + (PIPES * len(bores) / 2 - 1) * (2 * pipe + WALL)  # half of the pipes are below
    if _to_rim(float(body.semi_major.min()), float(body.semi_minor.min()), highest) < pipe + WALL:
        rule, fix = "must leave room for the oil pipes of the joints behind", "give a longer lever or thinner hoses"
        raise InputError(rule, key=f"joint {group.name}, lever_m", fix=fix)
    return robot


def _to_rim(a: float, b: float, z: float) -> float:
    """Return the distance [m] from a point at z on the semi-axis a of an ellipse to its rim; negative outside."""
    if z < (a**2 - b**2) / a:  # there are two nearest points, on either side of the semi-axis
        return b * math.sqrt(1 - z**2 / (a**2 - b**2))
    return a - z


def _crossing(function: Callable[[float], float], ends: tuple[float, float], values: tuple[float, float]) -> float:
    """Return the zero of a nearly linear function, given its values at two ends, by the Illinois method."""
    (a, b), (at_a, at_b) = ends, values
    for _ in range(MAX_STEPS):
        x = (a * at_b - b * at_a) / (at_b - at_a)
        at_x = function(x)
        if abs(at_x) < PRECISE:
            break
        if at_x * at_b < 0:
            a, at_a = b, at_b
        else:
            at_a /= 2
        b, at_b = x, at_x
    return x


def _check_ends(robot: Robot, solved: Solved) -> None:
    """Check that muscles work at the solved bend: stretched hoses stay open, and shortened muscles still pull."""
    actuator, hose = joint_group(robot, solved.joint)[1], muscle(robot)
    bent = np.asarray(soft_joint(robot, solved.joint).bend(solved.both))[0]
    axis = 1 + bent[:, 1]
    bend = np.abs(bent[:, 0]) / joint_sections(robot, solved.joint)[:, 0] / np.sqrt(axis)
    stretched, shortened = axis + max(actuator.levers) * bend, axis - max(actuator.levers) * bend
    unit = robot.drive_unit
    cosine = math.cos(unit.braid_angle) if unit is not None else 1.0
    if stretched.max() > hose.closing_stretch(LUMEN_MIN) or shortened.min() * cosine < math.cos(NEUTRAL_BRAID):
        raise InputError(LOCKED)


def designs(
    robot: Robot,
    bench: Bench,
    free: Sequence[str] | str | None = None,
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    model_error: float = 0.03,
) -> Designs:
    """Return the space of designs from which a family is sampled.

    free, bounds: as for `unknowns`. model_error: error of the fast model, relative to each measured value.
    """
    both_sides = [joint for joint in bench.joints if len(bench.sides(joint)) == 2]
    frees = unknowns(robot, bench.joints, names=free, both_sides=both_sides, bounds=bounds, optional=True)
    measured = elements(bench)
    columns = zip(measured.kind.tolist(), measured.measured.tolist(), measured.sd.tolist(), strict=True)
    noise = np.array([usual_sd(kind, value) if math.isnan(sd) else sd for kind, value, sd in columns])
    sd = np.hypot(noise, model_error * np.abs(measured.measured))
    solved = [choice for joint in bench.joints if (choice := _solved(bench, frees, measured, sd, joint)) is not None]
    return Designs(robot, bench, frees, measured, sd, tuple(solved))


def _solved(bench: Bench, frees: Sequence[Unknown], measured: Elements, sd: Array, joint: int) -> Solved | None:
    """Return the unknown of a joint to solve, with the joint's most precise bend; None if there is no such pair."""
    solvable = [(kind, k) for kind in GRID for k, u in enumerate(frees) if (u.kind, u.joint) == (kind, joint)]
    row = measured.row
    bends = (measured.kind == "angle") & (bench.joint[row] == joint) & ~bench.unload[row] & (measured.measured > 0)
    if not solvable or not bends.any():
        return None
    relative = np.round(sd[bends] / measured.measured[bends], 2)
    _, _, k = min(
        zip(relative.tolist(), (-bench.pressure[row[bends]]).tolist(), np.flatnonzero(bends).tolist(), strict=True)
    )
    side, pressures = int(bench.side[row[k]]), np.zeros((1, 2))
    pressures[0, side] = bench.pressure[row[k]]
    return Solved(solvable[0][1], k, joint, pressures, 1 - 2 * side)
