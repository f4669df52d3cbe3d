"""Plans of other programs as missions: .plan, .waypoints, GPX, KML; what is refused names item, rule, value and fix."""

import json
import math
import random
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.io.door import KINDS
from hypertuna.mission.file import MissionFile, parse_mission, read_mission
from hypertuna.mission.geodesy import from_local
from hypertuna.mission.import_plan import check_plan, plan_document, plan_text, read_plan
from hypertuna.mission.plan_items import GO_HOME, SET_HOME, SPEED, UNSUPPORTED, WAYPOINT
from program import Run

HOME = (43.854, 125.302)
SQUARE = [(0.0, 20.0), (20.0, 20.0), (20.0, 0.0)]  # m east and north of home
PLACES = [tuple(np.degrees(from_local(tuple(np.radians(HOME)), place))) for place in SQUARE]  # type: ignore[arg-type]


def imported(path: Path, content: str | bytes, **options: Any) -> tuple[MissionFile, list[str]]:
    """Write a plan, and return its mission and what it says about changes."""
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    plan = read_plan(path, **options)
    return check_plan(plan_document(plan, "plan"), plan, str(path)), plan.notes


def simple(command: int = 16, *params: Any, frame: int = 3, **more: Any) -> dict[str, Any]:
    return {"type": "SimpleItem", "frame": frame, "command": command, "params": list(params)} | more


def waypoint(k: int, altitude: float = -1.5, hold: float = 0, radius: float = 0, yaw: float | None = None) -> Any:
    return simple(16, hold, radius, 0, yaw, *PLACES[k], altitude)


def qgroundcontrol(*items: Any, speed: Any = 0.4, **more: Any) -> str:
    mission = {"cruiseSpeed": speed, "plannedHomePosition": [*HOME, 200], "items": list(items)}
    return json.dumps({"fileType": "Plan", "version": 1, "mission": mission} | more)


def wpl(*lines: str) -> str:
    home = f"0\t1\t0\t16\t0\t0\t0\t0\t{HOME[0]}\t{HOME[1]}\t584\t1"
    rows = [f"{k}\t0\t{line.format(*PLACES)}" for k, line in enumerate(lines, 1)]
    return "\r\n".join(["QGC WPL 110", home, *rows]) + "\r\n"


def row(k: int, altitude: float = -1.5, command: int = 16, frame: int = 3) -> str:
    return f"{frame}\t{command}\t0\t0\t0\t0\t{PLACES[k][0]:.9f}\t{PLACES[k][1]:.9f}\t{altitude}\t1"


def gpx(body: str, namespace: str = "http://www.topografix.com/GPX/1/1") -> str:
    return f'<?xml version="1.0"?>\n<gpx version="1.1" creator="x" xmlns="{namespace}">{body}</gpx>'


def points(tag: str, *heights: float) -> str:
    ends = [f"><ele>{height}</ele></{tag}>" for height in heights] or ["/>"] * 3
    return "".join(f'<{tag} lat="{lat:.9f}" lon="{lon:.9f}"{end}' for (lat, lon), end in zip(PLACES, ends, strict=True))


def kml(body: str, namespace: str = ' xmlns="http://www.opengis.net/kml/2.2"') -> str:
    return f"<kml{namespace}><Document><Placemark>{body}</Placemark></Document></kml>"


def line(altitude: str = "", mode: str = "") -> str:
    text = " ".join(f"{lon:.9f},{lat:.9f}{altitude}" for lat, lon in PLACES)
    return f"<LineString>{mode}<coordinates>\n{text}\n</coordinates></LineString>"


