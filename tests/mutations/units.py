"""An FMU with a damaged list of variables, loaded, stepped and read in this process as importers do."""

import functools
import io
import platform
import random
from collections.abc import Callable
from ctypes import CDLL, CFUNCTYPE, Structure, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import hypertuna as ht
from hypertuna.errors import InputError
from mutations.damage import EXTREMES

BINARY = Path(__file__).parents[2] / f"build/fmu/{platform.machine()}-linux/fmi2.so"
LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_char_p)
PLACES = (*map(str, (-1, 1, 4, 6, 7, 12, 13, 99, 2**20, 2**31 - 1, 2**31, -(2**31), 2**64)), "1e3", "0x7", "07", "")
ROLES, TYPES = ("time", "input", "fixed", "tunable", "output", "x"), ("r", "i", "b", "x", "")
HEADS = (("twin", "plant", "x"), ("plane", "sea", "x"), ("y" * 100, "y", ""))


class Callbacks(Structure):
    """`fmi2CallbackFunctions`."""

    _fields_ = (("logger", LOGGER), *((name, c_void_p) for name in ("allocate", "free", "finished", "environment")))


@functools.cache
def resources() -> tuple[bytes, bytes]:
    """Return the list of variables of a robot at sea, and its image."""
    with ZipFile(io.BytesIO(ht.fmu("hypertuna", sea=True))) as archive:
        return archive.read("resources/variables"), archive.read("resources/robot.image")


@functools.cache
def library(binary: Path) -> CDLL:
    """Load a binary of FMI 2.0."""
    loaded = CDLL(str(binary))
    loaded.fmi2Instantiate.restype = c_void_p
    return loaded


def read_unit(path: Path, binary: Path = BINARY) -> list[float]:
    """Load an FMU whose list of variables lies at a path, and call all that an importer may; return its numbers."""
    text, image = resources()
    (path.parent / "robot.image").write_bytes(image)
    said, lib, token = list[bytes](), library(binary), text.split()[4]
    logger = LOGGER(lambda *args: said.append(args[-1]))
    where, callbacks = f"file://{path.parent}".encode(), Callbacks(logger)
    unit = c_void_p(lib.fmi2Instantiate(b"unit", 1, token, where, byref(callbacks), 0, 0))
    if not unit:
        raise InputError(said.pop().decode())
    numbers, lines, state = list[float](), text.count(b"\n") + 2, c_void_p()

    def call(name: str, *args: Any) -> int:
        return int(getattr(lib, f"fmi2{name}")(unit, *args))

    def each(verb: str, value: float) -> None:
        for reference in range(lines):
            for kind, number in (("Real", c_double(value)), ("Integer", c_int(1)), ("Boolean", c_int(1))):
                if call(f"{verb}{kind}", byref(c_uint(reference)), c_size_t(1), byref(number)) == 0:
                    numbers.append(number.value)

    each("Set", 0.1)
    call("SetupExperiment", 0, c_double(0), c_double(0), 0, c_double(0))
    call("EnterInitializationMode"), call("ExitInitializationMode")
    for step in range(3):
        call("DoStep", c_double(0.05 * step), c_double(0.05), 0)
        call("SetFMUstate" if step == 2 else "GetFMUstate", state if step == 2 else byref(state))
        each("Get", 0.0), each("Set", 0.2)
    call("FreeFMUstate", byref(state)), call("Reset")
    lib.fmi2FreeInstance(unit)
    return numbers


def of_list(content: bytes, chance: random.Random) -> bytes:
    """Damage a list of variables once to three times, as one does who knows its words."""
    lines = content.decode().splitlines()
    for _ in range(chance.choice((1, 1, 2, 3))):
        k = chance.randrange(1, len(lines)) if len(lines) > 1 else 0
        words = lines[k].split(" ")
        chance.choice(WAYS)(words, chance)
        lines[k] = " ".join(words)
        if chance.random() < 0.1:
            place = chance.randrange(3)
            lines[0] = " ".join(
                (*lines[0].split(" ")[:2], *_other(lines[0].split(" ")[2:], place, HEADS[place], chance))
            )
        if chance.random() < 0.1:
            lines[k : k + 1] = [lines[k]] * chance.choice((0, 2, 300, 20_000))
    return "\n".join(lines or [""]).encode() + chance.choice((b"\n", b"\n", b"\n", b"", b"\n\n", b"\r\n", b"\0\n"))


def _other(words: list[str], place: int, values: tuple[str, ...], chance: random.Random) -> list[str]:
    """Replace a word."""
    if place < len(words):
        words[place] = chance.choice(values)
    return words


def _add(words: list[str], chance: random.Random) -> None:
    """Add or drop a word."""
    words.insert(chance.randrange(len(words) + 1), chance.choice(("", "0", "x" * 5000))) if chance.random() < 0.6 else (
        words.pop()
    )


def _word(place: Callable[[list[str]], int], values: tuple[str, ...]) -> Callable[[list[str], random.Random], Any]:
    """Return what replaces a word at a place."""
    return lambda words, chance: _other(words, place(words), values, chance)


WAYS: tuple[Callable[[list[str], random.Random], Any], ...] = (
    *[_word(lambda words: len(words) - 2 if len(words) > 3 else 9, PLACES)] * 4,
    _word(lambda words: len(words) - 1, (*EXTREMES, "1,5", "-5", "1e19")),
    _word(lambda words: 1, ROLES),
    _word(lambda words: 0, TYPES),
    _add,
)
