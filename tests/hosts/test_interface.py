"""The C interface says what Python says: settled gaits, derivatives, paths, twins; and refuses damaged images.

Each test runs twice: in the shared library of this machine, and in Node.js in the WebAssembly that browsers run.
"""

import ctypes
import json
import math
import re
import runpy
import struct
import zlib
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from host_library import ROBOTS, TOP, Host, Native, Robot, Start, Twin
from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.description.robot import parse
from hypertuna.mission.image import robot_image
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.simulation.image import pack
from hypertuna.simulation.recorded import CONDITIONS
from hypertuna.swimming.beat import STATUSES, directional_derivatives, settle
from hypertuna.swimming.gait import KINDS, Gait, Gaits
from hypertuna.swimming.model import core_model
from image_file import columns_of, with_bytes, with_number

SAME = 1e-10  # relative: both are the same arithmetic but for its order
ITERATED = {
    "distance_to_settled",
    "change_per_beat",
    "beats",
    "arrived",
    "approach_beats",
}  # rounding, or its way there
INTERFACE = runpy.run_path(str(TOP / "make/interface.py"))
COLUMNS = (6, "40a0fdb8")  # version of the image, and the digest of all names of its columns
ROUNDING = {"turn_rate": 1e-10, "turn_radius": 1e-9, "spectral_radius": 1e-10}  # where the number itself is zero


def random_gaits(robot: ht.Robot, count: int, seed: int) -> list[Gait]:
    """Draw gaits of a robot: 0.5 to 5 Hz, bends to 35 deg, any phases, some with a bias."""
    chance, groups = np.random.default_rng(seed), len(robot.joints)

    def angles(low: float, high: float) -> tuple[float, ...]:
        return tuple(np.radians(chance.uniform(low, high, groups)).tolist())

    def gait() -> Gait:
        bias = angles(-8, 8) if chance.random() < 0.5 else (0.0,) * groups
        return Gait(frequency=chance.uniform(0.5, 5), amplitude=angles(3, 35), phase=angles(-90, 90), bias=bias)

    return [gait() for _ in range(count)]


def loaded(robot: ht.Robot, host: Host) -> Robot:
    """Read a robot's image."""
    read = Robot.read(robot_image(robot), host)
    assert isinstance(read, Robot)
    return read


