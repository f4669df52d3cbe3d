"""Drag of a first robot against handbooks and measured drag, none of it speeds of robots."""

import math

import numpy as np
import pytest

from hypertuna.description.drag import FOLDED, NOSES, STRIDE, beating, blunt_area, friction, swing
from hypertuna.description.new import new_robot, shape_of
from hypertuna.description.shape import Shape, link_columns, link_lengths


def drag_areas(shape: Shape, speed: float) -> dict[str, float]:
    """Return the drag area [m^2] of a shape at a speed [m/s] for each nose, friction included."""
    frequency = speed / (STRIDE * shape.length)
    coefficient = friction(shape, frequency)
    links, _ = link_columns(shape, link_lengths(3, shape.length), coefficient, 0.0)
    wetted = math.fsum(links["wetted_area_m2"])
    return {nose: coefficient * wetted + blunt_area(shape, nose, frequency, wetted) for nose in NOSES}


@pytest.mark.parametrize(
    ("shape", "reynolds", "measured"),
    [
        # Gellman et al. (SICB abstract): coasting bluegills, 0.015 +- 0.007
        (Shape.of(0.16, height=0.06, width=0.024), 41_000, 0.015),
        # Sagong et al. (2013): a sailfish and a swordfish in a wind tunnel, at one length per second
        (Shape.of(2.0, height=0.25, width=0.15), 4e6, 0.0075),
        (Shape.of(2.0, height=0.3, width=0.2), 4e6, 0.0091),
    ],
)
def test_fish_have_the_drag_of_a_streamlined_body(shape: Shape, reynolds: float, measured: float) -> None:
    links, _ = link_columns(shape, link_lengths(3, shape.length), 0.01, 0.0)
    area = drag_areas(shape, reynolds * 1e-6 / shape.length)["streamlined"]
    assert measured / 1.8 < area / math.fsum(links["wetted_area_m2"]) < 1.8 * measured


def test_a_vehicle_with_fins_and_sonar_is_at_the_streamlined_end_of_robots() -> None:
    # REMUS at 3 knots: 27.4 % of the drag are the sonar's, nearly as much as the bare hull's
    shape = Shape.of(1.33, height=0.19, width=0.19)
    areas, section = drag_areas(shape, 1.54), math.pi / 4 * 0.19**2
    measured = (areas["streamlined"] - FOLDED * section) / 0.3
    assert areas["robot"] / NOSES["robot"].factor < measured < areas["robot"]
    assert areas["streamlined"] < measured


def test_real_bodies_of_like_size_differ_by_ten() -> None:
    areas = drag_areas(Shape.of(0.3, 0.85), 0.3)
    low, high = areas["streamlined"], NOSES["blunt"].factor * areas["blunt"]
    assert high / low > 10
    assert areas["robot"] / NOSES["robot"].factor < math.sqrt(low * high) < areas["robot"] * NOSES["robot"].factor


def test_drag_scales_with_the_square_of_the_length_but_for_friction() -> None:
    small, large = (blunt_area(Shape.of(scale, 20 * scale**3), "blunt", 1.0, 0.0) for scale in (0.2, 2.0))
    assert large == pytest.approx(100 * small)
    assert friction(Shape.of(2.0), 1.0) < friction(Shape.of(0.2), 1.0)


def test_the_fin_beats_as_a_plate_of_its_chord_and_amplitude() -> None:
    shape = Shape.of(0.3, fin_span=0.1, fin_chord=0.03)
    keulegan = 9.5
    assert beating(shape, keulegan * 0.03 / (2 * math.pi)) == pytest.approx(8 * 9.5 ** (-1 / 3) - 1.2)
    assert beating(shape, 10.0) == 0  # as far as it swings: the plate of steady flow


def test_a_body_recoils_without_momentum() -> None:
    shape, lengths = shape_of(links=4)
    amplitude, phase = [0.17, 0.26, 0.35], [0.0, 0.5, 1.0]
    swung = swing(shape, lengths, amplitude, phase)
    assert swing(shape, lengths, [2 * a for a in amplitude], [p + 1 for p in phase]) == pytest.approx(2 * swung)
    joints = zip(amplitude, phase, np.cumsum(lengths[:-1]), strict=True)
    bent = abs(sum(a * np.exp(-1j * p) * (0.925 * 0.3 - at) for a, p, at in joints))
    assert 0.2 * bent < swung < 0.8 * bent  # a heavy fin would stay behind, a light one follow
    assert swing(shape, lengths, [0.0] * 3, phase) == 0


@pytest.mark.parametrize("nose", NOSES)
def test_the_words_of_a_nose_choose_the_drag_area_its_source_and_its_factor(nose: str) -> None:
    document = new_robot("fish", nose=nose)
    key = "water.strip.blunt_area_m2"
    assert document["uncertainty"][key] == NOSES[nose].factor
    assert NOSES[nose].reason in document["sources"][key]
    area = document["water"]["strip"]["blunt_area_m2"]
    assert area[1:] == [0.0, 0.0]
    assert area[0] > 0


def test_the_recoil_of_a_beat_has_neither_momentum_nor_spin() -> None:
    """One joint in the middle: head and tail recoil as a line that balances the bending by mass and added mass."""
    shape, lengths = shape_of(lengths=(0.2, 0.2))
    x, height, width = shape.sections(0.0, 0.4)
    area = np.where(x < shape.fin_start * 0.4, math.pi / 4, 1.0) * height * width  # ellipses, and a plate for the fin
    mass = area + math.pi / 4 * height**2
    bend = 0.3 * np.maximum(x - 0.2, 0.0)
    rows = np.array([[mass.sum(), (mass * x).sum()], [(mass * x).sum(), (mass * x**2).sum()]])
    shift, turn = np.linalg.solve(rows, [(mass * bend).sum(), (mass * x * bend).sum()])
    middle = np.searchsorted(x, (1 + shape.fin_start) / 2 * 0.4)  # of the fin
    assert swing(shape, lengths, [0.3], [0.7]) == pytest.approx(abs(bend - shift - turn * x)[middle])
