"""The ground's side of the radio: a connection that asks, waits for the answer, and asks again where none comes."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Self

from hypertuna import _core
from hypertuna.dialect import dialect, mavutil
from hypertuna.errors import InputError, shown
from hypertuna.gait import Gait
from hypertuna.link_items import items_of
from hypertuna.mission import Mission

__all__ = ["COMPONENT", "SYSTEM", "Client", "address", "connect"]

SYSTEM, COMPONENT = 255, 190  # MAV_COMP_ID_MISSIONPLANNER, what ground stations call themselves
PATIENCE = 2.0  # s for an answer: a LoRa link of 4.8 kbit/s needs a fifth of that
TRIES = 5
HEARTBEAT = 1.0  # s
BAUD = 9600
STORED, PAUSE = 6, 0.5  # times and s to wait until a robot has stored a mission: two seconds for the longest
BUSY = [name for name, _ in _core.refusal_table()].index("busy")
EPOCH = 1420070400  # 2015-01-01, from which stamps of signatures count
MODES = ("manual", "gait", "mission")  # HYPERTUNA_CONTROL

Listener = Callable[[Any], None]


def address(text: str) -> tuple[str, int]:
    """Read where a robot is, as `--connect` takes it.

    Parameters
    ----------
    text : str
        ``udp:PORT`` or ``udp:HOST:PORT`` to listen, ``udpout:HOST:PORT`` to speak first, ``tcp:HOST:PORT``,
        ``serial:DEVICE`` or ``serial:DEVICE:BAUD``.

    Returns
    -------
    str
        As pymavlink spells it.
    int
        Baud rate [1/s], of a serial line.

    Raises
    ------
    InputError
        If it is none of these.
    """
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
    """Connect to a robot.

    Parameters
    ----------
    text : str
        As for `address`.
    key : bytes, optional
        To sign with, 32 bytes.
    patience : float
        For its first heartbeat [s].
    listener : callable, optional
        Gets every message that comes.

    Returns
    -------
    Client

    Raises
    ------
    InputError
        If the address cannot be used, or no robot is heard.
    """
    place, baud = address(text)
    try:
        line = mavutil().mavlink_connection(place, baud=baud, source_system=SYSTEM, source_component=COMPONENT)
    except OSError as error:
        value, fix = f"not ({error})", "check device, host and port"
        raise InputError("must be a line that can be opened", key="--connect", value=value, fix=fix) from None
    if key is not None:
        line.setup_signing(key, sign_outgoing=True)
    client = Client(line, listener)
    if client.wait(lambda m: m.get_type() == "HEARTBEAT", patience) is None:
        client.close()
        fix = "switch the robot on, and check address and key"
        raise InputError(f"must be heard within {patience:g} s", key="--connect", value="silent", fix=fix)
    return client


class Client:
    """A robot at the other end of a line. Whatever waits keeps the heartbeat going.

    Parameters
    ----------
    line : object
        Connection of pymavlink.
    listener : callable, optional
        Gets every message that comes.
    """

    def __init__(self, line: Any, listener: Listener | None = None) -> None:
        self._line, self._listener = line, listener
        self._beat = -math.inf
        self.system = 1
        self.texts: list[str] = []  # what the robot said in words
        self.last: dict[str, Any] = {}  # latest message of each kind

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Hang up."""
        self._line.close()

    def poll(self, timeout: float = 0.0) -> Iterator[Any]:
        """Take the messages that have come; the first is waited for.

        Parameters
        ----------
        timeout : float
            [s].

        Yields
        ------
        object
            Message of the dialect.
        """
        end = time.monotonic() + timeout
        while True:
            now = time.monotonic()
            if now - self._beat >= HEARTBEAT:
                self._beat = now
                self._line.mav.heartbeat_send(6, 8, 0, 0, 0)  # MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID
            message = self._line.recv_match(blocking=timeout > 0, timeout=max(0.0, min(end - now, HEARTBEAT)))
            if message is not None and self._takes(message):
                yield message
                end = now  # what else has come, without waiting
            if message is None and time.monotonic() >= end:
                return

    def _takes(self, message: Any) -> bool:
        """Take down a message of the robot."""
        kind = message.get_type()
        if kind == "BAD_DATA" or kind.startswith("UNKNOWN") or message.get_srcSystem() == SYSTEM:
            return False
        if kind == "HEARTBEAT":
            self.system = message.get_srcSystem()
        if kind == "STATUSTEXT":
            self.texts.append(message.text)
        self.last[kind] = message
        if self._listener is not None:
            self._listener(message)
        return True

    def wait(self, wanted: Callable[[Any], bool], timeout: float) -> Any:
        """Wait for a message.

        Parameters
        ----------
        wanted : callable
            Whether a message is it.
        timeout : float
            [s].

        Returns
        -------
        object or None
            None if it did not come in time.
        """
        end = time.monotonic() + timeout
        while (left := end - time.monotonic()) > 0:
            for message in self.poll(left):
                if wanted(message):
                    return message
        return None

    def ask(self, message: Callable[[], Any], wanted: Callable[[Any], bool], what: str) -> Any:
        """Send a message until its answer comes.

        Parameters
        ----------
        message : callable
            Makes it, for every try.
        wanted : callable
            Whether a message is the answer.
        what : str
            For the error.

        Returns
        -------
        object
            The answer.

        Raises
        ------
        InputError
            If none comes.
        """
        for _ in range(TRIES):
            self._line.mav.send(message())
            if (answer := self.wait(wanted, PATIENCE)) is not None:
                return answer
        value = f"silent after {TRIES} tries"
        raise InputError("must be answered by the robot", key=what, value=value, fix="come nearer, and try again")

    def command(self, what: int, *values: float, name: str = "command") -> None:
        """Give a command and wait for its acknowledgement.

        Parameters
        ----------
        what : int
            MAV_CMD.
        *values : float
            Its parameters, up to seven.
        name : str
            For errors.

        Raises
        ------
        InputError
            If the robot refuses it, with its reason, or does not answer.
        """
        numbers = [*values, *[0.0] * (7 - len(values))]
        make = dialect().MAVLink_command_long_message
        self._acknowledged(lambda: make(self.system, 1, what, 0, *numbers), what, name)

    def _acknowledged(self, make: Callable[[], Any], what: int, name: str) -> None:
        """Send an order until COMMAND_ACK comes, also while the robot stores something, and say why it is refused."""
        said = len(self.texts)
        answer = self.ask(make, lambda m: m.get_type() == "COMMAND_ACK" and m.command == what, name)
        for _ in range(STORED):
            if answer.result_param2 != BUSY:
                break
            self.wait(lambda m: False, PAUSE)
            answer = self.ask(make, lambda m: m.get_type() == "COMMAND_ACK" and m.command == what, name)
        if answer.result != 0:
            word = dialect().enums["MAV_RESULT"][answer.result].name.removeprefix("MAV_RESULT_").lower()
            reason = self.texts[-1] if len(self.texts) > said else word.replace("_", " ")
            raise InputError("must be accepted by the robot", key=name, value="refused", fix=reason)

    def arm(self, on: bool = True) -> None:
        """Arm or disarm.

        Parameters
        ----------
        on : bool

        Raises
        ------
        InputError
            As for `command`.
        """
        self.command(400, float(on), name="arm" if on else "disarm")

    def begin_signing(self, key: bytes) -> None:
        """Give the robot a key; from then on both sign, and the robot hears nobody else.

        Parameters
        ----------
        key : bytes
            32 of them. It goes over the line as it is: do that on the bench.

        Raises
        ------
        InputError
            If the key has another length, or the robot does not sign with it.
        """
        if len(key) != 32:
            raise InputError("must have 32 bytes", key="key", value=f"{len(key)} long", fix="make one with `openssl`")
        stamp = int((time.time() - EPOCH) * 1e5)
        self._line.mav.setup_signing_send(self.system, 1, key, stamp)
        self._line.setup_signing(key, sign_outgoing=True)
        if self.wait(lambda m: m.get_type() == "HEARTBEAT" and m.get_signed(), 5 * HEARTBEAT) is None:
            raise InputError("must be taken by the robot", key="key", value="not taken", fix="disarm it, and try again")

    def mode(self, name: str) -> None:
        """Change who makes the command.

        Parameters
        ----------
        name : {"manual", "gait", "mission"}

        Raises
        ------
        InputError
            As for `command`.
        """
        self.command(176, 1, MODES.index(name), name=f"mode {name}")

    def gait(self, gait: Gait, *, fins: tuple[float, float] = (0.0, 0.0)) -> None:
        """Swim a steady gait.

        Parameters
        ----------
        gait : Gait
        fins : tuple of float
            Angles of the pectoral fins [rad].

        Raises
        ------
        InputError
            As for `command`.
        """

        def row(values: Iterable[float]) -> list[int]:
            whole = [round(math.degrees(float(value)) * 100) for value in values]
            return whole + [0] * (4 - len(whole))

        make, what = dialect().MAVLink_gait_set_message, dialect().HYPERTUNA_CMD_GAIT
        rows = (row(gait.amplitude), row(gait.phase), row(gait.bias), row(fins)[:2])
        self._acknowledged(lambda: make(round(gait.frequency * 1000), *rows, self.system, 1), what, "gait")

    def manual(self, ahead: float, turn: float, climb: float) -> None:
        """Move the stick: no answer comes, the robot rests when the next does not come in time.

        Parameters
        ----------
        ahead : float
            0 to 1 of the top speed [1].
        turn : float
            -1 to 1, starboard positive [1].
        climb : float
            -1 to 1 of the fins' largest angle [1].
        """
        x, z, r = (round(1000 * max(-1.0, min(1.0, value))) for value in (-climb, ahead, turn))
        self._line.mav.manual_control_send(self.system, x, 0, z, r, 0)

    def parameters(self, progress: Callable[[int, int], None] | None = None) -> dict[str, float]:
        """Read all parameters; what was lost on the way is asked for one by one.

        Parameters
        ----------
        progress : callable, optional
            Called with how many came and how many there are.

        Returns
        -------
        dict of str to float
            By name in lower case, in the robot's order [SI].

        Raises
        ------
        InputError
            If the robot does not answer.
        """
        make, found, total = dialect().MAVLink_param_request_list_message, {}, 0
        answer = self.ask(lambda: make(self.system, 1), lambda m: m.get_type() == "PARAM_VALUE", "parameters")
        while answer is not None:
            total = answer.param_count
            if answer.param_index < total:
                found[answer.param_index] = answer
            if progress is not None:
                progress(len(found), total)
            if len(found) == total:
                break
            answer = self.wait(lambda m: m.get_type() == "PARAM_VALUE", PATIENCE)
        for index in sorted(set(range(total)) - set(found)):
            found[index] = self._parameter(index)
            if progress is not None:
                progress(len(found), total)
        return {found[k].param_id.lower(): found[k].param_value for k in sorted(found)}

    def _parameter(self, index: int) -> Any:
        """Ask for one parameter by its place."""
        make = dialect().MAVLink_param_request_read_message
        return self.ask(
            lambda: make(self.system, 1, b"", index),
            lambda m: m.get_type() == "PARAM_VALUE" and m.param_index == index,
            f"parameter {index}",
        )

    def set_parameter(self, name: str, value: float) -> float:
        """Set a parameter; the robot keeps it.

        Parameters
        ----------
        name : str
        value : float
            [SI].

        Returns
        -------
        float
            As it is on board [SI].

        Raises
        ------
        InputError
            If the robot refuses it, with its reason, or does not answer.
        """
        make, said = dialect().MAVLink_param_set_message, len(self.texts)

        def answers(m: Any) -> bool:
            return m.get_type() in ("PARAM_VALUE", "PARAM_ERROR") and m.param_id.lower() == name.lower()

        answer = self.ask(lambda: make(self.system, 1, name.upper().encode(), value, 9), answers, name)
        if answer.get_type() == "PARAM_VALUE" and math.isclose(answer.param_value, value, rel_tol=1e-6, abs_tol=1e-30):
            return float(answer.param_value)
        self.wait(lambda m: m.get_type() == "PARAM_ERROR", PATIENCE / 2)
        unknown = answer.get_type() == "PARAM_ERROR"
        reason = self.texts[-1] if len(self.texts) > said else "no such parameter" if unknown else "not taken"
        raise InputError("must be accepted by the robot", key=name, value=f"{value:g}", fix=reason)

    def upload(self, mission: Mission, progress: Callable[[int, int], None] | None = None) -> None:
        """Send a mission; the robot has the old one until it has all of the new.

        Parameters
        ----------
        mission : Mission
        progress : callable, optional
            Called with items asked for and all items.

        Raises
        ------
        InputError
            If the robot refuses it, or does not answer.
        """
        items = items_of(mission, self.system)
        count = dialect().MAVLink_mission_count_message
        kinds = ("MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK")

        def answers(m: Any) -> bool:
            return m.get_type() in kinds and m.target_system == SYSTEM

        answer = self.ask(lambda: count(self.system, 1, len(items)), answers, "mission")
        while answer.get_type() != "MISSION_ACK":
            item = items[min(answer.seq, len(items) - 1)]
            if progress is not None:
                progress(answer.seq, len(items))
            answer = self.ask(functools.partial(_same, item), answers, f"mission item {item.seq}")
        if answer.type != 0:
            word = dialect().enums["MAV_MISSION_RESULT"][answer.type].name.removeprefix("MAV_MISSION_").lower()
            raise InputError("must be accepted by the robot", key="mission", value=word.replace("_", " "),
                             fix="see limits in docs/radio.md")  # fmt: skip

    def download(self) -> Sequence[Any]:
        """Read the mission on board.

        Returns
        -------
        sequence of object
            Its items, MISSION_ITEM_INT.

        Raises
        ------
        InputError
            If the robot does not answer.
        """
        listing = dialect().MAVLink_mission_request_list_message
        count = self.ask(lambda: listing(self.system, 1), lambda m: m.get_type() == "MISSION_COUNT", "mission").count
        return [self._item(k) for k in range(count)]

    def _item(self, seq: int) -> Any:
        """Ask for one item of the mission on board."""
        request = dialect().MAVLink_mission_request_int_message
        return self.ask(
            lambda: request(self.system, 1, seq),
            lambda m: m.get_type() == "MISSION_ITEM_INT" and m.seq == seq,
            f"mission item {seq}",
        )


def _same(message: Any) -> Any:
    """Give the same message at every try."""
    return message
