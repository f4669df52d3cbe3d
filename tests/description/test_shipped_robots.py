"""What the robots say that come with hypertuna: sources, published gaits, estimates that follow from arithmetic."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe

from hypertuna.description.robot import Robot, load, robots
from hypertuna.description.schema.body import NamedGait

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
    speeds = [
        key.removeprefix("speed/")
        for key, entry in values.items()
        if key.startswith("speed/") and entry["unit"] == "m/s"
    ]
    assert len(speeds) == 8
    assert set(speeds) <= set(gaits)
    # Table IV by hand: the gait that was found for the highest speed.
    assert gaits["optimised-max"].frequency == 5.99
    assert np.degrees(gaits["optimised-max"].amplitude) == pytest.approx([15.98, 24.93])
    assert np.degrees(gaits["optimised-max"].phase) == pytest.approx([0, 37.43])


def keulegan_carpenter(robot: Robot, gait: NamedGait, width: float) -> float:
    """KC of the middle of the last link against the head: U T / width, U of the sinusoid of the same mean square."""
    clock = 2 * math.pi * np.arange(256) / 256
    links, along, velocity = len(robot.links.name), 0j, 0j
    angle, rate = np.zeros_like(clock), np.zeros_like(clock)
    for i in range(links):
        for group, amplitude, phase in zip(robot.joints, gait.amplitude, gait.phase, strict=True):
            if i in group.links:
                x = gait.frequency / (group.bandwidth or math.inf)
                swing = amplitude / math.hypot(1, x) / len(group.links)
                angle = angle + swing * np.sin(clock - phase - math.atan(x))
                rate = rate + 2 * math.pi * gait.frequency * swing * np.cos(clock - phase - math.atan(x))
        along = np.exp(1j * angle)
        middle = velocity + 1j * rate * along * robot.links.length[i] / 2
        velocity = velocity + 1j * rate * along * robot.links.length[i]
    across = (np.conj(1j * along) * middle).real
    return math.sqrt(2 * float(np.mean(across**2))) / gait.frequency / width


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

    # The caudal fin: a wing of aspect ratio 5 and the area of Table II; its coefficient beating at the KC of Table IV.
    strip, span = fish.water.strip, math.sqrt(5 * lateral[-1])
    chord = lateral[-1] / span
    assert strip.edge_height == pytest.approx(span, rel=0.002)
    # Of a rectangular plate of aspect ratio 5, validation/flow/fin.py: lift slope 3.95, added mass 0.897 (DNV-RP-C205).
    assert strip.edge_lift == pytest.approx(3.955 / (math.pi / 2 * 5), abs=5e-4)
    added = 0.897 * chord**2 * span
    assert strip.added_mass_normal[-1] == pytest.approx(added / (lateral[-1] ** 2 / length[-1]), abs=5e-4)
    beating = [keulegan_carpenter(fish, gait, chord) for name, gait in fish.gaits.items() if "optimised" in name]
    assert (min(beating), max(beating)) == pytest.approx((7.34, 12.78), rel=0.005)
    graham = 8 * float(np.mean(beating)) ** (-1 / 3)
    assert strip.drag_beating[-1] == pytest.approx(graham - strip.drag_normal[-1], abs=0.05)
    head = math.pi * half_heights[0] ** 2 * ratios[0]
    assert strip.blunt_area[0] / head == pytest.approx(1.14, abs=0.01)

    # Lamb's k1 of a prolate spheroid, on the head alone.
    e = math.sqrt(1 - slenderness**2)
    alpha = 2 * (1 - e**2) / e**3 * (math.atanh(e) - e)
    reference_mass = fish.water.density * math.pi / 4 * lateral[0] ** 2 / length[0]
    expected = alpha / (2 - alpha) * fish.links.mass[0] / reference_mass
    assert fish.water.strip.added_mass_tangential[0] == pytest.approx(expected, rel=0.02)
