"""Damage that knows the structure of binary files of points and poses: HDF5, MATLAB, C3D, workbooks, databases."""

import contextlib
import io
import random
import sqlite3
import struct
import tempfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from mutations.damage import LONG, of_bytes, of_structure, of_text
from mutations.forged import _bomb, _directory, _lying, _members, _zipped

EXTREMES = (np.nan, np.inf, -np.inf, 1e308, -1e13, 0.0, -1.0)
WORDS = (0, 1, -1, 2**15 - 1, -(2**15), 255, 84, 85, 86)


def of_hdf5(content: bytes, chance: random.Random) -> bytes:
    """Damage groups, arrays, names and attributes of an HDF5 file; or its bytes."""
    import h5py

    if chance.random() < 0.3:
        return of_bytes(content, chance)
    stream = io.BytesIO(content)
    with h5py.File(stream, "r+") as file:
        places: list[str] = []
        file.visit(places.append)
        for name in chance.choices(places, k=chance.choice((1, 1, 2))):
            with contextlib.suppress(
                ValueError, TypeError, KeyError, OSError, RuntimeError, AttributeError
            ):  # cannot be damaged so
                _object(file, name, chance)
    return stream.getvalue()


def _object(file: Any, name: str, chance: random.Random) -> None:
    """Damage a group or an array of an HDF5 file."""
    import h5py

    one, kind = file[name], chance.randrange(9)
    for key, value in list(one.attrs.items()):
        if isinstance(value, bytes) and chance.random() < 0.4:
            one.attrs[key] = np.bytes_(chance.choice((of_bytes, of_text))(bytes(value), chance)[:60_000].rstrip(b"\0"))
    if kind == 0:
        del file[name]
    elif kind == 1:
        file.move(name, f"{name}{chance.choice(('x', '/y', LONG[:300], '7'))}")
    elif kind == 2:
        del file[name]
        file[name] = chance.choice((h5py.ExternalLink("/dev/zero", "/"), h5py.SoftLink("/"), h5py.SoftLink(name)))
    elif kind == 3 and name.count("/") < 20:
        file[f"{name} again"] = file["/"]  # a circle
    elif isinstance(one, h5py.Dataset) and one.size < 10**6:
        data, old = one[()], one.dtype
        attributes = dict(one.attrs)
        del file[name]
        if kind == 4:
            size = chance.choice(((10**9, 10**3), (10**5, 10**5), (0, 3), (2**40,)))
            file.create_dataset(name, size, "f8", chunks=True, compression=chance.choice(("gzip", None)))
        elif kind == 5 and old.kind in "iuf":
            with np.errstate(all="ignore"):
                flat = np.array(data, chance.choice(("f8", "f4", "i8", "u1", "c16", "?")), copy=True).reshape(-1)
            flat[: chance.choice((1, len(flat)))] = chance.choice((0, 1))
            file[name] = flat.reshape(
                chance.choice((np.shape(data), np.shape(data)[::-1], (*np.shape(data), 1), (-1,)))
            )
        elif kind == 6 and old.kind == "f":
            data.reshape(-1)[chance.randrange(data.size) :] = chance.choice(EXTREMES)
            file[name] = data
        elif kind == 7:
            file[name] = chance.choice((LONG, ["\0", "\x1b[31m"], [b"\xff"], np.zeros(2, "V7"), 5, "7"))
        else:
            file.create_dataset(name, data=data[: chance.randrange(len(data) + 1)] if data.ndim else data)
        file[name].attrs.update(attributes)