SAME = {
    "plan": qgroundcontrol(*map(waypoint, range(3))),
    "waypoints": wpl(row(0), row(1), row(2)),
    "waypoints-frame-0": wpl(row(0, frame=0), row(1, frame=0), row(2, frame=0)),
    "gpx-rte": gpx(f"<rte>{points('rtept', -1.5, -1.5, -1.5)}</rte>"),
    "gpx-trk": gpx(f"<trk><trkseg>{points('trkpt', -1.5, -1.5, -1.5)}</trkseg></trk>"),
    "gpx-wpt": gpx(points("wpt", -1.5, -1.5, -1.5)),
    "gpx-1.0": gpx(f"<rte>{points('rtept', -1.5, -1.5, -1.5)}</rte>", "http://www.topografix.com/GPX/1/0"),
    "gpx-no-namespace": gpx(points("wpt", -1.5, -1.5, -1.5)).replace(' xmlns="http://www.topografix.com/GPX/1/1"', ""),
    "gpx-byte-order-mark": "\ufeff" + gpx(points("wpt", -1.5, -1.5, -1.5)),
    "kml-line": kml(line(",-1.5", "<altitudeMode>absolute</altitudeMode>")),
    "kml-points": kml(
        "".join(
            f"<Point><altitudeMode>absolute</altitudeMode><coordinates>{lon:.9f},{lat:.9f},-1.5</coordinates></Point>"
            for lat, lon in PLACES
        ),
        ' xmlns="http://earth.google.com/kml/2.1"',
    ),
}


@pytest.mark.parametrize("form", SAME)
def test_three_points_are_the_same_mission_in_every_form(form: str, tmp_path: Path) -> None:
    """Depth is a negative altitude; the origin is the plan's home, or else the first point."""
    file, _ = imported(tmp_path / "three", SAME[form])
    mission = file.mission
    first = (0.0, 0.0) if form.startswith(("plan", "waypoints")) else SQUARE[0]
    there = [(x - first[0], y - first[1]) for x, y in SQUARE]
    np.testing.assert_allclose([point[:2] for point in mission.waypoints], there, atol=2e-3)
    assert [point.depth for point in mission.waypoints] == [1.5] * 3
    assert {point.speed for point in mission.waypoints} == {0.4 if form == "plan" else 0.3}
    assert (mission.start, mission.home, mission.stay) == ((0.0, 0.0), (0.0, 0.0), False)
    assert mission.depth_max == 2.0


def test_without_altitudes_the_mission_is_at_the_surface(tmp_path: Path) -> None:
    for content in (gpx(f"<rte>{points('rtept')}</rte>"), kml(line()), kml(line(",0"))):
        file, notes = imported(tmp_path / "flat", content)
        assert [point.depth for point in file.mission.waypoints] == [0.0] * 3
        assert notes == ["the plan has no speed: 0.3 m/s is assumed"]
    file, notes = imported(tmp_path / "flat", kml(line(",-3")))
    assert file.mission.waypoints[0].depth == 0.0  # clampToGround, as Google Earth reads it
    assert "altitudes are not kept, as altitudeMode clampToGround ignores them: point 1, point 2, point 3" in notes


def test_times_to_stay_radii_speeds_home_and_fence_are_kept(tmp_path: Path) -> None:
    corners = np.degrees(from_local(tuple(np.radians(HOME)), [(-30, -30), (50, -30), (50, 50), (-30, 50)])).tolist()
    fence = {"circles": [], "polygons": [{"inclusion": True, "polygon": corners, "version": 1}]}
    items = [
        simple(179, 1, 0, 0, 0, 0, 0, 0),  # home is where it starts
        simple(178, 1, 0.25, -1, 0, 0, 0, 0, frame=2),
        waypoint(0, hold=30, radius=4),
        simple(178, 0, -1, -1, 0, 0, 0, 0, frame=2),  # no change
        waypoint(1, -2.5, yaw=90),
        simple(20, 0, 0, 0, 0, 0, 0, 0, frame=2),
    ]
    content = qgroundcontrol(*items, geoFence=fence, rallyPoints={"points": [[1, 2, 3]]}, speed=15)
    file, notes = imported(tmp_path / "kept.plan", content)
    first, second = file.mission.waypoints
    assert (first.hold, first.radius, first.speed, first.depth) == (30, 4, 0.25, 1.5)
    assert (second.hold, second.radius, second.speed, second.depth) == (0, 3, 0.25, 2.5)
    np.testing.assert_allclose(file.mission.fence, [(-30, -30), (50, -30), (50, 50), (-30, 50)], atol=2e-3)
    assert notes == [
        "rally points are not kept: the robot returns to [home]",
        "cruiseSpeed 15 is not kept: a mission swims at most 5 m/s",
        "speed over ground is taken as speed through the water: item 2",
        "heading (param 4) is not kept: item 5",
    ]


