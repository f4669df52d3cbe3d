"""Analytic model and finite elements on one geometry: their difference and its causes.

The analytic model (docs/actuator.md) assumes a neutral layer of constant length. A body of silicone has none: under
pressure in the units of one side it shortens, N F / (E A), as it bends, N F w / (E I). `shortening_bend` releases that
layer. A segment then has two unknowns, the stretch of its axis l and its curvature k per length at rest; units of the
side with the pressure, at the lever w, and of the other, at v, have the stretches l - k w and l + k v, and force and
moment balance:

    N [F(P, l - k w) + F_0(l + k v)] + mu A (l - 1/l^2) = 0,    N [w F(P, l - k w) - v F_0(l + k v)] = E I k.

A and I are those of the section without the channels, about y = 0; the small shift of the centroid by channels at
unequal levers is neglected. A unit without pressure that lengthens is held by its braid; in one that shortens the braid
is slack and only the wall resists.
"""

import math
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.actuation.bending import Bend, bend, check_side
from hypertuna.actuation.soft_joint import drive_unit, joint_group, mooney, muscle
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.fe.bend import FeBend
from hypertuna.fe.geometry import joint_body
from hypertuna.fe.section import section_bend

STEP = 5e3  # Pa, largest step of the path to a pressure
BALANCED = 1e-6  # tolerance of force and moment as strain, and as curvature times lever


@dataclass(frozen=True)
class Reason:
    """One step from the analytic model to finite elements."""

    text: str  # the change
    angle: float  # of the joint after the change [rad]; NaN without equilibrium


@dataclass(frozen=True)
class FeComparison:
    """Both models of a joint at the same pressures."""

    fe: FeBend
    analytic: Bend  # at the pressures of the finite elements, with the described friction, at rising pressure
    reasons: tuple[Reason, ...]  # at the highest pressure; empty by default

    @property
    def difference(self) -> Array:
        """Relative difference of the angle, analytic minus finite elements, (n,); NaN at rest."""
        return _relative(self.analytic.angle, self.fe.angle)

    @property
    def oil_difference(self) -> Array:
        """Relative difference of the oil, (n,)."""
        return _relative(self.analytic.volume, self.fe.oil)

    @property
    def shortening(self) -> Array:
        """Relative shortening of the axis, the neutral layer of the analytic model, (n,)."""
        length = joint_body(self.fe.robot, self.fe.joint).length
        return 1 - np.array([state.length for state in self.fe.measured]) / length

    def record(self) -> dict[str, Any]:
        """Return all numbers with units in their names, a step for each pressure."""
        fe, analytic = self.fe, self.analytic
        columns = {
            "pressure_kpa": fe.pressure / 1e3,
            "bend_fe_deg": np.degrees(fe.angle),
            "bend_analytic_deg": np.degrees(analytic.angle),
            "bend_difference_percent": 100 * self.difference,
            "oil_fe_ml": 1e6 * fe.oil,
            "oil_analytic_ml": 1e6 * analytic.volume,
            "oil_difference_percent": 100 * self.oil_difference,
            "shortening_percent": 100 * self.shortening,
        }
        kept = {key: value for key, value in fe.record().items() if key not in ("steps", "r_squared")}
        return kept | {
            "friction": analytic.friction,
            "r_squared_fe": fe.r_squared(),
            "r_squared_analytic": analytic.r_squared(),
            "steps": [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)],
            "reasons": [{"text": reason.text, "bend_deg": math.degrees(reason.angle)} for reason in self.reasons],
        }


def _relative(value: Array, reference: Array) -> Array:
    """Return the difference over the reference, NaN where the reference is nearly zero."""
    small = np.abs(reference) <= 1e-9 * max(1e-300, float(np.abs(reference).max(initial=0.0)))
    return np.where(small, math.nan, (value - reference) / np.where(small, 1.0, reference))


def compare(fe: FeBend, *, reasons: bool = False) -> FeComparison:
    """Compare the analytic model with finite elements, optionally with the reasons of the difference."""
    if not len(fe.pressure):
        raise InputError("must reach a pressure", key="pressure", value=fe.status_text, fix="start with a lower one")
    analytic = bend(fe.robot, fe.joint, fe.pressure, side=fe.side, material=fe.material)
    steps = _reasons(fe) if reasons and fe.pressure[-1] > 0 else ()
    return FeComparison(fe, analytic, steps)


