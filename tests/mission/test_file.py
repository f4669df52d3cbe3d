"""Mission files: what they say, the errors of bad ones, and that any file ends in a mission or one sentence."""

from __future__ import annotations

import copy
import math
import random
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from figures_reference import sections
from hypothesis import given
from hypothesis import strategies as st

import hypertuna as ht
from hypertuna.frames import pose_to
from hypertuna.mission.file import MissionFile, missions, parse_mission, randomized, read_mission
from hypertuna.mission.geodesy import from_local, to_local
from hypertuna.mission.schema import Document

SHIPPED = Path(__file__).parents[2] / "missions"
SEEDS = 400  # of the fuzz


def document() -> dict[str, Any]:
    """A mission with every table."""
    return {
        "format": 1,
        "name": "test",
        "origin": {"latitude_deg": 43.85, "longitude_deg": 125.3, "declination_deg": -10.0},
        "start": {"x_m": 1.0, "y_m": 2.0, "heading_deg": 90.0, "depth_m": 0.5, "battery": 0.8},
        "waypoints": [{"x_m": 10.0, "y_m": 20.0, "depth_m": 1.0, "speed_m_s": 0.3, "radius_m": 2.0, "hold_s": 30.0}],
        "home": {"x_m": 5.0, "y_m": 5.0},
        "water": {"bottom_m": 4.0, "current_m_s": 0.1, "current_deg": 90.0, "current_bottom_m_s": 0.0},
        "limits": {
            "fence_m": [[-50, -50], [50, -50], [50, 50], [-50, 50]],
            "depth_m": 3.0,
            "battery": 0.2,
            "duration_s": 600.0,
            "silence_below": True,
        },
        "gps": {"surface_every_s": 120.0, "gaps_s": [[10.0, 20.0], [30.0, 40.0]]},
        "scatter": {"current_m_s": 0.2, "gaps": 3, "gap_s": 50.0},
    }


def put(where: str, value: Any) -> dict[str, Any]:
    """The mission with another value at a place such as waypoints.0.x_m; ... removes what stands there."""
    changed = document()
    part: Any = changed
    *tables, last = (int(name) if name.isdigit() else name for name in where.split("."))
    for name in tables:
        part = part[name]
    if value is ...:
        del part[last]
    else:
        part[last] = value
    return changed


def test_a_waypoint_without_a_radius_has_that_of_the_board() -> None:
    """As `NAV_WAYPOINT` with a radius of 0 (firmware/tests/radio/test_missions.cpp)."""
    assert parse_mission(put("waypoints.0.radius_m", ...)).mission.waypoints[0].radius == 3.0


# --- what they say


def test_a_mission_in_our_frames() -> None:
    read = parse_mission(document())
    mission = read.mission
    assert mission.waypoints[0] == (10, 20, 1, 0.3, 2, 30)
    assert (mission.start, mission.home, mission.depth, mission.battery) == ((1, 2), (5, 5), 0.5, 0.8)
    north, east, heading = pose_to("ned", [0, 0, mission.heading])
    assert (north, east, heading) == pytest.approx((0, 0, math.pi / 2))  # the head faces east: the tail points west
    assert math.cos(mission.heading) == pytest.approx(-1)
    assert mission.current == pytest.approx((0.1, 0))  # toward east
    assert mission.current_bottom == pytest.approx((0, 0))
    assert (mission.bottom, mission.depth_max, mission.reserve, mission.duration) == (4, 3, 0.2, 600)
    assert read.declination == mission.declination
    assert (mission.silence_below, mission.declination) == (True, pytest.approx(math.radians(-10)))
    assert mission.gaps == ((10, 20), (30, 40))
    assert mission.surface_every == 120
    assert read.origin == pytest.approx((math.radians(43.85), math.radians(125.3)))


