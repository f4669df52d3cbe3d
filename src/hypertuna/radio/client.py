"""The ground's side of the radio: a connection that asks, waits for the answer, and asks again where none comes."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NoReturn, Self

from hypertuna import _core
from hypertuna.errors import InputError, shown
from hypertuna.radio.dialect import dialect, mavutil
from hypertuna.swimming.gait import Gait

__all__ = ["COMPONENT", "PATIENCE", "SYSTEM", "Client", "Listener", "address", "connect"]

SYSTEM, COMPONENT = 255, 190  # MAV_COMP_ID_MISSIONPLANNER, what ground stations call themselves
PATIENCE = 2.0  # s for an answer: a LoRa link of 4.8 kbit/s needs a fifth of that
TRIES = 5
HEARTBEAT = 1.0  # s
BAUD = 9600
STORED, PAUSE = 6, 0.5  # times and s to wait until a robot has stored a mission: two seconds for the longest
BUSY = [name for name, _ in _core.refusal_table()].index("busy")
EPOCH = 1420070400  # 2015-01-01, from which stamps of signatures count
PART = 0.2  # s that nothing else is done while a message is waited for
GROUND, NO_AUTOPILOT, OURS = 6, 8, 0  # MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID, MAV_AUTOPILOT_GENERIC

Listener = Callable[[Any], None]


def address(text: str) -> tuple[str, int]:
    """Read where a robot is, as `--connect` takes it."""
    kind, _, rest = text.partition(":")
    host, _, number = rest.rpartition(":")
    fix = "write udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600"
    if kind == "serial" and rest:
        return (host, int(number)) if number.isdecimal() and host else (rest, BAUD)
    if kind in ("udp", "udpin", "udpout", "tcp") and number.isdecimal() and 0 < int(number) < 65536:
        if kind in ("udpout", "tcp") and not host:
            raise InputError("must name host and port", key="--connect", value=shown(text), fix=fix)
        return f"{'udpin' if kind == 'udp' else kind}:{host or '127.0.0.1'}:{number}", BAUD
    raise InputError("must say where the robot is", key="--connect", value=shown(text), fix=fix)


def connect(text: str, *, key: bytes | None = None, patience: float = 10.0, listener: Listener | None = None) -> Client:
    """Connect to a robot: `patience` [s]."""
    place, baud = address(text)
    try:
        line = mavutil().mavlink_connection(
            place, baud=baud, source_system=SYSTEM, source_component=COMPONENT, retries=1
        )
    except OSError as error:
        value, fix = f"{shown(text)} ({error.strerror or error})", "check device, host and port"
        raise InputError("must be a line that can be opened", key="--connect", value=value, fix=fix) from None
    line.handle_eof = line.handle_disconnect = _hung_up
    if key is not None:
        line.setup_signing(key, sign_outgoing=True)
    client = Client(line, listener)
    try:
        heart = client.wait(lambda m: m.get_type() == "HEARTBEAT", patience)
        if heart is None:
            fix = "switch the robot on, and check address and key"
            raise InputError(f"must be heard within {patience:g} s", key="--connect", value="silent", fix=fix)
        if heart.autopilot != OURS:
            kind = dialect().enums["MAV_AUTOPILOT"].get(heart.autopilot)
            value, fix = (
                kind.name if kind else f"autopilot {heart.autopilot}",
                "connect to one that hypertuna's runs on",
            )
            raise InputError("must be a robot with this firmware", key="--connect", value=value, fix=fix)
    except BaseException:
        client.close()
        raise
    return client


def _hung_up() -> NoReturn:
    """Tell that the other end closed the line, where pymavlink would print."""
    raise ConnectionResetError("the other end closed it")


class Client:
    """A robot at the other end of a line. Whatever waits keeps the heartbeat going.

    The robot is the first vehicle that is heard. What others say, such as a tank's camera or another ground station,
    goes to the listener alone.
    """

    def __init__(self, line: Any, listener: Listener | None = None) -> None:
        self._line = line
        self._beat = -math.inf
        self.listener = listener
        self.idle: Callable[[], None] | None = None  # called while something is waited for
        self.system = 0  # of the robot; 0 is everybody
        self.messages = 0  # of the robot
        self.texts: list[str] = []  # what the robot said in words
        self.last: dict[str, Any] = {}  # its latest message of each kind

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Hang up."""
        self._line.close()

    def poll(self, timeout: float = 0.0) -> Iterator[Any]:
        """Take the messages that have come; the first is waited for: `timeout` [s]."""
        end = time.monotonic() + timeout
        while True:
            now = time.monotonic()
            if now - self._beat >= HEARTBEAT:
                self._beat = now
                self.send(dialect().MAVLink_heartbeat_message(GROUND, NO_AUTOPILOT, 0, 0, 0, 3))
            with _line_is_there():
                left = max(0.0, min(end - now, PART))
                message = self._line.recv_match(blocking=timeout > 0, timeout=left)
            if self.idle is not None:
                self.idle()
            if message is not None and self._takes(message):
                yield message
                end = now  # what else has come, without waiting
            if message is None and time.monotonic() >= end:
                return

    def send(self, message: Any) -> None:
        """Send a message."""
        with _line_is_there():
            self._line.mav.send(message)

    def _takes(self, message: Any) -> bool:
        """Take down a message; whether it is the robot's."""
        kind, source = message.get_type(), message.get_srcSystem()
        if kind == "BAD_DATA" or kind.startswith("UNKNOWN") or source == SYSTEM:
            return False
        if self.listener is not None:
            self.listener(message)
        if kind == "HEARTBEAT" and self.system == 0 and message.autopilot != NO_AUTOPILOT:
            self.system = source
        if source != self.system:
            return False
        self.messages += 1
        if kind == "STATUSTEXT":
            self.texts.append(message.text)
        self.last[kind] = message
        return True

    def wait(self, wanted: Callable[[Any], bool], timeout: float) -> Any:
        """Wait for a message: `timeout` [s]."""
        end = time.monotonic() + timeout
        while (left := end - time.monotonic()) > 0:
            for message in self.poll(left):
                if wanted(message):
                    return message
        return None

    def ask(self, message: Callable[[], Any], wanted: Callable[[Any], bool], what: str) -> Any:
        """Send a message until its answer comes."""
        for _ in range(TRIES):
            self.send(message())
            if (answer := self.wait(wanted, PATIENCE)) is not None:
                return answer
        value = f"silent after {TRIES} tries"
        raise InputError("must be answered by the robot", key=what, value=value, fix="come nearer, and try again")

    def command(self, what: int, *values: float, name: str = "command") -> None:
        """Give a command and wait for its acknowledgement."""
        numbers = [*values, *[0.0] * (7 - len(values))]
        make = dialect().MAVLink_command_long_message
        self._acknowledged(lambda: make(self.system, 1, what, 0, *numbers), what, name)

    def _acknowledged(self, make: Callable[[], Any], what: int, name: str) -> None:
        """Send an order until COMMAND_ACK comes, also while the robot stores something, and say why it is refused."""
        answer = self.ask(make, lambda m: m.get_type() == "COMMAND_ACK" and m.command == what, name)
        for _ in range(STORED):
            if answer.result_param2 != BUSY:
                break
            self.wait(lambda m: False, PAUSE)
            answer = self.ask(make, lambda m: m.get_type() == "COMMAND_ACK" and m.command == what, name)
        if answer.result != 0:
            refusals = [sentence for _, sentence in _core.refusal_table()]
            known = 0 < answer.result_param2 < len(refusals)
            reason = refusals[answer.result_param2] if known else f"MAV_RESULT {answer.result}"
            raise InputError("must be accepted by the robot", key=name, value="refused", fix=reason)

    def arm(self, on: bool = True) -> None:
        """Arm or disarm."""
        self.command(400, float(on), name="arm" if on else "disarm")

    def begin_signing(self, key: bytes) -> None:
        """Give the robot a key; from then on both sign, and the robot hears nobody else."""
        if len(key) != 32:
            raise InputError("must have 32 bytes", key="key", value=f"{len(key)} long", fix="make one with `openssl`")
        stamp = int((time.time() - EPOCH) * 1e5)
        self.send(dialect().MAVLink_setup_signing_message(self.system, 1, key, stamp))
        self._line.setup_signing(key, sign_outgoing=True)
        if self.wait(lambda m: m.get_type() == "HEARTBEAT" and m.get_signed(), 5 * HEARTBEAT) is None:
            raise InputError("must be taken by the robot", key="key", value="not taken", fix="disarm it, and try again")

    def mode(self, name: str) -> None:
        """Change who makes the command."""
        self.command(176, 1, [control for control, _ in _core.control_table()].index(name), name=f"mode {name}")

    def gait(self, gait: Gait, *, fins: tuple[float, float] = (0.0, 0.0)) -> None:
        """Swim a steady gait: `fins` [rad]."""

        def row(values: Iterable[float]) -> list[int]:
            whole = [round(math.degrees(float(value)) * 100) for value in values]
            return whole + [0] * (4 - len(whole))

        make, what = dialect().MAVLink_gait_set_message, dialect().HYPERTUNA_CMD_GAIT
        rows = (row(gait.amplitude), row(gait.phase), row(gait.bias), row(fins)[:2])
        self._acknowledged(lambda: make(round(gait.frequency * 1000), *rows, self.system, 1), what, "gait")

    def manual(self, ahead: float, turn: float, climb: float) -> None:
        """Move the stick: no answer comes, the robot rests when the next does not come in time."""
        x, z, r = (round(1000 * max(-1.0, min(1.0, value))) for value in (-climb, ahead, turn))
        self.send(dialect().MAVLink_manual_control_message(self.system, x, 0, z, r, 0))


@contextlib.contextmanager
def _line_is_there() -> Iterator[None]:
    """Say it in one sentence where a line is gone."""
    try:
        yield
    except OSError as error:
        value, fix = f"gone ({error.strerror or error})", "plug it in again, or check the network, and connect anew"
        raise InputError("must stay open", key="--connect", value=value, fix=fix) from None
