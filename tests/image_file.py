"""What a robot image holds, read as hosts/image.hpp does: its columns and its text."""

import json
import struct
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from hypertuna.arrays import Array

HEADER, ENTRY = 32, 12  # bytes


def _parts(image: bytes) -> tuple[int, int, int]:
    """Return the counts of columns, and of bytes of names and text."""
    columns, names, text = struct.unpack_from("<3I", image, 16)
    return columns, names, text


def text_of(image: bytes) -> dict[str, Any]:
    """Return the text of an image."""
    columns, names, size = _parts(image)
    start = HEADER + ENTRY * columns + names
    text: dict[str, Any] = json.loads(image[start : start + size])
    return text


def columns_of(image: bytes) -> dict[str, Array]:
    """Return the numbers of an image by column."""
    return dict(_columns(image))


def _columns(image: bytes) -> Iterator[tuple[str, Array]]:
    columns, names, size = _parts(image)
    name = HEADER + ENTRY * columns
    at = -(-(name + names + size) // 8) * 8
    for k in range(columns):
        rows, width, length = struct.unpack_from("<3I", image, HEADER + ENTRY * k)
        yield image[name : name + length].decode(), np.frombuffer(image, "<f8", rows * width, at)
        name, at = name + length, at + 8 * rows * width


def with_bytes(image: bytes, at: int, content: bytes) -> bytes:
    """Return an image with other bytes at a place, and the right checksum."""
    changed = bytearray(image)
    changed[at : at + len(content)] = content
    struct.pack_into("<I", changed, 12, zlib.crc32(changed[16:]))
    return bytes(changed)


def with_number(image: bytes, at: int, number: float) -> bytes:
    """Return an image with another number at a place among all, and the right checksum."""
    (count,) = struct.unpack_from("<I", image, 28)
    return with_bytes(image, len(image) - 8 * (count - at), struct.pack("<d", number))