def test_what_is_left_out() -> None:
    bare = {key: document()[key] for key in ("format", "name", "start", "waypoints")}
    mission = parse_mission(bare).mission
    assert mission.home == mission.start
    assert (mission.fence, mission.duration, mission.gaps, mission.current) == ((), 0, (), (0, 0))
    uniform = parse_mission(put("water", {"current_m_s": 0.2, "current_deg": 180.0})).mission
    assert uniform.current == uniform.current_bottom == pytest.approx((0, -0.2))


def test_places_by_latitude_and_longitude() -> None:
    there = np.degrees(from_local((math.radians(43.85), math.radians(125.3)), [10.0, 20.0]))
    point = {"latitude_deg": float(there[0]), "longitude_deg": float(there[1]), "speed_m_s": 0.3, "radius_m": 2.0}
    mission = parse_mission(put("waypoints.0", point)).mission
    assert mission.waypoints[0][:2] == pytest.approx((10, 20), abs=1e-6)
    assert from_local((0.7, 2.0), np.zeros((1, 2))) == pytest.approx(np.array([[0.7, 2.0]]))  # a track of one place


def test_the_hash_is_of_what_matters() -> None:
    plain = parse_mission(document()).hash
    assert parse_mission(document() | {"description": "other words"}).hash == plain
    assert parse_mission(put("waypoints.0.x_m", 10.5)).hash != plain
    assert parse_mission(put("scatter.gaps", 4)).hash != plain
    assert parse_mission(put("waypoints.0.hold_s", 31.0)).hash != plain
    assert parse_mission(put("limits.silence_below", False)).hash != plain
    assert parse_mission(put("origin.declination_deg", -11.0)).hash != plain


def test_a_mission_without_later_keys_keeps_its_hash() -> None:
    """The hash seeds the scatter of a mission: stored flights of version 0.2 repeat."""
    assert read_mission("box").hash[:8] == "f076cb4e"


@pytest.mark.parametrize("name", missions())
def test_shipped_missions(name: str) -> None:
    read = read_mission(name)
    assert read.name == name
    assert read.robot in ht.robots()
    assert read == read_mission(SHIPPED / f"{name}.toml") or read.hash == read_mission(SHIPPED / f"{name}.toml").hash


def test_the_lake_is_the_paper_s_800_m() -> None:
    mission = read_mission("lake").mission
    course = np.array([mission.start, *(point[:2] for point in mission.waypoints), mission.home])
    assert np.hypot(*np.diff(course, axis=0).T).sum() == 800
    assert {point.speed for point in mission.waypoints} == {0.5}


def test_the_transect_is_against_the_current() -> None:
    mission = read_mission("transect").mission
    way = np.subtract(mission.waypoints[0][:2], mission.start)
    assert np.dot(way, mission.current) < 0 < -mission.current[0]
    assert abs(mission.current_bottom[0]) < abs(mission.current[0])


# --- seeds


def test_a_seed_draws_its_own_water_within_bounds() -> None:
    read = parse_mission(document())
    assert randomized(read, 0) is read.mission
    drawn_ = [randomized(read, seed) for seed in range(1, 101)]
    added = np.array([m.current for m in drawn_]) - read.mission.current
    speed = np.hypot(*added.T)
    assert speed.max() <= 0.2
    assert 0.08 < speed.mean() < 0.12  # even from 0 to 0.2: 0.1 +- 0.006
    assert len({m.current for m in drawn_}) == 100
    for mission in drawn_:
        edges = np.array(mission.gaps).ravel()
        assert (np.diff(edges) > 0).all()
        assert np.subtract(mission.current, mission.current_bottom) == pytest.approx(
            np.subtract(read.mission.current, read.mission.current_bottom)
        )
    assert randomized(read, 7) == randomized(parse_mission(document()), 7)
    with pytest.raises(ht.InputError, match="seed must not be negative"):
        randomized(read, -1)


# --- errors of bad ones


