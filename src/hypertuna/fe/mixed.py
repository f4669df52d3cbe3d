"""Mixed form: the pressure of a nearly incompressible solid as an unknown of its own.

The volumetric energy kappa/2 theta^2, theta = J - 1, becomes p theta - p^2 / (2 kappa): the same for p = kappa theta,
but theta may vary within an element beyond p, so that elements do not lock. The pressure is discontinuous and solved
element by element: p = kappa Pi theta(u), Pi the L2 projection. An energy of the displacement alone remains, with the
same Newton's method and line search.
"""

from collections.abc import Callable
from typing import Any

from hypertuna.errors import InputError
from hypertuna.fe.energies import Solid

LOWER = 2  # order of the displacement minus that of the pressure


def mixed_space(displacements: Any, region: Any) -> Any:
    """Return the space of displacements and discontinuous pressures, two orders lower.

    With one order more p follows every theta, as without p; with one less a beam is too soft (docs/fe.md).
    """
    from ngsolve import COUPLING_TYPE, L2

    order = displacements.globalorder
    if order < 1 + LOWER:
        fix = "use a mesh of order 3, or no mixed form"
        raise InputError(f"must be at least {1 + LOWER} in the mixed form", key="order", value=str(order), fix=fix)
    for number in range(displacements.ndof):  # only the pressures are condensed
        if displacements.CouplingType(number) == COUPLING_TYPE.LOCAL_DOF:
            displacements.SetCouplingType(number, COUPLING_TYPE.INTERFACE_DOF)
    return displacements * L2(displacements.mesh, order=order - LOWER, definedon=region)


def dilatation(solid: Solid, F: Any) -> Any:
    """Return the dilatation theta of a solid's law: J - 1, or the trace of Green's strain."""
    from ngsolve import Det, InnerProduct

    return (InnerProduct(F, F) - 3) / 2 if solid.law == "linear" else Det(F) - 1


def mixed_energy(solid: Solid, F: Any, p: Any) -> Any:
    """Return the volumetric energy per volume at rest, p theta - p^2 / (2 kappa) [J/m^3]."""
    return p * dilatation(solid, F) - p * p / (2 * solid.bulk)


def settling(space: Any, solid: Solid, region: Any) -> Callable[[Any], None]:
    """Return a function that sets the pressures of a state [Pa] from its displacements."""
    import ngsolve as ngs

    displacements, pressures = space.components
    u, (p, q) = ngs.GridFunction(displacements), pressures.TnT()
    # the energy's integration rule, so that its derivative by the pressures is zero to the last digit
    rules = {ngs.TET: ngs.IntegrationRule(ngs.TET, 2 * displacements.globalorder)}
    volume = ngs.dx(definedon=region, intrules=rules)
    mass = ngs.BilinearForm(pressures, symmetric=True)
    mass += p * q / solid.bulk * volume
    inverse = mass.Assemble().mat.Inverse(pressures.FreeDofs(), inverse="sparsecholesky")
    source = ngs.LinearForm(pressures)
    source += (dilatation(solid, ngs.Id(3) + ngs.Grad(u)) * q).Compile() * volume

    def settle(state: Any) -> None:
        u.vec.data = state.Range(space.Range(0).start, space.Range(0).stop)
        source.Assemble()
        state.Range(space.Range(1).start, space.Range(1).stop).data = inverse * source.vec

    return settle
