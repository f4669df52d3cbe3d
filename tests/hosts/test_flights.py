"""Flights of the C interface are those of `hypertuna mission`: native and in WebAssembly, by the same pilot."""

import functools
import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from host_library import Host, InNode, Native, Robot, Twin
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.control.sensors import KINDS
from hypertuna.mission import image
from hypertuna.mission.file import missions, parse_mission, randomized, read_mission
from hypertuna.mission.flight import Flight, fly
from hypertuna.mission.image import robot_image
from hypertuna.mission.mishaps import FIN_KINDS
from hypertuna.mission.run import fly_part, mission_start


@pytest.fixture(scope="module", params=[Native, InNode], ids=["native", "wasm"])
def host(request: pytest.FixtureRequest) -> Iterator[Host]:
    """Where the core runs."""
    host: Native | InNode = request.param()
    yield host
    host.close()


@functools.cache
def flown(name: str, seed: int, ticks: int, faults: tuple[str, ...] = ()) -> dict[str, Array]:
    """Fly the begin of a mission in Python: all columns, a row per tick."""
    robot = ht.load("hypertuna")
    start = mission_start(robot, randomized(read_mission(name), seed), seed=seed, faults=faults, every=1)
    return fly_part(start, ticks)[0]


@functools.cache
def without_depth() -> Flight:
    """Fly the box in Python with a depth sensor that breaks."""
    return fly("box", "hypertuna", faults=["depth:nan@15"], every=1)


@functools.cache
def in_pond(seed: int) -> Flight:
    """Fly over the pond in Python."""
    return fly(parse_mission(POND), "hypertuna", seed=seed, every=1)


def pilot(host: Host) -> Robot:
    """Read the robot that has a pilot."""
    read = Robot.read(robot_image(ht.load("hypertuna")), host)
    assert isinstance(read, Robot)
    return read


def flight(robot: Robot, name: str, seed: int) -> Twin:
    """Begin a mission of an image."""
    return Twin(robot, [one["name"] for one in json.loads(robot.text)["missions"]].index(name), seed=seed)


def same_as_python(last: dict[str, Array], part: dict[str, Array], tick: int) -> None:
    """Assert that all columns of twin and pilot are those of Python's flight at a tick."""
    compared = last.keys() & part.keys()
    assert compared == part.keys() - {"ticks"}
    for name in compared:
        wanted = np.atleast_1d(part[name][tick])
        assert last[name] == pytest.approx(wanted, rel=1e-9, abs=1e-9), (tick, name)
    assert last["time"] == pytest.approx(0.01 * tick)


@pytest.mark.parametrize("name", ["lake", "box"])
def test_flight_is_that_of_python(host: Host, name: str) -> None:
    """60 s of a mission whose seed adds a current."""
    part, twin = flown(name, 3, 6000), flight(pilot(host), name, 3)
    for until in (1, 1500, 6000):
        same_as_python(twin.advance(until - twin.made), part, until - 1)


def test_faults_come_as_in_python(host: Host) -> None:
    """A fin's servo that stands, and a compass that reads too much: 2 s of it end the mission, 3 s the flight."""
    part = flown("box", 0, 2250, ("fin-port:up@10", "field:spike@20"))
    robot = pilot(host)
    twin, names = flight(robot, "box", 0), json.loads(robot.text)["pilot"]
    twin.advance(1000)
    twin.jam(0, 1 + names["fin_faults"].index("up"))
    twin.advance(1000)
    twin.fail(1 + KINDS.index("spike"), *names["channels"]["field"])
    same_as_python(twin.advance(250), part, 2249)


def test_saved_flight_goes_on_to_the_same_bits(host: Host) -> None:
    twin = flight(pilot(host), "transect", 4)
    twin.advance(300)
    state = twin.state
    first = twin.advance(200)
    assert twin.restore(state)
    again = twin.advance(200)
    assert all(np.array_equal(first[name], again[name], equal_nan=True) for name in first)
    other = flight(twin.robot, "transect", 4)
    assert other.restore(state)
    again = other.advance(200)
    assert all(np.array_equal(first[name], again[name], equal_nan=True) for name in first)


# --- how a flight ends


def ended(last: dict[str, Array], robot: Robot) -> tuple[str, set[str]]:
    """Return how a flight ended, and the pilot's reasons."""
    names = json.loads(robot.text)["pilot"]
    reasons = {one["name"] for bit, one in enumerate(names["reasons"]) if int(last["reasons"][0]) >> bit & 1}
    return (["", *(one["name"] for one in names["endings"])][int(last["ending"][0])], reasons)


