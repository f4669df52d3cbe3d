"""The C interface of hosts/device.h: a twin under commands, its pilot, its saved state, and what is refused."""

from collections.abc import Iterator
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p, create_string_buffer
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from host_library import ROOM, Native, Robot, Start, Twin, row
from hypertuna.arrays import Array
from hypertuna.description.robot import parse
from hypertuna.mission.image import robot_image
from hypertuna.simulation.twin import twins

ROBOT = ht.load("hypertuna")
GAIT = ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 40))
AT_SEA: dict[str, Any] = {"sea": 1, "depth": 2.0, "heading": 0.5, "speed": 0.2, "current": (0.1, -0.05)}
RETURNS = {"create": c_void_p, "tick": c_double, "column": c_char_p, "state_size": c_size_t}


@pytest.fixture(scope="module")
def host() -> Iterator[Native]:
    host = Native()
    for name, kind in RETURNS.items():
        getattr(host.lib, f"ht_device_{name}").restype = kind
    yield host
    host.close()


class Device:
    """A device by ctypes; `fault` is why there is none."""

    def __init__(self, host: Native, image: bytes | None, plant: int = 0, room: int = ROOM, **start: Any) -> None:
        given = Start(**{"bottom": np.inf, "current": (c_double * 2)(*start.pop("current", (0, 0)))} | start)
        self.host, fault = host, create_string_buffer(b"?" * (ROOM - 1))
        size, text = c_size_t(len(image or b"")), fault if room else None
        self.handle = c_void_p(self("create", image, size, byref(given), plant, text, c_size_t(room)))
        self.fault = fault.value.decode()

    def __call__(self, name: str, *args: Any) -> Any:
        """Call a function, of this device unless it makes one."""
        own = () if name == "create" else (self.handle,)
        return getattr(self.host.lib, f"ht_device_{name}")(*own, *args)

    def __del__(self) -> None:
        """Free the device; null is free."""
        self("free")

    def command(self, gait: ht.Gait) -> None:
        """Command a gait, with level fins."""
        self("command", row(gait).ctypes, (c_double * 2)(), 1)

    def columns(self) -> dict[str, int]:
        """Widths of the columns."""
        widths, width = dict[str, int](), c_int()
        while name := self("column", len(widths), byref(width)):
            widths[name.decode()] = width.value
        return widths

    def read(self) -> dict[str, Array]:
        """Return all columns."""
        widths = self.columns()
        out = np.zeros(sum(widths.values()))
        self("read", out.ctypes)
        return dict(zip(widths, np.split(out, np.cumsum(list(widths.values()))[:-1]), strict=True))

    def save(self) -> bytes:
        """Return the state."""
        state = create_string_buffer(self("state_size"))
        self("save", state)
        return state.raw


def same(one: dict[str, Array], other: dict[str, Array]) -> bool:
    return all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


def test_it_swims_as_the_twin_of_hypertuna_h_to_the_bit(host: Native) -> None:
    """A pilot reads its sensors beside the command; as long as it does not steer, nothing else changes."""
    image = robot_image(ROBOT)
    robot = Robot.read(image, host)
    assert isinstance(robot, Robot)
    device, twin = Device(host, image, seed=4, **AT_SEA), Twin(robot, seed=4, **AT_SEA)
    assert device("joints") == 2
    assert device("tick") == 0.01
    device.command(GAIT)
    twin.command(GAIT)
    for _ in range(5):
        device("advance", 40)
        before = device.read()
        device("advance", 1)
        last = twin.advance(41)
        for name in ("position", "attitude", "velocity", "angle", "fin"):  # of the start of a tick; here of now
            assert np.array_equal(before[name], last[name]), name
        assert np.array_equal(device.read()["pulse"], last["pulse"])
    assert np.hypot(*before["position"][:2]) > 0.4
    assert device("column", -1, byref(c_int())) is None
    assert device("column", len(device.columns()), byref(c_int())) is None


