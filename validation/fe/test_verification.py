"""Finite elements beside theory: McKibben tubes, cubes, a clamped beam, hoses, local volume; slopes of the energies."""

from __future__ import annotations

import json
import math
from typing import Any

import fe_blocks
import numpy as np
import pytest
import validate as fe_validate
from fe_blocks import closed_form, cube_stress
from fe_cases import ANGLES, SLACK, Case, beam_cases, cube_cases, hose_cases, muscle_cases, sleeve_cases
from fe_tube import ideal_pull, ideal_stretch, load, pull, sleeve_pull, tube
from volume import volume_kept

import hypertuna as ht
from hypertuna.actuation.silicone import Mooney
from hypertuna.fe.energies import LAWS, Solid, Wall, solid_energy
from hypertuna.fe.model import FeOptions, equilibrium, fe_model
from hypertuna.fe.newton import Equilibrium, lead

ROBOT = ht.load("hypertuna")
SILICONE = Mooney(10e3, 3e3)
BRAID = Wall(4e-3, 2.8e-3, Mooney(0.0, 0.0), math.radians(35), 1e8, SLACK)


def test_braid_alone_pulls_nothing_at_the_neutral_angle() -> None:
    assert ideal_pull(250e3, 4e-3, math.acos(math.sqrt(1 / 3))) == pytest.approx(0.0, abs=1e-12)
    angle = math.radians(35)
    assert ideal_stretch(angle) * math.cos(angle) == pytest.approx(math.sqrt(1 / 3))  # free: the braid stands there
    assert ideal_stretch(angle, 1.0) == pytest.approx(1.0)
    half = ideal_pull(1.0, 1.0, angle, ideal_stretch(angle, 0.5))
    assert half == pytest.approx(0.5 * ideal_pull(1.0, 1.0, angle))


@pytest.mark.fe
@pytest.mark.parametrize("angle", ANGLES)
def test_braid_alone_pulls_and_contracts_as_theory_says(angle: float) -> None:
    blocked, half, free = muscle_cases(ROBOT, math.radians(angle), hose=False)
    assert abs(blocked.difference) < 1e-3
    assert abs(half.difference) < 1e-3
    assert abs(free.difference) < 1e-3
    assert not blocked.text + half.text + free.text
    assert (free.computed > half.computed > 0) == (angle < 54.7)  # beyond, it gets longer


@pytest.mark.fe
def test_hose_and_sleeve_are_those_of_the_core() -> None:
    hose = list(muscle_cases(ROBOT, math.radians(35), hose=True))
    alone = list(muscle_cases(ROBOT, math.radians(35), hose=False))
    sleeve = list(sleeve_cases(ROBOT))
    assert max(abs(case.difference) for case in (*hose, *sleeve)) < 1e-3
    assert hose[-1].computed < alone[-1].computed - 0.01  # the hose resists


@pytest.mark.fe
def test_what_carries_the_wall_adds_nothing() -> None:
    free = tube(BRAID, thickness=1e-3)
    load(free, 250e3)
    blocked = ideal_pull(250e3, BRAID.outer, BRAID.braid_angle)
    assert abs(sleeve_pull(free)) < 1e-5 * blocked
    assert free.stretch == pytest.approx(ideal_stretch(BRAID.braid_angle), rel=1e-3)


