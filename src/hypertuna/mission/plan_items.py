"""Plans that are lists of MAVLink items: .plan of QGroundControl and .waypoints of ArduPilot's ground stations."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from hypertuna.control.mission import Point
from hypertuna.errors import InputError, shown
from hypertuna.io.door import parse_json
from hypertuna.mission.plans import Plan, Stop, check_count, checked_number, checked_place, depth_of
from hypertuna.mission.schema import MAX_DURATION, MAX_SPEED, MAX_WAYPOINTS

WAYPOINT, GO_HOME, SPEED, SET_HOME = 16, 20, 178, 179  # numbers of MAV_CMD
# By number of a MAV_CMD that a mission cannot keep: its name.
UNSUPPORTED = {17: "loiter", 18: "loiter", 19: "loiter", 21: "landing", 22: "take-off", 82: "spline", 93: "delay"}
FIXES = dict.fromkeys((17, 19, 93), "give the waypoint a time to stay instead, param 1")  # by MAV_CMD
SEA_LEVEL, ABOVE_HOME = (0, 5), (3, 6)  # numbers of MAV_FRAME with altitudes above sea level, above home
MAX_ITEMS = 3 * MAX_WAYPOINTS  # of a plan, including speeds and other commands


@dataclass(frozen=True)
class Item:
    """An item of MAVLink's mission protocol, with numbers as in the file, not yet checked."""

    number: int  # home is 0
    command: object
    frame: object
    params: list[Any]  # four numbers, then latitude, longitude [deg] and altitude [m]

    @property
    def name(self) -> str:
        """Name of the item in ground stations."""
        return f"item {self.number}"

    def number_of(self, k: int, what: str, low: float = -math.inf, high: float = math.inf) -> float:
        """Return parameter `k` of the item, counted from 1, after checking its range; 0 if the file has none."""
        value = self.params[k - 1]
        return 0.0 if value is None or value != value else checked_number(value, self.name, what, low, high)


def read_qgroundcontrol(content: bytes, depth: float | None) -> Plan:
    """Read a .plan file of QGroundControl (docs.qgroundcontrol.com, file formats, Plan)."""
    try:
        document = parse_json(content)
    except ValueError as error:
        raise InputError("must be valid JSON", value=f"not ({shown(str(error))})", fix="export it again") from None
    if document.get("fileType") != "Plan":
        fix = "save the plan in QGroundControl"
        raise InputError("must have the fileType Plan", value=shown(document.get("fileType")), fix=fix)
    mission = _part(document, "mission", dict)
    items = _part(mission, "items", list)
    check_count(len(items) if len(items) > MAX_ITEMS else 0)
    plan = Plan(fence=_fence(document))
    home = mission.get("plannedHomePosition")
    if isinstance(home, list) and len(home) >= 2:
        plan.home = checked_place(home[0], home[1], "plannedHomePosition")
    if isinstance(rally := document.get("rallyPoints"), dict) and rally.get("points"):
        plan.note("rally points are not kept: the robot returns to [home]")
    cruise_speed = mission.get("cruiseSpeed")
    usable = isinstance(cruise_speed, int | float) and 0 < cruise_speed <= MAX_SPEED
    if cruise_speed is not None and not usable:
        plan.note(f"cruiseSpeed {shown(cruise_speed)} is not kept: a mission swims at most {MAX_SPEED:g} m/s")
    _follow(plan, _simple_items(items), depth, float(cruise_speed) if usable else None)
    return plan


def _simple_items(items: list[Any]) -> Iterator[Item]:
    """Yield the items of a .plan file; raise an error for complex items, such as surveys."""
    for number, item in enumerate(items, 1):
        if not isinstance(item, dict):
            raise InputError("must be an object", key=f"item {number}", value=shown(item), fix="export the plan again")
        kind = item.get("complexItemType", item.get("type"))
        if item.get("type") != "SimpleItem":
            fix = "replace it by waypoints, such as those at its corners"
            raise InputError("must be a simple item", key=f"item {number}", value=f"a {shown(kind)}", fix=fix)
        params = item.get("params")
        if not isinstance(params, list) or len(params) != 7:
            raise InputError("must have 7 params", key=f"item {number}", fix="export the plan again")
        yield Item(number, item.get("command"), item.get("frame"), params)


def read_waypoints(content: bytes, depth: float | None) -> Plan:
    """Read a .waypoints file ("QGC WPL 110"): a line per item, the first one home, as ArduPilot writes it."""
    try:
        head, *lines = [line.split() for line in content.decode("utf-8-sig").splitlines() if line.strip()]
    except UnicodeDecodeError as error:
        raise InputError("must be UTF-8", value=f"not ({error.reason})", fix="export it again") from None
    if head != ["QGC", "WPL", "110"]:
        fix = "export it again from a current ground station"
        raise InputError("must begin with QGC WPL 110", value=shown(" ".join(head)), fix=fix)
    check_count(len(lines) if len(lines) > MAX_ITEMS else 0)
    plan, items = Plan(), [_item_of(number, cells) for number, cells in enumerate(lines)]
    if items and (items[0].frame, items[0].command) == (0, WAYPOINT):  # home, as Mission Planner and ArduPilot write it
        plan.home = checked_place(items[0].params[4], items.pop(0).params[5], "item 0, home")
    _follow(plan, iter(items), depth, None)
    return plan


