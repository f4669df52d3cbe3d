"""The command `hypertuna radio drive`."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

from rich.console import Console
from rich.live import Live

from hypertuna.cli.emit import emit
from hypertuna.cli.options import AsJson, RobotOptions, file, grouped, text
from hypertuna.cli.radio import Connect, Key
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.files import Closing
from hypertuna.radio.client import Client, connect
from hypertuna.radio.drive import EVENT, Stick, gamepad, keys, moved, pressed, view
from hypertuna.radio.log import RadioLogWriter, check_new
from hypertuna.swimming.gait import named_gait

PERIOD = 0.2  # s between stick messages: if one is lost, the next still comes within the timeout of 0.5 s


@grouped
def drive_command(
    place: Connect,
    robot: RobotOptions,
    log: Annotated[str | None, file("--log", "all messages", ".mcap")] = None,
    pad: Annotated[str | None, text("--gamepad", "Joystick device, such as /dev/input/js0.", "DEVICE")] = None,
    key: Key = None,
    as_json: AsJson = False,
) -> None:
    """Drive a robot by keyboard or gamepad, with a live view of its messages; disarm it at the end."""
    fish = robot.load()
    if not sys.stdin.isatty():
        raise InputError(
            "must be a terminal", key="standard input", value="not one", fix="start the command in a terminal"
        )
    if log is not None:
        check_new(log)
    with ExitStack() as stack:
        client = stack.enter_context(connect(place, key=key))
        writer = stack.enter_context(RadioLogWriter(log, fish.name)) if log is not None else None
        client.listener = None if writer is None else writer.write
        stick = None if pad is None else stack.enter_context(Pad(pad, client.texts))
        stack.enter_context(_single_keys())
        disarmed = _drive(client, fish, stick)
        messages = client.messages
    emit(
        disarmed,
        record=lambda disarmed: {"messages": messages, "disarmed": disarmed, "log": log},
        lines=lambda ok: [f"{messages} messages; the robot {'is disarmed' if ok else 'did not answer to disarm'}"],
        written=(log,),
        as_json=as_json,
    )
    if not disarmed:
        fix = "the robot rests by itself after link_timeout without a message"
        raise InputError("must be answered by the robot", key="disarm", value="unanswered", fix=fix)


def _drive(client: Client, fish: Robot, pad: Pad | None) -> bool:
    """Send the keys' orders until the operator quits, then disarm; return whether the robot confirmed the disarming."""
    gaits, stick = tuple(fish.gaits), Stick()
    received, sent, manual, disarmed = time.monotonic(), 0.0, False, False
    with Live(console=Console(stderr=True), refresh_per_second=8, screen=True) as live:
        client.idle = lambda: live.update(view(client.last, client.texts, stick, gaits, time.monotonic() - received))
        try:
            while stick.order != "quit":
                for _ in client.poll(0.05):
                    received = time.monotonic()
                last_stick, stick = stick, _moved_stick(stick, pad)
                moves = (stick.ahead, stick.turn, stick.climb) != (last_stick.ahead, last_stick.turn, last_stick.climb)
                if moves and not manual:
                    manual = _try_order(client, lambda: _begin_manual(client))
                if stick.order and stick.order != "quit":
                    _send_order(client, fish, gaits, stick.order)
                    stick, manual = Stick(), False
                if manual and time.monotonic() - sent > PERIOD:
                    sent = time.monotonic()
                    client.manual(stick.ahead, stick.turn, stick.climb)
        except KeyboardInterrupt:  # Ctrl-C or a closed terminal quits, as the key q does
            pass
        finally:
            client.texts.append("disarming")
            with contextlib.suppress(InputError):  # a robot out of reach rests after its own link timeout
                client.arm(False)
                disarmed = True
    return disarmed


def _send_order(client: Client, fish: Robot, gaits: tuple[str, ...], order: str) -> None:
    """Send the order of a key to the robot; show the reason if it refuses."""
    if order == "arm":
        heartbeat = client.last.get("HEARTBEAT")
        _try_order(client, lambda: client.arm(heartbeat is None or not heartbeat.base_mode & 128))
    elif order == "stop":
        _try_order(client, lambda: client.mode("rest"))
    elif order == "mission":
        _try_order(client, lambda: client.mode("mission"))
    elif order.isdigit() and int(order) <= len(gaits):
        _try_order(client, lambda: client.gait(named_gait(fish, gaits[int(order) - 1])))


def _begin_manual(client: Client) -> None:
    """Select the mode in which the robot follows sticks, and send centered ones, so that it stays at rest."""
    client.mode("manual")
    client.manual(0.0, 0.0, 0.0)


def _try_order(client: Client, order: Callable[[], None]) -> bool:
    """Call `order`, which sends an order, and show a refusal; return whether the robot accepted it."""
    try:
        order()
    except InputError as error:
        client.texts.append(str(error))
        return False
    return True


def _moved_stick(stick: Stick, pad: Pad | None) -> Stick:
    """Return the stick moved by all keys and gamepad events since the last call."""
    stick = Stick(stick.ahead, stick.turn, stick.climb)
    if select.select([sys.stdin], [], [], 0)[0]:
        bytes_read = os.read(sys.stdin.fileno(), 64)
        for key in keys(bytes_read) if bytes_read else "q":  # no bytes: the terminal is gone
            stick = pressed(stick, key)
            if stick.order:
                return stick
    for event in [] if pad is None else pad.events():
        stick = moved(stick, event)
        if stick.order:
            return stick
    return stick


@contextlib.contextmanager
def _single_keys() -> Iterator[None]:
    """Switch the terminal to single keys without echo, and back at the end."""
    import termios  # imported here, because only Unix has these two modules
    import tty

    settings = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield
    finally:
        with contextlib.suppress(termios.error):  # the terminal may be gone
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)


class Pad(Closing):
    """A gamepad; if it is unplugged, the stick returns to rest."""

    def __init__(self, path: str, texts: list[str]) -> None:
        fix = "plug it in, and look for it with `ls /dev/input`"
        try:
            self._file: int | None = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            value = f"{path} ({error.strerror})"
            raise InputError("must be a joystick device", key="--gamepad", value=value, fix=fix) from None
        if Path(path).is_dir() or Path(path).is_file():
            self.close()
            raise InputError("must be a joystick device", key="--gamepad", value=path, fix=fix)
        self._rest, self._texts = b"", texts

    def close(self) -> None:
        """Close the device."""
        if self._file is not None:
            os.close(self._file)
        self._file = None

    def events(self) -> list[tuple[str, float]]:
        """Return the events since the last call; a stop once the gamepad is gone."""
        if self._file is None:
            return []
        try:
            content = os.read(self._file, 1024)
        except BlockingIOError:  # nothing new
            return []
        except OSError:
            content = b""
        if not content:
            self.close()
            self._texts.append("the gamepad is disconnected: drive with the keys, or restart the command")
            return [("gone", 1.0)]
        content = self._rest + content
        length = len(content) - len(content) % EVENT.size
        self._rest = content[length:]
        return gamepad(content[:length])
