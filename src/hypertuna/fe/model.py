"""Finite-element model of a soft joint: mesh, space of displacements, total energy.

The total energy is the energy of the matrix, of hose and braid on the channels' walls, of the plate and of the member
on the axis, minus the work of the oil's pressure and of a couple on the tip plate:

    Pi(u) = int W(F) dX + int_wall (hose + braid) dA + ... - sum_sides P V(u) - T g(u).

Displacements are of the fourth order, since two families of inextensible fibers constrain a curved wall, and the matrix
hardly changes its volume at any point. Elements of a lower order need much finer meshes (docs/fe.md).
"""

import math
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.silicone import Mooney
from hypertuna.actuation.soft_joint import drive_unit, joint_group, mooney
from hypertuna.description.robot import Robot
from hypertuna.fe.energies import (
    Axis,
    Solid,
    Wall,
    aligned_axis_energy,
    braid_energy,
    cavity,
    hose_energy,
    solid_energy,
)
from hypertuna.fe.extra import need_fe
from hypertuna.fe.geometry import FACES, JointBody, joint_body
from hypertuna.fe.mesh import MeshSize, joint_mesh, mesh_size
from hypertuna.fe.newton import Equilibrium, Problem, lead

PLATE = 1e3  # shear modulus of the plates over that of the matrix
ARC = 2  # polynomial order of the axis' angle along the joint, if a member holds the axis


@dataclass(frozen=True)
class FeOptions:
    """Options of a finite-element model: mesh, material set, law and compressibility."""

    material: str | None = None  # material set, the robot's by default
    law: str = "mooney_rivlin"  # law of the matrix, one of `energies.LAWS`
    poisson: float = 0.475  # Poisson's ratio of the matrix
    mesh: str | MeshSize = "medium"  # one of `mesh.MESHES`, or sizes

    @property
    def size(self) -> MeshSize:
        """Sizes of the mesh's elements."""
        return mesh_size(self.mesh)

    def material_of(self, robot: Robot) -> str:
        """Return the material set of the options, else of the robot."""
        return self.material or drive_unit(robot).material_set

    def facts(self, robot: Robot) -> dict[str, Any]:
        """Return all options by name, for records and journals."""
        return asdict(self) | {"material": self.material_of(robot)}


class SurfaceStrain(NamedTuple):
    """Squared stretches of a wall along the channel and around it, and their shear, as NGSolve expressions [1]."""

    Caa: Any
    Chh: Any
    Cah: Any


@dataclass(frozen=True)
class FeModel:
    """A finite-element model of a joint, with its state, which `equilibrium` changes."""

    robot: Robot
    body: JointBody
    options: FeOptions
    matrix: Solid
    wall: Wall
    mesh: Any
    deformation: Any  # deformation of the mesh to the true shape in m, from `joint_mesh`
    # Total energy of the upper half. Loads: gauge pressures of the left and right sides [Pa], and T [N m]; the couple
    # on the tip plate is T cos(angle), counter-clockwise.
    problem: Problem

    @property
    def displacement(self) -> Any:
        """Displacement in the present state [m], an ngsolve.GridFunction."""
        return self.problem.state.components[0] if self.body.axis else self.problem.state

    @property
    def unknowns(self) -> int:
        """Number of unknowns of the finite-element space."""
        return int(self.problem.state.space.ndof)


def fe_model(robot: Robot, joint: str | int, options: FeOptions | None = None) -> FeModel:
    """Return the model of a joint at rest."""
    options = options or FeOptions()
    soft_parts(robot, options)  # checks the options before the mesh is made
    body = joint_body(robot, joint)
    need_fe()
    return model_on(robot, body, options, *joint_mesh(body, options.size))


def model_on(robot: Robot, body: JointBody, options: FeOptions, mesh: Any, deformation: Any) -> FeModel:
    """Return the model of a body at rest, on the mesh and deformation that `joint_mesh` returns."""
    import ngsolve as ngs

    matrix, wall = soft_parts(robot, options)
    space = ngs.VectorH1(mesh, order=options.size.order, dirichlet="fixed", dirichletz="symmetry")
    loads = (ngs.Parameter(0.0), ngs.Parameter(0.0), ngs.Parameter(0.0))
    if body.axis > 0:  # unknown coefficients of the axis' angle
        for _ in range(ARC):
            space = space * ngs.NumberSpace(mesh)
    energy = _energy(space, axis_of(robot, body), body, matrix, wall, loads)
    problem = Problem(energy, ngs.GridFunction(space), loads, matrix.shear)
    return FeModel(robot, body, options, matrix, wall, mesh, deformation, problem)


