"""The client against a stand-in at the other end of a line: who is the robot, and what is said where a line fails."""

import socket
import struct
import time
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")

from hypertuna.errors import InputError
from hypertuna.radio.client import Client, connect
from hypertuna.radio.dialect import dialect
from hypertuna.radio.parameters import read_parameter, set_parameter
from radio_bench import free_port

ROBOT, CAMERA, OTHER = 7, 200, 9
VEHICLE, STATION = (12, 0), (6, 8)  # type and autopilot: submarine, generic; ground station, none


class StandIn:
    """A robot on UDP: sends what a test asks for, and keeps what it receives."""

    def __init__(self, port: int) -> None:
        self.line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.line.settimeout(0.2)
        self.ground = ("127.0.0.1", port)
        self.answers: dict[str, tuple[Any, ...]] = {}
        self.heard: list[object] = []
        self.ends = False
        self.near = False  # another robot, which comes later: a first burst may be cut off by the opening line
        self._thread = Thread(target=self._run)
        self._thread.start()

    def say(self, name: str, source: int, *values: object) -> None:
        made = getattr(dialect(), f"MAVLink_{name}_message")(*values)
        self.line.sendto(made.pack(dialect().MAVLink(None, srcSystem=source, srcComponent=1)), self.ground)

    def _run(self) -> None:
        parser = dialect().MAVLink(None)
        while not self.ends:
            sources = [(*STATION, 254), (*STATION, CAMERA), (*VEHICLE, ROBOT)]
            for kind, autopilot, source in sources + [(*VEHICLE, OTHER)] * self.near:
                self.say("heartbeat", source, kind, autopilot, 0, 0, 4, 3)
            try:
                content = self.line.recv(4096)
            except TimeoutError:
                continue
            for message in parser.parse_buffer(content) or []:
                self.heard.append(message)
                if message.get_type() in self.answers:
                    self.say(*self.answers[message.get_type()])

    def close(self) -> None:
        self.ends = True
        self._thread.join()
        self.line.close()


@pytest.fixture
def pair() -> Iterator[tuple[StandIn, Client]]:
    port = free_port()
    robot = StandIn(port)
    try:
        with connect(f"udp:{port}") as client:
            robot.near = True
            yield robot, client
    finally:
        robot.close()


def test_the_robot_is_the_first_vehicle(pair: tuple[StandIn, Client]) -> None:
    """Ground stations and cameras have heartbeats, too, and another robot may be near: only the listener hears them."""
    robot, client = pair
    heard: list[int] = []
    client.listener = lambda message: heard.append(message.get_srcSystem())
    end = time.monotonic() + 20
    while set(heard) != {ROBOT, CAMERA, OTHER, 254} and time.monotonic() < end:
        list(client.poll(0.2))
    assert client.system == ROBOT
    assert {ROBOT, CAMERA, OTHER, 254} == set(heard)
    assert client.last["HEARTBEAT"].get_srcSystem() == ROBOT
    robot.answers["COMMAND_LONG"] = ("command_ack", OTHER, 400, 0, 0, 0, 255, 190)
    assert client.wait(lambda m: m.get_type() == "COMMAND_ACK", 0.5) is None


def test_a_refusal_tells_its_number(pair: tuple[StandIn, Client]) -> None:
    """No STATUSTEXT came: the sentence is that of the number."""
    robot, client = pair
    robot.answers["COMMAND_LONG"] = ("command_ack", ROBOT, 400, 4, 0, 7, 255, 190)
    with pytest.raises(InputError, match="arm must be accepted by the robot, but is refused: a fault forbids it"):
        client.arm()
    order = next(message for message in robot.heard if message.get_type() == "COMMAND_LONG")
    assert (order.target_system, order.command) == (ROBOT, 400)


def test_names_that_do_not_fit_are_told(pair: tuple[StandIn, Client]) -> None:
    robot, client = pair
    for name in ("proportional_of_it", "größe", ""):
        with pytest.raises(InputError, match="must be a parameter of the robot"):
            set_parameter(client, name, 1.0)
    assert "PARAM_SET" not in {message.get_type() for message in robot.heard}
    robot.answers["PARAM_REQUEST_READ"] = ("param_value", ROBOT, b"LINK_RATE", 4800.0, 9, 77, 3)
    assert read_parameter(client, "link_rate") == 4800


def server(content: bytes) -> int:
    """A port of TCP where somebody says something, waits a moment, and hangs up."""
    listening = socket.create_server(("127.0.0.1", 0))

    def run() -> None:
        line, _ = listening.accept()
        line.sendall(content)
        line.recv(10)
        # Without unread bytes a closed line ends, with them it is reset: both happen.
        line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 0, 0))
        line.close()
        listening.close()

    Thread(target=run, daemon=True).start()
    return int(listening.getsockname()[1])


def heartbeat(autopilot: int) -> bytes:
    made = dialect().MAVLink_heartbeat_message(12, autopilot, 0, 0, 4, 3)
    return bytes(made.pack(dialect().MAVLink(None, srcSystem=1, srcComponent=1)))


def test_a_line_that_ends_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with (
        connect(f"tcp:127.0.0.1:{server(heartbeat(0))}") as robot,
        pytest.raises(InputError, match="--connect must stay open, but is lost"),
    ):
        robot.wait(lambda m: False, 20)
    assert capsys.readouterr().out == ""


def test_another_firmware_is_refused() -> None:
    with pytest.raises(
        InputError, match="must lead to a robot with hypertuna's firmware, but is MAV_AUTOPILOT_ARDUPILOTMEGA"
    ):
        connect(f"tcp:127.0.0.1:{server(heartbeat(3))}")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # pymavlink leaves its socket open
def test_lines_that_cannot_be_opened(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        with pytest.raises(
            InputError, match=r"must be an address that can be opened, but is 'udp:\d+' \(Address already"
        ):
            connect(f"udp:{other.getsockname()[1]}")
    with pytest.raises(InputError, match="No such file"):
        connect(f"serial:{tmp_path / 'none'}")
    with pytest.raises(InputError, match="Connection refused"):
        connect(f"tcp:127.0.0.1:{free_port()}")


def test_a_late_text_is_not_the_reason_of_the_next_refusal(pair: tuple[StandIn, Client]) -> None:
    """A slow robot's words about the refusal before come between an unknown parameter and its error."""
    robot, client = pair
    robot.answers["PARAM_SET"] = ("param_error", ROBOT, 255, 190, b"NONSENSE", -1, 1)
    client.idle = lambda: client.texts.append("a value is out of range")
    with pytest.raises(InputError, match="no such parameter"):
        set_parameter(client, "nonsense", 7)
