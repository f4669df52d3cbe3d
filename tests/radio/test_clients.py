"""Real clients by the clock: our own, pymavlink's mavutil and MAVProxy, against three robots.

On a bench board on UDP; the firmware of the PC beside the twin, on UDP; and that of the emulated Cortex-M7 beside the
twin, whose UART is a TCP socket.
"""

import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.firmware.boards import find_firmware, missing
from hypertuna.firmware.parameters import firmware_table
from hypertuna.mission.file import read_mission
from hypertuna.mission.upload import download, upload
from hypertuna.radio.client import connect
from hypertuna.radio.dialect import mavutil
from hypertuna.radio.parameters import read_parameters, set_parameter
from hypertuna.swimming.gait import named_gait
from radio_bench import free_port, running

PARAMETERS = len(firmware_table(ht.load("hypertuna")).parameters)
WIRE = 115200  # bit/s: as a cable, so that a test takes seconds


@contextmanager
def in_the_loop(board: str, port: int) -> Iterator[None]:
    """The twin in the water and the firmware on a board, no faster than the clock."""
    if (sentence := missing(board)) is not None:
        pytest.skip(sentence)
    try:
        find_firmware("hypertuna", board)
    except InputError as error:
        pytest.skip(str(error))
    options = ["--scenario", "afloat", "--radio", str(port), "--real-time", "--ticks", "30000"]
    command = [sys.executable, "-m", "hypertuna", "hil", "--board", board, *options]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        end = time.monotonic() + 60
        while board == "qemu" and time.monotonic() < end:
            with socket.socket() as line:
                if line.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.5)
        yield
    finally:
        process.terminate()
        process.wait()


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


def test_a_signed_link(bench: str) -> None:
    """A key is set once; then nobody without it is heard, and the answers are signed."""
    key = bytes(range(32))
    with connect(bench) as robot:
        set_parameter(robot, "link_rate", WIRE)
        robot.begin_signing(key)
        robot.arm()
        robot.arm(False)
    with connect(bench, patience=3) as stranger, pytest.raises(InputError, match="must be answered"):
        stranger.arm()
    with connect(bench, key=key) as robot:
        robot.arm()


def mavutil_ask(line: object, kind: str, timeout: float = 5, **fields: object) -> object:
    """Receive until a message has these fields."""
    end = time.monotonic() + timeout
    while time.monotonic() < end:
        m = line.recv_match(type=kind, blocking=True, timeout=1)  # type: ignore[attr-defined]
        if m is not None and all(getattr(m, name) == value for name, value in fields.items()):
            return m
    raise AssertionError(f"no {kind} with {fields}")


def test_mavutil(place: str) -> None:
    """The methods that pymavlink's users call, without a line of ours but the dialect."""
    line = mavutil().mavlink_connection(place)
    assert line.wait_heartbeat(timeout=60)
    line.param_set_send("link_rate", WIRE)
    mavutil_ask(line, "PARAM_VALUE", param_id="LINK_RATE", param_value=WIRE)
    line.param_fetch_all()
    count = mavutil_ask(line, "PARAM_VALUE", param_index=0).param_count  # type: ignore[attr-defined]
    mavutil_ask(line, "PARAM_VALUE", param_index=count - 1)
    line.param_set_send("learning", 0.3)
    mavutil_ask(line, "PARAM_VALUE", param_id="LEARNING", param_value=pytest.approx(0.3))
    line.waypoint_count_send(1)
    mavutil_ask(line, "MISSION_REQUEST_INT", seq=0)
    line.mav.mission_item_int_send(1, 1, 0, 1, 16, 0, 1, 0, 3, 0, 0, 100000, 0, 1.0)
    mavutil_ask(line, "MISSION_ACK", type=0)
    time.sleep(1)  # until the parameter is stored: busy before
    line.arducopter_arm()
    line.motors_armed_wait()
    line.mav.command_long_send(1, 1, 52510, 0, 2, 10, 15, 40, 0, 0, 0)
    mavutil_ask(line, "COMMAND_ACK", command=52510, result=0)
    mavutil_ask(line, "GAIT", frequency=2000)
    line.set_mode(104)
    mavutil_ask(line, "HEARTBEAT", custom_mode=104)
    line.set_mode(102)
    for _ in range(10):
        line.mav.manual_control_send(1, 0, 0, 750, 0, 0)
        time.sleep(0.05)
    mavutil_ask(line, "GAIT", state=102)
    line.arducopter_disarm()
    line.motors_disarmed_wait()
    line.close()