def soft_parts(robot: Robot, options: FeOptions) -> tuple[Solid, Wall]:
    """Return the matrix of a robot's joints, and the walls of hose and braid."""
    unit = drive_unit(robot)
    hose, silicone = (mooney(robot, name, options.material) for name in (unit.hose, unit.matrix))
    wall = Wall(unit.outer_diameter / 2, unit.inner_diameter / 2, hose, unit.braid_angle, unit.braid_stiffness)
    return Solid(options.law, silicone, options.poisson), wall


def axis_of(robot: Robot, body: JointBody) -> Axis:
    """Return the member that holds the axis of a joint's body."""
    _, actuator = joint_group(robot, body.name)
    buckling = math.inf if actuator.axis_buckling is None else actuator.axis_buckling
    return Axis(actuator.axis_stiffness, buckling, body.axis)


def equilibrium(model: FeModel, *, pressure: tuple[float, float], couple: float = 0.0) -> Equilibrium:
    """Bring a model from its present state to the equilibrium under two pressures [Pa] and a couple [N m]."""
    return lead(model.problem, (*pressure, couple))


def surface_strain(gradient: Any) -> SurfaceStrain:
    """Return the strain of a channel's wall, which runs along x, from the displacement gradient."""
    from ngsolve import CF, Cross, Id, InnerProduct, Norm, specialcf

    F, normal = Id(3) + gradient, specialcf.normal(3)
    around = Cross(normal, CF((1, 0, 0)))
    around = around / Norm(around)  # unit length again: the mesh's wall is not quite a cylinder
    a, h = F * Cross(around, normal), F * around
    return SurfaceStrain(InnerProduct(a, a), InnerProduct(h, h), InnerProduct(a, h))


def _energy(space: Any, axis: Axis, body: JointBody, matrix: Solid, wall: Wall, loads: tuple[Any, Any, Any]) -> Any:
    """Return the total energy of the upper half [J] as an NGSolve form of the displacement."""
    import ngsolve as ngs

    u, *turns = space.TrialFunction() if axis.width else [space.TrialFunction()]
    F, place = ngs.Id(3) + ngs.Grad(u), ngs.CF((ngs.x, ngs.y, ngs.z)) + u
    energy = ngs.BilinearForm(space, symmetric=True)
    energy += ngs.Variation(solid_energy(matrix, F).Compile() * ngs.dx("matrix"))
    plate = Solid("neo_hookean", Mooney(PLATE * matrix.shear / 2, 0.0), 0.3)
    energy += ngs.Variation(solid_energy(plate, F).Compile() * ngs.dx("plate"))
    gradient = ngs.Grad(u).Trace()
    C = surface_strain(gradient)
    walls = hose_energy(wall, *C) + braid_energy(wall, *C)
    energy += ngs.Variation(walls.Compile() * ngs.ds(FACES["walls"]))
    volume = cavity(place, ngs.Id(3) + gradient, ngs.specialcf.normal(3))
    for name, load in zip(SIDES, loads[:2], strict=True):
        energy += ngs.Variation((-load * volume).Compile() * ngs.ds(FACES[name]))
    if axis.width > 0:  # half of the strip is in the upper half
        turn = sum(part * (ngs.x / body.length) ** (k + 1) for k, part in enumerate(turns))
        along = ngs.CF((1 + gradient[0, 0], gradient[1, 0], gradient[2, 0]))
        energy += ngs.Variation(aligned_axis_energy(axis, along, turn).Compile() * ngs.ds("axis"))
    # The sine of the tip's angle is the integral of -u_x (y - y_m) / int (y - y_m)^2.
    area = ngs.Integrate(ngs.CF(1.0) * ngs.ds("tip"), space.mesh)
    offset = ngs.y - ngs.Integrate(ngs.y * ngs.ds("tip"), space.mesh) / area
    turn = -u[0] * offset / ngs.Integrate(offset * offset * ngs.ds("tip"), space.mesh)
    energy += ngs.Variation((-0.5 * loads[2] * turn).Compile() * ngs.ds("tip"))
    return energy
