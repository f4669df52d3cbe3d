"""Muscle whose hose is resolved: solid elements from the lumen to the braid, where the joint's model has a wall.

A quarter of a hose between lumen and braid, around it a sleeve of matrix; the fibers lie on the face between both. Ends
are plane and free to widen, where core muscle.hpp knows the answer.
"""

from __future__ import annotations

from typing import Any

from fe_tube import LENGTH, ORDER, QUARTERS, Tube, gradients

from hypertuna.fe.energies import Solid, Wall, braid_energy, cavity, solid_energy
from hypertuna.fe.extra import need_fe
from hypertuna.fe.model import surface_strain
from hypertuna.fe.newton import Problem

__all__ = ["resolved_hose"]


def resolved_hose(wall: Wall, sleeve: Solid, *, thickness: float, poisson: float) -> Tube:
    """Return a muscle at rest, with a hose of solid elements. `thickness` of the sleeve [m], `poisson` of the hose."""
    need_fe()
    import ngsolve as ngs

    length = LENGTH * wall.outer
    mesh = _mesh(wall, thickness, length)
    space = ngs.VectorH1(mesh, order=ORDER, dirichletx="ends", dirichlety="y", dirichletz="z") * ngs.NumberSpace(mesh)
    w, strain = space.TrialFunction()
    pressure, apart = ngs.Parameter(0.0), ngs.Parameter(0.0)
    whole, F = gradients(w, strain)
    energy = ngs.BilinearForm(space, symmetric=True)
    work = apart * strain * length / (QUARTERS * ngs.Integrate(ngs.CF(1.0), mesh))
    for name, solid in (("hose", Solid("mooney_rivlin", wall.hose, poisson)), ("sleeve", sleeve)):
        energy += ngs.Variation((solid_energy(solid, F) - work).Compile() * ngs.dx(name))
    energy += ngs.Variation(braid_energy(wall, *surface_strain(whole)).Compile() * ngs.ds("braid"))
    across = ngs.CF((0.0, ngs.y + w[1], ngs.z + w[2]))  # as in `fe_tube.tube`
    volume = 1.5 * cavity(across, ngs.Id(3) + whole, ngs.specialcf.normal(3))
    energy += ngs.Variation((-pressure * volume).Compile() * ngs.ds("lumen"))
    problem = Problem(energy, ngs.GridFunction(space), (pressure, apart), wall.hose.modulus / 3)
    return Tube(wall, sleeve, length, held=False, problem=problem)


def _mesh(wall: Wall, thickness: float, length: float) -> Any:
    """Mesh a quarter of hose and sleeve [m]: faces "lumen", "braid", "rim", "ends", and "y" and "z" of symmetry."""
    import ngsolve as ngs
    from netgen.occ import Box, Cylinder, Glue, OCCGeometry, Pnt, X

    radii = (wall.inner, wall.outer, wall.outer + thickness)
    inner, outer, rim = (Cylinder(Pnt(0, 0, 0), X, r=radius, h=length) for radius in radii)
    box, parts = Box((0, 0, 0), (length, 2 * radii[-1], 2 * radii[-1])), []
    for name, part in (("hose", outer - inner), ("sleeve", rim - outer)):
        quarter = part * box
        quarter.mat(name)
        parts.append(quarter)
    both, same = Glue(parts), 1e-3 * wall.inner
    for face in both.faces:
        low, high = face.bounding_box
        plane = next((name for name in "yz" if getattr(high, name) < same), "")
        ends = high.x < same or low.x > length - same
        curved = next(
            (name for name, radius in zip(("lumen", "braid"), radii, strict=False) if high.y < radius + same), ""
        )
        face.name = plane or ("ends" if ends else curved or "rim")
    options = {"grading": 0.9, "curvaturesafety": 1.0, "parallel_meshing": False}
    mesh = ngs.Mesh(OCCGeometry(both).GenerateMesh(maxh=wall.outer, **options))
    mesh.Curve(ORDER)
    return mesh
