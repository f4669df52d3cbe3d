"""What holds an axis: buckling in silicone against closed forms, an integral equation and a strip in pieces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import k0

import hypertuna as ht
from hypertuna.actuation.axis import AxisMember, buckling_load, film, held_compression, pipe
from hypertuna.actuation.soft_joint import joint_models
from hypertuna.description.robot import parse
from hypertuna.errors import InputError

SILICONE = 80e3  # Pa
G = SILICONE / 3


def strip_in_pieces(bending: float, foundation: float, length: float, pieces: int = 600) -> float:
    """Buckling load of a strip with pinned ends on springs, from the stiffness matrices of its pieces."""
    step = length / pieces
    second = (np.diag(np.full(pieces - 1, 2.0)) - np.eye(pieces - 1, k=1) - np.eye(pieces - 1, k=-1)) / step**2
    return float(
        eigh(bending * second @ second + foundation * np.eye(pieces - 1), second, subset_by_index=[0, 0])[0][0]
    )


@pytest.mark.parametrize(("bending", "foundation"), [(2.6e-6, 4.7e5), (0.01, 1.4e5)])
def test_a_strip_on_an_elastic_foundation_buckles_at_twice_the_root_of_k_times_ei(
    bending: float, foundation: float
) -> None:
    load, wave = buckling_load(bending, lambda _: foundation)
    assert load == pytest.approx(2 * math.sqrt(foundation * bending), rel=1e-9)
    assert wave == pytest.approx((foundation / bending) ** 0.25, rel=1e-3)
    assert strip_in_pieces(bending, foundation, 12.3 * 2 * math.pi / wave) == pytest.approx(load, rel=5e-3)


@pytest.mark.parametrize(
    "member", [film(6.35e-3, 0.125e-3, 2.5e9, SILICONE), film(6.35e-3, 0.43e-3, 4.9e9, SILICONE)], ids=["thin", "thick"]
)
def test_a_film_buckles_as_its_pieces_do_on_the_foundation_of_its_waves(member: AxisMember) -> None:
    pieces = strip_in_pieces(member.bending, member.foundation, 12 * member.wavelength)
    assert member.buckling == pytest.approx(pieces, rel=0.05)  # the foundation changes with the waves


def test_a_film_wider_than_its_waves_lies_between_two_half_spaces() -> None:
    """Their surfaces resist with 2 G q each, so that E I q^2 + 4 G b / q is least at q^3 = 2 G b / (E I)."""
    found = film(0.2, 0.1e-3, 2.5e9, SILICONE)
    wave = (2 * G * 0.2 / found.bending) ** (1 / 3)
    assert found.wavelength == pytest.approx(2 * math.pi / wave, rel=0.02)
    assert found.buckling == pytest.approx(3 * found.bending * wave**2, rel=0.02)


def test_even_pressure_on_a_film_comes_close_to_that_of_a_stiff_one() -> None:
    """A stiff film moves as a whole: its pressure p solves int K0(q |z - s|) p(s) ds = 4 pi G, here in 400 pieces."""
    found, width = film(6.35e-3, 0.43e-3, 4.9e9, SILICONE), 6.35e-3
    wave, edges = 2 * math.pi / found.wavelength, -width / 2 * np.cos(np.linspace(0, math.pi, 401))
    middle, size = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
    with np.errstate(divide="ignore"):
        kernel = k0(wave * np.abs(middle[:, None] - middle)) * size
    near = wave * size / 4  # the mean of K0 over a small piece around its middle, with K0(x) = ln(2 / x) - 0.5772
    np.fill_diagonal(kernel, size * (1 - np.log(near) - np.euler_gamma))
    exact = float(np.linalg.solve(kernel, np.full(400, 4 * math.pi * G)) @ size)
    assert 0.94 * exact < found.foundation < exact


def test_silicone_resists_a_thin_pipe_as_oil_resists_a_wire() -> None:
    """Lamb's cylinder in slow flow: 4 pi G over ln(2 / (q a)) - 0.5772 + 1/2, a the radius."""
    found = pipe(0.2e-3, 0.0, 200e9, SILICONE)
    qa = 2 * math.pi / found.wavelength * 0.1e-3
    assert qa < 0.03
    assert found.foundation == pytest.approx(4 * math.pi * G / (math.log(2 / qa) - np.euler_gamma + 0.5), rel=1e-3)
    assert found.stiffness == pytest.approx(200e9 * math.pi * 0.1e-3**2)
    assert found.bending == pytest.approx(200e9 * math.pi / 64 * 0.2e-3**4)


def test_a_held_axis_carries_what_the_muscles_pull() -> None:
    fish = ht.load("hypertuna")
    pressures = [[100e3, 0.0], [250e3, 0.0], [250e3, 250e3]]
    one, both = held_compression(fish, "II", pressures)[1:]
    assert 0 < one < both
    document = fish.document()
    document["joints"][1]["actuator"] |= {"axis_stiffness_n": 1e4, "axis_buckling_n": 0.9 * both}
    model = joint_models(parse(document))[1]
    strain = model["rest"] + model.balance(pressures[1:])["strain"]
    assert strain[0] == pytest.approx(-one / 1e4, rel=0.1)  # holds
    assert strain[1] < -1.2 * both / 1e4  # has buckled


@pytest.mark.parametrize("thickness", [0.0, -1e-4, math.nan])
def test_a_film_needs_a_thickness(thickness: float) -> None:
    with pytest.raises(InputError, match="thickness must be"):
        film(6e-3, thickness, 5e9, SILICONE)


def test_the_bore_of_a_pipe_is_less_than_its_outer_diameter() -> None:
    with pytest.raises(InputError, match=r"inner must be less than outer, but is 0\.006 m"):
        pipe(4e-3, 6e-3, 5e9, SILICONE)
