"""Read tracked points from C3D files: header, parameters, and frames as integers or floats of three processors."""

import math
import struct
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.door import CELLS, read_bytes
from hypertuna.trials.points import Points, Rows, seen

BLOCK, FILE_MARK = 512, 80  # bytes of a block; second byte of every C3D file
INTEL, DEC, SGI = 84, 85, 86  # processors, which differ in byte order and float format
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "meters": 1.0, "millimeters": 1e-3}  # units of length [m]
MAX_PARAMETERS, MAX_FRAME = 5000, 65535  # parameters that are read; largest frame number in a header
AXES = {"+X": 0, "+Y": 1, "+Z": 2}  # index of an axis


@dataclass(frozen=True)
class _Numbers:
    """Reader of binary numbers in the byte order and float format of one of three processors."""

    processor: int

    @property
    def order(self) -> str:
        return ">" if self.processor == SGI else "<"

    def floats(self, data: bytes) -> Array:
        """Return floats from bytes; DEC swaps 16-bit halves, and its values read as IEEE are 4 times too large."""
        if self.processor != DEC:
            with np.errstate(invalid="ignore"):  # some bytes are no valid number
                return np.frombuffer(data, f"{self.order}f4").astype(float)
        halves = np.frombuffer(data, "<u2").reshape(-1, 2)[:, ::-1]
        with np.errstate(invalid="ignore"):
            return np.ascontiguousarray(halves).view("<f4").ravel().astype(float) / 4

    def words(self, data: bytes) -> Array:
        """Return signed 16-bit integers from bytes."""
        return np.frombuffer(data, f"{self.order}i2")

    def value(self, kind: int, data: bytes) -> Any:
        """Return a parameter's value by its kind: an array of numbers, or bytes for text."""
        return data if kind in (-1, 1) else self.words(data) if kind == 2 else self.floats(data)


def read(path: str | Path, individual: str | None) -> Points:
    """Read the points of a C3D file."""
    file, content = str(path), read_bytes(path, "points")
    try:
        return _points(file, content)
    except InputError:
        raise
    except (ValueError, IndexError, struct.error, OverflowError):
        fix = "export it again: it is damaged, or was cut short"
        raise InputError("must be a whole C3D file", file=file, value="not", fix=fix) from None


