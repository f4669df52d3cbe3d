"""Unknowns of an actuator: geometry and material parameters that a bench may identify."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from hypertuna.actuation.soft_joint import drive_unit, joint_group, mooney
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.actuator import NEUTRAL_BRAID
from hypertuna.errors import InputError, did_you_mean
from hypertuna.identification.names import split_names


class UnknownKind(NamedTuple):
    """A kind of unknown: its default bounds, its keys in the robot's file, and its unit."""

    low: float  # default lower bound, as a factor on the described value
    high: float  # default upper bound
    keys: tuple[str, ...] = ()  # keys in the robot's file, in a joint's actuator or in the drive unit
    unit: str = "1"  # SI unit, "1" for a number
    scaled: bool = True  # False: the default bounds are values, not factors
    counted: str = ""  # meaning of a number without unit
    optional: bool = False  # fitted only if named


# Kinds of unknowns of each joint, by name.
PER_JOINT = {
    "lever": UnknownKind(0.5, 2.0, ("lever_m",), "m"),  # no drawing shows it; it ends inside the section
    # the length of links is measured, but not that of rigid end walls
    "segment_length": UnknownKind(0.8, 1.25, ("segment_length_m",), counted="x described"),
    "stiffness_factor": UnknownKind(0.25, 4.0, ("stiffness_factor",)),  # a strip and pipes stiffen, channels weaken
    # from a film that buckles at once, to stiff pipes
    "axis_buckling": UnknownKind(1.0, 300.0, ("axis_stiffness_n", "axis_buckling_n"), "N", scaled=False, optional=True),
    # ratio of the two levers
    "asymmetry": UnknownKind(math.exp(-0.3), math.exp(0.3), ("asymmetry",), scaled=False, counted="left / right"),
}
# Kinds of unknowns that all joints share.
SHARED = {
    # at 54.7 deg the pull is zero
    "braid_angle": UnknownKind(math.radians(20), math.radians(50), ("braid_angle_deg",), "rad", scaled=False),
    "outer_diameter": UnknownKind(0.5, 2.0, ("outer_diameter_m", "inner_diameter_m"), "m"),
    "diameter_ratio": UnknownKind(0.4, 0.9, ("inner_diameter_m",), scaled=False, counted="inner / outer"),
    # published constants of one silicone differ by 2.0 (docs/bench.md)
    "hose_modulus": UnknownKind(0.5, 2.0, counted="x described"),
    "matrix_modulus": UnknownKind(0.5, 2.0, counted="x described"),
    "friction": UnknownKind(0.01, 1.0, ("friction",), scaled=False),
}
KINDS = PER_JOINT | SHARED
# Factors to which pull or stiffness is proportional (name, formula); their logarithm is fitted, not the unknown's.
FACTORS = {
    "braid_angle": ("braid_pull", "2 / tan^2(braid_angle) - 1, the pull at rest over pressure and section"),
    "diameter_ratio": ("hose_wall", "1 - diameter_ratio^2, the fraction of the hose's section that is wall"),
}
# Displayed unit, and displayed units per SI unit.
BORDER = {"N": ("N", 1.0), "m": ("mm", 1e3), "rad": ("deg", 180 / math.pi), "1": ("1", 1.0)}
# Elastic constants of a material, by the material set in use.
MODULI = {
    "datasheet": ("modulus_100",),
    "fe": ("modulus_fe",),
    "tensile": ("tensile",),
    "mean": ("modulus_100", "tensile"),
}
INSIDE = 1 - 1e-9  # default upper bounds end at this part of an upper limit
FILM = 5e3  # N, tensile stiffness on the axis if none is described: that of a bending sensor's film
STEP = 1e-5  # step of a logarithm for differences


@dataclass(frozen=True)
class Unknown:
    """A positive unknown; the fit varies the logarithm of the unknown, or of its factor in FACTORS."""

    kind: str  # key of KINDS
    joint: int | None  # joint group; None if all joints share the unknown
    name: str  # such as lever[I]
    described: float  # value [SI]; modulus, segment length: factor on the described one; asymmetry: left lever / right
    lower: float  # prior bounds, in the unit of `described`
    upper: float

    @property
    def unit(self) -> str:
        """SI unit, "1" for a number without one."""
        return KINDS[self.kind].unit

    @property
    def factor(self) -> str:
        """Name in products of powers: the name of the factor in FACTORS, or of the unknown itself."""
        return FACTORS.get(self.kind, (self.name, ""))[0]

    def log(self, value: float) -> float:
        """Return the logarithm that the fit varies, at a value of the unknown [SI]."""
        if self.kind == "braid_angle":
            return math.log(2 / math.tan(value) ** 2 - 1)
        return math.log(1 - value**2) if self.kind == "diameter_ratio" else math.log(value)

    def value(self, log: float) -> float:
        """Return the value of the unknown [SI], given the logarithm that the fit varies."""
        if self.kind == "braid_angle":
            return math.atan(math.sqrt(2 / (1 + math.exp(log))))
        return math.sqrt(-math.expm1(log)) if self.kind == "diameter_ratio" else math.exp(log)

    @property
    def prior_sd(self) -> float:
        """Prior standard deviation of the logarithm: that of a uniform distribution between the bounds."""
        return abs(self.log(self.upper) - self.log(self.lower)) / math.sqrt(12)

    def relative(self, value: float) -> float:
        """Return the magnitude of the derivative of log(unknown) with respect to the fitted logarithm [1]."""
        steps = (math.log(self.value(self.log(value) + side * STEP)) for side in (1, -1))
        return abs(next(steps) - next(steps)) / (2 * STEP)


