"""Unknowns of an actuator: geometry and material parameters that a bench may identify."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hypertuna.actuation.soft_joint import drive_unit, joint_group, mooney
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.actuator import NEUTRAL_BRAID
from hypertuna.errors import InputError, did_you_mean
from hypertuna.identification.names import split_names

# Unknowns and their default bounds, as factors on the described value; those in ABSOLUTE as values [rad or 1].
PER_JOINT = {
    "lever": (0.5, 2.0),  # in no drawing; inside the section
    "segment_length": (0.8, 1.25),  # links are measured, rigid end walls are not
    "stiffness_factor": (0.25, 4.0),  # strip, pipes and channels stiffen and weaken the matrix
    "asymmetry": (math.exp(-0.3), math.exp(0.3)),  # as the ratio of the two levers
}
SHARED = {
    "braid_angle": (math.radians(20), math.radians(50)),  # at 54.7 deg the pull is zero
    "outer_diameter": (0.5, 2.0),
    "diameter_ratio": (0.4, 0.9),  # inner over outer
    "hose_modulus": (0.5, 2.0),  # published constants of one silicone differ by 2.0 (docs/bench.md)
    "matrix_modulus": (0.5, 2.0),
    "sleeve": (0.5, 2.0),
    "friction": (0.01, 1.0),
}
# Factors that pull and stiffness are proportional to, in place of the unknown itself: name and formula.
FACTORS = {
    "braid_angle": ("braid_pull", "2 / tan^2(braid_angle) - 1, the pull at rest over pressure and section"),
    "diameter_ratio": ("hose_wall", "1 - diameter_ratio^2, the fraction of the hose's section that is wall"),
}
# Displayed unit, and displayed units per SI unit.
BORDER = {"m": ("mm", 1e3), "rad": ("deg", 180 / math.pi), "1": ("1", 1.0)}
INSIDE = 1 - 1e-9  # of an upper limit
STEP = 1e-5  # of a logarithm, for differences
ABSOLUTE = ("braid_angle", "diameter_ratio", "friction")
NAME = re.compile(r"(?P<kind>\w+)(?:\[(?P<joint>[^\]]*)\])?")


@dataclass(frozen=True)
class Unknown:
    """A positive unknown, fitted by a logarithm: its own, or that of a factor in pull or stiffness."""

    kind: str  # key of PER_JOINT or SHARED
    joint: int | None  # its joint group; None if all share it
    name: str  # lever[I]
    described: float  # [SI]; a modulus, a segment length: factor on the described one; asymmetry: left lever over right
    lower: float  # prior bounds, in the unit of `described`
    upper: float

    @property
    def unit(self) -> str:
        """SI unit, "1" for a number."""
        return {"lever": "m", "outer_diameter": "m", "sleeve": "m", "braid_angle": "rad"}.get(self.kind, "1")

    @property
    def factor(self) -> str:
        """Name in products of powers: that of the factor in FACTORS, or its own."""
        return self.name if self.kind not in FACTORS else FACTORS[self.kind][0]

    def log(self, value: float) -> float:
        """Return the logarithm of the factor at a value."""
        if self.kind == "braid_angle":
            return math.log(2 / math.tan(value) ** 2 - 1)
        return math.log(1 - value**2) if self.kind == "diameter_ratio" else math.log(value)

    def value(self, log: float) -> float:
        """Return the value of a logarithm of the factor."""
        if self.kind == "braid_angle":
            return math.atan(math.sqrt(2 / (1 + math.exp(log))))
        return math.sqrt(-math.expm1(log)) if self.kind == "diameter_ratio" else math.exp(log)

    @property
    def prior_sd(self) -> float:
        """Prior standard deviation of the logarithm: that of a uniform distribution between the bounds."""
        return abs(self.log(self.upper) - self.log(self.lower)) / math.sqrt(12)

    def relative(self, value: float) -> float:
        """Return the magnitude of d(log of the unknown) / d(log of its factor) at a value [SI]."""
        steps = (math.log(self.value(self.log(value) + side * STEP)) for side in (1, -1))
        return abs(next(steps) - next(steps)) / (2 * STEP)


def check_tables(robot: Robot, joints: Sequence[int]) -> None:
    """Check that a robot describes the actuators of some joints."""
    fix = "add it to the robot's file; docs/description.md lists its keys, robots/hypertuna.toml has an example"
    if robot.drive_unit is None:
        raise InputError("is needed to identify an actuator", file=robot.file, key="table [drive_unit]", fix=fix)
    for material in (robot.drive_unit.hose, robot.drive_unit.matrix):
        mooney(robot, material)  # checks the constants in use
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
    """Return the unknowns that a bench of some joints may identify.

    names: such as `lever` (of every joint measured) or `lever[I]`; all if left out. both_sides: joints bent both ways,
    the only ones with free asymmetry unless it is named. bounds: lower and upper by name [SI].
    """
    check_tables(robot, joints)
    known = [
        _make(robot, kind, j) for kind in PER_JOINT for j in joints if kind != "asymmetry" or j in both_sides or names
    ]
    sleeve = drive_unit(robot).sleeve > 0
    known += [_make(robot, kind, None) for kind in SHARED if kind != "sleeve" or sleeve]
    if names is not None:
        known = _named(known, split_names(names) if isinstance(names, str) else list(names))
    return tuple(_bounded(robot, known, bounds or {}))


def _make(robot: Robot, kind: str, joint: int | None) -> Unknown:
    """Return an unknown with its default bounds."""
    value = _described(robot, kind, joint)
    low, high = PER_JOINT[kind] if joint is not None else SHARED[kind]
    factor = 1.0 if kind in ABSOLUTE or kind == "asymmetry" else value
    name = kind if joint is None else f"{kind}[{robot.joints[joint].name}]"
    value = max(value, low) if kind == "friction" else value
    lower, upper = min(low * factor, value), max(high * factor, value)
    return Unknown(kind, joint, name, value, lower, min(upper, INSIDE * _upper_limit(robot, kind, joint)))


def _upper_limit(robot: Robot, kind: str, joint: int | None) -> float:
    """Return the limit below which an unknown must stay."""
    if kind == "lever" and joint is not None:
        return min(joint_group(robot, joint)[1].semi_minor)
    return {"braid_angle": NEUTRAL_BRAID, "diameter_ratio": 1.0}.get(kind, math.inf)


def _described(robot: Robot, kind: str, joint: int | None) -> float:
    """Return the value of an unknown in the description."""
    if joint is not None:
        actuator = joint_group(robot, joint)[1]
        if kind == "asymmetry":
            return (2 + actuator.asymmetry) / (2 - actuator.asymmetry)
        return 1.0 if kind == "segment_length" else float(getattr(actuator, kind))
    unit = drive_unit(robot)
    if kind == "diameter_ratio":
        return unit.inner_diameter / unit.outer_diameter
    return 1.0 if kind.endswith("modulus") else float(getattr(unit, kind))


def _named(known: Sequence[Unknown], names: Sequence[str]) -> list[Unknown]:
    """Return unknowns by name; without brackets a name covers every joint."""
    chosen: list[Unknown] = []
    for name in names:
        matching = _matching(known, name)
        if any(one in chosen for one in matching):
            raise InputError(
                "must be listed only once", key=f"free {name}", value="named twice", fix="remove it from one"
            )
        chosen += matching
    if not chosen:
        raise InputError("must name at least one unknown", key="free", fix="leave it out for all")
    return chosen


def _matching(known: Sequence[Unknown], name: str) -> list[Unknown]:
    """Return the unknowns that a name covers."""
    matching = [one for one in known if name in (one.name, one.kind)]
    if not matching:
        match = NAME.fullmatch(name)
        near = [one.name for one in known if match and one.kind == match["kind"]]
        fix = did_you_mean(name, near or list(dict.fromkeys(one.kind for one in known)))
        raise InputError("must be an unknown of this bench and robot", key=f"free {name}", fix=fix)
    return matching


def _bounded(robot: Robot, known: Sequence[Unknown], bounds: Mapping[str, tuple[float, float]]) -> list[Unknown]:
    """Return unknowns with the given bounds [SI]."""
    ends: dict[str, tuple[float, float]] = {}
    for name, pair in bounds.items():
        for one in _matching(known, name):
            _check_bounds(robot, one, *pair, f"bounds {name}")
            ends[one.name] = pair
    return [Unknown(u.kind, u.joint, u.name, u.described, *ends[u.name]) if u.name in ends else u for u in known]


def _check_bounds(robot: Robot, one: Unknown, low: float, high: float, key: str) -> None:
    """Check bounds of an unknown: positive, in order, around the described value, below its limit."""
    unit, factor = BORDER[one.unit]
    unit = "" if unit == "1" else f" {unit}"
    limit = _upper_limit(robot, one.kind, one.joint)
    if 0 < high < low < math.inf:
        rule = "must be the lower bound, then the upper one"
        fix = f"exchange the two, {high * factor:g}:{low * factor:g}"
    elif not 0 < low < high < math.inf:
        rule, fix = "must be a lower bound above 0, then a higher upper bound", "give LOW:HIGH"
    elif not low <= one.described <= high:
        rule = f"must include the described value, {one.described * factor:.6g}{unit}"
        fix = f"give wider bounds{' in' * bool(unit)}{unit}"
    elif high >= limit:
        rule, fix = f"must end below {limit * factor:.4g}{unit}", "give a lower upper bound"
    else:
        return
    raise InputError(rule, key=key, value=f"{low * factor:g} to {high * factor:g}{unit}", fix=fix)


def with_unknowns(robot: Robot, frees: Sequence[Unknown], values: Array, *, checked: bool = True) -> Robot:
    """Return the robot with other values (n,) of its unknowns, as `Unknown.described` counts them [SI].

    checked: validate the whole description, which takes a thousand times longer.
    """
    unit = drive_unit(robot)
    actuators: dict[int, dict[str, Any]] = {}
    changes: dict[str, Any] = {}
    materials = dict(robot.materials)
    for one, value in zip(frees, values.tolist(), strict=True):
        if one.joint is not None:
            actuators.setdefault(one.joint, {}).update(_actuator_part(robot, one.joint, one.kind, value))
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
        actuator = joint_group(robot, j)[1].model_copy(update=update)
        groups[j] = groups[j].model_copy(update={"actuator": actuator})
    update = {"drive_unit": unit.model_copy(update=changes), "joints": tuple(groups), "materials": materials}
    changed_robot = robot.model_copy(update=update)
    changed_robot.__dict__.pop("hash", None)  # of the described values
    return parse(changed_robot.document(), file=robot.file) if checked else changed_robot


def _actuator_part(robot: Robot, joint: int, kind: str, value: float) -> dict[str, Any]:
    """Return the fields that an unknown changes in the actuator of its joint."""
    if kind == "asymmetry":
        return {"asymmetry": 2 * (value - 1) / (value + 1)}
    if kind == "segment_length":
        return {"segment_length": tuple(value * length for length in joint_group(robot, joint)[1].segment_length)}
    return {kind: value}


def _material_part(material: Any, which: str, factor: float) -> dict[str, Any]:
    """Return the field that a factor of the modulus changes in a material, in the set of constants in use."""
    key = {"datasheet": "modulus_100", "fe": "modulus_fe", "tensile": "tensile"}[which]
    value = getattr(material, key)
    return {key: tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value}


def keys_of(robot: Robot, one: Unknown) -> tuple[str, ...]:
    """Return the keys of a robot's file that an unknown changes, without indices, as in [sources]."""
    unit = drive_unit(robot)
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
