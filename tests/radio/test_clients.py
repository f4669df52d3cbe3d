"""Our own client by the clock, against three robots; validation/clients has those of others.

On a bench board on UDP; the firmware of the PC beside the twin, on UDP; and that of the emulated Cortex-M7 beside the
twin, whose UART is a TCP socket.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.firmware.parameters import firmware_table
from hypertuna.mission.file import read_mission
from hypertuna.mission.upload import download, upload
from hypertuna.radio.client import connect, make_message
from hypertuna.radio.dialect import dialect
from hypertuna.radio.parameters import read_parameters, set_parameter
from hypertuna.swimming.gait import named_gait
from radio_bench import free_port, in_the_loop, running

PARAMETERS = len(firmware_table(ht.load("hypertuna")).parameters)
WIRE = 115200  # bit/s: as a cable, so that a test takes seconds


@pytest.fixture(params=["bench", "pc", "qemu"])
def place(request: pytest.FixtureRequest) -> Iterator[str]:
    """Where a robot is, as pymavlink spells it."""
    port = free_port()
    with running(port) if request.param == "bench" else in_the_loop(request.param, port):
        yield f"tcp:127.0.0.1:{port}" if request.param == "qemu" else f"udpin:127.0.0.1:{port}"


@pytest.fixture
def bench() -> Iterator[str]:
    """The bench board alone."""
    port = free_port()
    with running(port):
        yield f"udp:{port}"


def test_our_own_client_from_connecting_to_disarming(place: str) -> None:
    with connect(place, patience=60) as robot:
        set_parameter(robot, "link_rate", WIRE)
        found = read_parameters(robot)
        assert len(found) > 70
        assert found["link_rate"] == WIRE
        assert set_parameter(robot, "learning", 0.2) == pytest.approx(0.2)
        with pytest.raises(InputError, match="a value is out of range"):
            set_parameter(robot, "learning", 7)
        with pytest.raises(InputError, match="no such parameter"):
            set_parameter(robot, "nonsense", 7)
        mission = read_mission("lake").mission
        upload(robot, mission)
        items = download(robot)
        assert sum(item.command == 16 for item in items) == len(mission.waypoints)
        gait = named_gait(ht.load("hypertuna"), "unoptimised-0.3")
        with pytest.raises(InputError, match="not while disarmed"):
            robot.gait(gait)
        robot.arm()
        with pytest.raises(InputError, match="not while armed"):
            set_parameter(robot, "learning", 0.1)
        robot.gait(gait)
        swims = robot.wait(lambda m: m.get_type() == "GAIT" and m.frequency == 2000, 5)
        assert (swims.amplitude, swims.lag, swims.state) == ([1600, 2500], [0, 0], 103)
        robot.gait(ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(-200, 200)))
        assert robot.wait(lambda m: m.get_type() == "GAIT" and (m.lag, m.state) == ([0, 4000], 103), 5)
        robot.mode("mission")
        assert robot.wait(lambda m: m.get_type() == "HEARTBEAT" and m.custom_mode == 104, 5)
        robot.mode("manual")
        for _ in range(20):
            robot.manual(0.5, 0.2, 0.0)
            list(robot.poll(0.05))
        assert robot.wait(lambda m: m.get_type() == "GAIT" and m.state == 102, 5)
        robot.arm(False)
        assert robot.wait(lambda m: m.get_type() == "HEARTBEAT" and not m.base_mode & 128, 5)
        for kind in ("ATTITUDE", "HYDRAULICS", "LOCAL_POSITION_NED", "SERVO_OUTPUT_RAW", "SYS_STATUS", "PILOT"):
            assert kind in robot.last or robot.wait(lambda m, kind=kind: m.get_type() == kind, 12)


def test_a_refused_mission_says_why(bench: str) -> None:
    """In the robot's words: item, quantity, value and bound; and the waypoint of the file."""
    mission = read_mission("lake").mission
    first, second, _ = mission.waypoints
    fastest = 2 * max(ht.load("hypertuna").guidance.speed)  # as far as the pilot takes
    with connect(bench) as robot:
        set_parameter(robot, "link_rate", WIRE)
        for points, words in (
            ([first._replace(speed=-1)], "item 6 (waypoint 1): speed -1 m/s, min 0.01."),
            ([first, second._replace(depth=-5)], "item 8 (waypoint 2): above the water: altitude 5 m, max 0."),
            ([first, second._replace(radius=0.1)], "item 8 (waypoint 2): radius 0.1 m, min 1.89."),
            ([first, second._replace(speed=2)], f"item 9 (waypoint 2): speed 2 m/s, max {fastest:.2g}."),
        ):
            with pytest.raises(InputError) as refused:
                upload(robot, replace(mission, waypoints=tuple(points)))
            assert str(refused.value) == f"the mission was refused by the robot: {words}"


def test_a_signed_link(bench: str) -> None:
    """A key is set once; then nobody without it is heard, and the answers are signed."""
    key = bytes(range(32))
    with connect(bench) as robot:
        set_parameter(robot, "link_rate", WIRE)
        robot.begin_signing(key)
        robot.arm()
        robot.arm(False)
    with connect(bench, patience=3) as stranger:
        with pytest.raises(InputError, match="--key must be the robot.s key, but is missing: give the file of its key"):
            stranger.arm()
        assert stranger.wait(lambda m: m.get_type() == "STATUSTEXT" and m.text.startswith("messages must be sig"), 5)
    with connect(bench, key=key) as robot:
        robot.arm()


def test_messages_that_the_page_on_ros_lists_are_sent(bench: str) -> None:
    """Those that the robot has at any time; GLOBAL_POSITION_INT and HOME_POSITION want the origin of a mission."""
    page = (Path(__file__).parents[2] / "docs" / "howto" / "ros2.md").read_text()
    sent = [
        name for row in re.findall(r"^\| (`.*?) \|", page, re.MULTILINE) for name in re.findall(r"`([A-Z_]+)`", row)
    ]
    sent = [name for name in sent if name not in ("STATUSTEXT", "MANUAL_CONTROL")]  # of events; of the ground
    assert len(sent) == 10
    with connect(bench) as robot:
        set_parameter(robot, "link_rate", WIRE)
        upload(robot, read_mission("lake").mission)
        robot.send(make_message("set_gps_global_origin", robot.system, 473000000, 85000000, 0))
        for name in sent:
            robot.command(512, getattr(dialect(), f"MAVLINK_MSG_ID_{name}"))  # MAV_CMD_REQUEST_MESSAGE
            assert robot.wait(lambda m, name=name: m.get_type() == name, 5), name
