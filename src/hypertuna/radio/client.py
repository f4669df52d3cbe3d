"""The ground station's side of the radio: a connection that repeats requests until they are answered."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NoReturn

from hypertuna import _core
from hypertuna.errors import InputError, shown
from hypertuna.io.files import Closing
from hypertuna.radio.dialect import dialect, mavutil
from hypertuna.swimming.gait import Gait, lags

SYSTEM, COMPONENT = 255, 190  # ids that ground stations use; 190 is MAV_COMP_ID_MISSIONPLANNER
PATIENCE = 2.0  # s to wait for an answer: five times what a LoRa radio of 4.8 kbit/s needs
TRIES = 5  # number of times that a request is sent before it fails
HEARTBEAT = 1.0  # s between heartbeats
BAUD = 9600  # default baud rate of a serial line
BUSY_TRIES, PAUSE = 6, 0.5  # retries and pause [s] while the robot stores a mission, which takes up to 2 s
BUSY = [name for name, _ in _core.refusal_table()].index("busy")  # code of this refusal
EPOCH = 1420070400  # Unix time of 2015-01-01, from which timestamps of signatures count
POLL = 0.2  # longest uninterrupted wait for a message [s]
GROUND, NO_AUTOPILOT, GENERIC = 6, 8, 0  # MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID, MAV_AUTOPILOT_GENERIC

Listener = Callable[[Any], None]  # called with each message


def address(text: str) -> tuple[str, int]:
    """Convert an address of `--connect` to pymavlink's spelling and a baud rate [1/s]."""
    kind, _, remainder = text.partition(":")
    host, _, number = remainder.rpartition(":")
    fix = "write udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600"
    if kind == "serial" and remainder:
        return (host, int(number)) if number.isdecimal() and host else (remainder, BAUD)
    if kind in ("udp", "udpin", "udpout", "tcp") and number.isdecimal() and 0 < int(number) < 65536:
        if kind in ("udpout", "tcp") and not host:
            raise InputError("must name host and port", key="--connect", value=shown(text), fix=fix)
        return f"{'udpin' if kind == 'udp' else kind}:{host or '127.0.0.1'}:{number}", BAUD
    raise InputError("must be the address of a robot", key="--connect", value=shown(text), fix=fix)


def connect(text: str, *, key: bytes | None = None, patience: float = 10.0, listener: Listener | None = None) -> Client:
    """Connect to a robot and wait `patience` [s] for its heartbeat; `listener` gets every message."""
    target, baud = address(text)
    try:
        link = mavutil().mavlink_connection(
            target, baud=baud, source_system=SYSTEM, source_component=COMPONENT, retries=1
        )
    except OSError as error:
        value, fix = f"{shown(text)} ({error.strerror or error})", "check device, host and port"
        raise InputError("must be an address that can be opened", key="--connect", value=value, fix=fix) from None
    link.handle_eof = link.handle_disconnect = _hung_up
    if key is not None:
        link.setup_signing(key, sign_outgoing=True)
    client = Client(link, listener)
    try:
        heartbeat = client.wait(of_kind("HEARTBEAT"), patience)
        if heartbeat is None:
            rule, fix = (
                f"must receive a heartbeat within {patience:g} s",
                "switch the robot on, and check address and key",
            )
            raise InputError(rule, key="--connect", value="silent", fix=fix)
        if heartbeat.autopilot != GENERIC:
            kind = dialect().enums["MAV_AUTOPILOT"].get(heartbeat.autopilot)
            value = kind.name if kind else f"autopilot {heartbeat.autopilot}"
            fix = "check the address, and which vehicle sends there"
            raise InputError("must lead to a robot with hypertuna's firmware", key="--connect", value=value, fix=fix)
    except BaseException:
        client.close()
        raise
    return client


def _hung_up() -> NoReturn:
    """Raise an error when the other end closes the connection; pymavlink would only print a line."""
    raise ConnectionResetError("the other end closed the connection")


