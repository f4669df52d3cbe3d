"""Mesh of a soft joint: straight tetrahedra of Netgen, moved to the exact surface by an elastic motion of all nodes.

Netgen curves elements at the surface only, so they invert in the thin webs between hoses. Here the interior follows the
surface like an elastic body, so that the curvature is spread over many elements.
"""

import contextlib
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hypertuna.errors import InputError
from hypertuna.fe.geometry import FACES, MM, JointBody, half_shape
from hypertuna.ranges import check_name

AREA = 2e-3  # relative tolerance of a mesh's areas and volume
TRIES = 5  # most meshes tried, each finer than the last, until no element is inverted
FINER = 0.9  # ratio of element sizes of successive meshes


@dataclass(frozen=True)
class MeshSize:
    """Sizes of the elements of a mesh."""

    around: float = 1.0  # size of triangles on the channels' walls over the channels' radius
    largest: float = 4.0  # size of elements far from the channels over the channels' radius
    grading: float = 0.9  # growth of element sizes, as Netgen defines it
    order: int = 4  # polynomial order of the displacements
    pieces: float = 6.0  # number of elements along the joint, few since slender hoses vary little along their axes
    # Polynomial order of curved elements; None: that of the displacements. With a higher one elements could not rotate.
    curve: int | None = None

    @property
    def curvature(self) -> int:
        """Polynomial order of curved elements."""
        return self.order if self.curve is None else self.curve

    def squeeze(self, body: JointBody) -> float:
        """Return the ratio of an element's length along the joint to its length across the joint."""
        return max(1.0, body.length / (self.pieces * self.around * body.radius))


MESHES = {"coarse": MeshSize(1.3, 5.0, pieces=4.0), "medium": MeshSize(), "fine": MeshSize(0.8, pieces=9.0)}


def mesh_size(mesh: str | MeshSize) -> MeshSize:
    """Return the element sizes of a mesh, given these sizes or the name of a mesh."""
    if isinstance(mesh, MeshSize):
        return mesh
    return MESHES[check_name(mesh, MESHES, "mesh", "mesh")]


def joint_mesh(body: JointBody, size: MeshSize) -> tuple[Any, Any]:
    """Return a mesh of a body's upper half in mm, shortened along x, and its deformation to the true shape in m."""
    from netgen.meshing import NgException

    value = "no mesh of Netgen"
    for _ in range(TRIES):
        with contextlib.suppress(NgException):
            mesh = _straight(body, size)
            deformation = _bend(mesh, body, size)
            mesh.SetDeformation(deformation)
            if (inverted := _inverted(mesh, size)) == 0:
                _check(mesh, body)
                return mesh, deformation
            value = f"one with {inverted} of them"
        size = replace(size, around=FINER * size.around, largest=FINER * size.largest)
    rule = "must be without inverted elements"
    raise InputError(rule, key="mesh", value=value, fix="use a finer mesh, or leave more matrix between the hoses")


def _straight(body: JointBody, size: MeshSize) -> Any:
    """Return a mesh of the upper half, of tetrahedra with plane faces."""
    import ngsolve as ngs
    from netgen.occ import OCCGeometry

    shape, radius = half_shape(body, squeeze=size.squeeze(body)), MM * body.radius
    for face in shape.faces:
        if face.name.startswith("wall"):
            face.maxh = size.around * radius
    options = {"maxh": size.largest * radius, "grading": size.grading, "curvaturesafety": 1 / size.around}
    return ngs.Mesh(OCCGeometry(shape).GenerateMesh(segmentsperedge=0.5, parallel_meshing=False, **options))


