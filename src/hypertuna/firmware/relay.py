"""Relay: the modeled radio between a board's serial port and a ground station, tick by tick."""

import contextlib
import socket
import time
from dataclasses import fields
from typing import Any

from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.firmware.channel import Air, RadioModel
from hypertuna.io.files import Closing
from hypertuna.ranges import FINITE

HOST = "127.0.0.1"
TIMEOUT = 10.0  # s within which an emulated board must listen
DATAGRAM = 65536  # largest datagram [bytes]
INTEGERS = {"packet", "buffer"}  # attributes of a RadioModel that are whole numbers


def radio_model(text: str) -> RadioModel:
    """Parse the attributes of a RadioModel, such as ``rate=2400,loss=0.3,burst=4``."""
    names, attributes = [field.name for field in fields(RadioModel)], dict[str, Any]()
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, value = part.partition("=")
        if name not in names or not equals:
            fix = did_you_mean(name, names) if name not in names else f"write {name}=NUMBER"
            raise InputError("must be NAME=NUMBER of the radio", key="air", value=shown(part), fix=fix)
        try:
            number = FINITE.check(float(value), f"air.{name}", "give a number")
        except ValueError:
            fix = "write, for example, loss=0.3"
            raise InputError("must be a number", key=f"air.{name}", value=shown(value), fix=fix) from None
        attributes[name] = int(number) if name in INTEGERS else number
    return RadioModel(**attributes)


class Relay(Closing):
    """Carry bytes between a board and a ground station (UDP, `port`) over the modeled radio."""

    def __init__(self, board: str, port: int, model: RadioModel, *, seed: int = 0) -> None:
        self.air = Air(model, seed=seed)
        self.ground = _udp_socket()
        self.ground_address = (HOST, port)
        self.stream = board == "qemu"
        # A free port: the firmware on a PC will send to it, an emulated board will listen on it.
        self._board = _udp_socket()
        self.board_port: int = self._board.getsockname()[1]
        self._board_address: Any = None
        if self.stream:
            self._board.close()

    def close(self) -> None:
        """Close both ends."""
        self.ground.close()
        self._board.close()

    def connect(self) -> None:
        """Connect to an emulated board that is running; the firmware on a PC sends first."""
        deadline = time.monotonic() + TIMEOUT
        while self.stream:
            try:
                self._board = socket.create_connection((HOST, self.board_port), timeout=TIMEOUT)
            except OSError:
                if time.monotonic() > deadline:
                    fix = "run `make firmware` again, and check that QEMU starts"
                    raise InputError("must listen to its radio", key="board", value="silent", fix=fix) from None
                time.sleep(0.02)
            else:
                self._board.setblocking(False)
                return

    def carry(self, now: float, *, deaf: bool = False) -> None:
        """Carry all bytes up to the simulated time `now` [s]; nothing passes while the robot is deaf, under water."""
        self.air.deaf = deaf
        from_board, sender = _receive_all(self._board)
        self._board_address = sender or self._board_address
        self.air.write(0, from_board, now)
        self.air.write(1, _receive_all(self.ground)[0], now)
        with contextlib.suppress(OSError):  # no listener
            if to_ground := self.air.read(1, now):
                self.ground.sendto(to_ground, self.ground_address)
        with contextlib.suppress(OSError):
            if (to_board := self.air.read(0, now)) and self.stream:
                self._board.sendall(to_board)
            elif to_board and self._board_address is not None:
                self._board.sendto(to_board, self._board_address)


def _udp_socket() -> socket.socket:
    """Open a non-blocking UDP socket on a free port."""
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp.bind((HOST, 0))
    udp.setblocking(False)
    return udp


def _receive_all(line: socket.socket) -> tuple[bytes, Any]:
    """Return all bytes that have arrived, and the address of their sender."""
    received, sender = bytearray(), None
    with contextlib.suppress(OSError):  # no more for now
        while True:
            datagram, sender = line.recvfrom(DATAGRAM)
            if not datagram:
                break
            received += datagram
    return bytes(received), sender