@pytest.mark.parametrize("name", ROBOTS)
def test_settled_gaits_are_those_of_python(host: Host, name: str) -> None:
    """1,000 gaits over all robots, water laws and joint models."""
    robot = ht.load(name)
    swimmer = loaded(robot, host)
    models = json.loads(swimmer.text)["models"]
    gaits = random_gaits(robot, 1000 // len(ROBOTS) // len(models) + 1, seed=7)
    for k, choice in enumerate(models):
        here = robot.using(**choice)
        ours, theirs = settle(here, Gaits.of(gaits)), swimmer.swim(k, gaits)
        assert np.array_equal(theirs.pop("status"), ours["status"])
        sure = ours["status"] == STATUSES.index("settled")  # elsewhere rounding grows from beat to beat
        assert sure.mean() > 0.8
        for values in (ours, theirs):
            values["turn_radius"] = 1 / values["turn_radius"]  # 0 for a straight path
        for quantity in theirs.keys() - ITERATED:
            mine, yours = ours[quantity][sure], theirs[quantity][sure]
            assert yours == pytest.approx(mine, rel=SAME, abs=ROUNDING.get(quantity, 0.0), nan_ok=True), quantity


@pytest.mark.parametrize("name", ROBOTS)
def test_derivatives_are_those_of_python(host: Host, name: str) -> None:
    robot = ht.load(name)
    swimmer, gaits = loaded(robot, host), random_gaits(robot, 20, seed=8)
    batch = Gaits.of(gaits)
    beats = settle(robot, batch)
    width = 1 + 3 * len(robot.joints)
    ours = directional_derivatives(robot, batch, beats, np.eye(len(core_model(robot).parameter_names()), width))
    compared = 0
    for k, gait in enumerate(gaits):
        if STATUSES[beats["status"][k]] != "settled" or beats["distance_to_settled"][k] > 1e-10:
            continue
        for quantity, values in swimmer.gradient(0, gait).items():
            wanted = ours[quantity][k]
            if quantity == "torque_peak" and not any(gait.bias):  # left or right is the larger: by rounding alone
                values, wanted = values[: -len(gait.bias)], wanted[: -len(gait.bias)]
            assert values == pytest.approx(wanted, rel=1e-8, abs=1e-9 * np.abs(wanted).max()), (k, quantity)
            compared += 1
    assert compared > 50


@pytest.mark.parametrize("name", ROBOTS)
def test_path_of_a_beat_is_that_of_python(host: Host, name: str) -> None:
    robot = ht.load(name)
    gait = random_gaits(robot, 1, seed=9)[0]
    data, rows = ht.swim(robot, gait).trajectory, loaded(robot, host).path(0, gait, 128)
    for column, variable in enumerate(("time", "x", "y", "heading")):
        assert rows[:, column] == pytest.approx(data[variable].values, rel=1e-9, abs=1e-9)
    for group, amplitude, phase, bias in zip(robot.joints, gait.amplitude, gait.phase, gait.bias, strict=True):
        slow = gait.frequency / (group.bandwidth or math.inf)  # a first-order lag divides by 1 + i slow
        beat = np.exp(1j * (2 * np.pi * gait.frequency * rows[:, 0] - phase - group.phase_offset)) / (1 + 1j * slow)
        wanted = np.outer(bias + amplitude * beat.imag, group.share)
        assert rows[:, 4:][:, group.links] == pytest.approx(wanted, abs=1e-12)
        assert np.abs(wanted).max() > 0.01


# --- the twin


def same_as_python(last: dict[str, Array], run: ht.TwinRun | ht.SeaRun, tick: int) -> None:
    """Assert that all that a tick of the twin shows is what the run has there."""
    compared = 0
    for name, values in last.items():
        if name not in run.data or name in ("surge", "sway"):  # in the run of the nose, here of the head
            continue
        wanted = np.atleast_1d(run.data[name][tick])
        if wanted.shape != values.shape:  # a servo on the axle is one of two circuits here
            continue
        there = np.isfinite(wanted)  # sensors that the robot has
        assert values[there] == pytest.approx(wanted[there], rel=1e-9, abs=1e-9), (tick, name)
        compared += 1
    assert compared > 12


@pytest.mark.parametrize("name", ["hypertuna", "examples/servofish.toml"])
def test_twin_runs_as_in_python(host: Host, name: str) -> None:
    """20 s in the plane with noise of the sensors, seed 5."""
    robot = ht.load(name)
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 40))
    run = ht.twin(robot, gait, duration=20, seed=5, start="rest")
    ticks, made = len(run.time), 0
    twin = Twin(loaded(robot, host), seed=5)
    twin.command(gait)
    for until in (1, ticks // 7, ticks // 2, ticks):
        last = twin.advance(until - made)
        made = until
        same_as_python(last, run, until - 1)
    assert last["x"] == pytest.approx(run.data["x"][-1], rel=1e-12)


def test_twin_at_sea_runs_as_in_python(host: Host) -> None:
    """5 s from 2 m of depth in a current, the fins at work."""
    robot = ht.load("hypertuna")
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 40))
    fins, sea = (-0.2, 0.1), ht.Sea(current=(0.1, -0.05), bottom=2.2)
    run = ht.twin_at_sea(robot, gait, duration=5, fins=fins, sea=sea, depth=2, heading=0.3, speed=0.2, seed=5)
    start = {"sea": 1, "seed": 5, "speed": 0.2, "depth": 2.0, "heading": math.pi / 2 - 0.3}
    twin = Twin(loaded(robot, host), **start, current=sea.current, bottom=sea.bottom)
    twin.command(gait, fins)
    last = twin.advance(len(run.time))
    same_as_python(last, run, -1)


