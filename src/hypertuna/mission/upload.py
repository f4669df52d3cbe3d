"""Send missions by radio, as MAVLink items: bounds, home, fence, then speeds and waypoints in order."""

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

from hypertuna.control.mission import Mission
from hypertuna.errors import InputError
from hypertuna.radio.client import SYSTEM, Client, make_message, of_kind
from hypertuna.radio.dialect import dialect

LOCAL = 1  # MAV_FRAME_LOCAL_NED
UNITS_PER_METER = 1e4  # scale of the integers x and y in an item


def items_of(mission: Mission, system: int) -> list[Any]:
    """Return the MAVLink messages of a mission's items. Start, heading and water are left out."""
    module = dialect()
    items: list[Any] = []

    def add(command: int, values: tuple[float, ...], north: float = 0.0, east: float = 0.0, down: float = 0.0) -> None:
        numbers = [*values, *[0.0] * (4 - len(values))]
        place = (round(north * UNITS_PER_METER), round(east * UNITS_PER_METER), down)
        items.append(make_message("mission_item_int", system, 1, len(items), LOCAL, command, 0, 1, *numbers, *place))

    bounds = (mission.depth_max, mission.reserve, mission.duration, mission.surface_every)
    flags = mission.stay + 2 * mission.silence_below
    home_values = (flags / UNITS_PER_METER, 100 * mission.home_radius / UNITS_PER_METER, mission.home_speed)
    add(module.HYPERTUNA_CMD_BOUNDS, bounds, *home_values)
    if mission.declination:
        add(module.HYPERTUNA_CMD_DECLINATION, (math.degrees(mission.declination),))
    add(module.MAV_CMD_DO_SET_HOME, (), mission.home[1], mission.home[0])
    for x, y in mission.fence:
        add(module.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, (len(mission.fence),), y, x)
    speed = 0.0
    for point in mission.waypoints:
        if point.speed != speed:
            add(module.MAV_CMD_DO_CHANGE_SPEED, (0.0, point.speed))
        speed = point.speed
        add(module.MAV_CMD_NAV_WAYPOINT, (point.hold, point.radius), point.y, point.x, point.depth)
    return items


def upload(robot: Client, mission: Mission, progress: Callable[[int, int], None] | None = None) -> None:
    """Send a mission to a robot, which keeps its former mission until the new one is complete."""
    items, texts_before = items_of(mission, robot.system), len(robot.texts)
    answers = of_kind("MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK", target_system=SYSTEM)
    answer = robot.ask(robot.message("mission_count", len(items)), answers, "mission")
    while answer.get_type() != "MISSION_ACK":
        item = items[min(answer.seq, len(items) - 1)]
        if progress is not None:
            progress(answer.seq, len(items))
        answer = robot.ask(item, answers, f"mission item {item.seq}")
    if answer.type != 0:
        result = dialect().enums["MAV_MISSION_RESULT"][answer.type].name.removeprefix("MAV_MISSION_").lower()
        reason = [f"{result.replace('_', ' ')}; docs/radio.md lists the limits", *robot.texts[texts_before:]][-1]
        raise InputError("was refused by the robot", key="the mission", fix=_with_waypoint(reason, items))


def _with_waypoint(reason: str, items: Sequence[Any]) -> str:
    """Add the waypoint's number, from 1, to the item's number in the robot's reason for a refusal."""
    item_text = re.match(r"item (\d+)", reason)
    if item_text is None or int(item_text[1]) >= len(items):
        return reason
    commands = [item.command for item in items[: int(item_text[1]) + 1]]
    number = commands.count(dialect().MAV_CMD_NAV_WAYPOINT) + (commands[-1] == dialect().MAV_CMD_DO_CHANGE_SPEED)
    return reason.replace(item_text[0], f"{item_text[0]} (waypoint {number})", 1)


def download(robot: Client) -> Sequence[Any]:
    """Return the items of the mission on board a robot, as MAVLink messages."""
    count = robot.ask(robot.message("mission_request_list"), of_kind("MISSION_COUNT"), "mission").count
    return [
        robot.ask(robot.message("mission_request_int", k), of_kind("MISSION_ITEM_INT", seq=k), f"mission item {k}")
        for k in range(count)
    ]