def test_the_written_file_is_the_same_mission(tmp_path: Path) -> None:
    (tmp_path / "a.plan").write_text(SAME["plan"])
    plan = read_plan(tmp_path / "a.plan")
    document = plan_document(plan, 'a "b" é')
    (tmp_path / "a.toml").write_text(plan_text(document, plan, "a.plan"))
    assert read_mission(tmp_path / "a.toml").hash == parse_mission(document).hash
    assert read_mission(tmp_path / "a.toml").name == 'a "b" é'


def test_one_depth_replaces_altitudes(tmp_path: Path) -> None:
    """Tracks of a mountain lake, and altitudes above the terrain."""
    for content in (gpx(points("wpt", 1500, 1501, 1502)), wpl(row(0, 10, frame=10), row(1, 400), row(2, frame=10))):
        file, notes = imported(tmp_path / "deep", content, depth=1.0)
        assert [point.depth for point in file.mission.waypoints] == [1.0] * 3
        assert "altitudes are replaced by --depth 1" in notes


def test_what_is_taken_of_a_file_with_several_lists_is_told(tmp_path: Path) -> None:
    body = points("wpt") + f"<rte>{points('rtept')}</rte><trk><trkseg>{points('trkpt')}</trkseg></trk>"
    _, notes = imported(tmp_path / "all.gpx", gpx(body))
    assert notes[:2] == [
        "3 waypoints (wpt) beside the routes (rte) are not kept",
        "1 tracks (trk) beside the routes (rte) are not kept",
    ]


