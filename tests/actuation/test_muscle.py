"""Muscles: stresses summed through the wall, virtual work, closed forms, the printed equations, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.soft_joint import (
    muscle,
)
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from oracles.muscle import BRAID, HOSE, INNER, OUTER, SLEEVE, pull_by_stresses


def unit(sleeve: float = 0.0, hose: tuple[float, float] = HOSE) -> _core.DriveUnit:
    options = {"outer": OUTER, "inner": INNER, "tan2": math.tan(BRAID) ** 2, "sleeve": sleeve, "friction": 0.1}
    return _core.DriveUnit(**options, hose=hose, matrix=SLEEVE)


def pulls(muscle: _core.DriveUnit, stretch: float, pressure: float = 0.0) -> float:
    return float(muscle.at(np.array([stretch]), pressure=pressure)["pull"][0])


@pytest.mark.parametrize("sleeve", [0.0, 1e-3])
@pytest.mark.parametrize("stretch", [0.8, 0.93, 1.0, 1.06, 1.12])
def test_cauchy_stresses_through_the_wall_give_the_same_pull(stretch: float, sleeve: float) -> None:
    got = unit(sleeve).at(np.array([stretch]), pressure=2e5)
    force, carried = pull_by_stresses(stretch, 2e5, sleeve)
    assert got["pull"][0] == pytest.approx(force, abs=1e-10)
    assert got["carried"][0] == pytest.approx(carried, abs=1e-6)  # Pa


def energy_and_lumen(stretch: complex) -> tuple[complex, complex]:
    """Energy and lumen per length at rest, written anew for complex numbers."""
    braid2 = OUTER**2 * (1 / math.cos(BRAID) ** 2 - stretch**2) / math.tan(BRAID) ** 2
    swelling = stretch * braid2 / 4 - OUTER**2 / 4
    nodes, weights = np.polynomial.legendre.leggauss(40)
    x1, x2 = INNER**2 / 4, OUTER**2 / 4
    x = 0.5 * (x2 - x1) * nodes + 0.5 * (x1 + x2)
    l1, l2 = stretch, np.sqrt((1 + swelling / x) / stretch)
    squares = np.array([np.full_like(l2, l1), l2, 1 / (l1 * l2)]) ** 2
    density = HOSE[0] * (squares.sum(axis=0) - 3) + HOSE[1] * ((1 / squares).sum(axis=0) - 3)
    energy = math.pi * 0.5 * (x2 - x1) * (weights @ density)
    return energy, math.pi / 4 * (braid2 * stretch - (OUTER**2 - INNER**2))


@given(stretch=st.floats(0.75, 1.12), pressure=st.floats(-5e4, 5e5))
def test_virtual_work_holds(stretch: float, pressure: float) -> None:
    """Force against dU/dL - P dV/dL by complex steps of energy and volume written anew; 1e-10 of the force's scale."""
    energy, lumen = energy_and_lumen(stretch + 1e-30j)
    got = unit().at(np.array([stretch]), pressure=pressure)
    assert got["energy"][0] == pytest.approx(energy.real, rel=1e-10, abs=1e-15)
    assert got["lumen"][0] == pytest.approx(lumen.real, rel=1e-12, abs=1e-18)
    slopes = energy.imag / 1e-30, lumen.imag / 1e-30
    assert got["energy_slope"][0] == pytest.approx(slopes[0], rel=1e-10, abs=1e-10)
    assert got["pull"][0] == pytest.approx(slopes[0] - pressure * slopes[1], rel=1e-10, abs=1e-10)
    # Pressure against dU/dV: without a pull, the pressure does the work that the walls store.
    free = slopes[0] / slopes[1]
    assert pulls(unit(), stretch, free) == pytest.approx(0, abs=1e-10 * (1 + abs(slopes[0])))


