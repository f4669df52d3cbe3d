"""Boards that run the firmware with a twin: a program on this machine, or an emulated Cortex-M7."""

import contextlib
import os
import shutil
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.errors import InputError
from hypertuna.firmware.lockstep import FROM_BOARD
from hypertuna.io.files import scratch, write_atomically

BOARDS = {"pc": "pc", "qemu": "qemu_mps2.elf"}  # board -> end of the name of its program
EMULATOR = "qemu-system-arm"
BOX = "black_box"  # file to which a board writes its black box
COMPILER = "arm-none-eabi-g++"
INSTRUCTIONS = 40 / 64  # per count of the board's clock: an instruction takes 64 ns of emulated time, a count 40 ns
FOLDER = Path(__file__).parents[3] / "build" / "firmware"  # default folder of the programs


def missing(board: str) -> str | None:
    """Return a sentence on what a board needs and this machine lacks; None if it can run."""
    if board == "qemu":
        for program in (EMULATOR, COMPILER):
            if shutil.which(program) is None:
                return f"{program} is not installed: run `make system-deps`"
    return None


def find_firmware(robot: str, board: str, folder: str | Path | None = None) -> Path:
    """Return the path of a robot's firmware for a board."""
    path = Path(FOLDER if folder is None else folder) / f"{robot}-{BOARDS[board]}"
    if not path.is_file():
        fix = f"run `make firmware ROBOT={robot}`" if missing(board) is None else str(missing(board))
        raise InputError("must be a firmware program, but the file does not exist", file=str(path), fix=fix)
    return path


class Board:
    """Running firmware: it answers each message."""

    def __init__(self, process: subprocess.Popen[bytes], to_board: IO[bytes], from_board: IO[bytes]) -> None:
        self.process, self.to_board, self.from_board = process, to_board, from_board

    def send(self, message: bytes) -> None:
        """Send messages (TO_BOARD) to the board."""
        with contextlib.suppress(BrokenPipeError):  # `answer` reports that the board has ended
            self.to_board.write(message)
            self.to_board.flush()

    def answer(self, count: int = 1) -> bytes:
        """Return the bytes of `count` answers (FROM_BOARD), waiting for them."""
        content = self.from_board.read(count * FROM_BOARD.itemsize)
        if len(content) < count * FROM_BOARD.itemsize:
            status = self.process.wait()
            fix = "run `make firmware` again: its version must match"
            raise InputError("must run to the end", key="firmware", value=f"it ended with status {status}", fix=fix)
        return content

    def run(self, messages: NDArray[Any]) -> NDArray[Any]:
        """Send messages (n,) of TO_BOARD and return the answers (n,) of FROM_BOARD, without waiting for each."""
        sender = threading.Thread(target=self.send, args=(messages.tobytes(),))
        sender.start()
        content = self.answer(len(messages))
        sender.join()
        return np.frombuffer(content, FROM_BOARD)


@contextlib.contextmanager
def started(
    board: str, firmware: Path, radio: int | None = None, black_box: str | Path | None = None
) -> Iterator[Board]:
    """Run firmware on a board ("pc" or "qemu") until the end of the context.

    `radio`: port of 127.0.0.1, to which a PC sends MAVLink by UDP, and on which an emulated board listens for TCP.
    `black_box`: file that gets the black box at the end.
    """
    if board == "qemu" and radio is not None:
        _check_free(radio)
    firmware = firmware.absolute()  # the program runs in another folder
    with scratch() as folder:
        if board == "pc":
            options = [] if radio is None else ["--udp", str(radio)]
            options += [] if black_box is None else ["--box", BOX]
            process = subprocess.Popen([firmware, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder)
            assert process.stdin is not None
            assert process.stdout is not None
            to_board: IO[bytes] = process.stdin
            from_board: IO[bytes] = process.stdout
        else:
            for name in ("to_board", "from_board"):
                os.mkfifo(folder / name)
            serial = "null" if radio is None else f"tcp:127.0.0.1:{radio},server=on,wait=off"
            machine = ["-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", serial, "-icount", "shift=6"]
            semihosting = ["-semihosting-config", "enable=on,target=native", "-kernel", str(firmware)]
            process = subprocess.Popen([EMULATOR, *machine, *semihosting], cwd=folder, stdin=subprocess.DEVNULL)
            to_board = _opened(folder / "to_board", process)
            from_board = (folder / "from_board").open("rb")
        try:
            yield Board(process, to_board, from_board)
        finally:
            process.kill()
            process.wait()
            from_board.close()
            with contextlib.suppress(BrokenPipeError):  # unread messages
                to_board.close()
            if black_box is not None and (folder / BOX).exists():
                write_atomically(black_box, (folder / BOX).read_bytes())


def _check_free(port: int) -> None:
    """Check that a port is free."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError as error:
            rule = f"must be a free port ({error.strerror})"
            raise InputError(rule, key="radio", value=str(port), fix="choose another one") from None


def _opened(fifo: Path, process: subprocess.Popen[bytes]) -> IO[bytes]:
    """Open a FIFO for writing as soon as a process reads from it."""
    while process.poll() is None:
        try:
            handle = os.open(fifo, os.O_WRONLY | os.O_NONBLOCK)
        except OSError:  # no reader yet
            time.sleep(0.005)
            continue
        os.set_blocking(handle, True)
        return os.fdopen(handle, "wb")
    fix = "run `make firmware` again"
    raise InputError("must start", key="firmware", value=f"{EMULATOR} ended with status {process.returncode}", fix=fix)