def unknowns(
    robot: Robot,
    joints: Sequence[int],
    *,
    names: Sequence[str] | str | None = None,
    both_sides: Sequence[int] = (),
    bounds: Mapping[str, tuple[float, float]] | None = None,
    optional: bool = False,
) -> tuple[Unknown, ...]:
    """Return the unknowns that a bench may identify, for the joints that it measures.

    names: such as `lever` (of every joint measured) or `lever[I]`; all if left out. both_sides: joints bent both ways;
    without names, the asymmetry is unknown in these joints only. bounds: lower and upper by name [SI]. optional:
    include the optional kinds.
    """
    unit = drive_unit(robot)
    for material in (unit.hose, unit.matrix):
        mooney(robot, material)  # checks the constants in use
    free_asymmetry, optional = joints if names else both_sides, optional or bool(names)
    all_unknowns = [
        _make(robot, name, j)
        for name, kind in PER_JOINT.items()
        for j in joints
        if (name != "asymmetry" or j in free_asymmetry) and (optional or not kind.optional)
    ]
    all_unknowns += [_make(robot, kind, None) for kind in SHARED]
    if names is not None:
        chosen: list[Unknown] = []
        for name in split_names(names) if isinstance(names, str) else names:
            matching = _matching(all_unknowns, name)
            if any(u in chosen for u in matching):
                rule, fix = "must be listed only once", "remove it from one"
                raise InputError(rule, key=f"free {name}", value="named twice", fix=fix)
            chosen += matching
        if not chosen:
            raise InputError("must name at least one unknown", key="free", fix="leave it out for all")
        all_unknowns = chosen
    bounds_by_name: dict[str, tuple[float, float]] = {}
    for name, (low, high) in (bounds or {}).items():
        for u in _matching(all_unknowns, name):
            _check_bounds(robot, u, low, high, f"bounds {name}")
            bounds_by_name[u.name] = low, high
    bounded = ((u, *bounds_by_name.get(u.name, (u.lower, u.upper))) for u in all_unknowns)
    return tuple(replace(u, lower=low, upper=high) for u, low, high in bounded)


def _make(robot: Robot, kind: str, joint: int | None) -> Unknown:
    """Return an unknown with its default bounds."""
    value = _described(robot, kind, joint)
    low, high = KINDS[kind][:2]
    factor = value if KINDS[kind].scaled else 1.0
    name = kind if joint is None else f"{kind}[{robot.joints[joint].name}]"
    value = max(value, low) if kind in ("friction", "axis_buckling") else value
    lower, upper = min(low * factor, value), max(high * factor, value)
    return Unknown(kind, joint, name, value, lower, min(upper, INSIDE * _upper_limit(robot, kind, joint)))


def _upper_limit(robot: Robot, kind: str, joint: int | None) -> float:
    """Return the value [SI] below which an unknown must stay."""
    if kind == "lever" and joint is not None:
        return min(joint_group(robot, joint)[1].semi_minor)
    return {"braid_angle": NEUTRAL_BRAID, "diameter_ratio": 1.0}.get(kind, math.inf)


def _described(robot: Robot, kind: str, joint: int | None) -> float:
    """Return the value [SI] of an unknown in the robot's description."""
    unit = drive_unit(robot)
    part: Any = unit if joint is None else joint_group(robot, joint)[1]
    if kind == "axis_buckling":  # a buckling force of None: the axis never buckles
        return 0.0 if not part.axis_stiffness else float(part.axis_buckling or KINDS[kind].high)
    if kind == "asymmetry":
        return float((2 + part.asymmetry) / (2 - part.asymmetry))
    if kind == "diameter_ratio":
        return unit.inner_diameter / unit.outer_diameter
    return 1.0 if KINDS[kind].counted == "x described" else float(getattr(part, kind))