def test_saved_twin_goes_on_to_the_same_bits(host: Host) -> None:
    robot = loaded(ht.load("examples/servofish.toml"), host)
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(16, 24), phase=(0, 40))
    twin = Twin(robot, seed=3)
    twin.command(gait)
    twin.advance(50)
    state = twin.state
    first = twin.advance(70)
    assert twin.restore(state)
    assert not twin.restore(state[:-1])
    again = twin.advance(70)
    assert all(np.array_equal(first[name], again[name], equal_nan=True) for name in first)


def test_broken_sensor_is_told_by_the_controller(host: Host) -> None:
    robot = ht.load("hypertuna")
    twin = Twin(loaded(robot, host), seed=1)
    twin.command(ht.Gait.from_degrees(frequency=1, amplitude=(10, 10), phase=(0, 40)))
    fault = 1 << list(CONDITIONS).index("bend_fault")
    assert not int(twin.advance(100)["status"][0]) & fault
    twin.fail(2, 0, 0)  # the bend sensor of the first joint, open
    assert int(twin.advance(100)["status"][0]) & fault


def test_robot_without_a_controller_has_no_twin(host: Host) -> None:
    assert Twin(loaded(ht.load("rexeel"), host)).fault.startswith("twin: the robot has no controller")


# --- images


def test_damaged_images_are_refused_with_a_sentence(host: Host) -> None:
    image = robot_image(ht.load("rexeel"))
    for size in (0, 7, 31, 32, len(image) - 8, len(image) - 1):
        assert isinstance(Robot.read(image[:size], host), str), size
    for place in range(len(image)):
        damaged = image[:place] + bytes([image[place] ^ 0x10]) + image[place + 1 :]
        assert isinstance(Robot.read(damaged, host), str), place


def test_images_with_good_checksums_and_damaged_columns_are_refused_or_read(host: Host) -> None:
    """Names, sizes and numbers of any kind: a robot or a sentence, and a swim that ends."""
    image, chance = robot_image(ht.load("examples/servofish.toml")), np.random.default_rng(4)
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(16, 24), phase=(0, 40))
    refused = 0
    for _ in range(1000):
        body = bytearray(image[16:])
        for place in chance.integers(0, len(body), 3):
            body[place] = chance.integers(0, 256)
        read = Robot.read(image[:12] + struct.pack("<I", zlib.crc32(body)) + bytes(body), host)
        refused += isinstance(read, str)
        if isinstance(read, Robot) and read.count("groups") == 2:
            read.swim(0, [gait])
    assert 50 < refused < 1000


def test_every_number_has_a_range(host: Host) -> None:
    """A number that no robot has is refused by its column's name, wherever it stands; what is refused is never read."""
    image = robot_image(ht.load("hypertuna"))
    tried, at = set(), 0
    for name, numbers in columns_of(image).items():
        kind = re.sub(r"\.\d+\.", ".#.", name)
        for wrong in (math.nan, -1e300, 1e300) if len(numbers) and kind not in tried else ():
            read = Robot.read(with_number(image, at, wrong), host)
            assert isinstance(read, str), (name, wrong)
            assert read.startswith(f"image: {name}: must be a "), read
        tried.add(kind)
        if kind == "controller.pulse_per_rad":  # divides: none is infinite
            assert isinstance(Robot.read(with_number(image, at, -0.0), host), str)
        at += len(numbers)
    assert isinstance(Robot.read(with_number(image, 0, 0.05), host), Robot)
    assert len(tried) > 300