REFUSED = [
    (wpl(row(0, 10), row(1), row(2)), "item 1 must not be above the water: a depth is a negative altitude, but is at"),
    (wpl(row(0), row(1, command=93), row(2)), "item 2 must be a waypoint, a speed, home or the way home, but is comma"),
    (wpl(row(0), row(1, frame=10)), "item 2 must have an altitude above home or sea level, frame 0, 3, 5 or 6, but is"),
    (wpl(row(0), row(1, frame=1)), "item 2 must have an altitude above home or sea level"),
    (wpl(row(0), row(1, command=20), row(2)), "item 3 must not follow the way home"),
    (wpl(row(0).replace("43.", "x.")), "item 1 must have numbers only"),
    (wpl(row(0)).replace("\r\n1\t", "\r\n2\t"), "item 1 must be numbered from 0 without a gap, but is 2"),
    (wpl(row(0)).replace("\t1\r\n", "\r\n"), "item 0 must have 12 columns, but is 11 long"),
    (wpl(row(0).replace("43.", "143.")), "item 1 must have a latitude from -89 to 89, but is 143."),
    (wpl(row(0).replace("\t-1.5", "\tnan")), "item 1 must have an altitude, a number, but is nan"),
    (wpl(), "has no waypoints: draw at least one"),
    ("QGC WPL 120\n", "must begin with QGC WPL 110, but is 'QGC WPL 120'"),
    (qgroundcontrol({"type": "ComplexItem", "complexItemType": "survey"}), "item 1 must be a simple item, but is a 's"),
    (qgroundcontrol(waypoint(0), simple(22, 0, 0, 0, 0, 1, 2, 3)), "item 2 must be a waypoint, a speed, home or the w"),
    (qgroundcontrol(waypoint(0), simple("no", 0, 0, 0, 0, 1, 2, 3)), "but is command 'no'"),
    (qgroundcontrol(waypoint(0), simple(16, 0, 0, 0, 0, None, 2, 0)), "item 2 must have a latitude from -89 to 89, bu"),
    (qgroundcontrol(waypoint(0, hold=-1)), "item 1 must have a time to stay, param 1, from 0 to 604800, but is -1"),
    (qgroundcontrol(waypoint(0), simple(178, 1, 99, 0, 0, 0, 0, 0)), "item 2 must have a speed, param 2, from -1 to 5"),
    (qgroundcontrol(waypoint(0), simple(178, 1, 0, 0, 0, 0, 0, 0)), "item 2 must have a speed above 0, but is 0"),
    (qgroundcontrol(simple(16, 0, 0, 0, 0, 50.0, 8.0, 0)), "item 1 must be within 100 km of the origin"),
    (qgroundcontrol(waypoint(0), geoFence={"circles": [{}]}), "geoFence must have at most one polygon to stay inside"),
    (qgroundcontrol(waypoint(0), geoFence={"polygons": [{"inclusion": False, "polygon": []}]}), "geoFence must have a"),
    (qgroundcontrol(waypoint(0), geoFence={"polygons": [{"inclusion": True, "polygon": [[1], 2]}]}), "geoFence must h"),
    (qgroundcontrol(3), "item 1 must be an object, but is 3"),
    (qgroundcontrol(*[waypoint(0)] * 1001), "must have at most 1000 waypoints, but is 1001 long"),
    (qgroundcontrol(*[3] * 4000), "must have at most 1000 waypoints, but is 4000 long"),
    ('{"fileType": "Rally"}', "must have the fileType Plan, but is 'Rally'"),
    ('{"fileType": "Plan", "mission": []}', "mission must be an object, but is []"),
    ('{"fileType": "Plan"', "must be valid JSON"),
    ('{"a":' * 100_000, "must be valid JSON"),
    (gpx(""), "has no waypoints"),
    (gpx(points("wpt", 0.5, -1, -1)), "must not be above the water: a depth is a negative altitude, but is at 0.5"),
    (gpx('<wpt lat="x" lon="0"/>'), "point 1 must have a latitude from -89 to 89, but is 'x'"),
    (gpx('<wpt lat="0"/>'), "point 1 must have a longitude from -180 to 180, but is missing"),
    (gpx("<rte/><rte/>"), "must have one route or track, but is 2 routes (rte)"),
    (gpx('<wpt lat="0" lon="0"/>' * 1001), "must have at most 1000 waypoints, but is 1001 long"),
    ("<html/>", "must be GPX or KML, but is 'html'"),
    ("<gpx>", "must be valid XML"),
    ('<!DOCTYPE g [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><gpx>&b;</gpx>', "must not have a document type"),
    (kml(line() * 2), "must have one LineString, but is 2 of them"),
    (kml(line(",7", "<altitudeMode>absolute</altitudeMode>")), "point 1 must not be above the water"),
    (kml(line("", "<altitudeMode>relativeToSeaFloor</altitudeMode>")), "altitudeMode must not count altitudes from th"),
    (kml("<Point><coordinates>1</coordinates></Point>"), "point 1 must be LON,LAT or LON,LAT,ALT, but is '1'"),
    (b"PK\x03\x04", "must be a plan: .plan of QGroundControl, .waypoints, GPX or KML: unzip it first"),
    (b"\xff\xfe\x00", "must be a plan: .plan of QGroundControl, .waypoints, GPX or KML"),
    (b"QGC WPL 110\n\xff", "must be UTF-8"),
    (b"", "must be a plan"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "sentence"), REFUSED, ids=[sentence[:40] for _, sentence in REFUSED])