def _bend(mesh: Any, body: JointBody, size: MeshSize) -> Any:
    """Return the displacement of all points from the straight mesh to the true shape [m]."""
    import ngsolve as ngs

    curved = {name: _to_channels(body) for name in ("wall_left", "wall_right")} | {
        "outer": _to_rim(body, size.squeeze(body))
    }
    planes = {"dirichletx": "fixed|tip|tie|cap_.*", "dirichlety": "axis", "dirichletz": "symmetry"}
    planes["dirichletz_bbnd"] = "rim"  # the rim of the axis' strip, inside the matrix
    space = ngs.VectorH1(mesh, order=size.curvature, dirichlet="|".join(curved), **planes)
    motion = ngs.GridFunction(space)
    motion.Set(mesh.BoundaryCF(curved), definedon=mesh.Boundaries("|".join(curved)), dual=True)
    u, v = space.TnT()
    strains = [ngs.Grad(w) + ngs.Grad(w).trans for w in (u, v)]
    stiffness = ngs.BilinearForm(space, symmetric=True)
    stiffness += ngs.InnerProduct(*strains) / ngs.specialcf.mesh_size**2 * ngs.dx  # small elements are made stiffer
    stiffness.Assemble()
    residual = motion.vec.CreateVector()
    residual.data = stiffness.mat * motion.vec
    motion.vec.data -= stiffness.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky") * residual
    deformation = ngs.GridFunction(ngs.VectorH1(mesh, order=size.curvature))
    scales = (size.squeeze(body) / MM, 1 / MM, 1 / MM)
    place = (ngs.x, ngs.y, ngs.z)
    deformation.Set(ngs.CF(tuple(s * (p + motion[k]) - p for k, (s, p) in enumerate(zip(scales, place, strict=True)))))
    return deformation


def _to_channels(body: JointBody) -> Any:
    """Return the displacement [mm] that moves the straight faces of channels' walls onto the round walls."""
    import ngsolve as ngs

    motion, radius = ngs.CF((0.0, 0.0, 0.0)), MM * body.radius
    for channel in body.upper:
        dy, dz = ngs.y - MM * channel.y, ngs.z - MM * channel.z
        distance = ngs.sqrt(dy * dy + dz * dz)
        outward = radius / distance - 1
        motion = ngs.IfPos(1.001 * radius - distance, ngs.CF((0.0, outward * dy, outward * dz)), motion)
    return motion


def _to_rim(body: JointBody, squeeze: float) -> Any:
    """Return the displacement [mm], along rays from the section's center, of straight outer faces to the ellipses."""
    import ngsolve as ngs

    stations = [MM / squeeze * float(x) for x in body.stations]

    def taper(values: Any) -> Any:
        axis = ngs.CF(MM * float(values[-1]))  # semi-axis of the plate
        for k in reversed(range(len(stations) - 1)):
            taper_rate = MM * float(values[k + 1] - values[k]) / (stations[k + 1] - stations[k])
            axis = ngs.IfPos(stations[k + 1] - ngs.x, MM * float(values[k]) + taper_rate * (ngs.x - stations[k]), axis)
        return axis

    reach = ngs.sqrt((ngs.z / taper(body.semi_major)) ** 2 + (ngs.y / taper(body.semi_minor)) ** 2)
    return ngs.CF((0.0, (1 / reach - 1) * ngs.y, (1 / reach - 1) * ngs.z))


def _inverted(mesh: Any, size: MeshSize) -> int:
    """Return the number of elements whose Jacobian is not positive everywhere."""
    import ngsolve as ngs

    points = mesh.MapToAllElements(ngs.IntegrationRule(ngs.TET, 2 * size.curvature), ngs.VOL)
    jacobian = np.asarray(ngs.Det(ngs.specialcf.JacobianMatrix(3))(points)).reshape(mesh.ne, -1)
    return int((jacobian.min(axis=1) <= 0).sum())


def _check(mesh: Any, body: JointBody) -> None:
    """Check areas and volume of a mesh against the body; they differ if a face of the drawing has a wrong name."""
    import ngsolve as ngs

    one = ngs.CF(1.0)
    channels = sum(0.5 if abs(channel.z) < 1e-9 else 1.0 for channel in body.upper)
    caps = channels * np.pi * body.radius**2
    parts = {
        "area in the plane of symmetry": (ngs.ds("symmetry"), body.symmetry_area),
        "area of the channels' walls": (ngs.ds(FACES["walls"]), 2 * channels * np.pi * body.radius * body.length),
        "area of the channels' ends": (ngs.ds("cap_.*"), caps),
        "volume of the matrix": (ngs.dx("matrix"), body.volume / 2),
        "area of the axis' strip": (ngs.ds("axis"), body.axis / 2 * body.length),
    }
    for name, (where, expected) in parts.items():
        excess = ngs.Integrate(one * where, mesh) - expected
        if abs(excess) > AREA * expected:
            rule, value = (
                f"must have the drawing's {name}",
                f"{100 * excess / expected if expected else 100:+.2g} % off",
            )
            raise InputError(rule, key="mesh", value=value, fix="use a finer mesh, or change the geometry slightly")
