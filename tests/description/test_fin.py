"""Caudal fins of another span and chord: what of the links and of the water follows them."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.description.design import designed, variable
from hypertuna.description.fin import _pieces
from hypertuna.description.new import new_robot
from hypertuna.description.robot import Robot, parse
from hypertuna.description.schema.water import helmbold, plate_mass
from hypertuna.errors import InputError
from hypertuna.swimming.designs import beat_features


def test_a_fin_of_its_own_is_exchanged_within_its_link(tuna: Robot) -> None:
    """What the link has beside the plate stays; drag and friction follow the areas, the drag of beating KC^(-1/3)."""
    span, chord = 0.160 * 1.1, 0.032 * 0.9
    strip, lateral = tuna.water.strip, tuna.links.lateral_area[7] + span * chord - 0.160 * 0.032
    assert strip is not None
    kappa = 0.897 * plate_mass(span / chord) / plate_mass(5.0)
    plates = kappa * chord**2 * span - 0.897 * 0.032**2 * 0.160
    across = (strip.added_mass_normal[7] * tuna.links.lateral_area[7] ** 2 / 0.089 + plates) * 0.089 / lateral**2
    lumped = tuna.document()["water"]["lumped"]["added_mass"]
    lumped[7] *= kappa * chord**2 * span / (0.897 * 0.032**2 * 0.160)
    document = tuna.document()
    for key, ratio in (("lateral_area_m2", 1), ("wetted_area_m2", 1)):
        document["links"][key][7] *= lateral / tuna.links.lateral_area[7] * ratio
    document["spatial"]["height_m"][7] *= lateral / tuna.links.lateral_area[7]
    document["water"]["lumped"]["added_mass"] = lumped
    document["water"]["strip"]["added_mass_normal"][7] = across
    document["water"]["strip"] |= {
        "edge_height_m": span,
        "edge_aspect": span / chord,
        "edge_added_mass": kappa,
        "edge_lift": 0.504 * helmbold(span / chord) / helmbold(5.0),
    }
    own = 2.6 * tuna.links.lateral_area[7] / (0.160 * 0.032)  # the plate's, of which the link has the mean
    document["water"]["strip"]["drag_beating"][7] = span * chord / lateral * ((own + 1.2) * 0.9 ** (1 / 3) - 1.2)
    by_hand = parse(document)
    pairs = ({"fin.span": 1.1, "fin.chord": 0.9}, {"fin.area": 0.99, "fin.aspect_ratio": 1.1 / 0.9})
    for water in ("strip", "lumped", "elongated"):
        expected = beat_features(by_hand.using(water=water))
        for pair in pairs:
            robot = tuna.using(water=water)
            design = [variable(robot, key, 0.8, 1.25) for key in pair]
            found = designed(robot, design, tuple(pair.values()))
            np.testing.assert_allclose(beat_features(found), expected, rtol=1e-12)


def test_a_last_link_that_is_the_fin_changes_as_a_whole() -> None:
    """An eel's: heights by the span, the length and all that follows it by the chord."""
    eel = ht.load("rexeel")
    last = len(eel.links.name) - 1
    design = [variable(eel, f"fin.{kind}", 0.5, 1.5) for kind in ("span", "chord")]
    found = designed(eel, design, (1.2, 0.9))
    assert found.links.length[last] == pytest.approx(0.9 * eel.links.length[last], rel=1e-14)
    assert found.links.lateral_area[last] == pytest.approx(1.2 * 0.9 * eel.links.lateral_area[last], rel=1e-14)
    assert found.links.com[last] == pytest.approx(0.9 * eel.links.com[last], rel=1e-14)
    assert found.body.length == pytest.approx(eel.body.length - 0.1 * eel.links.length[last], rel=1e-14)
    assert found.links.mass == eel.links.mass


def test_the_drag_of_beating_follows_the_chord_in_a_fin_s_part_of_its_link() -> None:
    """Half of the last link is fin: it alone has 8 KC^(-1/3) - 1.2 more, and a longer span a greater part."""
    document = new_robot("x", links=3, length=0.3, mass=0.85)
    robot, last = parse(document), 2
    strip = robot.water.strip
    assert strip is not None
    chord, area = strip.edge_height / strip.edge_aspect, robot.links.lateral_area[last]
    part = chord * strip.edge_height / area
    assert 0.3 < part < 0.9
    own = strip.drag_beating[last] / part
    for span, ratio in ((1.0, 1.0), (1.3, 1.0), (1.0, 0.8), (1.2, 1.1)):
        design = [variable(robot, f"fin.{kind}", 0.5, 1.5) for kind in ("span", "chord")]
        found = designed(robot, design, (span, ratio)).water.strip
        plate = span * ratio * part * area
        wanted = plate / (area + plate - part * area) * ((own + 1.2) * ratio ** (1 / 3) - 1.2)
        assert found is not None
        assert found.drag_beating[last] == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("links", [7, 9, 13])
