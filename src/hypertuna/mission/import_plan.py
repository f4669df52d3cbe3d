"""Import plans of other programs as missions: .plan of QGroundControl, .waypoints, GPX and KML."""

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from hypertuna.description.commented import commented
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, escaped, shown
from hypertuna.io.door import read_bytes
from hypertuna.io.tables import parse_float
from hypertuna.mission.checks import check_fit
from hypertuna.mission.file import MissionFile, parse_mission
from hypertuna.mission.geodesy import to_local
from hypertuna.mission.gpx import parse_xml
from hypertuna.mission.new import spelled, usual_radius, usual_speed
from hypertuna.mission.plan_items import read_qgroundcontrol, read_waypoints
from hypertuna.mission.plans import Place, Plan, Stop, check_count, checked_place, depth_of
from hypertuna.mission.schema import Document

ALTITUDES = ("absolute", "relativeToGround")  # modes of KML whose altitudes are used; others ignore altitudes
# Elements of GPX, the preferred one first.
GPX_KINDS = {"rte": "routes (rte)", "wpt": "waypoints (wpt)", "trk": "tracks (trk)"}
Node = tuple[str, str | None, str | None, str | None]  # name, latitude, longitude, altitude or None for the surface
SPEED, RADIUS = 0.3, 3.0  # m/s and m, if neither plan nor robot states them: the defaults of a mission file
BELOW = 0.5  # m: least distance of the depth limit below the deepest waypoint
GROUND = 20.0  # m: default depth of the ground in a mission file


def read_plan(path: str | Path, *, depth: float | None = None) -> Plan:
    """Read a plan in the format that its content shows; `depth` [m] replaces the altitudes of all waypoints.

    Raises
    ------
    InputError
        If it is no plan, or has what a mission cannot keep: the item, the rule, the value and the fix.
    """
    content = read_bytes(path, "plan")
    start = content.removeprefix(b"\xef\xbb\xbf").lstrip()[:7]
    read: Callable[[bytes, float | None], Plan]
    if start.startswith(b"{"):
        read = read_qgroundcontrol
    elif start == b"QGC WPL":
        read = read_waypoints
    elif start.startswith(b"<"):
        read = read_xml
    else:
        rule = "must be a plan: .plan of QGroundControl, .waypoints, GPX or KML"
        fix = "unzip it first" if start.startswith(b"PK") else "export it again from the program that drew it"
        raise InputError(rule, file=str(path), fix=fix)
    try:
        plan = read(content, depth)
        if not plan.stops:
            raise InputError("has no waypoints", fix="draw at least one")
    except InputError as error:
        raise InputError(error.rule, file=str(path), key=error.key, value=error.value, fix=error.fix) from None
    if depth is not None:
        plan.note(f"altitudes are replaced by --depth {depth:g}")
    return plan


def plan_document(plan: Plan, name: str, robot: Robot | None = None, speed: float | None = None) -> dict[str, Any]:
    """Return a plan as the document of a mission file; speeds and radii that it lacks are the robot's."""
    default_speed = speed or (SPEED if robot is None else usual_speed(robot))
    radius = RADIUS if robot is None else usual_radius(robot)
    origin = plan.home or plan.stops[0].place
    if any(stop.speed is None for stop in plan.stops) and speed is None:
        plan.note(f"the plan has no speed: {default_speed:g} m/s is assumed{' for the robot' * (robot is not None)}")
    limit = math.ceil(10 * max(1.0, max(stop.depth for stop in plan.stops) + BELOW)) / 10
    document: dict[str, Any] = {"format": 1, "name": name}
    document |= {} if robot is None else {"robot": spelled(robot)}
    document["origin"] = _degrees(origin)
    document["start"] = {"x_m": 0.0, "y_m": 0.0, "heading_deg": _heading(origin, plan.stops)}
    document["waypoints"] = [
        _degrees(stop.place)
        | {"depth_m": stop.depth, "speed_m_s": speed or stop.speed or default_speed, "radius_m": stop.radius or radius}
        | ({"hold_s": stop.hold} if stop.hold else {})
        for stop in plan.stops
    ]
    document["home"] = {"radius_m": radius, "speed_m_s": document["waypoints"][-1]["speed_m_s"]}
    if limit >= GROUND:
        document["water"] = {"bottom_m": 1.5 * limit}
        plan.note(f"the depth of the ground is not in the plan: water.bottom_m = {1.5 * limit:g} is assumed")
    document["limits"] = {"depth_m": limit}
    if plan.fence:
        document["limits"]["fence_m"] = np.round(_local(origin, plan.fence), 3).tolist()
    return document


def plan_text(document: dict[str, Any], plan: Plan, source: str) -> str:
    """Return the text of a mission file, with comments on the parts of the plan that were not kept."""
    notes = [f"# Not kept: {escaped(note)}" for note in plan.notes]
    return "\n".join(
        [f"# Imported from {escaped(Path(source).name)}.", *notes, commented(document, Document, hints={})]
    )


