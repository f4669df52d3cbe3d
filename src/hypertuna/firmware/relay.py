"""Relay: the modelled radio between a board's serial port and a ground station, one control tick after the other."""

from __future__ import annotations

import contextlib
import socket
import time
from dataclasses import fields
from typing import Any, Self

from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.firmware.channel import Air, RadioModel
from hypertuna.ranges import FINITE

__all__ = ["Relay", "radio_model"]

HOST = "127.0.0.1"
PATIENCE = 10.0  # s, for an emulated board to listen
DATAGRAM = 65536  # bytes at most
WHOLE = {"packet", "buffer"}


def radio_model(text: str) -> RadioModel:
    """Read the numbers of a radio, such as ``rate=2400,loss=0.3,burst=4``."""
    known, given = [one.name for one in fields(RadioModel)], dict[str, Any]()
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, value = part.partition("=")
        if name not in known or not equals:
            fix = did_you_mean(name, known) if name not in known else f"write {name}=NUMBER"
            raise InputError("must be NAME=NUMBER of the radio", key="air", value=shown(part), fix=fix)
        try:
            number = FINITE.check(float(value), f"air.{name}", "give a number")
        except ValueError:
            raise InputError(
                "must be a number", key=f"air.{name}", value=shown(value), fix="write, as loss=0.3"
            ) from None
        given[name] = int(number) if name in WHOLE else number
    return RadioModel(**given)


class Relay:
    """Takes what a board and a ground station write, and gives it to the other as the radio lets it through."""

    def __init__(self, board: str, port: int, model: RadioModel, *, seed: int = 0) -> None:
        self.air = Air(model, seed=seed)
        self.ground = _bound()
        self.ground_address = (HOST, port)
        self.stream = board == "qemu"
        # A port that is free now: a pc's firmware will speak to it, an emulated board will listen there.
        self._board = _bound()
        self.board_port: int = self._board.getsockname()[1]
        self._board_address: tuple[str, int] | None = None
        if self.stream:
            self._board.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.ground.close()
        self._board.close()

    def connect(self) -> None:
        """Connect to an emulated board, which has to run by now; a pc's firmware speaks first."""
        late = time.monotonic() + PATIENCE
        while self.stream:
            try:
                self._board = socket.create_connection((HOST, self.board_port), timeout=PATIENCE)
            except OSError:
                if time.monotonic() > late:
                    fix = "run `make firmware` again, and see whether QEMU starts"
                    raise InputError("must listen to its radio", key="board", value="silent", fix=fix) from None
                time.sleep(0.02)
            else:
                self._board.setblocking(False)
                return

    def carry(self, now: float) -> None:
        """Let everything through that has its time: `now` [s]."""
        self.air.write(0, self._from_board(), now)
        self.air.write(1, _received(self.ground), now)
        if down := self.air.read(1, now):
            with contextlib.suppress(OSError):  # nobody listens
                self.ground.sendto(down, self.ground_address)
        if up := self.air.read(0, now):
            with contextlib.suppress(OSError):
                if self.stream:
                    self._board.sendall(up)
                elif self._board_address is not None:
                    self._board.sendto(up, self._board_address)

    def _from_board(self) -> bytes:
        found = bytearray()
        with contextlib.suppress(OSError):  # no more for now
            while True:
                if self.stream:
                    part = self._board.recv(DATAGRAM)
                else:
                    part, self._board_address = self._board.recvfrom(DATAGRAM)
                if not part:
                    break
                found += part
        return bytes(found)


def _bound() -> socket.socket:
    """Open a free port for datagrams that does not wait."""
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind((HOST, 0))
    made.setblocking(False)
    return made


def _received(from_: socket.socket) -> bytes:
    """Take all datagrams that have come."""
    found = bytearray()
    with contextlib.suppress(OSError):
        while True:
            found += from_.recv(DATAGRAM)
    return bytes(found)
