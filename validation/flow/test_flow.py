"""Stored coefficients of heaving plates against measured ones, and the solver's parts against closed forms."""

import json
import runpy
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
FIN = runpy.run_path(str(HERE / "fin.py"))
TABLE = runpy.run_path(str(HERE / "table.py"))
ROWS = json.loads((HERE / "oscillating.json").read_text())
PLATES = [row for row in ROWS if row["section"] == "plate" and TABLE["usual"](row)]


@pytest.mark.parametrize("row", PLATES, ids=lambda row: f"KC {row['kc']:g}")
def test_plates_have_the_measured_drag(row: dict[str, float]) -> None:
    """Within 20 % of Graham's fit to measured plates, which is of KC 2 and more; below, it is an extrapolation."""
    assert row["drag_normal"] == pytest.approx(TABLE["graham"](row["kc"]), rel=0.2)


def test_drag_falls_and_added_mass_rises_with_the_travel() -> None:
    """As Keulegan and Carpenter measured; without vortices, both would be those of potential flow: 0 and 1."""
    drag, mass = (np.array([row[key] for row in PLATES]) for key in ("drag_normal", "added_mass_normal"))
    order = np.argsort([row["kc"] for row in PLATES])
    assert len(order) >= 5
    assert np.all(np.diff(drag[order]) < 0)
    assert np.all(np.diff(mass[order]) > 0)
    assert mass[order][0] < 1.4


def test_the_page_is_that_of_the_rows() -> None:
    assert (HERE / "README.md").read_text().endswith(TABLE["tables"]())


@pytest.mark.fe
def test_the_fit_returns_the_coefficients_of_a_force() -> None:
    """A force made of C_n = 5 and C_m = 1.5 comes back, all of its variance explained."""
    flow = runpy.run_path(str(HERE / "oscillating.py"))
    kc, time = 4.0, np.linspace(0, 12, 3001)[1:]
    v, acceleration = np.sin(2 * np.pi * time / kc), 2 * np.pi / kc * np.cos(2 * np.pi * time / kc)
    force = -0.5 * 5 * v * np.abs(v) - 1.5 * np.pi / 4 * acceleration
    found = flow["coefficients"](flow["Flow"](time, force, 0), kc, range(3))
    np.testing.assert_allclose(found, (5, 1.5, 1), rtol=1e-9)


@pytest.mark.fe
def test_an_ellipse_that_starts_has_the_added_mass_of_potential_flow() -> None:
    """Lamb: pi/4 times its height squared at every thickness, while no vortex has formed.

    Water that sticks to the body across half an element is carried along, so that the error goes with the mesh.
    """
    flow = runpy.run_path(str(HERE / "oscillating.py"))
    kc, errors = 4.0, []
    for mesh in ("coarse", "fine"):
        result = flow["flow"]("0.5", kc, mesh=mesh, step=2e-3, reynolds=1e5, cycles=0.005)
        errors.append(-result.force[-1] / (np.pi / 4 * 2 * np.pi / kc) - 1)
    assert errors[0] == pytest.approx(0, abs=0.1)
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.2)


@pytest.mark.parametrize(("aspect", "mass"), [(1.0, 0.579), (2.0, 0.757)])
def test_a_lattice_has_the_added_mass_of_tables(aspect: float, mass: float) -> None:
    """Rectangular plates of DNV-RP-C205, by lattices of 4 and 8 panels along the chord."""
    coarse, fine = (FIN["lattice"](aspect, across)[0] for across in (4, 8))
    assert 2 * fine - coarse == pytest.approx(mass, abs=0.003)


def test_a_lattice_has_the_lift_of_slender_wings_and_of_strips() -> None:
    """Slope pi AR/2 for a small aspect ratio, less than Helmbold's formula for a middle one, which 2 pi bounds."""
    slopes = {aspect: 2 * FIN["lattice"](aspect, 8)[1] - FIN["lattice"](aspect, 4)[1] for aspect in (0.25, 5.0)}
    assert slopes[0.25] == pytest.approx(np.pi / 2 * 0.25, rel=0.01)
    assert slopes[5.0] == pytest.approx(2 * np.pi * 5 / (2 + np.sqrt(29)), rel=0.1)
    assert slopes[5.0] < 2 * np.pi * 5 / (2 + np.sqrt(29))


@pytest.mark.parametrize(("aspect", "law", "tolerance"), [(0.1, 0.0, 0.08), (1.0, 1.0, 0.1), (2.456, 2.456, 0.05)])
def test_side_edges_have_the_suction_of_the_fin_s_law(aspect: float, law: float, tolerance: float) -> None:
    """pi for a slender plate: its flow across is that of a flat plate, pulled by pi rho w^2 a at both edges."""
    suction = 2 * FIN["side_suction"](aspect, 12) - FIN["side_suction"](aspect, 6)
    assert suction == pytest.approx(np.pi / (1 + law / 2), rel=tolerance)