def test_a_plan_that_is_no_mission_is_one_sentence(content: str | bytes, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(ht.InputError) as error:
        imported(tmp_path / "bad", content)
    assert str(error.value).startswith(f"{tmp_path / 'bad'}")
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_without_end_is_bounded(tmp_path: Path) -> None:
    with pytest.raises(ht.InputError, match=r"/dev/zero must be a regular file, but is a pipe or a device"):
        read_plan("/dev/zero")
    (tmp_path / "exact").write_bytes(b" " * KINDS["plan"].largest)
    with pytest.raises(ht.InputError, match="must be a plan"):
        read_plan(tmp_path / "exact")
    (tmp_path / "longer").write_bytes(b" " * (KINDS["plan"].largest + 1))
    with pytest.raises(ht.InputError, match=r"must be at most 5 MB, but is larger: cut it, or thin it out"):
        read_plan(tmp_path / "longer")
    with pytest.raises(ht.InputError, match="is a folder: give the path of a plan"):
        read_plan(tmp_path)


@pytest.mark.parametrize("form", ["plan", "waypoints", "gpx-rte", "kml-line"])
def test_spoiled_plans_end_in_a_sentence_or_a_mission(form: str, tmp_path: Path) -> None:
    pieces = (b"", b"<", b'"', b"9", b"e9", b"-", b"\xff", b"\x00", b"null", b"[]", b"true", b"\t", b"1e400")
    content, path = SAME[form].encode(), tmp_path / "spoiled"
    missions = 0
    begin = time.monotonic()
    for seed in range(300):
        draw, spoiled = random.Random(seed), bytearray(content)
        for _ in range(draw.randint(1, 4)):
            at = draw.randrange(len(spoiled))
            spoiled[at : at + draw.choice([1, 1, 20])] = draw.choice(pieces)
        try:
            file, _ = imported(path, bytes(spoiled))
        except ht.InputError:
            continue
        missions += 1
        assert all(math.isfinite(value) for point in file.mission.waypoints for value in point)
    assert 0 < missions < 300
    assert time.monotonic() - begin < 60


# --- the command


@pytest.fixture
def run(run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    """Run `hypertuna` in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return run


def test_the_command_imports_and_the_mission_flies(run: Run, tmp_path: Path) -> None:
    Path("three.plan").write_text(SAME["plan"])
    code, output, errors = run("mission", "import", "three.plan", "-o", "three.toml", "--robot", "hypertuna")
    assert (code, errors) == (0, "")
    assert "3 waypoints, depth 1.5 m" in output
    assert "goes home" in output
    assert Path("three.toml").read_text().startswith("# Imported from three.plan.\nformat = 1")
    assert run("mission", "three.toml", "--duration", "2", "--json")[0] == 1
    code, _, errors = run("mission", "import", "three.plan", "-o", "three.toml")
    assert (code, errors) == (2, "error: three.toml exists already: give another name, or replace it with --force.\n")
    told = json.loads(
        run("mission", "import", "three.plan", "-o", "three.toml", "--force", "--speed", "0.2", "--json")[1]
    )
    assert (told["waypoints"], told["goes_home"], told["notes"]) == (3, False, [])
    assert {point.speed for point in read_mission("three.toml").mission.waypoints} == {0.2}
    Path("near.plan").write_text(qgroundcontrol(waypoint(0, radius=0.5)))
    code, _, errors = run("mission", "import", "near.plan", "-o", "near.toml", "--robot", "hypertuna")
    assert code == 2
    assert errors.startswith("error: near.plan: item 1: radius_m must be at least 1.9 m")
    assert not Path("near.toml").exists()


@pytest.mark.parametrize(
    ("option", "value"), [("--speed", "0"), ("--speed", "nan"), ("--speed", "6"), ("--depth", "-1")]
)
def test_options_of_import_are_checked(option: str, value: str, run: Run) -> None:
    Path("a.plan").write_text(SAME["plan"])
    code, _, errors = run("mission", "import", "a.plan", "-o", "a.toml", option, value)
    assert code == 2
    assert errors.startswith("error: ")
    assert errors.count("\n") == 1
    assert not Path("a.toml").exists()


def test_a_plan_in_place_of_a_mission_names_the_command(run: Run) -> None:
    Path("a.plan").write_text(SAME["plan"])
    code, _, errors = run("mission", "a.plan")
    assert code == 2
    assert (
        errors
        == "error: a.plan is a plan, not a mission: `hypertuna mission import a.plan -o a.toml` makes one of it.\n"
    )


def test_commands_that_a_mission_cannot_keep_have_the_numbers_of_mavlink() -> None:
    mavlink = pytest.importorskip("pymavlink.dialects.v20.common", reason="needs the extra radio")
    for number, name in UNSUPPORTED.items():
        assert name.upper().replace("LANDING", "LAND").replace("-", "") in mavlink.enums["MAV_CMD"][number].name
    numbers = (mavlink.MAV_CMD_NAV_WAYPOINT, mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    assert (*numbers, mavlink.MAV_CMD_DO_CHANGE_SPEED, mavlink.MAV_CMD_DO_SET_HOME) == (
        *(WAYPOINT, GO_HOME, SPEED, SET_HOME),
    )
