"""A joint without end effects: its sections in uniform bending, by finite elements in the plane of a section.

In a long body all sections deform alike: to y + u_y, z + u_z in the plane, with the stretch l - k (y + u_y) along x,
where l is the stretch of the axis and k the curvature per length at rest. The unknowns are u, l and k. Energies,
pressure and braids are as in model.py, at a hundredth of the cost. A real joint bends less, since plates hold its ends.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.actuation.bending import check_side
from hypertuna.actuation.hydraulics import SIDES
from hypertuna.actuation.soft_joint import joint_group
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.fe.energies import Axis, Solid, Wall, axis_energy, braid_energy, hose_energy, solid_energy
from hypertuna.fe.extra import need_fe
from hypertuna.fe.geometry import MM, JointBody, joint_body
from hypertuna.fe.model import FeOptions, axis_of, soft_parts
from hypertuna.fe.newton import Problem, lead

ORDER = 3  # polynomial order of displacements and of curved elements
AROUND = 0.8  # size of edges on the channels over their radius
INSIDE = 1e-9  # mm, distance of a point from the mesh's edge, where it might belong to no element
FIRST = 5e3  # Pa, first load step, small because braids are slack


@dataclass(frozen=True)
class Section:
    """Bend and axial stretch of a joint's sections in uniform bending, at rising pressures."""

    angle: Array  # (n,) bend of a joint of such sections, toward the side with the pressure [rad]; NaN: not converged
    axis: Array  # (n,) mean stretch of the axis, the line y = z = 0 at rest [1]


def section_bend(
    robot: Robot,
    joint: str | int,
    pressure: ArrayLike,
    *,
    side: str = "left",
    options: FeOptions | None = None,
    segments: bool = True,
) -> Section:
    """Return the deformation of a joint's sections at pressures (n,) [Pa] of one side, without friction.

    segments: solve each segment's section; if False, one mean section stands for all.
    """
    check_side(side)
    need_fe()
    options = options or FeOptions()
    rising = np.atleast_1d(np.asarray(pressure, dtype=np.float64))
    _, actuator = joint_group(robot, joint)
    lengths = np.array(actuator.segment_length)
    major, minor = np.array(actuator.semi_major), np.array(actuator.semi_minor)
    if not segments:
        major, minor = (np.array([np.average(half, weights=lengths)]) for half in (major, minor))
        lengths = lengths.sum(keepdims=True)
    states = [_bent(robot, joint, rising, side, (a, b), options) for a, b in zip(major, minor, strict=True)]
    axis, curvature = np.moveaxis(np.array(states), 2, 0)  # axis and curvature (segments, n)
    return Section(lengths @ curvature, lengths @ axis / lengths.sum())


def _bent(
    robot: Robot, joint: str | int, rising: Array, side: str, semi_axes: tuple[float, float], options: FeOptions
) -> Array:
    """Return axial stretch [1] and curvature per length at rest [1/m] of a section at each pressure (n, 2)."""
    import ngsolve as ngs

    matrix, w = soft_parts(robot, options)
    wall = replace(w, outer=MM * w.outer, inner=MM * w.inner, braid_stiffness=MM * w.braid_stiffness)
    body = joint_body(robot, joint)
    mesh = _mesh(body, semi_axes)
    in_plane = ngs.H1(mesh, order=ORDER, dirichlet_bbnd="pin"), ngs.H1(mesh, order=ORDER, dirichlet="symmetry")
    space = in_plane[0] * in_plane[1] * ngs.NumberSpace(mesh) * ngs.NumberSpace(mesh)
    load = ngs.Parameter(0.0)
    scale = MM * semi_axes[1]
    energy = _energy(space, axis_of(robot, body), matrix, wall, load, side, scale)
    problem = Problem(energy, ngs.GridFunction(space), (load,), matrix.shear)
    states = np.full((len(rising), 2), math.nan)
    lead(problem, (min(FIRST, float(rising[0])),))
    for k, value in enumerate(rising):
        if not lead(problem, (float(value),)).converged:
            break
        axis, bend = (problem.state.components[c].vec[0] for c in (2, 3))
        pin_distance = problem.state.components[0](mesh(0.0, INSIDE))  # mm along y, of the middle relative to the pin
        states[k] = 1 + axis - bend / scale * pin_distance, (1 - 2 * SIDES.index(side)) * bend / semi_axes[1]
    return states