@pytest.mark.parametrize(
    ("where", "value", "sentence"),
    [
        ("format", 2, "format must be 1, but is 2"),
        ("name", ..., "name is missing: give the name of the mission"),
        ("nmae", "x", "nmae is not a known key: did you mean name?"),
        ("waypoints", [], "waypoints must not be empty"),
        ("waypoints.0.speed_m_s", 0.0, "waypoints[0].speed_m_s must be greater than 0, but is 0.0: give the speed"),
        ("waypoints.0.speed_m_s", 30.0, "waypoints[0].speed_m_s must be at most 5, but is 30.0"),
        ("waypoints.0.radius_m", -1.0, "waypoints[0].radius_m must be greater than 0, but is -1.0"),
        ("waypoints.0.x_m", "ten", "waypoints[0].x_m must be a number, but is 'ten': give the east of the origin [m]"),
        ("waypoints.0.x_m", math.nan, "waypoints[0].x_m must be a finite number"),
        ("waypoints.0.x_m", ..., "waypoints[0] must have x_m and y_m: give both in m"),
        ("waypoints.0.latitude_deg", 43.0, "waypoints[0] must be x_m and y_m, or latitude_deg and longitude_deg, not"),
        ("waypoints.0.depth_m", -1.0, "waypoints[0].depth_m must not be negative"),
        (
            "waypoints.0.depth_m",
            4.0,
            "waypoints[0].depth_m must be less than water.bottom_m = 4, the depth of the ground",
        ),
        (
            "waypoints.0.depth_m",
            3.5,
            "waypoints[0].depth_m must be at most limits.depth_m = 3, but is 3.5: reduce it, or raise limits.depth_m",
        ),
        (
            "waypoints.0.x_m",
            60.0,
            "waypoints[0] must be inside limits.fence_m, but is at 60, 20 m: move the point inside",
        ),
        ("home.x_m", -60.0, "home must be inside limits.fence_m, but is at -60, 5 m"),
        ("start.y_m", 60.0, "start must be inside limits.fence_m"),
        ("start.depth_m", 5.0, "start.depth_m must be less than water.bottom_m = 4, the depth of the ground"),
        ("start.heading_deg", ..., "start.heading_deg is missing: give the direction that the head faces, clockwise"),
        ("start.battery", 1.5, "start.battery must be at most 1"),
        ("limits.fence_m", [[0, 0], [1, 1]], "limits.fence_m must have 3 to 64 corners, but is 2: give [[x, y]"),
        ("limits.fence_m", [[0, 0], [0, 0], [1, 1]], "limits.fence_m[0] must not repeat the corner before it"),
        ("limits.fence_m", [[-50, -50], [50, 50], [50, -50], [-50, 50]], "must not have sides that cross, as those"),
        ("limits.fence_m", [[0, 0], [1, 1], [2, 2]], "limits.fence_m must enclose an area"),
        ("limits.fence_m", [[0, 0], [1e6, 0], [0, 1]], "limits.fence_m[1] must be within 100 km of the origin"),
        ("limits.fence_m", [[0.0, 0.0, 0.0]], "limits.fence_m[0] must have at most 2 values, but is [0.0, 0.0, 0.0]"),
        (
            "limits.fence_m",
            [[-40, -40], [40, -40], [40, 40], [8, 40], [8, 10], [12, 10], [6, 6], [-1, 40], [-40, 40]],
            "waypoints[0] must be reachable on a straight course inside limits.fence_m: add a waypoint on the way",
        ),
        ("scatter.gap_s", 0.0, "scatter.gap_s must be greater than 0 if scatter.gaps is, but is 0"),
        ("name", "a\x1b[31m", "none of them a control character"),
        ("limits.battery", 1.0, "limits.battery must be less than 1"),
        ("limits.duration_s", 0.0, "limits.duration_s must be greater than 0"),
        (
            "gps.gaps_s",
            [[5.0, 1.0]],
            "gps.gaps_s[0] must be [from, to], the first time before the second, but is [5.0, 1.0]",
        ),
        ("gps.gaps_s", [[5.0, 9.0], [8.0, 10.0]], "gps.gaps_s[1] must begin after the previous gap ends at 9 s"),
        ("water.current_m_s", 9.0, "water.current_m_s must be at most 5"),
        ("origin.latitude_deg", 95.0, "origin.latitude_deg must be at most 89"),
    ],
)
def test_bad_missions_are_told_key_rule_value_and_fix(where: str, value: Any, sentence: str) -> None:
    with pytest.raises(ht.InputError) as error:
        parse_mission(put(where, value), file="bad.toml")
    told = str(error.value)
    assert told.startswith("bad.toml: ")
    assert sentence in told
    assert "\n" not in told