def test_a_fin_over_several_links_is_that_of_a_new_robot(links: int) -> None:
    """Its area and added mass are those of one made with this fin, and it swims so; no link changes its length."""
    sizes: Any = {"links": links, "length": 0.3, "mass": 0.4}
    robot = parse(tomllib.loads(first_robot("x", **sizes)))
    strip, gait = robot.water.strip, ht.named_gait(robot, "cruise")
    assert strip is not None
    span, chord = strip.edge_height, strip.edge_height / strip.edge_aspect
    assert chord > robot.links.length[-1]

    def sums(fish: Robot) -> tuple[float, float]:
        """Lateral area [m^2], and added mass across over rho pi/4 [m^3]."""
        water, parts = fish.water.strip, fish.links
        assert water is not None
        across = zip(water.added_mass_normal, parts.lateral_area, parts.length, strict=True)
        return sum(parts.lateral_area), sum(c * area**2 / length for c, area, length in across)

    for higher, longer in ((1.0, 0.6), (1.0, 0.8), (1.0, 1.2), (0.8, 1.0), (1.2, 1.1)):
        design = [variable(robot, f"fin.{kind}", 0.6, 1.2) for kind in ("span", "chord")]
        found = designed(robot, design, (higher, longer))
        made = parse(tomllib.loads(first_robot("x", **sizes, fin_span=higher * span, fin_chord=longer * chord)))
        assert found.links.length == robot.links.length
        assert sums(found) == pytest.approx(sums(made), rel=0.05)
        assert ht.swim(found, gait).speed == pytest.approx(ht.swim(made, gait).speed, rel=0.06)
    same = designed(robot, design, (1.0 + 1e-9, 1.0))
    assert same.links.lateral_area == pytest.approx(robot.links.lateral_area, rel=1e-8)
    assert same.water.strip is not None
    assert same.water.strip.added_mass_normal == pytest.approx(strip.added_mass_normal, rel=1e-8)
    assert same.water.strip.drag_beating == pytest.approx(strip.drag_beating, rel=1e-8)


@pytest.mark.parametrize("kind", ["span", "chord"])
@pytest.mark.parametrize("links", [9, 13])
def test_a_fin_over_several_links_changes_without_jumps(links: int, kind: str) -> None:
    """A step of 0.1 % of a size changes no sum over the links by more than 0.3 %; just below 1 drag fell by a tenth."""
    robot = parse(tomllib.loads(first_robot("x", links=links, length=0.3, mass=0.4)))
    one, rows = variable(robot, f"fin.{kind}", 0.7, 1.2), []
    for factor in np.arange(0.75, 1.15, 1e-3):
        fish = designed(robot, (one,), (factor,))
        water, parts = fish.water.strip, fish.links
        assert water is not None
        area, mass = np.array(parts.lateral_area), np.array(water.added_mass_normal)
        rows.append([area.sum(), mass @ (area**2 / parts.length), area @ water.drag_beating])
    assert np.abs(np.diff(np.log(rows), axis=0)).max() < 3e-3


def test_a_fin_that_would_reach_the_head_is_refused() -> None:
    robot = parse(tomllib.loads(first_robot("x", links=13, length=0.3, mass=0.4)))
    with pytest.raises(InputError, match="the fin must end behind the head"):
        variable(robot, "fin.chord", 1.0, 6.0)


def test_the_links_are_cut_where_the_fin_s_area_begins() -> None:
    """Of 0.026 m^2 the last link has 0.02; the next one, half wide and half narrow, gives 0.04 m of its 0.1."""
    links = {"length_m": [0.2, 0.1, 0.1], "lateral_area_m2": [0.02, 0.01, 0.02]}
    document = {"links": links, "water": {"strip": {"added_mass_normal": [1.0, 1.0, 1.0]}}}
    pieces = _pieces(document, 0.026)
    assert pieces.fin == 2
    np.testing.assert_allclose(pieces.ends, [0.0, 0.1, 0.16, 0.2, 0.4])
    np.testing.assert_allclose(pieces.height, [0.2, 0.1, 0.1, 0.1])
    whole = _pieces(document, 0.02)
    assert (whole.fin, whole.ends.tolist()) == (1, pytest.approx([0.0, 0.1, 0.2, 0.4]))
