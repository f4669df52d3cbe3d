"""The C interface of hosts/hypertuna.h, called as any program would: the shared library of `make hosts`, or the core in
WebAssembly in Node.js, that of `make studio-core` or else that of the studio's page.
"""

import base64
import ctypes
import gzip
import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pytest

from hypertuna.arrays import Array
from hypertuna.swimming.gait import Gait

ROBOTS = (
    "hypertuna",
    "rexeel",
    "rexeel-theory",
    "examples/minnow.toml",
    "examples/myfish.toml",
    "examples/servofish.toml",
)
TOP = Path(__file__).parents[1]
LIBRARY = TOP / os.environ.get("HYPERTUNA_HOSTS", "build/hosts") / "libhypertuna.so"  # make test-hosts-sanitized
CORE = TOP / "build/studio/core.wasm"
PAGE = TOP / "data/studio/studio.html"
ROOM = 400  # bytes of a sentence
GROUPS = ("amplitude", "phase", "bias")
CREATORS = {"ht_robot_read", "ht_twin_create", "ht_twin_fly"}
POINTERS = CREATORS | {"ht_robot_text", "ht_quantity", "ht_derivative", "ht_twin_column"}
POINTERS |= {"ht_quantity_label", "ht_quantity_unit"}


class Start(ctypes.Structure):
    """`ht_start`."""

    _fields_ = (
        ("sea", ctypes.c_int),
        ("seed", ctypes.c_uint64),
        ("speed", ctypes.c_double),
        ("depth", ctypes.c_double),
        ("heading", ctypes.c_double),
        ("current", ctypes.c_double * 2),
        ("bottom", ctypes.c_double),
    )


class Host(Protocol):
    """Where the core runs."""

    def call(self, name: str, *args: Any) -> int:
        """Call a function with whole numbers, bytes, and arrays, which receive what it writes."""

    def read(self, at: int, size: int | None = None) -> bytes:
        """Read memory of a size, or up to a zero."""


class Native:
    """The shared library."""

    def __init__(self) -> None:
        if not LIBRARY.is_file():
            pytest.skip("the library of the C interface is not built: run `make hosts`")
        self.lib = ctypes.CDLL(str(LIBRARY))
        for name in POINTERS | {"ht_twin_state_size"}:
            getattr(self.lib, name).restype = ctypes.c_size_t

    def call(self, name: str, *args: Any) -> int:
        """Call a function."""

        def taken(value: Any) -> Any:
            if isinstance(value, np.ndarray):
                assert value.flags.c_contiguous
                return ctypes.c_void_p(value.ctypes.data)
            return value if isinstance(value, bytes) else ctypes.c_size_t(value)

        result: int = getattr(self.lib, name)(*map(taken, args))
        return result

    def read(self, at: int, size: int | None = None) -> bytes:
        """Read memory."""
        return ctypes.string_at(at, -1 if size is None else size)

    def close(self) -> None:
        """Nothing is open."""


class InNode:
    """The core in WebAssembly, in a process of Node.js."""

    def __init__(self) -> None:
        node = shutil.which("node")
        if node is None:
            pytest.skip("Node.js is not installed")
        with tempfile.NamedTemporaryFile(suffix=".wasm") as file:
            file.write(wasm())
            file.flush()
            command = [node, str(TOP / "tests/hosts/serve_core.mjs"), file.name]
            self.node = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            assert self._ask("read", 0, 0) == {"memory": ""}

    def _ask(self, what: str, *given: Any) -> Any:
        assert self.node.stdin
        assert self.node.stdout
        self.node.stdin.write(json.dumps({"ask": what, "with": given}) + "\n")
        self.node.stdin.flush()
        return json.loads(self.node.stdout.readline())

    def call(self, name: str, *args: Any) -> int:
        """Call a function."""
        given = [int(arg) if isinstance(arg, int | np.integer) else base64.b64encode(arg).decode() for arg in args]
        answer = self._ask("call", name, given)
        for arg, memory in zip(args, answer["memory"], strict=True):
            if isinstance(arg, np.ndarray):
                arg.reshape(-1).view(np.uint8)[:] = np.frombuffer(base64.b64decode(memory), np.uint8)
        result: int = answer["result"]
        return result

    def read(self, at: int, size: int | None = None) -> bytes:
        """Read memory."""
        return base64.b64decode(self._ask("read", at, size)["memory"])

    def close(self) -> None:
        """End the process."""
        self.node.communicate()


def wasm() -> bytes:
    """Return the core in WebAssembly, or skip."""
    if CORE.is_file():
        return CORE.read_bytes()
    if not PAGE.is_file():
        pytest.skip("the core in WebAssembly is not built: run `make studio-core`")
    found = re.search(r'<script[^>]* id="core">([^<]*)<', PAGE.read_text(encoding="utf-8"))
    assert found
    return gzip.decompress(base64.b64decode(found[1]))


def row(gait: Gait) -> Array:
    """Return a gait as the interface takes it."""
    return np.concatenate([[gait.frequency], *(getattr(gait, kind) for kind in GROUPS)])