def _item_of(number: int, cells: list[str]) -> Item:
    """Read an item from a line's cells: index, current, frame, command, seven parameters, autocontinue."""
    name, fix = f"item {number}", "export the file again"
    if len(cells) != 12:
        raise InputError("must have 12 columns", key=name, value=f"{len(cells)} long", fix=fix)
    try:
        index, frame, command = int(cells[0]), int(cells[2]), int(cells[3])
        params = [float(cell) for cell in cells[4:11]]
    except ValueError:
        raise InputError("must have numbers only", key=name, value=shown(" ".join(cells)), fix=fix) from None
    if index != number:
        raise InputError("must be numbered from 0 without a gap", key=name, value=f"{index}", fix=fix)
    return Item(number, command, frame, params)


def _follow(plan: Plan, items: Iterator[Item], depth: float | None, speed: float | None) -> None:
    """Add the waypoints of items to a plan, in order; speed [m/s] applies until an item changes the speed."""
    for item in items:
        if plan.goes_home:
            raise InputError("must not follow the way home", key=item.name, fix="make RETURN_TO_LAUNCH the last item")
        if item.command == WAYPOINT:
            plan.stops.append(_stop(plan, item, depth, speed))
            check_count(len(plan.stops))
        elif item.command == SPEED:
            speed = _changed_speed(plan, item, speed)
        elif item.command == SET_HOME:
            if item.number_of(1, "param 1") != 1:  # 1: the present position, which is the start
                plan.home = checked_place(item.params[4], item.params[5], item.name)
        elif item.command == GO_HOME:
            plan.goes_home = True
        else:
            number = item.command if isinstance(item.command, int) else -1
            value = f"command {shown(item.command)}{f' ({UNSUPPORTED[number]})' if number in UNSUPPORTED else ''}"
            rule, fix = "must be a waypoint, a speed, home or the way home", FIXES.get(number, "remove it")
            raise InputError(rule, key=item.name, value=value, fix=fix)


def _stop(plan: Plan, item: Item, depth: float | None, speed: float | None) -> Stop:
    """Return the waypoint of an item; depth [m]: given for all items; speed [m/s]: set by earlier items."""
    if depth is None and item.frame not in SEA_LEVEL + ABOVE_HOME:
        rule = "must have an altitude above home or sea level, frame 0, 3, 5 or 6"
        fix = "choose that altitude mode, or give one depth for all waypoints by --depth"
        raise InputError(rule, key=item.name, value=f"in frame {shown(item.frame)}", fix=fix)
    place = checked_place(item.params[4], item.params[5], item.name)
    stop_depth = depth_of(item.params[6], item.name, depth)
    if item.frame in SEA_LEVEL and stop_depth:
        plan.note("altitudes above sea level are taken as above the water's surface", item.name)
    if item.number_of(3, "param 3"):
        plan.note("passing radius (param 3) is not kept", item.name)
    if item.number_of(4, "param 4"):
        plan.note("heading (param 4) is not kept", item.name)
    hold = item.number_of(1, "a time to stay, param 1,", 0.0, MAX_DURATION)
    radius = item.number_of(2, "an acceptance radius, param 2,", 0.0, 1e5)
    return Stop(item.name, place, stop_depth, speed, radius or None, hold)


def _changed_speed(plan: Plan, item: Item, speed: float | None) -> float | None:
    """Return the speed [m/s] that an item sets for the next waypoints; -1 in the item keeps the present `speed`."""
    if (new_speed := item.number_of(2, "a speed, param 2,", -1.0, MAX_SPEED)) == -1:
        return speed
    if new_speed <= 0:
        raise InputError("must have a speed above 0", key=item.name, value=f"{new_speed:g}", fix="correct param 2")
    if item.number_of(1, "param 1") == 1:
        plan.note("speed over ground is taken as speed through the water", item.name)
    return new_speed


def _fence(document: Mapping[str, Any]) -> list[Point]:
    """Return the corners [deg] of the plan's fence, which must be a single inclusion polygon."""
    fence = document.get("geoFence")
    if not isinstance(fence, dict):
        return []
    circles, polygons = fence.get("circles") or [], fence.get("polygons") or []
    inside = isinstance(polygons, list) and all(isinstance(p, dict) and p.get("inclusion") is True for p in polygons)
    if circles or not inside or len(polygons) > 1:
        rule, fix = (
            "must have at most one polygon to stay inside, and no circle",
            "draw one polygon, or remove the fence",
        )
        raise InputError(rule, key="geoFence", fix=fix)
    corners = _part(polygons[0], "polygon", list) if polygons else []
    if not all(isinstance(corner, list) and len(corner) == 2 for corner in corners):
        raise InputError("must have corners of latitude and longitude", key="geoFence", fix="export the plan again")
    return [checked_place(corner[0], corner[1], f"geoFence, corner {k}") for k, corner in enumerate(corners, 1)]


def _part(table: Mapping[str, Any], key: str, kind: type) -> Any:
    """Return the object or list under a key of a JSON document, after checking its type."""
    value = table.get(key)
    if not isinstance(value, kind):
        word = "an object" if kind is dict else "a list"
        raise InputError(f"must be {word}", key=key, value=shown(value), fix="export the plan again")
    return value
