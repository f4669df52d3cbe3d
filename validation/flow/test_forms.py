"""Forms of the force on a fin against first principles, theory, lattices and measured plates."""

import json
import math
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).parent
FORMS = runpy.run_path(str(HERE / "forms.py"))
TABLE = runpy.run_path(str(HERE / "table.py"))
STEEP = runpy.run_path(str(HERE / "steep.py"))
COMPARED = TABLE["compared"]()  # lattice, theory and forms; see `compared` in table.py
FINITE = [row for row in COMPARED if row[0] < 1e3]  # rows of plates of finite span
PITCHING = [row for row in FINITE if row[2].startswith("pitch")]


def axial_force(depth: Any, s: float, time: float) -> tuple[float, float]:
    """Return Lighthill's axial force per length on a moving straight link, and the part that the depth's slope makes.

    Central differences of the momentum along the axes at rest, and of what a plane across the link passes on.
    """
    step = 1e-5

    def pose(t: float) -> np.ndarray:
        return np.array([0.3 * t + 0.1 * math.sin(t), 0.2 * math.cos(1.3 * t), 0.6 * math.sin(0.9 * t)])

    def state(place: float, t: float) -> tuple[np.ndarray, np.ndarray, float, float]:
        rate = (pose(t + step) - pose(t - step)) / (2 * step)
        angle = pose(t)[2]
        along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        velocity = rate[:2] + rate[2] * place * across
        return along, across, float(velocity @ along), float(velocity @ across)

    def momentum(place: float, t: float) -> np.ndarray:
        _, across, _, v_n = state(place, t)
        return depth(place) * v_n * across

    def passed(place: float, t: float) -> np.ndarray:
        along, across, v_t, v_n = state(place, t)
        return depth(place) * (v_t * v_n * across - v_n**2 / 2 * along)

    force = (passed(s + step, time) - passed(s - step, time)) / (2 * step)
    force -= (momentum(s, time + step) - momentum(s, time - step)) / (2 * step)
    along, _, _, v_n = state(s, time)
    return float(force @ along), -(depth(s + step) - depth(s - step)) / (2 * step) * v_n**2 / 2


def test_a_straight_link_of_constant_depth_bears_no_axial_force() -> None:
    """And one whose depth changes bears -1/2 (d mu/ds) v_n^2: suction where it grows."""
    for s, time in ((0.2, 0.4), (0.7, 1.9), (1.0, 3.3)):
        assert axial_force(lambda s: 2.0, s, time)[0] == pytest.approx(0, abs=1e-5)
        found, depth = axial_force(lambda s: 2.0 + s**2, s, time)
        assert found == pytest.approx(depth, abs=1e-5)
        assert abs(depth) > 1e-3


def test_forms_p_and_quarter_are_theory_of_infinite_span_with_c_of_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Force and moment of Theodorsen with C(k) = 1, whose thrust and power are Garrick's."""
    monkeypatch.setitem(FORMS["response"].__globals__, "deficiency", lambda k: 1.0)
    for k, heave, pitch in ((0.2, 0.1, 0.05j), (0.6, 0.0, 0.1), (1.2, 0.1, -0.03)):
        right = FORMS["response"]("Theodorsen", FORMS["STRIP"], k, heave, pitch)
        for form in ("P", "quarter"):
            found = FORMS["response"](form, FORMS["STRIP"], k, heave, pitch)
            np.testing.assert_allclose(found[:2], right[:2], rtol=1e-12)


def test_theory_of_forms_is_that_of_the_lattice_s_page() -> None:
    """Force and thrust without suction of a plate that heaves and pitches about its leading edge."""
    beat = FORMS["WAKE"]["Beat"](0.6, 0.05, 0.03, math.pi / 3, 0.0)
    lift, thrust, suction = FORMS["WAKE"]["theory"](beat)
    pitch = beat.pitch * np.exp(1j * beat.lead)
    found = FORMS["response"]("Theodorsen", FORMS["STRIP"], 0.6, beat.heave, pitch)
    assert found.force == pytest.approx(lift, rel=1e-9)
    assert FORMS["thrust_and_power"](found, 0.6, beat.heave, pitch)[0] == pytest.approx(thrust - suction, rel=1e-9)


def test_the_lattice_of_infinite_span_has_the_thrust_and_the_power_of_theory() -> None:
    for aspect, k, _, numbers in COMPARED:
        if aspect > 1e3:
            assert numbers["lattice"][0] == pytest.approx(numbers["Theodorsen"][0], rel=0.04, abs=2e-4)
            assert numbers["lattice"][1] == pytest.approx(numbers["Theodorsen"][1], rel=0.02 + 0.02 * k)


