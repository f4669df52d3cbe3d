"""GPX 1.1 (topografix.com/GPX/1/1): the track of a mission for maps, and tracks of such files back."""

import math
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NoReturn
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.files import read_bytes, version, write_atomically
from hypertuna.io.tables import parse_float
from hypertuna.mission.geodesy import from_local
from hypertuna.mission.record import MissionRecord

SPACE = "http://www.topografix.com/GPX/1/1"
BEGINNING = datetime(1970, 1, 1, tzinfo=UTC)  # a simulated mission has no date: its times count from here
SPACES = {"": SPACE}
MAX_BYTES = 200_000_000


@dataclass(frozen=True)
class GpxTrack:
    """A track of a GPX file."""

    name: str  # empty if it has none
    latitude: Array  # (points,) [rad]
    longitude: Array
    elevation: Array  # (points,), above the surface [m]; NaN where missing
    time: Array  # (points,), since 1970 [s]; NaN where missing


def write_gpx(record: MissionRecord, path: str | Path) -> Path:
    """Write the track of a mission, whole or not at all."""
    return write_atomically(path, gpx_text(record).encode())


def gpx_text(record: MissionRecord) -> str:
    """Return waypoints, true and estimated track of a mission once a second."""
    check_origin(record.origin)
    assert record.origin is not None
    root = Element("gpx", {"version": "1.1", "creator": f"hypertuna {version()}", "xmlns": SPACE})
    SubElement(SubElement(root, "metadata"), "name").text = _clean(record.name)
    for k, point in enumerate(record.mission.waypoints):
        place = from_local(record.origin, [point.x, point.y])
        node = _point(root, "wpt", place, -point.depth)
        SubElement(node, "name").text = f"{k + 1}"
    if record.true:
        _track(root, record.name, record, record.position)
    if {"position_estimated", "depth_estimated"} <= set(record.data):
        estimated = np.column_stack([record.data["position_estimated"], -record.data["depth_estimated"]])
        _track(root, f"{record.name}, estimated", record, estimated)
    ElementTree.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def check_origin(origin: tuple[float, float] | None, file: str | None = None) -> None:
    """Check that there is an origin, which a track on the Earth needs: `origin` [rad]."""
    if origin is None:
        fix = "add the table [origin] with latitude_deg and longitude_deg to the mission"
        raise InputError("is needed for a track on the Earth", file=file, key="origin", fix=fix)


def read_gpx(path: str | Path) -> list[GpxTrack]:
    """Read the tracks of a GPX file; segments of a track are joined."""
    file = str(path)
    content = read_bytes(path, "give the path of a .gpx file", limit=MAX_BYTES)
    try:
        root = parse_xml(content)
    except InputError as error:
        raise InputError(error.rule, file=file, value=error.value, fix=error.fix) from None
    if root.tag != f"{{{SPACE}}}gpx":
        value, fix = shown(root.tag), "give a GPX 1.1 file"
        raise InputError("must begin with the element gpx of GPX 1.1", file=file, value=value, fix=fix)
    return [_read_track(node, f"trk[{k}]", file) for k, node in enumerate(root.iterfind("trk", SPACES))]


def parse_xml(content: bytes) -> Element:
    """Parse XML of strangers: without a document type, so that no entity grows."""
    try:
        return ElementTree.fromstring(content, parser=ElementTree.XMLParser(target=_Plain()))
    except InputError:
        raise
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        value = f"not ({shown(str(error))})"
        raise InputError("must be valid XML", value=value, fix="export it again") from None


class _Plain(ElementTree.TreeBuilder):
    """Builder that refuses document types: their entities can fill the memory."""

    def doctype(self, *_: object) -> NoReturn:
        raise InputError("must not have a document type", fix="remove the line <!DOCTYPE ...>")


def _point(parent: Element, tag: str, place: Array, height: float) -> Element:
    """Add a point: latitude and longitude to a centimeter, elevation to a millimeter."""
    latitude, longitude = np.degrees(place)
    node = SubElement(parent, tag, {"lat": f"{latitude:.8f}", "lon": f"{longitude:.8f}"})
    SubElement(node, "ele").text = f"{round(height, 3) + 0.0:.3f}"  # no -0.000
    return node


def _track(root: Element, name: str, record: MissionRecord, position: Array) -> None:
    """Add a track of positions (T, 3), one point a second."""
    assert record.origin is not None  # checked
    track = SubElement(root, "trk")
    SubElement(track, "name").text = _clean(name)
    segment = SubElement(track, "trkseg")
    at = record.every(1.0)
    places = from_local(record.origin, position[at, :2])
    for place, height, second in zip(places, position[at, 2], record.time[at], strict=True):
        stamp = (BEGINNING + timedelta(milliseconds=round(1e3 * float(second)))).isoformat(timespec="milliseconds")
        node = _point(segment, "trkpt", place, float(height))
        SubElement(node, "time").text = stamp.replace("+00:00", "Z")


def _clean(text: str) -> str:
    """Remove characters that XML 1.0 excludes."""
    return "".join(c for c in text if c in "\t\n\r" or "\x20" <= c <= "\ud7ff" or "\ue000" <= c <= "\ufffd")


def _read_track(track: Element, key: str, file: str) -> GpxTrack:
    """Read the points of all segments of a track."""
    rows = []
    for k, node in enumerate(track.iterfind("trkseg/trkpt", SPACES)):
        place = f"{key}.trkpt[{k}]"
        latitude = _number(node.get("lat"), f"{place}.lat", 90.0, file)
        longitude = _number(node.get("lon"), f"{place}.lon", 180.0, file)
        height, moment = node.findtext("ele", None, SPACES), node.findtext("time", None, SPACES)
        elevation = math.nan if height is None else _number(height, f"{place}.ele", math.inf, file)
        time = math.nan if moment is None else _time(moment, f"{place}.time", file)
        rows.append((math.radians(latitude), math.radians(longitude), elevation, time))
    columns = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return GpxTrack(track.findtext("name", "", SPACES), *columns)


def _number(text: str | None, key: str, limit: float, file: str) -> float:
    """Read a number of limited size."""
    value = math.nan if text is None else parse_float(text)
    if not abs(value) <= limit or math.isinf(value):
        rule = "must be a number" if math.isinf(limit) else f"must be a number from -{limit:g} to {limit:g}"
        given = "missing" if text is None else shown(text)
        raise InputError(rule, file=file, key=key, value=given, fix="correct that point")
    return value


def _time(text: str, key: str, file: str) -> float:
    """Read a time; one without a zone is UTC."""
    try:
        stamp = datetime.fromisoformat(text.strip())
        return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError):
        fix = "write it as 2026-01-31T12:00:00Z"
        raise InputError("must be a time", file=file, key=key, value=shown(text), fix=fix) from None