def test_flight_that_cannot_dive_comes_home_as_in_python(host: Host) -> None:
    """Without a depth sensor the robot turns back, and the flight ends there: further ticks are not made."""
    python, robot = without_depth(), pilot(host)
    twin, names = flight(robot, "box", 0), json.loads(robot.text)["pilot"]
    twin.advance(1500)
    twin.fail(1 + KINDS.index("nan"), *names["channels"]["depth"])
    end = twin.advance(100_000)
    status, reasons = ended(end, robot)
    assert status == "home"
    assert "depth_lost" in reasons
    assert end["reasons"][0] == python.record.data["reasons"][-1]
    assert python.status == status
    assert twin.made == len(python.record.time)
    last = twin.read()
    assert last["position"] == pytest.approx(python.record.position[-1], rel=1e-9, abs=1e-9)
    assert last["charge_left"] == pytest.approx(python.record.data["charge_left"][-1])
    assert names["modes"][int(last["mode"][0])]["name"] == "ended"
    twin.advance(10)
    assert twin.made == len(python.record.time)


POND = {
    "format": 1,
    "name": "pond",
    "start": {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0},
    "waypoints": [{"x_m": 0.0, "y_m": 8.0, "depth_m": 0.5, "speed_m_s": 0.4, "radius_m": 3.0}],
    "water": {"bottom_m": 3.0, "current_m_s": 0.05, "current_deg": 90.0, "current_bottom_m_s": 0.02},
    "gps": {"gaps_s": [[3.0, 6.0]]},
    "limits": {
        "fence_m": [[-30, -30], [30, -30], [30, 30], [-30, 30]],
        "depth_m": 2.0,
        "battery": 0.2,
        "duration_s": 400.0,
    },
    "scatter": {"current_m_s": 0.05, "gaps": 5, "gap_s": 20.0},
}


def test_whole_flight_is_that_of_python(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    """There and back again in a current that fades with depth, with gaps between the fixes, scattered by the seed."""
    file = parse_mission(POND)
    monkeypatch.setattr(image, "missions", lambda: ["pond"])
    monkeypatch.setattr(image, "read_mission", lambda _: file)
    robot = pilot(host)
    for seed in (0, 3):
        python, twin = in_pond(seed), flight(robot, "pond", seed)
        last = twin.advance(100_000)
        assert (ended(last, robot)[0], python.status) == ("done", "done")
        # A flight is + - * / and sqrt, which all machines round alike: without scatter all bits are Python's. A seed's
        # current has a sine of the C library, and is added before Python computes the shear, but after it here: 1e-17
        # m/s. The difference grows tenfold in 20 s, to 1e-8 m after 148 s, when a rate of the gyroscope rounds to
        # another count: 1e-6 m a second later, and 1e-2 m at the end.
        near = 3e-2 if seed else 0.0
        assert abs(twin.made - len(python.record.time)) <= (20 if seed else 0)
        assert last["position"] == pytest.approx(python.record.position[-1], abs=near, rel=0.0)
        assert last["charge"] == pytest.approx(python.record.data["charge"][-1], rel=near, abs=0.0)


def test_flight_without_time_left_is_given_up(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(image, "mission_start", functools.partial(mission_start, duration=1.5))
    robot = pilot(host)
    twin = flight(robot, "box", 0)
    assert ended(twin.advance(149), robot)[0] == ""
    assert ended(twin.advance(10), robot)[0] == "given up"
    assert twin.made == 150


def test_flight_of_a_mission_that_is_not_there_is_refused(host: Host) -> None:
    robot = pilot(host)
    count = robot.count("missions")
    assert count == len(missions()) == 3
    for mission in (count, (1 << 32) - 1):
        assert Twin(robot, mission, seed=0).fault.startswith("flight: there is no mission ")
    for name in ("examples/servofish.toml", "rexeel"):
        other = Robot.read(robot_image(ht.load(name)), host)
        assert isinstance(other, Robot)
        assert other.count("missions") == 0
        assert Twin(other, 0, seed=0).fault.startswith("flight: the robot has no pilot")
        assert (json.loads(other.text)["missions"], json.loads(other.text)["pilot"]) == ([], None)


# --- the text


def test_text_describes_the_missions() -> None:
    text = text_of("hypertuna")
    for one, name in zip(text["missions"], missions(), strict=True):
        file = read_mission(name)
        assert (one["name"], one["text"]) == (file.name, file.description)
        assert one["waypoints"] == [list(point) for point in file.mission.waypoints]
        assert one["fence"] == [list(corner) for corner in file.mission.fence]
        assert (one["start"], one["home"]) == ([*file.mission.start], [*file.mission.home])
        assert (one["current"], one["bottom"]) == ([*file.mission.current], file.mission.bottom)
    assert [(one["name"], one["text"]) for one in text["pilot"]["modes"]] == _core.mode_table()
    assert [(one["name"], one["text"]) for one in text["pilot"]["reasons"]] == _core.reason_table()
    assert text["pilot"]["channels"].keys() > text["twin"]["channels"].keys() | {"depth", "field"}
    assert text["pilot"]["fin_faults"] == [*FIN_KINDS]


def text_of(name: str) -> dict[str, Any]:
    """Return the text of an image, read by the library of this machine."""
    host = Native()
    read = Robot.read(robot_image(ht.load(name)), host)
    assert isinstance(read, Robot)
    text: dict[str, Any] = json.loads(read.text)
    return text
