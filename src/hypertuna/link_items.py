"""Missions as the items that the radio carries: bounds, home, fence, then speeds and waypoints in their order."""

from __future__ import annotations

from typing import Any

from hypertuna.dialect import dialect
from hypertuna.mission import Mission

__all__ = ["items_of"]

LOCAL = 1  # MAV_FRAME_LOCAL_NED
STEP = 1e4  # of an item's x and y in 1 m


def items_of(mission: Mission, system: int) -> list[Any]:
    """Make the items of a mission. Start and heading are where the robot is; the water is not told.

    Parameters
    ----------
    mission : Mission
    system : int
        Of the robot.

    Returns
    -------
    list of object
        MISSION_ITEM_INT, as docs/radio.md tells them.
    """
    module = dialect()
    items: list[Any] = []

    def add(what: int, values: tuple[float, ...], north: float = 0.0, east: float = 0.0, down: float = 0.0) -> None:
        numbers = [*values, *[0.0] * (4 - len(values))]
        place = (round(north * STEP), round(east * STEP), down)
        items.append(
            module.MAVLink_mission_item_int_message(system, 1, len(items), LOCAL, what, 0, 1, *numbers, *place)
        )

    bounds = (mission.depth_max, mission.reserve, mission.duration, mission.surface_every)
    more = (float(mission.stay) / STEP, 100 * mission.home_radius / STEP, mission.home_speed)
    add(module.HYPERTUNA_CMD_BOUNDS, bounds, *more)
    add(module.MAV_CMD_DO_SET_HOME, (), mission.home[1], mission.home[0])
    for x, y in mission.fence:
        add(module.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, (len(mission.fence),), y, x)
    speed = 0.0
    for point in mission.waypoints:
        if point.speed != speed:
            add(module.MAV_CMD_DO_CHANGE_SPEED, (0.0, point.speed))
        speed = point.speed
        add(module.MAV_CMD_NAV_WAYPOINT, (0.0, point.radius), point.y, point.x, point.depth)
    return items
