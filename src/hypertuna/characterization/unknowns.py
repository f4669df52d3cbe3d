"""Unknowns of an actuator: what of its geometry and materials a bench may identify, and the robot that they make."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.actuation.soft_joint import mooney
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.actuator import NEUTRAL_BRAID
from hypertuna.errors import InputError, did_you_mean
from hypertuna.identification.names import split_names

__all__ = [
    "BORDER",
    "FACTORS",
    "PER_JOINT",
    "SHARED",
    "Unknown",
    "check_tables",
    "keys_of",
    "unknowns",
    "with_unknowns",
]

Array = NDArray[np.float64]

# Unknowns and how far they may reasonably lie from what the description says: factors, but for braid angle [rad],
# friction [1] and diameter ratio [1], which have limits of their own. What a robot's file says in [sources] decides
# how well each is really known; --bounds says so.
PER_JOINT = {
    "lever": (0.5, 2.0),  # no drawing shows it; it must be inside the section
    "segment_length": (0.8, 1.25),  # links are measured, the end walls that do not bend are not
    "stiffness_factor": (0.25, 4.0),  # strip, pipes and channels stiffen and weaken the matrix
    "asymmetry": (math.exp(-0.3), math.exp(0.3)),  # as the ratio of the two levers
}
SHARED = {
    "braid_angle": (math.radians(20), math.radians(50)),  # at 54.7 deg a muscle does not pull at all
    "outer_diameter": (0.5, 2.0),
    "diameter_ratio": (0.4, 0.9),  # inner over outer diameter: a hose has a wall, and a lumen
    "hose_modulus": (0.5, 2.0),  # published constants of one silicone differ by 2.0 (docs/bench.md)
    "matrix_modulus": (0.5, 2.0),
    "sleeve": (0.5, 2.0),
    "friction": (0.01, 1.0),
}
# What a muscle's pull and stiffness are proportional to, where that is not the unknown itself.
FACTORS = {
    "braid_angle": ("braid_pull", "2 / tan^2(braid_angle) - 1, the pull at rest over pressure and section"),
    "diameter_ratio": ("hose_wall", "1 - diameter_ratio^2, the part of the hose's section that is wall"),
}
# Units at the border, and how many of them are one SI unit. Numbers without a unit say what they count from.
BORDER = {"m": ("mm", 1e3), "rad": ("deg", 180 / math.pi), "1": ("1", 1.0)}
INSIDE = 1 - 1e-9  # of a limit that the described values must stay below
STEP = 1e-5  # of a logarithm, for differences
ABSOLUTE = ("braid_angle", "diameter_ratio", "friction")
NAME = re.compile(r"(?P<kind>\w+)(?:\[(?P<joint>[^\]]*)\])?")


@dataclass(frozen=True)
class Unknown:
    """One unknown, positive, and sought by a logarithm: its own, or that of a factor that pull or stiffness go by.

    Attributes
    ----------
    kind : str
        Key of `PER_JOINT` or `SHARED`.
    joint : int or None
        The joint group that it belongs to; None if all share it.
    name : str
        ``lever[I]``.
    described : float
        Value that the description gives: SI units for lever, braid angle, outer diameter and sleeve, else a number:
        a modulus and a segment length as a factor of what is described, asymmetry as the ratio of the left lever to
        the right one.
    lower, upper : float
        What is held possible without the bench.
    """

    kind: str
    joint: int | None
    name: str
    described: float
    lower: float
    upper: float

    @property
    def unit(self) -> str:
        """SI unit, "1" for a number."""
        return {"lever": "m", "outer_diameter": "m", "sleeve": "m", "braid_angle": "rad"}.get(self.kind, "1")

    @property
    def factor(self) -> str:
        """What stands for the unknown in products of powers, since pull and stiffness go by it: see `FACTORS`."""
        return self.name if self.kind not in FACTORS else FACTORS[self.kind][0]

    def log(self, value: float) -> float:
        """Logarithm of the factor."""
        if self.kind == "braid_angle":
            return math.log(2 / math.tan(value) ** 2 - 1)
        return math.log(1 - value**2) if self.kind == "diameter_ratio" else math.log(value)

    def value(self, log: float) -> float:
        """Undo `log`."""
        if self.kind == "braid_angle":
            return math.atan(math.sqrt(2 / (1 + math.exp(log))))
        return math.sqrt(-math.expm1(log)) if self.kind == "diameter_ratio" else math.exp(log)

    @property
    def prior_sd(self) -> float:
        """Standard deviation of the logarithm if nothing but the bounds is known: that of a uniform distribution."""
        return abs(self.log(self.upper) - self.log(self.lower)) / math.sqrt(12)

    def relative(self, value: float) -> float:
        """Tell by how much the unknown's own logarithm changes with that of its factor.

        Parameters
        ----------
        value : float
            Where [SI].

        Returns
        -------
        float
            Without sign [1].
        """
        steps = (math.log(self.value(self.log(value) + side * STEP)) for side in (1, -1))
        return abs(next(steps) - next(steps)) / (2 * STEP)


def check_tables(robot: Robot, joints: Sequence[int]) -> None:
    """Check that a robot describes the actuators of some joints.

    Parameters
    ----------
    robot : Robot
    joints : sequence of int

    Raises
    ------
    InputError
        If a table or the constants of a material are missing: with their name.
    """
    fix = "add it to the robot's file; docs/description.md tells its keys, robots/hypertuna.toml shows one"
    if robot.drive_unit is None:
        raise InputError("is needed to identify an actuator", file=robot.file, key="table [drive_unit]", fix=fix)
    for material in (robot.drive_unit.hose, robot.drive_unit.matrix):
        mooney(robot, material)  # says what the set of constants in use lacks
    for j in joints:
        group = robot.joints[j]
        for key, part in (("actuator", group.actuator), ("drive_units", group.drive_units)):
            if part is None:
                place = f"joints[{j}].{key}, of joint {group.name},"
                raise InputError("is needed to identify an actuator", file=robot.file, key=place, fix=fix)


def unknowns(
    robot: Robot,
    joints: Sequence[int],
    *,
    names: Sequence[str] | str | None = None,
    both_sides: Sequence[int] = (),
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> tuple[Unknown, ...]:
    """List what a bench may identify.

    Parameters
    ----------
    robot : Robot
    joints : sequence of int
        Joint groups that were measured.
    names : sequence of str or str, optional
        Unknowns to free, such as ``lever`` (of every joint measured) or ``lever[I]``; all if left out.
    both_sides : sequence of int
        Joint groups that were bent both ways: asymmetry is free for them only, unless it is named.
    bounds : mapping, optional
        Lowest and highest value by name [SI]; others are `PER_JOINT` and `SHARED`.

    Returns
    -------
    tuple of Unknown

    Raises
    ------
    InputError
        If a table is missing, a name is not known, or bounds do not hold what is described.
    """
    check_tables(robot, joints)
    found = []
    for kind in PER_JOINT:
        found += [_make(robot, kind, j) for j in joints if kind != "asymmetry" or j in both_sides or names]
    unit = robot.drive_unit
    assert unit is not None
    for kind in SHARED:
        if kind != "sleeve" or unit.sleeve > 0:
            found.append(_make(robot, kind, None))
    if names is not None:
        found = _named(found, split_names(names) if isinstance(names, str) else list(names))
    return tuple(_bounded(robot, found, bounds or {}))


def _make(robot: Robot, kind: str, joint: int | None) -> Unknown:
    """Describe an unknown with its default bounds."""
    value = _described(robot, kind, joint)
    low, high = PER_JOINT[kind] if joint is not None else SHARED[kind]
    factor = 1.0 if kind in ABSOLUTE or kind == "asymmetry" else value
    name = kind if joint is None else f"{kind}[{robot.joints[joint].name}]"
    value = max(value, low) if kind == "friction" else value
    lower, upper = min(low * factor, value), max(high * factor, value)
    return Unknown(kind, joint, name, value, lower, min(upper, INSIDE * _most(robot, kind, joint)))


def _most(robot: Robot, kind: str, joint: int | None) -> float:
    """Return what an unknown must stay below."""
    if kind == "lever" and joint is not None:
        actuator = robot.joints[joint].actuator
        assert actuator is not None
        return min(actuator.semi_minor)
    return {"braid_angle": NEUTRAL_BRAID, "diameter_ratio": 1.0}.get(kind, math.inf)


def _described(robot: Robot, kind: str, joint: int | None) -> float:
    """Read the value of an unknown from a robot."""
    if joint is not None:
        actuator = robot.joints[joint].actuator
        assert actuator is not None
        if kind == "asymmetry":
            return (2 + actuator.asymmetry) / (2 - actuator.asymmetry)
        return 1.0 if kind == "segment_length" else float(getattr(actuator, kind))
    unit = robot.drive_unit
    assert unit is not None
    if kind == "diameter_ratio":
        return unit.inner_diameter / unit.outer_diameter
    return 1.0 if kind.endswith("modulus") else float(getattr(unit, kind))


def _named(known: Sequence[Unknown], names: Sequence[str]) -> list[Unknown]:
    """Choose unknowns by name; without brackets a name covers every joint."""
    chosen: list[Unknown] = []
    for name in names:
        mine = _matching(known, name)
        if any(one in chosen for one in mine):
            raise InputError("must be free once", key=f"free {name}", value="named twice", fix="remove it from one")
        chosen += mine
    if not chosen:
        raise InputError("must name one unknown at least", key="free", fix="leave it out for all")
    return chosen


def _matching(known: Sequence[Unknown], name: str) -> list[Unknown]:
    """Unknowns that a name covers."""
    mine = [one for one in known if name in (one.name, one.kind)]
    if not mine:
        match = NAME.fullmatch(name)
        near = [one.name for one in known if match and one.kind == match["kind"]]
        fix = did_you_mean(name, near or list(dict.fromkeys(one.kind for one in known)))
        raise InputError("must be an unknown of this bench and robot", key=f"free {name}", fix=fix)
    return mine


def _bounded(robot: Robot, found: Sequence[Unknown], bounds: Mapping[str, tuple[float, float]]) -> list[Unknown]:
    """Give unknowns the bounds that the user says."""
    ends: dict[str, tuple[float, float]] = {}
    for name, pair in bounds.items():
        for one in _matching(found, name):
            low, high = ends[one.name] = pair
            (unit, factor), key = BORDER[one.unit], f"bounds {name}"
            unit = "" if unit == "1" else f" {unit}"
            value = f"{low * factor:g} to {high * factor:g}{unit}"
            if 0 < high < low < math.inf:
                fix = f"exchange the two, {high * factor:g}:{low * factor:g}"
                raise InputError("must be the lower bound, then the upper one", key=key, value=value, fix=fix)
            if not 0 < low < high < math.inf:
                fix = "give LOW:HIGH"
                rule = "must be a lower bound above 0, then a higher upper bound"
                raise InputError(rule, key=key, value=value, fix=fix)
            if not low <= one.described <= high:
                rule = f"must hold the described value, {one.described * factor:.6g}{unit}"
                raise InputError(rule, key=key, value=value, fix=f"give wider bounds{' in' * bool(unit)}{unit}")
            if high >= (most := _most(robot, one.kind, one.joint)):
                rule, fix = f"must end below {most * factor:.4g}{unit}", "give a lower upper bound"
                raise InputError(rule, key=key, value=value, fix=fix)
    return [Unknown(u.kind, u.joint, u.name, u.described, *ends[u.name]) if u.name in ends else u for u in found]


def with_unknowns(robot: Robot, frees: Sequence[Unknown], values: Array, *, checked: bool = True) -> Robot:
    """Return the robot with other values for its unknowns.

    Parameters
    ----------
    robot : Robot
    frees : sequence of Unknown
    values : ndarray, shape (n,)
        As `Unknown.described` counts them [SI].
    checked : bool
        Whether the description is checked as a whole, which takes a thousand times longer: a fit does so once.

    Returns
    -------
    Robot

    Raises
    ------
    InputError
        If the description does not take the values.
    """
    unit = robot.drive_unit
    assert unit is not None
    actuators: dict[int, dict[str, Any]] = {}
    changes: dict[str, Any] = {}
    materials = dict(robot.materials)
    for one, value in zip(frees, values.tolist(), strict=True):
        if one.joint is not None:
            actuators.setdefault(one.joint, {}).update(_actuator_part(robot, one, value))
        elif one.kind.endswith("modulus"):
            name = unit.hose if one.kind == "hose_modulus" else unit.matrix
            changed = _material_part(materials[name], unit.material_set, value)
            materials[name] = materials[name].model_copy(update=changed)
        elif one.kind != "diameter_ratio":
            changes[one.kind] = value
    ratio = next((v for u, v in zip(frees, values.tolist(), strict=True) if u.kind == "diameter_ratio"), None)
    ratio = ratio or unit.inner_diameter / unit.outer_diameter
    if {"outer_diameter", "diameter_ratio"} & {one.kind for one in frees}:
        changes["inner_diameter"] = ratio * changes.get("outer_diameter", unit.outer_diameter)
    groups = list(robot.joints)
    for j, update in actuators.items():
        actuator = groups[j].actuator
        assert actuator is not None
        groups[j] = groups[j].model_copy(update={"actuator": actuator.model_copy(update=update)})
    update = {"drive_unit": unit.model_copy(update=changes), "joints": tuple(groups), "materials": materials}
    fish = robot.model_copy(update=update)
    fish.__dict__.pop("hash", None)  # of the other values
    return parse(fish.document(), file=robot.file) if checked else fish


def _actuator_part(robot: Robot, one: Unknown, value: float) -> dict[str, Any]:
    """Say what an unknown changes in the actuator of its joint."""
    assert one.joint is not None
    actuator = robot.joints[one.joint].actuator
    assert actuator is not None
    if one.kind == "asymmetry":
        return {"asymmetry": 2 * (value - 1) / (value + 1)}
    if one.kind == "segment_length":
        return {"segment_length": tuple(value * length for length in actuator.segment_length)}
    return {one.kind: value}


def _material_part(material: Any, which: str, factor: float) -> dict[str, Any]:
    """Say what a factor of the modulus changes in a material, in the set of constants that is in use."""
    key = {"datasheet": "modulus_100", "fe": "modulus_fe", "tensile": "tensile"}[which]
    value = getattr(material, key)
    return {key: tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value}


def keys_of(robot: Robot, one: Unknown) -> tuple[str, ...]:
    """Return the keys of a robot's file that an unknown changes.

    Parameters
    ----------
    robot : Robot
    one : Unknown

    Returns
    -------
    tuple of str
        As in ``[sources]``: without indices.
    """
    unit = robot.drive_unit
    assert unit is not None
    if one.joint is not None:
        last = {"lever": "lever_m", "segment_length": "segment_length_m"}.get(one.kind, one.kind)
        return (f"joints.actuator.{last}",)
    if one.kind.endswith("modulus"):
        name = unit.hose if one.kind == "hose_modulus" else unit.matrix
        last = {"datasheet": "modulus_100_pa", "fe": "modulus_fe_pa", "tensile": "tensile_pa"}[unit.material_set]
        return (f"materials.{name}.{last}",)
    names = {
        "braid_angle": ("braid_angle_deg",),
        "outer_diameter": ("outer_diameter_m", "inner_diameter_m"),
        "diameter_ratio": ("inner_diameter_m",),
        "sleeve": ("sleeve_m",),
        "friction": ("friction",),
    }
    return tuple(f"drive_unit.{name}" for name in names[one.kind])
