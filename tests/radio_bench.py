"""The firmware's radio on a bench board, in lock-step or by the clock, for tests; built when it is first needed."""

import fcntl
import functools
import os
import shutil
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from hypertuna.errors import InputError
from hypertuna.firmware.boards import find_firmware, missing

ROOT = Path(__file__).parents[1]
BUILD = ROOT / os.environ.get("HYPERTUNA_BENCH", "build/firmware/bench")  # another: make test-firmware-sanitized
TICK = 0.01


@functools.cache
def built(target: str) -> Path:
    """A program of the firmware, for this machine."""
    if shutil.which("c++") is None or shutil.which("cmake") is None:
        pytest.skip("the firmware needs a C++ compiler and CMake")
    pytest.importorskip("pymavlink", reason="the firmware's MAVLink headers need the extra radio")
    BUILD.parent.mkdir(parents=True, exist_ok=True)
    with BUILD.with_suffix(".lock").open("w") as lock:  # workers of one run of the tests build one after another
        fcntl.flock(lock, fcntl.LOCK_EX)
        _build(target)
    return BUILD / "firmware" / "tests" / target


def _build(target: str) -> None:
    options = ["-G", "Ninja", "-DHYPERTUNA_BUILD_FIRMWARE=ON"]
    for command in (["cmake", "-S", ROOT, "-B", BUILD, *options], ["cmake", "--build", BUILD, "--target", target]):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


@dataclass(frozen=True)
class Told:
    """What the vehicle is doing after a tick."""

    tick: int
    faults: int
    commands: int
    refused: int
    replayed: int
    frames: int
    bad: int
    skipped: int
    frames_sent: int
    bytes_sent: int
    frequency: float
    amplitude: float
    first: float
    armed: int
    state: int
    max_waiting: int
    waypoints: int


LAYOUT = struct.Struct("<10I3f4B")


class RadioBench:
    """The robot in simulated time: bytes in and out, tick by tick."""

    def __init__(self) -> None:
        self._process = subprocess.Popen([built("radio_bench")], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._to, self._from = self._process.stdin, self._process.stdout

    def tick(self, content: bytes = b"") -> tuple[bytes, Told]:
        self._to.write(struct.pack("<H", len(content)) + content)
        self._to.flush()
        (count,) = struct.unpack("<H", self._from.read(2))
        return self._from.read(count), Told(*LAYOUT.unpack(self._from.read(LAYOUT.size)))

    def close(self) -> None:
        self._to.close()
        self._process.wait(timeout=60)
        self._from.close()


def free_port() -> int:
    """A port of UDP that nobody uses now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        number: int = line.getsockname()[1]
    return number


@contextmanager
def running(port: int, readings: Path | None = None) -> Iterator[None]:
    """The robot by the clock, on UDP, whose sensors read the numbers of a file."""
    process = subprocess.Popen([built("radio_bench"), str(port), *([] if readings is None else [readings])])
    try:
        yield
    finally:
        process.kill()
        process.wait()


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
