"""The program that reads an HDF5 file in a process of its own, within limits of time and memory.

It is started by `hypertuna.io.hdf5` and imports nothing of the package: the file is its input, its output a line of
JSON (names, types, shapes, attributes) followed by the numbers. Only what lies in the file itself is read: no links
to other files, no stored programs, no references.
"""

import json
import resource
import sys
from typing import Any

SECONDS, MEMORY = 40, 1 << 30  # limits: s of processor time; bytes of address space
# Limits: nested groups; groups and arrays; attributes; texts of an array; letters of all texts and of attributes.
DEPTH, OBJECTS, ATTRIBUTES, TEXTS, LETTERS = 8, 2000, 20_000, 20_000, 4_000_000
LARGEST, MOST = 12_000_000, 24_000_000  # numbers of an array and of all: an hour of 12 markers at 60 Hz has 8 million


def attributes(item: Any, counts: dict[str, int]) -> dict[str, Any]:
    """Return the attributes that are texts or single numbers, up to the limits: a group can have many names."""
    values = {}
    for name in list(item.attrs)[:200]:
        counts["attributes"] += 1
        if counts["attributes"] > ATTRIBUTES or counts["about"] > LETTERS:
            break
        try:
            value = item.attrs[name]
        except Exception:  # an attribute of a type that h5py does not know
            continue
        value = value.item() if getattr(value, "size", 0) == 1 and hasattr(value, "item") else value
        value = value.decode("latin-1") if isinstance(value, bytes) else value
        if isinstance(value, (str, int, float)) and (length := len(str(value))) <= LETTERS:
            values[name] = value
            counts["about"] += length + len(name)
    return values


def texts(array: Any) -> list[str]:
    """Return the texts of an array."""
    flat = array.ravel().tolist()
    return [cell.decode("utf-8", "replace") if isinstance(cell, bytes) else str(cell) for cell in flat]


def main() -> None:
    """Read the HDF5 file at the standard input, and write its content to the standard output."""
    for limit, value in ((resource.RLIMIT_CPU, SECONDS), (resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CORE, 0)):
        hard = resource.getrlimit(limit)[1]
        resource.setrlimit(limit, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))
    import h5py
    import numpy as np

    entries: list[dict[str, Any]] = []
    contents: list[bytes] = []
    left_out: list[str] = []
    counts = dict.fromkeys(("objects", "numbers", "letters", "attributes", "about"), 0)

    def keep(name: str, array: Any) -> None:
        ordered = np.ascontiguousarray(array.astype(array.dtype.newbyteorder("<")))
        entries.append({"name": name, "type": ordered.dtype.str, "shape": ordered.shape})
        contents.append(ordered.tobytes())

    def read(name: str, data: Any) -> None:
        if data.is_virtual or data.external or data.shape is None:
            return
        kind, size = data.dtype.kind, int(np.prod(data.shape, dtype=float))
        width = sum(int(np.prod(data.dtype[n].shape, dtype=float)) for n in data.dtype.names or ()) or 1
        if kind in "SO":
            letters = size * (data.dtype.itemsize if kind == "S" else 16)
            counts["letters"] += letters
            if (kind == "S" or h5py.check_string_dtype(data.dtype)) and size <= TEXTS and counts["letters"] < LETTERS:
                entries.append({"name": name, "texts": texts(data[()])})
            return
        if kind not in "biufV" or (kind == "V" and not data.dtype.names):
            return
        counts["numbers"] += size * width
        if size * width > LARGEST or counts["numbers"] > MOST:
            counts["numbers"] -= size * width
            left_out.append(name)
        elif kind == "V":
            for field in data.dtype.names:
                if data.dtype[field].base.kind in "biuf":
                    keep(f"{name}/{field}", data[field])
        else:
            keep(name, data[()])

    def walk(group: Any, place: str, depth: int) -> None:
        for key in group:
            counts["objects"] += 1
            if counts["objects"] > OBJECTS:
                left_out.append("...")
                return
            if not isinstance(group.get(key, getlink=True), h5py.HardLink) or key.startswith(("_i_", "#")):
                continue
            item, name = group[key], f"{place}{key}"
            entries.append({"name": name, "attributes": attributes(item, counts)})
            if isinstance(item, h5py.Group) and depth < DEPTH:
                walk(item, f"{name}/", depth + 1)
            elif isinstance(item, h5py.Dataset):
                read(name, item)

    with open(0, "rb") as stream, h5py.File(stream, "r") as file:
        walk(file, "", 0)
    sys.stdout.buffer.write(json.dumps({"entries": entries, "left_out": left_out}).encode() + b"\n")
    for content in contents:
        sys.stdout.buffer.write(content)


if __name__ == "__main__":
    main()