def test_blocked_force_and_free_contraction_have_closed_forms() -> None:
    """At rest the walls pull nothing; without walls the muscle shortens until the braid stands at 54.7 deg."""
    cosine2 = math.cos(BRAID) ** 2
    blocked = 2e5 * math.pi / 4 * OUTER**2 * (3 * cosine2 - 1) / (1 - cosine2)
    assert pulls(unit(), 1.0, 2e5) == pytest.approx(blocked, rel=1e-13)
    assert pulls(unit(), 1.0) == 0
    contraction = 1 - 1 / math.sqrt(3 * cosine2)
    assert brentq(lambda e: pulls(unit(hose=(0.0, 0.0)), 1 - e, 2e5), 0.01, 0.5) == pytest.approx(
        contraction, rel=1e-11
    )
    with_walls = brentq(lambda e: pulls(unit(), 1 - e, 2e5), 0.01, 0.5)
    assert with_walls == pytest.approx(brentq(lambda e: pull_by_stresses(1 - e, 2e5)[0], 0.01, 0.5), rel=1e-10)
    assert with_walls < contraction


@given(stretch=st.floats(0.75, 1.12), pressure=st.floats(1e3, 5e5), factor=st.floats(-2, 3))
def test_the_pull_is_linear_in_the_pressure(stretch: float, pressure: float, factor: float) -> None:
    none, one = pulls(unit(), stretch), pulls(unit(), stretch, pressure)
    assert pulls(unit(), stretch, factor * pressure) == pytest.approx(none + factor * (one - none), rel=1e-9, abs=1e-9)


def pull_as_printed(stretch: float, pressure: float, solid: tuple[float, float]) -> float:
    """Eqs 5-17 of the paper word for word, with L0 = 1, m = 1 strand and no sleeve; L^2 / b^2 read as L^2 / c^2."""
    c1, c2 = solid
    c, n = 1 / math.cos(BRAID), math.tan(BRAID) / (math.pi * OUTER)
    length, theta = stretch, math.acos(stretch / c)
    D_o = c * math.sin(theta) / (n * math.pi)
    V_t = math.pi / 4 * (OUTER**2 - INNER**2)
    V_f = (c**2 * length - length**3) / (4 * math.pi * n**2) - V_t
    D_i = 2 * math.sqrt(V_f / (math.pi * length))
    l1, l2 = length, D_i / INNER
    l3 = 1 / (l1 * l2)
    s33 = -pressure
    s11 = s33 + l2 * l3 * (2 * c1 * (l1**2 - l3**2) - 2 * c2 * (1 / l1**2 - 1 / l3**2))
    s22 = s33 + l1 * l3 * (2 * c1 * (l2**2 - l3**2) - 2 * c2 * (1 / l2**2 - 1 / l3**2))
    P_t = pressure - s22 * (OUTER - INNER) / D_i
    F_c = P_t * D_o * length / (2 * n)
    return F_c / math.tan(theta) - pressure * V_f / length + s11 * V_t / length


@pytest.mark.parametrize("stretch", [0.7, 0.85, 1.0, 1.05])
def test_the_printed_equations_are_kept_word_for_word(stretch: float) -> None:
    got = unit().at(np.array([stretch]), pressure=2e5)["printed_pull"][0]
    assert got == pytest.approx(pull_as_printed(stretch, 2e5, HOSE), rel=1e-12)


UNIT_RULES = {
    "inner_diameter_m": (9e-3, "drive_unit.inner_diameter_m must be less than outer_diameter_m = .*, but is 0.009"),
    "braid_angle_deg": (
        55.0,
        "drive_unit.braid_angle_deg must be less than 54.74, .* but is 55: measure it from the axis",
    ),
    "hose": (
        "DR20",
        "drive_unit.hose must be a material of the table .materials., but is 'DR20': did you mean DR10?",
    ),
}


@pytest.mark.parametrize("key", UNIT_RULES)
def test_a_muscle_that_cannot_be_is_told(tuna: ht.Robot, key: str) -> None:
    value, sentence = UNIT_RULES[key]
    document = tuna.document()
    document["drive_unit"] |= {key: value}
    with pytest.raises(InputError, match=sentence):
        muscle(parse(document))
