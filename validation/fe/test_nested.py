"""Nested spaces of displacements: one curved body on all levels, states taken over whole, the index by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from nested import convergence, finer, take_over

import hypertuna as ht
from hypertuna.description.changes import changed
from hypertuna.fe.mesh import MeshSize
from hypertuna.fe.model import FeModel, FeOptions, equilibrium, fe_model

SMALL = MeshSize(0.8, largest=6.0, order=3, pieces=3.0)


def test_a_power_law_gives_its_order_and_its_limit() -> None:
    """Halved element sizes: errors of 0.16, 0.04, 0.01 have order 2 and limit 1; the index is 1.25 times the last."""
    found = convergence([1000, 8000, 64000], [0.84, 0.96, 0.99])
    assert found is not None
    assert found["order"] == pytest.approx(2)
    assert found["limit"] == pytest.approx(1)
    assert found["index_percent"] == pytest.approx(100 * 1.25 * 0.01 / 0.99)


@pytest.mark.parametrize("values", [[0.84, 0.96, 0.95], [0.9, 0.91, 0.93], [1.0, 1.0, 1.0]])
def test_values_that_turn_spread_or_stand_still_have_no_limit(values: list[float]) -> None:
    assert convergence([1000, 8000, 64000], values) is None


def volume(model: FeModel) -> float:
    """Volume of the matrix [m^3], by a quadrature that is exact for curved elements of the third order."""
    import ngsolve as ngs

    return float(ngs.Integrate(ngs.CF(1.0) * ngs.dx("matrix", bonus_intorder=8), model.mesh))


@pytest.mark.fe
def test_finer_levels_have_the_same_body_and_hold_the_coarser_state() -> None:
    import ngsolve as ngs

    base = fe_model(ht.load("hypertuna"), "II", FeOptions(mesh=SMALL))
    assert equilibrium(base, pressure=(20e3, 0.0)).converged
    square = ngs.InnerProduct(base.displacement, base.displacement) * ngs.dx(bonus_intorder=8)
    before = ngs.Integrate(square, base.mesh)
    for order, bisections in ((3, 1), (4, 0)):
        model = finer(base, order, bisections)
        assert model.mesh.ne >= base.mesh.ne * (2 if bisections else 1)
        assert volume(model) == pytest.approx(volume(base), rel=1e-10)
        take_over(model, base)
        assert model.problem.loads[0].Get() == 20e3
        square = ngs.InnerProduct(model.displacement, model.displacement) * ngs.dx(bonus_intorder=8)
        assert ngs.Integrate(square, model.mesh) == pytest.approx(before, rel=1e-8)


@pytest.mark.fe
@pytest.mark.parametrize(("order", "curve", "free"), [(3, 3, True), (4, 3, True), (3, 4, False)])
def test_only_displacements_of_the_order_of_the_curve_can_rotate(order: int, curve: int, free: bool) -> None:
    """A quarter turn about z costs no energy: none to speak of beside that of a kilopascal in the whole volume."""
    import ngsolve as ngs

    size = replace(SMALL, order=order, curve=curve)
    free_axis = changed(ht.load("hypertuna"), {"joints.actuator.axis_stiffness_n": 1e-9})  # what lies there has angles
    model = fe_model(free_axis, "II", FeOptions(mesh=size))
    model.displacement.Set(ngs.CF((-ngs.x - ngs.y, ngs.x - ngs.y, 0)))
    energy = float(model.problem.energy.Energy(model.displacement.vec))
    assert math.isfinite(energy)
    assert (abs(energy) < 1e-6 * 1e3 * volume(model)) == free
