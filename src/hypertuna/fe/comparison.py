"""Analytic model and finite elements on one and the same geometry: how far they differ, and why.

The analytic model (docs/actuator.md) takes a neutral layer that keeps its length. Nothing does in a body of silicone:
under pressure in the units of one side it shortens, N F / (E A), as it bends, N F w / (E I). `shortening_bend` releases
that layer. A segment then has two unknowns, the stretch of its axis l and its curvature k per length at rest; units of
the side with the pressure, at the lever w, and of the other, at v, have the stretches l - k w and l + k v, and force
and moment balance:

    N [F(P, l - k w) + F_0(l + k v)] + mu A (l - 1/l^2) = 0,    N [w F(P, l - k w) - v F_0(l + k v)] = E I k.

A and I are those of the section less the channels, about y = 0: that channels at unlike levers move the center of the
area a little is left out. A unit without pressure that gets longer is held by its braid; one that gets shorter has a
slack braid, and only its wall resists.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna.actuation.bending import Bend, bend, check_side
from hypertuna.actuation.soft_joint import drive_unit, joint_group, mooney, muscle
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.fe.bend import FeBend
from hypertuna.fe.geometry import joint_body
from hypertuna.fe.record import oil_taken
from hypertuna.fe.section import section_bend

__all__ = ["FeComparison", "Reason", "compare", "shortening_bend"]

Array = NDArray[np.float64]

STEP = 5e3  # Pa, largest of the path that leads to a pressure
BALANCED = 1e-6  # strain and curvature times lever that what is left of force and moment may stand for


@dataclass(frozen=True)
class Reason:
    """One step from the analytic model to finite elements."""

    text: str  # what was changed in addition
    angle: float  # angle of the joint then [rad]; NaN where it was not found


@dataclass(frozen=True)
class FeComparison:
    """Both models of a joint at the same pressures."""

    fe: FeBend
    # at the pressures that finite elements reached, with friction as the description has it, on the way up
    analytic: Bend
    reasons: tuple[Reason, ...]  # at the highest pressure; empty where they were not asked for

    @property
    def difference(self) -> Array:
        """Angle of the analytic model less that of finite elements, over the latter [1], shape (n,); NaN at rest."""
        return _relative(self.analytic.angle, self.fe.angle)

    @property
    def oil(self) -> Array:
        """Oil taken in since rest by finite elements [m^3], shape (n,)."""
        return oil_taken(self.fe)

    @property
    def oil_difference(self) -> Array:
        """The same of the oil [1], shape (n,)."""
        return _relative(self.analytic.volume, self.oil)

    @property
    def shortening(self) -> Array:
        """How much of its length the axis, where the analytic model has its neutral layer, loses [1], shape (n,)."""
        length = joint_body(self.fe.robot, self.fe.joint).length
        return 1 - np.array([found.length for found in self.fe.measured]) / length


def _relative(value: Array, reference: Array) -> Array:
    """Difference over the reference, NaN where that is next to nothing."""
    small = np.abs(reference) <= 1e-9 * max(1e-300, float(np.abs(reference).max(initial=0.0)))
    return np.where(small, math.nan, (value - reference) / np.where(small, 1.0, reference))


def compare(found: FeBend, *, reasons: bool = False) -> FeComparison:
    """Put the analytic model beside finite elements."""
    if not len(found.pressure):
        raise InputError("must reach a pressure", key="pressure", value=found.status_text, fix="begin with a lower one")
    analytic = bend(found.robot, found.joint, found.pressure, side=found.side, material=found.material)
    steps = _reasons(found) if reasons and found.pressure[-1] > 0 else ()
    return FeComparison(found, analytic, steps)


def _reasons(found: FeBend) -> tuple[Reason, ...]:
    """Change the analytic model step by step, at the highest pressure."""
    robot, joint, highest = found.robot, found.joint, found.pressure[-1:]
    options: dict[str, Any] = {"side": found.side, "material": found.material}
    bare = _bare(robot, joint)
    return (
        Reason("analytic model as described", float(bend(robot, joint, highest, **options).angle[0])),
        Reason("braids do not rub", float(bend(robot, joint, highest, friction=False, **options).angle[0])),
        Reason(
            "matrix by its sections alone: no sleeve_m, no stiffness_factor",
            float(bend(bare, joint, highest, friction=False, **options).angle[0]),
        ),
        Reason(
            "the neutral layer may get shorter",
            float(shortening_bend(bare, joint, highest, **options)[0]),
        ),
        Reason(
            "sections by finite elements: matrix swells and warps around the hoses",
            float(section_bend(robot, joint, highest, side=found.side, options=found.options).angle[0]),
        ),
        Reason("the whole body by finite elements: ends held by plates", float(found.angle[-1])),
    )


def _bare(robot: Robot, joint: str | int) -> Robot:
    """Take out of a description what stands for effects that a section does not have."""
    _, actuator = joint_group(robot, joint)
    plain = {"actuator": actuator.model_copy(update={"stiffness_factor": 1.0})}
    joints = tuple(group.model_copy(update=plain) if group.actuator is actuator else group for group in robot.joints)
    unit = drive_unit(robot).model_copy(update={"sleeve": 0.0})
    return robot.model_copy(update={"joints": joints, "drive_unit": unit})


def shortening_bend(
    robot: Robot, joint: str | int, pressure: ArrayLike, *, side: str = "left", material: str | None = None
) -> Array:
    """Bend a joint whose neutral layer may get shorter, by the pressure of one side and without friction.

    `pressure` (n,) [Pa]; returns [rad].
    """
    _, actuator = joint_group(robot, joint)
    left, right = (actuator.lever * (1 + sign * actuator.asymmetry / 2) for sign in (1, -1))
    levers = (right, left) if check_side(side) else (left, right)
    rising = np.atleast_1d(np.asarray(pressure, dtype=np.float64))
    total = np.zeros(len(rising))
    sections = zip(actuator.segment_length, actuator.semi_major, actuator.semi_minor, strict=True)
    for length, major, minor in sections:
        total += length * _curvature(robot, joint, rising, levers, (major, minor), material)
    return total


def _curvature(
    robot: Robot,
    joint: str | int,
    rising: Array,
    levers: tuple[float, float],
    section: tuple[float, float],
    material: str | None,
) -> Array:
    """Curvature of one section per length at rest at every pressure [1/m]; levers of the side with it and the other."""
    from scipy.optimize import root

    unit, (group, actuator) = drive_unit(robot), joint_group(robot, joint)
    hose, matrix = (mooney(robot, name, material) for name in (unit.hose, unit.matrix))
    count, mean, radius = cast(int, group.drive_units), actuator.lever, unit.outer_diameter / 2
    near, far = (lever / mean for lever in levers)
    a, b = section
    area = math.pi * (a * b - 2 * count * radius**2)
    holes = count * radius**2 * sum(lever**2 + radius**2 / 4 for lever in levers)
    inertia = actuator.stiffness_factor * math.pi * (a * b**3 / 4 - holes)
    tube = muscle(robot, material, friction=False)
    ring = math.pi * (radius**2 - (unit.inner_diameter / 2) ** 2)

    def unbalanced(x: Array, pressure: float) -> Array:
        """Force and moment over the matrix' stiffness, of the axis' stretch and curvature times mean lever."""
        axis, turn = x
        pulled = tube.at(np.array([axis - near * turn]), pressure=pressure)["pull"][0]
        long = axis + far * turn
        slack = 2 * ring * (hose.c1 + hose.c2 / long) * (long - 1 / long**2)
        held = tube.at(np.array([long]), pressure=0.0)["pull"][0] if long > 1 else slack
        force = count * (pulled + held) + matrix.modulus / 3 * area * (axis - 1 / axis**2)
        moment = count * mean * (near * pulled - far * held) - matrix.modulus * inertia * turn / mean
        return np.array([force / (matrix.modulus * area), moment * mean / (matrix.modulus * inertia)])

    state, reached, found = np.array([1.0, 0.0]), 0.0, np.full(len(rising), math.nan)
    for k, value in enumerate(rising):
        for step in np.linspace(reached, value, 1 + math.ceil((value - reached) / STEP))[1:]:
            state = root(unbalanced, state, args=(float(step),), tol=1e-12).x
            if not np.abs(unbalanced(state, float(step))).max() < BALANCED:
                return found
        reached, found[k] = float(value), state[1] / mean
    return found