class Client(Closing):
    """Connection to a robot; it sends heartbeats while it waits for messages.

    The robot is the first vehicle that sends a heartbeat. Messages of others, such as a tank's camera or another
    ground station, go to the listener alone.
    """

    def __init__(self, line: Any, listener: Listener | None = None) -> None:
        self._line = line
        self._beat = -math.inf
        self.listener = listener
        self.idle: Callable[[], None] | None = None  # called while waiting
        self.system = 0  # id of the robot; 0 before its heartbeat
        self.messages = 0  # number of messages received from the robot
        self.texts: list[str] = []  # received by STATUSTEXT
        self.last: dict[str, Any] = {}  # the robot's latest message of each kind

    def close(self) -> None:
        """Close the connection."""
        self._line.close()

    def poll(self, timeout: float = 0.0) -> Iterator[Any]:
        """Yield the robot's messages that have been received; wait up to `timeout` [s] for the first one."""
        deadline = time.monotonic() + timeout
        while True:
            now = time.monotonic()
            if now - self._beat >= HEARTBEAT:
                self._beat = now
                self.send(make_message("heartbeat", GROUND, NO_AUTOPILOT, 0, 0, 0, 3))
            with _connected():
                timeout_left = max(0.0, min(deadline - now, POLL))
                message = self._line.recv_match(blocking=timeout > 0, timeout=timeout_left)
            if self.idle is not None:
                self.idle()
            if message is not None and self._accept(message):
                yield message
                deadline = now  # do not wait for further messages
            if message is None and time.monotonic() >= deadline:
                return

    def send(self, message: Any) -> None:
        """Send a message."""
        with _connected():
            self._line.mav.send(message)

    def _accept(self, message: Any) -> bool:
        """Pass a message to the listener, and record it if it is the robot's; return whether it is."""
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
        """Wait up to `timeout` [s] for a wanted message; return None if it does not arrive."""
        deadline = time.monotonic() + timeout
        while (timeout_left := deadline - time.monotonic()) > 0:
            for message in self.poll(timeout_left):
                if wanted(message):
                    return message
        return None

    def message(self, name: str, *values: Any) -> Any:
        """Make a message whose first two fields address the robot (system and component)."""
        return make_message(name, self.system, 1, *values)

    def ask(self, message: Any, wanted: Callable[[Any], bool], what: str) -> Any:
        """Send a message, repeatedly if necessary, and return the answer; `what` names the request in errors."""
        heartbeat = self.last.get("HEARTBEAT")
        if heartbeat is not None and is_signed(heartbeat) and not self._line.mav.signing.sign_outgoing:
            fix = "give the file of its key, because this robot accepts only signed messages"
            raise InputError("must be the robot's key", key="--key", value="missing", fix=fix)
        for _ in range(TRIES):
            self.send(message)
            if (answer := self.wait(wanted, PATIENCE)) is not None:
                return answer
        value = f"unanswered after {TRIES} tries"
        raise InputError("must be answered by the robot", key=what, value=value, fix="move closer, and try again")

    def command(self, what: int, *values: float, name: str = "command") -> None:
        """Send a MAV_CMD with up to seven parameters and wait for its acknowledgement."""
        numbers = [*values, *[0.0] * (7 - len(values))]
        self._acknowledged(self.message("command_long", what, 0, *numbers), what, name)

    def _acknowledged(self, message: Any, what: int, name: str) -> None:
        """Send a command until COMMAND_ACK, retry while the robot is busy, and raise an error if it refuses."""
        answer = self.ask(message, of_kind("COMMAND_ACK", command=what), name)
        for _ in range(BUSY_TRIES):
            if answer.result_param2 != BUSY:
                break
            self.wait(lambda m: False, PAUSE)
            answer = self.ask(message, of_kind("COMMAND_ACK", command=what), name)
        if answer.result != 0:
            refusals = [sentence for _, sentence in _core.refusal_table()]
            has_reason = 0 < answer.result_param2 < len(refusals)
            reason = refusals[answer.result_param2] if has_reason else f"MAV_RESULT {answer.result}"
            raise InputError("must be accepted by the robot", key=name, value="refused", fix=reason)

    def arm(self, on: bool = True) -> None:
        """Arm or disarm."""
        self.command(400, float(on), name="arm" if on else "disarm")

    def begin_signing(self, key: bytes) -> None:
        """Send the robot a key of 32 bytes, unencrypted; both then sign, and the robot ignores unsigned messages."""
        if len(key) != 32 or not any(key):
            value = f"{len(key)} bytes long" if any(key) else "all zeros"
            raise InputError(
                "must have 32 random bytes", key="key", value=value, fix="make one: openssl rand -out key 32"
            )
        self._send_key(key)
        self._line.setup_signing(key, sign_outgoing=True)
        self._check_signed(True)

    def end_signing(self) -> None:
        """Delete the robot's key, so that it accepts unsigned messages again."""
        self._send_key(bytes(32))
        self._line.disable_signing()
        self._check_signed(False)

    def _send_key(self, key: bytes) -> None:
        self.send(self.message("setup_signing", key, int((time.time() - EPOCH) * 1e5)))

    def _check_signed(self, signed: bool) -> None:
        """Wait for a heartbeat with or without a signature."""
        if self.wait(lambda m: m.get_type() == "HEARTBEAT" and is_signed(m) == signed, 5 * HEARTBEAT) is None:
            fix = "disarm the robot, give its present key with --key, and try again"
            raise InputError("must be confirmed by the robot", key="key", value="unconfirmed", fix=fix)

    def mode(self, name: str) -> None:
        """Order the robot into a mode, by the name of its state."""
        states = [state for state, *_ in _core.state_table()]
        self.command(176, 1, _core.MODE_BASE + states.index(name), name=f"mode {name}")

    def gait(self, gait: Gait, *, fins: tuple[float, float] = (0.0, 0.0)) -> None:
        """Command a steady gait and the angles of the pectoral fins (2,) [rad], port first."""
        if len(gait.amplitude) > _core.BOARD_JOINTS:
            rule = f"must be of at most {_core.BOARD_JOINTS} joint groups for the firmware"
            raise InputError(rule, key="gait", value=f"of {len(gait.amplitude)}", fix="drive a robot that has one")

        def row(values: Iterable[float], count: int = _core.BOARD_JOINTS) -> list[int]:
            centidegrees = [round(math.degrees(float(value)) * 100) for value in values]
            return centidegrees + [0] * (count - len(centidegrees))

        rows = (row(gait.amplitude), row(lags(gait)), row(gait.bias), row(fins, len(fins)))
        message = make_message("gait_set", round(gait.frequency * 1000), *rows, self.system, 1)
        self._acknowledged(message, dialect().HYPERTUNA_CMD_GAIT, "gait")

    def manual(self, ahead: float, turn: float, climb: float) -> None:
        """Send the stick: ahead 0 to 1, turn (starboard) and climb -1 to 1. It is not acknowledged, so repeat it."""
        x, r = (round(1000 * max(-1.0, min(1.0, value))) for value in (-climb, turn))
        z = 500 + round(500 * max(0.0, min(1.0, ahead)))  # 500 is no thrust
        self.send(make_message("manual_control", self.system, x, 0, z, r, 0))


def make_message(name: str, *values: Any) -> Any:
    """Make a message of the dialect, by its name in lower case."""
    return getattr(dialect(), f"MAVLink_{name}_message")(*values)


def is_signed(message: Any) -> bool:
    """Return whether a message has a signature; pymavlink's get_signed() also requires that the key is known."""
    return bool(message.get_header().incompat_flags & 1)


def of_kind(*kinds: str, **fields: Any) -> Callable[[Any], bool]:
    """Return a predicate that is true for messages of these kinds with these values of fields."""
    return lambda m: m.get_type() in kinds and all(getattr(m, name) == value for name, value in fields.items())


@contextlib.contextmanager
def _connected() -> Iterator[None]:
    """Turn the error of a lost connection into an InputError."""
    try:
        yield
    except OSError as error:
        value, fix = (
            f"lost ({error.strerror or error})",
            "plug the device in again or check the network, then reconnect",
        )
        raise InputError("must stay open", key="--connect", value=value, fix=fix) from None