def _mesh(body: JointBody, semi_axes: tuple[float, float]) -> Any:
    """Return a mesh of a section's upper half in mm; the mesh's x and y are the body's y and z."""
    import ngsolve as ngs
    from netgen.occ import Axes, Glue, OCCGeometry, Segment, WorkPlane, Y, Z

    a, b, r = MM * semi_axes[0], MM * semi_axes[1], MM * body.radius
    face = WorkPlane(Axes((0, 0, 0), n=Z, h=Y)).Ellipse(a, b).Face()
    for channel in body.upper:
        face = face - WorkPlane().MoveTo(MM * channel.y, MM * channel.z).Circle(r).Face()
    face = face * WorkPlane().MoveTo(-2 * b, 0).Rectangle(4 * b, 2 * a).Face()
    if body.axis > 0:
        face = Glue([face, Segment((0, 0, 0), (0, MM * body.axis / 2, 0))])
    for edge in face.edges:
        low, high = edge.bounding_box
        edge.name = "outer"
        if abs(low.y) < 1e-4 and abs(high.y) < 1e-4:
            edge.name = "symmetry"
        if abs(low.x) < 1e-4 and abs(high.x) < 1e-4:
            edge.name = "axis"
        for channel in body.upper:
            distance = max(max(abs(p.x - MM * channel.y), abs(p.y - MM * channel.z)) for p in (low, high))
            if distance < 1.001 * r:
                edge.name, edge.maxh = ("wall_left", "wall_right")[channel.side], AROUND * r
    min(face.vertices, key=lambda corner: corner.p.x).name = "pin"
    mesh = ngs.Mesh(OCCGeometry(face, dim=2).GenerateMesh(maxh=b / 2, grading=0.5))
    mesh.Curve(ORDER)
    return mesh


def _energy(space: Any, axis: Axis, matrix: Solid, wall: Wall, load: Any, side: str, scale: float) -> Any:
    """Return the energy of half a section per length [Pa mm^2]."""
    import ngsolve as ngs

    uy, uz, long, turn = space.TrialFunction()
    y = ngs.x + uy

    def in_plane(gy: Any, gz: Any) -> Any:
        return ngs.Id(2) + ngs.CF((gy[0], gy[1], gz[0], gz[1]), dims=(2, 2))

    stretch = 1 + long - turn / scale * y
    F2 = in_plane(ngs.grad(uy), ngs.grad(uz))
    F = ngs.CF((stretch, 0, 0, 0, F2[0, 0], F2[0, 1], 0, F2[1, 0], F2[1, 1]), dims=(3, 3))
    energy = ngs.BilinearForm(space, symmetric=True)
    energy += ngs.Variation(solid_energy(matrix, F).Compile() * ngs.dx)
    Fs = in_plane(ngs.grad(uy).Trace(), ngs.grad(uz).Trace())
    outward = ngs.specialcf.normal(2)
    # Netgen orients normals of plane edges by its curves; the right sign makes the channels' area positive.
    sign = 1.0 if ngs.Integrate(-ngs.x * outward[0] * ngs.ds(f"wall_{side}"), space.mesh) > 0 else -1.0
    normal = sign * outward
    around = Fs * ngs.CF((-normal[1], normal[0]))
    Caa, Chh = stretch * stretch, ngs.InnerProduct(around, around)
    walls = hose_energy(wall, Caa, Chh, ngs.CF(0.0)) + braid_energy(wall, Caa, Chh, ngs.CF(0.0))
    energy += ngs.Variation(walls.Compile() * ngs.ds("wall_.*"))
    if axis.width > 0:
        energy += ngs.Variation((MM * axis_energy(axis, stretch - 1, stretch - 1)).Compile() * ngs.ds("axis"))
    # Volume per length at rest: the integral of the stretch over the channel, as the flux of its antiderivative in y.
    flux = ((1 + long) * y - turn / (2 * scale) * y * y) * (Fs[1, 1] * normal[0] - Fs[1, 0] * normal[1])
    energy += ngs.Variation((load * flux).Compile() * ngs.ds(f"wall_{side}"))
    return energy
