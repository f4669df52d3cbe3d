"""The C interface of hosts/hypertuna.h, called as any program would: as the shared library of `make hosts`."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hypertuna.arrays import Array
from hypertuna.swimming.gait import Gait

LIBRARY = Path(__file__).parents[1] / "build/hosts/libhypertuna.so"
ROOM = 400  # bytes of a sentence
GROUPS = ("amplitude", "phase", "bias")


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


def library() -> ctypes.CDLL:
    """Load the library, or skip."""
    if not LIBRARY.is_file():
        pytest.skip("the library of the C interface is not built: run `make hosts`")
    lib = ctypes.CDLL(str(LIBRARY))
    for name in ("ht_robot_read", "ht_twin_create"):
        getattr(lib, name).restype = ctypes.c_void_p
    for name in ("ht_quantity", "ht_derivative", "ht_twin_column"):
        getattr(lib, name).restype = ctypes.c_char_p
    lib.ht_robot_text.restype = ctypes.POINTER(ctypes.c_char)
    lib.ht_twin_state_size.restype = ctypes.c_size_t
    return lib


def numbers(array: Array) -> ctypes.c_void_p:
    """Point to the numbers of an array."""
    assert array.dtype == np.float64
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def row(gait: Gait) -> Array:
    """Return a gait as the interface takes it."""
    return np.concatenate([[gait.frequency], *(getattr(gait, kind) for kind in GROUPS)])


@dataclass
class Robot:
    """A robot that was read from an image."""

    lib: ctypes.CDLL
    handle: ctypes.c_void_p

    @classmethod
    def read(cls, image: bytes) -> "Robot | str":
        """Read an image: a robot, or the sentence that says what is wrong."""
        lib, fault = library(), ctypes.create_string_buffer(ROOM)
        handle = lib.ht_robot_read(image, ctypes.c_size_t(len(image)), fault, ctypes.c_size_t(ROOM))
        assert bool(handle) == (not fault.value)
        return cls(lib, ctypes.c_void_p(handle)) if handle else fault.value.decode()

    def __del__(self) -> None:
        """Free the robot."""
        self.lib.ht_robot_free(self.handle)

    @property
    def text(self) -> str:
        """The image's text."""
        size = ctypes.c_size_t()
        return ctypes.string_at(self.lib.ht_robot_text(self.handle, ctypes.byref(size)), size.value).decode()

    def names(self, call: str) -> list[str]:
        """Names of quantities or derivatives."""
        names: list[str] = []
        while name := getattr(self.lib, call)(len(names)):
            names.append(name.decode())
        return names

    def swim(self, model: int, gaits: Sequence[Gait], *, follow: bool = False) -> dict[str, Array]:
        """Settled gaits: quantities by name (gaits,)."""
        names, rows = self.names("ht_quantity"), np.ascontiguousarray([row(gait) for gait in gaits])
        out = np.zeros((len(rows), len(names)))
        self.lib.ht_swim(self.handle, model, numbers(rows), len(rows), int(follow), numbers(out))
        return dict(zip(names, out.T, strict=True))

    def gradient(self, model: int, gait: Gait) -> dict[str, Array]:
        """Derivatives by name (1 + 3 G,)."""
        names, at = self.names("ht_derivative"), row(gait)
        out = np.zeros((len(names), len(at)))
        self.lib.ht_gradient(self.handle, model, numbers(at), numbers(out))
        return dict(zip(names, out, strict=True))

    def path(self, model: int, gait: Gait, steps: int) -> Array:
        """Path of a beat."""
        out = np.zeros((steps + 1, 4 + self.lib.ht_robot_links(self.handle)))
        self.lib.ht_path(self.handle, model, numbers(row(gait)), steps, numbers(out))
        return out


class Twin:
    """A twin of a robot."""

    def __init__(self, robot: Robot, **start: float) -> None:
        self.robot, fault = robot, ctypes.create_string_buffer(ROOM)
        current = (ctypes.c_double * 2)(0.0, 0.0)
        given = Start(**{"bottom": float("inf"), "current": current} | start)
        self.handle = ctypes.c_void_p(
            robot.lib.ht_twin_create(robot.handle, ctypes.byref(given), fault, ctypes.c_size_t(ROOM))
        )
        self.fault = fault.value.decode()
        self.columns: dict[str, int] = {}
        width = ctypes.c_int()
        while not self.fault:
            name = robot.lib.ht_twin_column(self.handle, len(self.columns), ctypes.byref(width))
            if name is None:
                break
            self.columns[name.decode()] = width.value

    def __del__(self) -> None:
        """Free the twin."""
        self.robot.lib.ht_twin_free(self.handle)

    def command(self, gait: Gait, fins: tuple[float, float] = (0.0, 0.0), *, armed: bool = True) -> None:
        """Command a gait."""
        self.robot.lib.ht_twin_command(self.handle, numbers(row(gait)), numbers(np.array(fins)), int(armed))

    def fail(self, kind: int, first: int, last: int) -> None:
        """Break sensor channels."""
        self.robot.lib.ht_twin_break(self.handle, kind, first, last)

    def advance(self, ticks: int) -> dict[str, Array]:
        """Make ticks: the row of the last."""
        assert self.robot.lib.ht_twin_advance(self.handle, ticks) == ticks
        out = np.zeros(sum(self.columns.values()))
        self.robot.lib.ht_twin_read(self.handle, numbers(out))
        ends = np.cumsum(list(self.columns.values()))[:-1]
        return dict(zip(self.columns, np.split(out, ends), strict=True))

    @property
    def state(self) -> bytes:
        """All that the twin goes on from."""
        state = ctypes.create_string_buffer(self.robot.lib.ht_twin_state_size(self.handle))
        self.robot.lib.ht_twin_save(self.handle, state)
        return state.raw

    def restore(self, state: bytes) -> bool:
        """Go on from a state."""
        return bool(self.robot.lib.ht_twin_restore(self.handle, state, ctypes.c_size_t(len(state))))