# A place, a speed, a place 11 m to the north.
WAYPOINTS = """QGC WPL 110
0\t1\t3\t16\t0\t3\t0\t0\t{lat:.7f}\t{lon:.7f}\t-0.5\t1
1\t0\t3\t178\t0\t0.3\t0\t0\t0\t0\t0\t1
2\t0\t3\t16\t0\t3\t0\t0\t{north:.7f}\t{lon:.7f}\t-1.0\t1
"""
# What is typed, and what must be read before the next is.
SCRIPT = (
    ("", "online system 1"),
    ("param set LINK_RATE 115200", ""),
    ("param fetch", f"Received {PARAMETERS} parameters"),
    ("param set LEARNING 0.2", ""),
    ("param show LEARNING", "LEARNING         0.2"),
    ("wp load {waypoints}", "MISSION_ACK: TYPE_MISSION: ACCEPTED"),
    ("wp list", "Saved 5 waypoints"),
    ("arm throttle", "ARMED"),
    ("long 52510 2 10 15 40 0 0 0", "COMMAND_ACK {{command : 52510, result : 0"),
    ("long 176 1 104 0 0 0 0 0", "DO_SET_MODE: ACCEPTED"),
    ("status HEARTBEAT", "custom_mode : 104"),
    ("long 176 1 102 0 0 0 0 0", "DO_SET_MODE: ACCEPTED"),
    ("message MANUAL_CONTROL 1 0 0 750 0 0", ""),
    ("status HEARTBEAT", "custom_mode : 102"),
    ("disarm", "DISARMED"),
)


def test_mavproxy(place: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """A session of MAVProxy, typed by a script; its transcript is printed."""
    program = Path(sys.executable).parent / "mavproxy.py"
    if not program.exists() and shutil.which("mavproxy.py") is None:
        pytest.skip("MAVProxy is not installed: pip install MAVProxy")
    waypoints = tmp_path / "way.txt"
    on_the_bench = request.node.callspec.params["place"] == "bench"
    lat, lon = (50.0, 8.0) if on_the_bench else (0.0, 0.0)  # where each robot has its origin
    waypoints.write_text(WAYPOINTS.format(lat=lat, lon=lon, north=lat + 1e-4))
    modules = "--default-modules=param,wp,arm,mode,misc,cmdlong,message,log"
    command = [program, f"--master={place}", f"--state-basedir={tmp_path}", modules, "--mav20"]
    transcript = tmp_path / "transcript.txt"
    with transcript.open("wb") as out:
        session = subprocess.Popen(
            [sys.executable, "-u", "-W", "ignore", *command],
            stdin=subprocess.PIPE,
            stdout=out,
            stderr=subprocess.STDOUT,
        )
    assert session.stdin is not None
    try:
        for typed, wanted in SCRIPT:
            read = transcript.stat().st_size
            if typed:
                session.stdin.write(typed.format(waypoints=waypoints).encode() + b"\n")
                session.stdin.flush()
            time.sleep(1.0)
            # MAVProxy knows no link_rate before it has the list: 75 frames in turn with telemetry, 19 s at 4.8 kbit/s.
            end, needle = time.monotonic() + 120, wanted.replace("{{", "{")
            asked = time.monotonic()
            while needle not in transcript.read_bytes()[read if typed else 0 :].decode(errors="replace"):
                assert time.monotonic() < end, f"{typed}: no '{needle}' in\n{transcript.read_text(errors='replace')}"
                time.sleep(0.1)
                if typed.startswith("status") and time.monotonic() > asked + 2:  # it tells the last that came
                    session.stdin.write(typed.encode() + b"\n")
                    session.stdin.flush()
                    asked = time.monotonic()
    finally:
        session.kill()
        session.wait()
        session.stdin.close()
    print(transcript.read_text(errors="replace"))
