"""Free muscle by finite elements: a McKibben tube alone, with the energies of the joint's model.

The tube is a quarter of a sleeve around a channel; its ends are plane and free to widen, so that it stretches and
swells evenly and theory knows the answer. The stretch of the whole is an unknown, or held, beside a displacement w that
leaves the ends in their planes: F = I + (lambda - 1) e_x (x) e_x + grad w.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hypertuna.actuation.silicone import Mooney
from hypertuna.fe.energies import Solid, Wall, braid_energy, cavity, hose_energy, nominal_stress, solid_energy
from hypertuna.fe.extra import need_fe
from hypertuna.fe.model import surface_strain
from hypertuna.fe.newton import Equilibrium, Problem, lead

__all__ = ["CARRIER", "Tube", "gradients", "ideal_pull", "ideal_stretch", "load", "pull", "sleeve_pull", "tube"]

ORDER = 3  # of displacements and curved elements: enough for a tube, which stretches uniformly
LENGTH = 2.0  # of the tube over its outer radius: a short one is enough, as its state is uniform
QUARTERS = 4  # of the tube, of which symmetry leaves one to compute

# Elements need a volume, which a wall alone lacks: a solid of 5 Pa carries it, free to change its volume.
CARRIER = Solid("neo_hookean", Mooney(2.5, 0.0), 0.0)


@dataclass(frozen=True)
class Tube:
    """Tube with its present state, which `load` changes."""

    wall: Wall
    sleeve: Solid
    length: float  # at rest [m]
    held: bool  # whether its length is held
    problem: Problem  # energy of a quarter; its loads are the pressure [Pa] and what the ends are pulled apart with [N]

    @property
    def displacement(self) -> Any:
        """Return the present displacement w [m], an ngsolve.GridFunction."""
        return self.problem.state if self.held else self.problem.state.components[0]

    @property
    def stretch(self) -> float:
        """Return the present length over that at rest [1]."""
        return 1.0 if self.held else 1.0 + float(self.problem.state.components[1].vec[0])


def tube(wall: Wall, sleeve: Solid = CARRIER, *, thickness: float, held: bool = False) -> Tube:
    """Return a tube at rest. `thickness` [m]."""
    need_fe()
    import ngsolve as ngs

    length = LENGTH * wall.outer
    mesh = _mesh(wall.outer, thickness, length)
    space = ngs.VectorH1(mesh, order=ORDER, dirichletx="ends", dirichlety="y", dirichletz="z")
    if not held:
        space = space * ngs.NumberSpace(mesh)
    w, strain = (space.TrialFunction(), ngs.CF(0.0)) if held else space.TrialFunction()
    pressure, apart = ngs.Parameter(0.0), ngs.Parameter(0.0)
    whole, F = gradients(w, strain)
    energy = ngs.BilinearForm(space, symmetric=True)
    work = apart * strain * length / (QUARTERS * ngs.Integrate(ngs.CF(1.0), mesh))
    energy += ngs.Variation((solid_energy(sleeve, F) - work).Compile() * ngs.dx)
    C = surface_strain(whole)
    walls = hose_energy(wall, C.Caa, C.Chh, C.Cah) + braid_energy(wall, C.Caa, C.Chh, C.Cah)
    # No flow of (0, y, z) / 2 passes a plane end, so the wall alone encloses the volume; `cavity` takes a third.
    across = ngs.CF((0.0, ngs.y + w[1], ngs.z + w[2]))
    volume = 1.5 * cavity(across, ngs.Id(3) + whole, ngs.specialcf.normal(3))
    energy += ngs.Variation((walls - pressure * volume).Compile() * ngs.ds("wall"))
    problem = Problem(energy, ngs.GridFunction(space), (pressure, apart), max(sleeve.shear, wall.hose.modulus / 3))
    return Tube(wall, sleeve, length, held, problem)


def load(tube: Tube, pressure: float, apart: float = 0.0) -> Equilibrium:
    """Change a tube's loads in steps from the present ones. `pressure` [Pa], `apart` [N]."""
    return lead(tube.problem, (pressure, apart))


def pull(tube: Tube) -> float:
    """Return the force [N] by which a held tube pulls its ends together, from the virtual work of x / L."""
    import ngsolve as ngs

    state = tube.problem.state
    longer, slope = ngs.GridFunction(state.space), state.vec.CreateVector()
    longer.Set(ngs.CF((ngs.x / tube.length, 0.0, 0.0)))
    tube.problem.energy.Apply(state.vec, slope)
    return QUARTERS * float(slope.InnerProduct(longer.vec))


def sleeve_pull(tube: Tube) -> float:
    """Return the sleeve's part of a tube's pull [N]: what a carrying solid adds to theory."""
    import ngsolve as ngs

    _, F = gradients(tube.displacement, ngs.CF(tube.stretch - 1))
    axial = nominal_stress(tube.sleeve, F)[0]
    return QUARTERS * float(ngs.Integrate(axial, tube.problem.state.space.mesh)) / tube.length


def ideal_pull(pressure: float, radius: float, angle: float, stretch: float = 1.0) -> float:
    """Return a braid's pull P pi D0^2 / (4 sin^2 theta0) (3 cos^2 theta - 1) with cos theta = lambda cos theta0.

    After Gaylord (1958); Chou and Hannaford (1996) write it with the diameter at 90 degrees, D0 / sin theta0.

    `pressure` [Pa], `radius` [m], `angle` [rad], `stretch` [1]; returns [N].
    """
    return pressure * math.pi * (radius / math.sin(angle)) ** 2 * (3 * (stretch * math.cos(angle)) ** 2 - 1)


def ideal_stretch(angle: float, part: float = 0.0) -> float:
    """Return the stretch at which a braid pulls a given part of its pull at rest: `ideal_pull` solved for lambda.

    `angle` [rad], `part` [1]; returns [1].
    """
    return math.sqrt((1 + part * (3 * math.cos(angle) ** 2 - 1)) / 3) / math.cos(angle)


def gradients(w: Any, strain: Any) -> tuple[Any, Any]:
    """Return the displacement's gradient along a wall, and the sleeve's deformation gradient."""
    import ngsolve as ngs

    axis = ngs.CF((1.0, 0.0, 0.0))
    even = strain * ngs.OuterProduct(axis, axis)
    return ngs.Grad(w).Trace() + even, ngs.Id(3) + ngs.Grad(w) + even


def _mesh(radius: float, thickness: float, length: float) -> Any:
    """Mesh a quarter of a sleeve [m]: faces "wall", "rim", "ends", and "y" and "z" in the planes of symmetry."""
    import ngsolve as ngs
    from netgen.occ import Box, Cylinder, OCCGeometry, Pnt, X

    rim = radius + thickness
    sleeve = Cylinder(Pnt(0, 0, 0), X, r=rim, h=length) - Cylinder(Pnt(0, 0, 0), X, r=radius, h=length)
    quarter, same = sleeve * Box((0, 0, 0), (length, 2 * rim, 2 * rim)), 1e-3 * radius
    for face in quarter.faces:
        low, high = face.bounding_box
        plane = next((name for name in "yz" if getattr(high, name) < same), "")
        ends = high.x < same or low.x > length - same
        face.name = plane or ("ends" if ends else "wall" if high.y < radius + same else "rim")
    options = {"grading": 0.9, "curvaturesafety": 1.0, "parallel_meshing": False}  # its threads would only wait
    mesh = ngs.Mesh(OCCGeometry(quarter).GenerateMesh(maxh=radius, **options))
    mesh.Curve(ORDER)
    return mesh