def _matching(known: Sequence[Unknown], name: str) -> list[Unknown]:
    """Return the unknowns that a name stands for: all of a kind, or the one of a joint."""
    matching = [unknown for unknown in known if name in (unknown.name, unknown.kind)]
    if not matching:
        same_kind = [unknown.name for unknown in known if unknown.kind == name.partition("[")[0]]
        fix = did_you_mean(name, same_kind or list(dict.fromkeys(unknown.kind for unknown in known)))
        raise InputError("must be an unknown of this bench and robot", key=f"free {name}", fix=fix)
    return matching


def _check_bounds(robot: Robot, unknown: Unknown, low: float, high: float, key: str) -> None:
    """Check the bounds of an unknown: positive, in order, around the described value, below the upper limit."""
    unit, factor = BORDER[unknown.unit]
    unit = "" if unit == "1" else f" {unit}"
    limit = _upper_limit(robot, unknown.kind, unknown.joint)
    if 0 < high < low < math.inf:
        rule = "must be the lower bound, then the upper one"
        fix = f"exchange the two, {high * factor:g}:{low * factor:g}"
    elif not 0 < low < high < math.inf:
        rule, fix = "must be a lower bound above 0, then a higher upper bound", "give LOW:HIGH"
    elif not low <= unknown.described <= high:
        rule = f"must include the described value, {unknown.described * factor:.6g}{unit}"
        fix = f"give wider bounds{' in' * bool(unit)}{unit}"
    elif high >= limit:
        rule, fix = f"must end below {limit * factor:.4g}{unit}", "give a lower upper bound"
    else:
        return
    raise InputError(rule, key=key, value=f"{low * factor:g} to {high * factor:g}{unit}", fix=fix)


def with_unknowns(robot: Robot, frees: Sequence[Unknown], values: Array, *, checked: bool = True) -> Robot:
    """Return the robot with new values (n,) of unknowns, in the units of `Unknown.described`.

    checked: validate the whole description, which takes a thousand times longer.
    """
    unit = drive_unit(robot)
    shared: dict[str, Any] = {}
    by_joint: dict[int, dict[str, Any]] = {}
    for unknown, value in zip(frees, values.tolist(), strict=True):
        (shared if unknown.joint is None else by_joint.setdefault(unknown.joint, {}))[unknown.kind] = value
    materials, groups = dict(robot.materials), list(robot.joints)
    for part in ("hose", "matrix"):
        if (factor := shared.pop(f"{part}_modulus", None)) is not None:
            name = getattr(unit, part)
            constants = {key: getattr(materials[name], key) for key in MODULI[unit.material_set]}
            scaled = {
                key: tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value
                for key, value in constants.items()
            }
            materials[name] = materials[name].model_copy(update=scaled)
    if {"outer_diameter", "diameter_ratio"} & shared.keys():
        ratio = shared.pop("diameter_ratio", None) or unit.inner_diameter / unit.outer_diameter
        shared["inner_diameter"] = ratio * shared.get("outer_diameter", unit.outer_diameter)
    for j, changes in by_joint.items():
        actuator = joint_group(robot, j)[1]
        if (ratio := changes.get("asymmetry")) is not None:
            changes["asymmetry"] = 2 * (ratio - 1) / (ratio + 1)
        if "axis_buckling" in changes:
            changes["axis_stiffness"] = actuator.axis_stiffness or FILM
        if (factor := changes.get("segment_length")) is not None:
            changes["segment_length"] = tuple(factor * length for length in actuator.segment_length)
        groups[j] = groups[j].model_copy(update={"actuator": actuator.model_copy(update=changes)})
    update = {"drive_unit": unit.model_copy(update=shared), "joints": tuple(groups), "materials": materials}
    changed_robot = robot.model_copy(update=update)
    changed_robot.__dict__.pop("hash", None)  # the cached hash of the described values
    return parse(changed_robot.document(), file=robot.file) if checked else changed_robot


def keys_of(robot: Robot, one: Unknown) -> tuple[str, ...]:
    """Return the keys of the robot's file that an unknown changes, without indices, as [sources] lists them."""
    unit = drive_unit(robot)
    if one.kind.endswith("modulus"):
        name = unit.hose if one.kind == "hose_modulus" else unit.matrix
        return tuple(f"materials.{name}.{key}_pa" for key in MODULI[unit.material_set])
    table = "drive_unit" if one.joint is None else "joints.actuator"
    return tuple(f"{table}.{key}" for key in KINDS[one.kind].keys)


def sourced(robot: Robot, described: Robot, texts: Mapping[str, str]) -> Robot:
    """Return the robot with new sources for changed keys; the source before the change follows after "Before:"."""
    document = robot.document()
    sources = document.setdefault("sources", {})
    without_sources = described.model_copy(update={"sources": {}})
    sourced_keys = {re.sub(r"\[\d+\]", "", key) for key in without_sources.unsourced()}
    for key, text in texts.items():
        old_source = described.source(key) if key in sourced_keys else None
        sources[key] = f"{text}. Before: {old_source}" if old_source else text
    return parse(document, file=described.file)