def _points(file: str, content: bytes) -> Points:
    """Parse the bytes of a C3D file, and return its points."""
    start_ = (content[0] - 1) * BLOCK
    if content[1] != FILE_MARK or start_ < BLOCK:
        raise ValueError
    numbers = _Numbers(content[start_ + 3])
    if numbers.processor not in (INTEL, DEC, SGI):
        raise ValueError
    head, about = numbers.words(content[:BLOCK]).astype(int) & 0xFFFF, _parameters(content, start_ + 4, numbers)
    count, analog, first, last = head[1], head[2], head[3], head[4]
    scale, rate = numbers.floats(content[12:16])[0], numbers.floats(content[20:24])[0]
    scale, rate = (float(one[0]) if one is not None and len(one) else own for own, one in (
        (scale, about.get("POINT:SCALE")), (rate, about.get("POINT:RATE"))))  # fmt: skip
    first, last = (_long(about, f"TRIAL:ACTUAL_{word}_FIELD", own) for word, own in (("START", first), ("END", last)))
    start = about.get("POINT:DATA_START")
    begin = ((int(start[0]) & 0xFFFF if start is not None and len(start) else head[8]) - 1) * BLOCK
    width = (4 if scale < 0 else 2) * (4 * count + analog)
    if count > 0 and last == MAX_FRAME:  # the largest number in the header: count frames to the end of the file
        last = max(last, first - 1 + (len(content) - begin) // width)
    frames = last - first + 1
    if count < 1 or frames < 1 or begin < BLOCK:
        fix = "export the trajectories of the markers with it"
        raise InputError("must hold points", file=file, value="a C3D file without", fix=fix)
    if frames * (4 * count + analog) > 8 * CELLS:
        raise InputError(f"must hold at most {8 * CELLS} numbers", file=file, value="more", fix="cut it into parts")
    if begin + frames * width > len(content):
        rule, fix = f"must hold the {frames} frames that it states", "export it again: it was cut short"
        raise InputError(rule, file=file, value=f"only {max(len(content) - begin, 0) // width}", fix=fix)
    data = content[begin : begin + frames * width]
    rows = (numbers.floats(data) if scale < 0 else numbers.words(data)).reshape(frames, -1)[:, : 4 * count]
    rows = rows.reshape(frames, count, 4).astype(float)
    # a negative residual marks a point that was not seen; some programs write only zeros instead
    visible = (rows[..., 3] >= 0) & (rows[..., :3] != 0).any(axis=2)
    place = np.where(visible[..., np.newaxis], rows[..., :3] * (1.0 if scale < 0 else scale), np.nan)
    return _named(file, about, place, rate, np.arange(float(first), last + 1.0))


def _named(file: str, about: dict[str, Any], place: Array, rate: float, frame: Array) -> Points:
    """Return points with their labels, unit and vertical axis; points without a label (*12) are left out."""
    labels: list[str] = []
    for k in range(1, 100):
        labels += about.get(f"POINT:LABELS{k if k > 1 else ''}:text", [])
    names = [label or f"{k + 1}" for k, label in enumerate([*labels, *[""] * place.shape[1]][: place.shape[1]])]
    count = Counter(names)
    names = [name if count[name] == 1 else f"{name} ({k + 1})" for k, name in enumerate(names)]
    keep = [k for k, name in enumerate(names) if not name.startswith("*")]
    unit = next(iter(about.get("POINT:UNITS:text", [])), "").lower()
    up = next(iter(about.get("POINT:Y_SCREEN:text", [])), "").upper()
    return Points(
        "C3D",
        file,
        tuple(names[k] for k in keep),
        seen(place[:, keep]),
        np.full((len(place), len(keep)), np.nan),
        Rows("frame", frame),
        frame=frame,
        rate=rate if math.isfinite(rate) and rate > 0 else None,
        length_unit=LENGTHS.get(unit),
        y_down=False,
        vertical=AXES.get(up),
        ignored=tuple(name for name in names if name.startswith("*")),
    )


def _long(about: dict[str, Any], name: str, own: int) -> int:
    """Return a parameter that is stored as two 16-bit words; `own` if the file lacks it."""
    words = about.get(name)
    if words is None or len(words) != 2 or words.dtype.kind != "i":
        return own
    return (int(words[0]) & 0xFFFF) + ((int(words[1]) & 0xFFFF) << 16)


def _parameters(content: bytes, at: int, numbers: _Numbers) -> dict[str, Any]:
    """Read the parameters from a byte offset on, by GROUP:NAME; texts also as lists of strings by GROUP:NAME:text."""
    groups: dict[int, str] = {}
    entries: list[tuple[int, str, int, list[int], bytes]] = []
    for _ in range(MAX_PARAMETERS):
        length, group = struct.unpack_from("bb", content, at)
        if length == 0 or group == 0:
            break
        name = content[at + 2 : (end := at + 2 + abs(length))].decode("latin-1").strip().upper()
        (step,) = struct.unpack_from(f"{numbers.order}h", content, end)
        if group < 0:
            groups[-group] = name
        else:
            kind, count = struct.unpack_from("bB", content, end + 2)
            sizes = list(content[end + 4 : end + 4 + count])
            begin, size = end + 4 + count, abs(kind) * math.prod(sizes)
            if kind not in (-1, 1, 2, 4) or begin + size > len(content):
                raise ValueError
            entries.append((group, name, kind, sizes, content[begin : begin + size]))
        if step <= 0:
            break
        at = end + step
    values: dict[str, Any] = {}
    for group, name, kind, sizes, data in entries:
        key = f"{groups.get(group, '')}:{name}"
        values[key] = numbers.value(kind, data)
        if kind == -1 and sizes and sizes[0]:
            texts = [data[k : k + sizes[0]].decode("latin-1") for k in range(0, len(data), sizes[0])]
            values[f"{key}:text"] = [text.replace("\0", " ").strip() for text in texts]
    return values
