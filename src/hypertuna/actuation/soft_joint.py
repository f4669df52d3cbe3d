"""Soft joint: muscles, matrix and levers of the description for the core, and the twin's table over the angle.

The equations are in core muscle.hpp, joint.hpp and joint_table.hpp; docs/actuator.md derives them.
"""

import math
from dataclasses import dataclass
from typing import cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from hypertuna import _core
from hypertuna.actuation.silicone import Mooney
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, cached, require
from hypertuna.description.schema.actuator import Actuator, DriveUnit, Material, MaterialSet, Reduced
from hypertuna.description.schema.body import JointGroup
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.ranges import WHOLE

MATERIAL_SETS: tuple[MaterialSet, ...] = get_args(MaterialSet)

# Columns of a joint's table, as core joint_table.hpp lays out a point; the pairs are of the sides, left and right.
COLUMNS = (
    *("energy", "energy_slope", "volume_left", "volume_right", "volume_slope_left", "volume_slope_right"),
    *("friction_left", "friction_right", "carried_left", "carried_right"),
)
LUMEN_MIN = 0.05  # lumen of the stretched side over that at rest at which the joint locks and a table ends
PRESSURE_MAX = 20e6  # Pa, at which a table ends if the joint does not lock below
STOP = 20.0  # stiffness beyond a table's end over that at rest


@dataclass(frozen=True)
class JointTable:
    """A soft joint as one angle: energy, volumes and friction over it (core joint_table.hpp)."""

    name: str  # of the joint group
    first: float  # rad, angle of the first point
    step: float  # rad, from point to point
    # (points, 10), of COLUMNS: energy [J] and its slope [N m], volume of each side [m^3] and its slope [m^3/rad],
    # friction per contact pressure [N m/Pa], pressure that the walls carry [Pa].
    points: Array
    viscosity: float  # N m s/rad
    stop: float  # N m/rad, stiffness beyond the ends, where the joint locks

    @property
    def angle(self) -> Array:
        """Angle of every point [rad], shape (points,)."""
        return self.first + self.step * np.arange(len(self.points), dtype=np.float64)

    def at(self, angle: ArrayLike) -> dict[str, Array]:
        """Interpolate at angles (n,) [rad].

        elastic [N m] (-dU/dangle), energy [J], and with a column per side volume [m^3], slope [m^3/rad], friction
        [N m/Pa] and carried [Pa].
        """
        where = np.atleast_1d(np.asarray(angle, dtype=np.float64))
        return _core.joint_load(self.points, first=self.first, step=self.step, stop=self.stop, angle=where)


def mooney(robot: Robot, material: str, material_set: str | None = None) -> Mooney:
    """Return the elastic constants of a silicone of ``[materials]``, by default of the set that ``[drive_unit]`` names.

    ``"datasheet"``: C1 from the stress at 100 % strain, which is 3.5 (C1 + C2/2), with C2 = 0. ``"fe"``: C1 = E/6 with
    the Young's modulus of a finite-element model. ``"tensile"``: C1 and C2 as fitted to tensile tests.
    """
    name = material_set or drive_unit(robot).material_set
    if name not in MATERIAL_SETS:
        fix = did_you_mean(name, MATERIAL_SETS)
        raise InputError("must be a known material set", key="material", value=shown(name), fix=fix)
    if material not in robot.materials:
        fix = did_you_mean(material, robot.materials)
        raise InputError("is not a material of [materials]", file=robot.file or None, key=material, fix=fix)
    solid: Material = robot.materials[material]
    if name == "datasheet":
        return Mooney(solid.modulus_100 / 3.5, 0.0)  # Mooney.modulus_100, solved for C1
    fix = f"give it for the material set {name}, or choose another set"
    if name == "fe":
        return Mooney(require(solid.modulus_fe, f"materials.{material}.modulus_fe_pa", robot, fix) / 6, 0.0)
    return Mooney(*require(solid.tensile, f"materials.{material}.tensile_pa", robot, fix))


def drive_unit(robot: Robot) -> DriveUnit:
    """Return the table of the muscle."""
    return require(robot.drive_unit, "drive_unit", robot)


def joint_group(robot: Robot, joint: str | int) -> tuple[JointGroup, Actuator]:
    """Return a joint group by name or index, with its table ``[joints.actuator]`` and a number of muscles."""
    names = [group.name for group in robot.joints]
    if isinstance(joint, int) and not isinstance(joint, bool) and 0 <= joint < len(names):
        index = joint
    elif joint in names:
        index = names.index(joint)
    else:
        fix = did_you_mean(str(joint), names)
        raise InputError("is not a joint of the robot", file=robot.file or None, key=f"joint {joint}", fix=fix)
    group = robot.joints[index]
    require(group.drive_units, f"joints.{group.name}.drive_units", robot)
    return group, require(group.actuator, f"joints.{group.name}.actuator", robot)


