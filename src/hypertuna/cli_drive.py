"""The command `hypertuna drive`."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.live import Live

from hypertuna.cli_link import Connect, Key, read_key
from hypertuna.console import check_suffix, print_json, tell_written
from hypertuna.description import Robot, load
from hypertuna.dialect import need_radio
from hypertuna.drive import Stick, gamepad, moved, pressed, view
from hypertuna.errors import InputError
from hypertuna.gait import named_gait
from hypertuna.link_client import Client, connect
from hypertuna.link_log import LinkLogWriter

__all__ = ["drive_command"]

PERIOD = 0.2  # s between two words of the stick: two fit into a timeout of half a second even if one is lost


def drive_command(
    place: Connect,
    robot: Annotated[
        str, typer.Option("--robot", help="Robot whose gaits are on the keys: its name, or a file that optimize wrote.")
    ] = "hypertuna",
    log: Annotated[str | None, typer.Option("--log", help="Record all that comes in this .mcap file.")] = None,
    pad: Annotated[str | None, typer.Option("--gamepad", help="Joystick device, such as /dev/input/js0.")] = None,
    key: Key = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object at the end.")] = False,
) -> None:
    """Drive a robot by keyboard or gamepad, with a live view of what it says. It is disarmed at the end."""
    need_radio()
    check_suffix(log, (".mcap",), "--log")
    fish = load(robot)
    if not sys.stdin.isatty():
        raise InputError("must be a terminal", key="standard input", value="none", fix="start it in a terminal")
    with ExitStack() as stack:
        writer = stack.enter_context(LinkLogWriter(log, fish.name)) if log is not None else None
        listener = None if writer is None else writer.write
        client = stack.enter_context(connect(place, key=read_key(key), listener=listener))
        device = None if pad is None else stack.enter_context(_device(pad))
        stack.enter_context(_raw())
        messages = _drive(client, fish, device)
    if as_json:
        print_json({"messages": messages, "log": log})
    else:
        tell_written(log)


def _drive(client: Client, fish: Robot, device: int | None) -> int:
    """Follow the keys until it is to end; then disarm."""
    gaits, stick, count = tuple(fish.gaits), Stick(), 0
    heard, spoken, manual = time.monotonic(), 0.0, False
    with Live(console=Console(stderr=True), refresh_per_second=8, transient=True) as live:
        try:
            while stick.order != "quit":
                for _ in client.poll(0.05):
                    heard, count = time.monotonic(), count + 1
                before, stick = stick, _asked(stick, device)
                if (stick.ahead, stick.turn, stick.climb) != (before.ahead, before.turn, before.climb):
                    manual = True
                if stick.order:
                    manual = _follow(client, fish, gaits, stick.order)
                    stick = Stick(order="quit") if stick.order == "quit" else Stick() if not manual else stick
                now = time.monotonic()
                if manual and now - spoken > PERIOD:
                    spoken = now
                    client.manual(stick.ahead, stick.turn, stick.climb)
                live.update(view(client.last, client.texts, stick, gaits, now - heard))
        finally:
            with contextlib.suppress(InputError):  # a robot that is out of reach rests by its own rule
                client.arm(False)
    return count


def _follow(client: Client, fish: Robot, gaits: tuple[str, ...], order: str) -> bool:
    """Pass an order on; whether the stick goes on speaking."""
    try:
        if order == "arm":
            heart = client.last.get("HEARTBEAT")
            client.arm(heart is None or not heart.base_mode & 128)
        elif order == "stop":
            client.mode("gait")
        elif order == "mission":
            client.mode("mission")
        elif order.isdigit() and int(order) <= len(gaits):
            client.gait(named_gait(fish, gaits[int(order) - 1]))
    except InputError as error:
        client.texts.append(str(error))
    return False


def _asked(stick: Stick, device: int | None) -> Stick:
    """Take what keys and sticks ask for since the last time."""
    stick = Stick(stick.ahead, stick.turn, stick.climb)
    while not stick.order and select.select([sys.stdin], [], [], 0)[0]:
        stick = pressed(stick, os.read(sys.stdin.fileno(), 1).decode(errors="ignore"))
    while device is not None and not stick.order and select.select([device], [], [], 0)[0]:
        for event in gamepad(os.read(device, 8)):
            stick = moved(stick, event)
    return stick


@contextlib.contextmanager
def _raw() -> Iterator[None]:
    """Take keys one by one, without showing them."""
    import termios  # here, because only Unix has them
    import tty

    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


@contextlib.contextmanager
def _device(path: str) -> Iterator[int]:
    """Open a gamepad."""
    if not Path(path).exists():
        raise InputError("must be a joystick device", key="--gamepad", value=path, fix="plug it in; see ls /dev/input")
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        yield number
    finally:
        os.close(number)
