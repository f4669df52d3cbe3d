"""Soft joints for the core: muscles, matrix and levers from the description, and each joint reduced to one section.

The equations are in core muscle.hpp and joint.hpp; docs/actuator.md derives them.
"""

import math
from dataclasses import dataclass
from typing import cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from hypertuna import _core
from hypertuna.actuation.silicone import Mooney
from hypertuna.arrays import Array, rounded_number
from hypertuna.description.robot import Robot, cached, joint_key, require
from hypertuna.description.schema.actuator import Actuator, DriveUnit, Material, MaterialSet
from hypertuna.description.schema.body import JointGroup
from hypertuna.errors import InputError, did_you_mean, shown

MATERIAL_SETS: tuple[MaterialSet, ...] = get_args(MaterialSet)

LUMEN_MIN = 0.05  # a stretched muscle locks when its lumen is this part of the lumen at rest
SMALL = 1e-5  # relative, rad or strain: step of finite differences


@dataclass(frozen=True)
class JointModel:
    """A soft joint reduced to one section, which relates bend, strain and pressures (core joint.hpp).

    Strains of the axis are relative to the filled, straight joint.
    """

    name: str  # name of the joint group
    row: Array  # numbers for the core, in the order of `joint_columns`
    fill: float  # Pa, pressure of both sides of the straight joint
    reach: float  # rad, bend at which a stretched muscle locks

    def __getitem__(self, column: str) -> float:
        """Return a number of the model by its name in core joint.hpp."""
        return float(self.row[_core.joint_columns().index(column)])

    @property
    def stiffness(self) -> float:
        """Bending stiffness of the straight joint without pressure [N m/rad]."""
        return -float(np.diff(self.at([-SMALL, SMALL], -self["rest"])["elastic"])[0]) / (2 * SMALL)

    def at(self, angle: ArrayLike, strain: ArrayLike = 0.0, pressure: ArrayLike = math.inf) -> dict[str, Array]:
        """Return loads and volumes at angles (n,) [rad], axial strains (n,) and pressures of the sides (n, 2) [Pa].

        Keys: energy [J], elastic [N m] (-dU/dangle), axial [J] (-dU/dstrain); with a column per side volume [m^3],
        slope [m^3/rad] (dV/dangle), gain [m^3] (dV/dstrain), friction [N m/Pa] and carried [Pa].
        """
        bend, strains = np.broadcast_arrays(np.atleast_1d(np.asarray(angle, dtype=np.float64)), strain)
        both = np.broadcast_to(np.asarray(pressure, dtype=np.float64), (len(bend), 2))
        return _core.joint_load(self.row, angle=bend.copy(), strain=strains.astype(np.float64), pressure=both.copy())

    def hold(self, angle: ArrayLike, lowest: float = -math.inf) -> dict[str, Array]:
        """Return strain (n,), pressure (n, 2) [Pa] and volume (n, 2) [m^3] that hold the joint at angles (n,) [rad].

        The pressures of the sides are equally far above and below the filling pressure. The lower one keeps its braid
        taut, and is at least `lowest` [Pa].
        """
        bend = np.atleast_1d(np.asarray(angle, dtype=np.float64))
        return _core.hold_joint(self.row, angle=bend, fill=self.fill, lowest=lowest)

    def balance(self, pressure: ArrayLike, moment: ArrayLike = 0.0) -> dict[str, Array]:
        """Return angle (n,) [rad], strain (n,), volume (n, 2) [m^3] under pressures (n, 2) [Pa] and moments [N m]."""
        pressures = np.atleast_2d(np.asarray(pressure, dtype=np.float64))
        moments = np.broadcast_to(np.asarray(moment, dtype=np.float64), len(pressures))
        return _core.balance_joint(self.row, pressure=pressures, moment=moments.copy())