def test_sides_in_one_line_do_not_cross() -> None:
    """A pier that stands into the water from the south: two sides lie on one line, apart."""
    pier = [[-50, -50], [20, -50], [20, 0], [25, 0], [25, -50], [50, -50], [50, 50], [-50, 50]]
    assert len(parse_mission(put("limits.fence_m", pier)).mission.fence) == 8
    flat = [[-50, -50], [20, -50], [10, -50], [50, -50], [50, 50], [-50, 50]]
    with pytest.raises(ht.InputError, match="must not have sides that cross"):
        parse_mission(put("limits.fence_m", flat))


def test_without_an_origin_no_latitude() -> None:
    point = {"latitude_deg": 43.0, "longitude_deg": 125.0, "speed_m_s": 0.3, "radius_m": 2.0}
    changed = put("waypoints.0", point)
    del changed["origin"]
    with pytest.raises(ht.InputError, match=r"waypoints\[0\].latitude_deg needs the table \[origin\]"):
        parse_mission(changed)


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(ht.InputError, match=r"nowhere.toml must be a file, but is missing"):
        read_mission(tmp_path / "nowhere.toml")
    with pytest.raises(ht.InputError, match=r"did you mean lake\?"):
        read_mission("lak")
    (tmp_path / "bad.toml").write_text("format = \n")
    with pytest.raises(ht.InputError, match=r"bad.toml must be valid TOML, but is not"):
        read_mission(tmp_path / "bad.toml")


def test_every_key_is_documented() -> None:
    page = (Path(__file__).parents[2] / "docs" / "missions.md").read_text()
    assert sections(Document) in page


# --- any file at all

JUNK = (
    None, True, -1, 0, 1, 1e308, -1e308, 10**400, math.nan, math.inf, -math.inf, "", "north", "\0", [], [[]], {}, [1],
    [[0, 0], [0, 0], [0, 0]], [[1e308, -1e308]] * 4, {"x_m": 1}, [{}], 1e-320, "1.0", [None],
)  # fmt: skip


BYTES = (b"", b"9", b"-", b"e", b".", b"[", b'"', b"=", b"\n", b"\xff", b"nan")


