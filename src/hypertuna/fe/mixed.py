"""Mixed form: the pressure of a nearly incompressible solid as an unknown of its own.

The volumetric energy kappa/2 theta^2, theta = J - 1, becomes p theta - p^2 / (2 kappa): the same where p is
kappa theta, but theta may now vary within an element in ways that p does not follow, so less is kept and nothing locks.
The pressure is discontinuous, and found element by element: p = kappa Pi theta(u), Pi the L2 projection. What is left
is an energy of the displacement alone, so Newton's method and its line search stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hypertuna.errors import InputError
from hypertuna.fe.energies import Solid

__all__ = ["dilatation", "mixed_energy", "mixed_space", "settling"]

LOWER = 2  # orders by which the pressure is below the displacement


def mixed_space(displacements: Any, region: Any) -> Any:
    """Space of displacements and pressures, the latter of an order two below and discontinuous.

    An order more would follow every theta, as if there were no p; an order less leaves a beam too soft, at any
    Poisson's ratio (docs/fe.md).
    """
    from ngsolve import COUPLING_TYPE, L2

    order = displacements.globalorder
    if order < 1 + LOWER:
        fix = "take a mesh of order 3, or leave mixed out"
        raise InputError(f"must be {1 + LOWER} at least in the mixed form", key="order", value=str(order), fix=fix)
    for number in range(displacements.ndof):  # those of an element's inside stay: the pressures alone are condensed
        if displacements.CouplingType(number) == COUPLING_TYPE.LOCAL_DOF:
            displacements.SetCouplingType(number, COUPLING_TYPE.INTERFACE_DOF)
    return displacements * L2(displacements.mesh, order=order - LOWER, definedon=region)


def dilatation(solid: Solid, F: Any) -> Any:
    """Return theta, what the bulk modulus of a solid's law resists: J - 1, or the trace of Green's strain.

    `F` (3, 3).
    """
    from ngsolve import Det, InnerProduct

    return (InnerProduct(F, F) - 3) / 2 if solid.law == "linear" else Det(F) - 1


def mixed_energy(solid: Solid, F: Any, p: Any) -> Any:
    """Volumetric energy per volume at rest, p theta - p^2 / (2 kappa): what `solid_energy` then leaves out.

    `F` (3, 3), `p` [Pa]; returns [J/m^3].
    """
    return p * dilatation(solid, F) - p * p / (2 * solid.bulk)


def settling(space: Any, solid: Solid, region: Any) -> Callable[[Any], None]:
    """Return what sets the pressures of a state to those that its displacements call for. Returns [Pa]."""
    import ngsolve as ngs

    displacements, pressures = space.components
    u, (p, q) = ngs.GridFunction(displacements), pressures.TnT()
    # the rule with which the energy is integrated, so that its slope over the pressures is 0 to the last digit
    rules = {ngs.TET: ngs.IntegrationRule(ngs.TET, 2 * displacements.globalorder)}
    volume = ngs.dx(definedon=region, intrules=rules)
    mass = ngs.BilinearForm(pressures, symmetric=True)
    mass += p * q / solid.bulk * volume
    inverse = mass.Assemble().mat.Inverse(pressures.FreeDofs(), inverse="sparsecholesky")
    calls = ngs.LinearForm(pressures)
    calls += (dilatation(solid, ngs.Id(3) + ngs.Grad(u)) * q).Compile() * volume

    def settle(state: Any) -> None:
        u.vec.data = state.Range(space.Range(0).start, space.Range(0).stop)
        calls.Assemble()
        state.Range(space.Range(1).start, space.Range(1).stop).data = inverse * calls.vec

    return settle