class Robot:
    """A robot that was read from an image."""

    def __init__(self, host: Host, handle: int) -> None:
        self.host, self.handle = host, handle

    @classmethod
    def read(cls, image: bytes, host: Host) -> "Robot | str":
        """Read an image: a robot, or the sentence that says what is wrong."""
        fault = np.zeros(ROOM, np.uint8)
        handle = host.call("ht_robot_read", image, len(image), fault, ROOM)
        sentence = sentence_of(fault)
        assert bool(handle) == (not sentence)
        return cls(host, handle) if handle else sentence

    def __del__(self) -> None:
        """Free the robot."""
        free(self.host, "ht_robot_free", self.handle)

    @property
    def text(self) -> str:
        """The image's text."""
        size = np.zeros(8, np.uint8)
        at = self.host.call("ht_robot_text", self.handle, size)
        return self.host.read(at, int.from_bytes(size, "little")).decode()

    def count(self, what: str) -> int:
        """Number of groups, links or models."""
        return self.host.call(f"ht_robot_{what}", self.handle)

    def names(self, call: str) -> list[str]:
        """Names of quantities or derivatives."""
        names: list[str] = []
        while at := self.host.call(call, len(names)):
            names.append(self.host.read(at).decode())
        return names

    def swim(self, model: int, gaits: Sequence[Gait], *, follow: bool = False) -> dict[str, Array]:
        """Settled gaits: quantities by name (gaits,)."""
        names, rows = self.names("ht_quantity"), np.ascontiguousarray([row(gait) for gait in gaits])
        out = np.zeros((len(rows), len(names)))
        self.host.call("ht_swim", self.handle, model, rows, len(rows), int(follow), out)
        return dict(zip(names, out.T, strict=True))

    def gradient(self, model: int, gait: Gait) -> dict[str, Array]:
        """Derivatives by name (1 + 3 G,)."""
        names, at = self.names("ht_derivative"), row(gait)
        out = np.zeros((len(names), len(at)))
        self.host.call("ht_gradient", self.handle, model, at, out)
        return dict(zip(names, out, strict=True))

    def path(self, model: int, gait: Gait, steps: int) -> Array:
        """Path of a beat."""
        out = np.zeros((steps + 1, 4 + self.count("links")))
        self.host.call("ht_path", self.handle, model, row(gait), steps, out)
        return out


class Twin:
    """A twin of a robot, under a command or on one of its missions."""

    def __init__(self, robot: Robot, mission: int | None = None, **start: Any) -> None:
        self.robot, self.host, fault = robot, robot.host, np.zeros(ROOM, np.uint8)
        if mission is None:
            current = (ctypes.c_double * 2)(*start.pop("current", (0.0, 0.0)))
            given = Start(**{"bottom": float("inf"), "current": current} | start)
            self.handle = self.host.call("ht_twin_create", robot.handle, bytes(given), fault, ROOM)
        else:
            self.handle = self.host.call("ht_twin_fly", robot.handle, mission, start["seed"], fault, ROOM)
        self.made = 0  # ticks
        self.fault = sentence_of(fault)
        assert bool(self.handle) == (not self.fault)
        self.columns: dict[str, int] = {}
        width = np.zeros(1, np.int32)
        while not self.fault:
            name = self.host.call("ht_twin_column", self.handle, len(self.columns), width)
            if not name:
                break
            self.columns[self.host.read(name).decode()] = int(width[0])

    def __del__(self) -> None:
        """Free the twin."""
        free(self.host, "ht_twin_free", self.handle)

    def command(self, gait: Gait, fins: tuple[float, float] = (0.0, 0.0), *, armed: bool = True) -> None:
        """Command a gait."""
        self.host.call("ht_twin_command", self.handle, row(gait), np.array(fins), int(armed))

    def fail(self, kind: int, first: int, last: int) -> None:
        """Break sensor channels."""
        self.host.call("ht_twin_break", self.handle, kind, first, last)

    def jam(self, fin: int, kind: int) -> None:
        """Let a fin's servo stand."""
        self.host.call("ht_twin_jam", self.handle, fin, kind)

    def advance(self, ticks: int) -> dict[str, Array]:
        """Make ticks: the row of the last."""
        made = self.host.call("ht_twin_advance", self.handle, ticks)
        self.made += made
        assert made == ticks or "ending" in self.columns
        return self.read()

    def read(self) -> dict[str, Array]:
        """Return all columns of the last tick."""
        out = np.zeros(sum(self.columns.values()))
        self.host.call("ht_twin_read", self.handle, out)
        ends = np.cumsum(list(self.columns.values()))[:-1]
        return dict(zip(self.columns, np.split(out, ends), strict=True))

    @property
    def state(self) -> bytes:
        """All that the twin goes on from."""
        state = np.zeros(self.host.call("ht_twin_state_size", self.handle), np.uint8)
        self.host.call("ht_twin_save", self.handle, state)
        return state.tobytes()

    def restore(self, state: bytes) -> bool:
        """Go on from a state."""
        return bool(self.host.call("ht_twin_restore", self.handle, state, len(state)))


def free(host: Host, name: str, handle: int) -> None:
    """Free what a handle stands for, unless all went with its process."""
    if not (isinstance(host, InNode) and host.node.returncode is not None):
        host.call(name, handle)


def sentence_of(fault: Array) -> str:
    """Return what was written before the zero."""
    return fault.tobytes().split(b"\0")[0].decode()
