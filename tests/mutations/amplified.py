"""Damage that says little many times: a small file whose content would be large, or slow to search through."""

import io
import random
import re
import sqlite3
import struct
import tempfile
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from mutations.forged import _members

SIZES = (1000, 100_000, 6_100_000, 30_000_000, 120_000_000)  # numbers of an array
COUNTS = (10, 300, 5000, 60_000)  # of names, points or rows
LETTERS = 50_000_000  # of a text, before it is packed


def of_npz(content: bytes, chance: random.Random) -> bytes:
    """Replace arrays of an archive by many numbers of a byte."""
    members, size = dict(_members(content)), chance.choice(SIZES)
    for name in chance.sample([*members], chance.randint(1, len(members))):
        rest = np.load(io.BytesIO(members[name])).shape[1:]
        shape = (size // max(int(np.prod(rest)), 1), *rest) if chance.random() < 0.7 else (size,)
        out = io.BytesIO()
        np.lib.format.write_array_header_1_0(out, {"descr": "|i1", "fortran_order": False, "shape": shape})
        members[name] = out.getvalue() + bytes(int(np.prod(shape)))
    return _packed(members)


def _packed(members: dict[str, bytes]) -> bytes:
    """Return files as a compressed archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return out.getvalue()


def _element(kind: int, content: bytes) -> bytes:
    """Return an element of a MATLAB file."""
    return struct.pack("<2I", kind, len(content)) + content + bytes(-len(content) % 8)


def _matrix(kind: int, shape: tuple[int, int], name: bytes, body: bytes) -> bytes:
    """Return an array of a MATLAB file."""
    head = _element(6, struct.pack("<2I", kind, 0)) + _element(5, struct.pack("<2i", *shape)) + _element(1, name)
    return _element(14, head + body)


def of_matlab(content: bytes, chance: random.Random) -> bytes:
    """Put compressed arrays of bytes, sparse ones, long texts, cells in cells or many names into MATLAB's file."""
    size, kind = chance.choice(SIZES), chance.randrange(5)
    numbers = _element(2, bytes(size if kind != 2 else 8))
    names = [b"x", b"y"] if chance.random() < 0.7 else [b"v%d" % k for k in range(chance.choice((3, 30)))]
    parts = []
    for name in names:
        if kind == 0:
            part = _matrix(9, (size, 1), name, numbers)
        elif kind == 1:
            part = _matrix(4, (1, size), name, numbers)
        elif kind == 2:
            part = _matrix(5, (size, 1), name, _element(5, b"") + _element(5, bytes(8)) + _element(9, b""))
        elif kind == 3:
            part = _matrix(9, (size, 1), b"", numbers)
            for _ in range(chance.randint(1, 8)):
                part = _matrix(1, (1, 1), name, part)
        else:
            count = chance.choice(COUNTS)
            fields = b"".join(b"f%06d\0" % k for k in range(count))
            body = _element(5, struct.pack("<i", 8)) + _element(1, fields) + _matrix(6, (0, 0), b"", b"") * count
            part = _matrix(2, (1, 1), name, body)
        packed = zlib.compress(part, 1)
        parts.append(struct.pack("<2I", 15, len(packed)) + packed)
        if len(names) > 2 and size > 10**7:
            parts *= len(names)
            break
    return content[:128] + b"".join(parts)


def of_c3d(content: bytes, chance: random.Random) -> bytes:
    """Give a C3D file many points, and as many numbers as it then states."""
    count, frames = chance.choice((10, 1000, 30_000, 65_535)), chance.choice((1, 2, 40))
    head = bytearray(content[:512].ljust(512, b"\0"))
    struct.pack_into("<HHHH", head, 2, count, chance.choice((0, 0, 1000)), 1, frames)
    return bytes(head) + content[512:] + bytes(16 * count * frames)


ROW, CELLS = "<row{}>{}</row>", ("<c><v>1</v></c>", '<c t="inlineStr"><is><t>{}</t></is></c>', "<c/>", "<a/>")


def of_workbook(content: bytes, chance: random.Random) -> bytes:
    """Make rows of a workbook's sheet wide, many, far, or long in text or attributes."""
    members = dict(_members(content))
    name = next((name for name in members if name.endswith("sheet1.xml")), "xl/worksheets/sheet1.xml")
    count, width = chance.choice(COUNTS), chance.choice((1, 30, 16_384))
    cell = chance.choice(CELLS).format("x" * chance.choice((1, 10_000)) + chance.choice((" ", "")))
    width, room = min(width, LETTERS // len(cell)), LETTERS // len(cell) // count
    wide = chance.choice(('<c r="XFD1"><v>1</v></c>', cell * width, ""))
    about = "".join(f' a{k}=""' for k in range(chance.choice((0, 0, 10, 100_000))))
    far = f' r="{chance.choice((1_048_576, 2**40, -1, 10**400))}"' if chance.random() < 0.2 else ""
    rows = ROW.format(about, wide) + ROW.format("", cell * min(width, room)) * count + ROW.format(far, cell)
    text = members.get(name, b"").decode(errors="replace")
    members[name] = re.sub("<sheetData>.*</sheetData>", lambda _: f"<sheetData>{rows}</sheetData>", text).encode()
    return _packed(members)


COMPUTED = ("zeroblob(900000000)", "zeroblob(100000)", "printf('%.*c', 90000000, 'x')")


def of_database(content: bytes, chance: random.Random) -> bytes:
    """Let columns of a bag be computed, its tables be virtual, or its rows many."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bag.db3"
        path.write_bytes(content)
        base = sqlite3.connect(path)
        table, kind = chance.choice(("messages", "topics")), chance.randrange(3)
        own = [row[1] for row in base.execute(f"PRAGMA table_info({table})")]
        base.execute(f"ALTER TABLE {table} RENAME TO old")
        if kind == 0:
            base.execute(f"CREATE VIRTUAL TABLE {table} USING fts4({', '.join(own)})")
        else:
            computed = chance.choice(own[1:]) if kind == 1 else ""
            types = (f"{name} AS ({chance.choice(COMPUTED)})" if name == computed else name for name in own)
            base.execute(f"CREATE TABLE {table}({', '.join(types)})")
            own = [name for name in own if name != computed]
        columns = ", ".join(own)
        for _ in range(1 if kind < 2 else chance.choice((1, 200))):
            base.execute(f"INSERT INTO {table}({columns}) SELECT {columns} FROM old")
        base.commit()
        base.close()
        return path.read_bytes()


def of_hdf5(content: bytes, chance: random.Random) -> bytes:
    """Give arrays or groups of an HDF5 file many names, many attributes, or zeros that are not stored."""
    import h5py

    stream = io.BytesIO(content)
    with h5py.File(stream, "r+") as file:
        places: list[Any] = []
        file.visit(places.append)
        name, count = chance.choice(places), chance.choice((10, 300, 2500))
        kind = chance.randrange(4)
        if kind == 0:
            for k in range(count):
                file[f"l{k}"] = file[name]
        elif kind == 1:
            for k in range(min(count, 300)):
                file[name].attrs[f"a{k}"] = "x" * chance.choice((10, 60_000 // min(count, 300)))
            for k in range(count):
                file[f"l{k}"] = file[name]
        elif kind == 2 and isinstance(file[name], h5py.Dataset):
            shape = (*file[name].shape[:-1], chance.choice(SIZES))
            del file[name]
            file.create_dataset(name, shape, chance.choice(("i1", "f8")), chunks=True)
        else:
            for k in range(chance.choice((2, 30, 600))):
                file[f"s{k}/data"], file[f"s{k}/ir"], file[f"s{k}/jc"] = [1.0], [0], [0, 1]
                file[f"s{k}"].attrs.update({"MATLAB_sparse": chance.choice(SIZES), "MATLAB_class": np.bytes_("double")})
    return stream.getvalue()


def of_table(content: bytes, chance: random.Random) -> bytes:
    """Give a table many columns: of one name, of names near a known one, or of all names again."""
    lines = content.decode(errors="replace").splitlines()
    k = next((k for k, line in enumerate(lines) if "," in line and not line.startswith("#")), 0)
    mark = max(",;\t", key=lines[k].count) if lines else ","
    head = lines[k].split(mark) if lines else [""]
    name, count = chance.choice(head), chance.choice(COUNTS)
    kind = chance.randrange(4)
    new = [
        name if kind == 0 else f"{name}{j}" if kind == 1 else f"{j:x}" if kind == 2 else f"{j}{name}"
        for j in range(count)
    ]
    if kind == 3 and chance.random() < 0.5:
        new = head * max(count // max(len(head), 1), 1)
    value = chance.choice(("1", "", "0"))
    extended = [
        line + mark + mark.join(new if j == k else [value] * len(new))
        for j, line in enumerate(lines[: k + 4])
        if j >= k
    ]
    return "\n".join([*lines[:k], *extended]).encode()


def of_toml(content: bytes, chance: random.Random) -> bytes:
    """Give a table of TOML many keys near a known one, long texts, or the same table many times in a list."""
    lines = content.decode(errors="replace").splitlines()
    keys = [k for k, line in enumerate(lines) if re.match(r"\w+ *=", line)] or [0]
    k, count, kind = chance.choice(keys), chance.choice((300, 5000, 60_000)), chance.randrange(4)
    key = lines[k].split("=")[0].strip() if lines else "a"
    if kind == 0:
        lines[k:k] = [f"{key}{j} = {j}" for j in range(count)]
    elif kind == 1:
        lines[k:k] = [f'"{key}{chr(0x4E00 + j % 20_000)}{j}" = "x"' for j in range(min(count, 30_000))]
    elif kind == 2 and lines:
        lines[k] = f"{key} = [{', '.join(['0.1'] * count)}]"
    elif lines:
        lines[k] = f'{key} = "{"x" * chance.choice((1000, 100_000, 900_000))}"'
    return "\n".join(lines).encode()