def _reasons(fe: FeBend) -> tuple[Reason, ...]:
    """Change the analytic model step by step at the highest pressure."""
    robot, bare, joint, highest = fe.robot, _bare(fe.robot, fe.joint), fe.joint, fe.pressure[-1:]
    options: dict[str, Any] = {"side": fe.side, "material": fe.material}
    angles = {
        "analytic model as described": bend(robot, joint, highest, **options).angle,
        "no friction of the braids": bend(robot, joint, highest, friction=False, **options).angle,
        "matrix of the sections alone: no sleeve_m, no stiffness_factor": bend(
            bare, joint, highest, friction=False, **options
        ).angle,
        "neutral layer that may shorten": shortening_bend(bare, joint, highest, **options),
        "sections by finite elements: matrix swells and warps around the hoses": section_bend(
            robot, joint, highest, side=fe.side, options=fe.options
        ).angle,
        "whole body by finite elements: ends held by plates": fe.angle[-1:],
    }
    return tuple(Reason(text, float(angle[0])) for text, angle in angles.items())


def _bare(robot: Robot, joint: str | int) -> Robot:
    """Return the robot without the parameters of effects that a section does not have."""
    _, actuator = joint_group(robot, joint)
    plain = {"actuator": actuator.model_copy(update={"stiffness_factor": 1.0})}
    joints = tuple(group.model_copy(update=plain) if group.actuator is actuator else group for group in robot.joints)
    unit = drive_unit(robot).model_copy(update={"sleeve": 0.0})
    return robot.model_copy(update={"joints": joints, "drive_unit": unit})


def shortening_bend(
    robot: Robot, joint: str | int, pressure: ArrayLike, *, side: str = "left", material: str | None = None
) -> Array:
    """Return angles (n,) [rad] of a joint whose neutral layer may shorten, at pressures (n,) [Pa], without friction."""
    _, actuator = joint_group(robot, joint)
    levers = actuator.levers[::-1] if check_side(side) else actuator.levers
    rising = np.atleast_1d(np.asarray(pressure, dtype=np.float64))
    sections = zip(actuator.segment_length, actuator.semi_major, actuator.semi_minor, strict=True)
    bends = [length * _curvature(robot, joint, rising, levers, half, material) for length, *half in sections]
    return np.asarray(sum(bends, np.zeros(len(rising))))


def _curvature(
    robot: Robot, joint: str | int, rising: Array, levers: tuple[float, float], half: list[float], material: str | None
) -> Array:
    """Return curvatures of a section (n,) [1/m]; the first lever is that of the side with the pressure."""
    from scipy.optimize import root

    unit, (group, actuator) = drive_unit(robot), joint_group(robot, joint)
    hose, matrix = (mooney(robot, name, material) for name in (unit.hose, unit.matrix))
    count, mean, radius = cast(int, group.drive_units), actuator.lever, unit.outer_diameter / 2
    near, far = (lever / mean for lever in levers)
    a, b = half
    area = math.pi * (a * b - 2 * count * radius**2)
    holes = count * radius**2 * sum(lever**2 + radius**2 / 4 for lever in levers)
    inertia = actuator.stiffness_factor * math.pi * (a * b**3 / 4 - holes)
    tube = muscle(robot, material, friction=False)
    ring = math.pi * (radius**2 - (unit.inner_diameter / 2) ** 2)

    def unbalanced(x: Array, pressure: float) -> Array:
        """Return force and moment over the matrix' stiffness at the axis' stretch and curvature times mean lever."""
        axis, turn = x
        pulled = tube.at(np.array([axis - near * turn]), pressure=pressure)["pull"][0]
        long = axis + far * turn
        slack = 2 * ring * (hose.c1 + hose.c2 / long) * (long - 1 / long**2)
        held = tube.at(np.array([long]), pressure=0.0)["pull"][0] if long > 1 else slack
        force = count * (pulled + held) + matrix.modulus / 3 * area * (axis - 1 / axis**2)
        moment = count * mean * (near * pulled - far * held) - matrix.modulus * inertia * turn / mean
        return np.array([force / (matrix.modulus * area), moment * mean / (matrix.modulus * inertia)])

    state, reached, curvature = np.array([1.0, 0.0]), 0.0, np.full(len(rising), math.nan)
    for k, value in enumerate(rising):
        for step in np.linspace(reached, value, 1 + math.ceil((value - reached) / STEP))[1:]:
            state = root(unbalanced, state, args=(float(step),), tol=1e-12).x
            if not np.abs(unbalanced(state, float(step))).max() < BALANCED:
                return curvature
        reached, curvature[k] = float(value), state[1] / mean
    return curvature
