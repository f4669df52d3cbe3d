"""Fast model and finite elements on one geometry: their difference and its causes.

In the fast model (docs/actuator.md) plane sections bend and shorten, and the ends do neither. In finite elements the
sections also warp, and plates hold the ends.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypertuna.actuation.bending import Bend, bend
from hypertuna.arrays import Array
from hypertuna.display import Displayed
from hypertuna.errors import InputError
from hypertuna.fe.bend import FeBend
from hypertuna.fe.geometry import joint_body
from hypertuna.fe.section import section_bend


@dataclass(frozen=True)
class Reason:
    """One step from the fast model to finite elements: a change, and the bend after the change."""

    text: str  # the change
    angle: float  # bend of the joint after the change [rad]; NaN without equilibrium


@dataclass(frozen=True)
class FeComparison(Displayed):
    """Bends of a joint by finite elements and by the fast model at the same pressures."""

    fe: FeBend
    analytic: Bend  # by the fast model, with the described friction, at rising pressure
    reasons: tuple[Reason, ...]  # steps between the models at the highest pressure; empty by default

    @property
    def difference(self) -> Array:
        """Relative difference of the angle (n,), fast model minus finite elements [1]; NaN at rest."""
        return _relative(self.analytic.angle, self.fe.angle)

    @property
    def oil_difference(self) -> Array:
        """Relative difference of the oil (n,), fast model minus finite elements [1]; NaN at rest."""
        return _relative(self.analytic.volume, self.fe.oil)

    @property
    def shortening(self) -> Array:
        """Relative shortening of the axis (n,) by finite elements [1]."""
        length = joint_body(self.fe.robot, self.fe.joint).length
        return 1 - np.array([state.length for state in self.fe.measured]) / length

    def record(self) -> dict[str, Any]:
        """Return all numbers by names with units; the list "steps" has a record for each pressure."""
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
            "shortening_analytic_percent": 100 * analytic.shortening,
        }
        facts = {key: value for key, value in fe.record().items() if key not in ("steps", "r_squared")}
        return facts | {
            "friction": analytic.friction,
            "r_squared_fe": fe.r_squared(),
            "r_squared_analytic": analytic.r_squared(),
            "steps": [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)],
            "reasons": [{"text": reason.text, "bend_deg": math.degrees(reason.angle)} for reason in self.reasons],
        }


def _relative(value: Array, reference: Array) -> Array:
    """Return the difference of value and reference over the reference [1]; NaN where the reference is nearly zero."""
    small = np.abs(reference) <= 1e-9 * max(1e-300, float(np.abs(reference).max(initial=0.0)))
    return np.where(small, math.nan, (value - reference) / np.where(small, 1.0, reference))


def compare(fe: FeBend, *, reasons: bool = False) -> FeComparison:
    """Compare the fast model with finite elements, optionally with the reasons for their difference."""
    if not len(fe.pressure):
        raise InputError("must reach a pressure", key="pressure", value=fe.status_text, fix="start with a lower one")
    analytic = bend(fe.robot, fe.joint, fe.pressure, side=fe.side, material=fe.material)
    steps = _reasons(fe) if reasons and fe.pressure[-1] > 0 else ()
    return FeComparison(fe, analytic, steps)


def _reasons(fe: FeBend) -> tuple[Reason, ...]:
    """Return the bend at the highest pressure after each step from the fast model to finite elements."""
    robot, joint, highest = fe.robot, fe.joint, fe.pressure[-1:]
    options: dict[str, Any] = {"side": fe.side, "material": fe.material}
    sections = section_bend(robot, joint, highest, side=fe.side, options=fe.options)
    angles = {
        "fast model as described": bend(robot, joint, highest, **options).angle,
        "no friction of the braids": bend(robot, joint, highest, friction=False, **options).angle,
        "sections by finite elements, along the whole length": sections.angle,
        "whole body by finite elements: ends held by plates": fe.angle[-1:],
    }
    return tuple(Reason(text, float(angle[0])) for text, angle in angles.items())