@pytest.mark.fe
def test_fibers_that_stretch_pull_less() -> None:
    """With fibers of k the force is off by about P R / (k sin^2 theta), and four times less with four times the k."""
    ideal = ideal_pull(250e3, BRAID.outer, BRAID.braid_angle)
    lost = []
    for stiffness in (1e6, 4e6):
        held = tube(Wall(4e-3, 2.8e-3, SILICONE, BRAID.braid_angle, stiffness, SLACK), thickness=1e-3, held=True)
        assert load(held, 250e3).converged
        lost.append(1 - pull(held) / ideal)
    assert 0.002 < lost[0] < 0.01
    assert lost[0] / lost[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.fe
def test_energy_slope_and_tangent_of_a_tube_agree_with_differences() -> None:
    inflated = tube(
        Wall(4e-3, 2.8e-3, SILICONE, math.radians(35), 1e6), Solid("mooney_rivlin", SILICONE, 0.49), thickness=1e-3
    )
    load(inflated, 100e3, 2.0)
    energy, state = inflated.problem.energy, inflated.problem.state.vec
    way, slope, after, tangent, moved = (state.CreateVector() for _ in range(5))
    way.SetRandom(1)
    size, free = 1e-7 / float(way.Norm()), inflated.problem.free
    for number in range(len(free)):
        if not free[number]:
            way[number] = 0.0
    moved.data = state + 3e-2 * size * way  # off the equilibrium, where the slope is not 0
    state.data = moved

    def at(part: float) -> Any:
        moved.data = state + part * size * way
        return moved

    rise = (energy.Energy(at(1.0)) - energy.Energy(at(-1.0))) / 2
    energy.Apply(state, slope)
    assert size * slope.InnerProduct(way) == pytest.approx(rise, rel=1e-3, abs=1e-16)
    energy.AssembleLinearization(state)
    tangent.data = size * energy.mat * way
    energy.Apply(at(1.0), slope)
    energy.Apply(at(-1.0), after)
    slope.data = 0.5 * slope - 0.5 * after - tangent
    assert slope.Norm() < 1e-3 * tangent.Norm()


@pytest.mark.fe
def test_cubes_strain_as_closed_forms_say() -> None:
    cases = list(cube_cases(ROBOT))
    assert len(cases) == 3 * len(LAWS)
    assert all(case.passed for case in cases)
    exact = [case for case in cases if case.group.endswith("linear") or case.name.startswith("shear")]
    assert max(abs(case.difference) for case in exact) < 1e-8  # what Newton leaves: no limit is taken here


@pytest.mark.fe
@pytest.mark.parametrize("law", LAWS)
def test_laws_share_their_moduli_at_rest(law: str) -> None:
    solid, small = Solid(law, SILICONE, 0.475), 1e-6
    young = 2 * solid.shear * 1.475
    assert solid.shear == pytest.approx(26e3)
    assert cube_stress(solid, "uniaxial", small)[0] / small == pytest.approx(young, rel=1e-4)
    assert cube_stress(solid, "biaxial", small)[0] / small == pytest.approx(young / (1 - 0.475), rel=1e-4)
    assert cube_stress(solid, "shear", small)[0] / small == pytest.approx(solid.shear, rel=1e-6)
    assert closed_form(solid, "shear", small) / small == pytest.approx(solid.shear, rel=1e-6)


@pytest.mark.fe
@pytest.mark.parametrize("law", LAWS)
def test_energy_does_not_see_a_rotation(law: str) -> None:
    import ngsolve as ngs
    from netgen.occ import Box, OCCGeometry

    mesh = ngs.Mesh(OCCGeometry(Box((0, 0, 0), (1, 1, 1))).GenerateMesh(maxh=2.0, parallel_meshing=False))
    F = np.array([[1.2, 0.3, 0.0], [-0.1, 0.9, 0.2], [0.1, 0.0, 1.05]])
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn = turn * np.linalg.det(turn)
    one, two = (
        float(solid_energy(Solid(law, SILICONE, 0.49), ngs.CF(tuple(G.ravel()), dims=(3, 3)))(mesh(0.3, 0.3, 0.3)))
        for G in (F, turn @ F)
    )
    assert one > 0
    assert two == pytest.approx(one, rel=1e-10)


@pytest.mark.fe
def test_beam_of_order_1_locks_and_others_bend_as_timoshenko_says() -> None:
    cases = list(beam_cases(ROBOT))
    assert all(case.passed for case in cases)
    soft, stiff = cases[: len(cases) // 2], cases[len(cases) // 2 :]
    assert [case.name for case in soft] == [case.name for case in stiff]
    lost = [a.computed / b.computed - 1 for a, b in zip(soft, stiff, strict=True)]
    assert lost[0] > 1.0  # order 1: less than half is left at nu = 0.499
    assert lost[0] > lost[2] > lost[3] > lost[4] > 0  # order 1, 2, 3, 4: less and less of nu is to be seen
    assert lost[4] < 0.003


@pytest.mark.fe
def test_a_beam_whose_force_is_not_reached_is_a_failed_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fe_blocks, "lead", lambda problem, loads: Equilibrium(False, 3, "the tangent is singular"))
    case = next(beam_cases(ROBOT))
    assert case.text == "the tangent is singular"
    assert not case.passed  # although an element of order 1 need not sag as far as theory says


@pytest.mark.fe
@pytest.mark.parametrize(
    ("poisson", "not_kept", "low", "high"),
    # By volume: at 0.475 the bulk modulus is twenty times the shear modulus only, and silicone at hoses yields.
    [(0.475, 0.3, 0.97, 1.02), (0.499, 0.02, 0.98, 1.02)],
)
def test_the_volume_is_kept_away_from_the_ends(poisson: float, not_kept: float, low: float, high: float) -> None:
    """J within 2 % of 1 farther than a hose's diameter from the plates; the largest differences are at the hoses."""
    model = fe_model(ht.load("hypertuna"), "II", FeOptions(mesh="coarse", poisson=poisson))
    assert equilibrium(model, pressure=(50e3, 0.0)).converged
    found = volume_kept(model)
    assert found["not_kept_percent"] < not_kept
    assert low < found["low"] < found["high"] < high  # of all but a thousandth at either end
    assert 0.8 < found["min"] < found["max"] < 1.1  # at single points; 0.6 to 1.25 with a pressure of the order 1
    assert found["at_hose"] < 1.2  # radii from the axis


@pytest.mark.fe
def test_a_hose_of_solid_elements_is_the_wall_of_the_joints_model() -> None:
    cases = list(hose_cases(ROBOT))
    assert len(cases) == 4
    assert max(abs(case.difference) for case in cases) < 3e-3
    assert not any(case.text for case in cases)


@pytest.mark.fe
def test_loads_that_are_not_reached_are_told() -> None:
    held = tube(BRAID, thickness=1e-3, held=True)
    found = lead(held.problem, (math.nan, 0.0))
    assert not found.converged
    assert "0 % of the way" in found.text


CASES = (
    Case("Tube", "pull", 10.02, 10.0, "N", 0.003),
    Case("Beam", "order 1", 1.0, 10.0, "mm", 0.5, locks=True),
)


def test_cases_pass_as_they_must() -> None:
    assert [case.passed for case in CASES] == [True, True]
    assert CASES[0].difference == pytest.approx(0.002)
    assert not Case("Tube", "pull", 10.04, 10.0, "N", 0.003).passed
    assert not Case("Beam", "order 1", 9.9, 10.0, "mm", 0.5, locks=True).passed  # that does not lock
    assert not Case("Tube", "pull", 10.0, 10.0, "N", 0.003, text="no step lowers the energy").passed


@pytest.mark.fe
def test_script_prints_the_cases_and_fails_with_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cases = list(CASES)
    monkeypatch.setattr(fe_validate, "validate", lambda robot: tuple(cases))
    assert fe_validate.main(["--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["robot"] == "hypertuna"
    assert [case["passed"] for case in record["cases"]] == [True, True]
    assert record["cases"][0]["difference"] == pytest.approx(0.002)
    assert fe_validate.main([]) == 0
    text = capsys.readouterr().out
    assert "all 2 cases agree" in text
    assert "over 50" in text
    cases.append(Case("Tube", "free", 0.2, 0.3, "1", 0.01, text="no step lowers the energy"))
    assert fe_validate.main([]) == 1
    text = capsys.readouterr().out
    assert "1 of 3 cases disagree" in text
    assert "NO no step" in text.replace("\n", " ")
    assert fe_validate.main(["--robot", "nobody"]) == 2
