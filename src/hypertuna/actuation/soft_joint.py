"""Soft joint: muscles, matrix and levers of a description, as the core takes them, and as the twin's table.

The equations stand in core muscle.hpp, joint.hpp and joint_table.hpp; docs/actuator.md derives them.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import cast, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hypertuna import _core
from hypertuna.actuation.silicone import Mooney
from hypertuna.description.robot import Robot
from hypertuna.description.schema.actuator import Actuator, DriveUnit, Material, MaterialSet, Reduced
from hypertuna.description.schema.body import JointGroup
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import WHOLE

__all__ = [
    "COLUMNS",
    "LUMEN_LEFT",
    "MATERIAL_SETS",
    "JointTable",
    "drive_unit",
    "joint_group",
    "joint_tables",
    "mooney",
    "muscle",
    "soft_joint",
]

Array = NDArray[np.float64]

MATERIAL_SETS: tuple[MaterialSet, ...] = get_args(MaterialSet)

# Columns of a joint's table, as core joint_table.hpp lays out a point; the pairs are of the sides, left and right.
COLUMNS = (
    *("energy", "energy_slope", "volume_left", "volume_right", "volume_slope_left", "volume_slope_right"),
    *("friction_left", "friction_right", "carried_left", "carried_right"),
)
LUMEN_LEFT = 0.05  # of the lumen at rest, on the stretched side, where a table ends and the joint counts as locked
HIGHEST = 20e6  # Pa, where a table ends if the joint locks nowhere below
MOST_TABLES = 256  # sets of tables that are kept, 40 kB each
STOP = 20.0  # stiffness beyond a table's end, in units of the stiffness at rest

_tables: dict[tuple[Hashable, ...], tuple[JointTable, ...]] = {}  # by all that they depend on


@dataclass(frozen=True)
class JointTable:
    """A soft joint as one angle: energy, volumes and friction over it (core joint_table.hpp)."""

    name: str  # Of the joint group
    first: float  # Angle of the first point, and from point to point [rad]
    step: float
    # (points, 10) Columns `COLUMNS`: energy [J] and its slope [N m], volume in the muscles of each side [m^3] and its
    # slope [m^3/rad], friction per contact pressure [N m/Pa], pressure that the walls carry [Pa]
    points: Array
    viscosity: float  # Viscous moment per rate [N m s/rad]
    stop: float  # Stiffness beyond the ends, where the joint locks [N m/rad]

    @property
    def angle(self) -> Array:
        """Angle of every point [rad], shape (points,)."""
        return self.first + self.step * np.arange(len(self.points), dtype=np.float64)

    def at(self, angle: ArrayLike) -> dict[str, Array]:
        """Look up what the twin sees between the points.

        `angle` (n,) [rad]; returns [N m], [J], [m^3], [m^3/rad], [N m/Pa], [Pa].
        """
        where = np.atleast_1d(np.asarray(angle, dtype=np.float64))
        return _core.joint_load(self.points, first=self.first, step=self.step, stop=self.stop, angle=where)


def mooney(robot: Robot, material: str, material_set: str | None = None) -> Mooney:
    """Choose the elastic constants of a silicone: `material` [materials], `material_set` [drive_unit]."""
    name = material_set or drive_unit(robot).material_set
    if name not in MATERIAL_SETS:
        fix = did_you_mean(name, MATERIAL_SETS)
        raise InputError("must be a set that exists", key="material", value=shown(name), fix=fix)
    if material not in robot.materials:
        fix = did_you_mean(material, robot.materials)
        raise InputError("is not a material of [materials]", file=robot.file or None, key=material, fix=fix)
    solid: Material = robot.materials[material]
    if name == "datasheet":
        return Mooney(solid.modulus_100 / 3.5, 0.0)  # Mooney.modulus_100, solved for C1
    key = {"fe": "modulus_fe_pa", "tensile": "tensile_pa"}[name]
    value = solid.modulus_fe if name == "fe" else solid.tensile
    if value is None:
        raise InputError(
            f"is needed by the material set {name}",
            file=robot.file or None,
            key=f"materials.{material}.{key}",
            fix="give it, or choose another set",
        )
    if name == "fe":
        return Mooney(cast(float, value) / 6, 0.0)
    return Mooney(*cast(tuple[float, float], value))


def drive_unit(robot: Robot) -> DriveUnit:
    """Return the table of the muscle, or say that there is none."""
    if robot.drive_unit is None:
        fix = "add it, docs/description.md lists its keys"
        raise InputError("is missing: soft joints need it", file=robot.file or None, key="[drive_unit]", fix=fix)
    return robot.drive_unit


def joint_group(robot: Robot, joint: str | int) -> tuple[JointGroup, Actuator]:
    """Find a joint group that is a soft joint: returns [joints.actuator]."""
    names = [group.name for group in robot.joints]
    if isinstance(joint, int) and not isinstance(joint, bool) and 0 <= joint < len(names):
        index = joint
    elif joint in names:
        index = names.index(joint)
    else:
        fix = did_you_mean(str(joint), names)
        raise InputError("is not a joint of the robot", file=robot.file or None, key=f"joint {joint}", fix=fix)
    group, file = robot.joints[index], robot.file or None
    if group.actuator is None:
        fix = "add it, docs/description.md lists its keys"
        raise InputError(
            "is missing: soft joints need it", file=file, key=f"[joints.actuator] of {names[index]}", fix=fix
        )
    if group.drive_units is None:
        fix = "give the number of muscles on each side"
        raise InputError("is missing: soft joints need it", file=file, key=f"joints[{index}].drive_units", fix=fix)
    return group, group.actuator


def muscle(robot: Robot, material: str | None = None, *, friction: bool = True) -> _core.DriveUnit:
    """Make a drive unit for the core."""
    unit = drive_unit(robot)
    hose, matrix = (mooney(robot, name, material) for name in (unit.hose, unit.matrix))
    return _core.DriveUnit(
        outer=unit.outer_diameter,
        inner=unit.inner_diameter,
        tan2=math.tan(unit.braid_angle) ** 2,
        sleeve=unit.sleeve,
        hose=hose,
        matrix=matrix,
        friction=unit.friction if friction else 0.0,
    )


def soft_joint(
    robot: Robot, joint: str | int, material: str | None = None, *, friction: bool = True
) -> _core.SoftJoint:
    """Make a joint for the core."""
    group, actuator = joint_group(robot, joint)
    matrix = mooney(robot, drive_unit(robot).matrix, material)
    half = 0.5 * actuator.asymmetry
    inertia = np.pi / 4 * np.array(actuator.semi_major) * np.array(actuator.semi_minor) ** 3  # of an ellipse
    return _core.SoftJoint(
        muscle(robot, material, friction=friction),
        units=cast(int, group.drive_units),
        lever=(actuator.lever * (1 + half), actuator.lever * (1 - half)),
        length=list(actuator.segment_length),
        stiffness=(actuator.stiffness_factor * matrix.modulus * inertia).tolist(),
    )


def joint_tables(robot: Robot, material: str | None = None, *, points: int = 257) -> tuple[JointTable, ...]:
    """Tabulate every joint of a robot over its angle.

    The segments share an angle as they do where the pressure of one side alone holds the joint there, so that a table
    bends under such a pressure exactly as the segments do. It reaches to the angle at which the lumen of a stretched
    muscle has a twentieth of its volume at rest left; there the joint locks.

    A joint with a table ``[joints.reduced]`` has moment and volume from there, and locks at that table's ends; friction
    and viscosity, which it does not know, are those of its muscles as above.
    """
    points = WHOLE.check(points, "points", "leave it out for 257")
    if points < 3 or points % 2 == 0:
        raise InputError("must be odd, and 3 at least", key="points", value=str(points), fix="leave it out for 257")
    unit = drive_unit(robot)
    hose, matrix = robot.materials[unit.hose], robot.materials[unit.matrix]
    joints = tuple((group.name, group.drive_units, group.actuator, group.reduced) for group in robot.joints)
    key = (unit, hose, matrix, joints, material, points)
    found = _tables.get(key)  # looked up once: another thread may clear them in between
    if found is None:
        found = tuple(_table(robot, g, material, points) for g in range(len(robot.joints)))
        if len(_tables) >= MOST_TABLES:
            _tables.clear()
        _tables[key] = found
    return found


def _table(robot: Robot, g: int, material: str | None, points: int) -> JointTable:
    """Tabulate one joint."""
    unit, joint = drive_unit(robot), soft_joint(robot, g, material)
    reach = min(joint.reach(side, left=LUMEN_LEFT, highest=HIGHEST) for side in (0, 1))
    table, reduced = joint.table(reach=reach, points=points), robot.joints[g].reduced
    if reduced is not None:
        table, reach = _reduced(robot, g, reduced, table, reach), reduced.angle[-1]
    table.flags.writeable = False  # it is kept, and handed out again
    matrix, walls = joint.stiffness()
    # Kelvin-Voigt: relaxation time times stiffness, as at rest
    viscosity = robot.materials[unit.matrix].relaxation * matrix + robot.materials[unit.hose].relaxation * walls
    step = 2 * reach / (points - 1)
    return JointTable(robot.joints[g].name, -reach, step, table, viscosity, STOP * (matrix + walls))


def _reduced(robot: Robot, g: int, reduced: Reduced, muscles: Array, reach: float) -> Array:
    """Tabulate a reduced joint up to its own ends, with friction and carried pressure of its muscles up to `reach`.

    Splines through moment and volume; the energy is the integral of that spline, and the core takes moments from energy
    and volumes alone, so that none of it is lost.
    """
    from scipy.interpolate import CubicSpline  # here, because it takes longer to import than a bend takes

    key = f"joints.{robot.joints[g].name}.reduced"
    if robot.joints[g].actuator.asymmetry != 0:  # type: ignore[union-attr]  # it has one, its muscles are tabulated
        rule, fix = "is for a joint whose sides are alike", "leave out actuator.asymmetry, or the table"
        raise InputError(rule, file=robot.file or None, key=key, fix=fix)
    angle = np.linspace(-reduced.angle[-1], reduced.angle[-1], len(muscles))
    elastic, volume = (CubicSpline(reduced.angle, values) for values in (reduced.elastic, reduced.volume))
    energy = elastic.antiderivative()
    held, slope = volume(angle), volume(angle, 1)
    falls = np.flatnonzero(slope <= 0)
    if len(falls):
        rule = "must rise smoothly: a cubic spline through it is not to fall between its angles"
        value = f"one that falls at {math.degrees(angle[falls[0]]):.3g} deg"
        fix = "give more angles there, or correct a volume"
        raise InputError(rule, file=robot.file or None, key=f"{key}.volume_m3", value=value, fix=fix)
    known = np.linspace(-reach, reach, len(muscles))
    first = COLUMNS.index("friction_left")
    rest = [np.interp(angle, known, column) for column in muscles[:, first:].T]  # beyond them as at their ends
    work = energy(angle) - energy(0.0)
    return np.stack([work, elastic(angle), held, held[::-1], slope, -slope[::-1], *rest], axis=1)
