"""Plans that are lists of places: GPX of any version, and KML."""

from collections.abc import Iterator
from xml.etree.ElementTree import Element

from hypertuna.errors import InputError, shown
from hypertuna.io.tables import parse_float
from hypertuna.mission.gpx import parse_xml
from hypertuna.mission.plans import Plan, Stop, check_count, checked_place, depth_of

ALTITUDES = ("absolute", "relativeToGround")  # of KML: other modes ignore altitudes, or count from the ground below
KINDS = {"rte": "routes (rte)", "wpt": "waypoints (wpt)", "trk": "tracks (trk)"}
Node = tuple[str, str | None, str | None, str | None]  # name, latitude, longitude, altitude or None for the surface


def read_xml(content: bytes, depth: float | None) -> Plan:
    """Read GPX or KML, by its root."""
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
    """Yield the points of the route, else all waypoints, else those of the track."""
    found = {kind: root.findall(f"{{*}}{kind}") for kind in KINDS}
    taken = next((kind for kind, nodes in found.items() if nodes), "")
    if taken != "wpt" and len(found.get(taken, [])) > 1:
        many, fix = len(found[taken]), "keep one, and export the file again"
        raise InputError("must have one route or track", value=f"{many} {KINDS[taken]}", fix=fix)
    for kind, nodes in found.items():
        if nodes and kind != taken:
            plan.note(f"{len(nodes)} {KINDS[kind]} beside the {KINDS[taken]} are not kept")
    points = {"rte": "{*}rte/{*}rtept", "wpt": "{*}wpt", "trk": "{*}trk/{*}trkseg/{*}trkpt"}
    for k, node in enumerate(root.iterfind(points[taken]) if taken else (), 1):
        yield f"point {k}", node.get("lat"), node.get("lon"), node.findtext("{*}ele")


def _kml(root: Element, plan: Plan) -> Iterator[Node]:
    """Yield the points of the line, else all single points."""
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
            high = cells[2] if len(cells) == 4 else ""
            if high and mode not in ALTITUDES and _number(high) != 0:
                plan.note(f"altitudes are not kept, as altitudeMode {mode} ignores them", f"point {number}")
            yield f"point {number}", cells[1], cells[0], high if high and mode in ALTITUDES else None


def _number(text: str | None) -> float | str | None:
    """Read a number; what is none stays text, for the error."""
    value = None if text is None else parse_float(text)
    return text if value is None or value != value else value
