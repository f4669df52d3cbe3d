"""Missions as the items that the radio carries: what each means, and how deep it is."""

from dataclasses import replace

import pytest

import hypertuna as ht

pytest.importorskip("pymavlink", reason="needs the extra radio")
from hypertuna.mission.upload import LOCAL, items_of


def test_items_have_the_places_of_a_mission() -> None:
    mission = replace(ht.read_mission("box").mission, home=(7.0, -3.0), fence=((-9, -8), (20, -8), (20, 30)))
    bounds, *items = items_of(mission, 5)
    assert [item.seq for item in (bounds, *items)] == list(range(1 + len(items)))
    assert {(item.target_system, item.frame, item.autocontinue) for item in items} == {(5, LOCAL, 1)}
    assert (bounds.param1, bounds.param3) == pytest.approx((mission.depth_max, mission.duration))
    # x is east and y north in a mission; an item has north and east in tenths of a millimeter, and the depth
    home, *rest = [item for item in items if item.param1 != 0 or item.x or item.y or item.z]
    assert (home.x, home.y, home.z) == (-30000, 70000, 0)
    fence = [(item.x, item.y, item.z, item.param1) for item in rest[:3]]
    assert fence == [(-80000, -90000, 0, 3), (-80000, 200000, 0, 3), (300000, 200000, 0, 3)]
    points = [(item.y / 1e4, item.x / 1e4, item.z) for item in items if item.command == 16]  # MAV_CMD_NAV_WAYPOINT
    assert points == [pytest.approx((point.x, point.y, point.depth), abs=1e-4) for point in mission.waypoints]