@pytest.mark.parametrize("start", [{}, {"sea": 1, "depth": 1.0}], ids=["plane", "sea"])
def test_a_tick_that_breaks_the_plant_is_not_made(host: Native, start: dict[str, Any]) -> None:
    """Python's record ends before that tick too, also in a batch. No tick is made behind it."""
    document = ROBOT.document()
    document["links"]["lateral_area_m2"][-1] = 300
    wild = parse(document)
    ways, swim = ({"depth": 1}, ht.twin_at_sea) if start else ({"start": "rest"}, ht.twin)
    runs = [swim(wild, GAIT, seed=1, duration=1, **ways)]
    whole = len(runs[0].time)
    ends = [swim(wild, GAIT, seed=1, duration=0.01 * ticks, **ways) for ticks in (whole, whole + 1)]
    if not start:
        two = [{"robot": wild, "gait": GAIT, "seed": 1, "duration": 1, **ways}] * 2
        runs += twins(two, measure=lambda run: run)
    assert [len(run.time) for run in (*runs, *ends)] == [whole] * (len(runs) + 2)
    assert [run.status for run in (*runs, *ends)] == ["diverged"] * len(runs) + ["completed", "diverged"]
    robot = Robot.read(robot_image(wild), host)
    assert isinstance(robot, Robot)
    for ticks in (whole + 1, whole, 1):
        device, twin = Device(host, robot_image(wild), seed=1, **start), Twin(robot, seed=1, **start)
        device.command(GAIT)
        twin.command(GAIT)
        made = [(device("advance", ticks), host.call("ht_twin_advance", twin.handle, ticks)) for _ in range(whole + 2)]
        assert np.sum(made, axis=0).tolist() == [whole, whole]
        assert made[-1] == (0, 0)


def test_a_pilot_steers_and_its_state_is_saved(host: Native) -> None:
    image = robot_image(ROBOT)
    first, other = Device(host, image, seed=4, **AT_SEA), Device(host, image, seed=4, **AT_SEA)
    for device in (first, other):
        device.command(GAIT)
        assert device("steer", 1, c_double(4.0), c_double(1.5)) == 1
    assert first("advance", 455) == 455
    other("advance", 30)
    state = first.save()
    before = first.read()
    assert before["fin"].max() < -0.3  # down
    assert other("restore", state, c_size_t(len(state) - 1)) == 0
    assert not same(before, other.read())
    assert other("restore", state, c_size_t(len(state))) == 1
    assert same(before, other.read())
    for device in (first, other):
        device("advance", 300)
    assert same(first.read(), other.read())
    assert first.read()["position"][2] < -2.1


def test_depths_that_no_sensor_reads_are_held_at_its_range(host: Native) -> None:
    deepest = next(one.high for one in ROBOT.sensors if one.quantity == "depth")
    rows = []
    for depth in (deepest, 1e9, 0.0, -1e9):
        device = Device(host, robot_image(ROBOT), seed=1, **AT_SEA)
        device.command(GAIT)
        device("steer", 1, c_double(depth), c_double(0.5))
        device("advance", 300)
        rows.append(device.read())
    assert same(*rows[:2])
    assert same(*rows[2:])
    assert rows[0]["position"][2] < rows[2]["position"][2]


def test_without_a_pilot_none_steers(host: Native) -> None:
    document = ROBOT.document()
    del document["guidance"]
    document["sources"] = {key: text for key, text in document["sources"].items() if not key.startswith("guidance")}
    image = robot_image(ROBOT)
    devices = {
        "plane": Device(host, image),
        "plant": Device(host, image, plant=1, **AT_SEA),
        "no pilot": Device(host, robot_image(parse(document)), **AT_SEA),
    }
    for name, device in devices.items():
        assert device.handle, device.fault
        assert device("steer", 1, c_double(4.0), c_double(0.0)) == 0, name


def test_what_is_no_image_is_refused_with_a_sentence(host: Native) -> None:
    image = robot_image(ROBOT)
    wrong = {
        None: "image: is shorter than a header; write it again",
        b"PK" + image[2:]: "image: is not a robot image; write one with `hypertuna robot image`",
        image[:-8]: "image: is cut off or has bytes too many",
        robot_image(ht.load("rexeel")): "twin: the robot has no controller; describe one and write the image again",
    }
    for content, sentence in wrong.items():
        device = Device(host, content)
        assert device.handle.value is None
        assert device.fault == sentence
    assert Device(host, image).fault == ""
    # As much of the sentence as there is room for; none is asked for by null.
    assert Device(host, b"", room=6).fault == "image"
    assert Device(host, b"", room=0).handle.value is None
    assert Device(host, image, room=0).handle.value