@pytest.mark.parametrize("name", ["plant.joint.axial_viscosity", "plant.circuit.stall_torque"])
def test_numbers_that_divide_are_not_zero(name: str) -> None:
    """A joint with an axis that yields at once, and a servo without torque, would lose a power that is no number."""
    image = robot_image(ht.load("hypertuna"))
    columns, host = columns_of(image), Native()
    at = sum(len(columns[other]) for other in list(columns)[: list(columns).index(name)])
    for zero in (0.0, -0.0):
        read = Robot.read(with_number(image, at + 1, zero), host)
        assert isinstance(read, str)
        assert read.startswith(f"{name.removeprefix('plant.')}: must be above 0"), read


def test_sizes_without_numbers_take_no_memory(host: Host) -> None:
    """A column of no rows may claim any width, and one of no width any rows."""
    columns = columns_of(robot_image(ht.load("examples/servofish.toml")))
    for name in ("models.0.joint_group", "models.0.bandwidth", "plant.share", "plant.armature"):
        for shape in ((0, 2**32 - 1), (2**32 - 1, 0), (0, 10**6), (10**6, 0)):
            image = pack({**columns, name: np.empty(0)}, "{}")
            place = list(columns).index(name)
            read = Robot.read(with_bytes(image, 32 + 12 * place, struct.pack("<2I", *shape)), host)
            assert isinstance(read, str), (name, shape)


def test_other_versions_are_named(host: Host) -> None:
    image = robot_image(ht.load("rexeel"))
    version, fix = _core.IMAGE_VERSION, "write it with this version of hypertuna"
    for other in (version - 1, version + 1):
        sentence = Robot.read(image[:8] + struct.pack("<I", other) + image[12:], host)
        assert sentence == f"image: has version {other}, but must have version {version}; {fix}"
    assert (
        Robot.read(b"PK\3\4" + image[4:], host) == "image: is not a robot image; write one with `hypertuna robot image`"
    )


def test_a_change_of_the_columns_changes_the_version() -> None:
    """Else a library of former columns would leave out the new ones, and compute another robot."""
    document = ht.load("hypertuna").document() | {"hinge": {"link": 7, "stiffness_n_m_per_rad": 0.2}}  # has all
    names = {re.sub(r"\.\d+\.", ".#.", name) for name in columns_of(robot_image(parse(document)))}
    digest = zlib.crc32("\n".join(sorted(names)).encode())
    assert (_core.IMAGE_VERSION, f"{digest:08x}") == COLUMNS, (
        "raise image_version in core/include/hypertuna/host/columns.hpp"
    )


# --- what the studio knows of the core


def test_the_studio_binds_every_function_or_excludes_it() -> None:
    code = (TOP / "studio/core.ts").read_text(encoding="utf-8")
    known = set(re.findall(r"\b(ht_\w+)\(", (TOP / "hosts/hypertuna.h").read_text(encoding="utf-8")))
    assert known == INTERFACE["functions"]().keys()
    assert known - set(INTERFACE["EXCLUDED"]) == set(re.findall(r"\bwasm\.(ht_\w+)", code))
    assert set(INTERFACE["EXCLUDED"]) < known


def test_the_studio_s_interface_is_of_the_present_header_and_lists() -> None:
    written = (TOP / "studio/interface.ts").read_text(encoding="utf-8")
    assert written == INTERFACE["written"](), "run `python make/interface.py > studio/interface.ts`"
    places = INTERFACE["layout"]("ht_start")
    assert places.pop("size") == ctypes.sizeof(Start)
    assert places == {name: getattr(Start, name).offset for name, *_ in Start._fields_}
    assert tuple(INTERFACE["members"]("FaultKind")) == tuple(_core.fault_kinds())
    assert tuple(INTERFACE["members"]("BeatStatus")) == STATUSES
    assert INTERFACE["numbers"]() == {"beat_steps": _core.BEAT_STEPS, "nearly_straight": _core.NEARLY_STRAIGHT}


# --- the text


def text_of(name: str) -> dict[str, Any]:
    """Return the text of a robot's image."""
    text: dict[str, Any] = json.loads(text_in(robot_image(ht.load(name))))
    return text