def places(part: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """All places of a document."""
    children = part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ()
    return [path] * bool(path) + [deeper for key, value in children for deeper in places(value, (*path, key))]


def spoiled(whole: dict[str, Any], seed: int) -> dict[str, Any]:
    """The document with one to three things replaced, removed, doubled or added."""
    draw, changed = random.Random(seed), copy.deepcopy(whole)
    for _ in range(draw.randint(1, 3)):
        *path, last = draw.choice(places(changed) or [("name",)])
        part: Any = changed
        for key in path:
            part = part[key]
        action = draw.choice(["replace", "replace", "remove", "double", "add"])
        if action == "replace" or (action == "double" and isinstance(part, dict)):
            part[last] = copy.deepcopy(draw.choice(JUNK))
        elif action == "double":
            part.insert(last, copy.deepcopy(part[last]))
        elif action == "add" and isinstance(part, dict):
            part[draw.choice(["x", "y_m", "latitude_deg", "depth_m", "format"])] = draw.choice(JUNK)
        else:
            del part[last]
    return changed


def tried(call: Callable[..., MissionFile], *arguments: Any, **options: Any) -> tuple[MissionFile | None, str]:
    """What a call returns, or says is wrong."""
    try:
        return call(*arguments, **options), ""
    except ht.InputError as error:
        return None, str(error)


def _sentences(told: str) -> bool:
    """Whether an error is one sentence, or several numbered ones below a first line."""
    first, *others = told.splitlines()
    numbered = all(line.startswith(f"  {number}. ") for number, line in enumerate(others, 1))
    return first.startswith("spoiled.toml") and numbered and len(others) != 1


def test_spoiled_documents_end_in_a_sentence() -> None:
    good = bad = 0
    for seed in range(5 * SEEDS):
        mission, sentence = tried(parse_mission, spoiled(document(), seed), file="spoiled.toml")
        good, bad = good + (mission is not None), bad + (mission is None)
        assert mission is None or all(math.isfinite(value) for point in mission.mission.waypoints for value in point)
        assert mission is not None or _sentences(sentence)
    assert bad > good > 0


@pytest.mark.parametrize("name", missions())
def test_spoiled_texts_end_in_a_sentence(name: str, tmp_path: Path) -> None:
    text, path = (SHIPPED / f"{name}.toml").read_bytes(), tmp_path / "spoiled.toml"
    for seed in range(SEEDS):
        draw = random.Random(seed)
        content = bytearray(text)
        for _ in range(draw.randint(1, 8)):
            at = draw.randrange(len(content))
            width = draw.choice([1, 1, 1, 20])
            content[at : at + width] = draw.choice(
                [b"", b"9", b"-", b"e", b".", b"[", b'"', b"=", b"\n", b"\xff", b"nan"]
            )
        path.write_bytes(content[: draw.randrange(len(content))] if draw.random() < 0.2 else content)
        mission, sentence = tried(read_mission, path)
        assert mission is not None or sentence.startswith(str(path))


# --- the Earth


def test_a_minute_of_latitude_is_a_nautical_mile() -> None:
    """By definition of the mile: 1852 m on average, 1843 m at the equator, 1862 m at the poles."""
    for latitude, mile in ((0.0, 1842.9), (45.0, 1852.2), (88.0, 1861.6)):
        there = to_local((math.radians(latitude), 0.0), math.radians(latitude + 1 / 60), 0.0)
        assert there == pytest.approx([0, mile], abs=0.3)


@given(latitude=st.floats(-89, 89), longitude=st.floats(-180, 180), x=st.floats(-1e5, 1e5), y=st.floats(-1e5, 1e5))
def test_back_and_forth(latitude: float, longitude: float, x: float, y: float) -> None:
    origin = math.radians(min(max(latitude, -85), 85)), math.radians(longitude)
    there = from_local(origin, [x, y])
    assert to_local(origin, there[0], there[1]) == pytest.approx([x, y], abs=1e-6)


def test_names_of_missions_are_words() -> None:
    assert all(re.fullmatch(r"[a-z]+", name) for name in missions())
    assert all(tomllib.loads((SHIPPED / f"{name}.toml").read_text())["name"] == name for name in missions())


def test_a_depth_limit_below_the_ground_is_refused() -> None:
    place = {"x_m": 0.0, "y_m": 0.0}
    document = {
        "format": 1,
        "name": "shallow",
        "start": place | {"heading_deg": 0.0},
        "waypoints": [place | {"speed_m_s": 0.3, "radius_m": 3.0, "depth_m": 1.0}],
        "water": {"bottom_m": 4.0},
    }
    with pytest.raises(
        ht.InputError, match=r"limits.depth_m must be less than water.bottom_m = 4, .* but is 5: reduce it"
    ):
        parse_mission(document)
    parse_mission(document | {"limits": {"depth_m": 3.5}})
