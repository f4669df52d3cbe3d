"""GPX: the structure of version 1.1, and the track read back."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.mission.geodesy import from_local, to_local
from hypertuna.mission.gpx import SPACE, gpx_text, write_gpx
from voyage import voyage

# Children of each element in the order of the schema, topografix.com/GPX/1/1/gpx.xsd; * for any number.
ORDER = {
    "gpx": ["metadata", "wpt*", "rte*", "trk*", "extensions"],
    "metadata": ["name", "desc", "author", "copyright", "link*", "time", "keywords", "bounds", "extensions"],
    "trk": ["name", "cmt", "desc", "src", "link*", "number", "type", "extensions", "trkseg*"],
    "trkseg": ["trkpt*", "extensions"],
    "wpt": ["ele", "time", "magvar", "geoidheight", "name", "cmt", "desc", "src", "link*", "sym", "type", "fix"],
}
ORDER["trkpt"] = ORDER["wpt"]
DATE = re.compile(r"-?\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)?")


def check(node: ElementTree.Element) -> None:
    """Check an element and what is in it against the schema of GPX 1.1."""
    assert node.tag.startswith(f"{{{SPACE}}}")
    name = node.tag.removeprefix(f"{{{SPACE}}}")
    children = [child.tag.removeprefix(f"{{{SPACE}}}") for child in node]
    known = [entry.removesuffix("*") for entry in ORDER.get(name, [])]
    places = [known.index(child) for child in children]
    assert places == sorted(places), f"{name} has {children}"
    for entry in ORDER.get(name, []):
        assert entry.endswith("*") or children.count(entry) <= 1
    if name == "gpx":
        assert node.get("version") == "1.1"
        assert node.get("creator")
    if name in ("wpt", "trkpt"):
        assert set(node.attrib) == {"lat", "lon"}
        assert -90 <= float(node.attrib["lat"]) <= 90
        assert -180 <= float(node.attrib["lon"]) < 180
    if name == "ele":
        assert re.fullmatch(r"-?\d+\.\d+", node.text or "")
    if name == "time":
        assert DATE.fullmatch(node.text or "")
    for child in node:
        check(child)


def test_the_structure_is_that_of_gpx_1_1() -> None:
    text = gpx_text(voyage())
    root = ElementTree.fromstring(text)
    check(root)
    assert text.startswith('<?xml version="1.0" encoding="UTF-8"?>\n<gpx ')
    assert len(root.findall(f"{{{SPACE}}}wpt")) == 4
    assert [node.findtext(f"{{{SPACE}}}name") for node in root.iter(f"{{{SPACE}}}trk")] == ["box", "box, estimated"]


def tracks(path: Path) -> list[tuple[str, np.ndarray]]:
    """Return name and points of each track: latitude and longitude [deg], elevation [m], time [s]."""
    space, found = {"": SPACE}, []
    for track in ElementTree.parse(path).iterfind("trk", space):
        points = [
            (
                *(float(node.attrib[key]) for key in ("lat", "lon")),
                float(node.findtext("ele", "", space)),
                datetime.fromisoformat(node.findtext("time", "", space)).timestamp(),
            )
            for node in track.iterfind("trkseg/trkpt", space)
        ]
        found.append((track.findtext("name", "", space), np.array(points)))
    return found


def test_the_track_comes_back(tmp_path: Path) -> None:
    record = voyage()
    (_, true), (_, believed) = tracks(write_gpx(record, tmp_path / "box.gpx"))
    assert record.origin is not None
    at = record.every(1.0)
    np.testing.assert_allclose(true[:, 3], [*range(300), record.time[-1]], atol=1e-3)
    for track, flat, depth in (
        (true, record.data["position"][at, :2], record.depth[at]),
        (believed, record.data["position_estimated"][at], record.data["depth_estimated"][at]),
    ):
        there = to_local(record.origin, *np.radians(track[:, :2].T))
        np.testing.assert_allclose(there, flat, atol=2e-3)  # 1e-8 deg is 1.1 mm
        np.testing.assert_allclose(track[:, 2], -depth, atol=1e-3)


def test_a_corner_of_the_box_is_where_a_map_has_it() -> None:
    """20 m north of the origin is 20 / 111.1 km of a degree of latitude further: 0.000180 deg."""
    origin = math.radians(43.854), math.radians(125.302)
    latitude, longitude = np.degrees(from_local(origin, [0.0, 20.0]))
    assert latitude - 43.854 == pytest.approx(20 / 111.1e3, rel=1e-3)
    assert longitude == pytest.approx(125.302, abs=1e-12)


def test_names_that_xml_cannot_hold(tmp_path: Path) -> None:
    odd = replace(voyage(5, bare=True), name='<a & "b">\0\x0b\ud800é')
    ((name, _),) = tracks(write_gpx(odd, tmp_path / "odd.gpx"))
    assert name == '<a & "b">é'


def test_without_an_origin_there_is_no_track() -> None:
    with pytest.raises(ht.InputError, match=r"origin is needed for a track on the Earth: add the table \[origin\]"):
        gpx_text(replace(voyage(5), origin=None))
