"""Write the track of a mission as GPX 1.1 (topografix.com/GPX/1/1), for maps."""

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NoReturn
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.files import version, write_atomically
from hypertuna.mission.geodesy import from_local
from hypertuna.mission.record import MissionRecord

SPACE = "http://www.topografix.com/GPX/1/1"  # XML namespace
BEGINNING = datetime(1970, 1, 1, tzinfo=UTC)  # start of simulated missions, which have no date


def write_gpx(record: MissionRecord, path: str | Path) -> Path:
    """Write the track of a mission to a GPX file, completely or not at all."""
    return write_atomically(path, gpx_text(record).encode())


def gpx_text(record: MissionRecord) -> str:
    """Return a mission's waypoints, and its true and estimated track with a point per second, as GPX text."""
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


def parse_xml(content: bytes) -> Element:
    """Parse an XML text and return its root; document types are refused, since their entities could fill the memory."""
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
    """Add a point at a place [rad], rounded to 1 mm, and a height [m] to a parent; return its node."""
    latitude, longitude = np.degrees(place)
    node = SubElement(parent, tag, {"lat": f"{latitude:.8f}", "lon": f"{longitude:.8f}"})
    SubElement(node, "ele").text = f"{round(height, 3) + 0.0:.3f}"  # no -0.000
    return node


def _track(root: Element, name: str, record: MissionRecord, position: Array) -> None:
    """Add a track of positions (T, 3) [m] to the root of a GPX file, one point a second."""
    assert record.origin is not None  # checked
    track = SubElement(root, "trk")
    SubElement(track, "name").text = _clean(name)
    segment = SubElement(track, "trkseg")
    rows = record.every(1.0)
    places = from_local(record.origin, position[rows, :2])
    for place, height, second in zip(places, position[rows, 2], record.time[rows], strict=True):
        stamp = (BEGINNING + timedelta(milliseconds=round(1e3 * float(second)))).isoformat(timespec="milliseconds")
        node = _point(segment, "trkpt", place, float(height))
        SubElement(node, "time").text = stamp.replace("+00:00", "Z")


def _clean(text: str) -> str:
    """Return a text without the characters that XML 1.0 excludes."""
    return "".join(c for c in text if c in "\t\n\r" or "\x20" <= c <= "\ud7ff" or "\ue000" <= c <= "\ufffd")