def muscle(robot: Robot, material: str | None = None, *, friction: bool = True) -> _core.DriveUnit:
    """Return a drive unit for the core, with a material set and with or without friction of its braid."""
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
    """Return a joint by name or index for the core, with a material set and with or without friction of its braids."""
    group, actuator = joint_group(robot, joint)
    matrix = mooney(robot, drive_unit(robot).matrix, material)
    inertia = np.pi / 4 * np.array(actuator.semi_major) * np.array(actuator.semi_minor) ** 3  # of an ellipse
    return _core.SoftJoint(
        muscle(robot, material, friction=friction),
        units=cast(int, group.drive_units),
        lever=actuator.levers,
        length=list(actuator.segment_length),
        stiffness=(actuator.stiffness_factor * matrix.modulus * inertia).tolist(),
    )


def joint_tables(robot: Robot, material: str | None = None, *, points: int = 257) -> tuple[JointTable, ...]:
    """Tabulate every joint of a robot over its angle, at an odd number of points.

    The segments share an angle as under the pressure of one side alone. A table ends where the lumen of a stretched
    muscle is `LUMEN_MIN` of that at rest, and the joint locks. A joint with a table ``[joints.reduced]`` takes moment
    and volume from there and locks at its ends; friction and viscosity are those of the muscles.
    """
    points = WHOLE.check(points, "points", "omit it for 257")
    if points < 3 or points % 2 == 0:
        raise InputError("must be odd and at least 3", key="points", value=str(points), fix="omit it for 257")
    groups = range(len(robot.joints))
    key = ("joint tables", material, points)
    return cached(robot, key, lambda: tuple(_table(robot, g, material, points) for g in groups))


def _table(robot: Robot, g: int, material: str | None, points: int) -> JointTable:
    """Tabulate one joint."""
    unit, joint = drive_unit(robot), soft_joint(robot, g, material)
    reach = min(joint.reach(side, left=LUMEN_MIN, highest=PRESSURE_MAX) for side in (0, 1))
    table, reduced = joint.table(reach=reach, points=points), robot.joints[g].reduced
    if reduced is not None:
        table, reach = _reduced(robot, g, reduced, table, reach), reduced.angle[-1]
    table.flags.writeable = False  # the table is cached and shared
    matrix, walls = joint.stiffness()
    # Kelvin-Voigt: relaxation time times stiffness, as at rest
    viscosity = robot.materials[unit.matrix].relaxation * matrix + robot.materials[unit.hose].relaxation * walls
    step = 2 * reach / (points - 1)
    return JointTable(robot.joints[g].name, -reach, step, table, viscosity, STOP * (matrix + walls))


def _reduced(robot: Robot, g: int, reduced: Reduced, muscles: Array, reach: float) -> Array:
    """Tabulate a reduced joint up to its own ends, with friction and carried pressure of its muscles up to `reach`.

    Splines through moment and volume; the energy is the integral of the spline of the moment, so that it is conserved.
    """
    from scipy.interpolate import CubicSpline  # here: its import takes longer than a bend

    key = f"joints.{robot.joints[g].name}.reduced"
    if joint_group(robot, g)[1].asymmetry != 0:
        rule, fix = "is for a joint whose sides are alike", "omit actuator.asymmetry, or the table"
        raise InputError(rule, file=robot.file or None, key=key, fix=fix)
    angle = np.linspace(-reduced.angle[-1], reduced.angle[-1], len(muscles))
    elastic, volume = (CubicSpline(reduced.angle, values) for values in (reduced.elastic, reduced.volume))
    energy = elastic.antiderivative()
    held, slope = volume(angle), volume(angle, 1)
    falls = np.flatnonzero(slope <= 0)
    if len(falls):
        rule = "must increase smoothly: a cubic spline through it must not fall between its angles"
        value = f"one that falls at {math.degrees(angle[falls[0]]):.3g} deg"
        fix = "give more angles there, or correct a volume"
        raise InputError(rule, file=robot.file or None, key=f"{key}.volume_m3", value=value, fix=fix)
    known = np.linspace(-reach, reach, len(muscles))
    first = COLUMNS.index("friction_left")
    rest = [np.interp(angle, known, column) for column in muscles[:, first:].T]  # beyond them as at their ends
    work = energy(angle) - energy(0.0)
    return np.stack([work, elastic(angle), held, held[::-1], slope, -slope[::-1], *rest], axis=1)