def text_in(image: bytes) -> str:
    """Read the text out of an image, without the library."""
    count, names, size, _ = struct.unpack("<4I", image[16:32])
    start = 32 + 12 * count + names
    return image[start : start + size].decode()


@pytest.mark.parametrize("name", ROBOTS)
def test_text_describes_the_body(host: Host, name: str) -> None:
    robot, text = ht.load(name), text_of(name)
    assert (text["robot"], text["length"], text["mass"]) == (robot.name, robot.body.length, robot.body.mass)
    columns = {key: [link[key] for link in text["links"]] for key in text["links"][0]}
    assert columns["name"] == list(robot.links.name)
    assert sum(columns["length"]) == pytest.approx(robot.body.length)
    areas = np.multiply(columns["height"], columns["length"])
    assert areas == pytest.approx(robot.links.lateral_area, rel=0.02)  # [spatial] is rounded
    assert all(0 < width <= height for width, height in zip(columns["width"], columns["height"], strict=True))
    assert [link for joint in text["joints"] for link in joint["links"]] == [k for g in robot.joints for k in g.links]


@pytest.mark.parametrize("name", ROBOTS)
def test_text_has_the_limits_of_optimizers_and_room_around_them(host: Host, name: str) -> None:
    robot, text = ht.load(name), text_of(name)
    space = gait_bounds(robot)

    def flat(bounds: dict[str, Any]) -> np.ndarray:
        return np.array([bounds["frequency"], *bounds["amplitude"], *bounds["phase"], *bounds["bias"]])

    limits, ranges = flat(text["limits"]), flat(text["ranges"])
    assert limits == pytest.approx(np.stack([space.low, space.high], axis=1))
    assert (ranges[:, 0] <= limits[:, 0]).all()
    assert (limits[:, 1] <= ranges[:, 1]).all()
    for gait in text["gaits"]:
        values = np.array([gait["frequency"], *gait["amplitude"], *gait["phase"], *gait["bias"]])
        assert values.tolist() == ht.named_gait(robot, gait["name"]).values.tolist()
        assert ((ranges[:, 0] <= values) & (values <= ranges[:, 1])).all(), gait["name"]
    tops = [[high for _, high in text["ranges"][kind]] for kind in KINDS]
    assert ht.Gait(text["ranges"]["frequency"][1], *tops)  # what the knobs reach is a gait


def test_text_of_a_robot_without_bounds_and_gaits_has_knobs() -> None:
    document = ht.load("rexeel").document()
    for key in ("gaits", "gait_bounds"):
        del document[key], document["sources"][key]
    text = json.loads(text_in(robot_image(parse(document))))
    assert text["limits"] is None
    assert text["gaits"] == []
    assert text["ranges"]["frequency"] == [0.1, 5.0]
    assert text["ranges"]["amplitude"] == [[0.0, pytest.approx(np.pi / 4)]] * 5


def test_published_numbers_are_those_of_the_robot_and_its_own_gaits() -> None:
    gaits = {gait["name"]: gait["published"] for gait in text_of("hypertuna")["gaits"]}
    assert gaits["optimised-max"]["speed"]["value"] == 0.582
    assert gaits["optimised-max"]["speed"]["kind"] == "measured"
    assert gaits["unoptimised-max"]["electrical_power"]["value"] == 22.45
    assert gaits["turning"]["turn_radius_bl"]["value"] == 0.47
    assert sum("speed" in numbers for numbers in gaits.values()) == 8
    assert all(not gait["published"] for name in ROBOTS[1:] for gait in text_of(name)["gaits"])
    document = ht.load("hypertuna").document()
    document["gaits"]["optimised-max"]["frequency_hz"] = 5.0
    changed = json.loads(text_in(robot_image(parse(document))))["gaits"]
    assert not next(gait for gait in changed if gait["name"] == "optimised-max")["published"]
