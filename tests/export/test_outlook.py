"""How exported robots look: sections of their links, and boxes that displace their water."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arrays import Array
from hypertuna.export.outlook import EDGE, FIN, NOSE, SKIN, SOFT, pieces


def ellipse(points: Array, width: float, height: float) -> Array:
    """Distance of points from the axis of an ellipse of this width and height, 1 on it."""
    return np.hypot(points[:, 1] / (width / 2), points[:, 2] / (height / 2))


def test_a_hull_passes_through_the_sections_between_links(tuna: ht.Robot) -> None:
    spatial, links, hulls = tuna.spatial, tuna.links, list(pieces(tuna))[:8]
    assert spatial is not None
    for i, hull in enumerate(hulls):
        rear = hull.points[hull.points[:, 0] == links.length[i]]
        assert len(rear) == 24
        if i < 7:
            width, height = ((column[i] + column[i + 1]) / 2 for column in (spatial.width, spatial.height))
            np.testing.assert_allclose(ellipse(rear, width, height), 1)
        before = max(i - 1, 0)
        width, height = ((column[i] + column[before]) / 2 for column in (spatial.width, spatial.height))
        if i:  # a round cap, half as long as its section is wide, up to the joint
            assert hull.points[:, 0].min() == pytest.approx(-width / 2)
            np.testing.assert_allclose(ellipse(hull.points[abs(hull.points[:, 0]) < 1e-12], width, height), 1)
        else:
            nose = hull.points[:, 0] <= NOSE * links.length[0] * (1 + 1e-9)
            assert (hull.points[:, 0].min(), ellipse(hull.points[nose], width, height).min()) == (
                0,
                pytest.approx(0.02, rel=0.01),
            )
    assert [hull.color for hull in hulls] == [SKIN, SKIN, *[SOFT] * 5, SKIN]  # head, L1, both joints, fin


def test_fins_are_plates_of_their_spans(tuna: ht.Robot) -> None:
    upper, lower, port, starboard = list(pieces(tuna))[8:]
    assert tuna.fins is not None
    assert tuna.water.strip is not None
    thick, half = 2 * EDGE * tuna.body.length, tuna.water.strip.edge_height / 2
    for lobe, sign in ((upper, 1), (lower, -1)):
        assert abs(sign * lobe.points[:, 2]).max() == pytest.approx(half)
        assert (sign * lobe.points[:, 2]).min() == 0
        assert np.ptp(lobe.points[:, 0]) == pytest.approx(0.85 * tuna.links.length[-1])
        assert np.ptp(lobe.points[:, 1]) == pytest.approx(thick)
    for fin, side in ((port, -1), (starboard, 1)):
        assert fin.place == (tuna.fins.x, side * tuna.fins.y, tuna.fins.z)
        np.testing.assert_allclose(np.ptp(fin.points, axis=0), [tuna.fins.chord, tuna.fins.span, thick])
        outer = fin.points[np.isclose(side * fin.points[:, 1], tuna.fins.span / 2)]  # its leading edge is swept
        assert outer[:, 0].min() == pytest.approx(-0.15 * tuna.fins.chord)
    assert {piece.color for piece in (upper, lower, port, starboard)} == {FIN}


def test_shapes_of_gazebo_lie_along_their_links(tuna: ht.Robot) -> None:
    """Ellipsoids of the sections, and boxes of the volume that each link displaces, about its center of buoyancy."""
    spatial, links = tuna.spatial, tuna.links
    assert spatial is not None
    elements = ElementTree.fromstring(ht.sdf(tuna)).findall("model/link")
    assert len(elements) == 8

    def numbers(path: str) -> list[float]:
        return [float(word) for word in (element.findtext(path) or "").split()]

    for i, element in enumerate(elements):
        low, width, height = -spatial.com_height[i], spatial.width[i], spatial.height[i]
        middle = links.length[i] / 2 - links.com[i]
        assert numbers("visual/pose") == pytest.approx([middle, 0, low, 0, 0, 0])
        assert numbers("visual/geometry/ellipsoid/radii") == pytest.approx(
            [0.55 * links.length[i], width / 2, height / 2]
        )
        center = spatial.buoyancy_center[i] - links.com[i]
        assert numbers("collision/pose") == pytest.approx([center, 0, low + spatial.buoyancy_height[i], 0, 0, 0])
        long, *across = numbers("collision/geometry/box/size")
        assert math.prod(across) * long == pytest.approx(spatial.volume[i])
        assert long == pytest.approx(links.length[i])
        assert across[0] / across[1] == pytest.approx(width / height)
        color = SOFT if 2 <= i <= 6 else SKIN
        assert element.findtext("visual/material/ambient") == element.findtext("visual/material/diffuse") == color
    fin = elements[-1].findall("visual")[1]
    pose, size = (
        [float(word) for word in (fin.findtext(path) or "").split()] for path in ("pose", "geometry/box/size")
    )
    assert pose == pytest.approx([3 / 4 * links.length[-1] - links.com[-1], 0, -spatial.com_height[-1], 0, 0, 0])
    assert size == pytest.approx([links.length[-1] / 2, 0.003 * tuna.body.length, 0.16])
    assert all(len(element.findall("visual")) == 1 for element in elements[:-1])


@pytest.mark.parametrize(("free", "depth"), [(False, 0.0), (True, 1.0)])
def test_in_mujoco_the_floor_is_a_body_length_below_the_nose(tuna: ht.Robot, free: bool, depth: float) -> None:
    """In space, the nose starts a meter deep."""
    root = ElementTree.fromstring(ht.mjcf(tuna.using(joints="ideal"), plugin=free, free=free))
    floor, body = root.find("worldbody/geom[@type='plane']"), root.find("worldbody/body")
    assert floor is not None
    assert body is not None
    assert [float(word) for word in floor.attrib["pos"].split()] == [0, 0, pytest.approx(-depth - tuna.body.length)]
    assert [float(word) for word in body.attrib.get("pos", "0 0 0").split()] == [0, 0, -depth]