def mooney(robot: Robot, material: str, material_set: str | None = None) -> Mooney:
    """Return the elastic constants of a silicone of ``[materials]``; the default set is the one in ``[drive_unit]``.

    ``"datasheet"``: C1 from the stress at 100 % strain, which is 3.5 (C1 + C2/2), with C2 = 0. ``"fe"``: C1 = E/6 with
    the Young's modulus of a finite-element model. ``"tensile"``: C1 and C2 as fitted to tensile tests. ``"mean"``:
    geometric means of the constants from tensile tests and from the data sheet.
    """
    name = material_set or drive_unit(robot).material_set
    if name not in MATERIAL_SETS:
        fix = did_you_mean(name, MATERIAL_SETS)
        raise InputError("must be a known material set", key="material", value=shown(name), fix=fix)
    if material not in robot.materials:
        fix = did_you_mean(material, robot.materials)
        raise InputError("is not a material of [materials]", file=robot.file or None, key=material, fix=fix)
    table: Material = robot.materials[material]
    from_data_sheet = Mooney(table.modulus_100 / 3.5, 0.0)  # Mooney.modulus_100, solved for C1
    if name == "datasheet":
        return from_data_sheet
    fix = f"give it for the material set {name}, or choose another set"
    if name == "fe":
        return Mooney(require(table.modulus_fe, f"materials.{material}.modulus_fe_pa", robot, fix) / 6, 0.0)
    tested = Mooney(*require(table.tensile, f"materials.{material}.tensile_pa", robot, fix))
    if name == "tensile":
        return tested
    return Mooney(math.sqrt(from_data_sheet.c1 * tested.c1), math.sqrt(from_data_sheet.c2 * tested.c2))


def drive_unit(robot: Robot) -> DriveUnit:
    """Return the table ``[drive_unit]`` of a robot that has muscles."""
    return require(robot.drive_unit, "drive_unit", robot)


def joint_group(robot: Robot, joint: str | int) -> tuple[JointGroup, Actuator]:
    """Return a joint group, given its name or index, and its table ``[joints.actuator]``; it must have muscles."""
    names = [group.name for group in robot.joints]
    if isinstance(joint, int) and not isinstance(joint, bool) and 0 <= joint < len(names):
        index = joint
    elif joint in names:
        index = names.index(joint)
    else:
        fix = did_you_mean(str(joint), names)
        raise InputError("is not a joint of the robot", file=robot.file or None, key=f"joint {joint}", fix=fix)
    group = robot.joints[index]
    if not group.drive.oil:
        rule, fix = "has no muscles: a servo turns it", "name a joint with the table joints.actuator"
        raise InputError(rule, file=robot.file or None, key=f"joint {group.name}", fix=fix)
    require(group.drive_units, f"{joint_key(robot, group.name)}.drive_units", robot)
    return group, require(group.actuator, f"{joint_key(robot, group.name)}.actuator", robot)


def muscle(robot: Robot, material: str | None = None, *, friction: bool = True) -> _core.DriveUnit:
    """Return the robot's drive unit for the core, for a material set, with or without friction of the braid."""
    unit = drive_unit(robot)
    hose, matrix = (mooney(robot, name, material) for name in (unit.hose, unit.matrix))
    return _core.DriveUnit(
        outer=unit.outer_diameter,
        inner=unit.inner_diameter,
        tan2=math.tan(unit.braid_angle) ** 2,
        sleeve=0.0,
        hose=hose,
        matrix=matrix,
        friction=unit.friction if friction else 0.0,
    )


def soft_joint(
    robot: Robot,
    joint: str | int,
    material: str | None = None,
    *,
    friction: bool = True,
    plain: bool = False,
    sections: Array | None = None,
) -> _core.SoftJoint:
    """Return the core's model of a joint, given its name or index, with or without friction of the braids.

    plain: as in the paper's equations, with full sections, and muscles that work up to their ends. sections: used in
    place of `joint_sections`.
    """
    group, actuator = joint_group(robot, joint)
    count = cast(int, group.drive_units)
    sections = joint_sections(robot, joint, plain=plain) if sections is None else sections
    unit = muscle(robot, material, friction=friction)
    return _core.SoftJoint(unit, units=count, lever=actuator.levers, sections=sections, axis=actuator.axis)


