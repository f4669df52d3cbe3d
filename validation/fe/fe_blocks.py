"""Blocks by finite elements: a cube that strains evenly and a clamped beam, with the energies of the joint's model."""

from __future__ import annotations

from typing import Any

from hypertuna.fe.energies import Solid, nominal_stress, solid_energy
from hypertuna.fe.extra import need_fe
from hypertuna.fe.newton import Equilibrium, Problem, lead

__all__ = ["STRAINS", "cantilever", "closed_form", "cube_stress", "timoshenko"]

SIDE = 0.01  # m, of the cube; width and height of the beam
SLENDER = 15.0  # length of the beam over its height
SAG = 0.01  # of the beam's end over its length: small, so that linear theory holds

# Strains of a cube: entries of grad u that are prescribed, and faces that stay in their planes.
STRAINS = {
    "uniaxial": (((0, 0),), {"dirichletx": "x.*", "dirichlety": "y0", "dirichletz": "z0"}),
    "biaxial": (((0, 0), (1, 1)), {"dirichletx": "x.*", "dirichlety": "y.*", "dirichletz": "z0"}),
    "shear": (((0, 1),), {"dirichlet": "..*"}),
}


def cube_stress(solid: Solid, strain: str, amount: float) -> tuple[float, Equilibrium]:
    """Strain a cube whose other faces are free; return its nominal stress P_xx, or P_xy in shear, and the solution.

    Returns the stress [Pa].
    """
    need_fe()
    import ngsolve as ngs

    places, fixed = STRAINS[strain]
    mesh = _box((SIDE, SIDE, SIDE), 2 * SIDE)
    space, given = ngs.VectorH1(mesh, order=1, **fixed), ngs.Parameter(0.0)
    entries = ngs.CF(tuple(1.0 if (i, j) in places else 0.0 for i in range(3) for j in range(3)), dims=(3, 3))
    state, w = ngs.GridFunction(space), space.TrialFunction()
    energy = ngs.BilinearForm(space, symmetric=True)
    energy += ngs.Variation(solid_energy(solid, ngs.Id(3) + given * entries + ngs.Grad(w)).Compile() * ngs.dx)
    found = lead(Problem(energy, state, (given,), solid.shear), (amount,))
    stress = nominal_stress(solid, ngs.Id(3) + given * entries + ngs.Grad(state))
    return float(ngs.Integrate(stress[places[0]], mesh)) / SIDE**3, found


def closed_form(solid: Solid, strain: str, amount: float) -> float:
    """Return the theory's nominal stress: hyperelastic laws incompressible, the linear law with its Poisson's ratio.

    Returns the stress [Pa].
    """
    stretch, mu, nu = 1 + amount, solid.shear, solid.poisson
    if solid.law == "linear":  # S = 2 mu E + lambda tr(E), with Green's strain E; P = F S
        green, lame = (stretch**2 - 1) / 2, solid.bulk - 2 * mu / 3
        young = 2 * mu * (1 + nu)
        cubic = amount**3 * (mu + lame / 2)
        return {
            "uniaxial": stretch * young * green,
            "biaxial": stretch * young / (1 - nu) * green,
            "shear": mu * amount + cubic,
        }[strain]
    c1, c2 = solid.constants if solid.law == "mooney_rivlin" else (mu / 2, 0.0)
    return {
        "uniaxial": 2 * (c1 + c2 / stretch) * (stretch - stretch**-2),
        "biaxial": 2 * (c1 + c2 * stretch**2) * (stretch - stretch**-5),
        "shear": mu * amount,
    }[strain]


def cantilever(solid: Solid, *, order: int, size: float = 1.0) -> tuple[float, float, int, Equilibrium]:
    """Clamp a beam of square section at one end and push the other across; compare with `timoshenko`.

    Returns sag [m], theory [m].
    """
    need_fe()
    import ngsolve as ngs

    length = SLENDER * SIDE
    mesh = _box((length, SIDE, SIDE / 2), size * SIDE)
    space = ngs.VectorH1(mesh, order=order, dirichlet="x0", dirichletz="z0")
    u = space.TrialFunction()
    F, force = ngs.Id(3) + ngs.Grad(u), ngs.Parameter(0.0)
    energy = ngs.BilinearForm(space, symmetric=True)
    energy += ngs.Variation(solid_energy(solid, F).Compile() * ngs.dx)
    energy += ngs.Variation((-force / SIDE**2 * u[1]).Compile() * ngs.ds("x1"))
    push = SAG * length / timoshenko(solid, 1.0)
    state = ngs.GridFunction(space)
    found = lead(Problem(energy, state, (force,), solid.shear), (push,))
    return float(ngs.Integrate(state[1] * ngs.ds("x1"), mesh)) / (SIDE**2 / 2), SAG * length, int(mesh.ne), found


def timoshenko(solid: Solid, force: float) -> float:
    """Return a clamped beam's end displacement: F L^3 / (3 E I) + F L / (k G A), k by Cowper (1966) for a rectangle.

    `force` [N]; returns [m].
    """
    length, nu = SLENDER * SIDE, solid.poisson
    young, inertia, factor = 2 * solid.shear * (1 + nu), SIDE**4 / 12, 10 * (1 + nu) / (12 + 11 * nu)
    return force * length**3 / (3 * young * inertia) + force * length / (factor * solid.shear * SIDE**2)


def _box(size: tuple[float, float, float], largest: float) -> Any:
    """Mesh a box between the planes x = 0 and so on and `size` [m]; its faces are x0, x1, y0, y1, z0, z1."""
    import ngsolve as ngs
    from netgen.occ import Box, OCCGeometry

    box, same = Box((0, 0, 0), size), 1e-3 * min(size)
    for face in box.faces:
        low, high = face.bounding_box
        for axis, far in zip("xyz", size, strict=True):
            if getattr(high, axis) < same:
                face.name = f"{axis}0"
            elif getattr(low, axis) > far - same:
                face.name = f"{axis}1"
    return ngs.Mesh(OCCGeometry(box).GenerateMesh(maxh=largest, parallel_meshing=False))
