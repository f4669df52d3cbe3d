"""MATLAB's files of version 5 (the default of `save`): their arrays of numbers, within limits of size and depth.

Cells and structures are walked; objects, functions and complex parts are left out. Files of version 7.3 are HDF5.
"""

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.door import MB, NUMBERS, check_numbers, read_bytes

LARGEST, ARRAYS, DEPTH = 256 * MB, 5000, 8  # limits: bytes unpacked; arrays; nested cells and structures
# Types of elements: of numbers -> type in NumPy; others.
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8", 16: "u1", 17: "u2"}
MATRIX, COMPRESSED = 14, 15  # types of elements that hold others
CELL, STRUCT, OBJECT, CHAR, SPARSE, DOUBLE, UINT64 = 1, 2, 3, 4, 5, 6, 15  # classes of arrays
HEADER = 128  # bytes


@dataclass
class MatFile:
    """Arrays of numbers and texts of a file, by their names: `x`, `fish.x`, `data(2).x`, `names{1}`."""

    file: str
    order: str = "<"  # of bytes
    arrays: dict[str, Array] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    count: int = 0  # arrays read so far
    numbers: int = 0  # and numbers of these


def read_matlab(path: str | Path) -> MatFile:
    """Return the arrays and texts of a file of version 5."""
    content = read_bytes(path, "points")
    mat = MatFile(str(path), "<" if content[126:128] == b"IM" else ">")
    try:
        if content[126:128] not in (b"IM", b"MI"):
            raise ValueError
        bytes_left = LARGEST
        for kind, data in _elements(memoryview(content)[HEADER:], mat.order):
            if kind == COMPRESSED:
                unpacked = zlib.decompressobj().decompress(data, bytes_left + 1)
                bytes_left -= len(unpacked)
                if bytes_left < 0:
                    rule, fix = f"must unpack to at most {LARGEST // MB} MB", "save the arrays of the points alone"
                    raise InputError(rule, file=mat.file, value="more", fix=fix)
                kind, data = next(iter(_elements(memoryview(unpacked), mat.order)))
            if kind == MATRIX:
                _matrix(mat, data, "", 0)
    except InputError:
        raise
    except (ValueError, LookupError, struct.error, zlib.error, StopIteration, OverflowError):
        fix = "save it again in MATLAB: save('points.mat', 'x', 'y')"
        raise InputError("must be a whole file of MATLAB", file=mat.file, value="not", fix=fix) from None
    return mat


def dense(rows: int, values: Array, row: Array, begin: Array, *, file: str) -> Array:
    """Return the full array of a sparse one, given its values, their rows, and the index at which a column begins."""
    columns, count = len(begin) - 1, len(values)
    valid = begin.dtype.kind in "iu" and row.dtype.kind in "iu" and row.ndim == begin.ndim == values.ndim == 1
    if not valid or columns < 1 or rows * columns > NUMBERS or (np.diff(begin.astype(float)) < 0).any():
        raise InputError("must be a whole file of MATLAB", file=file, value="not", fix="save it again")
    if (
        begin[0] != 0
        or begin[-1] > count
        or len(row) < begin[-1]
        or (row[: begin[-1]] >= rows).any()
        or (row < 0).any()
    ):
        raise InputError("must be a whole file of MATLAB", file=file, value="not", fix="save it again")
    array = np.zeros((rows, columns))
    count = int(begin[-1])
    array[row[:count], np.repeat(np.arange(columns), np.diff(begin.astype(int)))] = values[:count]
    return array


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield type and content of each element; content of up to 4 bytes is inside its tag."""
    offset = 0
    while offset + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, offset)
        if kind >> 16:
            kind, size, begin, offset = kind & 0xFFFF, kind >> 16, offset + 4, offset + 8
            if size > 4:
                raise ValueError
        else:
            begin = offset + 8
            offset = begin + size + (-size % 8 if kind != COMPRESSED else 0)
        if begin + size > len(data):
            raise ValueError
        yield kind, data[begin : begin + size]


def _numbers(mat: MatFile, element: tuple[int, memoryview]) -> Array:
    """Return the numbers of an element."""
    kind, data = element
    return np.frombuffer(data, np.dtype(mat.order + TYPES[kind]))


def _add(mat: MatFile, name: str, count: int, array: Callable[[], Array]) -> None:
    """Add an array of a number of floats, after checking that the file does not hold too many."""
    mat.numbers += count
    check_numbers(mat.numbers, mat.file)
    mat.arrays[name] = array()


def _matrix(mat: MatFile, data: memoryview, name: str, depth: int) -> None:
    """Read an array, or the arrays of a cell or a structure, into `mat`."""
    mat.count += 1
    if mat.count > ARRAYS or depth > DEPTH:
        rule, fix = f"must hold at most {ARRAYS} arrays, {DEPTH} deep", "save the arrays of the points alone"
        raise InputError(rule, file=mat.file, value="more", fix=fix)
    parts = _elements(data, mat.order)
    flags = next(parts, None)
    if flags is None:  # an empty element of a cell
        return
    kind = int(_numbers(mat, flags)[0]) & 0xFF
    if kind > UINT64:
        return  # an object or a function
    shape = tuple(int(size) for size in _numbers(mat, next(parts)))
    own_name = bytes(next(parts)[1]).decode("latin-1")
    name = name or own_name
    if kind == CELL:
        for k, (_, content) in enumerate(parts):
            _matrix(mat, content, f"{name}{{{k + 1}}}", depth + 1)
    elif kind in (STRUCT, OBJECT):
        if kind == OBJECT:
            next(parts)  # name of its class
        width, names = int(_numbers(mat, next(parts))[0]), bytes(next(parts)[1])
        fields = [names[k : k + width].split(b"\0")[0].decode("latin-1") for k in range(0, len(names), width)]
        several = np.prod(shape, dtype=float) > 1
        for k, (_, content) in enumerate(parts):
            index = f"({k // len(fields) + 1})" if several else ""
            _matrix(mat, content, f"{name}{index}.{fields[k % len(fields)]}", depth + 1)
    elif kind == CHAR:
        mat.texts[name] = "".join(map(chr, _numbers(mat, next(parts))[:10_000].tolist()))
    elif kind == SPARSE:
        row, begin, values = (_numbers(mat, next(parts)) for _ in range(3))
        if len(shape) != 2 or len(begin) != shape[1] + 1:
            raise ValueError
        _add(mat, name, shape[0] * shape[1], lambda: dense(shape[0], values, row, begin, file=mat.file))
    elif kind >= DOUBLE:
        values = _numbers(mat, next(parts))
        # a wrong size is a ValueError
        _add(mat, name, len(values), lambda: values.astype(float).reshape(shape, order="F"))