def joint_sections(robot: Robot, joint: str | int, *, plain: bool = False) -> Array:
    """Return for every section (n, 4): length, area, second moment of area, thickness of matrix around a hose [SI]."""
    group, actuator = joint_group(robot, joint)
    unit, count = drive_unit(robot), cast(int, group.drive_units)
    a, b, length = (np.array(x) for x in (actuator.semi_major, actuator.semi_minor, actuator.segment_length))
    area, second = np.pi * a * b, np.pi / 4 * a * b**3  # full ellipses
    if plain:
        return np.stack([length, area, actuator.stiffness_factor * second, 0 * area], axis=1)
    radius, free_length = unit.outer_diameter / 2, actuator.length
    hole_area = np.pi * radius**2
    area = area - 2 * count * hole_area
    second = second - count * hole_area * sum(lever**2 + radius**2 / 4 for lever in actuator.levers)
    sleeve = np.sqrt(radius**2 + area / (2 * count * np.pi)) - radius  # each hose widens an equal part of the section
    glued = 2 * unit.outer_diameter  # glued to the plates, one diameter of a hose neither swells nor shortens
    fix = "describe a longer joint, or thinner hoses"
    if min(area.min(), second.min()) <= 0 or free_length <= glued:
        rule = f"must have room for its hoses, and be longer than two diameters of a hose, {glued:g} m"
        key = f"{joint_key(robot, group.name)}.actuator.segment_length_m"
        raise InputError(rule, file=robot.file or None, key=key, value=f"{free_length:g} m in all", fix=fix)
    return np.stack([length * (1 - glued / free_length), area, actuator.stiffness_factor * second, sleeve], axis=1)


def joint_models(robot: Robot, material: str | None = None) -> tuple[JointModel, ...]:
    """Return every joint of a robot reduced to one section; a joint with a servo has a row of zeros.

    Under the highest pressure of one side, the section bends and shortens as much as all described sections together.
    """
    groups = range(len(robot.joints))
    return cached(robot, ("joint models", material), lambda: tuple(_model(robot, g, material) for g in groups))


def _model(robot: Robot, g: int, material: str | None) -> JointModel:
    """Return joint g reduced to one section; zeros if it has no muscles."""
    if not robot.joints[g].drive.oil:
        return JointModel(robot.joints[g].name, np.zeros(len(_core.joint_columns())), 0.0, math.inf)
    group, actuator = joint_group(robot, g)
    unit, hose = drive_unit(robot), muscle(robot, material)
    highest = require(group.pressure_max, f"{joint_key(robot, group.name)}.pressure_max_pa", robot)
    fill = group.line.fill_pressure if group.line is not None else 0.0
    section = soft_joint(robot, g, material, friction=False).one_section(left=highest, right=0.0)
    sizes = [rounded_number(value) for value in section]
    wall, matrix = (mooney(robot, name, material) for name in (unit.hose, unit.matrix))
    values = {
        **{"outer": unit.outer_diameter, "inner": unit.inner_diameter},
        **{"tan2": rounded_number(math.tan(unit.braid_angle) ** 2)},
        **{"hose_c1": wall.c1, "hose_c2": wall.c2, "matrix_c1": matrix.c1, "matrix_c2": matrix.c2},
        **{"friction": unit.friction, "units": cast(int, group.drive_units)},
        **dict(zip(("left", "right"), actuator.levers, strict=True)),
        **dict(zip(("length", "area", "second", "sleeve"), sizes, strict=True)),
    }
    row = np.array([values.get(name, 0.0) for name in _core.joint_columns()])  # no member on the axis yet
    # Kelvin-Voigt: viscosity is the relaxation time times the stiffness at rest
    model = JointModel(group.name, row, fill, 0.0)
    solid = {"elastic": matrix.modulus * sizes[2] / sizes[0], "axial": matrix.modulus * sizes[1] * sizes[0]}
    joint = {
        "elastic": model.stiffness,
        "axial": -float(np.diff(model.at(0.0, [-SMALL, SMALL])["axial"])[0]) / (2 * SMALL),
    }
    slow, fast = (robot.materials[name].relaxation for name in (unit.matrix, unit.hose))
    viscosity = {name: slow * solid[name] + fast * (joint[name] - solid[name]) for name in solid}
    values |= {"viscosity": viscosity["elastic"], "axial_viscosity": viscosity["axial"], "rest": 0.0}
    values |= dict(zip(("axis_stiffness", "axis_buckling"), actuator.axis, strict=True))
    row = np.array([values[name] for name in _core.joint_columns()])
    strain = float(JointModel(group.name, row, fill, 0.0).balance([fill, fill])["strain"][0])
    row[_core.joint_columns().index("rest")] = strain
    row.flags.writeable = False  # cached and shared
    stretch = 1 + strain
    stretch_left = hose.closing_stretch(LUMEN_MIN) - stretch
    return JointModel(group.name, row, fill, stretch_left * sizes[0] * math.sqrt(stretch) / max(actuator.levers))
