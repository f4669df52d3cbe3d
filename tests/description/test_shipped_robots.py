"""What the robots say that come with hypertuna: sources, published gaits, estimates that follow from arithmetic."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe

from hypertuna.description.robot import load, robots

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", robots())
def test_every_number_of_a_shipped_robot_has_a_source(name: str) -> None:
    robot = load(name)
    assert robot.unsourced() == ()
    assert robot.name == name
    assert robot.file == f"robots/{name}.toml"


def test_every_published_speed_is_that_of_a_gait_of_hypertuna() -> None:
    values = tomllib.loads((ROOT / "data" / "published" / "published.toml").read_text())["values"]
    gaits = load("hypertuna").gaits
    speeds = [key.removeprefix("speed/") for key, entry in values.items() if entry["unit"] == "m/s"]
    assert len(speeds) == 8
    assert set(speeds) <= set(gaits)
    # Table IV by hand: the gait that was found for the highest speed.
    assert gaits["optimised-max"].frequency == 5.99
    assert np.degrees(gaits["optimised-max"].amplitude) == pytest.approx([15.98, 24.93])
    assert np.degrees(gaits["optimised-max"].phase) == pytest.approx([0, 37.43])


def ittc(speed: float, length: float) -> float:
    """ITTC 1957 friction line in water of 20 C."""
    return 0.075 / (math.log10(speed * length / 1.004e-6) - 2) ** 2


def test_estimates_follow_from_their_arithmetic() -> None:
    fish, eel = load("hypertuna"), load("rexeel-theory")
    assert fish.water.strip is not None
    assert eel.water.strip is not None

    # Sections as ellipses: height from the lateral area, width from the perimeter (the head's ten times as printed).
    length, lateral, wetted = (np.array(getattr(fish.links, key)) for key in ("length", "lateral_area", "wetted_area"))
    wetted[0] *= 10
    half_heights, perimeters = lateral / length / 2, wetted / length
    ratios = [
        brentq(lambda ratio, a=a, p=p: 4 * a * ellipe(1 - ratio**2) - p, 0, 1)
        for a, p in zip(half_heights[:-1], perimeters[:-1], strict=True)
    ]
    density = np.array(fish.links.mass[:-1]) / (np.pi * half_heights[:-1] ** 2 * ratios * length[:-1])
    assert density == pytest.approx(np.full(7, 960), abs=55)
    assert fish.water.strip.drag_normal[:-1] == pytest.approx(1.98 - 0.78 * np.array(ratios), abs=0.006)

    slenderness = 2 * half_heights[0] * math.sqrt(ratios[0]) / fish.body.length
    friction = ittc(0.56, fish.body.length) * (1 + 1.5 * slenderness**1.5 + 7 * slenderness**3)
    assert fish.water.strip.drag_tangential == pytest.approx([10 * friction] + [friction] * 7, rel=0.01)
    assert eel.water.strip.drag_tangential == pytest.approx(
        [ittc(math.sqrt(0.05 * 0.16), eel.body.length)] * 6, rel=0.02
    )

    # Lamb's k1 of a prolate spheroid, on the head alone.
    e = math.sqrt(1 - slenderness**2)
    alpha = 2 * (1 - e**2) / e**3 * (math.atanh(e) - e)
    reference_mass = fish.water.density * math.pi / 4 * lateral[0] ** 2 / length[0]
    expected = alpha / (2 - alpha) * fish.links.mass[0] / reference_mass
    assert fish.water.strip.added_mass_tangential[0] == pytest.approx(expected, rel=0.02)
