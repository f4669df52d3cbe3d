"""Records of a black box, made by the book."""

import struct

import numpy as np

from hypertuna import _core
from hypertuna.firmware.black_box import record_dtype

JOINTS = 2


def sealed(kind: int, body: bytes) -> bytes:
    """A record: mark, words, and the sum of all partial sums, by the book."""
    content = struct.pack("<I", _core.RECORD_MARK | kind << 8 | len(body) // 4) + body
    total = sums = 0
    for (word,) in struct.iter_unpack("<I", content):
        total = (total + word) % 2**32
        sums = (sums + total) % 2**32
    return content + struct.pack("<I", sums)


def head(layout: int = _core.RECORD_LAYOUT, parameters: int = 7, joints: int = JOINTS) -> bytes:
    return sealed(_core.RECORD_ROBOT, struct.pack("<3I", layout, parameters, joints))


def tick(k: int) -> bytes:
    row = np.zeros((), record_dtype(JOINTS))
    row["tick"], row["bend_read"], row["depth_read"], row["mode"] = k, (0.1 * k, np.nan), 0.5, k % 3
    row["attitude_estimated"] = (1, 0, 0, 0)
    return sealed(_core.RECORD_TICK, row.tobytes())