def test_thrust_of_the_forms_without_axial_force_is_that_of_the_lattice_but_for_the_memory_of_the_wake() -> None:
    """Scale: thrust of a steady incidence. The law before gives a pitching plate the same thrust at every frequency."""
    for aspect, _, _, numbers in PITCHING:
        steady = next(row["lift"] for row in TABLE["stored"]("forms")["plates"] if row["aspect"] == aspect)
        scale = steady * FORMS["AMPLITUDE"] ** 2 / 2
        for form in ("S", "P", "quarter"):
            assert numbers[form][0] == pytest.approx(numbers["lattice"][0], abs=0.15 * scale)
        assert numbers["before"][0] == pytest.approx(-scale, rel=1e-9)
    assert max(numbers["lattice"][0] for _, _, _, numbers in PITCHING) > 0


def test_power_of_pitch_about_a_hinge_ahead_is_near_the_lattice_s_with_the_lift_near_mid_chord() -> None:
    over = {
        form: np.array([numbers[form][1] / numbers["lattice"][1] for _, _, _, numbers in PITCHING])
        for form in ("S", "P", "quarter")
    }
    assert over["S"].min() > 1.45
    assert np.all((over["P"] > 0.75) & (over["P"] < 1.2))
    assert np.all((over["quarter"] > 1.0) & (over["quarter"] < 1.26))


def test_a_plate_in_still_water_has_lighthill_s_thrust() -> None:
    for row in TABLE["stored"]("forms")["still"]:
        coarse, fine = row["normal"]
        assert 3 * fine - 2 * coarse == pytest.approx(1, abs=0.25)


def test_the_wake_of_form_quarter_takes_a_sum_of_squares() -> None:
    """Work of lift and axial force at random velocities, for every aspect ratio; P's may be zero, not less."""
    random = np.random.default_rng(1)
    for row in TABLE["stored"]("forms")["plates"]:
        part = FORMS["Plate"](row["mass"], row["lift"], 0.0)
        middle, turn = random.normal(size=(2, 1000))
        ratio = part.mass / part.lift
        for lever in (part.lever, ratio - 0.25):
            lift, axial = -part.lift * (middle + turn / 4), -turn * part.mass * middle
            taken = axial - lift * (middle + lever * turn)
            assert taken.min() > -1e-12
        squares = part.lift * (middle**2 + (ratio - 0.25) * turn**2 / 4)
        np.testing.assert_allclose(taken, squares, rtol=1e-9)


def test_lift_that_fades_takes_energy_unless_munk_s_moment_fades_with_it() -> None:
    """With the moment, the wake's energy is H times that without fading; without it, at times negative."""
    random = np.random.default_rng(1)
    row = next(row for row in TABLE["stored"]("forms")["plates"] if row["aspect"] == 5)
    mass, lift_slope = row["mass"], row["lift"]
    lever = mass / lift_slope - 0.25
    middle, turn = random.normal(size=(2, 1000))
    fade = random.uniform(size=1000)
    lift, axial = -lift_slope * (middle + turn / 4), -turn * mass * middle
    alone = axial - fade * lift * (middle + lever * turn)
    both = alone + (1 - fade) * mass * middle * turn
    np.testing.assert_allclose(both, fade * (axial - lift * (middle + lever * turn)), rtol=1e-9, atol=1e-12)
    assert alone.min() < -0.1
    assert both.min() > -1e-12


def test_fading_lift_is_nearer_to_measured_plates_beyond_the_incidence_where_they_stall() -> None:
    """From 20 deg on for aspect ratios of 2 and more, steady and flapping; a flapping wing within a tenth."""
    for series, angle, normal, laws in STEEP["rows"]():
        plain, faded, _ = (abs(each / normal - 1) for each in laws)
        if series["aspect"] >= 2 and angle >= 20:
            assert faded < plain
        if series["series"].startswith("flapping"):
            assert faded < 0.11


def test_attached_flow_has_the_lift_of_the_law_at_small_incidences_and_more_at_large_ones() -> None:
    """It acts near the quarter chord up to 40 deg: where form quarter has it."""
    record = TABLE["stored"]("forms")
    lift = {row["aspect"]: row["lift"] for row in record["plates"]}
    for row in record["steady"]:
        over = row["normal"] / (lift[row["aspect"]] * math.sin(2 * math.radians(row["incidence_deg"])))
        assert over > 1
        if row["incidence_deg"] <= 20:
            assert over < 1.06
        if row["incidence_deg"] <= 40:
            assert row["center"] == pytest.approx(0.25, abs=0.035)


def test_added_inertia_lies_between_that_of_theory_for_infinite_span_and_a_strip_s() -> None:
    coarse, fine = (FORMS["FIN"]["lattice"](5.0, across)[2] for across in (4, 8))
    wide = 2 * fine - coarse
    assert 3 / 8 < wide < 0.45
    coarse, fine = (FORMS["FIN"]["lattice"](0.5, across)[2] for across in (4, 8))
    assert wide < 2 * fine - coarse < 1


def test_every_series_of_measured_plates_has_its_source() -> None:
    for series in json.loads((HERE / "steep.json").read_text()):
        assert len(series["source"]) > 40
        assert len({"lift", "fit"} & series.keys()) == 1