def of_matlab(content: bytes, chance: random.Random) -> bytes:
    """Damage tags, sizes and numbers of MATLAB's file, or put elements before the others: deep, long, bombs."""
    kind, new = chance.randrange(6), bytearray(content)
    if kind < 2:
        at = 128 + 4 * chance.randrange((len(new) - 128) // 4)
        value = chance.choice((0, 1, 5, 14, 15, 2**31, 2**32 - 1, chance.getrandbits(32), 0x00040001, 9))
        new[at : at + 4] = struct.pack("<I", value)
        return bytes(new)
    if kind == 2:
        deep = struct.pack("<6I", 6, 8, 1, 0, 5, 8) + struct.pack("<4I", 1, 1, 1, 0)
        cell = b""
        for _ in range(chance.choice((3, 12, 500))):
            cell = struct.pack("<2I", 14, len(deep) + len(cell)) + deep + cell
        return bytes(new[:128]) + cell * chance.choice((1, 3)) + bytes(new[128:])
    if kind == 3:
        bomb = zlib.compress(bytes(chance.choice((1000, 300_000_000))))
        return bytes(new[:128]) + struct.pack("<2I", 15, len(bomb)) + bomb + bytes(new[128:])
    if kind == 4:
        shape = struct.pack("<2i", *chance.choice(((40, 4), (2**31 - 1, 2**31 - 1), (-1, 3), (0, 0), (1, 160))))
        return bytes(new).replace(struct.pack("<2i", 40, 4), shape)
    return of_bytes(content, chance)


def of_c3d(content: bytes, chance: random.Random) -> bytes:
    """Damage words of the header, parameters or points of a C3D file."""
    new = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 5))):
        part = chance.choice((20, 20, 2000, len(new)))
        at = 2 * chance.randrange(min(part, len(new)) // 2)
        word = struct.pack("<h", chance.choice(WORDS))
        new[at : at + 2] = word if chance.random() < 0.7 else bytes([chance.getrandbits(8), new[at + 1]])
    return of_bytes(bytes(new), chance) if chance.random() < 0.2 else bytes(new)


def of_workbook(content: bytes, chance: random.Random) -> bytes:
    """Damage the texts of a workbook, its list of files, or put a bomb into it."""
    members = dict(_members(content))
    kind = chance.randrange(8)
    if kind == 0:
        return chance.choice((_bomb(), _lying(100), _directory(100_000), content + b"x", content[:-30]))
    name = chance.choice([*members])
    name = chance.choice((name, "xl/worksheets/sheet2.xml", "xl/sharedStrings.xml", "xl/workbook.xml"))
    if kind == 1:
        members.pop(name, None)
    elif kind == 2:
        entities = "".join(f'<!ENTITY a{k + 1} "{f"&a{k};" * 10}">' for k in range(9))
        body = members.get(name, b"").partition(b"?>")[2]
        members[name] = f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a0 "x">{entities}]>'.encode() + body
    elif kind == 3:
        cell = chance.choice(
            (b'r="XFD1048576"', b'r="A1048576"', b'r="ZZZZZZ1"', b'r=""', b't="s"', b't="d"', b't="e"')
        )
        members[name] = members.get(name, b"").replace(b'r="B3"', cell)
    elif kind == 4:
        number = chance.choice((b"1e400", b"nan", b"99999999", b"-1", b"", b"TRUE", b"9" * 5000))
        members[name] = members.get(name, b"").replace(b"<v>", b"<v>" + number, chance.choice((1, 5)))
    else:
        members[name] = chance.choice((of_text, of_structure, of_bytes))(members.get(name) or b"<x/>", chance)
    return _zipped(members, chance, twice=kind == 7)


def of_database(content: bytes, chance: random.Random) -> bytes:
    """Damage messages, times, topics and tables of a bag, or its bytes."""
    if chance.random() < 0.3:
        return of_bytes(content, chance)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bag.db3"
        path.write_bytes(content)
        base = sqlite3.connect(path)
        for number, data in base.execute("SELECT id, data FROM messages").fetchall():
            if chance.random() < 0.02:
                new: Any = chance.choice((of_bytes(data, chance), _numbers(data, chance), b"", "text", None, 5))
                base.execute("UPDATE OR IGNORE messages SET data = ? WHERE id = ?", (new, number))
        kind = chance.randrange(8)
        if kind == 0:
            base.execute(
                "UPDATE OR IGNORE messages SET timestamp = ?", (chance.choice((0, -1, 2**62, "x", 1.5, None)),)
            )
        elif kind == 1:
            base.execute(
                "UPDATE OR IGNORE topics SET type = ?", (chance.choice(("nav_msgs/msg/Odometry", "", None, 3)),)
            )
        elif kind == 2:
            base.execute("UPDATE OR IGNORE topics SET name = ?", (chance.choice(("\0", "\x1b[31m", LONG, None)),))
        elif kind == 3:
            base.execute(f"DROP TABLE {chance.choice(('topics', 'messages'))}")
        elif kind == 4:
            base.execute("ALTER TABLE messages RENAME TO old")
            endless = (
                "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x FROM c) SELECT 1 id, x topic_id, 1 timestamp, "
            )
            base.execute(f"CREATE VIEW messages AS {endless} x data FROM c")
        elif kind == 5:
            base.execute("UPDATE OR IGNORE messages SET topic_id = ?", (chance.choice((0, 1, 2, 10**18, "x")),))
        base.commit()
        base.close()
        return path.read_bytes()


def _numbers(data: bytes, chance: random.Random) -> bytes:
    """Put a number of 64 bits, or a length, into a message."""
    at = 4 + 8 * chance.randrange(max((len(data) - 4) // 8, 1))
    value = chance.choice(EXTREMES)
    new = struct.pack("<d", value) if chance.random() < 0.6 else struct.pack("<2I", 2**32 - 1, chance.choice((0, 4096)))
    return data[:at] + new + data[at + 8 :]