def check_plan(document: dict[str, Any], plan: Plan, file: str, robot: Robot | None = None) -> MissionFile:
    """Check a plan's document, also against a robot if given, and return the mission; errors name the plan's items."""
    try:
        mission = parse_mission(document)
        if robot is not None:
            check_fit(robot, mission.mission)
        return mission
    except InputError as error:
        key = error.key or ""
        for k in range(len(plan.stops)):
            if key.startswith(f"waypoints[{k}]"):
                key = f"{plan.stops[k].name}: {key.removeprefix(f'waypoints[{k}]').lstrip('.')}".removesuffix(": ")
                break
        raise InputError(error.rule, file=file, key=key or None, value=error.value, fix=error.fix) from None


def _degrees(place: Place) -> dict[str, float]:
    """Return a place [deg] as latitude and longitude keys of a mission file, rounded to 0.1 mm."""
    return {"latitude_deg": round(place[0], 9), "longitude_deg": round(place[1], 9)}


def _local(origin: Place, places: Iterable[Place]) -> Any:
    """Return east and north (n, 2) [m] of places [deg]."""
    return to_local((math.radians(origin[0]), math.radians(origin[1])), *np.radians(list(places)).T)


def _heading(origin: Place, stops: list[Stop]) -> float:
    """Return the compass direction [deg] to the first waypoint that is not at the start."""
    for east, north in _local(origin, [stop.place for stop in stops]):
        if math.hypot(east, north) > 1.0:
            return round(math.degrees(math.atan2(east, north)), 1) + 0.0  # no -0.0
    return 0.0


def read_xml(content: bytes, depth: float | None) -> Plan:
    """Read a plan from GPX or KML, depending on the root's tag; `depth` [m] replaces all altitudes."""
    root = parse_xml(content)
    name, plan = root.tag.rpartition("}")[2], Plan()
    if name not in ("gpx", "kml"):
        raise InputError("must be GPX or KML", value=shown(name), fix="export it as GPX from a map program")
    nodes = list(_gpx(root, plan) if name == "gpx" else _kml(root, plan))
    check_count(len(nodes))
    for where, latitude, longitude, altitude in nodes:
        place = checked_place(_number(latitude), _number(longitude), where)
        plan.stops.append(Stop(where, place, depth_of(0.0 if altitude is None else _number(altitude), where, depth)))
    return plan


def _gpx(root: Element, plan: Plan) -> Iterator[Node]:
    """Yield name, latitude, longitude and altitude of the points in a GPX file's route, else waypoints, else track."""
    found = {kind: root.findall(f"{{*}}{kind}") for kind in GPX_KINDS}
    chosen = next((kind for kind, nodes in found.items() if nodes), "")
    if chosen != "wpt" and len(found.get(chosen, [])) > 1:
        count, fix = len(found[chosen]), "keep one, and export the file again"
        raise InputError("must have one route or track", value=f"{count} {GPX_KINDS[chosen]}", fix=fix)
    for kind, nodes in found.items():
        if nodes and kind != chosen:
            plan.note(f"{len(nodes)} {GPX_KINDS[kind]} beside the {GPX_KINDS[chosen]} are not kept")
    points = {"rte": "{*}rte/{*}rtept", "wpt": "{*}wpt", "trk": "{*}trk/{*}trkseg/{*}trkpt"}
    for k, node in enumerate(root.iterfind(points[chosen]) if chosen else (), 1):
        yield f"point {k}", node.get("lat"), node.get("lon"), node.findtext("{*}ele")


def _kml(root: Element, plan: Plan) -> Iterator[Node]:
    """Yield name, latitude, longitude and altitude of the points in a KML file's line, or else of its single points."""
    lines, points = list(root.iterfind(".//{*}LineString")), list(root.iterfind(".//{*}Point"))
    if len(lines) > 1:
        raise InputError("must have one LineString", value=f"{len(lines)} of them", fix="keep one line in the file")
    if points and lines:
        plan.note(f"{len(points)} points beside the line are not kept")
    if polygons := list(root.iterfind(".//{*}Polygon")):
        plan.note(f"{len(polygons)} polygons are not kept: give a fence as limits.fence_m")
    number = 0
    for node in lines or points:
        mode = node.findtext("{*}altitudeMode", "clampToGround").strip()
        if "SeaFloor" in mode:
            fix = "use absolute altitudes, negative below the water"
            raise InputError("must not count altitudes from the sea floor", key="altitudeMode", value=mode, fix=fix)
        for text in (node.findtext("{*}coordinates") or "").split():
            number += 1
            cells = [*text.split(","), ""]
            if not 3 <= len(cells) <= 4:
                fix = "write them without spaces, points separated by spaces"
                raise InputError("must be LON,LAT or LON,LAT,ALT", key=f"point {number}", value=shown(text), fix=fix)
            altitude = cells[2] if len(cells) == 4 else ""
            if altitude and mode not in ALTITUDES and _number(altitude) != 0:
                plan.note(f"altitudes are not kept, as altitudeMode {mode} ignores them", f"point {number}")
            yield f"point {number}", cells[1], cells[0], altitude if altitude and mode in ALTITUDES else None


def _number(text: str | None) -> float | str | None:
    """Return the number that a text holds; any other text unchanged, for the error to show."""
    value = None if text is None else parse_float(text)
    return text if value is None or value != value else value
